//! The film: what a frame shows is the sums in f64 of the samples that the estimator returns, pixel by pixel.

use std::collections::HashMap;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use mislab_kernel::estimator::Contribution;
use mislab_kernel::film::Tile;
use mislab_kernel::lanes::{Lanewise, Single};
use mislab_kernel::sampler::Dimension;
use mislab_kernel::world::{BuiltScene, View};
use mislab_renderer::{
    Bsdf, Channel, Estimator, Frame, ImageSettings, Material, Pace, Picture, PixelRect, Renderer, Request, SamplerKind,
    SamplerSettings, Sampling, Scene, Settings, State, Strategy, engine,
};
use mislab_tests::draws::Draws;
use mislab_tests::experiment::veach;
use mislab_tests::oracle::LUMINANCE;

use crate::once::{self, d};

/// Sums over the valid samples of a pixel by one technique: contributions, weights, and how many carried light.
#[derive(Clone, Copy, Debug, Default)]
struct Technique {
    value: DVec3,
    weight: f64,
    count: f64,
}

impl Technique {
    fn add(&mut self, part: &Contribution<Single>) {
        if part.lit {
            self.value += d(part.value);
            self.weight += f64::from(part.weight);
            self.count += 1.0;
        }
    }
}

/// Everything that a frame is worked out from.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    light: Technique,
    bsdf: Technique,
    emitted: DVec3,
    squares: f64,
    invalid: u64,
}

/// Adds up the first `spp` samples of a pixel, one after the other.
fn sums(scene: &BuiltScene, settings: &Settings, [x, y]: [u32; 2], spp: u32) -> Sums {
    let mut sampler = Draws::of(Single, settings);
    sampler.start(once::key(settings.sampling.seed, x, y), once::patch(settings.sampling.seed, x, y));
    let corner = [x / 8 * 8, y / 8 * 8];
    let near = scene.patches.cull(&scene.camera, corner, corner.map(|c| c + 8));
    let view = View { l: Single, scene, culled: &near };
    let mut sums = Sums::default();
    for index in 0..spp {
        let random = once::draw(&mut sampler, index);
        let [jx, jy] = random.get_2d(Dimension::Pixel);
        let dir = scene.camera.direction(Single, x as f32 + jx, y as f32 + jy);
        let hit = once::camera_hit(scene, dir, &near);
        let reflected = hit
            .surface
            .then(|| once::surface(scene, &hit))
            .flatten()
            .map(|surface| once::reflected(view, settings, &surface, -dir, &random));
        let parts = reflected.map_or(DVec3::ZERO, |r| d(r.light.value) + d(r.bsdf.value));
        let y = LUMINANCE.dot(parts + d(hit.emitted));
        // What cannot be squared in single precision is left out.
        if y.is_nan() || y * y > f64::from(f32::MAX) {
            sums.invalid += 1;
            continue;
        }
        if let Some(reflected) = reflected {
            sums.light.add(&reflected.light);
            sums.bsdf.add(&reflected.bsdf);
        }
        sums.emitted += d(hit.emitted);
        sums.squares += y * y;
    }
    sums
}

fn render(scene: &Scene, settings: &Settings) -> Arc<Frame> {
    let request = Request { scene: Arc::new(scene.clone()), settings: settings.clone() };
    engine::render_with(&request, 1, Lanewise::Single, &mut |_| true).expect("the request can be rendered")
}

