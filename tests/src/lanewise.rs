//! Running a piece of lane code at a vector level of choice.

use mislab_renderer::kernel::Lanewise;
use mislab_renderer::lanes::{Lanes, Single, Wide, dispatch};

/// Something to be done in lanes. `run` has to be `#[inline(always)]`, as all lane code.
pub trait Task {
    /// What comes of it.
    type Output;
    /// Does it.
    fn run<L: Lanes>(self, l: L) -> Self::Output;
}

/// Runs a task as the renderer's kernel would.
pub fn run<T: Task>(how: Lanewise, task: T) -> T::Output {
    match how {
        Lanewise::Wide(level) => dispatch!(level, simd => task.run(Wide(simd))),
        Lanewise::Single => task.run(Single),
    }
}
