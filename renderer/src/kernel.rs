//! The loop over the pixels of a tile: camera ray, surface, secondary ray, film.
//!
//! One dispatch to the machine's vector unit per tile (a dispatch costs about 27 ns).

use crate::bsdf::Surface;
use crate::build::BuiltScene;
use crate::estimator::{Reflected, drawn_by_light, reflected_radiance};
use crate::film::{BLOCK, Rest, Sample, Tile};
#[cfg(target_arch = "x86_64")]
use crate::lanes::Simd;
#[cfg(all(target_arch = "x86_64", not(one_lane)))]
use crate::lanes::Twice;
#[cfg(not(one_lane))]
use crate::lanes::Wide;
#[cfg(not(any(target_arch = "x86_64", one_lane)))]
use crate::lanes::dispatch;
use crate::lanes::{Lanes, Level, Mask, PACKET, Single, Uint};
use crate::patch::{Candidates, PATCH};
use crate::sampler::{Dimension, Numbers, Pixels, Sampler, Which, patch_key, pixel_keys};
use crate::settings::{Estimator, Settings, Strategy};

/// How the kernel runs. All ways agree up to the rounding of fused operations.
#[derive(Clone, Copy, Debug)]
pub enum Lanewise {
    /// Sixteen pixels at a time on a vector unit, or twice as many on one of 512 bits.
    Wide(Level),
    /// One pixel at a time, scalar code.
    Single,
}

impl Lanewise {
    /// The best of this machine.
    pub fn best() -> Self {
        Self::Wide(Level::new())
    }

    /// Every way this machine can run, the fastest first.
    pub fn all() -> Vec<Self> {
        let best = Level::new();
        let mut ways = vec![Self::Wide(best)];
        #[cfg(target_arch = "x86_64")]
        for level in [best.as_avx2().map(Simd::level), best.as_sse4_2().map(Simd::level)].into_iter().flatten() {
            let way = Self::Wide(level);
            if ways.iter().all(|other| other.name() != way.name()) {
                ways.push(way);
            }
        }
        ways.push(Self::Single);
        ways
    }

    /// Does a task in lanes. (By hand rather than by `dispatch!`, which would compile it for two more levels that no
    /// machine of the last ten years needs.)
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            // `cargo mutants` alone sets this (tests/README.md): to compile one kernel of four for each mutant.
            #[cfg(one_lane)]
            Self::Wide(_) | Self::Single => task.run(Single),
            #[cfg(all(target_arch = "x86_64", not(one_lane)))]
            Self::Wide(level) => {
                if let Some(simd) = level.as_avx512() {
                    avx512::run(simd, Twice(Wide(simd)), task)
                } else if let Some(simd) = level.as_avx2() {
                    avx2::run(simd, Wide(simd), task)
                } else if let Some(simd) = level.as_sse4_2() {
                    sse4_2::run(simd, Wide(simd), task)
                } else {
                    task.run(Single)
                }
            }
            #[cfg(not(any(target_arch = "x86_64", one_lane)))]
            Self::Wide(level) => dispatch!(level, simd => task.run(Wide(simd))),
            #[cfg(not(one_lane))]
            Self::Single => task.run(Single),
        }
    }

    /// Short name, e.g. "AVX-512".
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide(level) => crate::lanes::level_name(level),
            Self::Single => "single lane",
        }
    }
}

/// A task in lanes of one level: a module for each, since the compiler works on modules side by side.
#[cfg(all(target_arch = "x86_64", not(one_lane)))]
macro_rules! levels {
    ($($level:ident),*) => {$(
        mod $level {
            use super::{Lanes, Simd, Task};

            #[inline(never)]
            pub fn run<T: Task>(simd: impl Simd, l: impl Lanes, task: T) -> T::Output {
                simd.vectorize(
                    #[inline(always)]
                    || task.run(l),
                )
            }
        }
    )*};
}
#[cfg(all(target_arch = "x86_64", not(one_lane)))]
levels!(avx512, avx2, sse4_2);

/// Something to be done in lanes. `run` has to be `#[inline(always)]`, as all lane code.
pub trait Task {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run<L: Lanes>(self, l: L) -> Self::Output;
}

