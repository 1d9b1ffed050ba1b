//! Files as they are out there: whole scenes that bring something this reader does not know, and how bright they are.
//!
//! The expected means over pixels and channels are those of converged pictures; where pbrt-v3 reads the file it has the same.

use std::sync::Arc;

use mislab_renderer::black::why_black;
use mislab_renderer::pbrt::SceneFile;
use mislab_renderer::{Channel, Frame, Sampling, Settings};
use mislab_tests::experiment::render;

use crate::{assert_no_warnings, parse, warnings};

pub(crate) const HEADER: &str = r#"Film "image" "integer xresolution" [64] "integer yresolution" [64]
Sampler "stratified" "integer xsamples" [8] "integer ysamples" [8]
Integrator "veachMIS" "string MISstrategy" ["mis_all"]
LookAt 0 2 6  0 1 0  0 1 0
Camera "perspective" "float fov" [45]
WorldBegin
"#;

/// A floor, and a reddish wall at z = -2.
pub(crate) const ROOM: &str = r#"
Material "matte" "rgb Kd" [0.5 0.5 0.5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4  -4 0 4  4 0 4  4 0 -4]
Material "matte" "rgb Kd" [0.7 0.3 0.2]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -2  4 0 -2  4 4 -2  -4 4 -2]
"#;

/// A sphere light.
fn lamp(place: &str, l: f32, radius: f32) -> String {
    format!(
        "AttributeBegin Translate {place} Material \"matte\" \"rgb Kd\" [0 0 0]
         AreaLightSource \"diffuse\" \"rgb L\" [{l} {l} {l}] Shape \"sphere\" \"float radius\" [{radius}] AttributeEnd\n"
    )
}

/// A lamp, the room, and something more.
fn scene(world: &str) -> SceneFile {
    parse(&format!("{HEADER}{world}\nWorldEnd"))
}

pub(crate) fn picture(file: &SceneFile) -> Arc<Frame> {
    render(&Arc::new(file.scene.clone()), &file.settings)
}

fn mean(file: &SceneFile) -> f64 {
    let frame = picture(file);
    let values = [Channel::R, Channel::G, Channel::B].map(|c| frame.channel(c));
    let count = values[0].len() as f64 * 3.0;
    values.iter().flatten().map(|&v| f64::from(v)).sum::<f64>() / count
}

#[track_caller]
fn assert_mean(file: &SceneFile, expected: f64) {
    let found = mean(file);
    assert!((found / expected - 1.0).abs() < 0.006, "mean {found:.4}, expected {expected}");
}

/// A square lamp under the ceiling, whose vertices go round so that it would shine upwards; more parameters at its end.
fn square_lamp(n: &str) -> String {
    format!(
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [10 10 10]
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
         \"point P\" [-.5 2.5 -.5  -.5 2.5 .5  .5 2.5 .5  .5 2.5 -.5] {n} AttributeEnd\n"
    )
}

#[test]
fn normals_turn_a_lamp() {
    let down = "\"normal N\" [0 -1 0 0 -1 0 0 -1 0 0 -1 0]";
    let file = scene(&format!("{}{ROOM}", square_lamp(down)));
    assert_no_warnings(&file);
    assert_mean(&file, 0.0937);
    // Mirrored from left to right it is the same picture.
    let file = scene(&format!("AttributeBegin Scale -1 1 1 {} AttributeEnd {ROOM}", square_lamp(down)));
    assert_mean(&file, 0.0937);
}

#[test]
fn commas_change_nothing() {
    let file = scene(&format!("{}{ROOM}", lamp("0 2 0", 8.0, 0.4).replace("[8 8 8]", "[8, 8, 8]")));
    assert_eq!(warnings(&file).len(), 1);
    assert_mean(&file, 0.2236);
}

