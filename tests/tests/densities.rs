//! Every sampler has the density that it claims.
//!
//! Four million samples of each pair go into tables of 10 x 20, 50 x 100 and 100 x 200 cells; what each cell
//! should hold is the integral of the renderer's own density over it. The cells are those of the whole sphere
//! and those of a chart in which the lobe or light fills the table (`mislab_tests::charts`).
//!
//! A GGX lobe may send samples below the surface, where the density is 0: there the integral of the density
//! is the probability of staying above, and the samples below are one more cell. Lights that turn their backs
//! fail alike.
//!
//! What single precision cannot show: unit vectors are 6e-8 apart, so that directions into a cone of
//! sin^2 = 1e-14 are distinct only where the components across are small numbers, that is around an axis of
//! space. There the tables hold for the smallest cones; along other directions they are made from 1e-6 up.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use mislab_kernel::bsdf::{self, BuiltMaterial, Surface};
use mislab_kernel::lanes::{Lanes, Lanewise, Mask, PACKET, Real, V3};
use mislab_kernel::sampler::{Dimension, Numbers};
use mislab_kernel::warp;
use mislab_renderer::{Bsdf, Reflectance, SamplerKind, SamplerSettings};
use mislab_tests::charts::{Chart, frame};
use mislab_tests::chi_square::PValues;
use mislab_tests::depth::is_deep;
use mislab_tests::light_scenes::{View, facets, far_balls, mixtures, near_balls};
use mislab_tests::pair::{Case, Found, INDEPENDENT, Pair, check, in_parallel, integral};

/// How much an integral of a density may differ from 1, or from the probability of success.
const INTEGRAL: f64 = 1e-4;

/// A light technique.
struct LightPair(View);

impl Pair for LightPair {
    #[inline(always)]
    fn sample<L: Lanes>(&self, l: L, random: &Numbers<L>) -> (V3<L>, L::M) {
        let aim = self.0.lights.sample(l, V3::splat(l, self.0.p), random);
        (aim.wi, aim.valid)
    }
    #[inline(always)]
    fn density<L: Lanes>(&self, l: L, wi: V3<L>) -> L::F {
        self.0.lights.look(l, V3::splat(l, self.0.p), wi, l.f(0.0), false).pdf
    }
}

/// The BSDF technique at one surface, seen from one direction.
struct BsdfPair {
    material: BuiltMaterial,
    n: Vec3,
    wo: Vec3,
}

impl Pair for BsdfPair {
    #[inline(always)]
    fn sample<L: Lanes>(&self, l: L, random: &Numbers<L>) -> (V3<L>, L::M) {
        let s = Surface { p: V3::splat(l, Vec3::ZERO), n: V3::splat(l, self.n), material: &self.material };
        let wi = bsdf::sample(l, &s, V3::splat(l, self.wo), random).0;
        (wi, wi.dot(s.n).gt(l.f(0.0)))
    }
    #[inline(always)]
    fn density<L: Lanes>(&self, l: L, wi: V3<L>) -> L::F {
        let s = Surface { p: V3::splat(l, Vec3::ZERO), n: V3::splat(l, self.n), material: &self.material };
        bsdf::evaluate(l, &s, V3::splat(l, self.wo), wi).pdf
    }
}

/// A map of the unit square alone.
enum WarpPair {
    Hemisphere,
    Cone {
        one_minus_cos: f32,
    },
    Triangle,
    VisibleNormal {
        wo: Vec3,
        alpha: f32,
    },
    /// No map: two numbers of the sampler.
    Square,
}

