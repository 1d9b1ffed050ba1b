//! Small measurements with the renderer: one surface point, many independent samples.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DMat4, DVec3, Vec3};
use mislab_renderer::{
    Camera, Channel, Frame, Geometry, ImageSettings, Request, SamplerKind, SamplerSettings, Sampling, Scene, Settings,
    engine,
};

use crate::oracle::LUMINANCE;

/// Side of the image of [`measure`], in pixels.
const SIDE: u32 = 32;

/// The default scene.
pub fn veach() -> Scene {
    mislab_renderer::pbrt::embedded_scene().scene
}

/// Settings for statistics: independent samples.
pub fn independent(spp: u32, seed: u32, resolution: [u32; 2]) -> Settings {
    Settings {
        sampling: Sampling {
            sampler: SamplerSettings { kind: SamplerKind::Independent, strata: [1, 1], jitter: true },
            spp: NonZeroU32::new(spp),
            seed,
        },
        image: ImageSettings { resolution, ..ImageSettings::default() },
        ..Settings::default()
    }
}

/// Renders to the target on all cores.
///
/// # Panics
/// If the request is refused.
pub fn render(scene: &Arc<Scene>, settings: &Settings) -> Arc<Frame> {
    render_on(0, scene, settings)
}

/// Renders to the target on so many threads.
///
/// # Panics
/// If the request is refused.
pub fn render_on(threads: usize, scene: &Arc<Scene>, settings: &Settings) -> Arc<Frame> {
    let request = Request { scene: scene.clone(), settings: settings.clone() };
    engine::render(&request, threads, &mut |_| true).expect("the request can be rendered")
}

/// Waits until `done` holds.
///
/// # Panics
/// After a minute: the limit is for a broken program only.
pub fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "waited a minute for: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The default scene with a rectangle and a triangle as lights, one-sided, in front of each other.
pub fn mesh_lights(radiance: Vec3) -> Scene {
    let mut scene = veach();
    let quad = |z: f32, s: f32| vec![[-s, -s, z], [s, -s, z], [s, s, z], [-s, s, z]];
    let shapes: Vec<usize> = scene.light_shapes().collect();
    for (shape, (points, triangles)) in shapes.into_iter().zip([
        (quad(0.5, 0.6), vec![[0, 2, 1], [0, 3, 2]]),
        (quad(-0.5, 1.0), vec![[0, 1, 2], [0, 2, 3]]),
        (vec![[2.0, -1.0, 0.0], [3.0, -1.5, 0.5], [2.5, 1.0, 0.0]], vec![[0, 1, 2]]),
    ]) {
        let shape = &mut scene.shapes[shape];
        shape.geometry = Geometry::Mesh {
            positions: Arc::new(points.into_iter().map(Vec3::from).collect()),
            triangles: Arc::new(triangles),
        };
        if let Some(light) = &mut shape.light {
            light.radiance = radiance;
        }
    }
    scene
}

/// A camera at `eye` that looks at `target`, with this field of view.
pub fn camera(eye: DVec3, target: DVec3, fov_deg: f64) -> Camera {
    let forward = (target - eye).normalize();
    let (right, up) = forward.any_orthonormal_pair();
    let axes = [right, up, forward].map(|v| v.extend(0.0));
    Camera {
        world_from_camera: DMat4::from_cols(axes[0], axes[1], axes[2], eye.extend(1.0)),
        fov_deg,
        screen_window: None,
    }
}

/// The scene through a keyhole: every pixel sees `target` from `eye`, within 1e-5 radians.
pub fn keyhole(scene: &Scene, eye: DVec3, target: DVec3) -> Arc<Scene> {
    Arc::new(Scene { camera: camera(eye, target, 0.001), ..scene.clone() })
}

