//! The brightest outliers of a picture, sample by sample.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::request::{Estimator, Settings, Strategy, Technique};
use mislab_kernel::tile::replay::{self as kernel, Ray, Replayed};
use mislab_kernel::world::BuiltScene;

use super::luminance;
use super::replay::replay;
use super::suspects::Suspect;
use super::weights::weighted;

/// A half, and what rounding may add to it.
const MORE_THAN_HALF: f64 = 0.500_001;

/// A sample that outweighs all others of its pixel: its secondary ray has more than half of the pixel's sum of squares
/// (two equal ones have a half each, and rounding decides nothing).
#[derive(Clone, Debug, PartialEq)]
pub struct Outlier {
    /// Column and row in the full image.
    pub pixel: [u32; 2],
    /// Number of the sample, from 0.
    pub index: u32,
    /// The sample, see [`replay()`](super::replay()).
    pub sample: Replayed,
    /// Which of its rays.
    pub ray: usize,
    /// Luminance that this ray contributes, `w f / (c p)`.
    pub value: f64,
    /// Its share of the luminance of all samples of the pixel.
    pub share_of_pixel: f64,
    /// The pixel: mean over all samples, per channel.
    pub mean: DVec3,
    /// Mean over all other samples; 0 if there are none.
    pub mean_without: DVec3,
    /// Luminance that the same direction, drawn by the same technique, contributes to `mis_all` with the same heuristic.
    pub under_mis_all: f64,
}

/// Where and how to look for outliers.
pub struct Search<'a> {
    /// The scene as it was rendered.
    pub scene: &'a BuiltScene,
    /// The settings that it was rendered with.
    pub settings: &'a Settings,
    /// Samples per pixel of the picture.
    pub spp: u32,
    /// The level that it was rendered at.
    pub how: Lanewise,
    /// How many outliers.
    pub count: usize,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Most samples to replay; about a million a second and thread.
    pub most_samples: u64,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fireflies {
    /// The outliers of highest value, the brightest first; one a pixel.
    pub outliers: Vec<Outlier>,
    /// True if no pixel left out can have a brighter one.
    pub complete: bool,
    /// Pixels all of whose samples were replayed.
    pub examined: usize,
    /// Those whose samples do not add up to the picture: it was made at a level that rounds differently, or changed since.
    pub different: usize,
}

/// The brightest ray of a pixel, if it outweighs all others.
struct Found {
    pixel: [u32; 2],
    index: u32,
    ray: usize,
    value: f64,
}

/// What became of one pixel.
#[derive(Default)]
struct Examined {
    found: Option<Found>,
    different: bool,
}

/// Pixels that are looked at before the next decision, for each thread.
const ROUND: usize = 16;
/// Sums of samples may differ by so much from the film's.
const SAME: f64 = 1e-3;

