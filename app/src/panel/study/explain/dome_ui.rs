//! The hemisphere on screen: a disc of directions in false colours, with lights outlined and samples as dots.

use std::sync::Arc;

use eframe::egui::{
    self, Align2, Color32, ColorImage, Pos2, Rect, Role, Sense, Shape, Stroke, TextStyle, TextureHandle,
    TextureOptions, Ui, pos2, vec2,
};
use mislab_renderer::inspect::{Direction, Technique};
use mislab_renderer::{Estimator, Strategy};

use super::curves::Curve;
use super::dome::{Disc, Dome, DomeJob};
use super::number::short;
use super::place::{LightSeen, angle, luminance};
use super::shown::Shown;
use super::slice::words;
use super::slice_plot::dot;
use crate::look::colormap::ColourMap;
use crate::look::theme::{GRID, Inks};
use crate::panel::widgets::{caption, segmented};

/// Decades below the largest value that are told apart.
const DECADES: f64 = 5.0;
/// The last samples: so many are drawn.
const LAST: usize = 64;

/// What is coloured.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Image {
    Curve(Curve),
    /// w_L.
    Weight,
    /// What a sample there is worth.
    Value,
}

const IMAGES: [(Image, &str); 5] = [
    (Image::Curve(Curve::F), "f"),
    (Image::Curve(Curve::PLight), "p_L"),
    (Image::Curve(Curve::PBsdf), "p_B"),
    (Image::Weight, "w_L"),
    (Image::Value, "f / d"),
];

/// What is kept of it.
pub struct Hemisphere {
    image: Image,
    whole: bool,
    dome: DomeJob,
    drawn: Option<Drawn>,
}

/// The disc on screen, and what it was made of.
struct Drawn {
    dome: Arc<Dome>,
    estimator: Estimator,
    image: Image,
    dark: bool,
    largest: f64,
    texture: TextureHandle,
}

impl Default for Hemisphere {
    fn default() -> Self {
        Self { image: Image::Curve(Curve::F), whole: true, dome: DomeJob::default(), drawn: None }
    }
}

impl Hemisphere {
    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.dome.rest();
    }
}

impl Image {
    fn value(self, seen: &Direction, estimator: &Estimator) -> f64 {
        match (self, estimator.strategy) {
            (Self::Curve(curve), _) => curve.value(seen, estimator),
            (Self::Weight, _) => f64::from(seen.weighted(estimator)[0].weight),
            (Self::Value, Strategy::Bsdf) => Curve::ByBsdf.value(seen, estimator),
            (Self::Value, Strategy::Light | Strategy::MisAll | Strategy::Mis) => Curve::ByLight.value(seen, estimator),
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Curve(curve) => curve.hint(),
            Self::Weight => "Weight of a light sample in each direction: amber where it is 1, blue where it is 0.",
            Self::Value => "What a sample in each direction adds: f over the mixture, with the balance heuristic.",
        }
    }
}

