//! The sketch on the board: eye ray, plate, lobe, lights and the last rays, in the plane of incidence.

use eframe::egui::{self, Align2, Pos2, Role, Sense, Shape, Stroke, TextStyle, Ui, Vec2, pos2, vec2};
use glam::{DVec3, Vec3};
use mislab_renderer::inspect::Technique;

use super::place::Surface;
use super::shown::Shown;
use crate::look::theme::{GRID, Inks};
use crate::panel::study::tiles::caption_that_fits;

/// The last samples: rays of so many are drawn.
const LAST: usize = 12;
/// Points of the lobe's outline.
const OUTLINE: usize = 361;

/// The plane of incidence: along the surface towards the mirror direction, and along the normal.
struct Plane {
    along: DVec3,
    normal: DVec3,
}

impl Plane {
    fn new(surface: &Surface) -> Self {
        let normal = surface.normal.as_dvec3();
        let across = |v: DVec3| v - normal * normal.dot(v);
        let along = across(surface.mirrored.as_dvec3());
        // Seen from straight above, any plane will do.
        let along = if along.length() > 1e-6 { along.normalize() } else { normal.any_orthonormal_vector() };
        Self { along, normal }
    }

    /// Angle of a direction's projection from the normal, positive towards the mirror direction. In radians.
    fn angle(&self, v: Vec3) -> f64 {
        let v = v.as_dvec3();
        v.dot(self.along).atan2(v.dot(self.normal))
    }

    /// How far a direction lies off the plane, in radians.
    fn off(&self, v: Vec3) -> f64 {
        v.as_dvec3().dot(self.along.cross(self.normal)).clamp(-1.0, 1.0).asin().abs()
    }

    fn direction(&self, angle: f64) -> Vec3 {
        (self.normal * angle.cos() + self.along * angle.sin()).as_vec3().normalize()
    }
}

