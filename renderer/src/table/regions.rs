//! Which pixels belong to which square of the table: plates found by geometry, lights by the reference.

use glam::Vec3;
use mislab_kernel::request::scene::{Geometry, Scene, Shape};
use mislab_kernel::world::projection::{Projector, Ray};

use super::{LightSize, LobeWidth};
use crate::error::Error;

/// A square of the table, in the order of [`super::TableRow::cells`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Square {
    /// The row.
    pub light: LightSize,
    /// The column.
    pub bsdf: LobeWidth,
}

impl Square {
    /// Small/broad, small/sharp, large/broad, large/sharp.
    pub const ALL: [Self; 4] = [
        Self { light: LightSize::Small, bsdf: LobeWidth::Broad },
        Self { light: LightSize::Small, bsdf: LobeWidth::Sharp },
        Self { light: LightSize::Large, bsdf: LobeWidth::Broad },
        Self { light: LightSize::Large, bsdf: LobeWidth::Sharp },
    ];
}

/// The plates and lights of a scene, sorted into the rows and columns of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Groups {
    /// Materials by lobe: indices into [`Scene::materials`].
    pub sharp: Vec<usize>,
    /// See `sharp`.
    pub broad: Vec<usize>,
    /// Lights by size: indices into [`Scene::shapes`].
    pub small: Vec<usize>,
    /// See `small`.
    pub large: Vec<usize>,
}

impl Groups {
    /// Plates are the materials `plate1` to `plate4` (1 and 2 are sharp, whatever their roughness has been set to); in
    /// other scenes, all glossy materials in use, the smoother half (the middle one included) being sharp. Lights are those
    /// switched on, the smaller half (without the middle one) being small; the size of a mesh is the radius of a sphere of
    /// its area.
    ///
    /// # Errors
    /// [`Error::Invalid`] with fewer than two plates or lights.
    pub fn of(scene: &Scene) -> Result<Self, Error> {
        let used = |m: usize| scene.shapes.iter().any(|s| s.material == Some(m) && !emits(s));
        let alpha = |m: usize| scene.materials[m].bsdf.alpha();
        let named = ["plate1", "plate2", "plate3", "plate4"]
            .map(|name| scene.materials.iter().position(|m| m.name == name).filter(|&m| alpha(m).is_some() && used(m)));
        let (sharp, broad) = if let [Some(a), Some(b), Some(c), Some(d)] = named {
            (vec![a, b], vec![c, d])
        } else {
            let glossy = (0..scene.materials.len()).filter(|&m| used(m));
            let glossy: Vec<_> = glossy.filter_map(|m| alpha(m).map(|alpha| (alpha, m))).collect();
            halves(glossy, true)
        };
        if sharp.is_empty() || broad.is_empty() {
            return Err(Error::Invalid(format!(
                "scene {}: {} glossy surfaces, expected at least 2 (materials named plate1 to plate4, or mirror, metal or \
                 plastic) to sort by the width of their lobes",
                scene.name,
                sharp.len() + broad.len()
            )));
        }
        let lights = scene.light_shapes().filter(|&i| emits(&scene.shapes[i]));
        let (small, large) = halves(lights.map(|i| (size(&scene.shapes[i].geometry), i)).collect(), false);
        if small.is_empty() || large.is_empty() {
            return Err(Error::Invalid(format!(
                "scene {}: {} lights that are on, expected at least 2 to sort by size",
                scene.name,
                small.len() + large.len()
            )));
        }
        Ok(Self { sharp, broad, small, large })
    }

    /// Lights, the small ones first.
    pub fn lights(&self) -> impl Iterator<Item = usize> + '_ {
        self.small.iter().chain(&self.large).copied()
    }

    /// The square of every pixel; `None` where no plate is seen or no light is reflected. `materials` is by
    /// [`visible_materials`]; `luminance` holds, for each of [`Self::lights`], what that light alone contributes.
    pub fn squares(&self, materials: &[Option<usize>], luminance: &[Vec<f64>]) -> Vec<Option<Square>> {
        let square = |(pixel, material): (usize, &Option<usize>)| {
            let material = (*material)?;
            let bsdf = if self.sharp.contains(&material) {
                LobeWidth::Sharp
            } else if self.broad.contains(&material) {
                LobeWidth::Broad
            } else {
                return None;
            };
            let brightest =
                (0..luminance.len()).max_by(|&a, &b| luminance[a][pixel].total_cmp(&luminance[b][pixel]))?;
            let light = if brightest < self.small.len() { LightSize::Small } else { LightSize::Large };
            (luminance[brightest][pixel] > 0.0).then_some(Square { light, bsdf })
        };
        materials.iter().enumerate().map(square).collect()
    }
}

/// Whether a shape gives off light.
fn emits(shape: &Shape) -> bool {
    shape.light.as_ref().is_some_and(|light| light.on && light.radiance.max_element() > 0.0)
}

/// Sorts by value and splits in two; the middle one of an odd number goes to the lower half if `middle_low`.
fn halves(mut items: Vec<(f32, usize)>, middle_low: bool) -> (Vec<usize>, Vec<usize>) {
    items.sort_by(|a, b| a.0.total_cmp(&b.0));
    let split = (items.len() + usize::from(middle_low)) / 2;
    let indices = |part: &[(f32, usize)]| part.iter().map(|&(_, i)| i).collect();
    (indices(&items[..split]), indices(&items[split..]))
}