/// Draws it.
pub fn dome_ui(ui: &mut Ui, state: &mut Hemisphere, shown: &Shown<'_>) {
    let hint = |ui: &mut Ui, image: Image| drop(ui.label(image.hint()));
    if let Some(image) = segmented(ui, "Image", state.image, &IMAGES, true, &hint) {
        state.image = image;
    }
    let light = shown.surface.highlight();
    let name = light.map_or_else(|| "The lobe".to_owned(), |light| format!("The lobe and {}", light.name));
    let parts = [(true, "All directions"), (false, name.as_str())];
    let hint = |ui: &mut Ui, _: bool| {
        ui.label("How much is shown: the hemisphere, or what is about the mirror direction.");
    };
    if let Some(whole) = segmented(ui, "Part", state.whole, &parts, true, &hint) {
        state.whole = whole;
    }
    let disc =
        if state.whole { Disc::hemisphere(shown.surface) } else { Disc::peak(shown.surface, reach(shown, light)) };
    let Some(dome) = state.dome.of(ui.ctx(), shown.place, shown.surface.normal, disc) else {
        caption(ui, "Working \u{2026}");
        return;
    };
    draw(ui, state, shown, &dome);
    let Some(drawn) = &state.drawn else { return };
    let foot = 4.0 * ui.text_style_height(&TextStyle::Small);
    let side = (ui.available_height() - foot).min(ui.available_width()).max(120.0);
    let (place, response) = ui.allocate_exact_size(vec2(ui.available_width(), side), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(Role::Image, true, "Directions of the pixel"));
    let rect = Rect::from_center_size(place.center(), egui::Vec2::splat(side)).shrink(GRID);
    let uv = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    ui.painter().image(drawn.texture.id(), rect, uv, Color32::WHITE);
    let disc = dome.disc();
    overlay_ui(ui, shown, &disc, rect);
    let pointed = response.hover_pos().and_then(|at| at_pointer(&dome, rect, at));
    let fine = if dome.is_fine() { "" } else { " Coarse so far \u{2026}" };
    caption(
        ui,
        pointed.map_or_else(
            || {
                let what = match state.image {
                    Image::Weight => "Amber: w_L 1, blue: 0".to_owned(),
                    Image::Curve(_) | Image::Value if drawn.largest <= 0.0 => "Dark: nothing".to_owned(),
                    Image::Curve(_) | Image::Value => {
                        format!("Yellow: {}, each colour of five down a tenth; dark: nothing", short(drawn.largest))
                    }
                };
                format!(
                    "{what}. Rim: {:.1}\u{b0} from {}; distances are angles. Outlines: lights; dots: the last samples.{fine}",
                    disc.reach.to_degrees(),
                    if state.whole { "the normal" } else { "the mirror direction" }
                )
            },
            |seen| words(angle(seen.wi, shown.surface.mirrored), &seen, shown),
        ),
    );
}

/// So far that lobe and light are seen with some room around them, in radians.
fn reach(shown: &Shown<'_>, light: Option<&LightSeen>) -> f64 {
    let light = light.map_or(0.0, |light| light.off + light.radius);
    let lobe = shown.surface.alpha.map_or(0.0, |alpha| 2.0 * f64::from(alpha).atan());
    (1.25 * light.max(lobe)).clamp(0.25_f64.to_radians(), std::f64::consts::FRAC_PI_2)
}

/// Colours it, if anything about it has changed.
fn draw(ui: &Ui, state: &mut Hemisphere, shown: &Shown<'_>, dome: &Arc<Dome>) {
    let (image, estimator, dark) = (state.image, shown.estimator, ui.visuals().dark_mode);
    let current = state.drawn.as_ref().is_some_and(|drawn| {
        Arc::ptr_eq(&drawn.dome, dome) && (drawn.estimator, drawn.image, drawn.dark) == (estimator, image, dark)
    });
    if current {
        return;
    }
    let values: Vec<Option<f64>> =
        dome.seen.iter().map(|seen| seen.as_ref().map(|seen| image.value(seen, &estimator))).collect();
    let largest = values.iter().flatten().copied().fold(0.0, f64::max);
    let paper = ui.visuals().panel_fill;
    let colour = |value: &Option<f64>| {
        let Some(value) = *value else { return paper };
        let (map, share) = match image {
            Image::Weight => (ColourMap::technique(dark), value),
            Image::Curve(_) | Image::Value if value <= 0.0 => return Color32::BLACK,
            Image::Curve(_) | Image::Value => (ColourMap::Viridis, 1.0 + (value / largest).log10() / DECADES),
        };
        let [r, g, b] = map.at(share as f32).map(|c| (255.0 * c).round() as u8);
        Color32::from_rgb(r, g, b)
    };
    let pixels = ColorImage::new([dome.side(); 2], values.iter().map(colour).collect());
    let texture = ui.ctx().load_texture("directions", pixels, TextureOptions::NEAREST);
    state.drawn = Some(Drawn { dome: dome.clone(), estimator, image, dark, largest, texture });
}

