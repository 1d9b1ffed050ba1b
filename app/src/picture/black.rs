//! Over a picture that is black or nearly so, the reason why.

use eframe::egui::{Align, Color32, Label, Rect, RichText, Ui, vec2};
use mislab_renderer::Frame;
use mislab_renderer::black::{is_black, why_black};

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
        let size = vec2((0.8 * rect.width()).min(520.0), 80.0);
        let text = RichText::new(reason).color(Color32::from_gray(210));
        let label = Label::new(text).wrap().halign(Align::Center).selectable(true);
        ui.put(Rect::from_center_size(rect.center(), size), label);
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
                self.reason = why_black(frame);
            }
        }
        self.seen = spp;
    }
}
