//! The few controls that the panels are made of.

use std::cell::Cell;
use std::ops::RangeInclusive;

use eframe::egui::{
    self, Align, Align2, Color32, FontId, Label, Layout, Rect, Response, RichText, Sense, Slider, SliderClamping,
    Stroke, TextStyle, Ui, Widget as _, WidgetText, pos2, vec2,
};

use crate::look::theme::{GRID, medium};
use crate::panel::hint::Hint as _;
use crate::panel::number;

/// A ring around what the keyboard is on.
pub fn focus_ring(ui: &Ui, response: &Response, rect: Rect) {
    if response.has_focus() {
        let stroke = Stroke::new(2.0, ui.visuals().text_color());
        ui.painter().rect_stroke(rect, 4.0, stroke, egui::StrokeKind::Inside);
    }
}

/// Text in a cell at least as wide as `template`, so that counting does not move what is beside it.
pub fn cell(ui: &mut Ui, text: &str, template: &str, font: FontId, color: Option<Color32>, align: Align2) -> Response {
    let measure = |s: &str| ui.painter().layout_no_wrap(s.to_owned(), font.clone(), Color32::WHITE).size();
    let size = measure(template).max(measure(text));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let color = color.unwrap_or_else(|| ui.visuals().text_color());
    ui.painter().text(align.pos_in_rect(&rect), align, text, font, color);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, text));
    response
}

/// Type for what lies over the window, so that all of it fits: in the projector view smaller than around it.
pub fn sheet_type(ui: &mut Ui) {
    type_of_at_most(ui, SHEET_TYPE);
}

/// Size of type over the window, at most, in points.
pub const SHEET_TYPE: f32 = 18.0;

/// Type no larger than so many points.
pub fn type_of_at_most(ui: &mut Ui, largest: f32) {
    for font in ui.style_mut().text_styles.values_mut() {
        font.size = font.size.min(largest);
    }
    let spacing = ui.spacing_mut();
    let row = spacing.interact_size.y.min(1.6 * largest);
    spacing.interact_size.y = row;
    spacing.icon_width = spacing.icon_width.min(0.75 * row);
    spacing.icon_width_inner = spacing.icon_width_inner.min(0.4 * row);
}

/// How wide a text is in one line.
pub fn text_width(ui: &Ui, text: &str, font: &FontId) -> f32 {
    ui.painter().layout_no_wrap(text.to_owned(), font.clone(), Color32::WHITE).size().x
}

/// A quiet caption.
pub fn caption(ui: &mut Ui, text: impl Into<String>) -> Response {
    ui.label(RichText::new(text).text_style(TextStyle::Small).color(ui.visuals().weak_text_color()))
}

/// Title of a section.
pub fn title(ui: &mut Ui, text: &str) -> Response {
    ui.add_space(GRID);
    ui.label(RichText::new(text).family(medium()).strong())
}

/// Title of a section, with a remark at its right end: the first of `notes` that fits, or the last.
pub fn title_with_note(ui: &mut Ui, text: &str, notes: &[&str]) {
    ui.add_space(GRID);
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).family(medium()).strong());
        let (room, font) = (ui.available_width(), TextStyle::Small.resolve(ui.style()));
        let fits = |note: &&&str| text_width(ui, note, &font) <= room;
        let note = notes.iter().find(fits).or(notes.last()).copied().unwrap_or_default();
        let note = RichText::new(note).text_style(TextStyle::Small).color(ui.visuals().weak_text_color());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.add(Label::new(note).truncate()));
    });
}

/// A row of choices of which one is on, as wide as the column; `hint` explains one of them. Returns the one clicked.
pub fn segmented<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    current: T,
    choices: &[(T, &str)],
    enabled: bool,
    hint: &dyn Fn(&mut Ui, T),
) -> Option<T> {
    let mut clicked = None;
    let width = ui.available_width();
    let height = ui.spacing().interact_size.y;
    let font = TextStyle::Body.resolve(ui.style());
    let text_width = |s: &str| ui.painter().layout_no_wrap(s.to_owned(), font.clone(), Color32::WHITE).size().x;
    let natural: Vec<f32> = choices.iter().map(|(_, label)| text_width(label)).collect();
    let spare = (width - natural.iter().sum::<f32>()) / choices.len() as f32;
    let (outer, _) = ui.allocate_exact_size(vec2(width, height), Sense::hover());
    let track = ui.visuals().widgets.inactive.weak_bg_fill;
    ui.painter().rect_filled(outer, 4.0, if enabled { track } else { track.gamma_multiply(0.5) });
    let mut left = outer.left();
    for ((value, label), natural) in choices.iter().zip(natural) {
        let rect = Rect::from_min_size(pos2(left, outer.top()), vec2(natural + spare, height));
        left = rect.right();
        let sense = if enabled { Sense::click() } else { Sense::hover() };
        let response = ui.interact(rect, ui.scope_id().with((name, *label)), sense);
        let on = *value == current;
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::RadioButton, enabled, on, format!("{name}: {label}"))
        });
        let visuals = ui.style().interact_selectable(&response, on);
        if on || (enabled && (response.hovered() || response.has_focus())) {
            let fill = if on { ui.visuals().selection.bg_fill } else { visuals.weak_bg_fill };
            ui.painter().rect_filled(rect.shrink(2.0), 3.0, if enabled { fill } else { fill.gamma_multiply(0.5) });
        }
        focus_ring(ui, &response, rect);
        let color = if enabled { visuals.text_color() } else { ui.visuals().weak_text_color().gamma_multiply(0.7) };
        ui.painter().text(rect.center(), Align2::CENTER_CENTER, *label, font.clone(), color);
        if response.clicked() {
            clicked = Some(*value);
        }
        response.hint_ui(|ui| hint(ui, *value));
    }
    clicked
}

