//! EXR files: what is saved comes back bit for bit, and no file does harm.

use std::fs;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use glam::{DMat4, DVec3, Vec3};
use mislab_renderer::pbrt::embedded_scene;
use mislab_renderer::snapshot::{Contents, SaveOptions, info, layers_of, load_image, restore, save, shown};
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
fn files_of_other_programs_load_and_say_that_they_are_foreign() {
    use exr::prelude::*;
    let folder = folder();
    let path = folder.path().join("foreign.exr");
    let list = [
        AnyChannel::new("A", FlatSamples::F16((0..35).map(|i| f16::from_f32(i as f32 * 0.5)).collect())),
        AnyChannel::new("albedo.R", FlatSamples::F32((0..35).map(|i| i as f32).collect())),
        AnyChannel::new("id", FlatSamples::U32((0..35).collect())),
    ];
    let encoding = Encoding { blocks: Blocks::Tiles(Vec2(4, 3)), ..Encoding::SMALL_FAST_LOSSLESS };
    let attributes = LayerAttributes { layer_position: Vec2(-3, 4), ..LayerAttributes::default() };
    let layer = Layer::new((7, 5), attributes, encoding, AnyChannels::sort(list.into_iter().collect()));
    Image::from_layer(layer).write().to_file(&path).expect("writes");

    let image = load_image(&path).expect("loads");
    assert_eq!((image.window.min, image.window.size), ([-3, 4], [7, 5]));
    assert_eq!(image.channel("A").expect("half")[3], 1.5);
    assert_eq!(image.channel("albedo.R").expect("float")[34], 34.0);
    assert_eq!(image.channel("id").expect("uint")[33], 33.0);
    let error = restore(&path).expect_err("foreign").to_string();
    assert!(error.contains("foreign.exr") && error.contains("was not written by MIS Lab"), "{error}");
    let info = info(&path).expect("reads");
    assert!(matches!(info.restored, Ok(None)), "foreign, not damaged");
    let [part] = info.parts.as_slice() else { panic!("one part") };
    assert_eq!((part.window.min, part.window.size, part.deep), ([-3, 4], [7, 5], false));
    assert_eq!(part.display.size, [7, 5]);
    let channels: Vec<_> = part.channels.iter().map(|c| (c.name.as_str(), c.kind, c.sampling)).collect();
    assert_eq!(channels, [("A", "HALF", [1, 1]), ("albedo.R", "FLOAT", [1, 1]), ("id", "UINT", [1, 1])]);
    assert!(part.attributes.iter().any(|(n, _)| n == "compression"));
}

#[test]
fn files_of_several_parts_say_what_they_hold() {
    use exr::prelude::*;
    let folder = folder();
    let path = folder.path().join("parts.exr");
    let part = |name: &str, channel: &str, size: usize| {
        let values = FlatSamples::F32((0..size * size).map(|i| i as f32).collect());
        let channels = AnyChannels::sort([AnyChannel::new(channel, values)].into_iter().collect());
        Layer::new((size, size), LayerAttributes::named(name), Encoding::UNCOMPRESSED, channels)
    };
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((8, 8)));
    let parts = [part("beauty", "R", 8), part("depth", "Z", 4)];
    Image::from_layers(attributes, parts.into_iter().collect::<Vec<_>>()).write().to_file(&path).expect("writes");
    let info = info(&path).expect("reads");
    assert!(matches!(info.restored, Ok(None)));
    let said: Vec<_> =
        info.parts.iter().map(|p| (p.name.as_deref(), p.window.size, p.channels[0].name.as_str())).collect();
    assert_eq!(said, [(Some("beauty"), [8, 8], "R"), (Some("depth"), [4, 4], "Z")]);
    // The first is shown.
    let image = load_image(&path).expect("the first part");
    assert_eq!((image.window.size, image.channels.len()), ([8, 8], 1));
    assert_eq!(image.channel("R").map(|values| values[63]), Some(63.0));
    let error = restore(&path).expect_err("another program's").to_string();
    assert!(error.contains("not written by MIS Lab"), "{error}");
}