#[test]
fn what_is_left_out_leaves_the_rest() {
    let lamp_and_room = format!("{}{ROOM}", lamp("0 2 0", 8.0, 0.4));
    // The sphere is there, of the material before.
    let file = scene(&format!(
        "{lamp_and_room} NamedMaterial \"Sun_Light\" Translate -1 .5 0 Shape \"sphere\" \"float radius\" [.5]"
    ));
    assert!(file.warnings.len() == 1 && file.warnings[0].message.contains("Sun_Light"), "{:?}", file.warnings);
    assert_mean(&file, 0.2217);
    let bolt = "AttributeBegin\nObjectBegin \"bolt\"\nShape \"sphere\" \"float radius\" [.3]\nAttributeEnd\nObjectEnd";
    let file = scene(&format!("{lamp_and_room} {bolt}"));
    assert!(file.warnings.iter().any(|w| w.message.contains("ObjectBegin of line")), "{:?}", file.warnings);
    assert_mean(&file, 0.2236);
    let ellipsoid = "AttributeBegin Translate 0 .5 0 Scale 1 .5 1 Material \"matte\" \"rgb Kd\" [.2 .6 .2]
                     Shape \"sphere\" \"float radius\" [1] AttributeEnd";
    let file = scene(&format!("{}{ROOM} {ellipsoid}", lamp("0 3 0", 8.0, 0.4)));
    assert!(file.warnings.len() == 1 && file.warnings[0].message.contains("ellipsoid"), "{:?}", file.warnings);
    assert_mean(&file, 0.2253);
    // A lamp that is hardly an ellipsoid shines as a sphere does, mirrored or not.
    for scale in ["1 1 1.01", "-1 1 1.01"] {
        let file = scene(&format!("{}{ROOM}", lamp(&format!("0 2 0 Scale {scale}"), 8.0, 0.4)));
        assert_mean(&file, 0.2236 * 1.005);
    }
}

#[test]
fn plastic_has_the_books_value_and_pbrts() {
    let plastic = |parameter: &str| {
        let coat = format!(
            "\"plastic\" \"rgb Kd\" [.1 .1 .1] \"rgb Ks\" [1 1 1] \"float roughness\" [.05] \"bool remaproughness\" [\"false\"] {parameter}"
        );
        scene(&format!("{}{}", lamp("0 2 0", 8.0, 0.4), ROOM.replacen("\"matte\" \"rgb Kd\" [0.5 0.5 0.5]", &coat, 1)))
    };
    assert_mean(&plastic(""), 0.206);
    assert_mean(&plastic("\"bool pbrtfresnel\" [\"true\"]"), 0.242);
}

#[test]
fn a_lamp_without_a_material_is_grey() {
    let light =
        |place: &str, l: f32, radius: f32| lamp(place, l, radius).replace("Material \"matte\" \"rgb Kd\" [0 0 0]", "");
    let file = scene(&format!("{}{}{ROOM}", light("-1 2 0", 8.0, 0.4), light("1 1.5 0", 0.2, 0.6)));
    assert_no_warnings(&file);
    assert_mean(&file, 0.2358);
}

/// A lamp in the plane of the wall, facing into the room.
const WALL_LAMP: &str = r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [8 8 8]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-1 1 -2  1 1 -2  1 2 -2  -1 2 -2]
AttributeEnd
"#;

#[test]
fn a_lamp_in_a_wall_is_in_front_of_it_for_all_rays() {
    // The same lamp a thousandth in front of the wall, where there is nothing to decide.
    let apart = format!("{}{ROOM}", WALL_LAMP.replace(" -2 ", " -1.999 ").replace("-2]", "-1.999]"));
    let expected = mean(&scene(&apart));
    for world in [format!("{WALL_LAMP}{ROOM}"), format!("{ROOM}{WALL_LAMP}")] {
        for strategy in ["light", "bsdf", "mis_all"] {
            let text = format!("{HEADER}{world}\nWorldEnd").replace("[\"mis_all\"]", &format!("[\"{strategy}\"]"));
            let file = parse(&text);
            let found = mean(&file);
            assert!((found / expected - 1.0).abs() < 0.02, "{strategy}: {found}, expected {expected}");
        }
        // All of it shines, before the camera and in a mirror in place of the floor.
        let bright = |world: &str| picture(&scene(world)).channel(Channel::G).iter().filter(|&&v| v > 7.5).count();
        let floor =
            |world: &str| world.replacen("\"matte\" \"rgb Kd\" [0.5 0.5 0.5]", "\"mirror\" \"rgb Kr\" [1 1 1]", 1);
        assert_eq!(bright(&world), bright(&apart), "before the camera");
        assert_eq!(bright(&floor(&world)), bright(&floor(&apart)), "in a mirror");
        assert!(bright(&world) > 100 && bright(&floor(&world)) > 200);
    }
}

