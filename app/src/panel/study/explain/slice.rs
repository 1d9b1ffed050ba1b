//! The slice: a great circle of directions, with f, the densities and the weights as curves over the angle.

use eframe::egui::{self, Button, ComboBox, RichText, Role, Ui, vec2};
use mislab_renderer::Estimator;
use mislab_renderer::inspect::Direction;

use super::circle::Circle;
use super::curves::Curve;
use super::number::short;
use super::place::LightSeen;
use super::shown::Shown;
use super::slice_plot::{Drawing, ink, plot_ui};
use super::trace::{Part, TraceJob};
use crate::look::theme::{GRID, Inks};
use crate::panel::hint::Hint as _;
use crate::panel::study::tiles::{caption_lines, caption_that_fits};
use crate::panel::widgets::{ParamSlider, Scale, caption, segmented};
use crate::state::command::Command;

/// How much of the circle is shown, on either side of the mirror direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Reach {
    /// The lobe and the chosen light.
    #[default]
    Fit,
    /// So many degrees.
    Degrees(f64),
}

impl Reach {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Fit, "Fit"),
        (Self::Degrees(5.0), "\u{b1}5\u{b0}"),
        (Self::Degrees(20.0), "\u{b1}20\u{b0}"),
        (Self::Degrees(90.0), "\u{b1}90\u{b0}"),
    ];
}

/// What is kept of it.
pub struct Slice {
    /// Shape of the light that the circle passes through; `None`: the nearest to the mirror direction.
    light: Option<usize>,
    /// In degrees.
    turn: f64,
    reach: Reach,
    log: bool,
    hidden: Vec<Curve>,
    /// Of the last pass, in radians: it stands still while something is dragged.
    range: [f64; 2],
    trace: TraceJob,
}

impl Default for Slice {
    fn default() -> Self {
        Self {
            light: None,
            turn: 0.0,
            reach: Reach::Fit,
            log: true,
            hidden: Vec::new(),
            range: [-1.0, 1.0],
            trace: TraceJob::default(),
        }
    }
}

impl Slice {
    /// Gives up what is being worked out.
    pub fn rest(&mut self) {
        self.trace.rest();
    }
}

/// Draws it.
pub fn slice_ui(ui: &mut Ui, slice: &mut Slice, shown: &Shown<'_>, out: &mut Vec<Command>) {
    let surface = shown.surface;
    let chosen = surface.lights.iter().find(|light| Some(light.shape) == slice.light).or_else(|| surface.highlight());
    let Some(light) = chosen else {
        ui.label("No light is on: there is nothing to see.");
        return;
    };
    head_ui(ui, slice, shown, light);
    let circle = Circle::new(surface, light.centre, slice.turn.to_radians());
    let lobe = surface.alpha.filter(|alpha| *alpha > 0.0).map(|alpha| circle.lobe(surface, f64::from(alpha)));
    if ui.ctx().dragged_id().is_none() {
        slice.range = range(slice.reach, &circle, light, lobe);
    }
    let edges: Vec<f64> = surface.lights.iter().filter_map(|light| circle.interval(light)).flatten().collect();
    let part = Part { circle, range: slice.range, edges };
    let Some(trace) = slice.trace.of(ui.ctx(), shown.place, part) else {
        caption(ui, "Working \u{2026}");
        return;
    };
    let curves: Vec<Curve> = Curve::ALL.into_iter().filter(|curve| !slice.hidden.contains(curve)).collect();
    let drawing = Drawing { shown, circle, light, lobe, range: slice.range, trace: &trace, curves, log: slice.log };
    let foot = 2.0 * (ui.spacing().interact_size.y + GRID) + caption_lines(ui, [1.0, 3.0]) + 3.0 * GRID;
    let size = vec2(ui.available_width(), (ui.available_height() - foot).max(220.0));
    let reading = plot_ui(ui, &drawing, size, out);
    legend_ui(ui, slice, &shown.estimator);
    let resolution = if trace.is_fine() { "" } else { " Coarse so far \u{2026}" };
    let words = reading.map_or_else(
        || {
            let scale = if slice.log {
                "f: luminance/sr; p: 1/sr; f / d: luminance."
            } else {
                "Each curve over its own largest value."
            };
            format!("Angle from the mirror direction. {scale} Dots: samples, as large as what they add.{resolution}")
        },
        |seen| words(seen.angle, &seen.seen, shown),
    );
    caption_that_fits(ui, &words, if trace.is_fine() { "" } else { "Coarse so far \u{2026}" });
}

