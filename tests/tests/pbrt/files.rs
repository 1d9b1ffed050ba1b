//! Files: the scene itself, `Include` and PLY meshes.

use std::fs;
use std::path::Path;

use glam::Vec3;
use mislab_renderer::{Error, pbrt};

use crate::{assert_failure, assert_left_out, assert_no_warnings, mesh, sphere, world};

pub fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> std::path::PathBuf {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
    fs::write(&path, content).expect("a file can be written");
    path
}

#[test]
fn load_names_what_is_wrong_with_a_file() {
    let dir = tempfile::tempdir().expect("a folder");
    let missing = dir.path().join("missing.pbrt");
    let error = pbrt::load(&missing).expect_err("a missing file");
    assert!(matches!(error, Error::Io { .. }));
    let folder = dir.path().display();
    assert!(error.to_string().contains(&format!("no such file in {folder}")), "{error}");
    assert!(pbrt::load(dir.path()).expect_err("a folder").to_string().contains("a folder, expected a file"));
    let binary = write(dir.path(), "picture.exr", b"v/1\x01\x02\0\0\0");
    assert!(pbrt::load(&binary).expect_err("binary").to_string().contains("picture.exr: binary data"));
    let scene = write(dir.path(), "my scene.pbrt", pbrt::DEFAULT_SCENE);
    let file = pbrt::load(&scene).expect("a scene");
    assert_eq!((file.scene.name.as_str(), file.source), ("my scene", scene.display().to_string()));
    // Windows editors.
    let mut utf16: Vec<u8> = vec![0xff, 0xfe];
    utf16.extend(pbrt::DEFAULT_SCENE.encode_utf16().flat_map(u16::to_le_bytes));
    let scene = write(dir.path(), "utf16.pbrt", utf16);
    assert_eq!(pbrt::load(&scene).expect("a scene").scene.shapes.len(), 10);
    let scene = write(dir.path(), "latin1.pbrt", b"# Licht gr\xfcn\nCamera \"perspective\"\nWorldBegin WorldEnd");
    assert!(pbrt::load(&scene).is_ok());
}

#[test]
fn include_is_relative_and_keeps_places() {
    let dir = tempfile::tempdir().expect("a folder");
    let root = dir.path();
    let main = write(
        root,
        "main.pbrt",
        "Camera \"perspective\"\nWorldBegin\nInclude \"parts/a.pbrt\"\nShape \"sphere\"\nWorldEnd",
    );
    write(root, "parts/a.pbrt", "Material \"mirror\"\nInclude \"b.pbrt\"\nInclude \"shared.pbrt\"");
    write(root, "parts/b.pbrt", "Shape \"sphere\"\n Oops 3");
    write(root, "shared.pbrt", "Shape \"sphere\" \"float radius\" 5");
    let file = pbrt::load(&main).expect("a scene");
    assert_eq!(file.scene.shapes.len(), 3);
    assert_eq!(file.scene.materials.len(), 1, "the material of the included file holds on");
    assert_eq!(sphere(&file.scene.shapes[1]).1, 5.0, "found beside the main file, as pbrt does");
    let place = &file.warnings[0].location;
    assert!(place.file.ends_with("b.pbrt") && (place.line, place.column) == (2, 2), "{place}");
    // The same text with a folder given.
    let text = fs::read_to_string(&main).expect("text");
    assert_eq!(pbrt::parse(&text, "x", Some(root)).expect("a scene").scene.shapes.len(), 3);
    assert_left_out(&text, 3, 1, &["parts/a.pbrt", "no folder"]);

    let message = |content: &str| {
        let main =
            write(root, "bad.pbrt", format!("Camera \"perspective\" WorldBegin {content} Shape \"sphere\" WorldEnd"));
        let file = pbrt::load(&main).unwrap_or_else(|e| panic!("{content}: {e}"));
        assert!(!file.scene.shapes.is_empty(), "{content}: the rest is there");
        assert!(file.warnings.iter().all(|w| w.message.contains("left out")), "{:?}", file.warnings);
        file.warnings.first().map_or_else(String::new, ToString::to_string)
    };
    write(root, "loop.pbrt", "\nInclude \"bad.pbrt\"");
    assert!(message("Include \"loop.pbrt\"").contains("loop.pbrt:2:1: Include of"));
    assert!(message("Include \"bad.pbrt\"").contains("bad.pbrt:1:33: Include of"));
    assert!(message("Include \"none.pbrt\"").contains("bad.pbrt:1:33: Include: cannot read"));
    assert_failure("Include none", 1, 9, &["none"]);
    assert!(message("Include \"parts\"").contains("a folder"));
    // Twice, but not inside itself, is fine.
    let twice = write(root, "twice.pbrt", "WorldBegin Include \"shared.pbrt\" Include \"shared.pbrt\" WorldEnd");
    assert_eq!(pbrt::load(&twice).expect("a scene").scene.shapes.len(), 2);
    // Many includes of includes end.
    for i in 0..30 {
        let next = format!("Include \"deep{}.pbrt\" ", i + 1);
        write(root, &format!("deep{i}.pbrt"), next.repeat(3));
    }
    assert!(message("Include \"deep0.pbrt\"").contains("at most 16 deep"));
    for i in 0..12 {
        let next = format!("Include \"wide{}.pbrt\" ", i + 1);
        write(root, &format!("wide{i}.pbrt"), if i == 11 { String::new() } else { next.repeat(3) });
    }
    assert!(message("Include \"wide0.pbrt\"").contains("at most 1000"));
}

