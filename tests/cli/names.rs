//! `mislab render`: under which names pictures are saved.

use crate::place::{Place, scene_with_header};

/// The tutorial's three headers as printed there, with the line breaks and quotation marks of its PDF.
#[test]
fn the_tutorials_headers_render_to_their_files() {
    let headers = [
        (
            "veachMIS_L.exr",
            "light",
            64,
            "Sampler “stratified” “integer xsamples” [8] “integer ysamples”\n[8] “bool jitter” [“true”]\n\
             Integrator “veachMIS” “string MISstrategy” [“light”]\n\
             Film “image” “string filename” [“veachMIS_L.exr”] “integer\nxresolution” [800] “integer yresolution” [800]",
        ),
        (
            "veachMIS_BSDF.exr",
            "bsdf",
            64,
            "Integrator \"veachMIS\" \"string MISstrategy\" [\"bsdf\"]\n\
             Film \"image\" \"string filename\" [\"veachMIS_BSDF.exr\"] \"integer\nxresolution\" [800] \"integer yresolution\" [800]",
        ),
        (
            "veach_MIS_ALLx36.exr",
            "mis_all",
            36,
            "Sampler \"stratified\" \"integer xsamples\" [6] \"integer ysamples\"\n[6] \"bool jitter\" [\"true\"]\n\
             Film \"image\" \"string filename\" [\"veach_MIS_ALLx36.exr\"] \"integer\nxresolution\" [600] \"integer yresolution\" [600]\n\
             SurfaceIntegrator \"veachMIS\" \"string sample_method\" [\"mis_all\"]",
        ),
    ];
    let place = Place::new();
    for (file, strategy, spp, header) in headers {
        place.write("veach_mis.pbrt", &scene_with_header(header));
        let report = place.json("render veach_mis.pbrt --size 40x40 --quiet");
        assert_eq!(report["outfile"], file);
        assert_eq!(report["strategy"], strategy, "{file}");
        assert_eq!(report["spp"], spp, "{file}");
        let image = place.image(file);
        assert_eq!(image.display.size, [40, 40]);
        assert_eq!(image.attribute("strategy"), Some(strategy));
    }
    assert_eq!(place.files(), ["veachMIS_BSDF.exr", "veachMIS_L.exr", "veach_MIS_ALLx36.exr", "veach_mis.pbrt"]);
}

#[test]
fn another_programs_integrator_stands_in_the_pictures_name() {
    let place = Place::new();
    place.write(
        "path.pbrt",
        &scene_with_header("Integrator \"path\"\nFilm \"image\" \"string filename\" [\"veachMIS_L.exr\"]"),
    );
    let line = "render path.pbrt --size 8x8 --spp 1";
    let report = place.json(line);
    assert_eq!(report["outfile"], "veachMIS_L_mis_all.exr");
    let warnings = report["warnings"].as_array().expect("a list");
    assert!(warnings.len() == 1 && warnings[0].as_str().is_some_and(|w| w.contains("path")), "{warnings:?}");
    // The name says what was used, and whoever gives one is not contradicted.
    assert_eq!(place.json(&format!("{line} --strategy light"))["outfile"], "veachMIS_L_light.exr");
    assert_eq!(place.json(&format!("{line} --outfile mine.exr"))["outfile"], "mine.exr");
}

/// A file named for one strategy does not get the picture of another.
#[test]
fn a_strategy_of_the_command_line_stands_in_the_pictures_name() {
    let place = Place::new();
    let film = "Film \"image\" \"integer xresolution\" [8] \"integer yresolution\" [8] \"string filename\" [\"veachMIS_L.exr\"]";
    let integrator = "Integrator \"veachMIS\" \"string MISstrategy\" [\"light\"]";
    place.write("a.pbrt", &scene_with_header(&format!("{film} {integrator}")));
    place.run("render a.pbrt --spp 1 --strategy bsdf").expect_code(0);
    place.run("render a.pbrt --spp 1 --strategy light").expect_code(0);
    let mut files = place.files();
    files.retain(|name| name.ends_with(".exr"));
    files.sort();
    assert_eq!(files, ["veachMIS_L.exr", "veachMIS_L_bsdf.exr"]);
}

/// The names that nobody named on the command line: the Film's, and that of a picture rendered again.
#[test]
fn only_a_file_named_on_the_command_line_is_replaced() {
    let place = Place::new();
    let film =
        "Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16] \"string filename\" [\"a.exr\"]";
    place.write("a.pbrt", &scene_with_header(film));
    place.run("render a.pbrt --spp 1 --quiet --outfile one.exr").expect_code(0);
    for own in ["a.exr", "one_again.exr"] {
        place.write(own, "somebody's own");
    }
    for (line, own, saved) in [
        ("render a.pbrt --spp 1", "a.exr", "a_2.exr"),
        ("render a.pbrt --spp 1 --quiet", "a.exr", "a_3.exr"),
        ("render a.pbrt --quick", "a.exr", "a_4.exr"),
        ("render one.exr --quiet", "one_again.exr", "one_again_2.exr"),
    ] {
        let kept = format!("{own}: was there before and is kept as it was, the picture is {saved}");
        place.run(line).expect_code(0).expect_err(&[&kept]);
        assert_eq!(std::fs::read_to_string(place.path(own)).expect("is there"), "somebody's own", "{line}");
        assert!(place.files().contains(&saved.to_owned()), "{line}: {:?}", place.files());
    }
    assert_eq!(place.json("render a.pbrt --spp 1")["outfile"], "a_5.exr");
    place.run("render a.pbrt --spp 1 --outfile a.exr").expect_code(0);
    assert_eq!(place.image("a.exr").window.size, [16, 16], "named, it is replaced");
}

#[test]
fn a_home_folder_is_found_where_the_shell_leaves_it() {
    let place = Place::new();
    let mut command = place.command("render --size 8x8 --spp 1 --quiet --outfile=~/deep.exr");
    let home = Place::new();
    command.env("HOME", home.0.path());
    assert_eq!(command.status().expect("the program starts").code(), Some(0));
    assert!(home.path("deep.exr").exists() && place.files().is_empty());
}
