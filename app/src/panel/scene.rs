//! The scene's handles: roughness of every plate, size and switch of every light.

use eframe::egui::{self, Color32, CornerRadius, Rect, Sense, Stroke, TextStyle, Ui, vec2};
use mislab_renderer::Strategy;

use crate::look::theme::{GRID, strategy_fill};
use crate::panel::explain;
use crate::panel::hint::Hint as _;
use crate::panel::widgets::{ParamSlider, Scale, caption, title_with_note};
use crate::picture::picking::Target;
use crate::picture::swatch::Swatches;
use crate::state::command::Command;
use crate::state::document::Document;
use crate::state::edit::Edit;

/// Below this GGX width a surface is a mirror; the left end of the rail is 0 itself.
const SMALLEST_ALPHA: f64 = 1e-3;

/// The panel. `hovered` is what the mouse is on in the picture; returns what it is on here.
pub fn scene_ui(
    ui: &mut Ui,
    document: &Document,
    swatches: &Swatches,
    hovered: Option<Target>,
    out: &mut Vec<Command>,
) -> Option<Target> {
    let mut here = None;
    let scene = &document.scene;
    title_with_note(ui, "Roughness", &["GGX width \u{3b1}"]);
    let mut any = false;
    for (index, material) in scene.materials.iter().enumerate() {
        let Some(alpha) = material.bsdf.alpha() else { continue };
        any = true;
        let target = Target::Material(index);
        let on = row(ui, hovered == Some(target), |ui| {
            swatch(ui, swatches, target);
            let output = ParamSlider {
                name: &material.name,
                label_width: label_width(ui, scene.materials.iter().map(|m| m.name.as_str())),
                value: f64::from(alpha),
                default: f64::from(document.original_alpha(index).unwrap_or(alpha)),
                range: 0.0..=1.0,
                scale: Scale::Log(SMALLEST_ALPHA),
                template: "0.0000",
                unit: "",
                accent: None,
                zero_text: "mirror",
                explain: &explain::roughness,
            }
            .show(ui);
            if let Some(value) = output.changed {
                out.push(Edit::SetAlpha(index, value as f32).into());
            }
            output.hovered
        });
        here = on.then_some(target).or(here);
    }
    if !any {
        caption(ui, "No material of this scene has a roughness.");
    }

    title_with_note(ui, "Lights", &["radius, at the same power"]);
    let radii: Vec<f32> =
        scene.light_shapes().filter_map(|shape| Document::radius(&document.opened.scene, shape)).collect();
    let smallest = radii.iter().copied().fold(f32::INFINITY, f32::min);
    let largest = radii.iter().copied().fold(0.0, f32::max);
    let mut any = false;
    for shape in scene.light_shapes() {
        let Some(light) = &scene.shapes[shape].light else { continue };
        any = true;
        let target = Target::Light(shape);
        let on = row(ui, hovered == Some(target), |ui| {
            let mut lit = light.on;
            let switch = ui
                .add(egui::Checkbox::without_text(&mut lit))
                .accessible_name(format!("{} on", light.name))
                .hint("On or off: only lights that are on are drawn from.");
            if switch.changed() {
                out.push(Edit::SetLightOn(shape, lit).into());
            }
            let names = scene.light_shapes().filter_map(|s| scene.shapes[s].light.as_ref()).map(|l| l.name.as_str());
            let label_width = label_width(ui, names);
            let radius = Document::radius(scene, shape);
            dot(ui, radius.map_or(0.5, |r| relative_size(r, smallest, largest)), light.on);
            let Some(radius) = radius else {
                ui.label(&light.name);
                return switch.hovered();
            };
            let range = f64::from(0.25 * smallest)..=f64::from(2.0 * largest);
            let output = ParamSlider {
                name: &light.name,
                label_width,
                value: f64::from(radius),
                default: f64::from(Document::radius(&document.opened.scene, shape).unwrap_or(radius)),
                range,
                scale: Scale::Log(1e-6),
                template: "0.0000",
                unit: "",
                accent: Some(strategy_fill(Strategy::Light).0),
                zero_text: "",
                explain: &explain::radius,
            }
            .show(ui);
            if let Some(value) = output.changed {
                out.push(Edit::SetLightRadius(shape, value as f32).into());
            }
            output.hovered || switch.hovered()
        });
        here = on.then_some(target).or(here);
    }
    if !any {
        caption(ui, "This scene has no light: every picture of it is black.");
    }
    ui.add_space(GRID);
    let reset = ui.add_enabled(document.is_edited(), egui::Button::new("Reset to the file"));
    if reset.hint("Every setting and every edit of the scene. Double-click a slider to reset it alone.").clicked() {
        out.push(Edit::ResetScene.into());
    }
    here
}

/// A row that lights up when its thing is under the mouse in the picture. Returns whether the mouse is on it.
fn row(ui: &mut Ui, lit: bool, add: impl FnOnce(&mut Ui) -> bool) -> bool {
    let background = ui.painter().add(egui::Shape::Noop);
    let inner = ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 1.5 * GRID;
        add(ui)
    });
    if lit {
        let rect = inner.response.rect.expand2(vec2(GRID, 1.0));
        let fill = ui.visuals().widgets.hovered.weak_bg_fill;
        ui.painter().set(background, egui::epaint::RectShape::filled(rect, 4.0, fill));
    }
    inner.inner
}

fn swatch(ui: &mut Ui, swatches: &Swatches, target: Target) {
    let size = vec2(48.0, ui.spacing().interact_size.y);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    match swatches.get(target) {
        Some(texture) => {
            let uv = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            let mut mesh = egui::epaint::RectShape::filled(rect, CornerRadius::same(3), Color32::WHITE);
            mesh = mesh.with_texture(texture.id(), uv);
            ui.painter().add(mesh);
        }
        None => {
            ui.painter().rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        }
    }
    // White plates on white paper have an edge too.
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.6));
    ui.painter().rect_stroke(rect, 3.0, edge, egui::StrokeKind::Inside);
}

/// A dot of the light's size, filled while it is on.
fn dot(ui: &mut Ui, size: f32, on: bool) {
    let (rect, _) = ui.allocate_exact_size(vec2(20.0, ui.spacing().interact_size.y), Sense::hover());
    let radius = egui::lerp(2.0..=9.5, size);
    let color = ui.visuals().text_color();
    if on {
        ui.painter().circle_filled(rect.center(), radius, color);
    } else {
        ui.painter().circle_stroke(rect.center(), radius, Stroke::new(1.5, ui.visuals().weak_text_color()));
    }
}

/// 0 for the smallest light there was, 1 for the largest, on a logarithmic scale.
fn relative_size(radius: f32, smallest: f32, largest: f32) -> f32 {
    if largest <= smallest {
        return 0.5;
    }
    ((radius / smallest).ln() / (largest / smallest).ln()).clamp(-0.3, 1.1)
}

fn label_width<'a>(ui: &Ui, names: impl Iterator<Item = &'a str>) -> f32 {
    let font = TextStyle::Body.resolve(ui.style());
    let width = |name: &str| ui.painter().layout_no_wrap(name.to_owned(), font.clone(), Color32::WHITE).size().x;
    // Long names are cut (the row tells the rest on hover); sliders of one group start at one place.
    let widest = names.map(width).fold(0.0, f32::max);
    widest.clamp(44.0, 84.0)
}
