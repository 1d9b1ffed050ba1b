//! The pixel under the cursor: its place and its numbers.

use std::sync::Arc;

use eframe::egui::{self, Align2, Color32, Rect, Role, Sense, TextStyle, Ui, vec2};
use mislab_renderer::blind::Dark;
use mislab_renderer::{Channel, Layer};

use crate::look::layer::LayerLook;
use crate::look::theme::GRID;
use crate::picture::content::Content;
use crate::picture::planes::{BLIND, UNHIT, UNLIT};
use crate::picture::variance;
use crate::state::view::VarianceUnit;

/// A pixel of what is shown.
pub struct Pixel<'a> {
    /// What is shown.
    pub content: &'a Content,
    /// Column and row in the full image.
    pub at: [u32; 2],
    /// What its variance is counted in.
    pub unit: VarianceUnit,
    /// For each pixel of the full image what it is where it is black, if that is known.
    pub dark: Option<&'a Arc<Vec<Dark>>>,
}

impl Pixel<'_> {
    /// Place and values, on a plate in the lower right corner of the viewport.
    pub fn overlay(&self, ui: &Ui, viewport: Rect, layer: Layer) {
        let text = self.text(layer);
        let font = TextStyle::Body.resolve(ui.style());
        let galley = ui.painter().layout_no_wrap(text.clone(), font.clone(), ui.visuals().text_color());
        // As wide as usual values are, so that the plate stands still under a moving cursor.
        let usual = if LayerLook::of(layer).is_colour() { "R 0.0000   G 0.0000   B 0.0000" } else { "x 0000   y 0000" };
        let usual = ui.painter().layout_no_wrap(usual.into(), font, Color32::WHITE).size();
        let (padding, margin) = (vec2(4.0 * GRID, 3.0 * GRID), vec2(2.0 * GRID, 2.0 * GRID));
        let room = viewport.width() - 2.0 * margin.x - padding.x;
        let size = galley.size().max(vec2(usual.x.min(room), usual.y)) + padding;
        // The legend has the lower left corner; in a narrow viewport the two would meet.
        let corner = if viewport.width() > 600.0 { Align2::RIGHT_BOTTOM } else { Align2::RIGHT_TOP };
        let plate = corner.align_size_within_rect(size, viewport.shrink2(margin));
        let painter = ui.painter_at(viewport);
        painter.rect_filled(plate, 4.0, ui.visuals().panel_fill.gamma_multiply(0.92));
        painter.galley(plate.min + vec2(2.0 * GRID, 1.5 * GRID), galley, ui.visuals().text_color());
        let response = ui.interact(plate, ui.scope_id().with("pixel"), Sense::empty());
        response.widget_info(|| egui::WidgetInfo::labeled(Role::Label, true, format!("Pixel: {text}")));
    }

    /// Place and values in a layer.
    fn text(&self, layer: Layer) -> String {
        let names = LayerLook::of(layer).values;
        let values = self.values(layer);
        let words = match values.as_slice() {
            [] => String::new(),
            // Equal to the eye: the three are one number.
            [first, rest @ ..] if !rest.is_empty() && rest.iter().all(|v| value_text(*v) == value_text(*first)) => {
                format!("{}  {}", names.join(" = "), value_text(*first))
            }
            all => {
                let named = names.iter().zip(all).map(|(name, v)| format!("{name} {}", value_text(*v)));
                named.collect::<Vec<_>>().join("   ")
            }
        };
        let [x, y] = self.at;
        format!("x {x}   y {y}\n{words}")
    }

    /// The number of a layer that has one for each pixel.
    pub fn single(&self, layer: Layer) -> Option<f32> {
        match self.values(layer).as_slice() {
            [value] => Some(*value),
            _ => None,
        }
    }

    fn dark(&self) -> Dark {
        let [x, y] = self.at.map(|i| i as usize);
        let at = y * self.content.size()[0] as usize + x;
        self.dark.and_then(|dark| dark.get(at)).copied().unwrap_or(Dark::Empty)
    }

    /// The numbers of a layer as they are shown: see [`Planes::shown`](crate::picture::planes::Planes::shown).
    fn values(&self, layer: Layer) -> Vec<f32> {
        let values = self.numbers(layer);
        let colour = layer.channels().len() > 1;
        let black = values.iter().all(|value| *value == 0.0);
        match self.dark() {
            Dark::Blind if !colour || black => vec![BLIND; values.len()],
            Dark::Unhit if colour && black => vec![UNHIT; values.len()],
            Dark::Empty if !colour && values.iter().all(|value| value.is_nan()) => vec![UNLIT; values.len()],
            Dark::Blind | Dark::Unhit | Dark::Empty => values,
        }
    }

    fn numbers(&self, layer: Layer) -> Vec<f32> {
        match (layer, self.content) {
            (Layer::Variance, Content::Frame(frame)) => {
                let numbers = variance::CHANNELS.map(|channel| self.value(channel));
                vec![variance::in_unit(self.unit, variance::cost(self.unit, frame), numbers)]
            }
            (Layer::Variance, Content::File(_)) => vec![self.value(Channel::VarianceY)],
            (
                Layer::Picture
                | Layer::Light
                | Layer::Bsdf
                | Layer::WeightLight
                | Layer::WeightBsdf
                | Layer::ShareLight,
                Content::Frame(_) | Content::File(_),
            ) => layer.channels().iter().map(|channel| self.value(*channel)).collect(),
        }
    }

    /// All channels, for the clipboard; in words where a layer is marked.
    pub fn table(&self) -> String {
        let marked = |channel: Channel| {
            self.dark() == Dark::Blind && Layer::ALL.iter().any(|layer| layer.channels() == [channel])
        };
        let values = Channel::ALL.iter().filter_map(|c| {
            let value = self.content.value(self.at, *c)?;
            let value = if marked(*c) { NEVER.to_owned() } else { value.to_string() };
            Some(format!("{}\t{value}", c.exr_name()))
        });
        let [x, y] = self.at;
        format!("x\t{x}\ny\t{y}\n{}\n", values.collect::<Vec<_>>().join("\n"))
    }

    fn value(&self, channel: Channel) -> f32 {
        self.content.value(self.at, channel).unwrap_or(f32::NAN)
    }
}

/// What a pixel has instead of a number where no sample has carried light.
pub const NOTHING_YET: &str = "nothing hit yet";
/// What it has where none ever will.
pub const NEVER: &str = "cannot be hit";
/// What it has where there is nothing to hit: a lamp itself, nothing at all, or what no light reaches.
pub const NO_LIGHT: &str = "no light";

/// A number of a pixel as people read it.
pub fn value_text(value: f32) -> String {
    if value.is_nan() || value == UNHIT {
        NOTHING_YET.into()
    } else if value == BLIND {
        NEVER.into()
    } else if value == UNLIT {
        NO_LIGHT.into()
    } else if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) {
        format!("{value:.2e}")
    } else {
        format!("{value:.4}")
    }
}
