//! Materials: pbrt's parameters and defaults to [`Bsdf`], names, and which of them are used.

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use mislab_kernel::request::scene::{Bsdf, Material, Reflectance};

use super::log::{Log, Pos, shown};
use super::params::{At, Params};
use crate::error::Error;
use crate::near::suggestion;

/// What pbrt uses where no material is given.
const DEFAULT_MATTE: Bsdf = Bsdf::Matte { kd: Vec3::splat(0.5) };

/// The metal of pbrt-v3 by default: copper, its measured spectra as linear Rec. 709.
const COPPER_ETA: Vec3 = Vec3::new(0.200_438, 0.924_033, 1.102_212);
const COPPER_K: Vec3 = Vec3::new(3.912_949, 2.452_848, 2.142_188);

/// The largest index of a metal: beyond it the fourth powers in Fresnel's equations lose all meaning.
const MAX_INDEX: f32 = 1e6;

/// Materials of pbrt-v4 that have no counterpart here.
const OF_V4: [&str; 8] = [
    "coatedconductor",
    "conductor",
    "dielectric",
    "diffusetransmission",
    "interface",
    "measured",
    "principled",
    "thindielectric",
];

struct Definition {
    name: Option<String>,
    bsdf: Bsdf,
    used: bool,
}

/// All materials defined so far.
#[derive(Default)]
pub(super) struct Materials {
    definitions: Vec<Definition>,
    by_name: HashMap<String, usize>,
    last_unnamed: Option<usize>,
}

impl Materials {
    /// `Material`: the index of its definition. The same again right after itself is one definition.
    pub fn define_unnamed(&mut self, bsdf: Bsdf) -> usize {
        if let Some(last) = self.last_unnamed
            && self.definitions[last].bsdf == bsdf
        {
            return last;
        }
        self.definitions.push(Definition { name: None, bsdf, used: false });
        let index = self.definitions.len() - 1;
        self.last_unnamed = Some(index);
        index
    }

    /// `MakeNamedMaterial`: from here on the name means this.
    pub fn define_named(&mut self, name: String, bsdf: Bsdf, at: Pos, log: &mut Log) {
        let index = self.definitions.len();
        self.definitions.push(Definition { name: Some(name.clone()), bsdf, used: false });
        if self.by_name.insert(name.clone(), index).is_some() {
            log.warn(at, format!("material {} is defined again; from here on this one counts", shown(&name)));
        }
    }

    /// `NamedMaterial`: the index of the definition, or an error that lists the names there are.
    pub fn find(&self, name: &str, at: Pos, log: &Log) -> Result<usize, Error> {
        self.by_name.get(name).copied().ok_or_else(|| {
            let mut names: Vec<&str> = self.definitions.iter().filter_map(|d| d.name.as_deref()).collect();
            names.dedup();
            let guess = suggestion(name, &names);
            names.truncate(8);
            let expected = if names.is_empty() {
                "but no MakeNamedMaterial comes before it".to_owned()
            } else {
                format!("expected one defined before it: {}{guess}", names.join(", "))
            };
            log.error(at, format!("NamedMaterial {}, {expected}", shown(name)))
        })
    }

    /// Marks what a shape is made of: what the graphics state names or, as in pbrt, grey. `None` for a black light, whose
    /// surface only emits.
    pub fn use_for_shape(&mut self, current: Option<usize>, is_light: bool) -> Option<usize> {
        let index = current.unwrap_or_else(|| self.define_unnamed(DEFAULT_MATTE));
        if is_light && self.definitions[index].bsdf == (Bsdf::Matte { kd: Vec3::ZERO }) {
            return None;
        }
        self.definitions[index].used = true;
        Some(index)
    }

    /// The materials in use, in the order of their definitions and with unique names, and the new
    /// index of each definition.
    pub fn finish(self) -> (Vec<Material>, Vec<Option<usize>>) {
        let mut taken: HashSet<String> = self.definitions.iter().filter_map(|d| d.name.clone()).collect();
        let mut seen = HashSet::new();
        let mut unique = |base: &str, first: usize| {
            (first..).map(|n| format!("{base}{n}")).find(|name| taken.insert(name.clone())).unwrap_or_default()
        };
        let mut materials = Vec::new();
        let mut unnamed = 0;
        let index = self
            .definitions
            .into_iter()
            .map(|d| {
                if !d.used {
                    return None;
                }
                let name = match d.name {
                    Some(name) if seen.insert(name.clone()) => name,
                    Some(name) => unique(&format!("{name}_"), 2),
                    None => {
                        unnamed += 1;
                        unique("material", unnamed)
                    }
                };
                materials.push(Material { name, bsdf: d.bsdf });
                Some(materials.len() - 1)
            })
            .collect();
        (materials, index)
    }
}

