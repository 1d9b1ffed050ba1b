//! Materials, their defaults and names.

use glam::Vec3;
use mislab_renderer::{Bsdf, Reflectance};

use crate::{assert_left_out, assert_no_warnings, assert_warning, parse, world};

fn bsdf(material: &str) -> Bsdf {
    let file = parse(&world(&format!("Material {material}\nShape \"sphere\"")));
    let plastic = usize::from(material.starts_with("\"plastic\""));
    assert_eq!(file.warnings.len(), plastic, "{:?}", file.warnings);
    file.scene.materials[0].bsdf.clone()
}

#[test]
fn materials_and_their_defaults() {
    assert_eq!(bsdf("\"matte\""), Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(bsdf("\"matte\" \"color Kd\" [.1 .2 .3]"), Bsdf::Matte { kd: Vec3::new(0.1, 0.2, 0.3) });
    let mirror = |kr| Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::splat(kr)), alpha: 0.0 };
    assert_eq!(bsdf("\"mirror\""), mirror(0.9));
    assert_eq!(bsdf("\"mirror\" \"rgb Kr\" [1 1 1]"), mirror(1.0));
    let Bsdf::Conductor { reflectance: Reflectance::Fresnel { eta, k }, alpha } = bsdf("\"metal\"") else {
        panic!("a conductor")
    };
    assert!((eta - Vec3::new(0.200, 0.924, 1.102)).abs().max_element() < 1e-3, "copper");
    assert!((k - Vec3::new(3.913, 2.453, 2.142)).abs().max_element() < 1e-3, "copper");
    assert!((alpha - 0.13892).abs() < 1e-5, "roughness 0.01 remapped: {alpha}");
    let Bsdf::Plastic { kd, ks, alpha, swapped_indices } = bsdf("\"plastic\"") else { panic!("plastic") };
    assert_eq!((kd, ks, swapped_indices), (Vec3::splat(0.25), Vec3::splat(0.25), false));
    assert!((alpha - 0.46176).abs() < 1e-5, "roughness 0.1 remapped: {alpha}");
    let raw = "\"metal\" \"float roughness\" 0.3 \"bool remaproughness\" false";
    assert_eq!(bsdf(raw).alpha(), Some(0.3));
    assert_eq!(bsdf("\"metal\" \"float roughness\" 0 \"bool remaproughness\" false").alpha(), Some(0.0));
    // XYZ of Rec. 709 red.
    let Bsdf::Matte { kd } = bsdf("\"matte\" \"xyz Kd\" [0.412453 0.212671 0.019334]") else { panic!("matte") };
    assert!((kd - Vec3::X).abs().max_element() < 1e-4, "{kd}");
}

