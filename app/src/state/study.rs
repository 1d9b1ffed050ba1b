//! What can be looked at beside the pictures, or in their place: plots, numbers, series of pictures.

/// A study of the scene or of its pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Study {
    /// How the error falls.
    Convergence,
    /// Means against a reference: bias or noise.
    Means,
    /// Each technique's picture, its weights, and both multiplied.
    Pyramid,
    /// Small pictures of all strategies under all heuristics, or over c.
    Grid,
    /// Which strategy is best for each size of light and roughness.
    Plane,
    /// What happens at one pixel: its numbers, directions and samples.
    Explain,
    /// The best c of every pixel.
    BestC,
}

impl Study {
    /// All of them, in the order shown to users.
    pub const ALL: [Self; 7] =
        [Self::Explain, Self::BestC, Self::Convergence, Self::Means, Self::Pyramid, Self::Grid, Self::Plane];

    /// The name on screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Convergence => "Convergence",
            Self::Means => "Means: bias or noise",
            Self::Pyramid => "Techniques and weights",
            Self::Grid => "Grid of pictures",
            Self::Plane => "Light size and roughness",
            Self::Explain => "Explain a pixel",
            Self::BestC => "Best c of every pixel",
        }
    }

    /// The name in names of files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Convergence => "convergence",
            Self::Means => "means",
            Self::Pyramid => "techniques",
            Self::Grid => "grid",
            Self::Plane => "plane",
            Self::Explain => "pixel",
            Self::BestC => "best-c",
        }
    }

    /// It is looked at together with the pictures; others take their place.
    pub fn is_beside_pictures(self) -> bool {
        match self {
            Self::Convergence | Self::Means | Self::Explain | Self::BestC => true,
            Self::Pyramid | Self::Grid | Self::Plane => false,
        }
    }
}
