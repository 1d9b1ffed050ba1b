//! `mislab table`, and the same where there is no display.

use mislab_renderer::snapshot;
use serde_json::Value;

use crate::place::{Place, scene_with_header};

const TUTORIAL_FILES: [&str; 4] = ["veachMIS_BSDF.exr", "veachMIS_L.exr", "veachMIS_MIS.exr", "veach_MIS_ALLx36.exr"];

#[test]
fn the_table_in_all_formats_with_its_pictures() {
    let place = Place::new();
    let ran = place.run("table --size 24x24 --outdir lesson/pictures --format json");
    ran.expect_code(0).expect_err(&TUTORIAL_FILES);
    let table: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(table["rows"].as_array().map(Vec::len), Some(4));
    let folder = place.path("lesson/pictures");
    for (file, strategy, spp) in [
        ("veachMIS_L", "light", 64),
        ("veachMIS_BSDF", "bsdf", 64),
        ("veach_MIS_ALLx36", "mis_all", 36),
        ("veachMIS_MIS", "mis", 64),
    ] {
        let restored = snapshot::restore(&folder.join(format!("{file}.exr"))).expect("a snapshot");
        assert_eq!(restored.request.settings.estimator.strategy.name(), strategy);
        assert_eq!((restored.spp, restored.request.settings.image.resolution), (spp, [24, 24]));
    }

    let csv = place.run("table --size 24x24 --format csv --quiet");
    csv.expect_code(0);
    assert_eq!(csv.err, "");
    assert_eq!(csv.out.lines().count(), 1 + 4 * 4, "{}", csv.out);
    let markdown = place.run("table --size 24x24 --quiet -nthreads 2");
    markdown.expect_code(0);
    assert!(markdown.out.starts_with('|'), "{}", markdown.out);
}

/// Where no window can be opened, the lesson's results come all the same. The scene's own size keeps this short.
#[test]
fn without_a_display_the_pictures_and_the_table_are_made() {
    let place = Place::new();
    place.write(
        "small.pbrt",
        &scene_with_header("Film \"image\" \"integer xresolution\" [24] \"integer yresolution\" [20]"),
    );
    let ran = place.run("small.pbrt");
    ran.expect_code(0).expect_err(&["No window: ", "display", "pictures and table"]).expect_err(&TUTORIAL_FILES);
    assert!(ran.out.contains("veachMIS_MIS.exr") && ran.out.starts_with('|'), "{}", ran.out);
    for file in TUTORIAL_FILES {
        assert_eq!(place.image(file).display.size, [24, 20], "{file}");
    }
    let ran = place.run("none.pbrt");
    ran.expect_code(1).expect_err(&["none.pbrt: cannot read"]);
    assert!(!ran.err.contains("Rendering"), "nothing is announced that does not happen: {}", ran.err);
}

#[test]
fn without_a_display_no_file_is_replaced() {
    let place = Place::new();
    place.write(
        "small.pbrt",
        &scene_with_header("Film \"image\" \"integer xresolution\" [16] \"integer yresolution\" [16]"),
    );
    place.write("veachMIS_L.exr", "somebody's own");
    let ran = place.run("small.pbrt");
    ran.expect_code(0).expect_err(&["veachMIS_L_2.exr: light", "veachMIS_L.exr: was there before and is kept"]);
    assert_eq!(std::fs::read_to_string(place.path("veachMIS_L.exr")).expect("is there"), "somebody's own");
    assert_eq!(place.image("veachMIS_L_2.exr").display.size, [16, 16]);
    assert!(!place.files().contains(&"veachMIS_BSDF_2.exr".to_owned()), "what is free keeps its name");
    place.run("small.pbrt").expect_code(0);
    assert_eq!(place.image("veachMIS_BSDF_2.exr").attribute("strategy"), Some("bsdf"), "nor those of the run before");
}
