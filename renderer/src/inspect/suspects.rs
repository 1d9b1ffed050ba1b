//! What a picture's sums tell of its brightest samples, without any of them.

use mislab_kernel::film::{COUNT, LUMINANCE};
use mislab_kernel::geometry::grid::BLOCK;
use mislab_kernel::lanes::PACKET;
use mislab_kernel::request::PixelRect;

use crate::frame::Frame;
use crate::layer::Channel;

/// A pixel, and how bright one of its samples can be at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspect {
    /// Column and row in the full image.
    pub pixel: [u32; 2],
    /// Luminance of all samples together, lights seen directly included.
    pub sum: f64,
    /// No secondary ray adds more luminance.
    pub most: f64,
}

/// The sums of one pixel.
struct Sums {
    /// Luminance of all samples, of what is reflected and of all.
    reflected: f64,
    all: f64,
    /// Of the squared luminance of all samples.
    squares: f64,
    /// Samples that may be more than 0.
    lit: f64,
}

/// Single precision knows the sums to less.
const ROUNDING: f64 = 1e-5;

impl Sums {
    /// The pixel, if one of its samples may have at least half of the sum of squares.
    ///
    /// Of n numbers that are not negative none is larger than their sum, nor than `m + sqrt((n - 1) v)`, with their mean m
    /// and variance v (Samuelson 1968).
    fn suspect(&self, pixel: [u32; 2]) -> Option<Suspect> {
        let Self { reflected, all, squares, lit } = *self;
        if reflected <= 0.0 || reflected.is_nan() || lit < 1.0 {
            return None;
        }
        let mean = all / lit;
        let variance = (squares / lit - mean * mean).max(0.0);
        let samuelson = mean + ((lit - 1.0) * variance).sqrt();
        // Squares that are beyond single precision say nothing.
        let most = if samuelson.is_finite() { samuelson.min(reflected) } else { reflected } * (1.0 + ROUNDING);
        let outweighs = most * most >= 0.5 * squares || !squares.is_finite();
        outweighs.then_some(Suspect { pixel, sum: all, most })
    }
}

/// All pixels of a frame with samples that may be outliers, see [`Outlier`](super::Outlier). Frames know how many samples
/// carry light.
pub fn suspects_of_frame(frame: &Frame) -> Vec<Suspect> {
    let mut suspects = Vec::new();
    for tile in &frame.tiles {
        let PixelRect { min: [left, top], max: [right, bottom] } = tile.bounds;
        for block in 0..tile.block_count() {
            let corner = tile.block_corner(block);
            let lanes = |of: &dyn Fn(usize) -> [f64; PACKET]| {
                let [r, g, b] = [0, 1, 2].map(of);
                move |lane: usize| luminance([r[lane], g[lane], b[lane]])
            };
            let light = lanes(&|channel| tile.light(block, channel));
            let bsdf = lanes(&|channel| tile.bsdf(block, channel));
            let emitted = lanes(&|channel| tile.emission(block, channel).unwrap_or([0.0; PACKET]));
            let counts = [tile.light(block, COUNT), tile.bsdf(block, COUNT)];
            let squares = tile.luminance2(block);
            for lane in 0..squares.len() {
                let pixel = [corner[0] + lane as u32 % BLOCK[0], corner[1] + lane as u32 / BLOCK[0]];
                if !(left..right).contains(&pixel[0]) || !(top..bottom).contains(&pixel[1]) {
                    continue;
                }
                let reflected = light(lane) + bsdf(lane);
                let emitted = emitted(lane);
                let samples = f64::from(tile.samples);
                let lit = if emitted > 0.0 { samples } else { (counts[0][lane] + counts[1][lane]).min(samples) };
                let sums = Sums { reflected, all: reflected + emitted, squares: squares[lane], lit };
                suspects.extend(sums.suspect(pixel));
            }
        }
    }
    suspects
}

/// The same from the layers of a picture of `spp` samples: `layer` hands over the values of a channel, row by row from
/// the top left of `bounds`. `None` if it lacks one.
pub fn suspects_of_layers<'a>(
    bounds: PixelRect,
    spp: u32,
    layer: &dyn Fn(Channel) -> Option<&'a [f32]>,
) -> Option<Vec<Suspect>> {
    let colour = |channels: [Channel; 3]| {
        let [r, g, b] = channels.map(layer);
        let (r, g, b) = (r?, g?, b?);
        Some(move |i: usize| luminance([r, g, b].map(|plane| f64::from(plane[i]))))
    };
    let all = colour([Channel::R, Channel::G, Channel::B])?;
    let light = colour([Channel::LightR, Channel::LightG, Channel::LightB])?;
    let bsdf = colour([Channel::BsdfR, Channel::BsdfG, Channel::BsdfB])?;
    let variances = layer(Channel::VarianceY)?;
    let samples = f64::from(spp);
    let suspect = |i: usize| {
        let [reflected, all] = [light(i) + bsdf(i), all(i)].map(|mean| mean * samples);
        let squares = match spp {
            1 => all * all,
            _ => f64::from(variances[i]) * (samples - 1.0) + all * all / samples,
        };
        let [x, y] = [i as u32 % bounds.width(), i as u32 / bounds.width()];
        let squares = if squares.is_nan() { f64::INFINITY } else { squares };
        Sums { reflected, all, squares, lit: samples }.suspect([bounds.min[0] + x, bounds.min[1] + y])
    };
    Some((0..bounds.area()).filter_map(suspect).collect())
}

fn luminance(rgb: [f64; 3]) -> f64 {
    rgb.into_iter().zip(LUMINANCE).map(|(c, weight)| c * f64::from(weight)).sum()
}
