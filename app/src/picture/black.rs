//! Over a picture that is black or nearly so, the reason why.

use eframe::egui::{self, Align, Color32, Label, Layout, Rect, RichText, Ui, UiBuilder, vec2};
use mislab_renderer::Frame;
use mislab_renderer::black::{is_black, why_black};

use crate::look::theme::GRID;

/// What is known about the picture on screen.
#[derive(Default)]
pub struct Black {
    /// Generation and samples of the frame that was asked why.
    asked_at: Option<(u64, u32)>,
    /// Samples of the last frame that was looked at.
    seen: u32,
    reason: Option<String>,
}

impl Black {
    /// Writes the reason over `rect`, if there is one.
    pub fn overlay(&mut self, ui: &mut Ui, rect: Rect, frame: &Frame) {
        self.look_at(frame);
        let Some(reason) = &self.reason else { return };
        let width = (0.8 * rect.width()).min(480.0);
        let place = Rect::from_center_size(rect.center(), vec2(width, 0.0));
        let builder = UiBuilder::new().max_rect(place).layout(Layout::top_down(Align::Center));
        ui.scope_builder(builder, |ui| {
            let frame =
                egui::Frame::new().fill(Color32::from_black_alpha(170)).corner_radius(4).inner_margin(2.0 * GRID);
            frame.show(ui, |ui| {
                // Not to be selected: the mouse belongs to the picture.
                ui.add(Label::new(RichText::new(reason).color(Color32::from_gray(220))).wrap().selectable(false));
            });
        });
    }

    /// A picture that is not black never becomes so. One that is may light up at any sample; why it is so is asked anew
    /// each time that it has twice as many.
    fn look_at(&mut self, frame: &Frame) {
        let (generation, spp) = (frame.generation(), frame.spp());
        let asked_at = self.asked_at.filter(|asked| asked.0 == generation).map(|asked| asked.1);
        match asked_at {
            Some(_) if self.reason.is_none() => {}
            Some(asked) if spp < 2 * asked => {
                if spp > self.seen && !is_black(frame) {
                    self.reason = None;
                }
            }
            Some(_) | None => {
                self.asked_at = Some((generation, spp));
                self.reason = why_black(frame).map(|reason| sentence(&reason));
            }
        }
        self.seen = spp;
    }
}

/// With a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let (first, rest) = text.split_at(text.chars().next().map_or(0, char::len_utf8));
    format!("{}{rest}.", first.to_uppercase())
}
