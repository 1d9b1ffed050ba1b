//! The directives before `WorldBegin`: image, sampler, integrator and camera.

use std::num::NonZeroU32;

use glam::DMat4;
use mislab_kernel::request::scene::Camera;
use mislab_kernel::request::{Heuristic, OneSampleWeights, SamplerKind, SamplerSettings, Settings, Strategy};

use super::log::{Log, Pos, shown};
use super::params::{At, Params};
use crate::error::Error;
use crate::near::near;

/// The largest image side of [`Settings::check`], and the most samples per pixel that pbrt's numbers can say.
const MAX_SIDE: u32 = 65536;
const MAX_SPP: u32 = i32::MAX as u32;

/// Of pbrt-v3: image size, and samples per pixel of most samplers.
const DEFAULT_RESOLUTION: [u32; 2] = [1280, 720];
const DEFAULT_SPP: u32 = 16;

/// What pbrt-v3 has where the file says nothing: a Film of its size and 16 points of a low discrepancy (a lattice's for its
/// Halton's). The tutorial's integrator without a Sampler is one of the tutorial's headers: they leave it to the first.
pub(super) fn defaults(s: &mut Settings, has_film: bool, has_sampler: bool) {
    if !has_film {
        s.image.resolution = DEFAULT_RESOLUTION;
    }
    if !has_sampler {
        let strata = SamplerSettings::strata_for(DEFAULT_SPP);
        s.sampling.sampler = SamplerSettings { kind: SamplerKind::Lattice, strata, jitter: true };
        s.sampling.spp = NonZeroU32::new(DEFAULT_SPP);
    }
}

/// Film as the file has it.
pub(super) fn film(kind: &str, mut params: Params, at: Pos, s: &mut Settings, log: &mut Log) -> Result<String, Error> {
    if matches!(kind, "rgb" | "gbuffer" | "spectral") {
        log.found_v4();
        log.warn_dialect(
            at,
            format!("Film {} is read as \"image\"", shown(kind)),
            format!("Film {} as \"image\"", shown(kind)),
        );
    } else if kind != "image" {
        log.warn(at, format!("Film {} is read as \"image\"", shown(kind)));
    }
    let filename = params.text("filename", log)?.map_or_else(|| "pbrt.exr".to_owned(), |f| f.value);
    s.image.resolution = [
        params.integer("xresolution", 1..=MAX_SIDE, log)?.map_or(DEFAULT_RESOLUTION[0], |v| v.value),
        params.integer("yresolution", 1..=MAX_SIDE, log)?.map_or(DEFAULT_RESOLUTION[1], |v| v.value),
    ];
    s.image.crop = [0.0, 1.0, 0.0, 1.0];
    let crop = params.floats::<4>("cropwindow", log)?;
    if let Some(At { value: [xa, xb, ya, yb], at }) = crop {
        // pbrt sorts and clamps.
        let unit = |v: f64| v.clamp(0.0, 1.0) as f32;
        s.image.crop = [unit(xa.min(xb)), unit(xa.max(xb)), unit(ya.min(yb)), unit(ya.max(yb))];
        if [xa, xb, ya, yb].iter().any(|v| !(0.0..=1.0).contains(v)) {
            let [x0, x1, y0, y1] = s.image.crop;
            let given = format!("cropwindow {xa} {xb} {ya} {yb} reaches out of the image");
            if x0 == x1 || y0 == y1 {
                return Err(log.error(at, format!("{given} and holds no pixel of it, expected numbers in [0, 1]")));
            }
            log.warn(at, format!("{given}, expected numbers in [0, 1]; it is cut to {x0} {x1} {y0} {y1}"));
        }
    }
    let place = crop.map(|c| c.at).or(params.position("xresolution")).unwrap_or(at);
    check(s, place, log)?;
    params.finish(log);
    Ok(filename)
}

