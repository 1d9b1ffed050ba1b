//! Throughput of the kernel, by strategy, sampler and vector level: `cargo bench -p mislab-renderer`.

use divan::Bencher;
use divan::counter::ItemsCount;
use mislab_kernel::film::Tile;
use mislab_kernel::lanes::Lanewise;
use mislab_kernel::stop::Stop;
use mislab_kernel::tile::render_tile;
use mislab_kernel::world::BuiltScene;
use mislab_renderer::{Estimator, PixelRect, SamplerKind, SamplerSettings, Sampling, Settings, Strategy, pbrt};

fn main() {
    divan::main();
}

/// Samples per pixel of one call.
const BURST: u32 = 8;

/// A tile across the plates, the floor and the wall behind them.
fn tile(bencher: Bencher<'_, '_>, how: Lanewise, strategy: Strategy, kind: SamplerKind) {
    let base = Settings::default();
    let settings = Settings {
        estimator: Estimator { strategy, ..base.estimator },
        sampling: Sampling { sampler: SamplerSettings { kind, ..base.sampling.sampler }, ..base.sampling },
        ..base
    };
    let scene = BuiltScene::new(&pbrt::embedded_scene().scene, &settings).expect("the scene can be built");
    let bounds = PixelRect { min: [0, 480], max: [800, 488] };
    let paths = 800 * 8 * BURST * strategy.rays_per_sample();
    let mut buffers = Some(Tile::new(bounds, strategy, None));
    bencher.counter(ItemsCount::new(paths)).bench_local(|| {
        let mut tile = Tile::new(bounds, strategy, buffers.take());
        let invalid = render_tile(how, &scene, &settings, &mut tile, BURST, Stop::NEVER);
        buffers = Some(tile);
        invalid
    });
}

/// Every level of this machine with every strategy.
fn levels_and_strategies() -> impl Iterator<Item = (&'static str, Strategy)> {
    Lanewise::all().into_iter().flat_map(|how| Strategy::ALL.map(|strategy| (how.name(), strategy)))
}

#[divan::bench(args = levels_and_strategies())]
fn levels(bencher: Bencher<'_, '_>, (name, strategy): (&str, Strategy)) {
    let how = Lanewise::all().into_iter().find(|how| how.name() == name).expect("a level of this machine");
    tile(bencher, how, strategy, SamplerKind::Stratified);
}

/// Every sampler with every strategy.
fn samplers_and_strategies() -> impl Iterator<Item = (SamplerKind, Strategy)> {
    SamplerKind::ALL.into_iter().flat_map(|kind| Strategy::ALL.map(|strategy| (kind, strategy)))
}

#[divan::bench(args = samplers_and_strategies())]
fn samplers(bencher: Bencher<'_, '_>, (kind, strategy): (SamplerKind, Strategy)) {
    tile(bencher, Lanewise::best(), strategy, kind);
}
