//! What random numbers are for.

use super::hash::mix_one;
use crate::request::Strategy;

/// What a random number is for. The same technique finds the same numbers in every strategy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Position in the pixel (2).
    Pixel = 0,
    /// Which technique, in the one-sample model (1).
    Technique = 1,
    /// Which light (1).
    LightChoice = 2,
    /// Point or direction on the light (2).
    Light = 3,
    /// Which lobe of the BSDF (1).
    Lobe = 4,
    /// Direction in the lobe (2).
    Bsdf = 5,
}

impl Dimension {
    /// All dimensions, by number.
    pub const ALL: [Self; 6] = [Self::Pixel, Self::Technique, Self::LightChoice, Self::Light, Self::Lobe, Self::Bsdf];

    /// By dimension, whether a strategy asks for it, where there is more than one light to choose
    /// from (`lights`) and a surface with more than one lobe (`lobes`).
    pub fn wanted(strategy: Strategy, lights: bool, lobes: bool) -> [bool; Self::ALL.len()] {
        let draws = strategy.draws();
        Self::ALL.map(|dimension| match dimension {
            Self::Pixel => true,
            Self::Technique => strategy == Strategy::Mis,
            Self::LightChoice => draws.light && lights,
            Self::Light => draws.light,
            Self::Lobe => draws.bsdf && lobes,
            Self::Bsdf => draws.bsdf,
        })
    }

    /// Of those, the ones that have numbers of their own where one number is for several of them: the technique and
    /// the direction, the choice of a light or a lobe and the direction.
    pub(super) fn once_nested(wanted: [bool; Self::ALL.len()]) -> [bool; Self::ALL.len()] {
        let alone = !wanted[Self::Technique as usize];
        Self::ALL.map(|dimension| match dimension {
            Self::Pixel | Self::Technique => wanted[dimension as usize],
            Self::Light | Self::Bsdf => wanted[dimension as usize] && alone,
            Self::LightChoice | Self::Lobe => false,
        })
    }
}

/// By dimension: what sets the streams of random numbers apart, and which number of its stream's pair a dimension of
/// one number takes.
pub(super) const STREAMS: [(u32, usize); Dimension::ALL.len()] = {
    let mut streams = [(0, 0); Dimension::ALL.len()];
    let mut i = 0;
    while i < streams.len() {
        streams[i].0 = mix_one(0x632b_e5ab ^ i as u32);
        i += 1;
    }
    // Every strategy that asks for a technique chooses a light as well: two numbers for one.
    streams[Dimension::LightChoice as usize] = (streams[Dimension::Technique as usize].0, 1);
    streams
};