/// Sampler, and with it the samples per pixel.
pub(super) fn sampler(kind: &str, mut params: Params, at: Pos, s: &mut Settings, log: &mut Log) -> Result<(), Error> {
    let of_strata = SamplerKind::from_name(kind).filter(|kind| kind.has_strata());
    if let Some(kind) = of_strata {
        let strata = [
            params.integer("xsamples", 1..=SamplerSettings::MAX_STRATA, log)?.map_or(4, |v| v.value),
            params.integer("ysamples", 1..=SamplerSettings::MAX_STRATA, log)?.map_or(4, |v| v.value),
        ];
        let jitter = params.boolean("jitter", log)?.unwrap_or(true);
        s.sampling.sampler = SamplerSettings { kind, strata, jitter };
        check(s, params.position("xsamples").unwrap_or(at), log)?;
        s.sampling.spp = NonZeroU32::new(strata[0] * strata[1]);
        params.refuse_near_misses(log)?;
        params.finish(log);
        return Ok(());
    }
    let (sampler, default_spp) = match kind {
        "random" => (SamplerKind::Independent, 4),
        "sobol" => (SamplerKind::Sobol, DEFAULT_SPP),
        "lattice" => (SamplerKind::Lattice, DEFAULT_SPP),
        "padded_sobol" => (SamplerKind::PaddedSobol, DEFAULT_SPP),
        "halton" | "02sequence" | "lowdiscrepancy" | "maxmindist" => {
            log.warn(at, format!("Sampler {}: Owen-scrambled Sobol points are used instead", shown(kind)));
            (SamplerKind::Sobol, DEFAULT_SPP)
        }
        "paddedsobol" => {
            log.found_v4();
            let message = format!("Sampler {} is read as \"padded_sobol\"", shown(kind));
            log.warn_dialect(at, message, format!("Sampler {} as padded_sobol", shown(kind)));
            (SamplerKind::PaddedSobol, DEFAULT_SPP)
        }
        "zsobol" | "pmj02bn" => {
            log.found_v4();
            let message = format!("Sampler {}: Owen-scrambled Sobol points are used instead", shown(kind));
            log.warn_dialect(at, message, format!("Sampler {} as sobol", shown(kind)));
            (SamplerKind::Sobol, DEFAULT_SPP)
        }
        "independent" => {
            log.found_v4();
            let message = format!("Sampler {} is read as \"random\"", shown(kind));
            log.warn_dialect(at, message, format!("Sampler {} as random", shown(kind)));
            (SamplerKind::Independent, DEFAULT_SPP)
        }
        _ => {
            let message = format!(
                "Sampler {}, expected stratified, lattice, sobol, random, padded_stratified or padded_sobol; independent samples are used",
                shown(kind)
            );
            log.warn(at, message);
            (SamplerKind::Independent, DEFAULT_SPP)
        }
    };
    let spp = params.integer("pixelsamples", 1..=MAX_SPP, log)?.map_or(default_spp, |v| v.value);
    // The strata count only if the user switches to the stratified sampler.
    s.sampling.sampler = SamplerSettings { kind: sampler, strata: SamplerSettings::strata_for(spp), jitter: true };
    s.sampling.spp = NonZeroU32::new(spp);
    params.refuse_near_misses(log)?;
    params.finish(log);
    check(s, at, log)
}

/// Integrators that only pbrt-v4 has.
const OF_V4: [&str; 5] = ["function", "lightpath", "randomwalk", "simplepath", "simplevolpath"];

/// Integrators of pbrt and of programs that read its files.
const FOREIGN: [&str; 26] = [
    "ambientocclusion",
    "ao",
    "bdpt",
    "bidirectional",
    "diffuseprt",
    "dipolesubsurface",
    "directlighting",
    "distributedpath",
    "exphotonmap",
    "function",
    "glossyprt",
    "igi",
    "irradiancecache",
    "lightpath",
    "metropolis",
    "mlt",
    "mmlt",
    "path",
    "photonmap",
    "randomwalk",
    "simplepath",
    "simplevolpath",
    "sppm",
    "useprobes",
    "volpath",
    "whitted",
];

