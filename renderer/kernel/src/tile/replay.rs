//! One sample of one pixel once more, to the bit.
//!
//! The film adds up; what became of a single sample it does not keep. Since every random number is a function of (seed,
//! pixel, sample, dimension), a sample can be drawn again at any time. Levels round differently, so it is drawn on the
//! level that the film was, and in the packet of pixels that it was part of.

use glam::Vec3;

use crate::bsdf::{self, Surface};
use crate::estimator::{Candidate, Contribution, Point, choose_technique};
use crate::film::luminance;
use crate::geometry::grid::{BLOCK, SIDE};
use crate::lanes::{Lanes, Lanewise, Mask, Real, Task, Uint, V3};
use crate::request::{PerTechnique, Settings, Strategy, Technique};
use crate::sampler::{Dimension, Numbers, Pixels, Sampler, Which, patch_key, pixel_keys};
use crate::world::{BuiltScene, View};

/// One sample of one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// Its random numbers.
    pub drawn: Drawn,
    /// Radiance of a light that the camera ray hits, 0 without one; what the film adds to the picture's emission.
    pub emitted: Vec3,
    /// True where that is not 0.
    pub emits: bool,
    /// Number of the shape whose surface the camera ray hits, if it hits one that reflects.
    pub shape: Option<usize>,
    /// The secondary rays: light before BSDF for [`Strategy::MisAll`], else one; none where nothing reflects.
    pub rays: Vec<Ray>,
    /// Luminance of everything, in single precision: what the film squares. Where the square is no finite number, the
    /// film leaves the sample out.
    pub luminance: f32,
}

/// The random numbers of a sample, each in [0, 1); `None` where the strategy does not ask. Where one number is for
/// several things ([`SamplerKind::is_nested`](crate::request::SamplerKind::is_nested)), each is what the ones before
/// have left of it, and `None` for the technique that was not chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    /// Position in the pixel.
    pub pixel: [f32; 2],
    /// The one-sample model's choice: the light technique if it is less than c.
    pub technique: Option<f32>,
    /// Which light: its index is this times their number, rounded down.
    pub light_choice: Option<f32>,
    /// Point on it, or direction in its cone.
    pub light: Option<[f32; 2]>,
    /// Which lobe: the specular one if it is less than 1/2, on a surface with two. Asked where a scene has such surfaces.
    pub lobe: Option<f32>,
    /// Direction in the lobe.
    pub bsdf: Option<[f32; 2]>,
}

/// A secondary ray and what it contributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Which technique drew it.
    pub technique: Technique,
    /// False where that failed: the light chosen turns its back.
    pub valid: bool,
    /// Its direction, of unit length.
    pub wi: Vec3,
    /// True if it was drawn from a mirror's Dirac delta.
    pub dirac: bool,
    /// f, per channel.
    pub f: Vec3,
    /// `p_L` per solid angle.
    pub p_light: f32,
    /// `p_B` per solid angle; of a mirror's direction a probability.
    pub p_bsdf: f32,
    /// Weight of the technique; 0 where it hits no light.
    pub weight: f32,
    /// `w f / (c p)`, per channel: what the film adds.
    pub value: Vec3,
    /// True if it hits a light; the film adds nothing else.
    pub lit: bool,
}

/// Sample number `index` of the pixel (x, y), at the level `how`. The contributions are those that the kernel hands to the
/// film, bit for bit. Densities of rays that hit no light are 0 here.
pub fn replay(how: Lanewise, scene: &BuiltScene, settings: &Settings, pixel: [u32; 2], index: u32) -> Replayed {
    how.run(ReplaySample { scene, settings, pixel, index })
}

struct ReplaySample<'a> {
    scene: &'a BuiltScene,
    settings: &'a Settings,
    pixel: [u32; 2],
    index: u32,
}

