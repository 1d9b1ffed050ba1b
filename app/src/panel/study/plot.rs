//! A plot with logarithmic axes: where a value is on screen, decades and their labels, bands and lines.

use eframe::egui::{Align2, Color32, Mesh, Painter, Pos2, Rect, Shape, Stroke, TextStyle, Ui, pos2, vec2};

use crate::look::theme::GRID;

/// Axes over a rectangle; ends as powers of ten.
pub struct Axes {
    /// Where lines are drawn.
    pub rect: Rect,
    /// Decimal logarithms of the ends of the horizontal axis.
    pub x: [f64; 2],
    /// The same of the vertical one.
    pub y: [f64; 2],
}

impl Axes {
    /// Where a point of logarithms is.
    pub fn at(&self, [x, y]: [f64; 2]) -> Pos2 {
        let share = |v: f64, [low, high]: [f64; 2]| ((v - low) / (high - low)) as f32;
        let Rect { min, max } = self.rect;
        pos2(min.x + share(x, self.x) * (max.x - min.x), max.y - share(y, self.y) * (max.y - min.y))
    }

    /// The logarithms of a point on screen.
    pub fn logs(&self, at: Pos2) -> [f64; 2] {
        let Rect { min, max } = self.rect;
        let between = |share: f32, [low, high]: [f64; 2]| low + f64::from(share) * (high - low);
        [between((at.x - min.x) / (max.x - min.x), self.x), between((max.y - at.y) / (max.y - min.y), self.y)]
    }

    /// Decades with their labels, thin lines at 2 and 5 where there are few of them, and what the axes are.
    pub fn grid_ui(&self, ui: &Ui, names: [&str; 2]) {
        let painter = ui.painter();
        let font = TextStyle::Small.resolve(ui.style());
        let (weak, line) = (ui.visuals().weak_text_color(), ui.visuals().widgets.noninteractive.bg_stroke.color);
        painter.rect_filled(self.rect, 0.0, ui.visuals().extreme_bg_color);
        for (axis, ends) in [self.x, self.y].into_iter().enumerate() {
            // As many labels as have room.
            let room =
                if axis == 0 { self.rect.width() / (3.0 * font.size) } else { self.rect.height() / (1.5 * font.size) };
            let step = ((ends[1] - ends[0]) / f64::from(room.clamp(1.0, 6.0))).ceil().max(1.0) as i32;
            for power in ends[0].floor() as i32..=ends[1].ceil() as i32 {
                let few = ends[1] - ends[0] < 2.5;
                for digit in if few { &[1.0, 2.0, 5.0][..] } else { &[1.0][..] } {
                    let log = f64::from(power) + f64::log10(*digit);
                    if log < ends[0] - 1e-9 || log > ends[1] + 1e-9 {
                        continue;
                    }
                    let stroke = Stroke::new(if *digit == 1.0 { 1.0 } else { 0.5 }, line);
                    let text = plain(digit * 10_f64.powi(power));
                    let labelled = power.rem_euclid(step) == 0;
                    if axis == 0 {
                        let x = self.at([log, self.y[0]]).x;
                        painter.vline(x, self.rect.y_range(), stroke);
                        if labelled {
                            let at = pos2(x, self.rect.bottom() + 0.5 * GRID);
                            painter.text(at, Align2::CENTER_TOP, text, font.clone(), weak);
                        }
                    } else {
                        let y = self.at([self.x[0], log]).y;
                        painter.hline(self.rect.x_range(), y, stroke);
                        if labelled {
                            let at = pos2(self.rect.left() - GRID, y);
                            painter.text(at, Align2::RIGHT_CENTER, text, font.clone(), weak);
                        }
                    }
                }
            }
        }
        // Outside the plot, where no curve goes.
        let [x, y] = names;
        let ink = ui.visuals().text_color();
        let under =
            pos2(self.rect.center().x, self.rect.bottom() + 0.5 * GRID + ui.text_style_height(&TextStyle::Small));
        painter.text(under, Align2::CENTER_TOP, x, font.clone(), ink);
        painter.text(self.rect.left_top() - vec2(0.0, 0.5 * GRID), Align2::LEFT_BOTTOM, y, font, ink);
    }

    /// The axes within `room`, which holds their numbers and names, too; `widest` is so of the numbers at the left.
    pub fn within(ui: &Ui, room: Rect, widest: &str, [x, y]: [[f64; 2]; 2]) -> Self {
        let font = TextStyle::Small.resolve(ui.style());
        let line = ui.text_style_height(&TextStyle::Small);
        let left = ui.painter().layout_no_wrap(widest.to_owned(), font, Color32::WHITE).size().x + 2.0 * GRID;
        let (over, under) = (vec2(left, line + 0.5 * GRID), vec2(2.0 * GRID, 2.0 * line + 0.5 * GRID));
        Self { rect: Rect::from_min_max(room.min + over, room.max - under), x, y }
    }

    /// The area between two lines over the same x: pairs of a lower and an upper end.
    pub fn band(&self, painter: &Painter, over: &[(f64, [f64; 2])], fill: Color32) {
        let mut mesh = Mesh::default();
        for (x, [low, high]) in over {
            for y in [low, high] {
                mesh.colored_vertex(self.at([*x, *y]), fill);
            }
        }
        for i in 1..over.len() as u32 {
            let [a, b, c, d] = [2 * i - 2, 2 * i - 1, 2 * i, 2 * i + 1];
            mesh.add_triangle(a, b, c);
            mesh.add_triangle(b, c, d);
        }
        painter.add(Shape::mesh(mesh));
    }

    /// A line through points of logarithms.
    pub fn line(&self, painter: &Painter, points: &[[f64; 2]], stroke: Stroke) {
        painter.add(Shape::line(points.iter().map(|point| self.at(*point)).collect(), stroke));
    }

    /// A straight dashed line from one side to the other through a point, of that slope.
    pub fn guide(&self, painter: &Painter, through: [f64; 2], slope: f64, stroke: Stroke) {
        let end = |x: f64| self.at([x, through[1] + slope * (x - through[0])]);
        painter.extend(Shape::dashed_line(&[end(self.x[0]), end(self.x[1])], stroke, 1.5 * GRID, GRID));
    }
}

/// A power of ten, or a few of it, as people write it.
pub fn plain(value: f64) -> String {
    match value {
        v if v >= 1e6 => format!("{:.0} M", v / 1e6),
        v if v >= 1e4 => format!("{:.0} k", v / 1e3),
        v if v >= 1.0 => format!("{v:.0}"),
        v if v >= 0.99e-4 => format!("{v:.*}", (-v.log10()).ceil() as usize),
        v => format!("{v:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        let axes =
            Axes { rect: Rect::from_min_max(pos2(10.0, 20.0), pos2(110.0, 220.0)), x: [0.0, 2.0], y: [-3.0, 1.0] };
        assert_eq!(axes.at([0.0, -3.0]), pos2(10.0, 220.0));
        assert_eq!(axes.at([2.0, 1.0]), pos2(110.0, 20.0));
        let [x, y] = axes.logs(axes.at([0.7, -1.2]));
        assert!((x - 0.7).abs() < 1e-5 && (y + 1.2).abs() < 1e-5);
    }

    #[test]
    fn labels_are_short() {
        let written = [1e7, 2e4, 100.0, 0.5, 0.02, 0.0001, 1e-7].map(plain);
        assert_eq!(written, ["10 M", "20 k", "100", "0.5", "0.02", "0.0001", "1e-7"]);
    }
}