#[test]
fn material_warnings_and_errors() {
    let warning = |material: &str| {
        let file = parse(&world(&format!("Material {material}\nShape \"sphere\"")));
        assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
        (file.warnings[0].message.clone(), file.scene.materials[0].bsdf.clone())
    };
    let (message, mean) =
        warning("\"metal\" \"float uroughness\" .1 \"float vroughness\" .4 \"bool remaproughness\" false");
    assert!(
        message.contains("0.2000") && (mean.alpha().unwrap_or(0.0) - 0.2).abs() < 1e-6,
        "geometric mean: {message}"
    );
    let plastic = "\"plastic\" \"bool pbrtfresnel\" \"false\" \"float roughness\" 1";
    assert_eq!(warning(plastic).1.alpha(), Some(1.0));
    assert_eq!(warning("\"glass\" \"float index\" 1.5").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(warning("\"matte\" \"rgb Kd\" [.5 .5 2]").1, Bsdf::Matte { kd: Vec3::new(0.5, 0.5, 1.0) });
    assert_eq!(warning("\"matte\" \"texture Kd\" \"wood\"").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(warning("\"matte\" \"spectrum Kd\" [400 .1 700 .9]").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert!(warning("\"matte\" \"float sigma\" 20").0.contains("sigma"));
    assert!(warning("\"matte\" \"rgb kd\" [1 1 1]").0.contains("did you mean \"Kd\""));
    // Another program's materials have a colour too.
    assert_eq!(warning("\"uber\" \"rgb Kd\" [.1 .2 .3]").1, Bsdf::Matte { kd: Vec3::new(0.1, 0.2, 0.3) });
    assert!(warning("\"plastik\"").0.contains("did you mean \"plastic\""));
    // A parameter that cannot be has its default.
    let default = |parameters: &str, column: u32, words: &[&str]| {
        let words = [words, &["default is used"]].concat();
        let text = world(&format!("Material \"matte\" {parameters} Shape \"sphere\""));
        let file = assert_warning(&text, 3, column, &words);
        assert_eq!(file.scene.materials[0].bsdf, Bsdf::Matte { kd: Vec3::splat(0.5) });
    };
    default("\"rgb Kd\" [-1 0 0]", 28, &["Kd", "-1 0 0", "negative"]);
    default("\"rgb Kd\" [1 1]", 27, &["2 values", "expected 3"]);
    default("\"rgb Kd\" .5", 27, &["1 value", "expected 3"]);
    default("\"float Kd\" .5", 18, &["float Kd", "expected", "rgb Kd"]);
    let metal = |parameters: &str, column: u32, words: &[&str]| {
        let file =
            assert_warning(&world(&format!("Material \"metal\" {parameters} Shape \"sphere\"")), 3, column, words);
        file.scene.materials[0].bsdf.clone()
    };
    let alpha = bsdf("\"metal\"").alpha();
    assert_eq!(metal("\"float roughness\" -1", 36, &["roughness -1"]).alpha(), alpha);
    assert_eq!(metal("\"float roughness\" \"rough\"", 36, &["rough", "number"]).alpha(), alpha);
    assert_eq!(metal("\"bool remaproughness\" \"no\"", 40, &["no", "true"]).alpha(), alpha);
    let Bsdf::Conductor { reflectance: Reflectance::Fresnel { k, .. }, .. } =
        metal("\"rgb k\" [1 1 1e8]", 27, &["\"k\"", "cut to 1e6"])
    else {
        panic!("a metal")
    };
    assert_eq!(k, Vec3::new(1.0, 1.0, 1e6));
    assert_left_out(&world("Material \"matte\" \"Kd\" [1 1 1]"), 3, 18, &["\"Kd\"", "type name"]);
    assert_left_out(&world("Material"), 3, 1, &["Material", "text in quotes"]);
}

#[test]
fn plastic_says_that_pbrts_differs() {
    let file = parse(&world(
        "Material \"plastic\" Shape \"sphere\" Material \"plastic\" \"rgb Kd\" [1 0 0] Shape \"sphere\" \"float radius\" 2",
    ));
    assert_eq!(file.warnings.len(), 1, "said once: {:?}", file.warnings);
    let message = &file.warnings[0].message;
    for words in ["pbrt-v3", "swapped", "\"bool pbrtfresnel\" \"true\""] {
        assert!(message.contains(words), "{message}");
    }
    for (value, expected) in [("true", true), ("false", false)] {
        let file = parse(&world(&format!("Material \"plastic\" \"bool pbrtfresnel\" \"{value}\" Shape \"sphere\"")));
        assert_no_warnings(&file);
        let Bsdf::Plastic { swapped_indices, .. } = file.scene.materials[0].bsdf else { panic!("plastic") };
        assert_eq!(swapped_indices, expected);
    }
}

#[test]
fn shapes_of_no_material_are_not_there() {
    for nothing in ["\"\"", "\"none\""] {
        assert_left_out(&world(&format!("Material {nothing}\nShape \"sphere\"")), 4, 1, &["border"]);
        let file = parse(&world(&format!("Material {nothing} AreaLightSource \"diffuse\" Shape \"sphere\"")));
        assert_no_warnings(&file);
        assert_eq!(file.scene.shapes[0].material, None, "a light shines all the same");
    }
}

#[test]
fn material_names() {
    let file = parse(&world(
        "MakeNamedMaterial \"unused\" \"string type\" \"matte\"
         MakeNamedMaterial \"gloss\" \"string type\" \"mirror\"
         NamedMaterial \"gloss\" Shape \"sphere\" \"float radius\" 1 Shape \"sphere\" \"float radius\" 2
         Material \"matte\" \"rgb Kd\" [0 1 0] Shape \"sphere\" \"float radius\" 3
         AttributeBegin Material \"matte\" \"rgb Kd\" [0 1 0] Shape \"sphere\" \"float radius\" 4 AttributeEnd
         Material \"matte\" \"rgb Kd\" [0 0 1] Shape \"sphere\" \"float radius\" 5
         MakeNamedMaterial \"gloss\" \"string type\" \"plastic\" \"bool pbrtfresnel\" false
         NamedMaterial \"gloss\" Shape \"sphere\" \"float radius\" 6",
    ));
    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["gloss", "material1", "material2", "gloss_2"]);
    let used: Vec<Option<usize>> = file.scene.shapes.iter().map(|s| s.material).collect();
    assert_eq!(used, [Some(0), Some(0), Some(1), Some(1), Some(2), Some(3)]);
    assert_eq!(file.warnings.len(), 1, "defined again: {:?}", file.warnings);
    assert_left_out(&world("NamedMaterial \"gloss\""), 3, 1, &["gloss", "MakeNamedMaterial"]);
    assert_left_out(&world("MakeNamedMaterial \"gloss\""), 3, 1, &["string type"]);
    // A name taken by the file is not given again.
    let file = parse(&world(
        "Shape \"sphere\" MakeNamedMaterial \"material1\" \"string type\" \"mirror\" NamedMaterial \"material1\" Shape \"sphere\"",
    ));
    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["material2", "material1"]);
}
