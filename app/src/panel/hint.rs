//! Hints under the mouse: beside what they explain, never over the formula, gone with the first key.

use eframe::egui::{self, Context, Event, Id, Rect, RectAlign, Response, Tooltip, Ui, WidgetText, vec2};

use crate::look::theme::GRID;

/// What holds for all hints of a pass.
#[derive(Clone, Copy, Debug)]
struct Rules {
    /// None at all in the projector view: they would lie over what a class looks at.
    on: bool,
    /// When a key was last pressed, in seconds.
    last_key: f64,
    /// The column that is being drawn; hints stand beside all of it.
    column: Option<Rect>,
    /// Where the formula was in the last pass, and where it is in this one.
    formula: [Option<Rect>; 2],
}

impl Rules {
    fn id() -> Id {
        Id::unique("rules of hints")
    }

    fn of(ctx: &Context) -> Self {
        let none = Self { on: true, last_key: f64::NEG_INFINITY, column: None, formula: [None; 2] };
        ctx.data(|data| data.get_temp(Self::id())).unwrap_or(none)
    }

    fn keep(self, ctx: &Context) {
        ctx.data_mut(|data| data.insert_temp(Self::id(), self));
    }
}

/// To be called at the beginning of each pass, before anything takes keys out of the input.
pub fn begin_pass(ctx: &Context, on: bool) {
    let Rules { mut last_key, formula: [_, formula], .. } = Rules::of(ctx);
    ctx.input(|input| {
        if input.events.iter().any(|event| matches!(event, Event::Key { pressed: true, .. } | Event::Text(_))) {
            last_key = input.time;
        }
    });
    Rules { on, last_key, column: None, formula: [formula, None] }.keep(ctx);
}

/// Hints keep clear of this place, where the formula is.
pub fn keep_clear(ctx: &Context, formula: Rect) {
    let rules = Rules::of(ctx);
    Rules { formula: [rules.formula[0], Some(formula)], ..rules }.keep(ctx);
}

/// Hints of what `add` draws stand beside the whole of `column`.
pub fn beside<R>(ui: &mut Ui, column: Rect, add: impl FnOnce(&mut Ui) -> R) -> R {
    let before = Rules::of(ui.ctx());
    Rules { column: Some(column), ..before }.keep(ui.ctx());
    let result = add(ui);
    before.keep(ui.ctx());
    result
}

/// Explains a control while the mouse rests on it.
pub trait Hint {
    /// In words.
    fn hint(self, words: impl Into<WidgetText>) -> Self;
    /// In whatever `add` draws.
    fn hint_ui(self, add: impl FnOnce(&mut Ui)) -> Self;
}

impl Hint for Response {
    fn hint(self, words: impl Into<WidgetText>) -> Self {
        self.hint_ui(|ui| {
            ui.label(words);
        })
    }

    fn hint_ui(self, add: impl FnOnce(&mut Ui)) -> Self {
        let rules = Rules::of(&self.ctx);
        let (now, rest) = self.ctx.input(|i| (i.time, f64::from(i.pointer.time_since_last_movement())));
        // A key since the mouse came to rest: eyes are elsewhere.
        if !rules.on || now - rules.last_key < rest {
            return self;
        }
        let mut tooltip = if self.enabled() { Tooltip::for_enabled(&self) } else { Tooltip::for_disabled(&self) };
        let (mut anchor, align) = place(self.rect, rules.column, self.ctx.content_rect());
        let widest = self.ctx.global_style().spacing.tooltip_width + 8.0 * GRID;
        if let Some(formula) = rules.formula[0].filter(|_| align == RectAlign::BOTTOM_START) {
            // Aside, if it would reach under the bar to where the formula is.
            anchor = anchor.translate(vec2((formula.left() - widest - anchor.left()).min(0.0), 0.0));
        }
        tooltip.popup = tooltip.popup.anchor(anchor).align(align).gap(8.0);
        tooltip.show(add);
        self
    }
}

/// Beside a column towards the middle of the window, under what is at its top, over what is at its bottom.
fn place(control: Rect, column: Option<Rect>, window: Rect) -> (Rect, RectAlign) {
    let Some(column) = column else {
        let align = if control.center().y > window.center().y { RectAlign::TOP_START } else { RectAlign::BOTTOM_START };
        return (control, align);
    };
    let anchor = Rect::from_x_y_ranges(column.x_range(), control.y_range());
    let left = column.center().x < window.center().x;
    (anchor, if left { RectAlign::RIGHT_START } else { RectAlign::LEFT_START })
}

/// A hint of several lines: what it is, then remarks in small type.
pub fn lines(ui: &mut Ui, what: &str, remarks: &[&str]) {
    ui.label(what);
    for remark in remarks.iter().filter(|remark| !remark.is_empty()) {
        let text = egui::RichText::new(*remark).text_style(egui::TextStyle::Small);
        ui.label(text.color(ui.visuals().weak_text_color()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{pos2, vec2};

    #[test]
    fn hints_stand_towards_the_picture() {
        let window = Rect::from_min_size(pos2(0.0, 0.0), vec2(1280.0, 720.0));
        let rect = |x, y| Rect::from_min_size(pos2(x, y), vec2(100.0, 24.0));
        let left = Rect::from_min_size(pos2(0.0, 52.0), vec2(320.0, 600.0));
        let right = left.translate(vec2(960.0, 0.0));
        assert_eq!(place(rect(20.0, 300.0), Some(left), window).1, RectAlign::RIGHT_START);
        let (anchor, align) = place(rect(990.0, 300.0), Some(right), window);
        assert_eq!((anchor.left(), align), (960.0, RectAlign::LEFT_START));
        assert_eq!(place(rect(20.0, 10.0), None, window).1, RectAlign::BOTTOM_START);
        assert_eq!(place(rect(20.0, 690.0), None, window).1, RectAlign::TOP_START);
    }
}
