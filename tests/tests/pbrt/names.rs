//! Wrong names: what would give another picture than the one that is meant is an error, other programs' names are not.

use mislab_renderer::{Strategy, pbrt};

use crate::{assert_failure, parse, warnings};

/// A file with this header.
fn with(header: &str) -> String {
    format!("{header}\nCamera \"perspective\" WorldBegin WorldEnd")
}

#[test]
fn a_misspelt_integrator_is_an_error() {
    for name in
        ["veachMis", "VeachMIS", "veach MIS", "veach_mis", "vetchMIS", "veachMISS", "veach", "veachMIS2", "vaechMIS"]
    {
        let header = format!("Film \"image\"\n Integrator \"{name}\" \"string MISstrategy\" [\"light\"]");
        assert_failure(&with(&header), 2, 2, &[name, "did you mean \"veachMIS\""]);
        assert_failure(&with(&format!("SurfaceIntegrator \"{name}\"")), 1, 1, &["did you mean \"veachMIS\""]);
    }
    for (name, meant) in
        [("pathh", "path"), ("Path", "path"), ("directlightning", "directlighting"), ("volpaht", "volpath")]
    {
        assert_failure(&with(&format!("Integrator \"{name}\"")), 1, 1, &[name, &format!("did you mean \"{meant}\"")]);
    }
    assert_failure(&with("Integrator \"mis_all\""), 1, 1, &["veachMIS", "\"string MISstrategy\" \"mis_all\""]);
    for directive in ["Integrater", "integrator", "Intergrator", "SurfaceIntegrater", "Sampeler"] {
        let text = with(&format!("{directive} \"veachMIS\" \"string MISstrategy\" [\"light\"]"));
        let meant = if directive.starts_with("integrator") { "expected a directive" } else { "did you mean" };
        assert_failure(&text, 1, 1, &[directive, meant]);
    }
}

#[test]
fn misspelt_shapes_and_materials_are_left_out_and_guessed() {
    let with = |directive: &str| format!("Camera \"perspective\" WorldBegin\n{directive}\nWorldEnd");
    for (name, meant) in [("Sphere", "sphere"), ("trianglemash", "trianglemesh"), ("ply_mesh", "plymesh")] {
        let guess = format!("did you mean \"{meant}\"");
        crate::assert_left_out(&with(&format!("Shape \"{name}\"")), 2, 1, &[name, &guess]);
    }
    crate::assert_warning(&with("Material \"mate\""), 2, 1, &["did you mean \"matte\""]);
    let named = "MakeNamedMaterial \"plate1\" \"string type\" \"matte\"\nNamedMaterial \"plaet1\"";
    crate::assert_left_out(&with(named), 3, 1, &["\"plaet1\"", "did you mean \"plate1\""]);
}

#[test]
fn a_misspelt_parameter_of_it_is_an_error() {
    let cases = [
        ("string MISstrategie", "MISstrategy"),
        ("string misstrategy", "MISstrategy"),
        ("string strategy", "MISstrategy"),
        ("string samplemethod", "sample_method"),
        ("string heuristics", "heuristic"),
        ("string weight", "weights"),
        ("float light_prob", "lightprob"),
        ("float lightprobability", "lightprob"),
    ];
    for (parameter, meant) in cases {
        let value = if parameter.starts_with("float") { "0.3" } else { "\"light\"" };
        let text = with(&format!("Integrator \"veachMIS\"\n\"{parameter}\" {value}"));
        assert_failure(&text, 2, 1, &[&format!("did you mean \"{meant}\"")]);
    }
    // As are those that say how many samples there are.
    assert_failure(&with("Sampler \"random\" \"integer pixelsample\" 9"), 1, 18, &["did you mean \"pixelsamples\""]);
    assert_failure(&with("Sampler \"stratified\" \"integer xsample\" 9"), 1, 22, &["did you mean \"xsamples\""]);
    // A parameter of another integrator is none of ours.
    let file = parse(&with("Integrator \"veachMIS\" \"integer maxdepth\" 5 \"string lightsamplestrategy\" \"power\""));
    assert_eq!(warnings(&file).len(), 2);
    assert_eq!(file.foreign_integrator, None);
}

#[test]
fn another_programs_integrator_stands_in_the_pictures_name() {
    for name in ["path", "directlighting", "bdpt", "volpath", "whitted", "mlt", "sppm", "ao", "myown"] {
        let file = parse(&with(&format!("Integrator \"{name}\" \"integer maxdepth\" 5")));
        assert_eq!(file.settings.estimator.strategy, Strategy::MisAll);
        let found = warnings(&file);
        assert!(found.len() == 1 && found[0].2.contains(name) && found[0].2.contains("mis_all"), "{found:?}");
        assert_eq!(file.foreign_integrator.as_deref(), Some(name));
    }
    // The last one counts.
    let file = parse(&with("Integrator \"path\"\nIntegrator \"veachMIS\" \"string MISstrategy\" \"bsdf\""));
    assert_eq!(file.foreign_integrator, None);
    for (filename, expected) in
        [("a.exr", "a_mis_all.exr"), ("out/a.b.png", "out/a.b_mis_all.png"), ("plain", "plain_mis_all")]
    {
        assert_eq!(pbrt::name_with_strategy(filename, Strategy::MisAll), expected);
    }
    assert_eq!(pbrt::name_with_strategy("a.exr", Strategy::Bsdf), "a_bsdf.exr");
}
