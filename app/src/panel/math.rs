//! Just enough typesetting for a formula: rows, subscripts, fractions, colour.

use std::sync::Arc;

use eframe::egui::{self, Color32, FontId, Galley, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

/// A piece of a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum Math {
    /// Characters in a colour; `None` is the colour of text.
    Text(String, Option<Color32>),
    /// One after the other.
    Row(Vec<Math>),
    /// Base and index.
    Sub(Box<Math>, Box<Math>),
    /// Numerator over denominator.
    Frac(Box<Math>, Box<Math>),
    /// A gap, in ems.
    Gap(f32),
    /// The same in smaller type.
    Small(Box<Math>),
}

/// Size of type of a formula among lines of text: a little larger, for its fractions.
pub fn size_in_text(ui: &Ui) -> f32 {
    1.06 * egui::TextStyle::Body.resolve(ui.style()).size
}

/// Plain characters.
pub fn text(s: impl Into<String>) -> Math {
    Math::Text(s.into(), None)
}

/// `base` with `index` below, both in `color`.
pub fn sub(base: &str, index: &str, color: Color32) -> Math {
    let ink = |s: &str| Math::Text(s.into(), Some(color)).into();
    Math::Sub(ink(base), ink(index))
}

/// A fraction.
pub fn frac(numerator: Math, denominator: Math) -> Math {
    Math::Frac(numerator.into(), denominator.into())
}

/// A row.
pub fn row(parts: impl IntoIterator<Item = Math>) -> Math {
    Math::Row(parts.into_iter().collect())
}

/// A formula with every piece in its place, relative to the left end of its axis (the line that
/// fraction bars lie on).
pub struct Laid {
    width: f32,
    above: f32,
    below: f32,
    ink: Vec<(Vec2, Ink)>,
}

enum Ink {
    Text(Arc<Galley>, Color32),
    Bar(f32, Color32),
}

impl Math {
    /// The formula in one line of characters, for screen readers.
    pub fn plain(&self) -> String {
        match self {
            Self::Text(s, _) => s.clone(),
            Self::Row(parts) => parts.iter().map(Self::plain).collect(),
            Self::Sub(base, index) => format!("{}_{}", base.plain(), index.plain()),
            Self::Frac(n, d) => format!("({}) / ({})", n.plain().trim(), d.plain().trim()),
            Self::Gap(_) => " ".into(),
            Self::Small(inner) => inner.plain(),
        }
    }

    /// Shows it as a widget in type of that size, smaller if the column is narrower.
    pub fn show(&self, ui: &mut Ui, size: f32) -> egui::Response {
        let color = ui.visuals().text_color();
        let laid = self.fitted(ui.painter(), size, ui.available_width(), color);
        let (rect, response) = ui.allocate_exact_size(laid.size(), Sense::hover());
        laid.paint(ui.painter(), rect.min);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, self.plain()));
        response
    }

    /// Lays it out with type of that size, smaller if it would be wider than `width`.
    pub fn fitted(&self, painter: &Painter, size: f32, width: f32, color: Color32) -> Laid {
        let laid = self.layout(painter, size, color);
        let fit = width / laid.size().x;
        if fit < 1.0 { self.layout(painter, size * fit, color) } else { laid }
    }

    /// Lays it out with type of that size.
    pub fn layout(&self, painter: &Painter, size: f32, color: Color32) -> Laid {
        match self {
            Self::Text(s, own) => {
                let ink = own.unwrap_or(color);
                let galley = painter.layout_no_wrap(s.clone(), FontId::proportional(size), ink);
                let half = 0.5 * galley.size().y;
                let width = galley.size().x;
                Laid { width, above: half, below: half, ink: vec![(vec2(0.0, -half), Ink::Text(galley, ink))] }
            }
            Self::Gap(ems) => Laid { width: ems * size, above: 0.0, below: 0.0, ink: vec![] },
            Self::Small(inner) => inner.layout(painter, 0.8 * size, color),
            Self::Row(parts) => {
                let mut whole = Laid { width: 0.0, above: 0.0, below: 0.0, ink: vec![] };
                for part in parts {
                    let at = vec2(whole.width, 0.0);
                    whole.take(part.layout(painter, size, color), at, true);
                }
                whole
            }
            Self::Sub(base, index) => {
                let mut whole = base.layout(painter, size, color);
                let at = vec2(whole.width + 0.5, 0.32 * size);
                whole.take(index.layout(painter, 0.68 * size, color), at, true);
                whole
            }
            Self::Frac(numerator, denominator) => {
                let over = numerator.layout(painter, 0.92 * size, color);
                let under = denominator.layout(painter, 0.92 * size, color);
                let pad = 0.15 * size;
                let width = over.width.max(under.width) + 2.0 * pad;
                let mut whole = Laid { width, above: 0.0, below: 0.0, ink: vec![(Vec2::ZERO, Ink::Bar(width, color))] };
                let up = vec2(0.5 * (width - over.width), -over.below - 1.0);
                whole.take(over, up, false);
                let down = vec2(0.5 * (width - under.width), under.above + 1.0);
                whole.take(under, down, false);
                // A breath on either side, so that neighbouring bars do not touch.
                for (at, _) in &mut whole.ink {
                    at.x += 0.08 * size;
                }
                whole.width += 0.16 * size;
                whole
            }
        }
    }
}

impl Laid {
    fn take(&mut self, part: Self, at: Vec2, advance: bool) {
        self.above = self.above.max(part.above - at.y);
        self.below = self.below.max(part.below + at.y);
        if advance {
            self.width = at.x + part.width;
        }
        self.ink.extend(part.ink.into_iter().map(|(offset, ink)| (offset + at, ink)));
    }

    /// Width and height.
    pub fn size(&self) -> Vec2 {
        vec2(self.width, self.above + self.below)
    }

    /// Paints it with its top left corner there.
    pub fn paint(self, painter: &Painter, top_left: Pos2) -> Rect {
        let rect = Rect::from_min_size(top_left, self.size());
        let origin = pos2(top_left.x, top_left.y + self.above);
        for (offset, ink) in self.ink {
            match ink {
                Ink::Text(galley, color) => {
                    painter.galley(origin + offset, galley, color);
                }
                Ink::Bar(width, color) => {
                    let from = origin + offset;
                    let stroke = Stroke::new(1.5, color);
                    painter.add(Shape::line_segment([from, from + vec2(width, 0.0)], stroke));
                }
            }
        }
        rect
    }
}
