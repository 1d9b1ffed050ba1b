//! The camera and the surfaces in plain double precision: from pixels to rays, from points to pixels, and where a ray
//! hits a sphere or a triangle.
//!
//! For what is asked about a scene apart from rendering it: what is under the mouse, which pixels show which plate.
//! Rendering works on the same axes, rounded to single precision: [`crate::world::camera::Pinhole`].

use glam::{DMat4, DVec3};

use crate::request::scene::Camera;

/// Points closer to the plane of the eye than this, in camera space, have no place in the image.
const NEAREST: f64 = 1e-6;

/// A half-line from `origin`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, world space.
    pub origin: DVec3,
    /// Where it goes, not of unit length.
    pub direction: DVec3,
}

impl Ray {
    /// Smallest t > 0 where `origin + t direction` hits the sphere.
    pub fn hit_sphere(&self, center: DVec3, radius: f64) -> Option<f64> {
        let (oc, direction) = (self.origin - center, self.direction);
        let (a, half_b, c) = (direction.length_squared(), oc.dot(direction), oc.length_squared() - radius * radius);
        let root = (half_b * half_b - a * c).sqrt();
        // NaN, where the line misses, fails both tests.
        [(-half_b - root) / a, (-half_b + root) / a].into_iter().find(|&t| t > 0.0)
    }

    /// t > 0 where `origin + t direction` hits the triangle (Möller and Trumbore 1997).
    pub fn hit_triangle(&self, [a, b, c]: [DVec3; 3]) -> Option<f64> {
        let (ab, ac) = (b - a, c - a);
        let p = self.direction.cross(ac);
        let determinant = ab.dot(p);
        let from_a = self.origin - a;
        let u = from_a.dot(p) / determinant;
        let q = from_a.cross(ab);
        let v = self.direction.dot(q) / determinant;
        let t = ac.dot(q) / determinant;
        // A determinant of 0 (edge-on) makes these infinite or NaN, and fails.
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t.is_finite()).then_some(t)
    }
}

/// A camera's mapping between the world and the image, in pixels from the top left.
#[derive(Clone, Copy, Debug)]
pub struct Projector {
    /// The eye, world space.
    pub eye: DVec3,
    /// Direction through the image's top left corner, world space.
    pub corner: DVec3,
    /// What a pixel to the right adds to the direction.
    pub right: DVec3,
    /// What a pixel downwards adds to it.
    pub down: DVec3,
    camera_from_world: DMat4,
    /// Pixel = `scale * (X, Y) / Z + shift` for camera space (X, Y, Z).
    scale: [f64; 2],
    shift: [f64; 2],
}

impl Projector {
    /// The camera over an image of that many pixels. A camera that cannot be used makes numbers that are none.
    pub fn new(camera: &Camera, resolution: [u32; 2]) -> Self {
        let [width, height] = resolution.map(f64::from);
        let [left, right, bottom, top] = camera.screen(resolution);
        let tan = (camera.fov_deg.to_radians() / 2.0).tan();
        let world = camera.world_from_camera;
        let direction = |x: f64, y: f64, z: f64| world.transform_vector3(DVec3::new(x, y, z));
        let pixel = [(right - left) / width * tan, (bottom - top) / height * tan];
        Self {
            eye: world.transform_point3(DVec3::ZERO),
            corner: direction(left * tan, top * tan, 1.0),
            right: direction(pixel[0], 0.0, 0.0),
            down: direction(0.0, pixel[1], 0.0),
            camera_from_world: world.inverse(),
            scale: [1.0 / pixel[0], 1.0 / pixel[1]],
            shift: [-left * tan / pixel[0], -top * tan / pixel[1]],
        }
    }

    /// The ray through a point of the image.
    pub fn ray(&self, [x, y]: [f64; 2]) -> Ray {
        Ray { origin: self.eye, direction: self.corner + x * self.right + y * self.down }
    }

    /// Where a point of the world is in the image; `None` behind the eye or beside it.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let p = self.camera_from_world.transform_point3(point);
        let at = |axis: usize| self.scale[axis] * p[axis] / p.z + self.shift[axis];
        (p.z > NEAREST).then(|| [at(0), at(1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_goes_through_what_is_seen_at_its_pixel() {
        let camera = Camera {
            world_from_camera: DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)) * DMat4::from_rotation_y(0.3),
            fov_deg: 40.0,
            screen_window: None,
        };
        let projector = Projector::new(&camera, [300, 200]);
        let ray = projector.ray([211.5, 37.25]);
        let [x, y] = projector.project(ray.origin + 7.0 * ray.direction).expect("in front of the eye");
        assert!((x - 211.5).abs() < 1e-9 && (y - 37.25).abs() < 1e-9, "{x}, {y}");
        assert_eq!(projector.project(ray.origin - ray.direction), None, "behind the eye");
    }

    #[test]
    fn a_ray_hits_the_near_side_first() {
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
        assert_eq!(ray.hit_sphere(DVec3::new(0.0, 0.0, 5.0), 1.0), Some(4.0));
        assert_eq!(ray.hit_sphere(DVec3::ZERO, 1.0), Some(1.0), "from the inside");
        assert_eq!(ray.hit_sphere(DVec3::new(0.0, 0.0, -5.0), 1.0), None, "behind");
        let triangle = [DVec3::new(-1.0, -1.0, 2.0), DVec3::new(3.0, -1.0, 2.0), DVec3::new(-1.0, 3.0, 2.0)];
        assert_eq!(ray.hit_triangle(triangle), Some(2.0));
        assert_eq!(ray.hit_triangle(triangle.map(|p| p + DVec3::X * 2.0)), None, "beside");
    }
}
