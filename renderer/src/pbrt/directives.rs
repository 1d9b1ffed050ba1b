//! What can stand in a scene file.

/// The directives that are read.
pub(super) const DIRECTIVES: [&str; 31] = [
    "AreaLightSource",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Include",
    "Integrator",
    "LookAt",
    "MakeNamedMaterial",
    "Material",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "SurfaceIntegrator",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "Translate",
    "WorldBegin",
    "WorldEnd",
];

/// Others of pbrt-v3, which are left out.
const NOT_READ: [&str; 7] = [
    "Accelerator",
    "ActiveTransform",
    "LightSource",
    "MakeNamedMedium",
    "MediumInterface",
    "Texture",
    "TransformTimes",
];

/// Others of pbrt-v4.
pub(super) const OF_V4: [&str; 3] = ["Attribute", "ColorSpace", "Option"];

/// True for a directive of any pbrt.
pub(super) fn is_known(word: &str) -> bool {
    DIRECTIVES.contains(&word) || NOT_READ.contains(&word) || OF_V4.contains(&word)
}

/// Those that say what is computed. A mistake in one of them is no matter of a part of the picture: it is an error.
pub(super) const SETTINGS: [&str; 6] = ["Camera", "Film", "Integrator", "PixelFilter", "Sampler", "SurfaceIntegrator"];
