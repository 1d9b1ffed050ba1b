//! The loop over the pixels of a tile: camera ray, surface, secondary ray, film.
//!
//! One dispatch to the machine's vector unit per tile (a dispatch costs about 27 ns).

use crate::build::BuiltScene;
use crate::estimator::{Reflected, reflected_radiance};
use crate::film::{BLOCK, Sample, Tile};
#[cfg(not(target_arch = "x86_64"))]
use crate::lanes::dispatch;
use crate::lanes::{Lanes, Level, Mask, PACKET, Simd, Single, Uint, Wide};
use crate::patch::Candidates;
use crate::sampler::{Dimension, Numbers, Sampler, pixel_keys};
use crate::settings::Settings;

/// How the kernel runs. All ways agree up to the rounding of fused operations.
#[derive(Clone, Copy, Debug)]
pub enum Lanewise {
    /// Sixteen pixels at a time on a vector unit.
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

    /// Short name, e.g. "AVX-512".
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide(level) => crate::lanes::level_name(level),
            Self::Single => "single lane",
        }
    }
}

/// Adds `count` samples to every pixel of the tile; returns how many were invalid.
pub fn render_tile(how: Lanewise, scene: &BuiltScene, settings: &Settings, tile: &mut Tile, count: u32) -> u64 {
    // By hand rather than by `dispatch!`, which would compile the kernel for two more levels that
    // no machine of the last ten years needs.
    match how {
        // `cargo mutants` alone sets this (tests/README.md): to compile one kernel of four for each mutant.
        #[cfg(one_lane)]
        Lanewise::Wide(_) | Lanewise::Single => add_samples(Single, scene, settings, tile, count),
        #[cfg(all(target_arch = "x86_64", not(one_lane)))]
        Lanewise::Wide(level) => {
            if let Some(simd) = level.as_avx512() {
                simd.vectorize(
                    #[inline(always)]
                    || add_samples(Wide(simd), scene, settings, tile, count),
                )
            } else if let Some(simd) = level.as_avx2() {
                simd.vectorize(
                    #[inline(always)]
                    || add_samples(Wide(simd), scene, settings, tile, count),
                )
            } else if let Some(simd) = level.as_sse4_2() {
                simd.vectorize(
                    #[inline(always)]
                    || add_samples(Wide(simd), scene, settings, tile, count),
                )
            } else {
                add_samples(Single, scene, settings, tile, count)
            }
        }
        #[cfg(not(any(target_arch = "x86_64", one_lane)))]
        Lanewise::Wide(level) => dispatch!(level, simd => add_samples(Wide(simd), scene, settings, tile, count)),
        #[cfg(not(one_lane))]
        Lanewise::Single => add_samples(Single, scene, settings, tile, count),
    }
}

#[inline(always)]
fn add_samples<L: Lanes>(l: L, scene: &BuiltScene, settings: &Settings, tile: &mut Tile, count: u32) -> u64 {
    let mut invalid = 0;
    let wanted = Dimension::wanted(settings.strategy, scene.lights.list.len() > 1, scene.has_two_lobes);
    let mut sampler = Sampler::new(l, &settings.sampler, wanted);
    for [min, max] in tile.patches() {
        let near = scene.patches.candidates(&scene.camera, tile.corner_at(min), tile.corner_at(max));
        for row in min[1]..max[1] {
            for column in min[0]..max[0] {
                let block = tile.block_index([column, row]);
                let [x0, y0] = tile.corner_at([column, row]);
                let mut lane = 0;
                while lane < PACKET {
                    let pixel = l.iota() + l.u(lane as u32);
                    let x = (pixel & l.u(BLOCK - 1)) + l.u(x0);
                    let y = (pixel >> BLOCK.trailing_zeros()) + l.u(y0);
                    sampler.start(pixel_keys(l, settings.seed, x, y));
                    for index in tile.samples..tile.samples + count {
                        let random = sampler.draw(index);
                        let sample = sample(l, scene, settings, [x.to_real(), y.to_real()], &random, &near);
                        invalid += u64::from(tile.add(l, (block, lane), index, &sample));
                    }
                    lane += L::N;
                }
            }
        }
    }
    tile.samples += count;
    invalid
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
    // Packets are small patches of the image: nearly always all lanes meet the same surface. Where
    // not, there is one round for each surface met.
    let mut todo = hit.surface;
    while todo.any() {
        let id = hit.id.lane(todo.bits().trailing_zeros() as usize);
        let here = todo & hit.id.eq(l.u(id));
        todo = todo & !here;
        if let Some(surface) = scene.surface(l, id, hit.p, dir) {
            let round = reflected_radiance(l, scene, settings, &surface, -dir, random, near);
            reflected = if here.all() { round } else { Reflected::select(here, &round, &reflected) };
        }
    }
    Sample { reflected, emitted: hit.emitted, emits: hit.emits }
}
