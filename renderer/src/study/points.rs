//! The pictures of error curves, cheap ones first, and their errors as each is finished.

use std::num::NonZeroU32;
use std::sync::Arc;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Estimator, Request, SamplerSettings, Sampling, Settings};

use super::blocks::Blocks;
use super::cells::Part;
use super::reference::Against;
use crate::engine::Renderer;
use crate::error::Error;
use crate::frame::Frame;
use crate::table::reference::rgb;

/// What is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// A curve for each.
    pub estimators: Vec<Estimator>,
    /// Samples per pixel of the points, ascending.
    pub at: Vec<u32>,
    /// Pictures of each point with different seeds.
    pub replicates: u32,
    /// Errors are kept by blocks of pixels, too: [`super::cells::Part::Rect`] has its curves.
    pub by_block: bool,
}

/// With two, a 95 % interval is three times as wide as with three.
const FIRST_ROUND: usize = 3;

impl Plan {
    /// All pictures in the order that they are rendered in: three of every point, so that each soon has a band, then
    /// the others; in each round the cheap ones first.
    pub(crate) fn order(&self) -> impl Iterator<Item = [usize; 3]> {
        let (curves, points, all) = (self.estimators.len(), self.at.len(), self.replicates as usize);
        let first = all.min(FIRST_ROUND);
        let rounds = [0..first, first..all];
        rounds.into_iter().flat_map(move |round| {
            (0..points).flat_map(move |point| {
                let round = round.clone();
                round.flat_map(move |replicate| (0..curves).map(move |curve| [curve, point, replicate]))
            })
        })
    }

    /// Settings of a picture, with strata as square as can be and a seed that no other picture of the curve has.
    pub(crate) fn settings(&self, request: &Request, [curve, point, replicate]: [usize; 3]) -> Settings {
        let Settings { sampling, image, .. } = request.settings.clone();
        let spp = self.at[point];
        let number = point as u32 * self.replicates + replicate as u32;
        let sampler = SamplerSettings { strata: SamplerSettings::strata_for(spp), ..sampling.sampler };
        let seed = sampling.seed.wrapping_add(number);
        Settings {
            estimator: self.estimators[curve],
            sampling: Sampling { sampler, spp: NonZeroU32::new(spp), seed },
            image,
        }
    }
}

/// One picture, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Index into [`Plan::estimators`].
    pub curve: usize,
    /// Index into [`Plan::at`].
    pub point: usize,
    /// Processor seconds of the picture.
    pub cpu_seconds: f64,
    /// relMSE and MSE in each of [`super::cells::Cells::parts`].
    pub errors: Vec<[f64; 2]>,
    /// The same by blocks, with [`Plan::by_block`].
    pub blocks: Option<Blocks>,
}

impl Found {
    /// relMSE and MSE in a part; `None` where the picture has no such part or its errors are not known.
    pub fn errors_in(&self, part: Part) -> Option<[f64; 2]> {
        match part {
            Part::Whole => self.errors.first().copied(),
            Part::Square(index) => self.errors.get(index + 1).copied(),
            Part::Rect(rect) => self.blocks.as_ref().map(|blocks| blocks.over(rect)),
        }
    }
}

/// Renders and measures all of a plan, in the order of [`Plan::order`]; blocks. `request` says scene, pattern, seed and image.
/// `render` makes the picture at `[curve, point, replicate]` of the plan, and `against` gives the reference that a picture of so many
/// samples is measured with; either gives up with `None`. `found` takes each result.
///
/// # Errors
/// Those of `render`.
pub fn measure(
    request: &Request,
    plan: &Plan,
    render: &mut dyn FnMut(Settings, [usize; 3]) -> Result<Option<Arc<Frame>>, Error>,
    against: &mut dyn FnMut(u32) -> Option<Arc<Against>>,
    found: &mut dyn FnMut(Found),
) -> Result<(), Error> {
    for index @ [curve, point, _] in plan.order() {
        let Some(reference) = against(plan.at[point]) else { return Ok(()) };
        let Some(frame) = render(plan.settings(request, index), index)? else { return Ok(()) };
        let cpu_seconds = frame.stats().cpu_seconds;
        let planes = rgb(&frame);
        let picture = planes.each_ref().map(Vec::as_slice);
        let errors = reference.cells.parts().map(|part| errors(picture, &reference, part)).collect();
        let blocks = plan.by_block.then(|| reference.block_errors(picture));
        found(Found { curve, point, cpu_seconds, errors, blocks });
    }
    Ok(())
}

/// Pictures of a scene for [`measure`] beside live ones: on `threads` of low priority, until `goes_on`, asked several times a
/// second, says no.
pub fn in_background(
    scene: Arc<Scene>,
    threads: usize,
    mut goes_on: impl FnMut() -> bool,
) -> impl FnMut(Settings, [usize; 3]) -> Result<Option<Arc<Frame>>, Error> {
    let renderer = Renderer::in_background(threads);
    move |settings, _| {
        let mut stopped = false;
        let frame = renderer.render(&Request { scene: Arc::clone(&scene), settings }, &mut |_| {
            stopped |= !goes_on();
            !stopped
        });
        // Stopped early, there may be a frame or, before the first pass, an error that says so.
        if stopped { Ok(None) } else { frame.map(Some) }
    }
}

/// relMSE and MSE of a picture's planes in a part; NaN where it holds no value.
///
/// # Panics
/// If they have another number of pixels than the reference.
pub fn errors(picture: [&[f32]; 3], reference: &Against, part: Part) -> [f64; 2] {
    let errors = reference.errors(picture, part);
    [errors.rel_mse(), errors.mse()].map(|value| value.unwrap_or(f64::NAN))
}
