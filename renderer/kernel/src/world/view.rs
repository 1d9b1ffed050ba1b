//! What there is to see from the points of a patch: camera hits, lights in a direction, visibility.
//!
//! Culling is behind it: whoever asks need not know that most primitives are left out.

use glam::Vec3;

use super::BuiltScene;
use super::culling::Culled;
use crate::bsdf::{BuiltMaterial, Surface};
use crate::geometry::shape::{Ball, Facet};
use crate::lanes::{Lanes, Mask, PACKET, Place, Real, Uint, V3};
use crate::light::{Aim, LightShape, Sight};

/// A scene as the rays of one patch of pixels find it.
#[derive(Clone, Copy)]
pub struct View<'a, L: Lanes> {
    /// The lanes.
    pub l: L,
    /// The scene.
    pub scene: &'a BuiltScene,
    /// What is left of it after culling.
    pub culled: &'a Culled,
}

/// What a packet of camera rays hit.
pub struct CameraHit<'a, L: Lanes> {
    /// True where there is a surface that may reflect.
    pub surface: L::M,
    /// Which shape it belongs to, see [`BuiltScene::material`], in the first of these lanes.
    pub first: u32,
    /// And in each lane; `None` if it is the same in all.
    pub shapes: Option<L::U>,
    /// The points hit, made of what that of the shape is made of.
    pub points: Surface<'a, L>,
    /// Radiance of a light hit directly, 0 elsewhere.
    pub emitted: V3<L>,
    /// True where a light that shines this way was hit.
    pub emits: L::M,
}

/// Of camera rays that may hit different surfaces.
struct FirstHits;
impl Place for FirstHits {}

