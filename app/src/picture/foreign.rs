//! A picture from a file, of whatever program: its numbers, and where they lie.

use std::path::Path;

use mislab_renderer::snapshot::{Image, Window, layer_and_component, layers_of};
use mislab_renderer::{Channel, Layer, PixelRect};

use crate::picture::planes::Planes;
use crate::state::paths::short_name;

/// A picture from a file, to be compared with.
#[derive(Debug)]
pub struct Foreign {
    name: String,
    bounds: PixelRect,
    size: [u32; 2],
    /// The channels shown as the picture.
    colours: [usize; 3],
    /// `None` once the memory was needed for others.
    image: Option<Image>,
}

impl Foreign {
    /// `colours`: the channels shown as the picture; `None` for [`usual_colours`].
    ///
    /// # Errors
    /// Without a channel, in words.
    pub fn new(path: &Path, image: Image, colours: Option<[usize; 3]>) -> Result<Self, String> {
        let name = short_name(path);
        let usual = || usual_colours(&image);
        let colours =
            colours.or_else(usual).ok_or_else(|| format!("{name} has no channels: there is nothing to see"))?;
        let (bounds, size) = place(&image);
        Ok(Self { name, bounds, size, colours, image: Some(image) })
    }

    /// The same without its numbers.
    pub fn emptied(&self) -> Self {
        let Self { name, bounds, size, colours, image: _ } = self;
        Self { name: name.clone(), bounds: *bounds, size: *size, colours: *colours, image: None }
    }

    /// The file's name, without folders.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Size of the full image in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The numbers of a layer.
    ///
    /// # Errors
    /// If there are none, why not.
    pub fn planes(&self, layer: Layer, name: &str) -> Result<Planes, String> {
        let Some(image) = &self.image else {
            return Err(format!("{} is no longer in memory. Open it again to compare with it.", self.name));
        };
        let channels: Option<Vec<usize>> = layer.channels().iter().map(|c| self.channel(image, *c)).collect();
        let channels = channels.ok_or_else(|| format!("{} has no layer \u{201c}{name}\u{201d}.", self.name))?;
        let data = channels.iter().flat_map(|&c| image.channels[c].1.iter().copied()).collect();
        Ok(Planes::new(layer, self.bounds, self.size, data))
    }

    /// The pixels there are numbers for, in coordinates of the full image.
    pub fn bounds(&self) -> PixelRect {
        self.bounds
    }

    /// The number of a pixel of the full image, if the file has one.
    pub fn value(&self, [x, y]: [u32; 2], channel: Channel) -> Option<f32> {
        let image = self.image.as_ref()?;
        let [left, top] = self.bounds.min;
        let inside = (left..self.bounds.max[0]).contains(&x) && (top..self.bounds.max[1]).contains(&y);
        let index = || (y - top) as usize * self.bounds.width() as usize + (x - left) as usize;
        inside.then(|| Some(image.channels[self.channel(image, channel)?].1[index()])).flatten()
    }

    fn channel(&self, image: &Image, channel: Channel) -> Option<usize> {
        let [r, g, b] = self.colours;
        match channel {
            Channel::R => Some(r),
            Channel::G => Some(g),
            Channel::B => Some(b),
            Channel::LightR
            | Channel::LightG
            | Channel::LightB
            | Channel::BsdfR
            | Channel::BsdfG
            | Channel::BsdfB
            | Channel::WeightLightY
            | Channel::WeightBsdfY
            | Channel::ShareLightY
            | Channel::VarianceY => image.channels.iter().position(|(name, _)| name == channel.exr_name()),
        }
    }
}

/// The layers that have red, green and blue, with the channels of these.
pub fn colours(image: &Image) -> Vec<(String, [usize; 3])> {
    let names: Vec<&str> = image.channels.iter().map(|(name, _)| name.as_str()).collect();
    let layers = layers_of(names.iter().copied()).into_iter();
    let of = layers.filter_map(|layer| {
        let find = |wanted: &str| {
            let is = |&&c: &&usize| layer_and_component(names[c]).1.eq_ignore_ascii_case(wanted);
            layer.channels.iter().find(is).copied()
        };
        Some((layer.name.clone(), [find("R")?, find("G")?, find("B")?]))
    });
    of.collect()
}

/// The first layer in colour, or else the first channel in grey.
fn usual_colours(image: &Image) -> Option<[usize; 3]> {
    colours(image).first().map(|(_, channels)| *channels).or((!image.channels.is_empty()).then_some([0; 3]))
}

/// Where the data window lies in the image that is shown, and the size of that: as large as both windows together.
pub fn place(image: &Image) -> (PixelRect, [u32; 2]) {
    let (data, display) = (image.window, image.display);
    let end = |w: &Window, axis: usize| i64::from(w.min[axis]) + i64::from(w.size[axis]);
    let min = [0, 1].map(|axis| data.min[axis].min(display.min[axis]));
    let size = [0, 1].map(|axis| end(&data, axis).max(end(&display, axis)) - i64::from(min[axis]));
    // A display window that has nothing to do with the pixels would leave them a speck.
    const LARGEST: i64 = 1 << 17;
    if size.iter().any(|&side| side > LARGEST) {
        return (PixelRect { min: [0, 0], max: data.size }, data.size);
    }
    let corner = [0, 1].map(|axis| (i64::from(data.min[axis]) - i64::from(min[axis])) as u32);
    let rect = PixelRect { min: corner, max: [0, 1].map(|axis| corner[axis] + data.size[axis]) };
    (rect, size.map(|side| side as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(names: &[&str]) -> Image {
        let window = Window { min: [0, 0], size: [2, 1] };
        let channels = names.iter().enumerate().map(|(i, n)| ((*n).to_owned(), vec![i as f32, 10.0 + i as f32]));
        Image { window, display: window, channels: channels.collect(), attributes: Vec::new() }
    }

    #[test]
    fn layers_are_found_by_name_and_what_is_missing_is_said() {
        let file = Foreign::new(Path::new("a/b.exr"), image(&["B", "G", "R", "variance.Y"]), None).expect("channels");
        let picture = file.planes(Layer::Picture, "Picture").expect("colours");
        assert_eq!(picture.value(1, 0), [12.0, 11.0, 10.0], "red first");
        assert_eq!(file.value([1, 0], Channel::VarianceY), Some(13.0));
        assert_eq!(file.value([2, 0], Channel::R), None, "outside");
        let missing = file.planes(Layer::Light, "Light technique").expect_err("no such layer");
        assert_eq!(missing, "b.exr has no layer \u{201c}Light technique\u{201d}.");
        let gone = file.emptied();
        assert!(gone.planes(Layer::Picture, "Picture").is_err_and(|why| why.contains("no longer in memory")));
        let grey = Foreign::new(Path::new("y.exr"), image(&["Y"]), None).expect("a channel");
        assert_eq!(grey.planes(Layer::Picture, "Picture").expect("grey").value(0, 0), [0.0; 3]);
        assert!(Foreign::new(Path::new("n.exr"), image(&[]), None).is_err());
    }
}