/// Compares every channel of every pixel; returns how many samples carried light by either technique and how many
/// pixels show a light.
fn check(scene: &Scene, settings: &Settings, frame: &Frame) -> [f64; 3] {
    let built = BuiltScene::new(scene, settings).expect("the scene can be built");
    let bounds = frame.bounds();
    let spp = frame.spp();
    let n = f64::from(spp);
    let planes: Vec<(Channel, Vec<f32>)> = Channel::ALL.iter().map(|&c| (c, frame.channel(c))).collect();
    let (mut invalid, mut seen) = (0, [0.0; 3]);
    for i in 0..bounds.area() {
        let at = [bounds.min[0] + i as u32 % bounds.width(), bounds.min[1] + i as u32 / bounds.width()];
        let Sums { light, bsdf, emitted, squares, invalid: left_out } = sums(&built, settings, at, spp);
        invalid += left_out;
        seen[0] += light.count;
        seen[1] += bsdf.count;
        seen[2] += f64::from(u8::from(emitted != DVec3::ZERO));
        let total = light.value + bsdf.value + emitted;
        let y = LUMINANCE.dot(total);
        let share = LUMINANCE.dot(light.value) / LUMINANCE.dot(light.value + bsdf.value);
        for (channel, plane) in &planes {
            let found = plane[i];
            // The value and the scale of its rounding.
            let (expected, scale) = match channel {
                Channel::R => (total.x / n, total.x / n),
                Channel::G => (total.y / n, total.y / n),
                Channel::B => (total.z / n, total.z / n),
                Channel::LightR => (light.value.x / n, light.value.x / n),
                Channel::LightG => (light.value.y / n, light.value.y / n),
                Channel::LightB => (light.value.z / n, light.value.z / n),
                Channel::BsdfR => (bsdf.value.x / n, bsdf.value.x / n),
                Channel::BsdfG => (bsdf.value.y / n, bsdf.value.y / n),
                Channel::BsdfB => (bsdf.value.z / n, bsdf.value.z / n),
                Channel::WeightLightY => (light.weight / light.count, 1.0),
                Channel::WeightBsdfY => (bsdf.weight / bsdf.count, 1.0),
                Channel::ShareLightY => (share, 1.0),
                // Each of the squares is a number, their sum in single precision may be none.
                Channel::VarianceY if squares > f64::from(f32::MAX) => (f64::NAN, 0.0),
                Channel::VarianceY => ((squares - y * y / n) / (n - 1.0), squares / (n - 1.0)),
            };
            let off = (f64::from(found) - expected).abs();
            // A square has twice the error of its root.
            let ulps = if *channel == Channel::VarianceY { 6e-7 } else { 3e-7 };
            let right = found.is_nan() && expected.is_nan() || off <= ulps * scale;
            let name = channel.exr_name();
            assert!(right, "{settings:?}, pixel {at:?}, {name}: {found}, expected {expected}");
            // The pixel asked for alone.
            let alone = frame.pixel(at[0], at[1], *channel).expect("the pixel is in the frame");
            assert_eq!(alone.to_bits(), found.to_bits(), "{settings:?}, pixel {at:?}, {name}");
        }
    }
    assert_eq!(frame.stats().invalid_samples, invalid, "{settings:?}: invalid samples");
    seen
}

fn settings(strategy: Strategy, spp: u32, resolution: [u32; 2]) -> Settings {
    let sampler = SamplerSettings { kind: SamplerKind::Stratified, strata: [2, 3], jitter: true };
    Settings {
        estimator: Estimator { strategy, ..Estimator::default() },
        sampling: Sampling { sampler, spp: NonZeroU32::new(spp), seed: 11 },
        image: ImageSettings { resolution, ..ImageSettings::default() },
    }
}

/// Tiles hold each pixel once, and lie on one grid, so that a crop window computes the same packets.
#[test]
fn tiles_cover_a_picture() {
    for (min, max) in [
        ([0, 0], [1, 1]),
        ([0, 0], [800, 8]),
        ([0, 0], [1600, 24]),
        ([3, 5], [801, 17]),
        ([799, 7], [800, 8]),
        ([800, 8], [2401, 9]),
        ([1234, 56], [2345, 78]),
    ] {
        let tiles = Tile::cut(PixelRect { min, max });
        let mut count = HashMap::new();
        for tile in &tiles {
            assert!(tile.area() > 0, "{min:?} to {max:?}: {tile:?} is empty");
            let cell = |[x, y]: [u32; 2]| [x / Tile::SIZE[0], y / Tile::SIZE[1]];
            assert_eq!(cell(tile.min), cell(tile.max.map(|edge| edge - 1)), "{tile:?} lies across the grid");
            for y in tile.min[1]..tile.max[1] {
                for x in tile.min[0]..tile.max[0] {
                    *count.entry([x, y]).or_insert(0) += 1;
                }
            }
        }
        let pixels = (max[0] - min[0]) * (max[1] - min[1]);
        let inside = count.keys().all(|p| (0..2).all(|axis| (min[axis]..max[axis]).contains(&p[axis])));
        let once = count.values().all(|&count| count == 1);
        assert!(count.len() == pixels as usize && inside && once, "{min:?} to {max:?}: {tiles:?}");
    }
}

