//! pbrt's transformations. Vectors are columns: a directive multiplies the current matrix from the right.

use std::ops::Mul;

use glam::{DMat3, DMat4, DVec3};

/// A transformation and its inverse, each composed from the exact parts: the camera needs the
/// inverse of a `LookAt`, and gets its eye point to the last digit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transform {
    pub matrix: DMat4,
    pub inverse: DMat4,
}

impl Transform {
    pub const IDENTITY: Self = Self { matrix: DMat4::IDENTITY, inverse: DMat4::IDENTITY };

    pub fn from_matrix(matrix: DMat4) -> Self {
        Self { matrix, inverse: matrix.inverse() }
    }

    pub fn inverted(self) -> Self {
        Self { matrix: self.inverse, inverse: self.matrix }
    }

    pub fn translate(by: DVec3) -> Self {
        Self { matrix: DMat4::from_translation(by), inverse: DMat4::from_translation(-by) }
    }

    pub fn scale(by: DVec3) -> Self {
        Self { matrix: DMat4::from_scale(by), inverse: DMat4::from_scale(by.recip()) }
    }

    /// Turns by `degrees` about `axis`, counter-clockwise seen from the axis's tip in a right-handed
    /// frame. `None` if the axis has no direction.
    pub fn rotate(degrees: f64, axis: DVec3) -> Option<Self> {
        let matrix = DMat4::from_axis_angle(axis.try_normalize()?, degrees.to_radians());
        Some(Self { matrix, inverse: matrix.transpose() })
    }

    /// World to camera, left-handed: in camera space +x points right, +y up and +z from `eye` to
    /// `look`. `None` if the three do not span a frame.
    pub fn look_at(eye: DVec3, look: DVec3, up: DVec3) -> Option<Self> {
        let forward = (look - eye).try_normalize()?;
        let right = up.try_normalize()?.cross(forward).try_normalize()?;
        let up = forward.cross(right);
        let world_from_camera =
            DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), eye.extend(1.0));
        Some(Self::from_matrix(world_from_camera).inverted())
    }
}

impl Mul for Transform {
    type Output = Self;

    fn mul(self, right: Self) -> Self {
        Self { matrix: self.matrix * right.matrix, inverse: right.inverse * self.inverse }
    }
}

/// True if the matrix mirrors: a right hand becomes a left hand.
pub(super) fn swaps_handedness(m: &DMat4) -> bool {
    m.determinant() < 0.0
}

/// How far lengths may differ by direction, squared, for a transformation that counts as uniform. A rotation that was
/// typed with three digits behind the point has entries off by up to 5e-4, which is up to 1.8e-3 here; two of them together
/// are twice as far off.
const UNIFORM: f64 = 4e-3;

/// The factor by which the matrix scales all lengths, if it is the same for all directions (see [`UNIFORM`]).
pub(super) fn uniform_scale(m: &DMat4) -> Option<f64> {
    let linear = DMat3::from_mat4(*m);
    let gram = linear.transpose() * linear;
    let square = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
    let deviation = gram - DMat3::from_diagonal(DVec3::splat(square));
    let worst = deviation.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    (worst <= UNIFORM * square).then(|| square.sqrt())
}

/// Why a transformation cannot be used, if it cannot.
pub(super) fn flaw(Transform { matrix: m, inverse }: &Transform) -> Option<&'static str> {
    if !m.is_finite() || !m.determinant().is_finite() {
        return Some("a matrix with numbers that are too large");
    }
    if [m.x_axis.w, m.y_axis.w, m.z_axis.w, m.w_axis.w] != [0.0, 0.0, 0.0, 1.0] {
        return Some("a projective matrix, expected 0 0 0 1 as its last row (values 4, 8, 12 and 16)");
    }
    // The inverse must exist as numbers too: the camera and handedness depend on it.
    if m.determinant() == 0.0 || !inverse.is_finite() {
        return Some("a matrix without an inverse (a scale is 0 or too small)");
    }
    None
}