#[test]
fn so_it_is_in_any_plane_and_among_many_surfaces() {
    let many: String =
        (0..30).map(|i| format!("TransformBegin Translate {i} 0 60 Shape \"sphere\" TransformEnd\n")).collect();
    // A trapezium, which is two lights, in a wall along no axis.
    let lamp = WALL_LAMP.replace("1 2 -2  -1 2 -2]", "1 2 -2  -.7 2.1 -2]");
    let apart = lamp.replace(" -2 ", " -1.999 ").replace("-2]", "-1.999]");
    for more in ["", many.as_str()] {
        for turn in ["", "Rotate 9 1 2 3 Translate .1 .2 .3"] {
            let by = |lamp: &str, strategy: &str| {
                let text = format!("{HEADER}{turn}\n{ROOM}{lamp}{more}WorldEnd").replace("mis_all", strategy);
                mean(&parse(&text))
            };
            let expected = by(&apart, "mis_all");
            for strategy in ["light", "mis_all"] {
                let found = by(&lamp, strategy);
                assert!((found / expected - 1.0).abs() < 0.01, "{turn} {strategy}: {found}, expected {expected}");
            }
        }
    }
}

#[test]
fn a_body_around_a_lamp_of_its_size_does_not_hide_it() {
    let lamp = lamp("0 2 0", 8.0, 0.4);
    let body = "AttributeBegin Translate 0 2 0 Shape \"sphere\" \"float radius\" [0.4] AttributeEnd\n";
    for world in [format!("{lamp}{ROOM}{body}"), format!("{body}{lamp}{ROOM}")] {
        assert_mean(&scene(&world), 0.2236);
    }
}

#[test]
fn a_black_picture_says_why() {
    let why = |file: &SceneFile| why_black(&picture(file)).unwrap_or_default();
    let expect = |world: &str, words: &str| {
        let found = why(&scene(world));
        assert!(found.contains("no light reaches this picture directly") && found.contains(words), "{words}: {found}");
    };
    let lamp = lamp("0 2 0", 8.0, 0.4);
    expect("", "no shapes");
    expect(&format!("LightSource \"point\" \"rgb I\" [9 9 9] \"point from\" [0 2 0] {ROOM}"), "no area light");
    expect(&format!("AreaLightSource \"diffuse\" \"rgb L\" [0 0 0] {ROOM}"), "emits nothing");
    expect(&format!("TransformBegin Translate 0 0 100 {lamp}{ROOM} TransformEnd"), "nothing of the scene is in view");
    // It faces the ceiling, and nothing but the top of the wall is lit; lower, and nothing is.
    expect(&format!("{}{ROOM}", square_lamp("")), "% of the surfaces in view: its lights face away");
    let wall =
        "Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-9 -9 -2 9 -9 -2 0 2 -2]";
    expect(&format!("{}{wall}", square_lamp("")), "directly: its lights face away");
    let behind = lamp.replace("0 2 0 Material", "0 2 9 Material");
    let blackened =
        |world: &str| why(&scene(&world.replace("[0.5 0.5 0.5]", "[0 0 0]").replace("[0.7 0.3 0.2]", "[0 0 0]")));
    assert!(blackened(&format!("{behind}{ROOM}")).contains("this picture is black: everything in view is black"));
    // Not the scene's fault: a small light that few samples meet, and light samples of mirrors.
    let small = self::lamp("0 2 9", 8.0, 0.001);
    let by =
        |strategy: &str, world: &str| why(&parse(&format!("{HEADER}{world}WorldEnd").replace("mis_all", strategy)));
    assert_eq!(by("mis_all", &format!("{small}{ROOM}")), "");
    let found = by("bsdf", &format!("{small}{ROOM}"));
    assert!(found.contains("no sample of the strategy bsdf has hit a light in 64 spp"), "{found}");
    let found = by("light", &format!("{behind}{}", ROOM.replace("\"matte\" \"rgb Kd\"", "\"mirror\" \"rgb Kr\"")));
    assert!(found.contains("mirrors"), "{found}");
    assert_eq!(by("mis_all", &format!("{lamp}{ROOM}")), "");
}

