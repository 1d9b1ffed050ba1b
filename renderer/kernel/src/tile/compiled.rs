//! The loop over a tile, compiled for every level and strategy: a module for each, since the compiler works on modules
//! side by side.

use super::Job;
use crate::lanes::{self, Lanewise};
use crate::request::Strategy;
use crate::stop::Stopped;

/// Does the job with the kernel of its strategy, in these lanes.
pub(super) fn run(how: Lanewise, job: Job<'_>) -> Result<u64, Stopped> {
    match how {
        // `cargo mutants` alone sets this (tests/FAULTS.md): to compile one kernel of four for each mutant.
        #[cfg(one_lane)]
        Lanewise::Wide(_) | Lanewise::Single => single::run((), job),
        #[cfg(not(one_lane))]
        Lanewise::Single => single::run((), job),
        #[cfg(all(target_arch = "x86_64", not(one_lane)))]
        Lanewise::Wide(level) => {
            #[cfg(level = "avx512")]
            if let Some(simd) = level.as_avx512() {
                return avx512::run(simd, job);
            }
            #[cfg(level = "avx2")]
            if let Some(simd) = level.as_avx2() {
                return avx2::run(simd, job);
            }
            #[cfg(level = "sse4_2")]
            if let Some(simd) = level.as_sse4_2() {
                return sse4_2::run(simd, job);
            }
            single::run((), job)
        }
        #[cfg(not(any(target_arch = "x86_64", one_lane)))]
        Lanewise::Wide(level) => native::run(level, job),
    }
}

/// One level: how to get into it (`$inside`, with a token of type `$token`), and a module for each strategy.
macro_rules! level {
    ($level:ident, $token:ty, $simd:ident, $run:ident => $inside:expr) => {
        mod $level {
            use super::{Job, Stopped, Strategy, lanes};

            #[inline(always)]
            pub fn run(simd: $token, job: Job<'_>) -> Result<u64, Stopped> {
                match job.settings.estimator.strategy {
                    Strategy::Light => light::run(simd, job),
                    Strategy::Bsdf => bsdf::run(simd, job),
                    Strategy::MisAll => mis_all::run(simd, job),
                    Strategy::Mis => mis::run(simd, job),
                }
            }

            level!(@strategy light, Light, $token, $simd, $run => $inside);
            level!(@strategy bsdf, Bsdf, $token, $simd, $run => $inside);
            level!(@strategy mis_all, MisAll, $token, $simd, $run => $inside);
            level!(@strategy mis, Mis, $token, $simd, $run => $inside);
        }
    };
    (@strategy $name:ident, $strategy:ident, $token:ty, $simd:ident, $run:ident => $inside:expr) => {
        mod $name {
            use super::{Job, Stopped, Strategy, lanes};

            #[inline(never)]
            pub fn run($simd: $token, job: Job<'_>) -> Result<u64, Stopped> {
                macro_rules! $run {
                    ($lanes:expr) => {
                        job.run($lanes, Strategy::$strategy)
                    };
                }
                $inside
            }
        }
    };
}
level!(single, (), _nothing, run => lanes::fused(
    #[inline(always)]
    || run!(lanes::Single),
));
#[cfg(all(target_arch = "x86_64", not(one_lane), level = "avx512"))]
level!(avx512, lanes::Avx512, simd, run => lanes::Simd::vectorize(
    simd,
    #[inline(always)]
    || run!(lanes::Twice(lanes::Wide(simd))),
));
#[cfg(all(target_arch = "x86_64", not(one_lane), level = "avx2"))]
level!(avx2, lanes::Avx2, simd, run => lanes::Simd::vectorize(
    simd,
    #[inline(always)]
    || run!(lanes::Wide(simd)),
));
#[cfg(all(target_arch = "x86_64", not(one_lane), level = "sse4_2"))]
level!(sse4_2, lanes::Sse4_2, simd, run => lanes::Simd::vectorize(
    simd,
    #[inline(always)]
    || run!(lanes::Wide(simd)),
));
#[cfg(not(any(target_arch = "x86_64", one_lane)))]
level!(native, lanes::Level, level, run => lanes::dispatch!(level, simd => run!(lanes::Wide(simd))));