impl Task for ReplaySample<'_> {
    type Output = Replayed;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Replayed {
        let Self { scene, settings, pixel: [x, y], index } = self;
        // The pixel's packet, and its lane there.
        let [x0, y0] = [x / BLOCK[0] * BLOCK[0], y / BLOCK[1] * BLOCK[1]];
        let in_block = ((y - y0) * BLOCK[0] + (x - x0)) as usize;
        let lane = in_block % L::N;
        let numbers = l.iota() + l.u((in_block - lane) as u32);
        let columns = (numbers & l.u(BLOCK[0] - 1)) + l.u(x0);
        let rows = (numbers >> BLOCK[0].trailing_zeros()) + l.u(y0);
        let patch = [x, y].map(|v| v / SIDE * SIDE);
        let near = scene.culled(patch);

        let wanted = Dimension::wanted(settings.estimator.strategy, scene.lights.list.len() > 1, scene.has_two_lobes);
        let parts = settings.estimator.parts(scene.lights.list.len());
        let mut sampler = Sampler::new(&settings.sampling.sampler, wanted, parts);
        sampler.start(index, 1);
        sampler.enter(l, patch_key(settings.sampling.seed, patch));
        let mut pixels = Pixels::new(l, pixel_keys(l, settings.sampling.seed, columns, rows));
        sampler.turn(l, &mut pixels);
        let mut random = sampler.nothing(l);
        let sample = sampler.sample(l, Which { sample: 0, next: l.m(false) }, &pixels);
        if settings.estimator.strategy == Strategy::Mis {
            random.set_technique(sample.technique());
        }
        sample.draw(PerTechnique::BOTH, &mut random);
        let technique = number(&random, &wanted, Dimension::Technique, lane);
        let (first_by_light, random) = match settings.estimator.strategy {
            Strategy::Light | Strategy::MisAll => (l.m(true), random),
            Strategy::Bsdf => (l.m(false), random),
            Strategy::Mis => choose_technique(l, &settings.estimator, &random),
        };

        let [jx, jy] = random.get_2d(Dimension::Pixel);
        let dir = scene.camera.direction(l, columns.to_real() + jx, rows.to_real() + jy);
        let view = View { l, scene, culled: &near };
        let hit = view.camera_hit(dir);
        let shape = match hit.shapes {
            Some(shapes) => shapes.lane(lane),
            None => hit.first,
        };
        let (mut light, mut bsdf) = (V3::all(l.f(0.0)), V3::all(l.f(0.0)));
        let mut rays = Vec::new();
        let hit_here = hit.surface.bits() >> lane & 1 == 1;
        // As if all lanes hit this one's shape: the others are not looked at.
        let material = if hit_here { scene.material(shape) } else { None };
        if let Some(material) = material {
            let surface: Surface<'_, L> = Surface { material, ..hit.points };
            let at = Point { view, estimator: &settings.estimator, surface, wo: -dir, here: hit.surface };
            let mut last = settings.estimator.strategy != Strategy::MisAll;
            let mut by_light = first_by_light;
            loop {
                let draw = at.draw_where(by_light, &random);
                let mut part = Contribution::none(l);
                let (mut f, mut p_light, mut p_bsdf) = (Vec3::ZERO, 0.0, 0.0);
                if let Some(x) = at.candidate(&draw) {
                    part = at.contribution(&draw, &x).or(&part);
                    let Candidate { f: each, p } = x;
                    (f, p_light, p_bsdf) = (vector(each, lane), p.light.lane(lane), p.bsdf.lane(lane));
                }
                let technique = if by_light.bits() >> lane & 1 == 1 { Technique::Light } else { Technique::Bsdf };
                match technique {
                    Technique::Light => light = part.value,
                    Technique::Bsdf => bsdf = part.value,
                }
                rays.push(Ray {
                    technique,
                    valid: draw.valid.bits() >> lane & 1 == 1,
                    wi: vector(draw.wi, lane),
                    dirac: draw.dirac.bits() >> lane & 1 == 1,
                    f,
                    p_light,
                    p_bsdf,
                    weight: part.weight.lane(lane),
                    value: vector(part.value, lane),
                    lit: part.lit.bits() >> lane & 1 == 1,
                });
                if last {
                    break;
                }
                (last, by_light) = (true, l.m(false));
            }
        }
        let total = light + bsdf + hit.emitted;
        let mut asked = wanted;
        if settings.sampling.sampler.kind.is_nested() && settings.estimator.strategy == Strategy::Mis {
            let unasked = match first_by_light.bits() >> lane & 1 == 1 {
                true => [Dimension::Lobe, Dimension::Bsdf],
                false => [Dimension::LightChoice, Dimension::Light],
            };
            for dimension in unasked {
                asked[dimension as usize] = false;
            }
        }
        let light_numbers = match scene.lights.list.len() {
            0 => random.get_2d(Dimension::Light),
            n => random.choose_light(l, n).1,
        };
        let bsdf_numbers = match material {
            Some(material) => bsdf::choose_lobe(l, material, &random).1,
            None => random.get_2d(Dimension::Bsdf),
        };
        Replayed {
            drawn: Drawn {
                pixel: [jx.lane(lane), jy.lane(lane)],
                technique,
                light_choice: number(&random, &asked, Dimension::LightChoice, lane),
                light: pair::<L>(light_numbers, &asked, Dimension::Light, lane),
                lobe: number(&random, &asked, Dimension::Lobe, lane),
                bsdf: pair::<L>(bsdf_numbers, &asked, Dimension::Bsdf, lane),
            },
            emitted: vector(hit.emitted, lane),
            emits: hit.emits.bits() >> lane & 1 == 1,
            shape: material.map(|_| shape as usize),
            rays,
            luminance: luminance(l, total).lane(lane),
        }
    }
}

/// A vector in one lane.
#[inline(always)]
fn vector<L: Lanes>(v: V3<L>, lane: usize) -> Vec3 {
    Vec3::new(v.x.lane(lane), v.y.lane(lane), v.z.lane(lane))
}

/// A number in one lane, if it was wanted.
#[inline(always)]
fn number<L: Lanes>(random: &Numbers<L>, wanted: &Wanted, dimension: Dimension, lane: usize) -> Option<f32> {
    if wanted[dimension as usize] { Some(random.get_1d(dimension).lane(lane)) } else { None }
}

/// Two numbers in one lane, if they were wanted.
#[inline(always)]
fn pair<L: Lanes>([x, y]: [L::F; 2], wanted: &Wanted, dimension: Dimension, lane: usize) -> Option<[f32; 2]> {
    if wanted[dimension as usize] { Some([x.lane(lane), y.lane(lane)]) } else { None }
}

/// By dimension, whether the strategy asks for it.
type Wanted = [bool; Dimension::ALL.len()];
