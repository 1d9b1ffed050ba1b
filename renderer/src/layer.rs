//! What a frame shows of its sums: layers for people, and the channels they are made of.

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
