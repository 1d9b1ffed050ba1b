//! Meshes to measure with.

use glam::{Vec2, Vec3};

/// Positions and triangles of a mesh, and where it is seen from.
pub struct Mesh {
    pub name: &'static str,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub eye: Vec3,
    pub target: Vec3,
    /// Centre and radius of a small light.
    pub light: (Vec3, f32),
}

/// Hash of a lattice point, in [-1, 1].
fn hash(p: [i32; 3]) -> f32 {
    let mut h = 0x9e37_79b9u32;
    for v in p {
        h = (h ^ v as u32).wrapping_mul(0x85eb_ca6b);
        h ^= h >> 13;
        h = h.wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    h as f32 / u32::MAX as f32 * 2.0 - 1.0
}

/// Smooth noise of wavelength 1.
fn noise(p: Vec3) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let f = f * f * (3.0 - 2.0 * f);
    let at = |x: i32, y: i32, z: i32| hash([cell.x as i32 + x, cell.y as i32 + y, cell.z as i32 + z]);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let plane = |z: i32| mix(mix(at(0, 0, z), at(1, 0, z), f.x), mix(at(0, 1, z), at(1, 1, z), f.x), f.y);
    mix(plane(0), plane(1), f.z)
}

/// Noise at several wavelengths.
fn rough(p: Vec3) -> f32 {
    (0..7).map(|k| noise(p * 2f32.powi(k) + 17.0 * k as f32) * 0.5f32.powi(k)).sum()
}

/// A grid of quads cut into two triangles each.
fn grid(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let at = |i: u32, j: u32| j * (columns + 1) + i;
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    triangles
}

/// Hills, seen from above at a slant; half the diffuse rays go to the sky.
pub fn terrain(count: usize) -> Mesh {
    let n = ((count / 2) as f64).sqrt().round() as u32;
    let mut positions = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let p = Vec2::new(i as f32, j as f32) / n as f32 * 10.0 - 5.0;
            positions.push(Vec3::new(p.x, 0.8 * rough(Vec3::new(p.x, 0.0, p.y) * 0.8), p.y));
        }
    }
    Mesh {
        name: "terrain",
        positions,
        triangles: grid(n, n),
        eye: Vec3::new(0.0, 3.2, 4.8),
        target: Vec3::new(0.0, 0.0, 0.5),
        light: (Vec3::new(3.0, 4.0, -2.0), 0.2),
    }
}

/// A rough hollow sphere, seen from within: every ray meets something, far away.
pub fn cave(count: usize) -> Mesh {
    let rows = ((count / 4) as f64).sqrt().round() as u32;
    let columns = 2 * rows;
    let mut positions = Vec::new();
    for j in 0..=rows {
        for i in 0..=columns {
            let phi = (i % columns) as f32 / columns as f32 * std::f32::consts::TAU;
            let theta = (j as f32 + 0.01) / (rows as f32 + 0.02) * std::f32::consts::PI;
            let d = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            positions.push(d * (4.0 + 1.5 * rough(d * 3.0)));
        }
    }
    Mesh {
        name: "cave",
        positions,
        triangles: grid(columns, rows),
        eye: Vec3::new(0.3, 0.2, 1.0),
        target: Vec3::new(2.0, -0.7, -2.0),
        light: (Vec3::new(-0.5, 0.9, 0.4), 0.1),
    }
}