/// Radius of the sphere with the same area.
fn size(geometry: &Geometry) -> f32 {
    match geometry {
        Geometry::Sphere { radius, .. } => *radius,
        Geometry::Mesh { positions, triangles } => {
            let area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| positions[i as usize]);
                0.5 * (b - a).cross(c - a).length()
            };
            (triangles.iter().map(area).sum::<f32>() / (4.0 * std::f32::consts::PI)).sqrt()
        }
    }
}

/// The material that each pixel shows, row by row from the top left: that of the first surface behind the pixel's centre,
/// if all four corners show the same one. Lights and black surfaces are `None`.
pub fn visible_materials(scene: &Scene, resolution: [u32; 2]) -> Vec<Option<usize>> {
    let material = |hit: &Option<Primitive>| {
        let shape = &scene.shapes[hit.as_ref()?.shape as usize];
        shape.material.filter(|_| shape.light.is_none())
    };
    let of_pixel = |[centre, corners @ ..]: [Option<Primitive>; 5]| {
        material(&centre).filter(|_| corners.iter().all(|corner| material(corner) == material(&centre)))
    };
    first_hits(scene, resolution).map(of_pixel).collect()
}

/// A sphere or a triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Primitive {
    /// Index into [`Scene::shapes`].
    pub shape: u32,
    /// Which triangle of a mesh; 0 for a sphere.
    pub triangle: u32,
}

/// What is seen first at each pixel, row by row from the top left: behind its centre, then behind its corners, two of the upper
/// row and two of the lower.
pub fn first_hits(scene: &Scene, resolution: [u32; 2]) -> impl Iterator<Item = [Option<Primitive>; 5]> {
    let [width, height] = resolution.map(|n| n as usize);
    let centres = Grid::new(scene, resolution, [width, height], 0.5).trace(scene);
    let corners = Grid::new(scene, resolution, [width + 1, height + 1], 0.0).trace(scene);
    (0..height).flat_map(move |y| (0..width).map(move |x| [x, y])).map(move |[x, y]| {
        let corner = y * (width + 1) + x;
        let [a, b, c, d] = [corner, corner + 1, corner + width + 1, corner + width + 2].map(|i| corners[i]);
        [centres[y * width + x], a, b, c, d]
    })
}

/// A regular grid of points of the image, one pixel apart.
struct Grid {
    size: [usize; 2],
    /// Distance of the first point from the image's corner, in pixels.
    offset: f64,
    projector: Projector,
}

impl Grid {
    fn new(scene: &Scene, resolution: [u32; 2], size: [usize; 2], offset: f64) -> Self {
        Self { size, offset, projector: Projector::new(&scene.camera, resolution) }
    }

    /// What is seen at every point, by testing each surface against the points inside its outline's bounds.
    fn trace(&self, scene: &Scene) -> Vec<Option<Primitive>> {
        let mut nearest = vec![(f64::INFINITY, None); self.size[0] * self.size[1]];
        for (index, shape) in scene.shapes.iter().enumerate() {
            let primitive = |triangle: usize| Primitive { shape: index as u32, triangle: triangle as u32 };
            match &shape.geometry {
                Geometry::Sphere { center, radius } => {
                    let signs = [-1.0, 1.0];
                    let corners: Vec<Vec3> = signs
                        .iter()
                        .flat_map(|&x| signs.iter().flat_map(move |&y| signs.map(|z| Vec3::new(x, y, z))))
                        .map(|sign| *center + *radius * sign)
                        .collect();
                    let (center, radius) = (center.as_dvec3(), f64::from(*radius));
                    self.cover(&corners, primitive(0), &mut nearest, |ray| ray.hit_sphere(center, radius));
                }
                Geometry::Mesh { positions, triangles } => {
                    for (i, triangle) in triangles.iter().enumerate() {
                        let corners = triangle.map(|i| positions[i as usize]);
                        let abc = corners.map(Vec3::as_dvec3);
                        self.cover(&corners, primitive(i), &mut nearest, |ray| ray.hit_triangle(abc));
                    }
                }
            }
        }
        nearest.into_iter().map(|(_, first)| first).collect()
    }

    /// Tests the points of the grid that a convex body with these corners can cover.
    fn cover(
        &self,
        corners: &[Vec3],
        primitive: Primitive,
        nearest: &mut [(f64, Option<Primitive>)],
        hit: impl Fn(Ray) -> Option<f64>,
    ) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut any_in_front, mut any_behind) = (false, false);
        for corner in corners {
            let Some(pixel) = self.projector.project(corner.as_dvec3()) else {
                any_behind = true;
                continue;
            };
            any_in_front = true;
            for axis in 0..2 {
                low[axis] = low[axis].min(pixel[axis]);
                high[axis] = high[axis].max(pixel[axis]);
            }
        }
        if !any_in_front {
            return;
        }
        // What passes through the camera's plane has no bounds in the image.
        let range = |axis: usize| {
            let last = self.size[axis] as f64;
            if any_behind {
                return 0..self.size[axis];
            }
            let from = (low[axis] - self.offset - 1.0).clamp(0.0, last) as usize;
            let to = (high[axis] - self.offset + 2.0).clamp(0.0, last) as usize;
            from..to
        };
        for y in range(1) {
            for x in range(0) {
                let ray = self.projector.ray([x as f64 + self.offset, y as f64 + self.offset]);
                let point = &mut nearest[y * self.size[0] + x];
                if let Some(t) = hit(ray)
                    && t < point.0
                {
                    *point = (t, Some(primitive));
                }
            }
        }
    }
}