/// How a slider writes its value, and what it takes when something is typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Even steps, that many decimals.
    Linear(usize),
    /// Even ratios; the left end is 0 if the range starts there, next to it the given value.
    Log(f64),
}

/// A labelled slider over the width of its column, its number at the right end, its default marked
/// on the rail; a double click goes back there.
pub struct ParamSlider<'a> {
    /// Label and accessible name.
    pub name: &'a str,
    /// Width of the label; 0 hides it (the name stays for screen readers).
    pub label_width: f32,
    /// The value.
    pub value: f64,
    /// Where a double click goes.
    pub default: f64,
    /// The rail.
    pub range: RangeInclusive<f64>,
    /// Spread of values over the rail.
    pub scale: Scale,
    /// Widest number, for the width of its field.
    pub template: &'a str,
    /// Shown after the number.
    pub unit: &'a str,
    /// Colour of the filled part of the rail.
    pub accent: Option<Color32>,
    /// Shown instead of the number 0.
    pub zero_text: &'a str,
    /// What it is, in words and formulas: the hint.
    pub explain: &'a dyn Fn(&mut Ui),
}

/// What happened to a [`ParamSlider`].
pub struct SliderOutput {
    /// The new value.
    pub changed: Option<f64>,
    /// The mouse is over it, or it is being dragged.
    pub hovered: bool,
}

impl ParamSlider<'_> {
    /// Shows it in the rest of the row.
    pub fn show(self, ui: &mut Ui) -> SliderOutput {
        let Self { name, label_width, value, default, range, scale, template, unit, accent, zero_text, explain } = self;
        let mut new = value;
        let mut reset = false;
        let mut edited = false;
        let mut hovered = false;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 1.5 * GRID;
            if label_width > 0.0 {
                let (rect, response) =
                    ui.allocate_exact_size(vec2(label_width, ui.spacing().interact_size.y), Sense::click());
                let font = TextStyle::Body.resolve(ui.style());
                let at = Align2::LEFT_CENTER.pos_in_rect(&rect);
                ui.painter_at(rect).text(at, Align2::LEFT_CENTER, name, font, ui.visuals().text_color());
                reset |= response.double_clicked();
                hovered |= response.hovered();
            }
            let font = TextStyle::Body.resolve(ui.style());
            let measure = |s: &str| ui.painter().layout_no_wrap(s.to_owned(), font.clone(), Color32::WHITE).size().x;
            let field = measure(&format!("{template}{unit}")) + 4.0 * GRID;
            let rail = (ui.available_width() - field - ui.spacing().item_spacing.x).max(40.0);
            ui.spacing_mut().slider_width = rail;
            if let Some(accent) = accent {
                ui.visuals_mut().selection.bg_fill = accent;
            }
            // What lies beyond the rail, set by a key or a file, stays.
            let clamping = SliderClamping::Edits;
            let mut slider = Slider::new(&mut new, range.clone()).show_value(false).clamping(clamping);
            slider = match scale {
                Scale::Linear(decimals) => slider.max_decimals(decimals),
                Scale::Log(smallest) => slider.logarithmic(true).smallest_positive(smallest),
            };
            let response = slider.ui(ui).on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
            let response = response.accessible_name(name);
            focus_ring(ui, &response, response.rect);
            if value != default {
                mark_default(ui, response.rect, fraction(default, &range, scale));
            }
            reset |= response.contains_pointer()
                && ui.input(|i| i.pointer.button_double_clicked(egui::PointerButton::Primary));
            hovered |= response.hovered() || response.dragged();
            edited |= response.changed();
            if response.changed() {
                new = round_significant(new, scale);
            }
            response.hint_ui(|ui| explain(ui));

            let before_field = new;
            let speed = match scale {
                Scale::Linear(_) => (range.end() - range.start()) / f64::from(rail),
                Scale::Log(smallest) => new.abs().max(smallest) * 0.01,
            };
            let text = move |v: f64| {
                if v == 0.0 && !zero_text.is_empty() { zero_text.to_owned() } else { format_value(v, scale) }
            };
            let refused = Cell::new(None);
            let parse = number::parser(text(new), new, unit, number::Kind::Real, &refused);
            let field_value = egui::DragValue::new(&mut new)
                .range(range.clone())
                .clamp_existing_to_range(false)
                .speed(speed)
                .suffix(unit)
                .custom_formatter(move |v, _| text(v))
                .custom_parser(move |s| if s.trim() == zero_text { Some(0.0) } else { parse(s) })
                .update_while_editing(false);
            let field_height = ui.spacing().interact_size.y;
            let number = ui
                .allocate_ui_with_layout(vec2(field, field_height), Layout::right_to_left(Align::Center), |ui| {
                    ui.spacing_mut().button_padding.x = 1.5 * GRID;
                    ui.add_sized(vec2(field, field_height), field_value)
                })
                .inner
                .accessible_name(format!("{name} value"));
            if let Some(text) = refused.take() {
                number::refuse(ui.ctx(), &text);
            }
            hovered |= number.hovered() || number.dragged();
            edited |= number.changed();
            number.hint(format!("{name}: click to type, drag to change."));
            if new != before_field && !new.is_finite() {
                new = before_field;
            }
        });
        if reset {
            new = default;
        }
        // Controls round what they show; only a hand on them changes the value.
        let changed = (edited || reset) && new as f32 != value as f32;
        SliderOutput { changed: changed.then_some(new), hovered }
    }
}

