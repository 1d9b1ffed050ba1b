//! One layer of a frame as planes of numbers.

use mislab_renderer::{Frame, Layer, PixelRect};

/// The numbers of one layer of a frame.
#[derive(Clone, Debug)]
pub struct Planes {
    layer: Layer,
    bounds: PixelRect,
    image: [u32; 2],
    data: Vec<f32>,
}

impl Planes {
    /// `data`: for each channel of `layer`, `bounds.area()` numbers row by row from the top left; `image` is the size
    /// of the full image that `bounds` is part of.
    ///
    /// # Panics
    /// If `data` has another length.
    pub fn new(layer: Layer, bounds: PixelRect, image: [u32; 2], data: Vec<f32>) -> Self {
        let expected = layer.channels().len() * bounds.area();
        assert_eq!(data.len(), expected, "a layer holds one number per pixel and channel");
        Self { layer, bounds, image, data }
    }

    /// A layer of a frame.
    pub fn from_frame(frame: &Frame, layer: Layer) -> Self {
        let (bounds, channels) = (frame.bounds(), layer.channels());
        let mut data = vec![0.0; channels.len() * bounds.area()];
        frame.resolve(channels, &mut data);
        Self::new(layer, bounds, frame.request().settings.image.resolution, data)
    }

    /// What the numbers are.
    pub fn layer(&self) -> Layer {
        self.layer
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
