//! Why a picture is black or nearly so, in words.

use glam::Vec3;
use mislab_kernel::light::LightShape;
use mislab_kernel::request::{PixelRect, Scene, Strategy};

use crate::frame::Frame;
use crate::inspect::{Inspector, Point, Seen};
use crate::layer::Channel;

/// Rows and columns of camera rays that look for surfaces, and how many of the lights are looked for from the points that
/// they hit.
const RAYS: u32 = 64;
const LIGHTS: usize = 16;
/// Rays from points to lights. It is asked between two passes of a window.
const QUERIES: usize = 4096;
/// From so many primitives or lights on there are fewer rays: where all lie in one place, each ray tests them all.
const MANY: usize = 1024;
/// A picture with more than this share of pixels that are not 0 needs no explanation.
const LIT: f64 = 1.0 / 3.0;

const NO_LIGHT: &str = "no light reaches this picture directly";

/// One sentence that says why a picture is black, or why most of its surfaces are; `None` if it is neither.
pub fn why_black(frame: &Frame) -> Option<String> {
    let lit = lit_pixels(frame);
    if lit as f64 > LIT * frame.bounds().area() as f64 {
        return None;
    }
    let request = frame.request();
    if let Some(reason) = unlit(&request.scene) {
        return Some(format!("{NO_LIGHT}: {reason}"));
    }
    let inspector = Inspector::new(frame.scene(), &request.settings);
    let view = look_around(frame, &inspector);
    if lit == 0 { why_all_black(frame, &view) } else { why_mostly_black(frame, &view) }
}

/// What camera rays meet.
struct View<'a> {
    /// Is there anything at all?
    empty: bool,
    /// Points of surfaces that reflect and give off nothing themselves.
    points: Vec<Point<'a>>,
}

fn look_around<'a>(frame: &Frame, inspector: &'a Inspector<'_>) -> View<'a> {
    let geometry = &frame.scene().geometry;
    let rays = if geometry.facets.len() + geometry.balls.len() > MANY { RAYS / 4 } else { RAYS };
    let mut view = View { empty: true, points: Vec::new() };
    for [x, y] in grid(frame.bounds(), rays) {
        match inspector.at_pixel(x, y) {
            Seen::Nothing => {}
            Seen::Light(_) => view.empty = false,
            Seen::Surface(point) => {
                view.empty = false;
                // What gives off light itself is not dark.
                view.points.extend((point.reflects() && point.emitted() == Vec3::ZERO).then_some(point));
            }
        }
    }
    view
}

const MIRRORS: &str = "only mirrors are in view, and light samples never hit a mirror's one direction";
const TURNED: &str = "its lights face away, or something is in between";

/// The reason where every pixel is 0.
fn why_all_black(frame: &Frame, view: &View<'_>) -> Option<String> {
    let strategy = frame.request().settings.estimator.strategy;
    Some(if view.empty {
        format!("{NO_LIGHT}: nothing of the scene is in view")
    } else if view.points.is_empty() {
        "this picture is black: everything in view is black".to_owned()
    } else if strategy == Strategy::Light && view.points.iter().all(Point::is_mirror) {
        format!("this picture is black: {MIRRORS}")
    } else if lit_share(frame, &view.points) > 0.0 {
        let (name, spp) = (strategy.name(), frame.spp());
        format!("this picture is black: no sample of the strategy {name} has hit a light in {spp} spp")
    } else {
        format!("{NO_LIGHT}: {TURNED}")
    })
}

/// The reason where some pixels are not 0.
fn why_mostly_black(frame: &Frame, view: &View<'_>) -> Option<String> {
    let strategy = frame.request().settings.estimator.strategy;
    if view.points.is_empty() {
        return None;
    }
    if strategy == Strategy::Light && view.points.iter().all(Point::is_mirror) {
        return Some(format!("all surfaces in view are black: {MIRRORS}"));
    }
    let share = lit_share(frame, &view.points);
    let but = if share > 0.0 {
        format!(" but for {} % of the surfaces in view", (100.0 * share).ceil())
    } else {
        " but from lights in view".into()
    };
    (share <= LIT).then(|| format!("{NO_LIGHT}{but}: {TURNED}"))
}

