//! What a picture on screen is made of: a frame that was rendered, or a file.

use std::sync::Arc;

use mislab_renderer::{Channel, Frame, Layer, PixelRect};

use crate::look::layer::LayerLook;
use crate::picture::dark::Darks;
use crate::picture::foreign::Foreign;
use crate::picture::planes::Planes;
use crate::state::view::VarianceUnit;

/// Numbers to look at.
#[derive(Clone)]
pub enum Content {
    /// Of this program.
    Frame(Arc<Frame>),
    /// Of whatever program.
    File(Arc<Foreign>),
}

impl Content {
    /// The very same, not only equal.
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Frame(a), Self::Frame(b)) => Arc::ptr_eq(a, b),
            (Self::File(a), Self::File(b)) => Arc::ptr_eq(a, b),
            (Self::Frame(_), Self::File(_)) | (Self::File(_), Self::Frame(_)) => false,
        }
    }

    /// Size of the full image in pixels.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Frame(frame) => frame.request().settings.image.resolution,
            Self::File(file) => file.size(),
        }
    }

    /// The pixels there are numbers for, in coordinates of the full image.
    pub fn bounds(&self) -> PixelRect {
        match self {
            Self::Frame(frame) => frame.bounds(),
            Self::File(file) => file.bounds(),
        }
    }

    /// A frame of this program.
    pub fn frame(&self) -> Option<&Arc<Frame>> {
        match self {
            Self::Frame(frame) => Some(frame),
            Self::File(_) => None,
        }
    }

    /// The numbers of a layer as they are shown: see [`Planes::shown`]. Of a file there is the variance of one sample alone.
    ///
    /// # Errors
    /// If there are none, why not.
    pub fn planes(&self, layer: Layer, unit: VarianceUnit, dark: &Darks) -> Result<Planes, String> {
        match self {
            Self::Frame(frame) => Ok(Planes::shown(frame, layer, unit, dark.as_ref().map(|dark| dark.as_slice()))),
            Self::File(file) => {
                let planes = file.planes(layer, LayerLook::of(layer).name)?;
                if layer == Layer::Variance && unit != VarianceUnit::OneSample {
                    return Err(format!("{} has the variance of one sample alone: choose that unit.", file.name()));
                }
                Ok(planes)
            }
        }
    }

    /// The number of a pixel of the full image, if there is one.
    pub fn value(&self, [x, y]: [u32; 2], channel: Channel) -> Option<f32> {
        match self {
            Self::Frame(frame) => frame.pixel(x, y, channel),
            Self::File(file) => file.value([x, y], channel),
        }
    }
}
