//! The rays to measure with, in packets of 16.

use glam::Vec3;

use crate::mesh::Mesh;

pub const WIDTH: usize = 16;
/// Side of the picture in pixels.
pub const SIDE: u32 = 800;

/// Sixteen rays, coordinate by coordinate.
#[derive(Clone)]
pub struct Packet {
    pub origin: [[f32; WIDTH]; 3],
    pub dir: [[f32; WIDTH]; 3],
    pub t_max: [f32; WIDTH],
}

impl Packet {
    fn new(rays: &[(Vec3, Vec3, f32)]) -> Self {
        let at = |f: &dyn Fn(&(Vec3, Vec3, f32)) -> f32| std::array::from_fn(|i| f(&rays[i]));
        Self {
            origin: [0, 1, 2].map(|c| at(&|r| r.0[c])),
            dir: [0, 1, 2].map(|c| at(&|r| r.1[c])),
            t_max: at(&|r| r.2),
        }
    }

    pub fn ray(&self, i: usize) -> (Vec3, Vec3) {
        let get = |v: &[[f32; WIDTH]; 3]| Vec3::new(v[0][i], v[1][i], v[2][i]);
        (get(&self.origin), get(&self.dir))
    }
}

/// Numbers in [0, 1) (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// Camera rays in blocks of 4 x 4 pixels, eight blocks to a side of a patch's 8 x 8 as the renderer walks.
pub fn primary(mesh: &Mesh) -> Vec<Packet> {
    let forward = (mesh.target - mesh.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let mut random = Random(1);
    let mut packets = Vec::new();
    let patches = SIDE / 8;
    for patch in 0..patches * patches {
        for block in 0..4 {
            let x0 = patch % patches * 8 + block % 2 * 4;
            let y0 = patch / patches * 8 + block / 2 * 4;
            let rays: Vec<_> = (0..16)
                .map(|i| {
                    let x = ((x0 + i % 4) as f32 + random.unit()) / SIDE as f32 * 2.0 - 1.0;
                    let y = ((y0 + i / 4) as f32 + random.unit()) / SIDE as f32 * 2.0 - 1.0;
                    let d = forward + 0.5 * (x * right - y * up);
                    (mesh.eye, d.normalize(), f32::INFINITY)
                })
                .collect();
            packets.push(Packet::new(&rays));
        }
    }
    packets
}

/// Rays from what the camera rays met: to a point of the light, and in a direction of the cosine's law.
/// Rays that met nothing are replaced by a neighbour's.
pub fn secondary(mesh: &Mesh, primary: &[Packet], hits: &[([f32; WIDTH], [u32; WIDTH])]) -> (Vec<Packet>, Vec<Packet>) {
    let mut random = Random(2);
    let (mut shadow, mut diffuse) = (Vec::new(), Vec::new());
    for (packet, (t, id)) in primary.iter().zip(hits) {
        let (mut to_light, mut anywhere) = (Vec::new(), Vec::new());
        let Some(some) = (0..WIDTH).find(|&i| t[i].is_finite()) else { continue };
        for i in 0..WIDTH {
            let i = if t[i].is_finite() { i } else { some };
            let (o, d) = packet.ray(i);
            let [a, b, c] = mesh.triangles[id[i] as usize].map(|k| mesh.positions[k as usize]);
            let n = (b - a).cross(c - a).normalize();
            let n = if n.dot(d) > 0.0 { -n } else { n };
            let p = o + d * t[i] + n * 1e-4;
            let l = mesh.light.0 + mesh.light.1 * sphere(&mut random);
            to_light.push((p, (l - p).normalize(), (l - p).length() * 0.999));
            anywhere.push((p, (n + 0.9999 * sphere(&mut random)).normalize(), f32::INFINITY));
        }
        shadow.push(Packet::new(&to_light));
        diffuse.push(Packet::new(&anywhere));
    }
    (shadow, diffuse)
}

fn sphere(random: &mut Random) -> Vec3 {
    let z = 1.0 - 2.0 * random.unit();
    let phi = std::f32::consts::TAU * random.unit();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}
