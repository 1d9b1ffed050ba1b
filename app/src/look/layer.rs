//! What a layer is to the eye, in one table: its name, its marks, what its numbers are and how they become colours.
//!
//! Names in EXR files are the renderer's: [`mislab_renderer::Channel::exr_name`].

use mislab_renderer::{Estimator, Layer, Strategy, Technique};

use super::versus::Versus;

/// What the numbers of a picture on screen are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A layer of one picture.
    Layer(Layer),
    /// A number of two pictures.
    Versus(Versus),
}

impl From<Layer> for Quantity {
    fn from(layer: Layer) -> Self {
        Self::Layer(layer)
    }
}

impl From<Versus> for Quantity {
    fn from(versus: Versus) -> Self {
        Self::Versus(versus)
    }
}

impl Quantity {
    /// Numbers of a pixel.
    pub fn channels(self) -> usize {
        match self {
            Self::Layer(layer) => layer.channels().len(),
            Self::Versus(Versus::Difference | Versus::Variances | Versus::Errors) => 1,
        }
    }
}

/// How the numbers of a layer become colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colouring {
    /// They are a colour: exposure, offset and tone map apply.
    Radiance,
    /// A share in [0, 1] of one technique against the other: from blue to amber.
    Share {
        /// Whose share it is: at 1 it has the colour of this technique.
        of: Technique,
        /// What the two ends of the colour bar mean: 0 and 1.
        ends: [&'static str; 2],
    },
    /// A number without bound: its logarithm over the range that the user sets, in viridis.
    Magnitude,
    /// A number on either side of 0, over the same range both ways: from violet to olive.
    Signed,
}

/// A layer on screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerLook {
    /// Its name.
    pub name: &'static str,
    /// Its name where a view is stored.
    pub key: &'static str,
    /// The technique it is about, in whose colour it is marked in lists.
    pub technique: Option<Technique>,
    /// What the numbers of a pixel are called, one for each channel.
    pub values: &'static [&'static str],
    /// How they become colours.
    pub colouring: Colouring,
}

impl LayerLook {
    /// The table.
    pub fn of(quantity: impl Into<Quantity>) -> Self {
        use Technique::{Bsdf, Light};
        let layer = match quantity.into() {
            Quantity::Layer(layer) => layer,
            Quantity::Versus(versus) => {
                let values: &[&str] = match versus {
                    Versus::Difference => &["A \u{2212} B"],
                    Versus::Variances | Versus::Errors => &["log2 A / B"],
                };
                let (name, key) = (versus.title(), "versus");
                return Self { name, key, technique: None, values, colouring: Colouring::Signed };
            }
        };
        match layer {
            Layer::Picture => Self::radiance("Picture", "picture", None),
            Layer::Light => Self::radiance("Light technique", "light", Some(Light)),
            Layer::Bsdf => Self::radiance("BSDF technique", "bsdf", Some(Bsdf)),
            Layer::WeightLight => Self {
                name: "MIS weight, light samples",
                key: "w_light",
                technique: Some(Light),
                values: &["weight"],
                colouring: Colouring::Share { of: Light, ends: ["0 left to BSDF", "1 light only"] },
            },
            Layer::WeightBsdf => Self {
                name: "MIS weight, BSDF samples",
                key: "w_bsdf",
                technique: Some(Bsdf),
                values: &["weight"],
                colouring: Colouring::Share { of: Bsdf, ends: ["0 left to light", "1 BSDF only"] },
            },
            Layer::ShareLight => Self {
                name: "Share of the light technique",
                key: "share_light",
                technique: Some(Light),
                values: &["share"],
                colouring: Colouring::Share { of: Light, ends: ["0 all BSDF", "1 all light"] },
            },
            Layer::Variance => Self {
                name: "Variance",
                key: "variance",
                technique: None,
                values: &["variance"],
                colouring: Colouring::Magnitude,
            },
        }
    }

    const fn radiance(name: &'static str, key: &'static str, technique: Option<Technique>) -> Self {
        Self { name, key, technique, values: &["R", "G", "B"], colouring: Colouring::Radiance }
    }

    /// Whether it is a colour image (exposure and tone map apply) and not false colour.
    pub fn is_colour(self) -> bool {
        self.colouring == Colouring::Radiance
    }
}

/// Why `layer` shows nothing: the samples it is about are never drawn. `None` where they are.
pub fn not_drawn(layer: Layer, estimator: &Estimator) -> Option<String> {
    let of = match layer {
        Layer::Light | Layer::WeightLight => Technique::Light,
        Layer::Bsdf | Layer::WeightBsdf => Technique::Bsdf,
        Layer::Picture | Layer::ShareLight | Layer::Variance => return None,
    };
    let draws = estimator.strategy.draws();
    let one = estimator.strategy == Strategy::Mis;
    let (name, drawn, never) = match of {
        Technique::Light => ("light", draws.light, one && estimator.light_prob == 0.0),
        Technique::Bsdf => ("BSDF", draws.bsdf, one && estimator.light_prob == 1.0),
    };
    if !drawn {
        Some(format!("This strategy draws no {name} samples."))
    } else if never {
        Some(format!("At c = {} no {name} samples are drawn.", estimator.light_prob))
    } else {
        None
    }
}

/// Layers by their keys, for serde: the renderer itself does not store them.
pub mod by_key {
    use mislab_renderer::Layer;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    use super::LayerLook;

    /// Writes the key.
    pub fn serialize<S: Serializer>(layer: &Layer, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(LayerLook::of(*layer).key)
    }

    /// The layer of that key.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Layer, D::Error> {
        let key = String::deserialize(deserializer)?;
        Layer::ALL.into_iter().find(|layer| LayerLook::of(*layer).key == key).ok_or_else(|| {
            let known = Layer::ALL.map(|layer| LayerLook::of(layer).key);
            D::Error::custom(format!("layer \"{key}\", expected one of {}", known.join(", ")))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_has_a_name_and_every_key_is_one_of_a_kind() {
        for layer in Layer::ALL {
            let look = LayerLook::of(layer);
            assert_eq!(look.values.len(), layer.channels().len(), "{layer:?}");
            assert_eq!(look.is_colour(), layer.channels().len() == 3, "{layer:?}");
            assert_eq!(Layer::ALL.iter().filter(|other| LayerLook::of(**other).key == look.key).count(), 1);
        }
    }

    #[test]
    fn what_is_not_drawn_is_said() {
        let of = |strategy, light_prob| Estimator { strategy, light_prob, ..Estimator::default() };
        let said = |layer, estimator| not_drawn(layer, &estimator).unwrap_or_default();
        assert_eq!(said(Layer::Light, of(Strategy::Bsdf, 0.5)), "This strategy draws no light samples.");
        assert_eq!(said(Layer::WeightBsdf, of(Strategy::Light, 0.5)), "This strategy draws no BSDF samples.");
        assert_eq!(said(Layer::Bsdf, of(Strategy::Mis, 1.0)), "At c = 1 no BSDF samples are drawn.");
        for (layer, estimator) in [
            (Layer::Light, of(Strategy::MisAll, 0.0)),
            (Layer::Bsdf, of(Strategy::Mis, 0.5)),
            (Layer::Picture, of(Strategy::Bsdf, 0.0)),
        ] {
            assert_eq!(not_drawn(layer, &estimator), None, "{layer:?}");
        }
    }
}
