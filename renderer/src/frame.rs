//! An immutable snapshot of a picture in progress, and the layers in it.

use std::sync::Arc;

use crate::progressive::Request;
use crate::settings::PixelRect;

/// One image of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The estimate itself: visible emission plus both contributions.
    Picture,
    /// Weighted contribution of the light technique.
    Light,
    /// Weighted contribution of the BSDF technique.
    Bsdf,
    /// Mean MIS weight of the light samples that carried light.
    WeightLight,
    /// Mean MIS weight of the BSDF samples that carried light.
    WeightBsdf,
    /// Light technique's share of the reflected luminance.
    ShareLight,
    /// Variance of the luminance of one sample.
    Variance,
}

impl Layer {
    /// All layers, in the order shown to users.
    pub const ALL: [Self; 7] =
        [Self::Picture, Self::Light, Self::Bsdf, Self::WeightLight, Self::WeightBsdf, Self::ShareLight, Self::Variance];

    /// The channels of the layer: three for colour, one for a quantity.
    pub fn channels(self) -> &'static [Channel] {
        use Channel::*;
        match self {
            Self::Picture => &[R, G, B],
            Self::Light => &[LightR, LightG, LightB],
            Self::Bsdf => &[BsdfR, BsdfG, BsdfB],
            Self::WeightLight => &[WeightLightY],
            Self::WeightBsdf => &[WeightBsdfY],
            Self::ShareLight => &[ShareLightY],
            Self::Variance => &[VarianceY],
        }
    }
}

/// One plane of numbers of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "named after their layer and colour")]
pub enum Channel {
    R,
    G,
    B,
    LightR,
    LightG,
    LightB,
    BsdfR,
    BsdfG,
    BsdfB,
    WeightLightY,
    WeightBsdfY,
    ShareLightY,
    VarianceY,
}

impl Channel {
    /// All channels.
    pub const ALL: [Self; 13] = {
        use Channel::*;
        [R, G, B, LightR, LightG, LightB, BsdfR, BsdfG, BsdfB, WeightLightY, WeightBsdfY, ShareLightY, VarianceY]
    };

    /// Name in EXR files.
    pub fn exr_name(self) -> &'static str {
        match self {
            Self::R => "R",
            Self::G => "G",
            Self::B => "B",
            Self::LightR => "light.R",
            Self::LightG => "light.G",
            Self::LightB => "light.B",
            Self::BsdfR => "bsdf.R",
            Self::BsdfG => "bsdf.G",
            Self::BsdfB => "bsdf.B",
            Self::WeightLightY => "w_light.Y",
            Self::WeightBsdfY => "w_bsdf.Y",
            Self::ShareLightY => "share_light.Y",
            Self::VarianceY => "variance.Y",
        }
    }
}

/// How much work a frame took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameStats {
    /// Secondary rays traced (`mis_all`: two per camera ray).
    pub paths: u64,
    /// Wall-clock seconds spent rendering, pauses left out.
    pub render_seconds: f64,
    /// The same summed over threads.
    pub cpu_seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// SIMD level the kernel ran at.
    pub simd: &'static str,
    /// Samples whose contribution was not a finite number; counted and left out of the sums.
    pub invalid_samples: u64,
}

impl FrameStats {
    /// Millions of secondary rays per wall-clock second.
    pub fn mpaths_per_second(&self) -> f64 {
        if self.render_seconds > 0.0 { self.paths as f64 / self.render_seconds * 1e-6 } else { 0.0 }
    }
}

/// An immutable snapshot of a picture after a whole number of passes.
#[derive(Debug)]
pub struct Frame {
    request: Arc<Request>,
    generation: u64,
    spp: u32,
    bounds: PixelRect,
    stats: FrameStats,
}

impl Frame {
    /// The scene and settings it was made with.
    pub fn request(&self) -> &Arc<Request> {
        &self.request
    }

    /// Version of the settings; grows with every submit and restart.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Complete passes, at least 1.
    pub fn spp(&self) -> u32 {
        self.spp
    }

    /// The pixels it holds, in coordinates of the full image.
    pub fn bounds(&self) -> PixelRect {
        self.bounds
    }

    /// How much work it took.
    pub fn stats(&self) -> FrameStats {
        self.stats
    }

    /// Writes one channel: `bounds().area()` values, row by row from the top left. Undefined
    /// values (no sample of the technique carried light; variance of a single sample) are NaN.
    pub fn resolve(&self, channel: Channel, out: &mut [f32]) {
        let _ = (channel, out);
        unimplemented!()
    }

    /// One channel as by [`Self::resolve`].
    pub fn channel(&self, channel: Channel) -> Vec<f32> {
        let mut out = vec![0.0; self.bounds.area()];
        self.resolve(channel, &mut out);
        out
    }

    /// One value at a pixel of the full image; `None` outside [`Self::bounds`].
    pub fn pixel(&self, x: u32, y: u32, channel: Channel) -> Option<f32> {
        let _ = (x, y, channel);
        unimplemented!()
    }
}
