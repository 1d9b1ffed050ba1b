//! From pixels to the things in the scene and back: what is under the mouse, and its outline.
//!
//! Works on the plain scene data, apart from the renderer, so that it never waits for it.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use mislab_renderer::projection::Projector;
use mislab_renderer::{Geometry, Scene, Shape};

/// Something with a control in the scene panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// A material, by index.
    Material(usize),
    /// A light, by the index of its shape.
    Light(usize),
}

impl Target {
    /// The target that the surface of a shape belongs to.
    pub fn of_shape(scene: &Scene, index: usize) -> Option<Self> {
        let shape = scene.shapes.get(index)?;
        if shape.light.is_some() {
            return Some(Self::Light(index));
        }
        let material = shape.material?;
        scene.materials.get(material)?.bsdf.alpha().map(|_| Self::Material(material))
    }

    /// The shapes that belong to it.
    pub fn shapes(self, scene: &Scene) -> impl Iterator<Item = &Shape> {
        scene.shapes.iter().enumerate().filter_map(move |(i, shape)| match self {
            Self::Light(light) => (i == light).then_some(shape),
            Self::Material(material) => (shape.light.is_none() && shape.material == Some(material)).then_some(shape),
        })
    }
}

/// Meshes above this many triangles are left out: they would cost a visible pause per mouse move.
const MAX_TRIANGLES: usize = 100_000;

/// Where the things of a scene are in an image of it, in pixels from the top left.
pub struct Finder<'a> {
    scene: &'a Scene,
    projector: Projector,
}

impl<'a> Finder<'a> {
    /// For an image of that many pixels.
    pub fn new(scene: &'a Scene, resolution: [u32; 2]) -> Self {
        Self { scene, projector: Projector::new(&scene.camera, resolution) }
    }

    /// Where a point of the world is in the image; `None` behind the camera.
    pub fn project(&self, point: DVec3) -> Option<[f32; 2]> {
        self.projector.project(point).map(|at| at.map(|v| v as f32))
    }

    /// Index of the first shape seen at a position of the image.
    pub fn pick(&self, at: [f32; 2]) -> Option<usize> {
        let ray = self.projector.ray(at.map(f64::from));
        let hits = self.scene.shapes.iter().enumerate().filter_map(|(index, shape)| {
            let t = match &shape.geometry {
                Geometry::Sphere { center, radius } => ray.hit_sphere(center.as_dvec3(), f64::from(*radius)),
                Geometry::Mesh { triangles, .. } if triangles.len() > MAX_TRIANGLES => None,
                Geometry::Mesh { positions, triangles } => triangles
                    .iter()
                    .filter_map(|t| {
                        let [a, b, c] = t.map(|i| positions.get(i as usize).map(|p| p.as_dvec3()));
                        ray.hit_triangle([a?, b?, c?])
                    })
                    .reduce(f64::min),
            }?;
            Some((index, t))
        });
        hits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }

    /// The outline of a shape, as pieces of line in the image.
    pub fn outline(&self, shape: &Shape) -> Vec<[[f32; 2]; 2]> {
        match &shape.geometry {
            Geometry::Sphere { center, radius } => {
                let ring = self.sphere_outline(center.as_dvec3(), f64::from(*radius));
                ring.windows(2).filter_map(|pair| Some([pair[0]?, pair[1]?])).collect()
            }
            Geometry::Mesh { triangles, .. } if triangles.len() > MAX_TRIANGLES / 10 => Vec::new(),
            Geometry::Mesh { positions, triangles } => {
                // Edges of one triangle only are the border of the surface.
                let mut uses: HashMap<[u32; 2], usize> = HashMap::new();
                for [a, b, c] in triangles.iter() {
                    for (p, q) in [(a, b), (b, c), (c, a)] {
                        *uses.entry([*p.min(q), *p.max(q)]).or_default() += 1;
                    }
                }
                let mut border: Vec<[u32; 2]> = uses.into_iter().filter(|(_, n)| *n == 1).map(|(e, _)| e).collect();
                border.sort_unstable();
                let corner = |i: u32| self.project(positions.get(i as usize)?.as_dvec3());
                border.into_iter().filter_map(|[p, q]| Some([corner(p)?, corner(q)?])).collect()
            }
        }
    }

