//! Which strategy is best for each size of light and roughness: exact variances, by quadrature.
//!
//! The surface point is where a plate, taken as a plane mirror, shows the centre of a round light to the camera. Its roughness
//! and the light's radius vary, the light's power does not; all else is as in the scene, the other lights included.

use glam::{DMat4, DVec3};
use mislab_kernel::request::{Camera, Estimator, Geometry, ImageSettings, Scene, Settings, Strategy};
use mislab_kernel::world::BuiltScene;

use crate::inspect::{Accuracy, Inspector};

/// Variances that differ by less are called equal: their errors differ by half as much.
pub const NO_DIFFERENCE: f64 = 1.1;

/// A mean that is off by more than this share is another one's.
const SAME_MEAN: f64 = 1e-3;

/// A plate and a light of a scene, and the point where one shows the other.
#[derive(Clone, Debug)]
pub struct Square {
    scene: Scene,
    /// Index of the plate's shape.
    plate: usize,
    /// Index of its material.
    material: usize,
    /// Index of the light's shape.
    light: usize,
    eye: DVec3,
    target: DVec3,
}

/// Exact variances at one point of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variances {
    /// Luminance of the reflected radiance.
    pub mean: f64,
    /// Of one ray, over the square of the mean; in the order of [`Strategy::ALL`]. `mis_all` pays for two rays a
    /// sample. `None` where the strategy does not have the mean: the tutorial's weights at c = 0 or 1, a mirror.
    pub per_ray: [Option<f64>; 4],
}

impl Variances {
    /// The strategy of least variance, and how many times that of the second best it is; `None` if all are biased or
    /// none has any variance.
    pub fn best(&self) -> Option<(Strategy, f64)> {
        best_of(self.per_ray)
    }
}

/// [`Variances::best`] of variances from elsewhere, such as between known ones.
pub fn best_of(per_ray: [Option<f64>; 4]) -> Option<(Strategy, f64)> {
    let (mut best, mut second) = (None, f64::INFINITY);
    for (strategy, variance) in Strategy::ALL.into_iter().zip(per_ray) {
        let Some(variance) = variance else { continue };
        match best {
            Some((_, least)) if variance >= least => second = second.min(variance),
            Some((_, least)) => (best, second) = (Some((strategy, variance)), least),
            None => best = Some((strategy, variance)),
        }
    }
    let (best, least) = best?;
    let margin = second / least;
    (!margin.is_nan()).then_some((best, margin))
}

