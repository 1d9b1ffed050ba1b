//! The few functions of Embree 3's C interface that are needed, as its headers declare them.

use std::ffi::c_void;
use std::ptr;

use glam::Vec3;

use crate::rays::{Packet, WIDTH};

#[repr(C, align(64))]
struct Ray16 {
    org: [[f32; WIDTH]; 3],
    near: [f32; WIDTH],
    dir: [[f32; WIDTH]; 3],
    time: [f32; WIDTH],
    far: [f32; WIDTH],
    mask: [u32; WIDTH],
    id: [u32; WIDTH],
    flags: [u32; WIDTH],
}

#[repr(C, align(64))]
struct Hit16 {
    normal: [[f32; WIDTH]; 3],
    uv: [[f32; WIDTH]; 2],
    primitive: [u32; WIDTH],
    geometry: [u32; WIDTH],
    instance: [u32; WIDTH],
}

#[repr(C, align(64))]
struct RayHit16 {
    ray: Ray16,
    hit: Hit16,
}

#[repr(C)]
struct Context {
    flags: u32,
    filter: *const c_void,
    instance: [u32; 1],
}

#[link(name = "embree3")]
unsafe extern "C" {
    fn rtcNewDevice(config: *const i8) -> *mut c_void;
    fn rtcNewScene(device: *mut c_void) -> *mut c_void;
    fn rtcSetSceneBuildQuality(scene: *mut c_void, quality: u32);
    fn rtcNewGeometry(device: *mut c_void, kind: u32) -> *mut c_void;
    fn rtcSetNewGeometryBuffer(
        g: *mut c_void,
        kind: u32,
        slot: u32,
        format: u32,
        stride: usize,
        n: usize,
    ) -> *mut c_void;
    fn rtcCommitGeometry(geometry: *mut c_void);
    fn rtcAttachGeometry(scene: *mut c_void, geometry: *mut c_void) -> u32;
    fn rtcCommitScene(scene: *mut c_void);
    fn rtcIntersect16(valid: *const i32, scene: *mut c_void, context: *mut Context, hit: *mut RayHit16);
    fn rtcOccluded16(valid: *const i32, scene: *mut c_void, context: *mut Context, ray: *mut Ray16);
}

/// A mesh in Embree's form.
pub struct Embree {
    scene: *mut c_void,
}

impl Embree {
    /// Builds on one thread, with Embree's usual quality.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        // SAFETY: calls as the headers document them; the buffers have the sizes asked for.
        unsafe {
            let device = rtcNewDevice(c"threads=1".as_ptr().cast());
            assert!(!device.is_null(), "Embree can be set up");
            let scene = rtcNewScene(device);
            rtcSetSceneBuildQuality(scene, 1);
            let geometry = rtcNewGeometry(device, 0);
            let vertices = rtcSetNewGeometryBuffer(geometry, 1, 0, 0x9003, 12, positions.len());
            ptr::copy_nonoverlapping(positions.as_ptr().cast::<f32>(), vertices.cast(), positions.len() * 3);
            let indices = rtcSetNewGeometryBuffer(geometry, 0, 0, 0x5003, 12, triangles.len());
            ptr::copy_nonoverlapping(triangles.as_ptr().cast::<u32>(), indices.cast(), triangles.len() * 3);
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene, geometry);
            rtcCommitScene(scene);
            Self { scene }
        }
    }

    /// Distance and triangle of what each ray meets first.
    pub fn nearest(&self, packets: &[Packet], coherent: bool, out: &mut [([f32; WIDTH], [u32; WIDTH])]) {
        let valid = Valid([-1; WIDTH]);
        for (packet, out) in packets.iter().zip(out) {
            let mut context = Context { flags: u32::from(coherent), filter: ptr::null(), instance: [u32::MAX] };
            let hit = Hit16 {
                normal: [[0.0; WIDTH]; 3],
                uv: [[0.0; WIDTH]; 2],
                primitive: [u32::MAX; WIDTH],
                geometry: [u32::MAX; WIDTH],
                instance: [u32::MAX; WIDTH],
            };
            let mut both = RayHit16 { ray: ray(packet), hit };
            // SAFETY: aligned as declared, and the scene is committed.
            unsafe { rtcIntersect16(valid.0.as_ptr(), self.scene, &mut context, &mut both) };
            *out = (both.ray.far, both.hit.primitive);
        }
    }

    /// Bit i: something is in the way of ray i.
    pub fn blocked(&self, packets: &[Packet], coherent: bool, out: &mut [u32]) {
        let valid = Valid([-1; WIDTH]);
        for (packet, out) in packets.iter().zip(out) {
            let mut context = Context { flags: u32::from(coherent), filter: ptr::null(), instance: [u32::MAX] };
            let mut ray = ray(packet);
            // SAFETY: as above.
            unsafe { rtcOccluded16(valid.0.as_ptr(), self.scene, &mut context, &mut ray) };
            *out = (0..WIDTH).map(|i| u32::from(ray.far[i] < 0.0) << i).sum();
        }
    }
}

#[repr(align(64))]
struct Valid([i32; WIDTH]);

fn ray(packet: &Packet) -> Ray16 {
    Ray16 {
        org: packet.origin,
        near: [0.0; WIDTH],
        dir: packet.dir,
        time: [0.0; WIDTH],
        far: packet.t_max,
        mask: [u32::MAX; WIDTH],
        id: [0; WIDTH],
        flags: [0; WIDTH],
    }
}
