//! Variances over c of many pixels of a picture, to be averaged over its parts.

use mislab_kernel::request::Heuristic;

use super::best::AtC;
use super::many::Pixels;

/// The one-sample model at the centre of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelCurve {
    /// Column and row in the full image.
    pub pixel: [u32; 2],
    /// Luminance that is reflected, more than 0.
    pub mean: f64,
    /// Second moments for each c that was asked for.
    pub at: Vec<AtC>,
}

impl Pixels<'_> {
    /// Sketches of these pixels with their second moments for each c, as [`Table::curve`](super::Table::curve) has them; only of
    /// pixels from which light comes and that show one surface, at their centre and their corners, as does the pixel to the right
    /// (whose samples tell how sure a measured variance is). `None` once nobody wants them.
    pub fn curves(&self, pixels: &[[u32; 2]], heuristic: Heuristic, cs: &[f32]) -> Option<Vec<PixelCurve>> {
        let found = self.all(pixels, |pixel| self.curve(pixel, heuristic, cs))?;
        Some(found.into_iter().flatten().collect())
    }

    fn curve(&self, pixel: [u32; 2], heuristic: Heuristic, cs: &[f32]) -> Option<PixelCurve> {
        let [x, y] = pixel.map(|v| v as f32);
        let point = self.point(x + 0.5, y + 0.5)?;
        let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.0]];
        let same = |[dx, dy]: [f32; 2]| self.point(x + dx, y + dy).is_some_and(|other| other.shape() == point.shape());
        if !point.reflects() || !corners.into_iter().all(same) {
            return None;
        }
        let table = point.sketch();
        let mean = table.true_mean();
        (mean > 0.0).then(|| PixelCurve { pixel, mean, at: table.curve(heuristic, cs) })
    }
}
