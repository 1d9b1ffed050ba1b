//! What the processor time of the process went into: samples, or all the rest.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use cpu_time::ProcessTime;

/// Nanoseconds of all workers of the process, of all renderers, that went into scenes and samples.
static RENDERING: AtomicU64 = AtomicU64::new(0);

/// Counts processor time of a worker that went into a scene or into samples.
pub(super) fn add(time: Duration) {
    RENDERING.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
}

/// Processor time of the process so far, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// All of it.
    pub all: f64,
    /// What did not go into scenes and samples: windows and their drivers on whatever thread, the copies that frames
    /// cost, measuring, files. A worker counts a tile in when it is done, so that this is too high by
    /// what the workers have in hand: 2 ms each.
    pub beside_rendering: f64,
}

impl Spent {
    /// By now. All zeros where the system does not tell.
    pub fn now() -> Self {
        let Ok(process) = ProcessTime::try_now() else { return Self::default() };
        let all = process.as_duration().as_secs_f64();
        let rendering = Duration::from_nanos(RENDERING.load(Ordering::Relaxed)).as_secs_f64();
        Self { all, beside_rendering: all - rendering }
    }
}