#[test]
fn files_that_end_early_are_said_to() {
    let folder = folder();
    let path = folder.path().join("empty.exr");
    std::fs::write(&path, "").expect("writes");
    let reads: [fn(&std::path::Path) -> Option<mislab_renderer::Error>; 3] =
        [|path| load_image(path).err(), |path| restore(path).err(), |path| info(path).err()];
    for read in reads {
        let error = read(&path).expect("an error").to_string();
        assert!(error.contains("empty.exr: the file is empty"), "{error}");
    }
    // The magic number, the version, and the first letters of an attribute.
    std::fs::write(&path, b"\x76\x2f\x31\x01\x02\0\0\0chan").expect("writes");
    for read in reads {
        let error = read(&path).expect("an error").to_string();
        assert!(error.contains("ends early"), "{error}");
    }
}

/// The header of a file whose pixels hold many samples each, which no library of ours decodes.
#[test]
fn files_of_deep_pixels_say_what_they_hold() {
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0b1000, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        for text in [name, kind] {
            bytes.extend(text.as_bytes());
            bytes.push(0);
        }
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    };
    let numbers = |list: &[i32]| list.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let channel = |name: &str| [name.as_bytes(), &[0], &numbers(&[2, 0, 1, 1])].concat();
    attribute("channels", "chlist", &[channel("A"), channel("Z"), vec![0]].concat());
    attribute("chunkCount", "int", &numbers(&[3]));
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &numbers(&[-1, 0, 4, 2]));
    attribute("displayWindow", "box2i", &numbers(&[0, 0, 9, 9]));
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("maxSamplesPerPixel", "int", &numbers(&[7]));
    attribute("name", "string", b"smoke");
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    attribute("type", "string", b"deepscanline");
    attribute("version", "int", &numbers(&[1]));
    bytes.extend([0; 64]);
    let folder = folder();
    let path = write(&folder, "deep.exr", &bytes);
    let info = info(&path).expect("reads");
    let part = &info.parts[0];
    assert_eq!((part.name.as_deref(), part.deep, part.window.size), (Some("smoke"), true, [6, 3]));
    assert_eq!(part.channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["A", "Z"]);
    let error = load_image(&path).expect_err("deep").to_string();
    assert!(error.contains("deep"), "{error}");
}

/// A pipe has no end that a reader could wait for.
#[test]
#[cfg(unix)]
fn a_pipe_is_refused_and_not_waited_for() {
    let folder = folder();
    let path = folder.path().join("pipe.exr");
    let made = Command::new("mkfifo").arg(&path).status().expect("mkfifo is there");
    assert!(made.success());
    let errors = [
        load_image(&path).map(drop).expect_err("a pipe"),
        info(&path).map(drop).expect_err("a pipe"),
        restore(&path).map(drop).expect_err("a pipe"),
        mislab_renderer::pbrt::load(&path).map(drop).expect_err("a pipe"),
    ];
    for error in errors.map(|e| e.to_string()) {
        assert!(error.contains("pipe.exr: not a regular file, expected "), "{error}");
    }
}

#[test]
fn layers_are_a_matter_of_names() {
    let layers = layers_of(["B", "G", "R", ".A", "a.b.Y", "light.B", "light.R"]);
    let found: Vec<_> = layers.iter().map(|l| (l.name.as_str(), l.channels.as_slice())).collect();
    assert_eq!(found, [("RGB", &[0, 1, 2, 3][..]), ("a.b", &[4]), ("light", &[5, 6])]);
    assert_eq!(shown("two\nlines \u{1b}[31m"), "two\\nlines \\u{1b}[31m");
    assert_eq!(shown(&"x".repeat(401)), "(401 bytes)");
}

#[test]
fn files_that_are_none_say_what_was_expected() {
    let folder = folder();
    for (name, bytes) in
        [("empty.exr", &b""[..]), ("text.exr", b"not an image"), ("magic.exr", &[0x76, 0x2f, 0x31, 0x01])]
    {
        let error = load_image(&write(&folder, name, bytes)).expect_err(name).to_string();
        assert!(error.contains(name) && error.contains("EXR"), "{error}");
    }
    let error = load_image(folder.path()).expect_err("a folder").to_string();
    assert!(error.contains("a folder"), "{error}");
    let error = load_image(&folder.path().join("absent.exr")).expect_err("absent").to_string();
    assert!(error.contains("cannot read"), "{error}");
}

/// Replaces text in an encoded file by text of the same length.
fn patched(from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len(), "patches keep every offset");
    let mut bytes = encoded();
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes());
    let at = at.unwrap_or_else(|| panic!("{from} is not in the file"));
    bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
    bytes
}