/// The scattering of a material of the given pbrt type.
pub(super) fn read_bsdf(kind: &str, mut params: Params, at: Pos, log: &mut Log) -> Result<Bsdf, Error> {
    let bsdf = match kind {
        "matte" => {
            if let Some(sigma) = params.float("sigma", log)?
                && sigma.value != 0.0
            {
                log.warn(sigma.at, format!("matte: sigma {} is not used, the surface is Lambertian", sigma.value));
            }
            Bsdf::Matte { kd: params.reflectance("Kd", Vec3::splat(0.5), log)? }
        }
        "mirror" => Bsdf::Conductor {
            reflectance: Reflectance::Constant(params.reflectance("Kr", Vec3::splat(0.9), log)?),
            alpha: 0.0,
        },
        "metal" => {
            let mut index = |name, default| -> Result<Vec3, Error> {
                let Some(At { value, at }) = params.rgb(name, log)? else { return Ok(default) };
                if value.max_element() > MAX_INDEX {
                    log.warn(at, format!("metal: \"{name}\" is {value}, cut to {MAX_INDEX:e}"));
                }
                Ok(value.min(Vec3::splat(MAX_INDEX)))
            };
            let (eta, k) = (index("eta", COPPER_ETA)?, index("k", COPPER_K)?);
            Bsdf::Conductor {
                reflectance: Reflectance::Fresnel { eta, k },
                alpha: read_alpha(&mut params, 0.01, at, log)?,
            }
        }
        "plastic" => Bsdf::Plastic {
            kd: params.reflectance("Kd", Vec3::splat(0.25), log)?,
            ks: params.reflectance("Ks", Vec3::splat(0.25), log)?,
            alpha: read_alpha(&mut params, 0.1, at, log)?,
            swapped_indices: swapped_indices(&mut params, at, log)?,
        },
        "diffuse" | "coateddiffuse" => {
            let short = format!("material {} as matte", shown(kind));
            log.found_v4();
            log.warn_dialect(at, format!("material {} is pbrt-v4's, matte is used", shown(kind)), short);
            Bsdf::Matte { kd: params.reflectance("reflectance", Vec3::splat(0.5), log)? }
        }
        _ if OF_V4.contains(&kind) => {
            let short = format!("material {} as matte 0.5", shown(kind));
            log.found_v4();
            log.warn_dialect(at, format!("material {} is pbrt-v4's, matte 0.5 is used", shown(kind)), short);
            params.forget();
            return Ok(DEFAULT_MATTE);
        }
        _ => {
            // Most of pbrt's have a diffuse part of that name, and pbrt reads names it does not know as matte.
            let kd = params.reflectance("Kd", Vec3::splat(0.5), log)?;
            let guess = suggestion(kind, &["matte", "mirror", "metal", "plastic"]);
            let expected = "expected matte, mirror, metal or plastic";
            let message =
                format!("material {} is not supported, {expected}{guess}; matte {} is used", shown(kind), triple(kd));
            log.warn_once(&format!("material {kind}"), at, message);
            params.forget();
            return Ok(Bsdf::Matte { kd });
        }
    };
    params.finish(log);
    Ok(bsdf)
}

/// A colour in a message: one number if its channels are equal.
fn triple(v: Vec3) -> String {
    if v == Vec3::splat(v.x) { v.x.to_string() } else { format!("{} {} {}", v.x, v.y, v.z) }
}

/// Whether plastic's coat reflects as in pbrt-v3, whose source hands the two indices of refraction over in the wrong order:
/// there light from the air is reflected as if it came from inside of the plastic, wholly beyond 42 degrees. The book's
/// order is the default; a file that does not say which it means is told.
fn swapped_indices(params: &mut Params, at: Pos, log: &mut Log) -> Result<bool, Error> {
    if let Some(swapped) = params.boolean("pbrtfresnel", log)? {
        return Ok(swapped);
    }
    let message = "plastic: pbrt-v3 has the coat's two indices of refraction swapped and reflects more than here; \
                   \"bool pbrtfresnel\" \"true\" gives its value, \"false\" the book's without this remark";
    log.warn_once("plastic", at, message);
    Ok(false)
}

/// The GGX width from `roughness`, `uroughness`, `vroughness` and `remaproughness`.
fn read_alpha(params: &mut Params, default: f64, at: Pos, log: &mut Log) -> Result<f32, Error> {
    let remap = params.boolean("remaproughness", log)?.unwrap_or(true);
    let mut value = |name, default| -> Result<f64, Error> {
        let Some(At { value, at }) = params.float(name, log)? else { return Ok(default) };
        if value < 0.0 {
            log.warn(at, format!("{name} {value}, expected a number of at least 0; {default} is used"));
            return Ok(default);
        }
        Ok(value)
    };
    let roughness = value("roughness", default)?;
    let (u, v) = (value("uroughness", roughness)?, value("vroughness", roughness)?);
    let alpha = |roughness: f64| if remap { alpha_from_roughness(roughness) } else { roughness };
    let mut width = alpha(u);
    if u != v {
        width = (alpha(u) * alpha(v)).sqrt();
        log.warn(at, format!("roughness {u} along u and {v} along v: the same alpha {width:.4} is used for both"));
    }
    if width > 1.0 {
        log.warn(at, format!("roughness gives alpha {width:.4}, cut to 1"));
    }
    Ok(width.min(1.0) as f32)
}

/// pbrt-v3's mapping of roughness to the GGX width (`TrowbridgeReitzDistribution::RoughnessToAlpha`,
/// a polynomial in the logarithm). It never falls below about 0.047.
fn alpha_from_roughness(roughness: f64) -> f64 {
    let x = roughness.max(1e-3).ln();
    1.62142 + x * (0.819955 + x * (0.1734 + x * (0.0171201 + x * 0.000640711)))
}