/// The strategy and its parameters. False if the file asks for the integrator of another program, in whose place one of the
/// four strategies stands; a name that is nearly one of these is an error.
pub(super) fn integrator(
    kind: &str,
    mut params: Params,
    at: Pos,
    s: &mut Settings,
    log: &mut Log,
) -> Result<bool, Error> {
    let defaults = Settings::default();
    s.estimator.strategy = defaults.estimator.strategy;
    s.estimator.light_prob = defaults.estimator.light_prob;
    s.estimator.heuristic = defaults.estimator.heuristic;
    s.estimator.weights = defaults.estimator.weights;
    let names = Strategy::ALL.map(Strategy::name);
    if kind != "veachMIS" {
        let plain: String = kind.chars().filter(|c| c.is_alphanumeric()).collect();
        if near(&plain, &["veachMIS"]).is_some() || plain.to_lowercase().contains("veach") {
            return Err(log.error(at, format!("unknown integrator {}, did you mean \"veachMIS\"?", shown(kind))));
        }
        if names.contains(&kind) {
            let message = format!("unknown integrator {}, did you mean \"veachMIS\"", shown(kind));
            return Err(log.error(at, format!("{message} with \"string MISstrategy\" \"{kind}\"?")));
        }
        if let Some(meant) = near(kind, &FOREIGN).filter(|meant| *meant != kind) {
            return Err(log.error(at, format!("unknown integrator {}, did you mean \"{meant}\"?", shown(kind))));
        }
        if OF_V4.contains(&kind) {
            log.found_v4();
        }
        let used = s.estimator.strategy.name();
        let message =
            format!("integrator {} is not supported, expected veachMIS; strategy {used} is used", shown(kind));
        log.warn_dialect(at, message, format!("Integrator {} as veachMIS with {used}", shown(kind)));
        params.forget();
        return Ok(false);
    }
    // The tutorial uses both spellings.
    let new = params.choice("MISstrategy", Strategy::from_name, &names, log)?;
    let old = params.choice("sample_method", Strategy::from_name, &names, log)?;
    if let (Some(new), Some(old)) = (&new, &old)
        && new.value != old.value
    {
        log.warn(old.at, format!("sample_method differs from MISstrategy; {} is used", new.value.name()));
    }
    if let Some(strategy) = new.or(old) {
        s.estimator.strategy = strategy.value;
    }
    if let Some(At { value, at }) = params.float("lightprob", log)? {
        if !(0.0..=1.0).contains(&value) {
            return Err(log.error(at, format!("lightprob {value}, expected a number in [0, 1]")));
        }
        s.estimator.light_prob = value as f32;
    }
    let names = Heuristic::ALL.map(Heuristic::name);
    if let Some(h) = params.choice("heuristic", Heuristic::from_name, &names, log)? {
        s.estimator.heuristic = h.value;
    }
    let names = OneSampleWeights::ALL.map(OneSampleWeights::name);
    if let Some(w) = params.choice("weights", OneSampleWeights::from_name, &names, log)? {
        s.estimator.weights = w.value;
    }
    params.refuse_near_misses(log)?;
    params.finish(log);
    check(s, at, log).map(|()| true)
}

/// The filter is a box of one pixel; anything else is said to be so.
pub(super) fn pixel_filter(kind: &str, mut params: Params, at: Pos, log: &mut Log) -> Result<(), Error> {
    if kind != "box" {
        log.warn(at, format!("PixelFilter {}: a box of one pixel is used instead", shown(kind)));
        params.forget();
        return Ok(());
    }
    for name in ["xwidth", "ywidth"] {
        if let Some(width) = params.float(name, log)?
            && width.value != 0.5
        {
            log.warn(width.at, format!("{name} {}: a box of one pixel (0.5 to either side) is used", width.value));
        }
    }
    params.finish(log);
    Ok(())
}

/// The camera, seen from the inverse of the current matrix. The screen window of a
/// `frameaspectratio` replaces the one that the image's own shape would give.
pub(super) fn camera(
    kind: &str,
    mut params: Params,
    at: Pos,
    world_from_camera: DMat4,
    log: &mut Log,
) -> Result<Camera, Error> {
    if kind != "perspective" {
        log.warn(at, format!("Camera {} is read as \"perspective\"", shown(kind)));
    }
    let mut fov_deg = 90.0;
    let fov = params.float("fov", log)?;
    let half = params.float("halffov", log)?.filter(|h| h.value > 0.0).map(|h| At { value: 2.0 * h.value, at: h.at });
    if let Some(At { value, at }) = half.or(fov) {
        if !(value > 0.0 && value < 180.0) {
            return Err(
                log.error(at, format!("field of view of {value} degrees, expected more than 0 and less than 180"))
            );
        }
        fov_deg = value;
    }
    let mut screen_window = None;
    if let Some(At { value: ratio, at }) = params.float("frameaspectratio", log)? {
        if ratio <= 0.0 {
            return Err(log.error(at, format!("frameaspectratio {ratio}, expected a number above 0")));
        }
        screen_window =
            Some(if ratio > 1.0 { [-ratio, ratio, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / ratio, 1.0 / ratio] });
    }
    if let Some(At { value: window, at }) = params.floats::<4>("screenwindow", log)? {
        let [left, right, bottom, top] = window;
        if left == right || bottom == top {
            return Err(log.error(at, "empty screenwindow, expected left, right, bottom and top of a rectangle"));
        }
        screen_window = Some(window);
    }
    if let Some(lens) = params.float("lensradius", log)?
        && lens.value != 0.0
    {
        log.warn(lens.at, format!("lensradius {}: a pinhole camera is used, everything is in focus", lens.value));
    }
    params.finish(log);
    Ok(Camera { world_from_camera, fov_deg, screen_window })
}

/// Settings were valid before this directive, so what is wrong with them now stands here.
fn check(settings: &Settings, at: Pos, log: &Log) -> Result<(), Error> {
    settings.check().map_err(|message| log.error(at, message))
}
