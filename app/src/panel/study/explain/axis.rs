//! The plane of a plot whose axes are even or logarithmic: lines, numbers, names.

use eframe::egui::{Align2, Stroke, TextStyle, Ui, pos2};

use crate::look::theme::GRID;
use crate::panel::study::plot::{Axes, plain};

/// How values are spread along the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spread {
    /// By their decimal logarithms; the ends of the axis are such.
    Log,
    /// Even, without numbers: each line over its own largest value.
    Relative,
}

/// Draws ground, lines and numbers of both axes. The horizontal one is even; its numbers stand under `bottom`.
pub fn plane_ui(ui: &Ui, axes: &Axes, spread: Spread, bottom: f32, unit: &str) {
    let painter = ui.painter();
    let font = TextStyle::Small.resolve(ui.style());
    let (weak, line) = (ui.visuals().weak_text_color(), ui.visuals().widgets.noninteractive.bg_stroke.color);
    painter.rect_filled(axes.rect, 0.0, ui.visuals().extreme_bg_color);
    let stroke = Stroke::new(1.0, line);
    for (value, text) in ticks(axes.x) {
        let x = axes.at([value, axes.y[0]]).x;
        painter.vline(x, axes.rect.top()..=bottom, stroke);
        painter.text(pos2(x, bottom + 0.5 * GRID), Align2::CENTER_TOP, text + unit, font.clone(), weak);
    }
    let rows: Vec<(f64, String)> = match spread {
        Spread::Log => {
            let powers = axes.y[0].ceil() as i32..=axes.y[1].floor() as i32;
            // Six numbers, or as many as there is room for.
            let most = (axes.rect.height() / (1.3 * font.size)).clamp(1.0, 6.0);
            let step = ((axes.y[1] - axes.y[0]) / f64::from(most)).ceil().max(1.0) as i32;
            powers
                .filter(|power| power.rem_euclid(step) == 0)
                .map(|power| (f64::from(power), plain(10f64.powi(power))))
                .collect()
        }
        Spread::Relative => vec![(0.0, "0".to_owned()), (1.0, "max".to_owned())],
    };
    for (value, text) in rows {
        let y = axes.at([axes.x[0], value]).y;
        painter.hline(axes.rect.x_range(), y, stroke);
        painter.text(pos2(axes.rect.left() - GRID, y), Align2::RIGHT_CENTER, text, font.clone(), weak);
    }
}

/// Round numbers between the ends of an even axis, three to seven of them, as they are written.
fn ticks([low, high]: [f64; 2]) -> Vec<(f64, String)> {
    let raw = (high - low) / 6.0;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * power).find(|step| *step >= raw).unwrap_or(raw);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last)
        .map(|i| {
            let value = i as f64 * step;
            (value, format!("{value:.decimals$}").replace('-', "\u{2212}"))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        let written = |ends| ticks(ends).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(written([-90.0, 90.0]), ["\u{2212}50", "0", "50"]);
        assert_eq!(written([0.0, 1.0]), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(written([-0.6, 0.6]), ["\u{2212}0.6", "\u{2212}0.4", "\u{2212}0.2", "0.0", "0.2", "0.4", "0.6"]);
    }
}