#[test]
fn frames_show_the_sums_of_their_samples() {
    let mut seen = [0.0; 3];
    for strategy in Strategy::ALL {
        for (spp, resolution, crop) in [
            // Sides that no block or tile divides; one pixel; windows that begin inside blocks and tiles.
            (5, [61, 43], [0.0, 1.0, 0.0, 1.0]),
            (1, [1, 1], [0.0, 1.0, 0.0, 1.0]),
            (2, [3, 9], [0.0, 1.0, 0.0, 1.0]),
            (1, [1650, 18], [0.0, 1.0, 0.0, 1.0]),
            (2, [1650, 30], [0.47, 0.53, 0.4, 0.9]),
            (3, [77, 130], [0.1, 0.37, 0.21, 0.83]),
        ] {
            let base = settings(strategy, spp, resolution);
            let settings = Settings { image: ImageSettings { crop, ..base.image }, ..base };
            let scene = veach();
            let counts = check(&scene, &settings, &render(&scene, &settings));
            for (seen, count) in seen.iter_mut().zip(counts) {
                *seen += count;
            }
        }
    }
    assert!(seen[0] > 30_000.0 && seen[1] > 2000.0 && seen[2] > 500.0, "{seen:?}");
}

#[test]
fn sums_keep_their_precision() {
    // Lights seen through the pixels, plates and wall; a plain sum would be off by 1e-5.
    let scene = veach();
    let mut pictures = 0;
    for (strategy, crop) in [(Strategy::MisAll, [0.3, 0.43, 0.18, 0.3]), (Strategy::Mis, [0.15, 0.31, 0.6, 0.75])] {
        let base = settings(strategy, 5000, [16, 16]);
        let settings = Settings { image: ImageSettings { crop, ..base.image }, ..base };
        let counts = check(&scene, &settings, &render(&scene, &settings));
        assert!(counts[0] > 5000.0 && counts[1] > 500.0, "{counts:?}");
        pictures += usize::from(counts[2] > 0.0);
    }
    assert!(pictures > 0, "some pixel shows a light");
}

#[test]
fn samples_that_are_no_numbers_are_counted_and_left_out() {
    // Squares of luminances beyond 1.8e19 overflow: here they are samples of some surfaces, and the lights themselves.
    let mut scene = veach();
    for shape in &mut scene.shapes {
        if let Some(light) = &mut shape.light {
            light.radiance *= 3e18;
        }
    }
    let mut unknown = 0;
    for strategy in Strategy::ALL {
        let settings = settings(strategy, 6, [40, 30]);
        let frame = render(&scene, &settings);
        let samples = 6 * 40 * 30;
        let invalid = frame.stats().invalid_samples;
        assert!(invalid > 20 && invalid < samples / 2, "{}: {invalid} of {samples}", strategy.name());
        // Squares that are numbers may add up to more than one: such a variance is unknown, not 0.
        unknown += frame.channel(Channel::VarianceY).iter().filter(|v| v.is_nan()).count();
        check(&scene, &settings, &frame);
    }
    assert!(unknown > 0, "no squares overflow");
}

/// What a light emits and what its surface reflects are one sample.
#[test]
fn lights_that_reflect_add_up() {
    let mut scene = veach();
    let chalk = scene.materials.len();
    scene.materials.push(Material { name: "chalk".to_owned(), bsdf: Bsdf::Matte { kd: Vec3::splat(0.8) } });
    // Dim, so that what the others' light adds matters.
    for (i, shape) in scene.shapes.iter_mut().filter(|shape| shape.light.is_some()).enumerate() {
        shape.material = Some(chalk);
        if let Some(light) = &mut shape.light {
            light.radiance *= if i == 1 { 1.0 } else { 1e-3 };
        }
    }
    for strategy in Strategy::ALL {
        let settings = settings(strategy, 5, [60, 60]);
        let [.., lights] = check(&scene, &settings, &render(&scene, &settings));
        assert!(lights > 20.0, "{}: {lights} pixels show a light", strategy.name());
    }
}

