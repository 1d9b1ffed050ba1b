//! Two lanes at a time give what each of them gives alone, to the bit: masks and shortcuts ("if any lane ...") let no
//! lane see another.

use mislab_kernel::bsdf::Surface;
use mislab_kernel::estimator::{Contribution, Reflected};
use mislab_kernel::film::{Rest, Sample, Tile};
use mislab_kernel::geometry::grid::BLOCK;
use mislab_kernel::lanes::{Lanes, Mask, Real, Single, V3};
use mislab_kernel::sampler::{Numbers, pixel_keys};
use mislab_kernel::world::{BuiltScene, View};
use mislab_renderer::{PixelRect, SamplerKind, SamplerSettings, Sampling, Settings, Strategy};
use mislab_tests::draws::Draws;
use mislab_tests::two_lanes::{Floats, Integers, Truths, Two};

use crate::estimator::{SIDE, all_settings, scenes};
use crate::once;

/// Bits of a vector in one lane.
fn vector<L: Lanes>(v: V3<L>, lane: usize) -> [u32; 3] {
    [v.x, v.y, v.z].map(|x| x.lane(lane).to_bits())
}

/// Bits of everything in one lane.
fn contribution<L: Lanes>(c: &Contribution<L>, lane: usize) -> ([u32; 3], u32, bool) {
    (vector(c.value, lane), c.weight.lane(lane).to_bits(), c.lit.bits() >> lane & 1 == 1)
}

fn bits<L: Lanes>(r: &Reflected<L>, lane: usize) -> [([u32; 3], u32, bool); 2] {
    [contribution(&r.light, lane), contribution(&r.bsdf, lane)]
}

#[inline(never)]
fn draw(settings: &Settings, keys: Integers, patch: u32, index: u32) -> Numbers<Two> {
    let mut sampler = Draws::of(Two, settings);
    sampler.start(keys, patch);
    sampler.draw(index)
}

#[test]
fn samples_of_two_pixels() {
    let all = all_settings();
    let mut mixed = [0; 4];
    let mut pairs = 0;
    for (name, scene) in scenes() {
        let built = BuiltScene::new(&scene, &all[0]).expect("the scene can be built");
        for pixel in (0..SIDE * SIDE).step_by(2) {
            let [x, y] = [pixel % SIDE, pixel / SIDE];
            let corner = [x / 8 * 8, y / 8 * 8];
            let near = built.patches.cull(&built.camera, corner, corner.map(|c| c + 8));
            let x2 = Floats([x as f32 + 0.5, x as f32 + 1.5]);
            let dir = built.camera.direction(Two, x2, Floats([y as f32 + 0.5; 2]));
            let view = View { l: Two, scene: &built, culled: &near };
            let single = View { l: Single, scene: &built, culled: &near };
            let hit = view.camera_hit(dir);
            let each = [0, 1].map(|lane| {
                let dir = built.camera.direction(Single, x2.0[lane], y as f32 + 0.5);
                (dir, once::camera_hit(&built, dir, &near))
            });
            let shapes = [0, 1].map(|lane| hit.shapes.map_or(hit.first, |shapes| shapes.0[lane]));
            for (lane, (_, one)) in each.iter().enumerate() {
                let found = (hit.surface.0[lane], hit.emits.0[lane], vector(hit.emitted, lane));
                let what = format!("{name}, pixel {x} + {lane}, {y}");
                assert_eq!(found, (one.surface, one.emits, vector(one.emitted, 0)), "{what}");
                if one.surface {
                    let found = (shapes[lane], vector(hit.points.p, lane), vector(hit.points.n, lane));
                    let alone = (one.first, vector(one.points.p, 0), vector(one.points.n, 0));
                    assert_eq!(found, alone, "{what}");
                }
            }
            if !hit.surface.all() || shapes[0] != shapes[1] {
                continue;
            }
            let Some(material) = built.material(shapes[0]) else { continue };
            let surface = Surface { material, ..hit.points };
            for (i, settings) in all.iter().enumerate() {
                // Samplers in turn.
                let kind = SamplerKind::ALL[i % SamplerKind::ALL.len()];
                let sampler = SamplerSettings { kind, strata: [2, 3], jitter: true };
                let settings = &Settings { sampling: Sampling { sampler, ..settings.sampling }, ..settings.clone() };
                let keys = [once::key(i as u32, x, y), once::key(i as u32, x + 1, y)];
                let wide = pixel_keys(Two, i as u32, Integers([x, x + 1]), Integers([y; 2]));
                assert_eq!(wide.0, keys.map(|key| key.0), "keys");
                let patch = once::patch(i as u32, x, y);
                let random = draw(settings, wide, patch, pixel);
                let found = once::reflected(view, settings, &surface, -dir, &random);
                let alone = [0, 1].map(|lane| {
                    let (dir, hit) = &each[lane];
                    let surface = once::surface(&built, hit).expect("the surface scatters");
                    let mut sampler = Draws::of(Single, settings);
                    sampler.start(keys[lane], patch);
                    let random = once::draw(&mut sampler, pixel);
                    once::reflected(single, settings, &surface, -*dir, &random)
                });
                for (lane, alone) in alone.iter().enumerate() {
                    let what = || format!("{name}, pixel {x} + {lane}, {y}, {settings:?}");
                    assert_eq!(bits(&found, lane), bits(alone, 0), "{}", what());
                }
                // All four ways of carrying light must come up.
                let [a, b] = alone.map(|r| r.light.lit || r.bsdf.lit);
                mixed[usize::from(a) + 2 * usize::from(b)] += 1;
                pairs += 1;
            }
        }
    }
    assert!(pairs > 20_000 && mixed.iter().all(|&count| count > 1000), "{pairs} pairs: {mixed:?}");
}

