//! Pictures as EXR files: saving a frame with everything that made it, and reading it back.
//!
//! A file is one part of 32-bit FLOAT channels, ZIP-compressed, the names as by
//! [`Channel::exr_name`]. The data window is the rendered rectangle, the display window the full
//! image. Readable attributes (`strategy`, `seed`, `samplesPerPixel`, `renderTimeSeconds` ...) are for people and for
//! other programs; the exact state lies in `mislabSettings` and `mislabScene` as JSON that restores every number bit for
//! bit, and in `mislabView`, a text of the caller's.

mod decode;
mod disk;
mod encode;
mod layers;
mod names;

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use mislab_kernel::request::{PixelRect, Request};

use crate::error::Error;
use crate::frame::{Frame, FrameStats};
use crate::layer::Channel;
use crate::memory::{self, Need};
pub use layers::{DEFAULT_LAYER, LayerChannels, layer_and_component, layers_of};

/// What this program calls itself in files (`software`).
pub const SOFTWARE: &str = concat!("MIS Lab ", env!("CARGO_PKG_VERSION"));

/// What a caller adds to a saved picture.
#[derive(Clone, Debug)]
pub struct SaveOptions {
    /// Free text (`comments`); left out if empty.
    pub comments: String,
    /// State of the view as a text of the caller's own (`mislabView`); handed back by [`restore`].
    pub view: Option<String>,
    /// Further text attributes, name and value. Names have 1 to 31 characters of ASCII letters, digits and `_`, start
    /// with a letter, and must not be names this module writes itself.
    pub attributes: Vec<(String, String)>,
    /// When the picture was made (`capDate`, in UTC); `None`: now.
    pub date: Option<SystemTime>,
    /// A scene whose JSON is longer is left out, with a notice in the file. Default: 64 MiB.
    pub max_scene_bytes: usize,
}

impl Default for SaveOptions {
    fn default() -> Self {
        Self { comments: String::new(), view: None, attributes: Vec::new(), date: None, max_scene_bytes: 64 << 20 }
    }
}

/// What [`save`] wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Saved {
    /// Size of the file.
    pub bytes: u64,
    /// Something the user should know: the scene was too large to be stored with the picture.
    pub notice: Option<String>,
}

/// Saves a frame as EXR. The file appears complete or not at all: on any failure an older file of that name stays as it
/// was.
///
/// # Errors
/// [`Error::Io`] if the folder or file cannot be written, [`Error::Invalid`] for an attribute name that cannot be used, or
/// if there is not enough memory.
pub fn save(frame: &Frame, path: &Path, options: &SaveOptions) -> Result<Saved, Error> {
    let (bytes, notice) = encode(frame, options)?;
    write_file(path, &bytes)?;
    Ok(Saved { bytes: bytes.len() as u64, notice })
}

/// The bytes of the file that [`save`] writes, and the notice of [`Saved`].
///
/// # Errors
/// As [`save`], less the file system.
pub fn encode(frame: &Frame, options: &SaveOptions) -> Result<(Vec<u8>, Option<String>), Error> {
    memory::check(&Need::of_saving(frame.bounds().area() as u64), 0).map_err(Error::Invalid)?;
    Contents::from_frame(frame).encode(options)
}

/// Everything that goes into a file, apart from how it came about.
#[derive(Clone, Debug)]
pub struct Contents {
    /// Scene and settings.
    pub request: Arc<Request>,
    /// The pixels in `layers`, in coordinates of the full image.
    pub bounds: PixelRect,
    /// Passes.
    pub spp: u32,
    /// Work.
    pub stats: FrameStats,
    /// Channel names as in the file, each with `bounds.area()` values, row by row from the top left.
    pub layers: Vec<(String, Vec<f32>)>,
}

impl Contents {
    /// All channels of a frame.
    pub fn from_frame(frame: &Frame) -> Self {
        Self {
            request: Arc::clone(frame.request()),
            bounds: frame.bounds(),
            spp: frame.spp(),
            stats: frame.stats(),
            layers: Channel::ALL.map(|c| (c.exr_name().to_owned(), frame.channel(c))).into(),
        }
    }

    /// The bytes of the file, and the notice of [`Saved`]. The same contents and options (with a date) give the same bytes.
    ///
    /// # Errors
    /// As [`save`], less the file system.
    pub fn encode(self, options: &SaveOptions) -> Result<(Vec<u8>, Option<String>), Error> {
        encode::encode(self, options)
    }

    /// As [`save`].
    ///
    /// # Errors
    /// As [`save`].
    pub fn save(self, path: &Path, options: &SaveOptions) -> Result<Saved, Error> {
        let (bytes, notice) = self.encode(options)?;
        write_file(path, &bytes)?;
        Ok(Saved { bytes: bytes.len() as u64, notice })
    }
}

/// Replaces the file at `path` by `bytes`: written beside it, synced, then renamed, so that the file is complete or the
/// old one is untouched. Pipes and devices are written to directly.
///
/// # Errors
/// [`Error::Io`].
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    disk::write_file(path, bytes)
}

/// As [`write_file`], but never over anything that is there: false, and nothing is written, if the name is taken.
///
/// # Errors
/// As [`write_file`].
pub fn write_new_file(path: &Path, bytes: &[u8]) -> Result<bool, Error> {
    disk::write_new_file(path, bytes)
}