/// Outlines of the lights, the mirror direction, and the last samples.
fn overlay_ui(ui: &Ui, shown: &Shown<'_>, disc: &Disc, rect: Rect) {
    let painter = ui.painter_at(rect.expand(GRID));
    let at = |[x, y]: [f64; 2]| rect.center() + 0.5 * rect.width() * vec2(x as f32, -y as f32);
    let inside = |[x, y]: [f64; 2]| x.hypot(y) <= 1.0;
    painter.circle_stroke(rect.center(), 0.5 * rect.width(), Stroke::new(1.0, ui.visuals().weak_text_color()));
    let font = TextStyle::Small.resolve(ui.style());
    let mut named: Vec<Rect> = Vec::new();
    for light in &shown.surface.lights {
        let middle = light.centre.as_dvec3();
        let (u, v) = middle.any_orthonormal_pair();
        let ring = (0..=64).map(|i| {
            let turn = std::f64::consts::TAU * f64::from(i) / 64.0;
            let aside = u * turn.cos() + v * turn.sin();
            disc.place((middle * light.radius.cos() + aside * light.radius.sin()).as_vec3())
        });
        let ring: Vec<Pos2> = ring.filter(|place| inside(*place)).map(at).collect();
        if ring.is_empty() {
            continue;
        }
        let outline = Rect::from_points(&ring);
        painter.add(Shape::line(ring, Stroke::new(1.5, Color32::WHITE)));
        // Over it or under it, wherever no other name is.
        let name = painter.layout_no_wrap(light.name.clone(), font.clone(), Color32::WHITE);
        let places = [
            Align2::CENTER_BOTTOM.anchor_size(outline.center_top() - vec2(0.0, 0.5 * GRID), name.size()),
            Align2::CENTER_TOP.anchor_size(outline.center_bottom() + vec2(0.0, 0.5 * GRID), name.size()),
        ];
        if let Some(place) = places.into_iter().find(|place| !named.iter().any(|other| other.intersects(*place))) {
            painter.galley(place.min, name, Color32::WHITE);
            named.push(place);
        }
    }
    let peak = disc.place(shown.surface.mirrored);
    if inside(peak) {
        for side in [vec2(5.0, 5.0), vec2(5.0, -5.0)] {
            painter.line_segment([at(peak) - side, at(peak) + side], Stroke::new(1.5, Color32::WHITE));
        }
    }
    let Some(samples) = shown.samples else { return };
    let last = &samples.list[samples.list.len().saturating_sub(LAST)..];
    let rays = || last.iter().flat_map(|sample| &sample.rays).filter(|ray| ray.valid);
    let largest = rays().map(|ray| luminance(ray.value)).fold(0.0, f64::max);
    // Those of the dark theme: discs are dark in both.
    let inks = Inks::of(&egui::Visuals::dark());
    for ray in rays() {
        let place = disc.place(ray.wi);
        let share = if largest > 0.0 { (luminance(ray.value) / largest).sqrt() as f32 } else { 0.0 };
        let ink = match ray.technique {
            Technique::Light => inks.light,
            Technique::Bsdf => inks.bsdf,
        };
        if inside(place) {
            dot(&painter, at(place), ray.technique, 5.0 * share, ink);
        }
    }
}

/// What is seen in the direction under the mouse.
fn at_pointer(dome: &Dome, rect: Rect, pointer: Pos2) -> Option<Direction> {
    let share = (pointer - rect.min) / rect.size();
    let side = dome.side();
    let [column, row] = [share.x, share.y].map(|share| (share * side as f32).floor());
    let inside = |i: f32| (0.0..side as f32).contains(&i);
    (inside(column) && inside(row)).then(|| dome.seen[row as usize * side + column as usize]).flatten()
}