/// Adds `count` samples to every pixel of the tile; returns how many were invalid.
pub fn render_tile(how: Lanewise, scene: &BuiltScene, settings: &Settings, tile: &mut Tile, count: u32) -> u64 {
    match settings.estimator.strategy {
        Strategy::Light => how.run(AddSamples::<{ Strategy::Light as usize }> { scene, settings, tile, count }),
        Strategy::Bsdf => how.run(AddSamples::<{ Strategy::Bsdf as usize }> { scene, settings, tile, count }),
        Strategy::MisAll => how.run(AddSamples::<{ Strategy::MisAll as usize }> { scene, settings, tile, count }),
        Strategy::Mis => how.run(AddSamples::<{ Strategy::Mis as usize }> { scene, settings, tile, count }),
    }
}

/// Compiled once for each strategy, a number into [`Strategy::ALL`]: what a strategy does not do then costs nothing.
struct AddSamples<'a, const STRATEGY: usize> {
    scene: &'a BuiltScene,
    settings: &'a Settings,
    tile: &'a mut Tile,
    count: u32,
}

impl<const STRATEGY: usize> Task for AddSamples<'_, STRATEGY> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> u64 {
        let settings = Settings {
            estimator: Estimator { strategy: Strategy::ALL[STRATEGY], ..self.settings.estimator },
            ..self.settings.clone()
        };
        add_samples(l, self.scene, &settings, self.tile, self.count)
    }
}

#[inline(always)]
fn add_samples<L: Lanes>(l: L, scene: &BuiltScene, settings: &Settings, tile: &mut Tile, count: u32) -> u64 {
    let mut invalid = 0;
    let wanted = Dimension::wanted(settings.estimator.strategy, scene.lights.list.len() > 1, scene.has_two_lobes);
    let mut sampler = Sampler::new(&settings.sampling.sampler, wanted);
    let one_sample = settings.estimator.strategy == Strategy::Mis;
    let mut random = Numbers::nothing(l);
    let packet = Packet { place: (0, 0), corner: [l.f(0.0); 2], pixels: Pixels::new(l, l.u(0)) };
    let mut packets = vec![packet; (PATCH[0] * PATCH[1]) as usize * PACKET / L::N];
    let last = tile.samples + count;
    while tile.samples < last {
        let run = sampler.start(tile.samples, last - tile.samples);
        for [min, max] in tile.patches() {
            let near = scene.near(tile.corner_at(min));
            sampler.enter(l, patch_key(settings.sampling.seed, tile.corner_at(min)));
            let mut used = 0;
            for row in min[1]..max[1] {
                for column in min[0]..max[0] {
                    let [x0, y0] = tile.corner_at([column, row]);
                    let mut lane = 0;
                    while lane < PACKET {
                        let pixel = l.iota() + l.u(lane as u32);
                        let x = (pixel & l.u(BLOCK[0] - 1)) + l.u(x0);
                        let y = (pixel >> BLOCK[0].trailing_zeros()) + l.u(y0);
                        let packet = &mut packets[used];
                        packet.place = (tile.block_index([column, row]), lane);
                        packet.corner = [x.to_real(), y.to_real()];
                        packet.pixels.change(pixel_keys(l, settings.sampling.seed, x, y));
                        sampler.turn(l, &mut packet.pixels);
                        used += 1;
                        lane += L::N;
                    }
                }
            }
            let mut i = 0;
            while i < run {
                let index = tile.samples + i;
                // Always the same pairs, wherever runs begin.
                let pair = one_sample && index.is_multiple_of(2) && i + 1 < run;
                for packet in &packets[..used] {
                    let mut turns = Turns::new(l, settings, &sampler, &packet.pixels, i as usize, pair);
                    let mut waiting = Rest::nothing(l);
                    loop {
                        let (which, asked) = turns.next(&mut random);
                        sampler.draw(l, which, &packet.pixels, asked, &mut random);
                        let sample = sample(l, scene, settings, packet.corner, &random, &near);
                        let rest = tile.add(l, packet.place, index + turns.done, &sample);
                        turns.done += 1;
                        if !pair {
                            invalid += u64::from(tile.finish(l, packet.place, index, &rest));
                            break;
                        }
                        if turns.done == 2 {
                            let first = Rest::select(turns.swapped, &rest, &waiting);
                            let second = Rest::select(turns.swapped, &waiting, &rest);
                            invalid += u64::from(tile.finish(l, packet.place, index, &first));
                            invalid += u64::from(tile.finish(l, packet.place, index + 1, &second));
                            break;
                        }
                        waiting = rest;
                    }
                }
                i += if pair { 2 } else { 1 };
            }
        }
        tile.samples += run;
    }
    invalid
}

