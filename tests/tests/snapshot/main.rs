//! EXR files: what is saved comes back bit for bit, and no file does harm.

mod strange;

use std::fs;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use glam::{DMat4, DVec3, Vec3};
use mislab_renderer::pbrt::embedded_scene;
use mislab_renderer::snapshot::{Contents, SaveOptions, info, load_image, restore, save};
use mislab_renderer::{
    Bsdf, Camera, Channel, Estimator, FrameStats, Geometry, Heuristic, ImageSettings, Light, Material,
    OneSampleWeights, PixelRect, Reflectance, Request, SamplerKind, SamplerSettings, Sampling, Scene, Settings, Shape,
    Strategy, render,
};

/// A scene with one of everything and numbers that decimal text easily spoils.
fn scene() -> Scene {
    let light =
        Light { name: "light1".into(), radiance: Vec3::new(901.803, 1.0 / 3.0, f32::MIN_POSITIVE / 8.0), on: false };
    Scene {
        name: "ball & plate \"é\"".into(),
        camera: Camera {
            world_from_camera: DMat4::from_translation(DVec3::new(0.1, 2.0, 15.0)) * DMat4::from_rotation_x(0.3),
            fov_deg: 41.010_800_000_000_01,
            screen_window: Some([-1.0, 1.0, -0.75, 0.1 + 0.2]),
        },
        materials: vec![
            Material { name: "floor".into(), bsdf: Bsdf::Matte { kd: Vec3::new(0.4, 0.1, -0.0) } },
            Material {
                name: "plate1".into(),
                bsdf: Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha: 0.0 },
            },
            Material {
                name: "plate2".into(),
                bsdf: Bsdf::Conductor {
                    reflectance: Reflectance::Fresnel { eta: Vec3::splat(0.2), k: Vec3::splat(3.9) },
                    alpha: 0.02,
                },
            },
            Material {
                name: "coat".into(),
                bsdf: Bsdf::Plastic {
                    kd: Vec3::new(0.07, 0.09, 0.13),
                    ks: Vec3::ONE,
                    alpha: 0.1,
                    swapped_indices: false,
                },
            },
        ],
        shapes: vec![
            Shape {
                geometry: Geometry::Sphere { center: Vec3::new(-3.75, 0.0, 0.0), radius: 0.03333 },
                reverse_orientation: false,
                material: None,
                light: Some(light),
            },
            Shape {
                geometry: Geometry::Mesh {
                    positions: Arc::new(vec![Vec3::ZERO, Vec3::X * 0.1, Vec3::Y * 1e9]),
                    triangles: Arc::new(vec![[0, 1, 2]]),
                },
                reverse_orientation: true,
                material: Some(2),
                light: None,
            },
        ],
    }
}

/// A cropped picture with every channel and with values of every kind.
fn contents() -> Contents {
    let settings = Settings {
        estimator: Estimator {
            strategy: Strategy::Mis,
            light_prob: 0.1,
            heuristic: Heuristic::Cutoff,
            weights: OneSampleWeights::Tutorial,
        },
        sampling: Sampling {
            sampler: SamplerSettings { kind: SamplerKind::Stratified, strata: [6, 7], jitter: false },
            spp: NonZeroU32::new(4096),
            seed: u32::MAX,
        },
        image: ImageSettings { resolution: [20, 37], crop: [0.125, 0.7, 1.0 / 3.0, 1.0] },
    };
    let bounds = settings.pixel_bounds();
    let values = |channel: usize| -> Vec<f32> {
        (0..bounds.area())
            .map(|i| match (i + channel) % 9 {
                0 => f32::NAN,
                1 => f32::from_bits(0x7fc0_1234),
                2 => f32::INFINITY,
                3 => -0.0,
                4 => f32::from_bits(1),
                5 => f32::MAX,
                _ => (i * 13 + channel) as f32 * 0.1,
            })
            .collect()
    };
    Contents {
        layers: Channel::ALL.iter().enumerate().map(|(i, c)| (c.exr_name().to_owned(), values(i))).collect(),
        request: Arc::new(Request { scene: Arc::new(scene()), settings }),
        bounds,
        spp: 100,
        stats: FrameStats {
            paths: u64::MAX,
            render_seconds: 1.25,
            cpu_seconds: 2.5,
            threads: 2,
            simd: "AVX2",
            invalid_samples: 3,
        },
    }
}

