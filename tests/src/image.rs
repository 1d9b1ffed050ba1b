//! Images on disk: the reference, and what a failed test leaves behind to look at.

use std::path::{Path, PathBuf};

use exr::prelude::*;

/// Channels of equal size by name, row by row from the top left.
#[derive(Clone, Debug)]
pub struct Image {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Names and values.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Image {
    /// Reads an EXR file.
    ///
    /// # Panics
    /// If it cannot be read or holds other than 32-bit floats.
    pub fn read(path: &Path) -> Self {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let size = image.layer_data.size;
        let channels = image.layer_data.channel_data.list.iter().map(|channel| match &channel.sample_data {
            FlatSamples::F32(values) => (channel.name.to_string(), values.clone()),
            _ => panic!("{}: channel {} is not of 32-bit floats", path.display(), channel.name),
        });
        Self { width: size.width(), height: size.height(), channels: channels.collect() }
    }

    /// The channel of that name.
    ///
    /// # Panics
    /// If there is none.
    pub fn channel(&self, name: &str) -> &[f32] {
        match self.channels.iter().find(|(n, _)| n == name) {
            Some((_, values)) => values,
            None => panic!("no channel {name}"),
        }
    }

    /// Writes the image as `NAME.exr` into the tests' temporary folder and returns its path.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn dump(&self, name: &str) -> PathBuf {
        // A test's executable lies in target/PROFILE/deps; target/tmp is for its files.
        let executable = std::env::current_exe().ok();
        let target = executable.as_deref().and_then(|path| path.ancestors().nth(3));
        let folder = target.map_or_else(std::env::temp_dir, |target| target.join("tmp"));
        std::fs::create_dir_all(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        let path = folder.join(format!("{name}.exr"));
        let list = self
            .channels
            .iter()
            .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values.clone())))
            .collect();
        let channels = AnyChannels::sort(list);
        let layer =
            Layer::new((self.width, self.height), LayerAttributes::default(), Encoding::FAST_LOSSLESS, channels);
        exr::prelude::Image::from_layer(layer)
            .write()
            .to_file(&path)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        path
    }
}