/// Pixels of a patch that are worked on at once.
#[derive(Clone, Copy)]
struct Packet<L: Lanes> {
    /// Block and first lane.
    place: (usize, usize),
    /// Upper left corners of the pixels.
    corner: [L::F; 2],
    pixels: Pixels<L>,
}

/// In which order a packet takes one or two successive samples. In the one-sample model a pair usually has one sample
/// of either technique, but not the same one first in every pixel. There the light sample comes first: then all lanes
/// do the same, once what the light technique needs and once the BSDF technique. Neither technique's samples
/// change their order among themselves.
struct Turns<L: Lanes> {
    sample: usize,
    /// Where the second sample of a pair comes first.
    swapped: L::M,
    /// Of the one-sample model: the number that says which technique, and the lanes that the light technique draws;
    /// of both samples.
    technique: Option<[(L::F, L::M); 2]>,
    /// Whether the strategy draws by light, by BSDF.
    draws: [bool; 2],
    /// How many turns are over.
    done: u32,
}

impl<L: Lanes> Turns<L> {
    #[inline(always)]
    fn new(l: L, settings: &Settings, sampler: &Sampler, pixels: &Pixels<L>, sample: usize, pair: bool) -> Self {
        let draws = [settings.estimator.strategy != Strategy::Bsdf, settings.estimator.strategy != Strategy::Light];
        let mut turns = Self { sample, swapped: l.m(false), technique: None, draws, done: 0 };
        if settings.estimator.strategy == Strategy::Mis {
            let first = sampler.technique(l, sample, pixels);
            let second = if pair { sampler.technique(l, sample + 1, pixels) } else { first };
            let by_light = [drawn_by_light(l, settings, first), drawn_by_light(l, settings, second)];
            turns.swapped = !by_light[0] & by_light[1];
            turns.technique = Some([(first, by_light[0]), (second, by_light[1])]);
        }
        turns
    }

    /// Which sample's turn it is, and the techniques that it needs numbers of. The number that says which
    /// technique is put into `random`.
    #[inline(always)]
    fn next(&self, random: &mut Numbers<L>) -> (Which<L>, [bool; 2]) {
        let Some([(first, first_by_light), (second, second_by_light)]) = self.technique else {
            return (Which { sample: self.sample, next: self.swapped }, self.draws);
        };
        let next = if self.done == 0 { self.swapped } else { !self.swapped };
        let by_light = (next & second_by_light) | (!next & first_by_light);
        random.set_technique(next.select(second, first));
        (Which { sample: self.sample, next }, [by_light.any(), !by_light.all()])
    }
}

/// One sample of each pixel of a packet.
#[inline(always)]
fn sample<L: Lanes>(
    l: L,
    scene: &BuiltScene,
    settings: &Settings,
    [x, y]: [L::F; 2],
    random: &Numbers<L>,
    near: &Candidates,
) -> Sample<L> {
    let [jx, jy] = random.get_2d(Dimension::Pixel);
    let dir = scene.camera.direction(l, x + jx, y + jy);
    let hit = scene.camera_hit(l, dir, near);
    let mut reflected = Reflected::nothing(l);
    // Packets are small patches of the image: nearly always all lanes meet the same shape. Where
    // not, there is one round for each shape met.
    let (mut todo, mut shape) = (hit.surface, hit.first);
    while todo.any() {
        let mut here = todo;
        if let Some(shapes) = hit.shapes {
            here = here & shapes.eq(l.u(shape));
        }
        if let Some(material) = scene.material(shape) {
            let surface = Surface { material, ..hit.points };
            reflected_radiance(l, scene, settings, (here, &surface, -dir), random, near, &mut reflected);
        }
        let Some(shapes) = hit.shapes else { break };
        todo = todo & !here;
        shape = shapes.lane(todo.bits().trailing_zeros() as usize % L::N);
    }
    Sample { reflected, emitted: hit.emitted, emits: hit.emits }
}