    /// The circle where rays from the eye touch a sphere.
    fn sphere_outline(&self, center: DVec3, radius: f64) -> Vec<Option<[f32; 2]>> {
        let to_center = center - self.projector.eye;
        let distance = to_center.length();
        if distance <= radius {
            return Vec::new();
        }
        let axis = to_center / distance;
        let sin = radius / distance;
        let ring_center = center - axis * (radius * sin);
        let ring_radius = radius * (1.0 - sin * sin).sqrt();
        let (u, v) = axis.any_orthonormal_pair();
        (0..=64)
            .map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i) / 64.0;
                self.project(ring_center + ring_radius * (u * angle.cos() + v * angle.sin()))
            })
            .collect()
    }

    /// The smallest box of the image around everything that belongs to `target`: min and max.
    pub fn bounds(&self, target: Target) -> Option<[[f32; 2]; 2]> {
        let mut bounds: Option<[[f32; 2]; 2]> = None;
        let mut include = |p: [f32; 2]| {
            let b = bounds.get_or_insert([p, p]);
            *b = [[b[0][0].min(p[0]), b[0][1].min(p[1])], [b[1][0].max(p[0]), b[1][1].max(p[1])]];
        };
        for shape in target.shapes(self.scene) {
            match &shape.geometry {
                Geometry::Sphere { center, radius } => {
                    self.sphere_outline(center.as_dvec3(), f64::from(*radius))
                        .into_iter()
                        .flatten()
                        .for_each(&mut include);
                }
                Geometry::Mesh { positions, .. } => {
                    positions.iter().filter_map(|p| self.project(p.as_dvec3())).for_each(&mut include);
                }
            }
        }
        bounds
    }
}

/// The part of an image of that many pixels with all plates and lights in it, and a little around them: corners,
/// in pixels. `None` if it shows none.
pub fn things(scene: &Scene, resolution: [u32; 2]) -> Option<[[f32; 2]; 2]> {
    let finder = Finder::new(scene, resolution);
    let size = resolution.map(|n| n as f32);
    let targets: HashSet<Target> = (0..scene.shapes.len()).filter_map(|shape| Target::of_shape(scene, shape)).collect();
    let mut bounds: Option<[[f32; 2]; 2]> = None;
    for [min, max] in targets.into_iter().filter_map(|target| finder.bounds(target)) {
        let [low, high] = bounds.unwrap_or([min, max]);
        bounds = Some([[0, 1].map(|i| low[i].min(min[i])), [0, 1].map(|i| high[i].max(max[i]))]);
    }
    let [min, max] = bounds?;
    let margin = 0.02 * size[0].max(size[1]);
    let part = [[0, 1].map(|i| (min[i] - margin).max(0.0)), [0, 1].map(|i| (max[i] + margin).min(size[i]))];
    (part[0][0] < part[1][0] && part[0][1] < part[1][1]).then_some(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mislab_renderer::pbrt::embedded_scene;

    #[test]
    fn a_projected_light_is_picked_where_it_is_seen() {
        let scene = embedded_scene().scene;
        let finder = Finder::new(&scene, [800, 800]);
        for index in scene.light_shapes() {
            let Geometry::Sphere { center, .. } = scene.shapes[index].geometry else { continue };
            let at = finder.project(center.as_dvec3()).expect("the lights are in front of the camera");
            assert!((0.0..800.0).contains(&at[0]) && (0.0..800.0).contains(&at[1]), "light {index} at {at:?}");
            assert_eq!(finder.pick(at), Some(index), "at {at:?}");
            assert_eq!(Target::of_shape(&scene, index), Some(Target::Light(index)));
        }
    }

    #[test]
    fn plates_and_lights_fill_a_part_of_the_picture() {
        let scene = embedded_scene().scene;
        let [min, max] = things(&scene, [800, 800]).expect("the scene has plates and lights");
        let finder = Finder::new(&scene, [800, 800]);
        for index in scene.light_shapes() {
            let [low, high] = finder.bounds(Target::Light(index)).expect("in front of the camera");
            assert!(min[0] <= low[0] && min[1] <= low[1] && high[0] <= max[0] && high[1] <= max[1], "light {index}");
        }
        assert!(max[1] - min[1] < 700.0, "not the whole picture: {min:?} to {max:?}");
    }

    #[test]
    fn the_large_light_is_on_the_left() {
        // pbrt's camera is left-handed: world +x is on the left of this picture.
        let scene = embedded_scene().scene;
        let finder = Finder::new(&scene, [800, 800]);
        let large = finder.project(DVec3::new(3.75, 0.0, 0.0)).expect("in front of the camera");
        let small = finder.project(DVec3::new(-3.75, 0.0, 0.0)).expect("in front of the camera");
        assert!(large[0] < small[0], "{large:?} {small:?}");
    }
}