#[test]
fn missing_files_name_the_folder_and_near_names() {
    let dir = tempfile::tempdir().expect("a folder");
    for name in ["Plate.ply", "plates.ply", "other.ply", "room.pbrt"] {
        write(dir.path(), name, PLY_ASCII);
    }
    let folder = dir.path().display().to_string();
    let message = |name: &str| {
        let text = world(&format!("Shape \"plymesh\" \"string filename\" \"{name}\""));
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
        file.warnings[0].to_string()
    };
    let found = message("plate.ply");
    for words in ["plate.ply", &folder, "did you mean \"Plate.ply\""] {
        assert!(found.contains(words), "{found}");
    }
    assert!(message("room.ply").contains("did you mean \"room.pbrt\""), "{}", message("room.ply"));
    assert!(!message("nothing.ply").contains("did you mean"));
    assert!(message("meshes/plate.ply").contains("there is no folder"), "{}", message("meshes/plate.ply"));
    let found = pbrt::load(&dir.path().join("rom.pbrt")).expect_err("a missing file").to_string();
    assert!(found.contains("did you mean \"room.pbrt\""), "{found}");
}

/// Written on Windows, in whose paths a backslash separates folders.
#[test]
fn backslashes_separate_folders_everywhere() {
    let dir = tempfile::tempdir().expect("a folder");
    write(dir.path(), "mesh/part.ply", PLY_ASCII);
    write(dir.path(), "mesh/more.pbrt", "Shape \"sphere\"");
    let text = world(r#"Shape "plymesh" "string filename" "mesh\part.ply" Include "mesh\more.pbrt""#);
    let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(file.scene.shapes.len(), 2, "{:?}", file.warnings);
    if cfg!(windows) {
        assert_no_warnings(&file);
    } else {
        let said = file.warnings[0].to_string();
        assert!(said.contains(r"mesh\part.ply") && said.contains("mesh/part.ply"), "{said}");
        // A name with a backslash in it is one, if there is such a file.
        write(dir.path(), r"mesh\part.ply", PLY_ASCII);
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(file.warnings.len(), 1, "the Include alone: {:?}", file.warnings);
    }
    let text = world(r#"Shape "plymesh" "string filename" "mesh\none.ply""#);
    let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
    assert!(file.warnings[0].to_string().contains(r"mesh\none.ply"), "as written: {:?}", file.warnings);
}

#[test]
fn normals_of_a_ply_say_which_side_is_in_front() {
    let dir = tempfile::tempdir().expect("a folder");
    let property = "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
    let square = |nz: i32| {
        let header = PLY_ASCII.replace("property float z\n", property);
        ["0 0 0 9", "1 0 0 9", "1 1 0 9", "0 1 0.5 9"].into_iter().fold(header, |text, vertex| {
            let position = vertex.trim_end_matches(" 9");
            text.replace(&format!("\n{vertex}\n"), &format!("\n{position} 0 0 {nz} 9\n"))
        })
    };
    for (transform, nz, reverse) in
        [("", 1, false), ("", -1, true), ("Scale -1 1 1", 1, true), ("Scale -1 1 1", -1, false)]
    {
        write(dir.path(), "n.ply", square(nz));
        let text = world(&format!("{transform} Shape \"plymesh\" \"string filename\" \"n.ply\""));
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
        assert_no_warnings(&file);
        // Counter-clockwise seen from +z: the way the vertices go round, mirrored or not.
        assert_eq!(file.scene.shapes[0].reverse_orientation, reverse, "{transform}, {nz}");
    }
}

/// Some exporters write them for faces without an area.
#[test]
fn normals_of_a_ply_that_are_none_are_left_out_and_the_mesh_stays() {
    let dir = tempfile::tempdir().expect("a folder");
    let header = "ply\nformat FORMAT 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    let vertices =
        [[0.0, 0.0, 0.0, 0.0, 0.0, -1.0], [1.0, 0.0, 0.0, 0.0, f32::NAN, -1.0], [0.0, 1.0, 0.0, 0.0, 0.0, -1.0]];
    let mut binary = header.replace("FORMAT", "binary_little_endian").into_bytes();
    binary.extend(vertices.iter().flatten().flat_map(|v| v.to_le_bytes()));
    binary.push(3);
    binary.extend([0i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
    write(dir.path(), "binary.ply", binary);
    for (name, word) in [("ascii", "nan"), ("minus", "-nan"), ("indefinite", "-nan(ind)")] {
        let text =
            header.replace("FORMAT", "ascii") + &format!("0 0 0 0 0 -1\n1 0 0 0 {word} -1\n0 1 0 0 0 -1\n3 0 1 2\n");
        write(dir.path(), &format!("{name}.ply"), text);
    }
    for name in ["binary", "ascii", "minus", "indefinite"] {
        let text = world(&format!("Shape \"plymesh\" \"string filename\" \"{name}.ply\""));
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(file.scene.shapes.len(), 1, "{name}: {:?}", file.warnings);
        assert!(!file.scene.shapes[0].reverse_orientation, "{name}: by the order of the vertices");
        let found = file.warnings[0].to_string();
        assert!(file.warnings.len() == 1 && found.contains("the normal of vertex 1 is no number"), "{name}: {found}");
    }
}

pub const PLY_ASCII: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.5 9\n4 0 1 2 3\n";

pub fn ply_binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut out = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\nproperty float z\n\
         element face 2\nproperty uchar flags\nproperty list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let f32 = |v: f32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    let u32 = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
    for [x, y, z] in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5f32]] {
        let x = f64::from(x);
        out.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
        out.extend(f32(y));
        out.extend(f32(z));
    }
    for face in [[0, 1, 2], [0, 2, 3]] {
        out.extend([7, 3]);
        out.extend(face.into_iter().flat_map(u32));
    }
    out
}

#[test]
fn ply_meshes() {
    let dir = tempfile::tempdir().expect("a folder");
    write(dir.path(), "ascii.ply", PLY_ASCII);
    write(dir.path(), "crlf.ply", PLY_ASCII.replace('\n', "\r\n"));
    write(dir.path(), "little.ply", ply_binary(false));
    write(dir.path(), "big.ply", ply_binary(true));
    for name in ["ascii.ply", "crlf.ply", "little.ply", "big.ply"] {
        let text = world(&format!("Translate 0 0 1 Shape \"plymesh\" \"string filename\" \"{name}\""));
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_no_warnings(&file);
        let (positions, triangles) = mesh(&file.scene.shapes[0]);
        assert_eq!(positions[3], Vec3::new(0.0, 1.0, 1.5), "{name}");
        assert_eq!(**triangles, [[0, 1, 2], [0, 2, 3]], "{name}: a quad is two triangles");
    }
}

#[test]
fn bad_ply_files_are_left_out() {
    let dir = tempfile::tempdir().expect("a folder");
    let message = |content: &[u8]| {
        write(dir.path(), "bad.ply", content);
        let text = world("Shape \"plymesh\" \"string filename\" \"bad.ply\"");
        let file = pbrt::parse(&text, "t.pbrt", Some(dir.path())).unwrap_or_else(|e| panic!("{e}"));
        assert!(file.scene.shapes.is_empty() && file.warnings.len() == 1, "{:?}", file.warnings);
        let e = file.warnings[0].to_string();
        assert!(e.starts_with("t.pbrt:3:35: plymesh: ") && e.contains("bad.ply"), "{e}");
        assert!(!e.contains('\n'), "one line: {e}");
        e
    };
    assert!(message(b"hello").contains("magic"));
    assert!(message(PLY_ASCII.replace("4 0 1 2 3", "4 0 1 2 4").as_bytes()).contains("vertex index 4"));
    assert!(message(PLY_ASCII.replace("4 0 1 2 3", "4 0 1 2 -1").as_bytes()).contains("vertex_indices"));
    assert!(message(PLY_ASCII.replace("4 0 1 2 3", "2 0 1").as_bytes()).contains("at least 3"));
    assert!(message(PLY_ASCII.replace("property float y\n", "property float w\n").as_bytes()).contains("x, y or z"));
    assert!(message(PLY_ASCII.replace("0 0 0 9\n1", "0 0 1e99 9\n1").as_bytes()).contains("finite"));
    message(PLY_ASCII.replace("0 0 0 9\n1", "0 nan 0 9\n1").as_bytes());
    // Counts that no file could hold are refused before memory is asked for.
    assert!(message(PLY_ASCII.replace("vertex 4", "vertex 999999999999").as_bytes()).contains("announced"));
    assert!(
        message(PLY_ASCII.replace("element face", "element ghost 99999999\nelement face").as_bytes())
            .contains("announced")
    );
    let mut binary = ply_binary(false);
    let header_end = binary.len() - 28 + 1;
    binary[header_end] = 255;
    message(&binary);
    message(&ply_binary(true)[..200]);
    message(PLY_ASCII.replace("uchar int vertex", "float int vertex").replace("4 0 1 2 3", "4.5 0 1 2 3").as_bytes());
}

#[test]
fn the_files_a_scene_depends_on_are_named_also_in_errors() {
    let dir = tempfile::tempdir().expect("a folder");
    let root = dir.path();
    let names = |path: &Path| {
        let (scene, files) = pbrt::load_with_files(path);
        let name = |file: &std::path::PathBuf| {
            let file = file.strip_prefix(root).expect("all of them are here");
            file.to_string_lossy().replace('\\', "/")
        };
        (scene.is_ok(), files.iter().map(name).collect::<Vec<_>>())
    };
    let main = root.join("main.pbrt");
    assert_eq!(names(&main), (false, vec!["main.pbrt".to_owned()]), "a file that is missing");
    write(root, "main.pbrt", "WorldBegin\nInclude \"parts/a.pbrt\"\nInclude \"parts/a.pbrt\"\nWorldEnd");
    write(root, "parts/a.pbrt", "Shape \"plymesh\" \"string filename\" \"../mesh.ply\"");
    let expected = ["main.pbrt", "parts/a.pbrt", "parts/../mesh.ply", "../mesh.ply"];
    let (ok, files) = pbrt::load_with_files(&main);
    let warnings = ok.expect("the rest is a scene").warnings;
    assert!(warnings.iter().any(|w| w.message.contains("mesh.ply")), "the mesh is missing: {warnings:?}");
    assert_eq!(files.len(), expected.len(), "where it was looked for: {files:?}");
    write(
        root,
        "mesh.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    assert_eq!(names(&main), (true, expected[..3].iter().map(|name| (*name).to_owned()).collect()), "each once");
}
