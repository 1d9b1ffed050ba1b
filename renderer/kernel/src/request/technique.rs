//! The two techniques.

/// One way to draw the direction of a secondary ray. A strategy combines techniques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Technique {
    /// Towards a light, with density `p_L`.
    Light,
    /// By the lobe of the BSDF, with density `p_B`.
    Bsdf,
}

impl Technique {
    /// Both, light first.
    pub const ALL: [Self; 2] = [Self::Light, Self::Bsdf];
}

/// Something that each technique has one of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerTechnique<T> {
    /// That of the light technique.
    pub light: T,
    /// That of the BSDF technique.
    pub bsdf: T,
}

impl PerTechnique<bool> {
    /// True for both.
    pub const BOTH: Self = Self { light: true, bsdf: true };
}

impl<T> PerTechnique<T> {
    /// That of one technique.
    #[inline(always)]
    pub fn of(&self, technique: Technique) -> &T {
        match technique {
            Technique::Light => &self.light,
            Technique::Bsdf => &self.bsdf,
        }
    }
}