#[test]
fn a_file_of_pbrt_v4_is_named_as_one() {
    let text = "Film \"rgb\" \"integer xresolution\" [64] \"integer yresolution\" [64] \"string filename\" \"v4.exr\"
Sampler \"zsobol\" \"integer pixelsamples\" 16
Integrator \"volpath\"
LookAt 0 2 6  0 1 0  0 1 0
Camera \"perspective\" \"float fov\" [45]
WorldBegin
AttributeBegin
Translate 0 2 0
AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"float scale\" [20]
Shape \"sphere\" \"float radius\" .4
AttributeEnd
Material \"diffuse\" \"rgb reflectance\" [.2 .6 .2]
Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-4 0 -4  -4 0 4  4 0 4  4 0 -4]
";
    let file = parse(text);
    let found = warnings(&file);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!((found[0].0, found[0].1), (1, 1));
    for words in [
        "pbrt-v4",
        "Film \"rgb\"",
        "\"zsobol\"",
        "\"volpath\"",
        "\"diffuse\" as matte",
        "\"float scale\"",
        "no WorldEnd",
    ] {
        assert!(found[0].2.contains(words), "{words}: {}", found[0].2);
    }
    // The same in the words of pbrt-v3.
    let v3 = text
        .replace("\"rgb\" \"integer", "\"image\" \"integer")
        .replace("zsobol", "sobol")
        .replace("volpath", "veachMIS")
        .replace("[1 1 1] \"float scale\" [20]", "[20 20 20]")
        .replace("\"diffuse\" \"rgb reflectance\"", "\"matte\" \"rgb Kd\"")
        + "WorldEnd\n";
    let same = parse(&v3);
    assert_no_warnings(&same);
    assert_eq!((&file.scene, &file.settings), (&same.scene, &same.settings));
    // One odd name makes no pbrt-v4 of a file.
    let file = parse("Integrator \"volpath\"\nCamera \"perspective\"\nWorldBegin");
    assert_eq!(warnings(&file).len(), 2);
    assert!(!warnings(&file).iter().any(|w| w.2.contains("pbrt-v4")));
}

/// The irradiance from a sphere is `pi L (r / d)^2 cos`: that of a point light of the same power, whatever the radius.
#[test]
fn sphere_lights_of_any_radius_agree_with_a_point_light() {
    let power = 8.0 * 0.4f64 * 0.4;
    let settings = |file: &SceneFile| {
        let sampling = Sampling { spp: std::num::NonZeroU32::new(256), ..file.settings.sampling };
        Settings { sampling, ..file.settings.clone() }
    };
    for height in [2.0, 6.0] {
        let mut reference = None;
        for radius in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-9, 1e-14] {
            let l = power / (radius * radius);
            let floor = "Material \"matte\" \"rgb Kd\" [1 1 1] Shape \"trianglemesh\" \"integer indices\" [0 1 2]
                         \"point P\" [-90 0 -90  -90 0 90  90 0 0]";
            let header = HEADER.replace("mis_all", "light").replace("LookAt 0 2 6  0 1 0", "LookAt 0 3 6  0 0 3.5");
            let lamp = format!(
                "AttributeBegin Translate 0 {height} 0 Material \"matte\" \"rgb Kd\" [0 0 0]
                 AreaLightSource \"diffuse\" \"rgb L\" [{l} {l} {l}] Shape \"sphere\" \"float radius\" {radius:e} AttributeEnd\n"
            );
            let file = parse(&format!("{header}{lamp}{floor}\nWorldEnd"));
            let frame = render(&Arc::new(file.scene.clone()), &settings(&file));
            let light = frame.channel(Channel::G);
            let found = light.iter().map(|&v| f64::from(v)).sum::<f64>() / light.len() as f64;
            let expected = *reference.get_or_insert(found);
            assert!(
                (found / expected - 1.0).abs() < 1e-3,
                "radius {radius:e} at {height}: {found}, expected {expected}"
            );
        }
    }
}
