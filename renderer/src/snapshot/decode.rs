//! From a file to its header, its pixels and the state it was saved in. Nothing in a file is believed.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Seek};
use std::path::Path;

use exr::image::FlatSamples;
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::read::read;
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, ChannelDescription, IntegerBounds, SampleType, Text};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Request, Settings};
use mislab_kernel::world;

use super::{ChannelInfo, Image, MAX_IMAGE_BYTES, Part, Restored, Window, names};
use crate::error::Error;
use crate::file;
use crate::memory::{self, Need};

/// See [`super::load_image`].
pub(super) fn load_image(path: &Path) -> Result<Image, Error> {
    let (meta, mut file) = open(path)?;
    let header = flat_part(path, meta)?;
    check_size(path, &header, &file)?;
    file.rewind().map_err(|e| Error::io(path, "read", e))?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(BufReader::new(file))
        .map_err(|e| damaged(path, e))?;
    let channels = image.layer_data.channel_data.list.into_iter().map(|channel| {
        let values = match channel.sample_data {
            FlatSamples::F32(values) => values,
            FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
            FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
        };
        (name_of(channel.name.as_slice()), values)
    });
    let mut channels: Vec<(String, Vec<f32>)> = channels.collect();
    channels.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(Image {
        window: window(header.data_window()),
        display: window(header.shared_attributes.display_window),
        channels,
        attributes: attributes(&header),
    })
}

/// See [`super::info`].
pub(super) fn info(path: &Path) -> Result<super::Info, Error> {
    let (meta, _) = open(path)?;
    let parts = meta.headers.iter().map(part).collect();
    let restored = match meta.headers.first() {
        Some(header) if meta.headers.len() == 1 && is_ours(header) => restore_from(path, header).map(Some),
        _ => Ok(None),
    };
    Ok(super::Info { parts, restored })
}

/// See [`super::restore`].
pub(super) fn restore(path: &Path) -> Result<Restored, Error> {
    let (meta, _) = open(path)?;
    restore_from(path, &flat_part(path, meta)?)
}

/// What a file says, whatever it holds.
fn open(path: &Path) -> Result<(MetaData, File), Error> {
    let (file, metadata) = file::open(path, "an EXR file")?;
    if metadata.len() == 0 {
        return Err(Error::file(path, "the file is empty, expected an EXR file"));
    }
    let meta = MetaData::read_from_buffered(BufReader::new(&file), false).map_err(|e| damaged(path, e))?;
    // The crate turns the count into a signed 32-bit attribute and panics beyond.
    if let Some(header) = meta.headers.iter().find(|header| i32::try_from(header.chunk_count).is_err()) {
        return Err(Error::file(path, format!("{} blocks of pixels, more than a file can hold", header.chunk_count)));
    }
    Ok((meta, file))
}

/// The header of the first part of a flat file.
fn flat_part(path: &Path, mut meta: MetaData) -> Result<Header, Error> {
    if meta.headers.is_empty() {
        return Err(Error::file(path, "an EXR file without parts, expected at least one"));
    }
    let header = meta.headers.remove(0);
    if header.deep || meta.requirements.has_deep_data {
        return Err(Error::file(path, "an EXR file of deep pixels, expected flat ones"));
    }
    Ok(header)
}

fn part(header: &Header) -> Part {
    let channel = |c: &ChannelDescription| ChannelInfo {
        name: name_of(c.name.as_slice()),
        kind: match c.sample_type {
            SampleType::F32 => "FLOAT",
            SampleType::F16 => "HALF",
            SampleType::U32 => "UINT",
        },
        sampling: [c.sampling.0, c.sampling.1],
    };
    Part {
        name: header.own_attributes.layer_name.as_ref().map(|name| name_of(name.as_slice())),
        window: window(header.data_window()),
        display: window(header.shared_attributes.display_window),
        deep: header.deep,
        channels: header.channels.list.iter().map(channel).collect(),
        attributes: attributes(header),
    }
}

