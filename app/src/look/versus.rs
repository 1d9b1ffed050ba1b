//! What one picture can be shown as against another.

use serde::{Deserialize, Serialize};

/// A number of two pictures for each pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Versus {
    /// Luminance of A minus that of B.
    Difference,
    /// log2 of the variance of A over that of B, for blocks of pixels.
    #[default]
    Variances,
    /// log2 of the squared error of A over that of B against the reference, for blocks of pixels.
    Errors,
}

impl Versus {
    /// All of them, in the order shown to users.
    pub const ALL: [Self; 3] = [Self::Variances, Self::Errors, Self::Difference];

    /// The name on a button.
    pub fn name(self) -> &'static str {
        match self {
            Self::Difference => "A \u{2212} B",
            Self::Variances => "Noise A / B",
            Self::Errors => "Error A / B",
        }
    }

    /// What the numbers are, over their legend.
    pub fn title(self) -> &'static str {
        match self {
            Self::Difference => "Luminance: A \u{2212} B, in radiance",
            Self::Variances => "Variance: A over B, by 8 \u{d7} 8 pixels",
            Self::Errors => "Squared error: A over B, by 8 \u{d7} 8 pixels",
        }
    }

    /// What it tells, in a sentence.
    pub fn description(self) -> &'static str {
        match self {
            Self::Difference => {
                "Luminance of A minus that of B: olive where A is brighter, violet where B is. Key N sets the range."
            }
            Self::Variances => {
                "Variance of A over that of B, at what is equal: olive where A is the noisier one, violet where B is."
            }
            Self::Errors => {
                "relMSE of A over that of B, as they are, against a reference made in the background: bias counts, too."
            }
        }
    }
}