/// Draws it over what is left of `ui`.
pub fn sketch_ui(ui: &mut Ui, shown: &Shown<'_>) {
    let foot = 4.0 * ui.text_style_height(&TextStyle::Small) + 2.0 * GRID;
    let size = vec2(ui.available_width(), (ui.available_height() - foot).clamp(160.0, 0.75 * ui.available_width()));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, "Sketch in the plane of incidence"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    let origin = pos2(rect.center().x, rect.bottom() - 7.0 * GRID);
    let reach = (0.5 * rect.width() - 3.0 * GRID).min(origin.y - rect.top() - 5.0 * GRID);
    let plane = Plane::new(shown.surface);
    let at = |angle: f64, share: f32| origin + share * reach * vec2(angle.sin() as f32, -angle.cos() as f32);
    let (ink, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    let inks = Inks::of(ui.visuals());
    let font = TextStyle::Small.resolve(ui.style());

    // The lights behind everything, as wide as they are seen.
    let mut corner = 2.0 * GRID;
    for light in &shown.surface.lights {
        let (middle, off) = (plane.angle(light.centre), plane.off(light.centre));
        let strength = if off <= light.radius { 0.5 } else { 0.2 };
        let ends = [middle - light.radius, middle + light.radius];
        let mut cone = vec![origin];
        cone.extend((0..=24).map(|i| at(ends[0] + (ends[1] - ends[0]) * f64::from(i) / 24.0, 1.0)));
        painter.add(Shape::convex_polygon(cone, inks.light.gamma_multiply(strength), Stroke::NONE));
        if off <= light.radius {
            painter.text(at(middle, 1.02), Align2::CENTER_BOTTOM, &light.name, font.clone(), ink);
        } else {
            // Several of them may lie behind each other: they are listed.
            let words = format!("{} {:.0}\u{b0} off the plane", light.name, off.to_degrees());
            painter.text(rect.left_top() + vec2(2.0 * GRID, corner), Align2::LEFT_TOP, words, font.clone(), weak);
            corner += ui.text_style_height(&TextStyle::Small);
        }
    }
    lobe(shown, &plane, &painter, &at, inks.bsdf);
    rays(shown, &plane, &painter, &at, inks);

    let plate = [origin - vec2(reach, 0.0), origin + vec2(reach, 0.0)];
    painter.line_segment(plate, Stroke::new(4.0, ink));
    let name = &shown.surface.name;
    painter.text(plate[1] + vec2(0.0, 1.5 * GRID), Align2::RIGHT_TOP, name, font.clone(), ink);
    painter.extend(Shape::dashed_line(&[origin, at(0.0, 0.6)], Stroke::new(1.0, weak), 1.5 * GRID, GRID));
    painter.text(at(0.0, 0.62), Align2::CENTER_BOTTOM, "n", font.clone(), weak);
    let mirror = plane.angle(shown.surface.mirrored);
    painter.extend(Shape::dashed_line(&[origin, at(mirror, 1.0)], Stroke::new(1.0, weak), 1.5 * GRID, GRID));
    let eye = at(plane.angle(shown.surface.wo), 0.9);
    arrow(&painter, [origin, eye], Stroke::new(2.5, ink));
    painter.text(eye - vec2(0.0, GRID), Align2::CENTER_BOTTOM, "eye", font, ink);
    caption_that_fits(
        ui,
        "The plane of incidence, as on the board. Blue shape: the lobe p_B, in proportion to its largest value. Amber: lights, \
         as wide as they are seen from here; pale ones lie off this plane. Lines: the last samples, pale where they add nothing.",
        "Blue shape: the lobe p_B; amber: lights; lines: the last samples.",
    );
}

/// The density of the BSDF technique as a polar plot, the largest as long as the rays.
fn lobe(shown: &Shown<'_>, plane: &Plane, painter: &egui::Painter, at: &dyn Fn(f64, f32) -> Pos2, ink: egui::Color32) {
    let Some(point) = shown.place.point() else { return };
    let peak = plane.angle(shown.surface.mirrored);
    let quarter = std::f64::consts::FRAC_PI_2;
    // Denser about the peak: a lobe of a degree has an outline, too.
    let angles = (0..OUTLINE).map(|i| {
        let share = 2.0 * i as f64 / (OUTLINE - 1) as f64 - 1.0;
        let side = if share < 0.0 { quarter + peak } else { quarter - peak };
        peak + side * share.abs().powi(3) * share.signum()
    });
    let outline: Vec<(f64, f64)> =
        angles.map(|angle| (angle, f64::from(point.direction(plane.direction(angle)).p_bsdf))).collect();
    let largest = outline.iter().map(|(_, p)| *p).fold(0.0, f64::max);
    if largest > 0.0 {
        let points: Vec<Pos2> = outline.iter().map(|(angle, p)| at(*angle, (0.85 * p / largest) as f32)).collect();
        painter.add(Shape::closed_line(points, Stroke::new(2.5, ink)));
    }
}

/// Rays of the last samples, in the colours of their techniques.
fn rays(shown: &Shown<'_>, plane: &Plane, painter: &egui::Painter, at: &dyn Fn(f64, f32) -> Pos2, inks: Inks) {
    let Some(samples) = shown.samples else { return };
    let last = &samples.list[samples.list.len().saturating_sub(LAST)..];
    for ray in last.iter().flat_map(|sample| &sample.rays).filter(|ray| ray.valid) {
        let ink = match ray.technique {
            Technique::Light => inks.light,
            Technique::Bsdf => inks.bsdf,
        };
        let angle = plane.angle(ray.wi);
        // Shorter where it comes out of the plane, as a drawing of space has it.
        let share = 0.95 * plane.off(ray.wi).cos() as f32;
        let stroke = if ray.lit { Stroke::new(1.5, ink) } else { Stroke::new(1.0, ink.gamma_multiply(0.4)) };
        painter.line_segment([at(angle, 0.0), at(angle, share)], stroke);
    }
}

/// A line with a head at its end.
fn arrow(painter: &egui::Painter, [from, to]: [Pos2; 2], stroke: Stroke) {
    painter.line_segment([from, to], stroke);
    let back: Vec2 = (from - to).normalized() * 3.0 * GRID;
    for side in [0.4, -0.4] {
        painter.line_segment([to, to + Vec2::angled(back.angle() + side) * back.length()], stroke);
    }
}