/// Selecting between two samples takes every part of either from the same one.
#[test]
fn samples_are_selected_as_a_whole() {
    let part = |x: f32, lit: [bool; 2]| Contribution::<Two> {
        value: V3 { x: Floats([x, x + 1.0]), y: Floats([x + 2.0, x + 3.0]), z: Floats([x + 4.0, x + 5.0]) },
        weight: Floats([x + 6.0, x + 7.0]),
        lit: Truths(lit),
    };
    for i in 0..16u32 {
        let bit = |k: u32| i >> k & 1 == 1;
        let a = Reflected { light: part(10.0, [bit(0), bit(1)]), bsdf: part(20.0, [bit(1), bit(2)]) };
        let b = Reflected { light: part(30.0, [bit(2), bit(3)]), bsdf: part(40.0, [bit(3), bit(0)]) };
        for (a, b) in [(a.light, b.light), (a.bsdf, b.bsdf)] {
            let selected = a.or(&b);
            for lane in 0..2 {
                let expected = if a.lit.0[lane] { &a } else { &b };
                assert_eq!(contribution(&selected, lane), contribution(expected, lane), "{i}, lane {lane}");
            }
        }
    }
    assert_eq!(contribution(&Contribution::none(Two), 1), ([0; 3], 0, false));
}

/// All of a sample to the first block; how many were invalid.
fn add<L: Lanes>(tile: &mut Tile, l: L, lane: usize, index: u32, sample: &Sample<L>) -> u32 {
    let rest = tile.add(l, (0, lane), index, sample);
    tile.finish(l, (0, lane), index, &rest)
}

/// What is left of two samples is exchanged in some lanes, as if other samples had been added there.
#[test]
fn rests_of_samples_are_exchanged_lane_by_lane() {
    let sample = |x: [f32; 2], emits: [bool; 2]| {
        let part = Contribution::<Two> { value: V3::all(Floats(x)), weight: Floats([1.0; 2]), lit: Truths([true; 2]) };
        let emitted = V3::all(Floats([0, 1].map(|lane| if emits[lane] { 10.0 * x[lane] } else { 0.0 })));
        Sample { reflected: Reflected { light: part, bsdf: part }, emitted, emits: Truths(emits) }
    };
    let new = || Tile::new(PixelRect { min: [0, 0], max: BLOCK }, Strategy::MisAll, None);
    let at = (0, 4);
    let truths = [[false, false], [true, false], [false, true], [true, true]];
    for (swapped, (first, second)) in
        truths.into_iter().flat_map(|m| truths.into_iter().flat_map(move |a| truths.map(|b| (m, (a, b)))))
    {
        for x in [[1.0, 2.0], [f32::NAN, 2.0], [1.0, f32::INFINITY]] {
            let y = [3.0, 5.0];
            let pick = |a: [f32; 2], b: [f32; 2]| [0, 1].map(|i| if swapped[i] { a[i] } else { b[i] });
            let pick_truth = |a: [bool; 2], b: [bool; 2]| [0, 1].map(|i| if swapped[i] { a[i] } else { b[i] });
            let (mut exchanged, mut expected) = (new(), new());
            let [a, b] = [sample(x, first), sample(y, second)].map(|sample| exchanged.add(Two, at, 0, &sample));
            let rest = Rest::select(Truths(swapped), &a, &b);
            // The same sums of techniques.
            for sample in [sample(x, first), sample(y, second)] {
                expected.add(Two, at, 0, &sample);
            }
            let mixed = new().add(Two, at, 0, &sample(pick(x, y), pick_truth(first, second)));
            let invalid = [exchanged.finish(Two, at, 0, &rest), expected.finish(Two, at, 0, &mixed)];
            assert_eq!(invalid[0], invalid[1], "{swapped:?}, {first:?}, {second:?}, {x:?}: invalid samples");
            assert!(exchanged == expected, "{swapped:?}, {first:?}, {second:?}, {x:?}");
        }
    }
}

