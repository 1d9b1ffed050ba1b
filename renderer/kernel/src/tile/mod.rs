//! The loop over the pixels of a tile: camera ray, surface, secondary ray, film.
//!
//! One dispatch to the machine's vector unit per tile (a dispatch costs about 27 ns).

mod compiled;
pub mod replay;
mod turns;

use crate::bsdf::Surface;
use crate::estimator::{Point, Reflected};
use crate::film::{Rest, Sample, Tile};
use crate::geometry::grid::{BLOCK, PATCH};
use crate::lanes::{Lanes, Lanewise, Mask, PACKET, Uint};
use crate::request::{Estimator, Settings, Strategy};
use crate::sampler::{Dimension, Numbers, Pixels, Sampler, Which, patch_key, pixel_keys};
use crate::stop::{Stop, Stopped};
use crate::world::{BuiltScene, View};
use turns::Turns;

/// Adds `count` samples to every pixel of the tile; returns how many were invalid.
///
/// # Errors
/// If it is stopped, which it asks for at every patch: a scene may be slow beyond all bounds. The tile is of no use then.
pub fn render_tile(
    how: Lanewise,
    scene: &BuiltScene,
    settings: &Settings,
    tile: &mut Tile,
    count: u32,
    stop: Stop<'_>,
) -> Result<u64, Stopped> {
    compiled::run(how, Job { scene, settings, tile, count, stop })
}

/// See [`render_tile`].
struct Job<'a> {
    scene: &'a BuiltScene,
    settings: &'a Settings,
    tile: &'a mut Tile,
    count: u32,
    stop: Stop<'a>,
}

impl Job<'_> {
    /// Does it in lanes, by a strategy that is known when this is compiled: what it does not do then costs nothing.
    #[inline(always)]
    fn run<L: Lanes>(self, l: L, strategy: Strategy) -> Result<u64, Stopped> {
        let Self { scene, settings, tile, count, stop } = self;
        let (estimator, sampling) = (Estimator { strategy, ..settings.estimator }, settings.sampling);
        let mut invalid = 0;
        let wanted = Dimension::wanted(strategy, scene.lights.list.len() > 1, scene.has_two_lobes);
        let mut sampler = Sampler::new(&sampling.sampler, wanted, estimator.parts(scene.lights.list.len()));
        let one_sample = strategy == Strategy::Mis;
        let mut random = sampler.nothing(l);
        let packet = Packet { place: (0, 0), corner: [l.f(0.0); 2], pixels: Pixels::new(l, l.u(0)) };
        let mut packets = vec![packet; (PATCH[0] * PATCH[1]) as usize * PACKET / L::N];
        let last = tile.samples + count;
        while tile.samples < last {
            let run = sampler.start(tile.samples, last - tile.samples);
            for [min, max] in tile.patches() {
                stop.check()?;
                let near = scene.culled(tile.corner_at(min));
                let view = View { l, scene, culled: &near };
                sampler.enter(l, patch_key(sampling.seed, tile.corner_at(min)));
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
                            packet.pixels.change(pixel_keys(l, sampling.seed, x, y));
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
                        let first = Which { sample: i as usize, next: l.m(false) };
                        let mut turns = Turns::new(&estimator, sampler.sample(l, first, &packet.pixels), pair);
                        let mut waiting = Rest::nothing(l);
                        loop {
                            let (which, drawn) = turns.next(&mut random);
                            sampler.sample(l, which, &packet.pixels).draw(drawn, &mut random);
                            let sample = sample(view, &estimator, packet.corner, &random);
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
        Ok(invalid)
    }
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
/// One sample of each pixel of a packet, by its random numbers.
#[inline(always)]
fn sample<L: Lanes>(view: View<'_, L>, estimator: &Estimator, [x, y]: [L::F; 2], u: &Numbers<L>) -> Sample<L> {
    let View { l, scene, .. } = view;
    let [jx, jy] = u.get_2d(Dimension::Pixel);
    let dir = scene.camera.direction(l, x + jx, y + jy);
    let hit = view.camera_hit(dir);
    let mut reflected = Reflected::none(l);
    // Packets are small patches of the image: nearly always all lanes hit the same shape. Where not, there is one round
    // for each shape hit.
    let (mut todo, mut shape) = (hit.surface, hit.first);
    while todo.any() {
        let mut here = todo;
        if let Some(shapes) = hit.shapes {
            here = here & shapes.eq(l.u(shape));
        }
        if let Some(material) = scene.material(shape) {
            let surface = Surface { material, ..hit.points };
            reflected = reflected.replaced(&Point { view, estimator, surface, wo: -dir, here }.reflected(u));
        }
        let Some(shapes) = hit.shapes else { break };
        todo = todo & !here;
        shape = shapes.lane(todo.bits().trailing_zeros() as usize % L::N);
    }
    Sample { reflected, emitted: hit.emitted, emits: hit.emits }
}