/// A rectangle of an EXR file: position of the top left pixel and size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Window {
    /// Left and top; may be negative in files of other programs.
    pub min: [i32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Window {
    /// The pixels of both; `None` where there are none.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let end = |w: &Self, axis: usize| i64::from(w.min[axis]) + i64::from(w.size[axis]);
        let min = [0, 1].map(|axis| self.min[axis].max(other.min[axis]));
        let size = [0, 1].map(|axis| end(self, axis).min(end(other, axis)) - i64::from(min[axis]));
        let [width, height] = size.map(|n| u32::try_from(n).ok().filter(|n| *n > 0));
        Some(Self { min, size: [width?, height?] })
    }

    /// Number of pixels.
    pub fn area(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} x {} at ({} {})", self.size[0], self.size[1], self.min[0], self.min[1])
    }
}

/// The pixels of an EXR file, of this program or another.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The pixels there are.
    pub window: Window,
    /// The image they are part of.
    pub display: Window,
    /// Full channel names ("R", "light.G"), sorted by name, each with `window`'s area of values, row by row from the top
    /// left. HALF and UINT are converted to `f32`.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Attributes as text, sorted by name.
    pub attributes: Vec<(String, String)>,
}

impl Image {
    /// The values of a channel.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }

    /// The values of a channel in a part of the image.
    ///
    /// # Panics
    /// If the part reaches beyond [`Self::window`].
    pub fn part<'a>(&self, values: &'a [f32], part: Window) -> Cow<'a, [f32]> {
        if part == self.window {
            return Cow::Borrowed(values);
        }
        let [left, top] = [0, 1].map(|axis| (part.min[axis] - self.window.min[axis]) as usize);
        let [width, height] = part.size.map(|n| n as usize);
        let rows = values.chunks_exact(self.window.size[0] as usize).skip(top).take(height);
        let part: Vec<f32> = rows.flat_map(|row| &row[left..left + width]).copied().collect();
        assert_eq!(part.len(), width * height, "the part is inside the image");
        Cow::Owned(part)
    }

    /// The text of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, text)| text.as_str())
    }
}

/// Reads any EXR file, of several parts the first, of scan lines or tiles (FLOAT, HALF or UINT, no subsampling; the largest level of a
/// mip map).
///
/// # Errors
/// [`Error::Io`] if it cannot be read, [`Error::File`] if it is not such a file, is damaged, or would take more than
/// [`MAX_IMAGE_BYTES`].
pub fn load_image(path: &Path) -> Result<Image, Error> {
    decode::load_image(path)
}

/// Most bytes of pixels that [`load_image`] takes: the largest picture of this program.
pub const MAX_IMAGE_BYTES: u64 = crate::Settings::MAX_PIXELS * 4 * crate::Channel::ALL.len() as u64;

/// The state a file was saved in.
#[derive(Clone, Debug)]
pub struct Restored {
    /// Scene and settings as they were. `settings.sampling.spp` is the target, which the picture may not have reached.
    pub request: Request,
    /// Passes of the picture in the file.
    pub spp: u32,
    /// The caller's text of [`SaveOptions::view`].
    pub view: Option<String>,
    /// What wrote the file, e.g. "MIS Lab 0.1.0".
    pub software: String,
}

impl Restored {
    /// The request that renders the picture of the file, bit for bit: its target is the number of passes in the file.
    pub fn picture_request(&self) -> Request {
        let mut request = self.request.clone();
        request.settings.sampling.spp = std::num::NonZeroU32::new(self.spp);
        request
    }
}

/// Reads the state a file was saved in, without decoding its pixels. Everything is checked.
///
/// # Errors
/// [`Error::Io`] if it cannot be read, [`Error::File`] if it is no EXR file, was written by another program or a newer
/// version, holds no scene (too large when saved) or settings that are out of range.
pub fn restore(path: &Path) -> Result<Restored, Error> {
    decode::restore(path)
}

/// What an EXR file says about itself.
#[derive(Debug)]
pub struct Info {
    /// Its parts; most files have one.
    pub parts: Vec<Part>,
    /// The state it was saved in; `None` if another program wrote it, an error if the state cannot be used.
    pub restored: Result<Option<Restored>, Error>,
}

/// One picture of an EXR file, of whatever kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What it is called; files of one part mostly have no name for it.
    pub name: Option<String>,
    /// The pixels there are: the data window.
    pub window: Window,
    /// The image they are part of: the display window.
    pub display: Window,
    /// A pixel holds samples at many depths.
    pub deep: bool,
    /// In the order of the file.
    pub channels: Vec<ChannelInfo>,
    /// Every attribute as text, sorted by name; `mislabSettings`, `mislabScene` and `mislabView` among them, in full.
    pub attributes: Vec<(String, String)>,
}

/// A channel as the file announces it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Its full name.
    pub name: String,
    /// "FLOAT", "HALF" or "UINT".
    pub kind: &'static str,
    /// A value for every so many pixels along x and y; 1 and 1 but for subsampled colour.
    pub sampling: [usize; 2],
}

/// Reads what any EXR file says about itself, without decoding its pixels: channels, windows and attributes of all parts.
///
/// # Errors
/// [`Error::Io`] if it cannot be read, [`Error::File`] if it is no such file.
pub fn info(path: &Path) -> Result<Info, Error> {
    decode::info(path)
}

/// A name or value from a file for people: on one line, without control characters, which a terminal would obey. Long
/// values are for programs: only their length.
pub fn shown(text: &str) -> String {
    const LONGEST: usize = 400;
    if text.len() > LONGEST {
        return format!("({} bytes)", text.len());
    }
    let plain = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(plain).collect()
}