/// Each lane is valid or not for itself.
#[test]
fn invalid_samples_are_counted_lane_by_lane() {
    let part = |x: [f32; 2]| Contribution::<Two> {
        value: V3 { x: Floats(x), y: Floats(x), z: Floats(x) },
        weight: Floats([1.0; 2]),
        lit: Truths([true; 2]),
    };
    let emitted = V3::all(Floats([0.5; 2]));
    for bare in [false, true] {
        for strategy in Strategy::ALL {
            let mut tile = Tile::new(PixelRect { min: [0, 0], max: BLOCK }, strategy, None);
            tile.bare = bare;
            for (index, [a, b]) in
                [[1.0, 2.0], [f32::NAN, 1.0], [1.0, f32::INFINITY], [1e30, f32::NAN]].into_iter().enumerate()
            {
                let reflected = Reflected { light: part([a, b]), bsdf: part([b, a]) };
                let sample = Sample { reflected, emitted, emits: Truths([true; 2]) };
                // The sum of the techniques is what counts.
                let expected = if index == 0 { 0 } else { 2 };
                assert_eq!(add(&mut tile, Two, 2, index as u32, &sample), expected, "{a} and {b}");
                let reflected = Reflected { light: part([a, b]), bsdf: part([0.0; 2]) };
                let sample = Sample { reflected, emitted, emits: Truths([false; 2]) };
                let expected = [0, 1, 1, 2][index];
                assert_eq!(add(&mut tile, Two, 4, index as u32, &sample), expected, "{a} and {b}");
            }
        }
    }
}

/// Sums of a pixel, with what rounding has kept from them, are those it has alone, whatever its neighbour adds.
#[test]
fn pixels_are_summed_alone() {
    let bounds = PixelRect { min: [0, 0], max: BLOCK };
    let new = || Tile::new(bounds, Strategy::MisAll, None);
    let (mut both, mut alone) = (new(), new());
    let random = |index: u32, lane: u32, what: u32| {
        let bits = once::key(what, index, lane).0;
        // Now and then far above the sum so far: then what rounding has kept may be more than half a unit of it.
        (bits >> 8) as f32 * 0.25f32.powi((bits & 15) as i32)
    };
    const ROUND: u32 = 16;
    for number in 0..1000 * ROUND {
        let index = number % ROUND;
        if index == 0 {
            (both, alone) = (new(), new());
        }
        let lit = |what| [0, 1].map(|lane| once::key(what, number, lane).0 >> 12 & 1 == 0);
        let part = |what: u32| {
            let x = [0, 1].map(|lane| random(number, lane, what));
            let value = V3 { x: Floats(x), y: Floats(x.map(|x| 3.0 * x)), z: Floats(x.map(|x| x / 3.0)) };
            Contribution::<Two> { value, weight: Floats(x.map(|x| x / 64.0)), lit: Truths(lit(what + 1)) }
        };
        let (light, bsdf) = (part(10), part(20));
        let emitted = [0, 1].map(|lane| random(number, lane, 30));
        let emits = lit(31);
        let emitted = [0, 1].map(|lane| if emits[lane] { emitted[lane] } else { 0.0 });
        let reflected = Reflected { light, bsdf };
        let sample = Sample { reflected, emitted: V3::all(Floats(emitted)), emits: Truths(emits) };
        assert_eq!(add(&mut both, Two, 2, index, &sample), 0, "valid");
        for lane in 0..2 {
            let one = |c: &Contribution<Two>| Contribution::<Single> {
                value: V3 { x: c.value.x.lane(lane), y: c.value.y.lane(lane), z: c.value.z.lane(lane) },
                weight: c.weight.lane(lane),
                lit: c.lit.0[lane],
            };
            let reflected = Reflected { light: one(&light), bsdf: one(&bsdf) };
            let sample = Sample { reflected, emitted: V3::all(emitted[lane]), emits: emits[lane] };
            add(&mut alone, Single, 2 + lane, index, &sample);
        }
        assert!(both == alone, "sample {number}: neighbours change a sum");
    }
}