impl Pair for WarpPair {
    #[inline(always)]
    fn sample<L: Lanes>(&self, l: L, random: &Numbers<L>) -> (V3<L>, L::M) {
        let u = random.get_2d(Dimension::Bsdf);
        let d = match *self {
            Self::Hemisphere => warp::square_to_cosine_hemisphere(l, u),
            Self::Cone { one_minus_cos } => warp::square_to_cone(l, u, l.f(one_minus_cos)),
            Self::Triangle => {
                let [x, y] = warp::square_to_triangle(l, u);
                V3 { x, y, z: l.f(0.0) }
            }
            Self::VisibleNormal { wo, alpha } => {
                warp::square_to_visible_normal(l, u, V3::splat(l, wo), l.f(alpha)).normalize(l)
            }
            Self::Square => V3 { x: u[0], y: u[1], z: l.f(0.0) },
        };
        (d, l.m(true))
    }
    #[inline(always)]
    fn density<L: Lanes>(&self, l: L, d: V3<L>) -> L::F {
        match *self {
            Self::Hemisphere => warp::cosine_hemisphere_pdf(l, d.z),
            Self::Cone { one_minus_cos } => {
                let h = f64::from(one_minus_cos);
                // 1 - cos^2 of the rim, and a little for rounding at it; up to the hemisphere.
                let inside =
                    (d.x * d.x + d.y * d.y).le(l.f((h * (2.0 - h) * (1.0 + 1e-6)) as f32)) & d.z.ge(l.f(-1e-7));
                inside.select(warp::cone_pdf::<L>(l.f(1.0 / one_minus_cos)), l.f(0.0))
            }
            Self::Triangle => (d.x + d.y).le(l.f(1.0)).select(l.f(2.0), l.f(0.0)),
            Self::VisibleNormal { wo, alpha } => {
                let mut out = [0.0; PACKET];
                for (i, out) in out.iter_mut().enumerate().take(L::N) {
                    let h = DVec3::new(d.x.lane(i).into(), d.y.lane(i).into(), d.z.lane(i).into());
                    *out = visible_normal(wo.as_dvec3(), h, alpha.into()) as f32;
                }
                l.load(&out)
            }
            Self::Square => l.f(1.0),
        }
    }
}

/// Density of visible normals, `G1(wo) max(0, wo . h) D(h) / cos_o` (Heitz 2018, eq. 3), Trowbridge-Reitz.
fn visible_normal(wo: DVec3, h: DVec3, alpha: f64) -> f64 {
    if h.z <= 0.0 {
        return 0.0;
    }
    // sin^2 from the components across, which keeps narrow lobes.
    let length2 = h.length_squared();
    let (sin2, cos2) = ((h.x * h.x + h.y * h.y) / length2, h.z * h.z / length2);
    let d = 1.0 / (PI * alpha * alpha * cos2 * cos2 * (1.0 + sin2 / (cos2 * alpha * alpha)).powi(2));
    let tan2 = (wo.x * wo.x + wo.y * wo.y) / (wo.z * wo.z);
    let lambda = ((1.0 + alpha * alpha * tan2).sqrt() - 1.0) / 2.0;
    wo.dot(h).max(0.0) * d / ((1.0 + lambda) * wo.z)
}

/// Probability that a visible normal reflects `wo` below the surface: from theory, with no help from the renderer.
fn below(wo: DVec3, alpha: f64) -> f64 {
    struct Below {
        wo: DVec3,
        alpha: f64,
    }
    impl Pair for Below {
        #[inline(always)]
        fn sample<L: Lanes>(&self, l: L, _: &Numbers<L>) -> (V3<L>, L::M) {
            (V3::all(l.f(0.0)), l.m(false))
        }
        #[inline(always)]
        fn density<L: Lanes>(&self, l: L, d: V3<L>) -> L::F {
            let mut out = [0.0; PACKET];
            for (i, out) in out.iter_mut().enumerate().take(L::N) {
                let h = DVec3::new(d.x.lane(i).into(), d.y.lane(i).into(), d.z.lane(i).into());
                let wi = h * (2.0 * self.wo.dot(h)) - self.wo * h.length_squared();
                *out = if wi.z > 0.0 { 0.0 } else { visible_normal(self.wo, h, self.alpha) as f32 };
            }
            l.load(&out)
        }
    }
    integral(&Below { wo, alpha }, &Chart::Normal { alpha })
}

fn case<P>(name: String, pair: P, charts: Vec<Chart>, success: f64) -> Case<'static, P> {
    Case { name, pair, charts, partly: false, success, rounding: 5e-7, how: Lanewise::best(), settings: &INDEPENDENT }
}

fn light_case(view: View, chart_of: usize) -> Case<'static, LightPair> {
    let (charts, success) = (view.charts(chart_of), view.success());
    let partly = view.lights.list.len() > 1;
    let rounding = view.rounding();
    Case { rounding, partly, ..case(view.name.clone(), LightPair(view), charts, success) }
}

