//! Files of other programs, damaged ones, and what is no file at all.

#[cfg(unix)]
use std::process::Command;

use mislab_renderer::PixelRect;
use mislab_renderer::snapshot::{Contents, info, layers_of, load_image, restore, shown};

use crate::{contents, encoded, folder, options, write};

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
