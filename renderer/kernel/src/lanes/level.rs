//! Which lanes a task runs in: the vector levels of this machine, and one lane.

#[cfg(target_arch = "x86_64")]
use super::Simd;
#[cfg(all(target_arch = "x86_64", not(one_lane)))]
use super::Twice;
#[cfg(not(one_lane))]
use super::Wide;
#[cfg(not(any(target_arch = "x86_64", one_lane)))]
use super::dispatch;
use super::{Lanes, Level, Single};

/// How the kernel runs. All ways give the same bits but SSE4.2, which cannot multiply and add at once.
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

    /// Every way this machine can run and kernels are compiled for (see the feature `all-levels`), the fastest first.
    pub fn all() -> Vec<Self> {
        let best = Level::new();
        let mut ways = vec![Self::Wide(best)];
        #[cfg(target_arch = "x86_64")]
        for level in [
            best.as_avx2().filter(|_| cfg!(level = "avx2")).map(Simd::level),
            best.as_sse4_2().filter(|_| cfg!(level = "sse4_2")).map(Simd::level),
        ]
        .into_iter()
        .flatten()
        {
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
            // `cargo mutants` alone sets this (tests/FAULTS.md): to compile one kernel of four for each mutant.
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
            Self::Single => fused(
                #[inline(always)]
                || task.run(Single),
            ),
        }
    }

    /// Short name, e.g. "AVX-512".
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide(level) => level_name(level),
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

/// Does a task on one lane, with the instruction that multiplies and adds at once if the machine has it: elsewhere every
/// [`super::Real::mul_add`] of [`Single`] is a library call. The task must be `#[inline(always)]`.
pub fn fused<R>(task: impl FnOnce() -> R) -> R {
    #[cfg(all(target_arch = "x86_64", not(one_lane)))]
    if let Some(simd) = Level::new().as_avx2() {
        return simd.vectorize(task);
    }
    task()
}

/// Something to be done in lanes. `run` has to be `#[inline(always)]`, as all lane code.
pub trait Task {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run<L: Lanes>(self, l: L) -> Self::Output;
}

/// Short name of the level that [`Wide`] runs at.
pub fn level_name(level: Level) -> &'static str {
    let text = format!("{level:?}");
    if text.starts_with("Avx512") {
        "AVX-512"
    } else if text.starts_with("Avx2") {
        "AVX2"
    } else if text.starts_with("Sse4_2") {
        "SSE4.2"
    } else if text.starts_with("Sse2") {
        "SSE2"
    } else if text.starts_with("Neon") {
        "NEON"
    } else {
        "scalar"
    }
}