/// wo at this angle from the pole.
fn viewer(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let azimuth = 0.7f64;
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

const N: DVec3 = DVec3::new(-0.48, 0.64, 0.6);

fn bsdf_case(name: &str, bsdf: &Bsdf, degrees: f64) -> Case<'static, BsdfPair> {
    let n = N.as_vec3();
    let wo = (frame(N) * viewer(degrees)).as_vec3();
    let f = frame(n.as_dvec3().normalize());
    let local = f.transpose() * wo.as_dvec3();
    let mut charts = vec![Chart::Sphere { frame: frame(DVec3::new(0.36, 0.48, 0.8)) }];
    let mut success = 1.0;
    if let Some(alpha) = bsdf.alpha().map(f64::from) {
        charts.push(Chart::Lobe { frame: f, wo: local, alpha });
        let share = if matches!(bsdf, Bsdf::Plastic { .. }) { 0.5 } else { 1.0 };
        success = 1.0 - share * below(local, alpha);
    } else {
        charts.push(Chart::Cone { frame: f, one_minus_cos: 0.8 });
    }
    let label = format!("{name} from {degrees} degrees");
    case(label, BsdfPair { material: BuiltMaterial::new(bsdf), n, wo }, charts, success)
}

fn metal(alpha: f32) -> Bsdf {
    Bsdf::Conductor { reflectance: Reflectance::Constant(Vec3::ONE), alpha }
}

fn plastic(alpha: f32) -> Bsdf {
    Bsdf::Plastic { kd: Vec3::splat(0.4), ks: Vec3::splat(0.5), alpha, swapped_indices: false }
}

fn bsdf_cases() -> Vec<Case<'static, BsdfPair>> {
    let matte = Bsdf::Matte { kd: Vec3::splat(0.5) };
    let mut list = Vec::new();
    if is_deep() {
        for degrees in [0.0, 30.0, 60.0, 80.0, 88.0, 89.9] {
            for alpha in [1e-3, 3e-3, 0.01, 0.05, 0.2, 0.5, 1.0] {
                list.push(("metal", metal(alpha), degrees));
                list.push(("plastic", plastic(alpha), degrees));
            }
            list.push(("matte", matte.clone(), degrees));
        }
    } else {
        for (alpha, degrees) in
            [(1e-3, 0.0), (1e-3, 60.0), (0.01, 89.9), (0.01, 30.0), (0.05, 80.0), (0.2, 88.0), (1.0, 0.0), (1.0, 89.9)]
        {
            list.push(("metal", metal(alpha), degrees));
        }
        list.extend([("plastic", plastic(0.02), 60.0), ("plastic", plastic(0.5), 85.0), ("matte", matte, 30.0)]);
    }
    // Lobes of this width hold too few directions of single precision for a table.
    list.retain(|(_, bsdf, degrees)| {
        bsdf.alpha().is_none_or(|a| f64::from(a) * f64::to_radians(*degrees).cos() > 1e-5)
    });
    list.iter()
        .map(|(name, bsdf, degrees)| {
            let alpha = bsdf.alpha().map_or(String::new(), |alpha| format!(" of alpha {alpha}"));
            bsdf_case(&format!("{name}{alpha}"), bsdf, *degrees)
        })
        .collect()
}

fn light_cases() -> Vec<Case<'static, LightPair>> {
    let ordinary = |view: &View| {
        ["1e-14", "aslant, sin^2 1e-6", "x, sin^2 3e-1", "9.98e-1", "on a", "centre", "near its", "at 0.02", "aside"]
            .iter()
            .any(|part| view.name.contains(part))
            || view.lights.list.len() > 1 && ![5, 33].contains(&view.lights.list.len())
    };
    let views = [far_balls(), near_balls(), facets(), mixtures()].into_iter().flatten();
    views.filter(|view| is_deep() || ordinary(view)).map(|view| light_case(view, 0)).collect()
}

