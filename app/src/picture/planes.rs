//! One layer of a frame as planes of numbers.

use mislab_renderer::blind::Dark;
use mislab_renderer::{Frame, Layer, PixelRect};

use crate::look::layer::Quantity;
use crate::picture::variance;
use crate::state::view::VarianceUnit;

/// Stands for a pixel that cannot be sampled. Nothing that is measured is so far below 0.
pub const BLIND: f32 = f32::MIN;
/// Stands for a pixel that no sample has hit yet, in colours; a layer of one number has NaN there.
pub const UNHIT: f32 = f32::MIN / 2.0;

/// Stands for a pixel that has no number because it reflects no light, in layers of one number.
pub const UNLIT: f32 = f32::MIN / 4.0;

/// What is asked of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// Which of its layers.
    pub layer: Layer,
    /// What a variance is per.
    pub unit: VarianceUnit,
    /// Also its numbers: the graphics device may be the only one to have them otherwise.
    pub numbers: bool,
}

impl Asked {
    /// Whether these are what is asked for.
    pub fn is_met_by(&self, planes: &Planes) -> bool {
        planes.quantity() == self.layer.into() && (planes.has_numbers() || !self.numbers)
    }
}

/// The numbers of one layer of a frame, or what they are about.
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

    /// A layer of a frame as it is shown: the variance in that unit, and what is hatched marked; `dark` has a value for each pixel of
    /// the full image.
    pub fn shown(frame: &Frame, layer: Layer, unit: VarianceUnit, dark: Option<&[Dark]>) -> Self {
        Self::shown_in(Vec::new(), frame, layer, unit, dark)
    }

    /// The same in the memory of older ones, which [`Self::without_numbers`] has given.
    pub fn shown_in(memory: Vec<f32>, frame: &Frame, layer: Layer, unit: VarianceUnit, dark: Option<&[Dark]>) -> Self {
        let mut planes = match layer {
            Layer::Variance => Self::variance(memory, frame, unit),
            Layer::Picture
            | Layer::Light
            | Layer::Bsdf
            | Layer::WeightLight
            | Layer::WeightBsdf
            | Layer::ShareLight => Self::from_frame_in(memory, frame, layer),
        };
        if let Some(dark) = dark {
            planes.mark(dark);
        }
        planes
    }

    fn variance(mut data: Vec<f32>, frame: &Frame, unit: VarianceUnit) -> Self {
        let bounds = frame.bounds();
        let area = bounds.area();
        data.resize(variance::CHANNELS.len() * area, 0.0);
        frame.resolve(&variance::CHANNELS, &mut data);
        let cost = variance::cost(unit, frame);
        for i in 0..area {
            data[i] = variance::in_unit(unit, cost, [0, 1, 2, 3].map(|c| data[c * area + i]));
        }
        data.truncate(area);
        Self::new(Layer::Variance, bounds, frame.request().settings.image.resolution, data)
    }

    /// Marks what has no number: of colours the black pixels, by what they are, in the first channel; of one number those that are
    /// [`BLIND`] or [`UNLIT`].
    pub fn mark(&mut self, dark: &[Dark]) {
        let (width, area) = (self.bounds.width() as usize, self.bounds.area());
        let colour = self.data.len() > area;
        let (red, others) = self.data.split_at_mut(area);
        let first = self.bounds.min[1] as usize * self.image[0] as usize + self.bounds.min[0] as usize;
        for (y, row) in red.chunks_exact_mut(width.max(1)).enumerate() {
            let dark = &dark[first + y * self.image[0] as usize..];
            for (x, (value, dark)) in row.iter_mut().zip(dark).enumerate().filter(|(_, (v, _))| !colour || **v == 0.0) {
                let mark = match dark {
                    Dark::Blind => BLIND,
                    Dark::Unhit if colour => UNHIT,
                    Dark::Empty if value.is_nan() => UNLIT,
                    Dark::Unhit | Dark::Empty => continue,
                };
                if others.iter().skip(y * width + x).step_by(area).all(|other| *other == 0.0) {
                    *value = mark;
                }
            }
        }
    }

    /// Marks of a layer of one number what is [`UNLIT`] alone.
    pub fn mark_unlit(&mut self, dark: &[Dark]) {
        let empty: Vec<Dark> =
            dark.iter().map(|dark| if *dark == Dark::Empty { Dark::Empty } else { Dark::Unhit }).collect();
        self.mark(&empty);
    }

    /// Whether anything is marked as hatched, in colours.
    pub fn has_hatched_colours(&self) -> bool {
        let colour = self.data.len() > self.bounds.area();
        colour && self.channels().next().is_some_and(|red| red.iter().any(|v| *v == UNHIT || *v == BLIND))
    }

    /// The numbers of a layer of a frame, as files have them.
    pub fn from_frame(frame: &Frame, layer: Layer) -> Self {
        Self::from_frame_in(Vec::new(), frame, layer)
    }

    fn from_frame_in(mut data: Vec<f32>, frame: &Frame, layer: Layer) -> Self {
        let (bounds, channels) = (frame.bounds(), layer.channels());
        data.resize(channels.len() * bounds.area(), 0.0);
        frame.resolve(channels, &mut data);
        Self::new(layer, bounds, frame.request().settings.image.resolution, data)
    }

    /// What they are about without the numbers, and the memory of these for others.
    pub fn without_numbers(self) -> (Self, Vec<f32>) {
        (Self { data: Vec::new(), ..self }, self.data)
    }

    /// Whether there are numbers, or the graphics device alone has them.
    pub fn has_numbers(&self) -> bool {
        self.data.len() >= self.bounds.area()
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