/// Where a plane mirror spanned by the first triangle of the mesh `shape` shows the centre of the
/// sphere `light` to `eye`.
///
/// # Panics
/// If they are of other kinds.
pub fn highlight(scene: &Scene, shape: usize, light: usize, eye: DVec3) -> DVec3 {
    let Geometry::Mesh { positions, .. } = &scene.shapes[shape].geometry else { panic!("shape {shape} is no mesh") };
    let Geometry::Sphere { center, .. } = &scene.shapes[light].geometry else { panic!("shape {light} is no sphere") };
    let [a, b, c] = [0, 1, 2].map(|i| positions[i].as_dvec3());
    let n = (b - a).cross(c - a).normalize();
    let center = center.as_dvec3();
    let image = center - n * (2.0 * n.dot(center - a));
    let dir = image - eye;
    eye + dir * (n.dot(a - eye) / n.dot(dir))
}

/// What a keyhole picture tells about one sample.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Number of samples.
    pub n: f64,
    /// Samples per pixel.
    pub spp: f64,
    /// Mean per channel.
    pub mean_rgb: DVec3,
    /// Mean of luminance: picture, light layer, BSDF layer.
    pub mean: f64,
    /// Of the light technique.
    pub light: f64,
    /// Of the BSDF technique.
    pub bsdf: f64,
    /// Variance of the luminance of one sample, pooled over all pixels.
    pub variance: f64,
    /// Mean over pixels of the mean weights of light and of BSDF samples, and how many pixels have one.
    pub weights: [(f64, f64); 2],
}

/// Draws about `samples` independent samples of a [`keyhole`] scene; `settings` names the rest.
///
/// # Panics
/// If any sample was invalid.
pub fn measure(scene: &Arc<Scene>, settings: &Settings, samples: u32) -> Measured {
    let spp = (samples / (SIDE * SIDE)).max(2);
    let base = independent(spp, settings.sampling.seed, [SIDE, SIDE]);
    let settings = Settings {
        sampling: Sampling { sampler: base.sampling.sampler, spp: base.sampling.spp, ..settings.sampling },
        image: ImageSettings { resolution: base.image.resolution, ..settings.image },
        ..settings.clone()
    };
    let frame = render(scene, &settings);
    assert_eq!(frame.stats().invalid_samples, 0, "invalid samples");
    let pixels = f64::from(SIDE * SIDE);
    let spp = f64::from(spp);
    let n = pixels * spp;
    let rgb = |channels: [Channel; 3]| {
        let [r, g, b] = channels.map(|c| frame.channel(c));
        let colours = r.into_iter().zip(g).zip(b).map(|((r, g), b)| DVec3::new(r.into(), g.into(), b.into()));
        colours.collect::<Vec<_>>()
    };
    let mean_of = |colours: &[DVec3]| colours.iter().copied().sum::<DVec3>() / pixels;
    let picture = rgb([Channel::R, Channel::G, Channel::B]);
    let mean_rgb = mean_of(&picture);
    let mean = LUMINANCE.dot(mean_rgb);
    let within: f64 = frame.channel(Channel::VarianceY).iter().map(|&v| f64::from(v) * (spp - 1.0)).sum();
    let between: f64 = picture.iter().map(|&c| (LUMINANCE.dot(c) - mean).powi(2) * spp).sum();
    let weights = [Channel::WeightLightY, Channel::WeightBsdfY].map(|channel| {
        let defined: Vec<f64> = frame.channel(channel).into_iter().filter(|w| !w.is_nan()).map(f64::from).collect();
        let count = defined.len() as f64;
        (defined.iter().sum::<f64>() / count, count)
    });
    Measured {
        n,
        spp,
        mean_rgb,
        mean,
        light: LUMINANCE.dot(mean_of(&rgb([Channel::LightR, Channel::LightG, Channel::LightB]))),
        bsdf: LUMINANCE.dot(mean_of(&rgb([Channel::BsdfR, Channel::BsdfG, Channel::BsdfB]))),
        variance: (within + between) / (n - 1.0),
        weights,
    }
}
