//! Directives before `WorldBegin`.

use mislab_renderer::{Heuristic, OneSampleWeights, SamplerKind, Settings, Strategy};

use crate::{assert_failure, assert_left_out, assert_no_warnings, assert_warning, parse, warnings, world};

fn settings(header: &str) -> Settings {
    let file = parse(&format!("{header}\nCamera \"perspective\"\nWorldBegin WorldEnd"));
    assert_no_warnings(&file);
    file.settings
}

#[test]
fn absent_directives_and_parameters() {
    let file = parse("Camera \"perspective\" WorldBegin WorldEnd");
    assert_no_warnings(&file);
    assert_eq!((file.settings.estimator, file.film_filename.as_str()), (Settings::default().estimator, "pbrt.exr"));
    assert_eq!(file.settings.image.resolution, [1280, 720]);
    assert_eq!(
        (file.settings.sampling.sampler.kind, file.settings.sampling.target()),
        (SamplerKind::Lattice, Some(16))
    );
    assert_eq!((file.scene.camera.fov_deg, file.scene.camera.screen_window), (90.0, None));
    // pbrt's defaults for what a directive leaves out.
    assert_eq!(settings("Film \"image\"").image.resolution, [1280, 720]);
    let s = settings("Sampler \"stratified\"");
    assert_eq!(
        (s.sampling.sampler.strata, s.sampling.sampler.jitter, s.sampling.spp.map(|n| n.get())),
        ([4, 4], true, Some(16))
    );
    assert_eq!(settings("Sampler \"random\"").sampling.spp.map(|n| n.get()), Some(4));
}