#[test]
fn edited_settings_and_scenes_are_checked() {
    let folder = folder();
    for (from, to, word) in [
        ("\"light_prob\":0.1", "\"light_prob\":9.1", "mislabSettings: light probability 9.1"),
        ("\"light_prob\":0.1", "\"light_prob\":NaN", "mislabSettings"),
        ("\"strategy\":\"mis\"", "\"strategy\":\"mix\"", "mix"),
        ("\"strata\":[6,7]", "\"strata\":[0,7]", "0 x 7 strata"),
        ("\"spp\":4096", "\"spp\":0000", "mislabSettings"),
        ("\"resolution\":[20,37]", "\"resolution\":[20,0.]", "mislabSettings"),
        ("\"crop\":[0.125,0.7", "\"crop\":[0.825,0.7", "crop window"),
        ("\"heuristic\"", "\"heuristik\"", "mislabSettings"),
        ("\"seed\":4294967295", "\"seed\":42,\"new\":1", "unknown setting `new`"),
        ("\"alpha\":0.02", "\"alpha\":2.02", "plate2"),
        ("\"material\":2", "\"material\":9", "material"),
        ("\"triangles\":[[0,1,2]]", "\"triangles\":[[0,1,3]]", "vertex 3"),
        ("\"radius\":0.03333", "\"radius\":-0.0333", "shape 0"),
        ("\"fov_deg\":41.0", "\"fov_deg\":-1.0", "field of view"),
        ("\"name\":\"floor\"", "\"name\":\"fl\\ur\"", "mislabScene"),
    ] {
        let path = write(&folder, "edited.exr", &patched(from, to));
        let error = restore(&path).expect_err(to).to_string();
        assert!(error.contains(word), "{to}: {error}");
        assert!(load_image(&path).is_ok(), "{to}: the pixels are still good");
    }
    let error = restore(&write(&folder, "newer.exr", &newer())).expect_err("newer").to_string();
    assert!(error.contains("newer MIS Lab"), "{error}");
}

/// A file that claims to be of a later format.
fn newer() -> Vec<u8> {
    let mut bytes = encoded();
    let name = b"mislabFormat\0int\0\x04\0\0\0";
    let at = bytes.windows(name.len()).position(|w| w == name).expect("the attribute is there") + name.len();
    bytes[at] = 200;
    bytes
}

#[test]
fn a_header_that_claims_too_much_is_refused_before_memory_is_asked_for() {
    let folder = folder();
    for (width, height, word) in
        [(1_000_000_i32, 1_000_000_i32, "at most"), (8, 1_000_000, "cut off"), (1 << 29, 1 << 29, "at most")]
    {
        let mut bytes = encoded();
        let name = b"dataWindow\0box2i\0\x10\0\0\0";
        let at = bytes.windows(name.len()).position(|w| w == name).expect("the attribute is there") + name.len();
        let window = [0, 0, width - 1, height - 1].map(i32::to_le_bytes).concat();
        bytes[at..at + 16].copy_from_slice(&window);
        let error = load_image(&write(&folder, "huge.exr", &bytes)).expect_err("huge").to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let folder = folder();
    let small = Contents {
        bounds: PixelRect { min: [3, 13], max: [6, 16] },
        layers: ["B", "G", "R", "w_light.Y"].map(|n| (n.to_owned(), (0..9).map(|i| i as f32).collect())).into(),
        ..contents()
    };
    let good = small.encode(&options()).expect("encodes").0;
    let read = |bytes: &[u8]| {
        let path = write(&folder, "mutant.exr", bytes);
        let _ = (load_image(&path), info(&path), restore(&path));
    };
    for length in (0..good.len()).step_by(7) {
        let path = write(&folder, "short.exr", &good[..length]);
        assert!(load_image(&path).is_err(), "cut off after {length} of {} bytes", good.len());
        read(&good[..length]);
    }
    // xorshift32, fixed seed
    let mut state = 0x9e37_79b9_u32;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as usize
    };
    for _ in 0..3000 {
        let mut mutant = good.clone();
        for _ in 0..1 + random() % 3 {
            let at = random() % mutant.len();
            match random() % 4 {
                0 => mutant[at] ^= 1 << (random() % 8),
                1 => mutant[at] = 0xff,
                2 => mutant[at] = random() as u8,
                _ => {
                    let end = (at + 4).min(mutant.len());
                    let word = [0_u32, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fff0][random() % 5];
                    mutant[at..end].copy_from_slice(&word.to_le_bytes()[..end - at]);
                }
            }
        }
        read(&mutant);
    }
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
