//! Where the processor time of the process goes: into rendering, or beside it. A file of its own, since it is about a process.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::Instant;

use mislab_renderer::{ImageSettings, Request, Sampling, Settings, Spent, pbrt, render};

#[test]
fn rendering_and_the_rest_are_told_apart() {
    let file = pbrt::embedded_scene();
    let settings = Settings {
        sampling: Sampling { spp: NonZeroU32::new(256), ..file.settings.sampling },
        image: ImageSettings { resolution: [200, 200], ..file.settings.image },
        ..file.settings
    };
    let before = Spent::now();
    let start = Instant::now();
    render(&Request { scene: Arc::new(file.scene), settings }, 2, &mut |_| true).expect("renders");
    let rendered = Spent::now();
    let (all, beside) = (rendered.all - before.all, rendered.beside_rendering - before.beside_rendering);
    assert!(all < 3.0 * start.elapsed().as_secs_f64(), "{all} s in {:?}", start.elapsed());
    assert!((0.0..0.2 * all).contains(&beside), "{beside} of {all} s beside rendering");

    // Work of whatever else.
    let start = cpu_seconds();
    let mut sum = 0_u64;
    while cpu_seconds() - start < 0.2 {
        sum = (0..100_000).fold(sum, |sum, i| std::hint::black_box(sum.wrapping_mul(31) ^ i));
    }
    let worked = Spent::now().beside_rendering - rendered.beside_rendering;
    assert!((0.2..0.3).contains(&worked), "{worked} s beside rendering ({sum})");
}

/// Of the process, which does nothing else by now.
fn cpu_seconds() -> f64 {
    Spent::now().all
}