/// Refuses, before any memory is asked for, what the file cannot hold or we do not want to.
fn check_size(path: &Path, header: &Header, file: &File) -> Result<(), Error> {
    let length = file.metadata().map_err(|e| Error::io(path, "read", e))?.len();
    let Vec2(width, height) = header.layer_size;
    let samples = (width as u64).saturating_mul(height as u64).saturating_mul(header.channels.list.len() as u64);
    let bytes = samples.saturating_mul(4);
    if samples == 0 || bytes > MAX_IMAGE_BYTES {
        return Err(Error::file(
            path,
            format!(
                "{width} x {height} pixels of {} channels, expected at least one of each and at most {MAX_IMAGE_BYTES} bytes",
                header.channels.list.len()
            ),
        ));
    }
    // Once as they are decoded, once as floats.
    memory::check(&Need::of_file(2 * bytes), 0).map_err(|message| Error::file(path, message))?;
    if let Some(channel) = header.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        let name = name_of(channel.name.as_slice());
        return Err(Error::file(path, format!("channel {name} is subsampled, expected a value for every pixel")));
    }
    // Every block has an offset of 8 bytes, 4 of position and 4 of length.
    if (header.chunk_count as u64).saturating_mul(16) > length {
        return Err(Error::file(
            path,
            format!("{length} bytes, too few for its {width} x {height} pixels: the file is cut off or damaged"),
        ));
    }
    if let BlockDescription::Tiles(tiles) = header.blocks {
        let Vec2(w, h) = tiles.tile_size;
        let block = (w as u64).saturating_mul(h as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
        if block > MAX_IMAGE_BYTES {
            return Err(Error::file(
                path,
                format!("tiles of {w} x {h} pixels, expected at most {MAX_IMAGE_BYTES} bytes"),
            ));
        }
    }
    Ok(())
}

fn damaged(path: &Path, error: exr::error::Error) -> Error {
    /// What the library says of a file that is shorter than it claims.
    const SHORT: &str = "reference to missing bytes";
    match error {
        exr::error::Error::Io(e) if e.kind() != ErrorKind::UnexpectedEof => Error::io(path, "read", e),
        error if matches!(error, exr::error::Error::Io(_)) || error.to_string().contains(SHORT) => {
            Error::file(path, "the file ends early: it is cut off or damaged, or no EXR file")
        }
        other => Error::file(path, format!("not an EXR file that can be read, or damaged: {other}")),
    }
}

fn name_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn window(bounds: IntegerBounds) -> Window {
    let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    Window { min: [bounds.position.0, bounds.position.1], size: [size(bounds.size.0), size(bounds.size.1)] }
}

/// All attributes as text, sorted by name.
fn attributes(header: &Header) -> Vec<(String, String)> {
    let mut list: Vec<_> = header.all_named_attributes().map(|(n, value)| (name_of(n), describe(&value))).collect();
    list.sort();
    list
}

/// An attribute's value for people.
fn describe(value: &AttributeValue) -> String {
    use AttributeValue as A;
    match value {
        A::Text(t) => name_of(t.as_slice()),
        A::TextVector(list) => list.iter().map(|t| name_of(t.as_slice())).collect::<Vec<_>>().join(", "),
        A::F32(v) => v.to_string(),
        A::F64(v) => v.to_string(),
        A::I32(v) => v.to_string(),
        A::IntVec2(v) => format!("{} {}", v.0, v.1),
        A::FloatVec2(v) => format!("{} {}", v.0, v.1),
        A::IntVec3((x, y, z)) => format!("{x} {y} {z}"),
        A::FloatVec3((x, y, z)) => format!("{x} {y} {z}"),
        A::FloatRect(r) => format!("({} {}) - ({} {})", r.min.0, r.min.1, r.max.0, r.max.1),
        A::IntegerBounds(b) => window(*b).to_string(),
        A::Chromaticities(c) => format!(
            "red ({} {}) green ({} {}) blue ({} {}) white ({} {})",
            c.red.0, c.red.1, c.green.0, c.green.1, c.blue.0, c.blue.1, c.white.0, c.white.1
        ),
        A::ChannelList(list) => {
            let describe = |c: &ChannelDescription| format!("{} {:?}", name_of(c.name.as_slice()), c.sample_type);
            list.list.iter().map(describe).collect::<Vec<_>>().join(", ")
        }
        // Without the quality that a file does not hold: "DWAA(None)".
        A::Compression(c) => format!("{c:?}").split('(').next().unwrap_or_default().to_owned(),
        A::LineOrder(order) => format!("{order:?}"),
        A::BlockType(kind) => format!("{kind:?}"),
        A::EnvironmentMap(map) => format!("{map:?}"),
        A::Rational((n, d)) => format!("{n}/{d}"),
        A::Matrix3x3(m) => numbers(m),
        A::Matrix4x4(m) => numbers(m),
        A::Preview(p) => format!("preview of {} x {}", p.size.0, p.size.1),
        A::Bytes { type_hint, bytes } => format!("{} bytes of {}", bytes.len(), name_of(type_hint.as_slice())),
        A::Custom { kind, bytes } => format!("{} bytes of {}", bytes.len(), name_of(kind.as_slice())),
        other => format!("{other:?}"),
    }
}

fn numbers(values: &[f32]) -> String {
    values.iter().map(f32::to_string).collect::<Vec<_>>().join(" ")
}

/// There is something of ours to restore.
fn is_ours(header: &Header) -> bool {
    [names::SETTINGS, names::FORMAT_NAME]
        .iter()
        .any(|name| header.own_attributes.other.contains_key(&Text::new_or_panic(name)))
}