impl Square {
    /// All pairs of a plate (a mesh with a roughness) and a round light that is on, where the camera sees the one in the
    /// other; of the plates in the order of the scene, for each its lights.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let plates = scene.shapes.iter().enumerate().filter_map(|(plate, shape)| {
            let material = shape.material.filter(|_| shape.light.is_none())?;
            scene.materials.get(material)?.bsdf.alpha()?;
            Some((plate, material))
        });
        let mut all = Vec::new();
        for (plate, material) in plates {
            for light in scene.light_shapes() {
                all.extend(Self::of(scene, plate, material, light).filter(|square| square.is_seen()));
            }
        }
        all
    }

    fn of(scene: &Scene, plate: usize, material: usize, light: usize) -> Option<Self> {
        let (Geometry::Mesh { positions, triangles }, Geometry::Sphere { center, .. }) =
            (&scene.shapes[plate].geometry, &scene.shapes[light].geometry)
        else {
            return None;
        };
        scene.shapes[light].light.as_ref().filter(|light| light.on)?;
        let eye = scene.camera.world_from_camera.transform_point3(DVec3::ZERO);
        let corners = triangles.first()?.map(|i| positions.get(i as usize).map(|p| p.as_dvec3()));
        let (a, b, c) = (corners[0]?, corners[1]?, corners[2]?);
        let n = (b - a).cross(c - a).normalize_or_zero();
        let center = center.as_dvec3();
        let dir = center - n * (2.0 * n.dot(center - a)) - eye;
        let target = eye + dir * (n.dot(a - eye) / n.dot(dir));
        let square = Self { scene: scene.clone(), plate, material, light, eye, target };
        target.is_finite().then_some(square)
    }

    /// Whether the plate is what the camera sees there.
    fn is_seen(&self) -> bool {
        let (Some(alpha), Some(radius)) = (self.alpha(), self.radius()) else { return false };
        self.ask(alpha, radius, |point| point.shape() == self.plate).unwrap_or(false)
    }

    /// Name of the plate's material.
    pub fn plate(&self) -> &str {
        &self.scene.materials[self.material].name
    }

    /// Name of the light.
    pub fn light(&self) -> &str {
        self.scene.shapes[self.light].light.as_ref().map_or("", |light| &light.name)
    }

    /// Where the plate shows the light, in the scene's unit.
    pub fn point(&self) -> DVec3 {
        self.target
    }

    /// Distances from there to the camera and to the light's centre.
    pub fn distances(&self) -> [f64; 2] {
        let center = match &self.scene.shapes[self.light].geometry {
            Geometry::Sphere { center, .. } => center.as_dvec3(),
            Geometry::Mesh { .. } => self.target,
        };
        [self.target.distance(self.eye), self.target.distance(center)]
    }

    /// The plate's GGX width in the scene.
    pub fn alpha(&self) -> Option<f32> {
        self.scene.materials[self.material].bsdf.alpha()
    }

    /// The light's radius in the scene.
    pub fn radius(&self) -> Option<f32> {
        match self.scene.shapes[self.light].geometry {
            Geometry::Sphere { radius, .. } => Some(radius),
            Geometry::Mesh { .. } => None,
        }
    }

    /// Variances with another roughness (GGX width) and radius of the light, at the same power. Heuristic, c and weights are
    /// those of `own`. `None` where nothing arrives or the scene cannot be built. Some milliseconds.
    pub fn variances(&self, alpha: f32, radius: f32, own: &Estimator) -> Option<Variances> {
        self.ask(alpha, radius, |point| {
            let table = point.tabulate(&ACCURACY);
            let of = |strategy| table.moments(&Estimator { strategy, ..*own }).total;
            let truth = of(Strategy::Bsdf).mean;
            let per_ray = Strategy::ALL.map(|strategy| {
                let moments = of(strategy);
                let same = (moments.mean - truth).abs() <= SAME_MEAN * truth;
                let rays = f64::from(strategy.rays_per_sample());
                same.then_some(rays * moments.variance / (truth * truth))
            });
            (truth > 0.0).then_some(Variances { mean: truth, per_ray })
        })
        .flatten()
    }

    /// Asks about the surface at the point, seen from the camera.
    fn ask<R>(&self, alpha: f32, radius: f32, ask: impl FnOnce(&crate::inspect::Point<'_>) -> R) -> Option<R> {
        let mut scene = self.scene.clone();
        *scene.materials.get_mut(self.material)?.bsdf.alpha_mut()? = alpha;
        scene.set_light_radius(&self.scene, self.light, radius);
        scene.camera = keyhole(self.eye, self.target);
        let image = ImageSettings { resolution: [SIDE; 2], ..ImageSettings::default() };
        let settings = Settings { image, ..Settings::default() };
        let built = BuiltScene::new(&scene, &settings).ok()?;
        let middle = SIDE as f32 / 2.0;
        let seen = Inspector::new(&built, &settings).at_pixel(middle, middle);
        seen.point().map(|point| ask(&point))
    }
}

/// Colours are told apart at 10 %: this leaves a wide margin, and takes a fraction of the time of the default.
const ACCURACY: Accuracy = Accuracy { relative_error: 1e-3, evaluations: 50_000 };

/// Pixels along a side of the picture through the keyhole; one would do.
const SIDE: u32 = 8;

/// A camera all of whose pixels see `target`.
fn keyhole(eye: DVec3, target: DVec3) -> Camera {
    let forward = (target - eye).normalize();
    let (right, up) = forward.any_orthonormal_pair();
    let axes = [right, up, forward].map(|v| v.extend(0.0));
    let world_from_camera = DMat4::from_cols(axes[0], axes[1], axes[2], eye.extend(1.0));
    Camera { world_from_camera, fov_deg: 0.001, screen_window: None }
}