fn options() -> SaveOptions {
    SaveOptions {
        comments: "para a aula — π".into(),
        view: Some("{\"exposure\":0.5}".into()),
        attributes: vec![("course".into(), "Computação Gráfica".into())],
        // 29 February 2024, 23:59:59 UTC
        date: Some(UNIX_EPOCH + Duration::from_secs(1_709_251_199)),
        ..SaveOptions::default()
    }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn write(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    // Some file systems flush to the disk when a file is overwritten, but not when it is new.
    let _ = fs::remove_file(&path);
    fs::write(&path, bytes).expect("a file in the temporary folder");
    path
}

fn encoded() -> Vec<u8> {
    contents().encode(&options()).expect("encodes").0
}

#[test]
fn pixels_come_back_bit_for_bit_at_their_place() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let saved = contents().save(&path, &options()).expect("saves");
    assert_eq!(saved.notice, None);
    assert_eq!(saved.bytes, fs::metadata(&path).expect("is there").len());
    let image = load_image(&path).expect("loads");
    assert_eq!((image.window.min, image.window.size), ([3, 13], [11, 24]), "data window: the crop window");
    assert_eq!((image.display.min, image.display.size), ([0, 0], [20, 37]), "display window: the full image");
    assert_eq!(image.channels.len(), Channel::ALL.len());
    assert!(image.channels.is_sorted_by_key(|c| &c.0), "channels are sorted");
    for (name, expected) in &contents().layers {
        let found = image.channel(name).unwrap_or_else(|| panic!("channel {name} is missing"));
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(found), bits(expected), "channel {name}");
    }
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 1, "no temporary file stays behind");
}

#[test]
fn the_file_alone_restores_every_setting_and_the_scene() {
    let folder = folder();
    let path = write(&folder, "a.exr", &encoded());
    let restored = restore(&path).expect("restores");
    let original = contents().request;
    assert_eq!(restored.request, *original);
    // PartialEq cannot tell -0 from 0; the shortest decimal text of every number can.
    let json = |r: &Request| (serde_json::to_string(&*r.scene).unwrap(), serde_json::to_string(&r.settings).unwrap());
    assert_eq!(json(&restored.request), json(&original));
    assert_eq!(restored.spp, 100);
    assert_eq!(
        restored.picture_request().settings.sampling.spp,
        NonZeroU32::new(100),
        "the passes of the file, not the target"
    );
    assert_eq!(restored.view.as_deref(), Some("{\"exposure\":0.5}"));
    assert!(restored.software.starts_with("MIS Lab "), "{}", restored.software);
}

#[test]
fn attributes_are_readable_without_this_program() {
    let folder = folder();
    let info = info(&write(&folder, "a.exr", &encoded())).expect("reads");
    let get = |name: &str| {
        let found = info.parts[0].attributes.iter().find(|(n, _)| n == name);
        found.unwrap_or_else(|| panic!("attribute {name} is missing")).1.as_str()
    };
    for (name, value) in [
        ("strategy", "mis"),
        ("lightProb", "0.1"),
        ("heuristic", "cutoff"),
        ("weights", "tutorial"),
        ("sampler", "stratified"),
        ("strata", "6 7"),
        ("jitter", "0"),
        ("seed", "4294967295"),
        ("samplesPerPixel", "100"),
        ("renderTimeSeconds", "1.25"),
        ("cpuTimeSeconds", "2.5"),
        ("paths", "18446744073709551615"),
        ("threads", "2"),
        ("simd", "AVX2"),
        ("invalidSamples", "3"),
        ("capDate", "2024:02:29 23:59:59"),
        ("utcOffset", "0"),
        ("comments", "para a aula — π"),
        ("course", "Computação Gráfica"),
        ("sceneName", "ball & plate \"é\""),
        ("chromaticities", "red (0.64 0.33) green (0.3 0.6) blue (0.15 0.06) white (0.3127 0.329)"),
        ("compression", "ZIP16"),
        ("dataWindow", "11 x 24 at (3 13)"),
        ("displayWindow", "20 x 37 at (0 0)"),
    ] {
        assert_eq!(get(name), value, "attribute {name}");
    }
    assert!(info.parts[0].attributes.iter().all(|(name, _)| name.len() <= 31), "OpenEXR's limit of attribute names");
    assert!(info.restored.is_ok_and(|restored| restored.is_some()));
}

#[test]
fn the_same_picture_gives_the_same_bytes() {
    let first = encoded();
    for _ in 0..4 {
        assert!(encoded() == first, "the bytes differ from save to save");
    }
}

#[test]
fn openexr_tools_read_it_without_a_warning() {
    let folder = folder();
    let path = write(&folder, "a.exr", &encoded());
    for (tool, arguments) in [("exrheader", &[][..]), ("exrinfo", &["-v", "-s"][..])] {
        let output = match Command::new(tool).args(arguments).arg(&path).output() {
            Ok(output) => output,
            Err(_) if std::env::var_os("CI").is_none() => {
                eprintln!("skipped: {tool} of OpenEXR is not installed");
                continue;
            }
            Err(e) => panic!("{tool} of OpenEXR is needed where CI is set: {e}"),
        };
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        // Not of exrinfo: OpenEXR 3.1 never sets its exit status. It complains all the same.
        assert!(tool == "exrinfo" || output.status.success(), "{tool}: {err}");
        assert_eq!(err, "", "{tool} has something to say");
        for word in ["w_light.Y", "variance.Y", "samplesPerPixel"] {
            assert!(out.contains(word), "{tool} does not list {word}:\n{out}");
        }
        assert!(!out.to_lowercase().contains("warn"), "{tool} warns:\n{out}");
    }
}