/// One primitive of geometry or lights.
enum Primitive<'a> {
    Facet(&'a Facet),
    Ball(&'a Ball),
}

impl<'a, L: Lanes> View<'a, L> {
    /// The first hit of each camera ray, all of them rays of the patch.
    #[inline(always)]
    pub fn camera_hit(&self, dir: V3<L>) -> CameraHit<'a, L> {
        let Self { l, scene, culled } = *self;
        if culled.covered {
            let facet = &scene.geometry.facets[culled.surfaces.first()];
            let origin = V3::splat(l, scene.camera.origin);
            let p = dir.scale_add(facet.distance(l, origin, dir), origin);
            return CameraHit {
                surface: l.m(true),
                first: facet.shape,
                shapes: None,
                points: on_facet(l, facet, p, dir),
                emitted: V3::all(l.f(0.0)),
                emits: l.m(false),
            };
        }
        let view = *self;
        l.out_of_line::<FirstHits, _>(
            #[inline(always)]
            move || view.first_hit(dir),
        )
    }

    /// The same where rays of the patch may hit different surfaces.
    #[inline(always)]
    fn first_hit(&self, dir: V3<L>) -> CameraHit<'a, L> {
        let Self { l, scene, culled } = *self;
        let zero = l.f(0.0);
        let origin = V3::splat(l, scene.camera.origin);
        let hit = scene.geometry.nearest(l, origin, dir, &culled.surfaces);
        let (t_light, light, radiance) = scene.lights.nearest(l, origin, dir, &culled.lights);
        // Where a light and something opaque are at the same distance the light is in front, as for shadow rays.
        let is_light = t_light.le(hit.t) & t_light.lt(l.f(f32::INFINITY));
        let emitted = V3::select(is_light, radiance, V3::all(zero));
        let emits = (emitted.x + emitted.y + emitted.z).gt(zero);
        let p = dir.scale_add(is_light.select(t_light, hit.t), origin);
        // Lights are numbered after all else.
        let id = is_light.select_u(light + l.u(scene.geometry.len() as u32), hit.id);
        let surface = hit.t.lt(l.f(f32::INFINITY)) & !is_light;
        let id = if scene.fronts.is_empty() { id } else { self.frontmost(id, surface, dir) };
        let surface = if scene.lights_scatter { surface | is_light } else { surface };
        let (first, shapes, points) = self.points(id, surface, p, dir);
        CameraHit { surface, first, shapes, points, emitted, emits }
    }

    /// The same primitives, or those in front of them in the same place, of camera rays that hit opaque ones.
    #[inline(always)]
    fn frontmost(&self, id: L::U, hit: L::M, dir: V3<L>) -> L::U {
        let Self { l, scene, .. } = *self;
        let (mut ids, [mut x, mut y, mut z]) = ([0; PACKET], [[0.0; PACKET]; 3]);
        id.store(&mut ids);
        dir.x.store(&mut x);
        dir.y.store(&mut y);
        dir.z.store(&mut z);
        let mut todo = hit.bits();
        while todo != 0 {
            let i = todo.trailing_zeros() as usize;
            todo &= todo - 1;
            ids[i] = scene.fronts.at(&scene.geometry, ids[i], scene.camera.origin, Vec3::new(x[i], y[i], z[i]));
        }
        l.load_u(&ids)
    }

    /// The shapes (see [`CameraHit`]) and the points `p` that rays in directions `dir` hit on the primitives with these
    /// numbers. Most packets meet one primitive; in a fine mesh every ray may hit another.
    #[inline(always)]
    fn points(&self, id: L::U, hit: L::M, p: V3<L>, dir: V3<L>) -> (u32, Option<L::U>, Surface<'a, L>) {
        let l = self.l;
        let mut ids = [0; PACKET];
        id.store(&mut ids);
        let mut todo = hit.bits();
        let lane = todo.trailing_zeros() as usize % PACKET;
        let first = ids[lane];
        if (id.eq(l.u(first)) | !hit).all() {
            return match self.primitive(first) {
                Some(Primitive::Facet(facet)) => (facet.shape, None, on_facet(l, facet, p, dir)),
                Some(Primitive::Ball(ball)) => {
                    let n = (p - V3::splat(l, ball.center)).normalize(l);
                    (ball.shape, None, Surface::new(l, p, n, dir, &BuiltMaterial::BLACK))
                }
                None => (0, None, Surface::new(l, p, -dir, dir, &BuiltMaterial::BLACK)),
            };
        }
        // By lane: normal of a facet or centre of a ball.
        let (mut x, mut y, mut z, mut shapes) = ([0.0; PACKET], [0.0; PACKET], [0.0; PACKET], [0; PACKET]);
        let mut balls = 0;
        while todo != 0 {
            let i = todo.trailing_zeros() as usize;
            todo &= todo - 1;
            let v = match self.primitive(ids[i]) {
                Some(Primitive::Facet(facet)) => {
                    shapes[i] = facet.shape;
                    facet.normal
                }
                Some(Primitive::Ball(ball)) => {
                    shapes[i] = ball.shape;
                    balls |= 1 << i;
                    ball.center
                }
                None => Vec3::Z,
            };
            (x[i], y[i], z[i]) = (v.x, v.y, v.z);
        }
        let mut n = V3 { x: l.load(&x), y: l.load(&y), z: l.load(&z) };
        if balls != 0 {
            n = V3::select(l.mask(balls), (p - n).normalize(l), n);
        }
        (shapes[lane], Some(l.load_u(&shapes)), Surface::new(l, p, n, dir, &BuiltMaterial::BLACK))
    }

    /// The primitive with that number: facets, balls, lights.
    #[inline(always)]
    fn primitive(&self, id: u32) -> Option<Primitive<'a>> {
        let scene = self.scene;
        let (id, facets, all) = (id as usize, scene.geometry.facets.len(), scene.geometry.len());
        if id < facets {
            return Some(Primitive::Facet(&scene.geometry.facets[id]));
        }
        if id < all {
            return Some(Primitive::Ball(&scene.geometry.balls[id - facets]));
        }
        Some(match &scene.lights.list.get(id - all)?.shape {
            LightShape::Facet(facet) => Primitive::Facet(facet),
            LightShape::Ball(ball) => Primitive::Ball(ball),
        })
    }

    /// What lights there are in a direction from a point on a surface: their density and the radiance that arrives if nothing
    /// is in the way. `aim` says which light it was drawn towards, if it was.
    #[inline(always)]
    pub fn light_towards(&self, from: V3<L>, wi: V3<L>, aim: Option<&Aim<L>>) -> Sight<L> {
        let Self { l, scene, culled } = *self;
        match aim {
            Some(aim) if culled.lights_disjoint => scene.lights.look_at(l, aim, culled.may_be_blocked()),
            _ => scene.lights.look(l, from, wi, l.f(scene.epsilon), culled.may_be_blocked()),
        }
    }

    /// Of the lanes `wanted`, those where nothing opaque lies between the surface point and distance `t` along `wi`.
    #[inline(always)]
    pub fn visible(&self, s: &Surface<'_, L>, wi: V3<L>, t: L::F, wanted: L::M) -> L::M {
        let Self { l, scene, culled } = *self;
        if !culled.may_be_blocked() || !wanted.any() {
            return wanted;
        }
        let origin = s.n.scale_add(l.f(scene.epsilon), s.p);
        wanted & !scene.geometry.blocked(l, origin, wi, t - scene.epsilon, wanted, &culled.occluders)
    }
}

/// Points of a facet.
#[inline(always)]
fn on_facet<'a, L: Lanes>(l: L, facet: &Facet, p: V3<L>, dir: V3<L>) -> Surface<'a, L> {
    Surface::new(l, p, V3::splat(l, facet.normal), dir, &BuiltMaterial::BLACK)
}