/// What there is at an angle from the mirror direction.
pub fn words(angle: f64, seen: &Direction, shown: &Shown<'_>) -> String {
    let name =
        |shape: usize| shown.surface.lights.iter().find(|light| light.shape == shape).map(|light| light.name.as_str());
    let hit = seen.hit.filter(|_| seen.visible).and_then(|hit| name(hit.shape)).unwrap_or("no light");
    let [light, _] = seen.weighted(&shown.estimator);
    let value = |curve: Curve| short(curve.value(seen, &shown.estimator));
    format!(
        "{:.2}\u{b0}, {hit}: f {}, p_L {} /sr, p_B {} /sr, w_L {:.3}, f / d {} (light), {} (BSDF)",
        angle.to_degrees(),
        value(Curve::F),
        value(Curve::PLight),
        value(Curve::PBsdf),
        light.weight,
        value(Curve::ByLight),
        value(Curve::ByBsdf),
    )
    .replace('-', "\u{2212}")
}

/// Both ends, alike: as asked for, or so that lobe and light are seen with some room around them.
fn range(reach: Reach, circle: &Circle, light: &LightSeen, lobe: Option<[f64; 2]>) -> [f64; 2] {
    let end = match reach {
        Reach::Degrees(degrees) => degrees.to_radians(),
        Reach::Fit => {
            let middle = circle.angle_of(light.centre).abs();
            let light = circle.interval(light).map_or(middle + light.radius, |ends| ends[0].abs().max(ends[1].abs()));
            let lobe = lobe.map_or(0.0, |ends| ends[0].abs().max(ends[1].abs()));
            (1.25 * light.max(lobe)).clamp(0.25_f64.to_radians(), 90_f64.to_radians())
        }
    };
    [-end, end]
}

fn head_ui(ui: &mut Ui, slice: &mut Slice, shown: &Shown<'_>, light: &LightSeen) {
    ui.horizontal(|ui| {
        let combo = ComboBox::from_id_salt("light of the slice").selected_text(&light.name).width(84.0);
        let response = combo.show_ui(ui, |ui| {
            for each in &shown.surface.lights {
                if ui.selectable_label(each.shape == light.shape, &each.name).clicked() {
                    slice.light = Some(each.shape);
                    slice.turn = 0.0;
                }
            }
        });
        response.response.widget_info(|| egui::WidgetInfo::labeled(Role::ComboBox, true, "Light of the slice"));
        response
            .response
            .hint("The circle of directions passes through the mirror direction and the middle of this light.");
        let turn = ParamSlider {
            name: "Turn",
            label_width: 1.9 * ui.text_style_height(&egui::TextStyle::Body),
            value: slice.turn,
            default: 0.0,
            range: -90.0..=90.0,
            scale: Scale::Linear(1),
            template: "\u{2212}90.0",
            unit: "\u{b0}",
            accent: None,
            zero_text: "",
            explain: &|ui| {
                ui.label("Turns the circle about the mirror direction: at 0 it passes through the light.");
            },
        };
        if let Some(turn) = turn.show(ui).changed {
            slice.turn = turn;
        }
    });
    ui.horizontal(|ui| {
        let half = 0.6 * ui.available_width();
        ui.allocate_ui(vec2(half, ui.spacing().interact_size.y), |ui| {
            let hint = |ui: &mut Ui, _: Reach| drop(ui.label("How much of the circle is shown."));
            if let Some(reach) = segmented(ui, "Reach", slice.reach, &Reach::ALL, true, &hint) {
                slice.reach = reach;
            }
        });
        let hint = |ui: &mut Ui, log: bool| {
            ui.label(if log { "Powers of ten are evenly spaced." } else { "Each curve over its own largest value." });
        };
        if let Some(log) = segmented(ui, "Height", slice.log, &[(true, "log"), (false, "linear")], true, &hint) {
            slice.log = log;
        }
    });
}

/// Names of the curves, each of which can be hidden.
fn legend_ui(ui: &mut Ui, slice: &mut Slice, estimator: &Estimator) {
    let inks = Inks::of(ui.visuals());
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(GRID, GRID);
        // Pale, so that the colours of the curves can be read on it.
        ui.visuals_mut().selection.bg_fill = ui.visuals().widgets.inactive.weak_bg_fill;
        for curve in Curve::ALL {
            let on = !slice.hidden.contains(&curve);
            let ink = ink(ui, inks, curve, estimator);
            let text = RichText::new(curve.name(estimator)).text_style(egui::TextStyle::Small).color(ink);
            let button = ui.add(Button::selectable(on, text)).hint(curve.hint());
            if button.clicked() {
                if on { slice.hidden.push(curve) } else { slice.hidden.retain(|other| *other != curve) }
            }
        }
    });
}
