//! The plane's picture: colour says which strategy is best, strength by how much, hatching that there is no difference.

use eframe::egui::{Align2, Color32, ColorImage, Painter, Rect, Stroke, TextStyle, Ui, pos2, vec2};
use mislab_renderer::Strategy;
use mislab_renderer::plane::{NO_DIFFERENCE, best_of};

use super::plane_job::{ALPHA, Found, share_of};
use crate::look::theme::{GRID, strategy_fill};

/// From this ratio to the second best the colour is at its full strength.
pub const FULL: f64 = 10.0;
/// Strength where the best is just distinguishable.
const PALE: f32 = 0.35;
/// Pairs of stripes are so many texels apart. They fall to the right, across the border between light and BSDF.
const STRIPES: usize = 16;

/// The colour of the best strategy, its variance so many times below that of the second best.
pub fn colour(best: Strategy, margin: f64, paper: Color32) -> Color32 {
    let strength = ((margin / NO_DIFFERENCE).ln() / (FULL / NO_DIFFERENCE).ln()).clamp(0.0, 1.0) as f32;
    paper.lerp_to_gamma(strategy_fill(best).0, PALE + (1.0 - PALE) * strength)
}

/// The plane as `size` texels; alpha grows to the right, the radius upwards.
pub fn image(found: &Found, size: [usize; 2], paper: Color32, stripe: Color32) -> ColorImage {
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let share = [(x as f32 + 0.5) / size[0] as f32, 1.0 - (y as f32 + 0.5) / size[1] as f32];
            pixels.push(match found.between(share).and_then(|logs| best_of_logs(&logs)) {
                Some((best, margin)) if margin >= NO_DIFFERENCE => colour(best, margin, paper),
                Some((best, margin)) if (x + size[1] - y) % STRIPES < STRIPES / 2 => colour(best, margin, paper),
                Some(_) => stripe,
                None => paper,
            });
        }
    }
    ColorImage::new(size, pixels)
}

/// The strategy of the least variance, and how many times that of the second best it is.
fn best_of_logs(logs: &[f64; 4]) -> Option<(Strategy, f64)> {
    best_of(logs.map(|log| log.is_finite().then(|| log.exp())))
}

/// Ticks and numbers of both axes around the map.
pub fn axes(ui: &Ui, map: Rect, radius: [f32; 2]) {
    let painter = ui.painter();
    let font = TextStyle::Small.resolve(ui.style());
    let (ink, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    let stroke = Stroke::new(1.0, weak);
    painter.rect_stroke(map, 0.0, stroke, eframe::egui::StrokeKind::Outside);
    for value in ticks(ALPHA) {
        let x = map.left() + share_of(ALPHA, value) * map.width();
        painter.vline(x, map.bottom()..=map.bottom() + GRID, stroke);
        painter.text(pos2(x, map.bottom() + GRID), Align2::CENTER_TOP, value.to_string(), font.clone(), ink);
    }
    for value in ticks(radius) {
        let y = map.bottom() - share_of(radius, value) * map.height();
        painter.hline(map.left() - GRID..=map.left(), y, stroke);
        painter.text(pos2(map.left() - 1.5 * GRID, y), Align2::RIGHT_CENTER, value.to_string(), font.clone(), ink);
    }
    let under = map.bottom() + GRID + ui.text_style_height(&TextStyle::Small);
    let name = "roughness of the plate: GGX width \u{3b1}";
    painter.text(pos2(map.center().x, under), Align2::CENTER_TOP, name, font.clone(), weak);
    let over = map.left_top() - vec2(0.0, GRID);
    painter.text(over, Align2::LEFT_BOTTOM, "radius of the light, scene units", font, weak);
}

/// 1, 2 and 5 of each power of ten between the ends.
fn ticks([low, high]: [f32; 2]) -> Vec<f32> {
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let values = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
    // From f64, so that 0.05 reads as such.
    values.map(|v| v as f32).filter(|v| (low * 0.999..=high * 1.001).contains(v)).collect()
}

/// A square of the scene: a dot in the colour of its best strategy; beside the axis a mirror, which has no place on it.
pub fn dot(painter: &Painter, at: eframe::egui::Pos2, fill: Color32, ring: Color32, chosen: bool) {
    let (size, width) = if chosen { (7.0, 3.0) } else { (5.0, 1.5) };
    painter.circle_filled(at, size + width, Color32::from_black_alpha(90));
    painter.circle(at, size, fill, Stroke::new(width, ring));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_inside_the_axis() {
        assert_eq!(ticks([0.002, 0.5]), [0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5]);
    }

    #[test]
    fn the_least_of_four_and_its_margin() {
        let (best, margin) = best_of_logs(&[3.0, 1.0, 2.0, f64::INFINITY]).expect("three are known");
        assert_eq!(best, Strategy::Bsdf);
        assert!((margin - 1f64.exp()).abs() < 1e-12);
        assert_eq!(best_of_logs(&[f64::INFINITY; 4]), None);
    }
}
