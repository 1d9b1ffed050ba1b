//! What a second of one processor is worth: error and time together, by strategy and sampler.

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{
    Estimator, ImageSettings, Request, SamplerKind, SamplerSettings, Sampling, Settings, Strategy,
};

use crate::engine::Renderer;
use crate::error::Error;
use crate::frame::Frame;
use crate::layer::Channel;
use crate::metrics::{Errors, Reference, Region};
use crate::table::regions::visible_materials;

/// Width and height of the pictures in pixels.
const SIDE: u32 = 200;
/// Secondary rays per pixel of each picture, and samples of the reference.
const RAYS: u32 = 64;
const REFERENCE_SPP: u32 = 1024;

/// `1 / (relMSE x processor seconds)` by name of the strategy, then of the sampler.
pub type Efficiency = BTreeMap<&'static str, BTreeMap<&'static str, f64>>;

/// Of pictures of 200 x 200 pixels at 64 rays a pixel by one thread, against a reference of 1024 samples of both techniques:
/// the median over the materials in view, pixels at their edges left out. Each picture is rendered again for `time`, and
/// its shortest counts. Only ratios between entries mean something.
///
/// # Errors
/// [`Error::Invalid`] if the scene cannot be rendered.
pub fn efficiency(scene: &Arc<Scene>, time: Duration) -> Result<Efficiency, Error> {
    let renderer = Renderer::new(1, || {});
    let render = |strategy: Strategy, kind: SamplerKind, spp: u32, seed: u32| -> Result<(f64, Planes), Error> {
        let strata = SamplerSettings::strata_for(spp);
        let settings = Settings {
            estimator: Estimator { strategy, ..Estimator::default() },
            sampling: Sampling {
                sampler: SamplerSettings { kind, strata, jitter: true },
                spp: NonZeroU32::new(spp),
                seed,
            },
            image: ImageSettings { resolution: [SIDE; 2], ..ImageSettings::default() },
        };
        let frame = renderer.render(&Request { scene: Arc::clone(scene), settings }, &mut |_| true)?;
        Ok((frame.stats().cpu_seconds, planes(&frame)))
    };
    let (_, reference) = render(Strategy::MisAll, SamplerKind::Lattice, REFERENCE_SPP, 1 << 31)?;
    let regions = regions(scene);
    let mut efficiency = Efficiency::new();
    for strategy in Strategy::ALL {
        let spp = RAYS / strategy.rays_per_sample();
        for kind in SamplerKind::ALL {
            let (mut seconds, mut picture) = render(strategy, kind, spp, 1)?;
            let start = Instant::now();
            while start.elapsed() < time {
                let (again, same) = render(strategy, kind, spp, 1)?;
                (seconds, picture) = (seconds.min(again), same);
            }
            let mut errors: Vec<f64> = regions
                .iter()
                .filter_map(|mask| {
                    let [picture, reference] =
                        [&picture, &reference].map(|planes| planes.each_ref().map(Vec::as_slice));
                    Errors::of(&picture, &Reference::Exact(&reference), &Region::Mask(mask)).rel_mse()
                })
                .collect();
            errors.sort_by(f64::total_cmp);
            if let Some(median) = errors.get(errors.len() / 2) {
                efficiency.entry(strategy.name()).or_default().insert(kind.name(), 1.0 / (median * seconds));
            }
        }
    }
    Ok(efficiency)
}

/// Red, green and blue, row by row.
type Planes = [Vec<f32>; 3];

fn planes(frame: &Frame) -> Planes {
    [Channel::R, Channel::G, Channel::B].map(|channel| frame.channel(channel))
}

/// A mask for each material in view.
fn regions(scene: &Scene) -> Vec<Vec<bool>> {
    let materials = visible_materials(scene, [SIDE; 2]);
    (0..scene.materials.len())
        .map(|material| materials.iter().map(|&m| m == Some(material)).collect::<Vec<bool>>())
        .filter(|mask| mask.contains(&true))
        .collect()
}
