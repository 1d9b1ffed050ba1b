//! Surfaces in one place that are no lights: what is seen there does not depend on their order in the file, nor on the ray.

use std::collections::BTreeSet;

use mislab_renderer::Channel;
use mislab_renderer::pbrt::SceneFile;

use crate::outside::{HEADER, ROOM, picture};
use crate::{assert_no_warnings, parse, warnings};

const LAMP: &str = "AttributeBegin Translate -1 3 1 Material \"matte\" \"rgb Kd\" [0 0 0]
    AreaLightSource \"diffuse\" \"rgb L\" [9 9 9] Shape \"sphere\" \"float radius\" .4 AttributeEnd\n";
const STRATEGIES: [&str; 4] = ["light", "bsdf", "mis_all", "mis"];
const LIGHT_GREY: &str = "\"matte\" \"rgb Kd\" [.8 .8 .8]";
const DARK_GREY: &str = "\"matte\" \"rgb Kd\" [.2 .2 .2]";

/// A square over the floor, or in its plane at height 0, from another corner on and in other triangles if it is `turned`.
fn rug(material: &str, y: f32, turned: bool) -> String {
    let (indices, reverse) = if turned { ("2 3 0 1 2 0", "ReverseOrientation") } else { ("0 1 2 0 2 3", "") };
    format!(
        "AttributeBegin Material {material} {reverse} Shape \"trianglemesh\" \"integer indices\" [{indices}]
         \"point P\" [-1.03 {y} -1.1  -1.03 {y} .9  1.01 {y} .9  1.01 {y} -1.1] AttributeEnd\n"
    )
}

fn ball(material: &str) -> String {
    format!("AttributeBegin Translate 0 .8 0 Material {material} Shape \"sphere\" \"float radius\" .6 AttributeEnd\n")
}

fn scene(world: &str, strategy: &str) -> SceneFile {
    parse(&format!("{HEADER}{LAMP}{world}\nWorldEnd").replace("mis_all", strategy))
}

/// Every bit of every layer.
fn bits(file: &SceneFile) -> Vec<Vec<u32>> {
    let frame = picture(file);
    Channel::ALL.iter().map(|channel| frame.channel(*channel).iter().map(|v| v.to_bits()).collect()).collect()
}

#[test]
fn of_two_surfaces_in_one_place_the_one_that_reflects_more_is_seen() {
    let plastic = |kd: &str| format!("\"plastic\" \"rgb Kd\" [{kd}] \"rgb Ks\" [.5 .5 .5] \"float roughness\" .1");
    let (red, blue) = (plastic(".6 .1 .1"), plastic(".1 .1 .6"));
    let mirror = "\"mirror\" \"rgb Kr\" [.9 .9 .9]".to_owned();
    type Shape = fn(&str) -> String;
    let above: Shape = |material| rug(material, 0.3, false);
    for (shape, [more, less]) in [
        (above, [LIGHT_GREY, DARK_GREY]),
        (above, [&red, &blue]),
        (above, [&mirror, LIGHT_GREY]),
        (ball as Shape, [LIGHT_GREY, &red]),
    ] {
        for strategy in STRATEGIES {
            let expected = bits(&scene(&format!("{}{ROOM}", shape(more)), strategy));
            for [a, b] in [[more, less], [less, more]] {
                let file = scene(&format!("{}{}{ROOM}", shape(a), shape(b)), strategy);
                assert!(bits(&file) == expected, "{strategy}: {a}, then {b}");
                let found: Vec<_> =
                    warnings(&file).into_iter().filter(|(_, _, w)| w.contains("is where one of")).collect();
                let said = found.len() == 1 && found[0].2.contains("reflects more is seen");
                assert!(said, "{found:?}");
            }
        }
    }
    // Of the same material there is nothing to decide.
    assert_no_warnings(&scene(&format!("{}{}{ROOM}", ball(DARK_GREY), ball(DARK_GREY)), "mis_all"));
}

#[test]
fn the_order_in_the_file_changes_no_bit() {
    let cases = [(LIGHT_GREY, false), (LIGHT_GREY, true), (DARK_GREY, false), (DARK_GREY, true)];
    for ((material, turned), strategy) in cases.into_iter().zip(STRATEGIES) {
        let all = [rug(material, 0.0, turned), rug("\"mirror\"", 0.0, false), ball(DARK_GREY), ball(LIGHT_GREY)];
        let pictures = [[0, 1, 2, 3], [3, 2, 1, 0], [1, 0, 3, 2], [2, 0, 3, 1]].map(|order| {
            let listed: String = order.iter().map(|&i| all[i].as_str()).collect();
            [format!("{ROOM}{listed}"), format!("{listed}{ROOM}")].map(|world| bits(&scene(&world, strategy)))
        });
        let distinct: BTreeSet<_> = pictures.iter().flatten().collect();
        assert_eq!(distinct.len(), 1, "{strategy}, {material}, turned: {turned}");
    }
}

/// Of what overlaps in one plane, too; a picture of many primitives is searched by a tree instead of lists.
#[test]
fn a_rug_in_the_plane_of_the_floor_is_seen_as_a_whole_or_not_at_all() {
    // A thousandth above the floor, or left out, there is nothing to decide.
    for (material, apart) in [(LIGHT_GREY, rug(LIGHT_GREY, 0.001, false)), (DARK_GREY, String::new())] {
        let pixels = |file: &SceneFile| picture(file).channel(Channel::G);
        let expected = pixels(&scene(&format!("{apart}{ROOM}"), "mis_all"));
        for turned in [false, true] {
            let rug = rug(material, 0.0, turned);
            for crumbs in [0, 40] {
                // Behind the wall.
                let crumbs: String =
                    (0..crumbs).map(|i| ball(DARK_GREY).replace("0 .8 0", &format!("{i} 1 -9"))).collect();
                for world in [format!("{rug}{ROOM}{crumbs}"), format!("{ROOM}{rug}{crumbs}")] {
                    let file = scene(&world, "mis_all");
                    assert_no_warnings(&file);
                    let found = pixels(&file);
                    let off = found.iter().zip(&expected).filter(|(a, b)| (*a - *b).abs() > 0.1 * b.abs()).count();
                    assert!(off < 12, "{off} pixels differ, {material}, turned: {turned}");
                }
            }
        }
    }
}

/// A light that reflects, too: of equally bright ones.
#[test]
fn of_equally_bright_lights_in_one_place_the_one_that_reflects_more_is_seen() {
    let panel = |kd: &str| {
        format!(
            "AttributeBegin Material \"matte\" \"rgb Kd\" [{kd}] AreaLightSource \"diffuse\" \"rgb L\" [2 2 2]
             Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
             \"point P\" [-.5 1 -1.5  .5 1 -1.5  .5 2 -1.5  -.5 2 -1.5] AttributeEnd\n"
        )
    };
    let (more, less) = (panel(".8 .8 .8"), panel(".1 .1 .1"));
    let expected = bits(&scene(&format!("{more}{ROOM}"), "mis_all"));
    for [a, b] in [[&more, &less], [&less, &more]] {
        assert!(bits(&scene(&format!("{a}{b}{ROOM}"), "mis_all")) == expected, "{a} {b}");
    }
}
