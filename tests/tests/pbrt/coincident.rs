//! Lights in one place: what is seen there does not depend on their order in the file.

use mislab_renderer::Channel;
use mislab_renderer::pbrt::SceneFile;

use crate::outside::{HEADER, ROOM, picture};
use crate::{assert_no_warnings, parse, warnings};

/// A square lamp at z = -1.5 that shines towards the camera, or away from it.
fn panel(l: f32, half: f32, away: bool) -> String {
    let turn = if away { "ReverseOrientation" } else { "" };
    let (a, b, top) = (-half, half, 1.5 + half);
    let low = 1.5 - half;
    format!(
        "AttributeBegin Material \"matte\" \"rgb Kd\" [0 0 0] {turn} AreaLightSource \"diffuse\" \"rgb L\" [{l} {l} {l}]
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
         \"point P\" [{a} {low} -1.5  {b} {low} -1.5  {b} {top} -1.5  {a} {top} -1.5] AttributeEnd\n"
    )
}

fn scene(world: &str, strategy: &str) -> SceneFile {
    parse(&format!("{HEADER}{world}\nWorldEnd").replace("mis_all", strategy))
}

/// Pixels that show a surface of this radiance and nothing else.
fn showing(file: &SceneFile, radiance: f32) -> usize {
    picture(file).channel(Channel::G).iter().filter(|&&v| v == radiance).count()
}

const STRATEGIES: [&str; 4] = ["light", "bsdf", "mis_all", "mis"];

#[test]
fn of_two_lights_in_one_place_the_brighter_is_seen_and_the_other_changes_nothing() {
    let (bright, dim) = (panel(8.0, 0.5, false), panel(3.0, 0.5, false));
    // The same square, from another corner on, and from other triangles.
    let turned = dim.replace("[0 1 2 0 2 3]", "[2 3 0 2 0 1]");
    let alone = |strategy: &str| picture(&scene(&format!("{bright}{ROOM}"), strategy)).channel(Channel::G);
    for strategy in STRATEGIES {
        let expected = alone(strategy);
        for lights in [[&bright, &dim], [&dim, &bright], [&bright, &bright], [&bright, &turned], [&turned, &bright]] {
            let file = scene(&format!("{}{}{ROOM}", lights[0], lights[1]), strategy);
            assert_eq!(picture(&file).channel(Channel::G), expected, "{strategy}: {lights:?}");
            let found = warnings(&file);
            assert!(found.len() == 1 && found[0].2.contains("light2 is where light1 is"), "{found:?}");
        }
    }
    let ball = |l: f32| {
        format!(
            "AttributeBegin Translate 0 2 0 Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\"
             \"rgb L\" [{l} {l} {l}] Shape \"sphere\" \"float radius\" .4 AttributeEnd\n"
        )
    };
    let expected = picture(&scene(&format!("{}{ROOM}", ball(8.0)), "mis_all")).channel(Channel::G);
    for lights in [[8.0, 3.0], [3.0, 8.0]] {
        let file = scene(&format!("{}{}{ROOM}", ball(lights[0]), ball(lights[1])), "mis_all");
        assert_eq!(picture(&file).channel(Channel::G), expected, "{lights:?}");
    }
}

#[test]
fn of_two_lights_that_overlap_the_brighter_is_seen() {
    // The smaller one is in front, or hidden.
    for [small, large] in [[8.0, 3.0], [3.0, 8.0]] {
        let (small, large) = (panel(small, 0.3, false), panel(large, 0.6, false));
        // A thousandth in front, there is nothing to decide.
        let apart = if small.contains("[8 8 8]") { small.replace("-1.5", "-1.499") } else { String::new() };
        let expected = [8.0, 3.0].map(|l| showing(&scene(&format!("{apart}{large}{ROOM}"), "mis_all"), l));
        assert!(expected[0] > 20 || expected[1] > 100, "{expected:?}");
        for lights in [[&small, &large], [&large, &small]] {
            for strategy in STRATEGIES {
                let file = scene(&format!("{}{}{ROOM}", lights[0], lights[1]), strategy);
                let found = [8.0, 3.0].map(|l| showing(&file, l));
                assert_eq!(found, expected, "{strategy}: {lights:?}");
                assert_no_warnings(&file);
            }
        }
    }
}

#[test]
fn two_lights_back_to_back_shine_to_both_sides() {
    let (front, back) = (panel(8.0, 0.5, false), panel(3.0, 0.5, true));
    let behind = |text: &str| parse(&text.replace("LookAt 0 2 6", "LookAt 0 2 -9"));
    for lights in [[&front, &back], [&back, &front]] {
        // The room's wall, which would hide the panel from behind, is left out.
        let text = format!("{HEADER}{}{}WorldEnd", lights[0], lights[1]);
        let (from_front, from_behind) = (parse(&text), behind(&text));
        assert_no_warnings(&from_front);
        let alone = |light: &String| format!("{HEADER}{light}WorldEnd");
        let (expected_front, expected_back) =
            (showing(&parse(&alone(&front)), 8.0), showing(&behind(&alone(&back)), 3.0));
        assert!(expected_front > 50 && expected_back > 50);
        assert_eq!([8.0, 3.0].map(|l| showing(&from_front, l)), [expected_front, 0]);
        assert_eq!([8.0, 3.0].map(|l| showing(&from_behind, l)), [0, expected_back]);
    }
    // So does a sphere, from outside.
    let ball = |l: f32, inward: &str| {
        format!(
            "AttributeBegin Translate 0 2 0 Material \"matte\" \"rgb Kd\" [0 0 0] {inward} AreaLightSource \"diffuse\"
             \"rgb L\" [{l} {l} {l}] Shape \"sphere\" \"float radius\" .4 AttributeEnd\n"
        )
    };
    let (outward, inward) = (ball(8.0, ""), ball(3.0, "ReverseOrientation"));
    let expected = showing(&scene(&outward, "mis_all"), 8.0);
    for lights in [[&outward, &inward], [&inward, &outward]] {
        let file = scene(&format!("{}{}", lights[0], lights[1]), "mis_all");
        assert_eq!([8.0, 3.0].map(|l| showing(&file, l)), [expected, 0]);
    }
}

#[test]
fn behind_a_lamp_on_a_wall_is_the_wall() {
    let lamp = panel(8.0, 0.5, false).replace("-1.5", "-2");
    let behind = "AttributeBegin Translate 0 2 -5 Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\"
                  \"rgb L\" [9 9 9] Shape \"sphere\" \"float radius\" .1 AttributeEnd\n";
    let dark = |world: &str| {
        let text = format!("{HEADER}{behind}{world}WorldEnd").replace("LookAt 0 2 6", "LookAt 0 2 -9");
        picture(&parse(&text)).channel(Channel::G).iter().filter(|&&v| v == 0.0).count()
    };
    let without = dark(ROOM);
    for world in [format!("{lamp}{ROOM}"), format!("{ROOM}{lamp}")] {
        assert_eq!(dark(&world), without, "the lamp's black back is not seen");
    }
}