/// A small notch on the rail where the default is.
fn mark_default(ui: &Ui, rect: Rect, fraction: f32) {
    // The handle is a circle of 1/2.5 of the height, and stays inside the rail at both ends.
    let radius = rect.height() / 2.5;
    let x = egui::lerp(rect.left() + radius..=rect.right() - radius, fraction);
    let y = rect.center().y;
    let stroke = Stroke::new(2.0, ui.visuals().weak_text_color());
    ui.painter().vline(x, y + 3.0..=y + radius, stroke);
}

fn fraction(value: f64, range: &RangeInclusive<f64>, scale: Scale) -> f32 {
    let (min, max) = (*range.start(), *range.end());
    let t = match scale {
        Scale::Linear(_) => (value - min) / (max - min),
        Scale::Log(smallest) => {
            let min = if min > 0.0 { min } else { smallest };
            if value <= min { 0.0 } else { (value / min).ln() / (max / min).ln() }
        }
    };
    t.clamp(0.0, 1.0) as f32
}

/// Three significant digits on logarithmic rails: finer steps are not what a hand means.
fn round_significant(value: f64, scale: Scale) -> f64 {
    match scale {
        Scale::Linear(decimals) => {
            let unit = 10f64.powi(decimals as i32);
            (value * unit).round() / unit
        }
        Scale::Log(_) if value == 0.0 => 0.0,
        Scale::Log(_) => {
            let unit = 10f64.powi(2 - value.abs().log10().floor() as i32);
            (value * unit).round() / unit
        }
    }
}

fn format_value(value: f64, scale: Scale) -> String {
    match scale {
        Scale::Linear(decimals) => format!("{value:.decimals$}"),
        Scale::Log(_) if value == 0.0 => "0".into(),
        Scale::Log(_) => {
            let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.decimals$}")
        }
    }
}

/// A label of fixed width in front of a control, on one row. True when the label is double-clicked: a reset.
pub fn labelled(ui: &mut Ui, label: &str, width: f32, add: impl FnOnce(&mut Ui)) -> bool {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
        let font = TextStyle::Body.resolve(ui.style());
        let at = Align2::LEFT_CENTER.pos_in_rect(&rect);
        ui.painter().text(at, Align2::LEFT_CENTER, label, font, ui.visuals().text_color());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, label));
        add(ui);
        response.double_clicked()
    })
    .inner
}

/// A button as wide as told.
pub fn wide_button(ui: &mut Ui, text: impl Into<WidgetText>, width: f32) -> Response {
    let height = ui.spacing().interact_size.y;
    ui.add_sized(vec2(width, height), egui::Button::new(text.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_people_write_them() {
        assert_eq!(format_value(0.02, Scale::Log(1e-3)), "0.0200");
        assert_eq!(format_value(0.9, Scale::Log(1e-3)), "0.900");
    }

    #[test]
    fn rounding_keeps_three_digits() {
        assert_eq!(round_significant(0.123_456, Scale::Log(1e-3)), 0.123);
        assert_eq!(round_significant(0.001_234_56, Scale::Log(1e-3)), 0.001_23);
        assert_eq!(round_significant(0.123_456, Scale::Linear(2)), 0.12);
    }
}
