//! Numbers of all lights, for fetching lane by lane.

use glam::Vec3;

use super::built::{BuiltLight, LightShape};
use crate::lanes::{Lanes, SHORT, V3};

/// Numbers of the sphere and facet lights by index, for fetching by lane; filled up with zeros to [`SHORT`].
#[derive(Debug, Default)]
pub(super) struct Tables {
    /// How many lights there are.
    len: usize,
    pub(super) is_ball: Vec<f32>,
    pub(super) p: [Vec<f32>; 3],
    pub(super) radiance: [Vec<f32>; 3],
    /// Of a ball: radius^2 and 1 / radius^2.
    pub(super) radius2: Vec<f32>,
    pub(super) curvature2: Vec<f32>,
    pub(super) inward: Vec<f32>,
    pub(super) e1: [Vec<f32>; 3],
    pub(super) e2: [Vec<f32>; 3],
    pub(super) normal: [Vec<f32>; 3],
    pub(super) u_axis: [Vec<f32>; 3],
    pub(super) v_axis: [Vec<f32>; 3],
    pub(super) area: Vec<f32>,
    pub(super) quad: Vec<f32>,
    pub(super) any_ball: bool,
    pub(super) any_inward: bool,
    pub(super) any_facet: bool,
}

impl Tables {
    /// Of these lights.
    pub(super) fn new(list: &[BuiltLight]) -> Self {
        let mut t = Self { len: list.len(), ..Self::default() };
        for light in list {
            let (ball, facet) = match light.shape {
                LightShape::Ball(b) => (Some(b), None),
                LightShape::Facet(f) => (None, Some(f)),
            };
            t.any_ball |= ball.is_some();
            t.any_facet |= facet.is_some();
            t.is_ball.push(if ball.is_some() { 1.0 } else { 0.0 });
            t.any_inward |= ball.is_some_and(|b| b.inward);
            t.radius2.push(ball.map_or(0.0, |b| b.radius * b.radius));
            t.curvature2.push(ball.map_or(0.0, |b| b.curvature2()));
            t.area.push(facet.map_or(0.0, |f| f.area));
            t.inward.push(if ball.is_some_and(|b| b.inward) { 1.0 } else { 0.0 });
            t.quad.push(if facet.is_some_and(|f| f.quad) { 1.0 } else { 0.0 });
            let p = ball.map(|b| b.center).or(facet.map(|f| f.p0)).unwrap_or_default();
            let e1 = facet.map_or(Vec3::ZERO, |f| f.e1);
            let e2 = facet.map_or(Vec3::ZERO, |f| f.e2);
            let normal = facet.map_or(Vec3::ZERO, |f| f.normal);
            let [u_axis, v_axis] = facet.map_or([Vec3::ZERO; 2], |f| f.axes());
            for axis in 0..3 {
                t.radiance[axis].push(light.radiance[axis]);
                t.u_axis[axis].push(u_axis[axis]);
                t.v_axis[axis].push(v_axis[axis]);
                t.p[axis].push(p[axis]);
                t.e1[axis].push(e1[axis]);
                t.e2[axis].push(e2[axis]);
                t.normal[axis].push(normal[axis]);
            }
        }
        for table in t.all() {
            table.resize(list.len().max(SHORT), 0.0);
        }
        t
    }

    /// `table[choice]`. `SHORT_LIST`: there are [`SHORT`] lights at most.
    #[inline(always)]
    pub(super) fn pick<L: Lanes, const SHORT_LIST: bool>(&self, l: L, table: &[f32], choice: L::U) -> L::F {
        if SHORT_LIST || self.len <= SHORT {
            let table = table.first_chunk().expect("tables are filled up");
            return l.lookup(table, self.len, choice);
        }
        l.gather(table, choice)
    }

    /// Three of them.
    #[inline(always)]
    pub(super) fn pick_v<L: Lanes, const SHORT_LIST: bool>(&self, l: L, table: &[Vec<f32>; 3], choice: L::U) -> V3<L> {
        V3 {
            x: self.pick::<L, SHORT_LIST>(l, &table[0], choice),
            y: self.pick::<L, SHORT_LIST>(l, &table[1], choice),
            z: self.pick::<L, SHORT_LIST>(l, &table[2], choice),
        }
    }

    /// All of them.
    fn all(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        let vectors = [&mut self.p, &mut self.radiance, &mut self.e1, &mut self.e2, &mut self.normal];
        let axes = [&mut self.u_axis, &mut self.v_axis];
        let numbers = [&mut self.is_ball, &mut self.radius2, &mut self.curvature2, &mut self.inward];
        let more = [&mut self.area, &mut self.quad];
        vectors.into_iter().chain(axes).flatten().chain(numbers).chain(more)
    }
}