#[test]
fn a_scene_too_large_is_left_out_and_the_file_says_so() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let saved =
        contents().save(&path, &SaveOptions { max_scene_bytes: 100, ..options() }).expect("the picture is saved");
    assert!(saved.notice.expect("a notice").contains("more than the 100"));
    assert_eq!(load_image(&path).expect("loads").channels.len(), 13);
    let error = restore(&path).expect_err("there is no scene").to_string();
    assert!(error.contains("holds no scene") && error.contains("more than the 100"), "{error}");
}

#[test]
fn unusable_attributes_are_refused() {
    for name in ["", "a name", "strategy", "mislabScene", "dataWindow", "123", "é", &"x".repeat(32)] {
        let options = SaveOptions { attributes: vec![(name.to_owned(), "x".into())], ..options() };
        let error = contents().encode(&options).expect_err(name).to_string();
        assert!(error.contains(&format!("`{name}`")), "{error}");
    }
    let twice = vec![("a".to_owned(), "x".to_owned()), ("a".to_owned(), "y".to_owned())];
    assert!(contents().encode(&SaveOptions { attributes: twice, ..options() }).is_err());
    let error = contents().encode(&SaveOptions { comments: "a\0b".into(), ..options() }).expect_err("NUL").to_string();
    assert!(error.contains("comments"), "{error}");
}

#[test]
fn a_failed_save_leaves_the_old_file_alone() {
    let folder = folder();
    let path = write(&folder, "a.exr", b"precious");
    let mut broken = contents();
    broken.layers[3].1.pop();
    assert!(broken.save(&path, &options()).is_err());
    let outside = Contents { bounds: PixelRect { min: [0, 0], max: [21, 2] }, ..contents() };
    assert!(outside.save(&path, &options()).is_err());
    assert_eq!(fs::read(&path).expect("still there"), b"precious");

    let error = contents().save(&folder.path().join("no/such/folder/a.exr"), &options()).expect_err("no folder");
    assert!(error.to_string().contains("cannot save"), "{error}");
    let taken = folder.path().join("taken");
    fs::create_dir_all(taken.join("full")).expect("a folder");
    assert!(contents().save(&taken, &options()).is_err(), "a folder is in the way");
    assert_eq!(fs::read_dir(folder.path()).expect("lists").count(), 2, "no temporary file stays behind");
}

#[test]
#[cfg(unix)]
fn saving_replaces_files_but_neither_links_nor_devices() {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    let folder = folder();
    let path = write(&folder, "a.exr", b"old");
    let link = folder.path().join("link.exr");
    symlink(&path, &link).expect("links");
    contents().save(&link, &options()).expect("saves through the link");
    assert!(fs::symlink_metadata(&link).expect("is there").is_symlink(), "the link is still one");
    assert!(fs::read(&path).expect("reads") == encoded(), "its target was replaced");
    let ordinary = fs::metadata(write(&folder, "ordinary", b"")).expect("is there").permissions().mode();
    assert_eq!(fs::metadata(&path).expect("is there").permissions().mode(), ordinary, "rights of an ordinary file");

    contents().save(Path::new("/dev/null"), &options()).expect("a device takes the bytes");
    assert!(fs::metadata("/dev/null").expect("is there").file_type().is_char_device(), "and is still a device");
}

#[test]
fn a_saved_frame_is_restored_and_renders_the_same_bits_again() {
    let folder = folder();
    let path = folder.path().join("veachMIS_MIS.exr");
    let mut scene = embedded_scene().scene;
    *scene.material_mut("plate3").expect("a plate").bsdf.alpha_mut().expect("is glossy") = 0.123_456_79;
    let settings = Settings {
        estimator: Estimator { strategy: Strategy::Mis, light_prob: 0.3, ..Estimator::default() },
        sampling: Sampling { spp: NonZeroU32::new(5), seed: 99, ..Sampling::default() },
        image: ImageSettings { resolution: [40, 30], crop: [0.25, 0.9, 0.1, 1.0] },
    };
    let frame = render(&Request { scene: Arc::new(scene), settings }, 1, &mut |_| true).expect("renders");
    save(&frame, &path, &options()).expect("saves");

    let restored = restore(&path).expect("restores");
    assert_eq!(restored.request, **frame.request());
    let again = render(&restored.picture_request(), 2, &mut |_| true).expect("renders again");
    let image = load_image(&path).expect("loads");
    assert_eq!(image.channels.len(), Channel::ALL.len());
    for channel in Channel::ALL {
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let name = channel.exr_name();
        let saved = image.channel(name).unwrap_or_else(|| panic!("channel {name} is missing"));
        assert_eq!(bits(saved), bits(&frame.channel(channel)), "channel {name} of the file");
        assert_eq!(bits(saved), bits(&again.channel(channel)), "channel {name} rendered again");
    }
}