/// The state in a header of our own, checked.
fn restore_from(path: &Path, header: &Header) -> Result<Restored, Error> {
    let attribute = |name: &str| header.own_attributes.other.get(&Text::new_or_panic(name));
    let text = |name: &str| match attribute(name) {
        Some(AttributeValue::Text(t)) => std::str::from_utf8(t.as_slice())
            .map(Some)
            .map_err(|_| Error::file(path, format!("attribute {name} is not text in UTF-8"))),
        Some(_) => Err(Error::file(path, format!("attribute {name} is not a string"))),
        None => Ok(None),
    };
    let Some(settings) = text(names::SETTINGS)? else {
        return Err(Error::file(path, format!("was not written by MIS Lab: no attribute {}", names::SETTINGS)));
    };
    let format = match attribute(names::FORMAT_NAME) {
        Some(AttributeValue::I32(format @ 1..=names::FORMAT)) => *format,
        Some(AttributeValue::I32(newer)) if *newer > names::FORMAT => {
            return Err(Error::file(
                path,
                format!("written by a newer MIS Lab (format {newer}), this one reads format {}", names::FORMAT),
            ));
        }
        _ => return Err(Error::file(path, format!("no valid {}, expected {}", names::FORMAT_NAME, names::FORMAT))),
    };
    let settings =
        read_settings(settings, format).map_err(|m| Error::file(path, format!("{}: {m}", names::SETTINGS)))?;
    let Some(scene) = text(names::SCENE)? else {
        let why = text(names::SCENE_MISSING)?.unwrap_or("no attribute mislabScene");
        return Err(Error::file(path, format!("holds no scene: {why}")));
    };
    let invalid = |message: String| Error::file(path, format!("{}: {message}", names::SCENE));
    let scene: Scene = serde_json::from_str(scene).map_err(|e| invalid(e.to_string()))?;
    // The renderer is the judge of what can be rendered.
    world::check(&scene, &settings).map_err(|e| invalid(e.to_string()))?;
    let spp = match attribute(names::SPP) {
        Some(AttributeValue::I32(spp)) if *spp > 0 => *spp as u32,
        _ => return Err(Error::file(path, format!("no valid {}, expected an integer above 0", names::SPP))),
    };
    let software = header.own_attributes.software_name.as_ref().map(|t| name_of(t.as_slice())).unwrap_or_default();
    Ok(Restored {
        request: Request { scene: scene.into(), settings },
        spp,
        view: text(names::VIEW)?.map(str::to_owned),
        software,
    })
}

fn read_settings(json: &str, format: i32) -> Result<Settings, String> {
    let mut found: serde_json::Value = serde_json::from_str(json).map_err(|e| e.to_string())?;
    if format == 1
        && let Some(kind) = found.pointer_mut("/sampler/kind")
        && let Some(now) = kind.as_str().and_then(sampler_of_format_1)
    {
        *kind = now.into();
    }
    // From text, not from the value: a number of single precision takes another way through a double.
    let settings: Settings = serde_json::from_str(&found.to_string()).map_err(|e| e.to_string())?;
    // A setting we do not know would be lost silently, and with it the promise of the same bits.
    let known = serde_json::to_value(&settings).map_err(|e| e.to_string())?;
    if let (Some(known), Some(found)) = (known.as_object(), found.as_object())
        && let Some(name) = found.keys().find(|name| !known.contains_key(*name))
    {
        return Err(format!("unknown setting `{name}`"));
    }
    settings.check()?;
    Ok(settings)
}

/// What a sampler of format 1 is called now, if that is not the same: those names went to better patterns.
fn sampler_of_format_1(name: &str) -> Option<&'static str> {
    match name {
        "stratified" => Some("padded_stratified"),
        "sobol" => Some("padded_sobol"),
        "strata_lattice" => Some("stratified"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use mislab_kernel::request::SamplerKind;

    use super::*;

    #[test]
    fn a_name_of_format_1_means_the_pattern_it_meant_then() {
        use SamplerKind::{Independent, Lattice, PaddedSobol, PaddedStratified, Sobol, Stratified};
        for (name, then, now) in [
            ("stratified", PaddedStratified, Some(Stratified)),
            ("sobol", PaddedSobol, Some(Sobol)),
            ("strata_lattice", Stratified, None),
            ("lattice", Lattice, Some(Lattice)),
            ("independent", Independent, Some(Independent)),
        ] {
            let json = serde_json::to_string(&Settings::default()).expect("settings can be written");
            let json = json.replace("\"stratified\"", &format!("\"{name}\""));
            let kind = |format| read_settings(&json, format).ok().map(|settings| settings.sampling.sampler.kind);
            assert_eq!([kind(1), kind(2)], [Some(then), now], "{name}");
        }
    }
}
