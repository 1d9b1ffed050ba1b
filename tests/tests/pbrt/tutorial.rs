//! The tutorial's headers, as printed and as copied from a PDF.

use glam::DVec4;
use mislab_renderer::{SamplerKind, Scene, Strategy, pbrt};

use crate::{parse, warnings};

const HEADER_LIGHT: &str = r#"Sampler "stratified" "integer xsamples" [8] "integer ysamples"
[8] "bool jitter" ["true"]
Integrator "veachMIS" "string MISstrategy" ["light"]
Film "image" "string filename" ["veachMIS_L.exr"] "integer
xresolution" [800] "integer yresolution" [800]
"#;

const HEADER_BSDF: &str = r#"Integrator "veachMIS" "string MISstrategy" ["bsdf"]
Film "image" "string filename" ["veachMIS_BSDF.exr"] "integer
xresolution" [800] "integer yresolution" [800]
"#;

pub const HEADER_MIS_ALL: &str = r#"Sampler "stratified" "integer xsamples" [6] "integer ysamples"
[6] "bool jitter" ["true"]
Film "image" "string filename" ["veach_MIS_ALLx36.exr"] "integer
xresolution" [600] "integer yresolution" [600]
SurfaceIntegrator "veachMIS" "string sample_method" ["mis_all"]
"#;

const HEADER_MIS: &str = r#"Integrator "veachMIS" "string MISstrategy" ["mis"]
Film "image" "string filename" ["veachMIS_MIS.exr"] "integer
xresolution" [800] "integer yresolution" [800]
"#;

/// A header in front of the shipped scene, whose own one is replaced by it.
fn with_header(header: &str) -> String {
    let (own, body) = pbrt::DEFAULT_SCENE.split_once("WorldBegin").expect("a world");
    format!("{own}\n{header}\nWorldBegin{body}")
}

#[test]
fn tutorial_headers_work_as_printed() {
    let cases = [
        (HEADER_LIGHT, Strategy::Light, "veachMIS_L.exr", 64, 800),
        (HEADER_BSDF, Strategy::Bsdf, "veachMIS_BSDF.exr", 64, 800),
        (HEADER_MIS_ALL, Strategy::MisAll, "veach_MIS_ALLx36.exr", 36, 600),
        (HEADER_MIS, Strategy::Mis, "veachMIS_MIS.exr", 64, 800),
    ];
    let quotes: [fn(&str) -> String; 6] = [
        |h| h.to_owned(),
        |h| alternate(h, ['“', '”']),
        |h| alternate(h, ['„', '“']),
        |h| alternate(h, ['«', '»']),
        |h| alternate(h, ['”', '"']),
        |h| alternate(h, ['‘', '’']),
    ];
    for (header, strategy, filename, spp, size) in cases {
        for (i, quote) in quotes.iter().enumerate() {
            let file = parse(&with_header(&quote(header)));
            assert_eq!(file.settings.estimator.strategy, strategy);
            assert_eq!(file.film_filename, filename);
            assert_eq!(file.settings.sampling.spp.map(|n| n.get()), Some(spp));
            assert_eq!(file.settings.sampling.sampler.kind, SamplerKind::Stratified);
            assert!(file.settings.sampling.sampler.jitter);
            assert_eq!(file.settings.image.resolution, [size, size]);
            assert_eq!(file.scene, Scene { name: "test".to_owned(), ..pbrt::embedded_scene().scene });
            // That the file's own header does not count, and one about quotes.
            let (again, quotes): (Vec<_>, Vec<_>) =
                file.warnings.iter().partition(|w| w.message.contains("this one counts"));
            assert!((2..=3).contains(&again.len()), "Integrator, Film and for some headers the Sampler: {again:?}");
            assert_eq!(quotes.len(), usize::from(i > 0), "{quotes:?}");
        }
    }
}

/// Replaces straight quotes by an opening and a closing one in turn.
fn alternate(text: &str, quotes: [char; 2]) -> String {
    let mut count = 0;
    text.chars()
        .map(|c| {
            if c == '"' {
                count += 1;
                quotes[(count + 1) % 2]
            } else {
                c
            }
        })
        .collect()
}

#[test]
fn header_alone_is_an_empty_scene() {
    let file = parse(HEADER_LIGHT);
    assert_eq!(file.settings.estimator.strategy, Strategy::Light);
    assert!(file.scene.shapes.is_empty());
    assert!(file.warnings.iter().any(|w| w.message.contains("WorldBegin")));
}

#[test]
fn what_copying_brings_is_read() {
    // Byte order mark, CRLF, no-break spaces, soft hyphen and line break inside a quoted text,
    // ligature, typographic minus and dash.
    let text = "\u{feff}Film\u{a0}\"image\"\r\n\u{a0}\"string \u{fb01}lename\" [\"a.exr\"] \"integer\r\n  x\u{ad}resolution\" [20]\r\n\
                \"integer yresolution\" [10]\r\nTranslate \u{2212}1 \u{2013}2 3\r\nCamera \"perspective\"\r\nWorldBegin WorldEnd";
    let file = parse(text);
    assert_eq!((file.film_filename.as_str(), file.settings.image.resolution), ("a.exr", [20, 10]));
    assert_eq!(file.scene.camera.world_from_camera.w_axis, DVec4::new(1.0, 2.0, -3.0, 1.0));
    let found = warnings(&file);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!((found[0].0, found[0].1), (2, 2));
    assert!(found[0].2.contains("ligature"));
    assert_eq!((found[1].0, found[1].1), (5, 11));
    assert!(found[1].2.contains("minus"));
}

#[test]
fn quotes_of_the_other_kind_are_content() {
    let file = parse("Film \"image\" \"string filename\" \"student's.exr\" Camera 'perspective' WorldBegin WorldEnd");
    assert_eq!(file.film_filename, "student's.exr");
    let file = parse("Film \"image\" \"string filename\" \"two  spaces.exr\" WorldBegin WorldEnd");
    assert_eq!(file.film_filename, "two  spaces.exr");
    let file = parse(r#"Film "image" "string filename" "a\"b\\c\d.exr" WorldBegin WorldEnd"#);
    assert_eq!(file.film_filename, r#"a"b\c\d.exr"#);
}