fn warp_cases() -> Vec<Case<'static, WarpPair>> {
    let z = frame(DVec3::Z);
    let all = |name: String, pair, chart| case(name, pair, vec![chart], 1.0);
    let mut cases = vec![
        all("cosine hemisphere".into(), WarpPair::Hemisphere, Chart::Cone { frame: z, one_minus_cos: 1.0 }),
        all("triangle".into(), WarpPair::Triangle, Chart::Flat),
        all("square".into(), WarpPair::Square, Chart::Flat),
    ];
    for one_minus_cos in [5e-15f32, 1e-3, 1.0] {
        let chart = Chart::Cone { frame: z, one_minus_cos: one_minus_cos.into() };
        cases.push(all(format!("cone of 1 - cos = {one_minus_cos:e}"), WarpPair::Cone { one_minus_cos }, chart));
    }
    let normals: &[(f32, f64)] = if is_deep() {
        &[(1e-4, 0.0), (1e-4, 60.0), (1e-4, 89.9), (1e-3, 80.0), (0.03, 45.0), (0.3, 89.9), (1.0, 0.0), (1.0, 89.9)]
    } else {
        &[(1e-4, 60.0), (1e-4, 89.9), (0.3, 80.0)]
    };
    for &(alpha, degrees) in normals {
        let wo = viewer(degrees).as_vec3();
        let chart = Chart::Normal { alpha: alpha.into() };
        cases.push(all(
            format!("visible normal of alpha {alpha} from {degrees} degrees"),
            WarpPair::VisibleNormal { wo, alpha },
            chart,
        ));
    }
    cases
}

/// One number chooses the light or the lobe, and what it leaves draws the direction.
#[test]
fn nested_choices_have_the_density_that_is_claimed() {
    let lattice = SamplerSettings { kind: SamplerKind::Lattice, ..INDEPENDENT };
    let lights: Vec<_> = [mixtures(), facets(), far_balls().split_off(20)]
        .into_iter()
        .flatten()
        .map(|view| Case { settings: &lattice, ..light_case(view, 0) })
        .collect();
    let bsdfs = [("plastic of alpha 0.02", plastic(0.02), 60.0), ("plastic of alpha 0.5", plastic(0.5), 85.0)]
        .map(|(name, bsdf, degrees)| Case { settings: &lattice, ..bsdf_case(name, &bsdf, degrees) });
    let mut family = PValues::new("lattices against densities");
    let found = in_parallel(lights.len() + bsdfs.len(), |i| match lights.get(i) {
        Some(case) => check(case, 2000 + i as u32),
        None => check(&bsdfs[i - lights.len()], 2000 + i as u32),
    });
    let mut count = 0;
    for found in found.into_iter().flatten() {
        assert!(found.excess.abs() <= INTEGRAL && found.stray.is_empty(), "{found:?}");
        family.test(found.label, found.outcome);
        count += 1;
    }
    family.judge(count);
}

#[test]
fn samples_have_the_density_that_is_claimed() {
    let (lights, bsdfs, warps) = (light_cases(), bsdf_cases(), warp_cases());
    let mut scalar = [bsdf_case("metal of alpha 0.1, single lane", &metal(0.1), 50.0)];
    scalar[0].how = Lanewise::Single;
    let mut runs: Vec<Box<dyn Fn(u32) -> Vec<Found> + Sync>> = Vec::new();
    for case in &lights {
        runs.push(Box::new(move |seed| check(case, seed)));
    }
    for case in bsdfs.iter().chain(&scalar) {
        runs.push(Box::new(move |seed| check(case, seed)));
    }
    for case in &warps {
        runs.push(Box::new(move |seed| check(case, seed)));
    }
    let found = in_parallel(runs.len(), |i| {
        let start = std::time::Instant::now();
        let found = runs[i](1000 + i as u32);
        println!("{:.2} s {}", start.elapsed().as_secs_f64(), found[0].label);
        found
    });
    let mut family = PValues::new("samples against densities");
    let mut off = Vec::new();
    for found in found.into_iter().flatten() {
        if found.excess.abs() > INTEGRAL || found.excess.is_nan() {
            off.push(format!("{}: integral is off by {:e}", found.label, found.excess));
        }
        if let Some(d) = found.stray.first() {
            let n = found.stray.len();
            off.push(format!("{}: {n} samples where the density is 0, the first in direction {d}", found.label));
        }
        family.test(found.label, found.outcome);
    }
    assert!(off.is_empty(), "integrals that are off by more than {INTEGRAL}, or stray samples:\n{}", off.join("\n"));
    family.judge(200);
}