fn wait(picture: &Picture, spp: u32, state: State) -> Arc<Frame> {
    let start = Instant::now();
    loop {
        let status = picture.status();
        assert!(status.error.is_none() && status.worker_panics == 0, "{status:?}");
        if status.state == state && status.spp == spp {
            return picture.latest().expect("there is a frame");
        }
        assert!(start.elapsed() < Duration::from_secs(10), "{spp} samples were never reached: {status:?}");
        std::thread::sleep(Duration::from_micros(200));
    }
}

/// Frames are kept while their picture goes on, and their memory is used again when they are let go.
#[test]
fn frames_stay_what_they_were() {
    let renderer = Renderer::with_lanes(1, Lanewise::Single, || {});
    let picture = renderer.add_picture();
    let scene = veach();
    picture.set_pace(Pace::Paused);
    for (strategy, resolution) in [
        (Strategy::MisAll, [31, 20]),
        (Strategy::Light, [31, 20]),
        (Strategy::Mis, [31, 20]),
        (Strategy::Bsdf, [31, 20]),
        (Strategy::Bsdf, [33, 21]),
        (Strategy::MisAll, [33, 21]),
    ] {
        let settings = settings(strategy, 1000, resolution);
        picture.submit(Request { scene: Arc::new(scene.clone()), settings: settings.clone() });
        let mut frames = Vec::new();
        for pass in 1..=4 {
            frames.push(wait(&picture, pass, State::Paused));
            picture.step();
        }
        drop(frames.remove(1));
        wait(&picture, 5, State::Paused);
        for pass in 6..=8 {
            picture.step();
            frames.push(wait(&picture, pass, State::Paused));
        }
        for frame in &frames {
            check(&scene, &settings, frame);
        }
    }
}

/// A picture of many passes, each of them copied from one buffer to another since somebody keeps the frame.
#[test]
fn copies_keep_their_precision() {
    let renderer = Renderer::with_lanes(1, Lanewise::Single, || {});
    let picture = renderer.add_picture();
    let scene = veach();
    let settings = settings(Strategy::MisAll, 1000, [11, 7]);
    picture.set_pace(Pace::Paused);
    picture.submit(Request { scene: Arc::new(scene.clone()), settings: settings.clone() });
    let mut kept = wait(&picture, 1, State::Paused);
    for pass in 2..=600 {
        picture.step();
        let frame = wait(&picture, pass, State::Paused);
        // The one before the last is let go, and its memory used again.
        kept = frame;
    }
    check(&scene, &settings, &kept);
}

/// What a buffer held before is forgotten, its rounding errors too: those of a picture a hundred million times as bright
/// would show.
#[test]
fn buffers_forget() {
    let renderer = Renderer::with_lanes(1, Lanewise::Single, || {});
    let picture = renderer.add_picture();
    let dark = veach();
    let mut bright = veach();
    for shape in &mut bright.shapes {
        if let Some(light) = &mut shape.light {
            light.radiance *= 1e8;
        }
    }
    picture.set_pace(Pace::Paused);
    for strategy in Strategy::ALL {
        for (scene, spp) in [(&bright, 6), (&dark, 5), (&bright, 4), (&dark, 1), (&bright, 5), (&dark, 2)] {
            let settings = settings(strategy, 1000, [21, 17]);
            picture.submit(Request { scene: Arc::new(scene.clone()), settings: settings.clone() });
            // One pass after the other, so that each copies what the last one left.
            let mut frame = wait(&picture, 1, State::Paused);
            for pass in 2..=spp {
                picture.step();
                frame = wait(&picture, pass, State::Paused);
            }
            check(scene, &settings, &frame);
        }
    }
}