/// Replays pixels whose sums betray an outlier, those first that may have the brightest, until no other one can have a
/// brighter one. `None` if `goes_on` says no, which is asked after every pixel.
pub fn fireflies(
    search: &Search<'_>,
    mut suspects: Vec<Suspect>,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Option<Fireflies> {
    suspects.sort_by(|a, b| b.most.total_cmp(&a.most).then(a.pixel.cmp(&b.pixel)));
    let threads = match search.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let (mut kept, mut result): (Vec<Found>, _) = (Vec::new(), Fireflies::default());
    let mut left = suspects.as_slice();
    loop {
        let dimmest = kept.get(search.count.wrapping_sub(1)).map_or(0.0, |found| found.value);
        let brighter = left.iter().take_while(|suspect| suspect.most > dimmest).count();
        result.complete = brighter == 0 || search.count == 0;
        let affordable = search.most_samples / u64::from(search.spp.max(1)) - (result.examined as u64);
        let round = (ROUND * threads).min(brighter).min(usize::try_from(affordable).unwrap_or(usize::MAX));
        if result.complete || round == 0 {
            break;
        }
        let (now, later) = left.split_at(round);
        left = later;
        for examined in examine_all(search, now, threads, goes_on)? {
            result.examined += 1;
            result.different += usize::from(examined.different);
            kept.extend(examined.found);
        }
        kept.sort_by(|a, b| b.value.total_cmp(&a.value).then(a.pixel.cmp(&b.pixel)));
        kept.truncate(search.count);
    }
    result.outliers = kept.iter().map(|found| outlier(search, found)).collect();
    Some(result)
}

/// One pixel after the other, on all threads.
fn examine_all(
    search: &Search<'_>,
    suspects: &[Suspect],
    threads: usize,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Examined>> {
    let found = Mutex::new(Vec::with_capacity(suspects.len()));
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = || {
        while let Some(suspect) = suspects.get(next.fetch_add(1, Ordering::Relaxed)) {
            if stopped.load(Ordering::Relaxed) || !goes_on() {
                stopped.store(true, Ordering::Relaxed);
                return;
            }
            let examined = examine(search, suspect);
            found.lock().unwrap_or_else(PoisonError::into_inner).push(examined);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(suspects.len()) {
            // Without another thread this one does it all.
            let _ = std::thread::Builder::new().name("fireflies".into()).spawn_scoped(scope, work);
        }
        work();
    });
    (!stopped.into_inner()).then(|| found.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Replays all samples of a pixel.
fn examine(search: &Search<'_>, suspect: &Suspect) -> Examined {
    let Search { scene, settings, spp, how, .. } = search;
    let (mut sum, mut squares) = (0.0, 0.0);
    let mut brightest: Option<Found> = None;
    for index in 0..*spp {
        let sample = kernel::replay(*how, scene, settings, suspect.pixel, index);
        if !counts(&sample) {
            continue;
        }
        let y = f64::from(sample.luminance);
        sum += y;
        squares += y * y;
        for (ray, lit) in sample.rays.iter().enumerate().filter(|(_, ray)| ray.lit) {
            let value = luminance(lit.value.as_dvec3());
            if brightest.as_ref().is_none_or(|known| value > known.value) {
                brightest = Some(Found { pixel: suspect.pixel, index, ray, value });
            }
        }
    }
    let found = brightest.filter(|found| found.value > 0.0 && found.value * found.value > MORE_THAN_HALF * squares);
    Examined { found, different: (sum - suspect.sum).abs() > SAME * suspect.sum }
}

/// Whether the film has added a sample: not where its square is no finite number.
fn counts(sample: &Replayed) -> bool {
    (sample.luminance * sample.luminance).is_finite()
}

/// Everything about a sample that was found.
fn outlier(search: &Search<'_>, found: &Found) -> Outlier {
    let Search { scene, settings, spp, how, .. } = search;
    let Found { pixel, index, ray, value } = *found;
    let of = |index: u32| kernel::replay(*how, scene, settings, pixel, index);
    let colour = |sample: &Replayed| {
        let emitted = if sample.emits { sample.emitted.as_dvec3() } else { DVec3::ZERO };
        sample.rays.iter().filter(|ray| ray.lit).map(|ray| ray.value.as_dvec3()).sum::<DVec3>() + emitted
    };
    let others = (0..*spp).filter(|other| *other != index).map(of).filter(counts);
    let others: DVec3 = others.map(|sample| colour(&sample)).sum();
    let sample = replay(*how, scene, settings, pixel, index);
    let all = others + colour(&sample);
    let samples = f64::from(*spp);
    let under_mis_all = under_mis_all(&sample.rays[ray], &settings.estimator);
    Outlier {
        pixel,
        index,
        ray,
        value,
        share_of_pixel: value / luminance(all),
        mean: all / samples,
        mean_without: others / (samples - 1.0).max(1.0),
        under_mis_all,
        sample,
    }
}

/// Luminance that a ray's direction, drawn by the same technique, contributes to `mis_all`.
fn under_mis_all(ray: &Ray, estimator: &Estimator) -> f64 {
    let estimator = Estimator { strategy: Strategy::MisAll, ..*estimator };
    let [light, bsdf] = weighted(ray.f, [ray.p_light, ray.p_bsdf], &estimator);
    let own = match ray.technique {
        Technique::Light => light,
        Technique::Bsdf => bsdf,
    };
    luminance(own.value.as_dvec3())
}