/// The share of points that see a light, of some points and some lights.
fn lit_share(frame: &Frame, points: &[Point<'_>]) -> f64 {
    let list = &frame.scene().lights.list;
    let (queries, most) = if list.len() > MANY { (QUERIES / 64, LIGHTS / 4) } else { (QUERIES, LIGHTS) };
    let lights = list.iter().step_by(list.len().div_ceil(most).max(1));
    let targets: Vec<Vec3> = lights.map(|light| middle(&light.shape)).collect();
    let sees_light = |point: &Point<'_>| {
        targets.iter().any(|target| {
            let seen = point.direction((*target - point.position()).normalize_or_zero());
            seen.visible && seen.wi.dot(point.normal()) > 0.0
        })
    };
    let some: Vec<&Point<'_>> = points.iter().step_by(points.len().div_ceil(queries / most)).collect();
    some.iter().filter(|point| sees_light(point)).count() as f64 / some.len() as f64
}

/// True if every pixel is 0.
pub fn is_black(frame: &Frame) -> bool {
    frame.tiles.iter().all(|tile| lit_in(frame, tile.bounds, &mut Vec::new()) == 0)
}

/// How many pixels are not 0; counted until there are so many that the number does not matter.
fn lit_pixels(frame: &Frame) -> usize {
    let (mut lit, mut values) = (0, Vec::new());
    for tile in &frame.tiles {
        lit += lit_in(frame, tile.bounds, &mut values);
        if lit as f64 > LIT * frame.bounds().area() as f64 {
            break;
        }
    }
    lit
}

fn lit_in(frame: &Frame, part: PixelRect, values: &mut Vec<f32>) -> usize {
    values.clear();
    values.resize(3 * part.area(), 0.0);
    frame.resolve_rect(&[Channel::R, Channel::G, Channel::B], part, values);
    let (r, rest) = values.split_at(part.area());
    let (g, b) = rest.split_at(part.area());
    r.iter().zip(g).zip(b).filter(|&((&r, &g), &b)| r != 0.0 || g != 0.0 || b != 0.0).count()
}

/// Why no picture of this scene can be anything but black, if that can be told from what it consists of.
fn unlit(scene: &Scene) -> Option<&'static str> {
    let mut lights = scene.shapes.iter().filter_map(|shape| shape.light.as_ref()).peekable();
    if scene.shapes.is_empty() {
        Some("the scene has no shapes")
    } else if lights.peek().is_none() {
        Some("the scene has no area light, the only kind that is read")
    } else if lights.all(|light| !light.on || light.radiance == Vec3::ZERO) {
        Some("every light is off or emits nothing")
    } else {
        None
    }
}

/// Points spread over a part of the image, pixel centres if it is small.
fn grid(part: PixelRect, rays: u32) -> impl Iterator<Item = [f32; 2]> {
    let [columns, rows] = [part.width().min(rays), part.height().min(rays)];
    let at = |i: u32, n: u32, min: u32, size: u32| min as f32 + (i as f32 + 0.5) * (size as f32 / n as f32);
    (0..rows).flat_map(move |j| {
        (0..columns).map(move |i| [at(i, columns, part.min[0], part.width()), at(j, rows, part.min[1], part.height())])
    })
}

/// A point of a light that rays towards it hit.
fn middle(light: &LightShape) -> Vec3 {
    match light {
        LightShape::Ball(ball) => ball.center,
        LightShape::Facet(facet) => {
            let share = if facet.quad { 0.5 } else { 1.0 / 3.0 };
            facet.p0 + (facet.e1 + facet.e2) * share
        }
    }
}
