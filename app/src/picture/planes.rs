//! One layer of a frame as planes of numbers.

use mislab_renderer::{Frame, Layer, PixelRect};

use crate::look::layer::Quantity;
use crate::picture::variance;
use crate::state::view::VarianceUnit;

/// Stands for a pixel that cannot be sampled, in layers of one number. Nothing that is measured is negative.
pub const BLIND: f32 = f32::MIN;

/// The numbers of one layer of a frame.
#[derive(Clone, Debug)]
pub struct Planes {
    quantity: Quantity,
    bounds: PixelRect,
    image: [u32; 2],
    data: Vec<f32>,
}

impl Planes {
    /// `data`: for each channel of `quantity`, `bounds.area()` numbers row by row from the top left; `image` is the size
    /// of the full image that `bounds` is part of.
    ///
    /// # Panics
    /// If `data` has another length.
    pub fn new(quantity: impl Into<Quantity>, bounds: PixelRect, image: [u32; 2], data: Vec<f32>) -> Self {
        let quantity = quantity.into();
        let expected = quantity.channels() * bounds.area();
        assert_eq!(data.len(), expected, "a layer holds one number per pixel and channel");
        Self { quantity, bounds, image, data }
    }

    /// A layer of a frame as it is shown: the variance in that unit, and what the strategy is [`BLIND`] to marked; `blind`
    /// has a value for each pixel of the full image.
    pub fn shown(frame: &Frame, layer: Layer, unit: VarianceUnit, blind: Option<&[bool]>) -> Self {
        let mut planes = match layer {
            Layer::Variance => Self::variance(frame, unit),
            Layer::Picture
            | Layer::Light
            | Layer::Bsdf
            | Layer::WeightLight
            | Layer::WeightBsdf
            | Layer::ShareLight => Self::from_frame(frame, layer),
        };
        if let Some(blind) = blind.filter(|_| layer.channels().len() == 1) {
            planes.mark(blind);
        }
        planes
    }

    fn variance(frame: &Frame, unit: VarianceUnit) -> Self {
        let bounds = frame.bounds();
        let area = bounds.area();
        let mut data = vec![0.0; variance::CHANNELS.len() * area];
        frame.resolve(&variance::CHANNELS, &mut data);
        let cost = variance::cost(unit, frame);
        for i in 0..area {
            data[i] = variance::in_unit(unit, cost, [0, 1, 2, 3].map(|c| data[c * area + i]));
        }
        data.truncate(area);
        Self::new(Layer::Variance, bounds, frame.request().settings.image.resolution, data)
    }

    /// Marks pixels of the full image as [`BLIND`].
    pub fn mark(&mut self, blind: &[bool]) {
        let width = self.bounds.width() as usize;
        for (y, row) in self.data.chunks_exact_mut(width.max(1)).enumerate() {
            let first = (self.bounds.min[1] as usize + y) * self.image[0] as usize + self.bounds.min[0] as usize;
            for (value, _) in row.iter_mut().zip(&blind[first..]).filter(|(_, blind)| **blind) {
                *value = BLIND;
            }
        }
    }

    /// The numbers of a layer of a frame, as files have them.
    pub fn from_frame(frame: &Frame, layer: Layer) -> Self {
        let (bounds, channels) = (frame.bounds(), layer.channels());
        let mut data = vec![0.0; channels.len() * bounds.area()];
        frame.resolve(channels, &mut data);
        Self::new(layer, bounds, frame.request().settings.image.resolution, data)
    }

    /// What the numbers are.
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// The pixels there are numbers for, in coordinates of the full image.
    pub fn bounds(&self) -> PixelRect {
        self.bounds
    }

    /// Size of the full image in pixels.
    pub fn image(&self) -> [u32; 2] {
        self.image
    }

    /// The planes, one per channel.
    pub fn channels(&self) -> impl Iterator<Item = &[f32]> {
        self.data.chunks_exact(self.bounds.area().max(1))
    }

    /// The numbers of the pixel in column `x` and row `y` of the bounds; a single channel comes three times.
    pub fn value(&self, x: u32, y: u32) -> [f32; 3] {
        let area = self.bounds.area();
        let i = y as usize * self.bounds.width() as usize + x as usize;
        if self.data.len() == area { [self.data[i]; 3] } else { [0, 1, 2].map(|c| self.data[c * area + i]) }
    }
}
