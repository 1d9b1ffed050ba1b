//! Materials, their defaults and names.

use glam::Vec3;
use mislab_renderer::{Bsdf, Reflectance};

use crate::{assert_failure, assert_no_warnings, parse, world};

fn bsdf(material: &str) -> Bsdf {
    let file = parse(&world(&format!("Material {material}\nShape \"sphere\"")));
    assert_no_warnings(&file);
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
    let Bsdf::Plastic { kd, ks, alpha } = bsdf("\"plastic\"") else { panic!("plastic") };
    assert_eq!((kd, ks), (Vec3::splat(0.25), Vec3::splat(0.25)));
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
    let (message, bsdf) =
        warning("\"metal\" \"float uroughness\" .1 \"float vroughness\" .4 \"bool remaproughness\" false");
    assert!(
        message.contains("0.2000") && (bsdf.alpha().unwrap_or(0.0) - 0.2).abs() < 1e-6,
        "geometric mean: {message}"
    );
    assert_eq!(warning("\"plastic\" \"float roughness\" 1").1.alpha(), Some(1.0));
    assert_eq!(warning("\"glass\" \"float index\" 1.5").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(warning("\"matte\" \"rgb Kd\" [.5 .5 2]").1, Bsdf::Matte { kd: Vec3::new(0.5, 0.5, 1.0) });
    assert_eq!(warning("\"matte\" \"texture Kd\" \"wood\"").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert_eq!(warning("\"matte\" \"spectrum Kd\" [400 .1 700 .9]").1, Bsdf::Matte { kd: Vec3::splat(0.5) });
    assert!(warning("\"matte\" \"float sigma\" 20").0.contains("sigma"));
    assert!(warning("\"matte\" \"rgb kd\" [1 1 1]").0.contains("did you mean \"Kd\""));
    assert_failure(&world("Material \"matte\" \"rgb Kd\" [-1 0 0]"), 3, 28, &["Kd", "-1 0 0", "negative"]);
    assert_failure(&world("Material \"matte\" \"rgb Kd\" [1 1]"), 3, 27, &["2 values", "expected 3"]);
    assert_failure(&world("Material \"matte\" \"rgb Kd\" .5"), 3, 27, &["1 value", "expected 3"]);
    assert_failure(&world("Material \"matte\" \"float Kd\" .5"), 3, 18, &["float Kd", "expected", "rgb Kd"]);
    assert_failure(&world("Material \"metal\" \"float roughness\" -1"), 3, 36, &["roughness -1"]);
    assert_failure(&world("Material \"metal\" \"float roughness\" \"rough\""), 3, 36, &["rough", "number"]);
    assert_failure(&world("Material \"metal\" \"bool remaproughness\" \"no\""), 3, 40, &["no", "true"]);
    assert_failure(&world("Material \"metal\" \"rgb k\" [1 1 1e8]"), 3, 27, &["\"k\"", "at most 1e6"]);
    assert_failure(&world("Material"), 3, 1, &["Material", "text in quotes"]);
}

#[test]
fn material_names() {
    let file = parse(&world(
        "MakeNamedMaterial \"unused\" \"string type\" \"matte\"
         MakeNamedMaterial \"gloss\" \"string type\" \"mirror\"
         NamedMaterial \"gloss\" Shape \"sphere\" Shape \"sphere\"
         Material \"matte\" \"rgb Kd\" [0 1 0] Shape \"sphere\"
         AttributeBegin Material \"matte\" \"rgb Kd\" [0 1 0] Shape \"sphere\" AttributeEnd
         Material \"matte\" \"rgb Kd\" [0 0 1] Shape \"sphere\"
         MakeNamedMaterial \"gloss\" \"string type\" \"plastic\"
         NamedMaterial \"gloss\" Shape \"sphere\"",
    ));
    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["gloss", "material1", "material2", "gloss_2"]);
    let used: Vec<Option<usize>> = file.scene.shapes.iter().map(|s| s.material).collect();
    assert_eq!(used, [Some(0), Some(0), Some(1), Some(1), Some(2), Some(3)]);
    assert_eq!(file.warnings.len(), 1, "defined again: {:?}", file.warnings);
    assert_failure(&world("NamedMaterial \"gloss\""), 3, 1, &["gloss", "MakeNamedMaterial"]);
    assert_failure(&world("MakeNamedMaterial \"gloss\""), 3, 1, &["string type"]);
    // A name taken by the file is not given again.
    let file = parse(&world(
        "Shape \"sphere\" MakeNamedMaterial \"material1\" \"string type\" \"mirror\" NamedMaterial \"material1\" Shape \"sphere\"",
    ));
    let names: Vec<&str> = file.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["material2", "material1"]);
}