#[test]
fn film() {
    let s =
        settings(r#"Film "image" "integer xresolution" 40 "integer yresolution" [30] "float cropwindow" [.5 0 .25 1]"#);
    assert_eq!((s.image.resolution, s.image.crop), ([40, 30], [0.0, 0.5, 0.25, 1.0]));
    // The last one wins as a whole.
    let twice =
        "Film \"image\" \"integer xresolution\" 40\nFilm \"image\" \"integer yresolution\" 30\nCamera \"perspective\"";
    let file = assert_warning(twice, 2, 1, &["Film once more", "after that of line 1", "this one counts, as a whole"]);
    assert_eq!(file.settings.image.resolution, [1280, 30]);
    assert_failure("Film \"image\"\n \"integer xresolution\" [0]", 2, 25, &["xresolution", "0", "from 1 to"]);
    assert_failure("Film \"image\"\n \"integer xresolution\" [100000]", 2, 25, &["100000", "1 to 65536"]);
    assert_failure("Film \"image\" \"float cropwindow\" [.5 .5 0 1]", 1, 34, &["crop window", "x0 < x1"]);
    assert_failure("Film \"image\" \"float cropwindow\" [2 3 0 1]", 1, 34, &["2 3 0 1", "no pixel"]);
    let crop = "Film \"image\" \"float cropwindow\" [-1 .5 0 1.5]\nCamera \"perspective\" WorldBegin WorldEnd";
    let file = assert_warning(crop, 1, 34, &["-1 0.5 0 1.5", "cut to 0 0.5 0 1"]);
    assert_eq!(file.settings.image.crop, [0.0, 0.5, 0.0, 1.0]);
    assert_failure("Film \"image\" \"integer xresolution\" [2147483648]", 1, 37, &["2147483648", "1 to 65536"]);
    assert_failure("Sampler \"random\" \"integer pixelsamples\" [2147483648]", 1, 42, &["1 to 2147483647"]);
    assert_failure("Sampler \"stratified\" \"integer xsamples\" [2147483648]", 1, 42, &["1 to 65536"]);
    assert_failure("Film \"image\" \"float cropwindow\" [0 1 0]", 1, 33, &["3 values", "expected 4"]);
}

#[test]
fn what_is_given_again_counts_and_is_said() {
    let text = "Camera \"perspective\" \"float fov\" 30\nSampler \"random\"\nSampler \"sobol\" \"integer pixelsamples\" 2\n\
                Camera \"perspective\" \"float fov\" 40 \"float fov\" 50\nWorldBegin\n\
                Material \"matte\" \"rgb Kd\" [1 0 0] \"rgb Kd\" [0 1 0]\nWorldEnd";
    let file = parse(text);
    let places: Vec<(u32, u32)> = warnings(&file).iter().map(|w| (w.0, w.1)).collect();
    assert_eq!(places, [(3, 1), (4, 37), (4, 1), (6, 35)], "{:?}", warnings(&file));
    assert!(warnings(&file)[1].2.contains("Camera \"perspective\": parameter \"fov\" is given again; this one counts"));
    assert_eq!((file.scene.camera.fov_deg, file.settings.sampling.target()), (50.0, Some(2)));
}

#[test]
fn samplers() {
    for jitter in ["[\"false\"]", "[false]", "\"false\"", "false"] {
        let s = settings(&format!(
            "Sampler \"stratified\" \"bool jitter\" {jitter} \"integer xsamples\" [3] \"integer ysamples\" 5"
        ));
        assert_eq!(
            (s.sampling.sampler.strata, s.sampling.sampler.jitter, s.sampling.spp.map(|n| n.get())),
            ([3, 5], false, Some(15))
        );
    }
    let s = settings("Sampler \"random\" \"integer pixelsamples\" [12]");
    assert_eq!(
        (s.sampling.sampler.kind, s.sampling.sampler.strata, s.sampling.spp.map(|n| n.get())),
        (SamplerKind::Independent, [3, 4], Some(12))
    );
    let s = settings("Sampler \"sobol\" \"integer pixelsamples\" [32]");
    assert_eq!((s.sampling.sampler.kind, s.sampling.spp.map(|n| n.get())), (SamplerKind::Sobol, Some(32)));
    let s = settings("Sampler \"padded_sobol\" \"integer pixelsamples\" [32]");
    assert_eq!((s.sampling.sampler.kind, s.sampling.spp.map(|n| n.get())), (SamplerKind::PaddedSobol, Some(32)));
    let s = settings("Sampler \"lattice\" \"integer pixelsamples\" [32]");
    assert_eq!((s.sampling.sampler.kind, s.sampling.spp.map(|n| n.get())), (SamplerKind::Lattice, Some(32)));
    let s = settings(
        "Sampler \"padded_stratified\" \"bool jitter\" \"false\" \"integer xsamples\" [3] \"integer ysamples\" 5",
    );
    assert_eq!(
        (
            s.sampling.sampler.kind,
            s.sampling.sampler.strata,
            s.sampling.sampler.jitter,
            s.sampling.spp.map(|n| n.get())
        ),
        (SamplerKind::PaddedStratified, [3, 5], false, Some(15))
    );
    for other in ["halton", "02sequence", "lowdiscrepancy", "maxmindist"] {
        let file = parse(&format!(
            "Sampler \"{other}\" \"integer pixelsamples\" [32]\nCamera \"perspective\" WorldBegin WorldEnd"
        ));
        assert_eq!(
            (file.settings.sampling.sampler.kind, file.settings.sampling.spp.map(|n| n.get())),
            (SamplerKind::Sobol, Some(32))
        );
        assert_eq!(file.warnings.len(), 1);
    }
    assert_failure("Sampler \"stratified\" \"integer xsamples\" [0]", 1, 42, &["xsamples", "from 1 to"]);
    assert_failure(
        "Sampler \"stratified\" \"integer xsamples\" [300]\n\"integer ysamples\" [300]",
        1,
        22,
        &["300 x 300"],
    );
    assert_failure("Sampler \"random\" \"integer pixelsamples\" [2.5]", 1, 42, &["2.5", "whole number"]);
}

#[test]
fn integrators() {
    let s = settings(
        "Integrator \"veachMIS\" \"string MISstrategy\" \"mis\" \"float lightprob\" [0.25] \"string heuristic\" [\"power\"] \"string weights\" \"tutorial\"",
    );
    assert_eq!((s.estimator.strategy, s.estimator.light_prob), (Strategy::Mis, 0.25));
    assert_eq!((s.estimator.heuristic, s.estimator.weights), (Heuristic::Power, OneSampleWeights::Tutorial));
    // The last one wins, with everything it leaves out.
    let twice = "Integrator \"veachMIS\" \"string heuristic\" \"cutoff\"\nSurfaceIntegrator \"veachMIS\" \"string MISstrategy\" \"bsdf\"";
    let s = assert_warning(
        &format!("{twice} Camera \"perspective\""),
        2,
        1,
        &["SurfaceIntegrator after the Integrator of line 1", "this one counts"],
    )
    .settings;
    assert_eq!((s.estimator.strategy, s.estimator.heuristic), (Strategy::Bsdf, Heuristic::Balance));
    let file = parse("Integrator \"path\" \"integer maxdepth\" [5]\nCamera \"perspective\" WorldBegin WorldEnd");
    assert_eq!(file.settings.estimator.strategy, Strategy::MisAll);
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    assert!(file.warnings[0].message.contains("veachMIS"));
    assert_eq!(file.foreign_integrator.as_deref(), Some("path"));
    assert_failure(
        "Integrator \"veachMIS\"\n  \"string MISstrategy\" [\"brdf\"]",
        2,
        25,
        &["brdf", "light, bsdf, mis_all, mis"],
    );
    assert_failure("Integrator \"veachMIS\" \"float lightprob\" [1.5]", 1, 42, &["1.5", "[0, 1]"]);
    assert_failure(
        "Integrator \"veachMIS\" \"string heuristic\" [\"max\"]",
        1,
        43,
        &["balance, power, cutoff, maximum"],
    );
}

#[test]
fn pixel_filters() {
    settings("PixelFilter \"box\" \"float xwidth\" [0.5]");
    for other in ["\"gaussian\"", "\"box\" \"float xwidth\" [2]"] {
        let file = parse(&format!("PixelFilter {other} Camera \"perspective\" WorldBegin WorldEnd"));
        assert_eq!(file.warnings.len(), 1);
        assert!(file.warnings[0].message.contains("box of one pixel"));
    }
}

#[test]
fn cameras() {
    let camera =
        |parameters: &str| parse(&format!("Camera \"perspective\" {parameters} WorldBegin WorldEnd")).scene.camera;
    assert_eq!(camera("\"float fov\" 30").fov_deg, 30.0);
    assert_eq!(camera("\"float halffov\" 20").fov_deg, 40.0);
    assert_eq!(camera("\"float fov\" 30 \"float fov\" 50").fov_deg, 50.0, "the last one counts");
    assert_eq!(camera("\"float screenwindow\" [-1 1 -.5 .5]").screen_window, Some([-1.0, 1.0, -0.5, 0.5]));
    assert_eq!(camera("\"float frameaspectratio\" 2").screen_window, Some([-2.0, 2.0, -1.0, 1.0]));
    assert_eq!(camera("\"float frameaspectratio\" .5").screen_window, Some([-1.0, 1.0, -2.0, 2.0]));
    assert_failure("Camera \"perspective\" \"float fov\" [180]", 1, 35, &["180", "less than 180"]);
    assert_failure("Camera \"perspective\" \"float screenwindow\" [1 1 0 1]", 1, 44, &["screenwindow"]);
    assert_left_out("\nScale 1 0 1", 2, 1, &["Scale", "inverse"]);
    let file = parse("Camera \"perspective\" \"float lensradius\" 0.1 \"float focaldistance\" 3 WorldBegin WorldEnd");
    assert_eq!(file.warnings.len(), 2);
}

#[test]
fn misplaced_header_is_read_with_a_warning() {
    let file = parse(&world("Integrator \"veachMIS\" \"string MISstrategy\" \"mis\""));
    assert_eq!(file.settings.estimator.strategy, Strategy::Mis);
    assert_eq!(warnings(&file), [(3, 1, "Integrator belongs before WorldBegin; it is read all the same")]);
}
