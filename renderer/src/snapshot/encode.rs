//! From a picture to the bytes of a file.

use std::collections::HashMap;
use std::io::Cursor;
use std::time::{SystemTime, UNIX_EPOCH};

use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, FloatRect, IntegerBounds, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes, standard_names};

use super::{Contents, SaveOptions, names};
use crate::error::Error;

/// The bytes of the file, and the notice about a scene left out.
pub(super) fn encode(contents: Contents, options: &SaveOptions) -> Result<(Vec<u8>, Option<String>), Error> {
    let (bounds, [width, height]) = (contents.bounds, contents.request.settings.image.resolution);
    if bounds.max[0] > width || bounds.max[1] > height || bounds.area() == 0 {
        return Err(Error::Invalid(format!(
            "pixels {:?} to {:?}, expected at least one, inside the image of {width} x {height}",
            bounds.min, bounds.max
        )));
    }
    if let Some((name, values)) = contents.layers.iter().find(|(_, values)| values.len() != bounds.area()) {
        return Err(Error::Invalid(format!("channel {name} has {} values, expected {}", values.len(), bounds.area())));
    }

    let (other, notice) = attributes(&contents, options)?;
    let layer_attributes = LayerAttributes {
        layer_position: Vec2(bounds.min[0] as i32, bounds.min[1] as i32),
        software_name: Some(Text::new_or_panic(super::SOFTWARE)),
        comments: (!options.comments.is_empty()).then(|| text("comments", &options.comments)).transpose()?,
        capture_date: Some(text("capDate", &exr_date(options.date.unwrap_or_else(SystemTime::now)))?),
        utc_offset: Some(0.0),
        other,
        ..LayerAttributes::default()
    };
    let channels = contents.layers.into_iter().map(|(name, values)| AnyChannel {
        name: Text::from_slice_unchecked(name.as_bytes()),
        sample_data: FlatSamples::F32(values),
        quantize_linearly: false,
        sampling: Vec2(1, 1),
    });
    let layer = Layer::new(
        (bounds.width() as usize, bounds.height() as usize),
        layer_attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    let mut image = Image::from_layer(layer);
    image.attributes = ImageAttributes {
        chromaticities: Some(REC709),
        ..ImageAttributes::new(IntegerBounds::from_dimensions((width as usize, height as usize)))
    };
    let mut bytes = Vec::new();
    image
        .write()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|e| Error::Invalid(format!("the picture cannot be encoded as EXR: {e}")))?;
    sort_attributes(&mut bytes);
    Ok((bytes, notice))
}

/// Primaries and white point D65 of ITU-R BT.709.
const REC709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Our own attributes and the caller's, and the notice about a scene left out.
fn attributes(
    contents: &Contents,
    options: &SaveOptions,
) -> Result<(HashMap<Text, AttributeValue>, Option<String>), Error> {
    use AttributeValue::{F32, FloatRect as Rect, I32, IntVec2};

    let (scene, settings, stats) = (&contents.request.scene, &contents.request.settings, &contents.stats);
    let mut map = HashMap::new();
    let mut put = |name: &str, value: AttributeValue| map.insert(Text::new_or_panic(name), value);
    let string = |name: &str, value: &str| text(name, value).map(AttributeValue::Text);
    let integer = |value: usize| I32(i32::try_from(value).unwrap_or(i32::MAX));

    for (name, value) in &options.attributes {
        check_name(name)?;
        if put(name, string(name, value)?).is_some() {
            return Err(Error::Invalid(format!("two attributes named `{name}`")));
        }
    }
    put(names::SCENE_NAME, string(names::SCENE_NAME, &scene.name)?);
    put(names::STRATEGY, string(names::STRATEGY, settings.estimator.strategy.name())?);
    put(names::LIGHT_PROB, F32(settings.estimator.light_prob));
    put(names::HEURISTIC, string(names::HEURISTIC, settings.estimator.heuristic.name())?);
    put(names::WEIGHTS, string(names::WEIGHTS, settings.estimator.weights.name())?);
    put(names::SAMPLER, string(names::SAMPLER, settings.sampling.sampler.kind.name())?);
    put(
        names::STRATA,
        IntVec2(Vec2(settings.sampling.sampler.strata[0] as i32, settings.sampling.sampler.strata[1] as i32)),
    );
    put(names::JITTER, I32(settings.sampling.sampler.jitter.into()));
    // As text what can be larger than EXR's signed 32-bit integers.
    put(names::SEED, string(names::SEED, &settings.sampling.seed.to_string())?);
    let [x0, x1, y0, y1] = settings.image.crop;
    put(names::CROP, Rect(FloatRect { min: Vec2(x0, y0), max: Vec2(x1, y1) }));
    put(names::SPP, integer(contents.spp as usize));
    put(names::RENDER_SECONDS, F32(stats.render_seconds as f32));
    put(names::CPU_SECONDS, F32(stats.cpu_seconds as f32));
    put(names::PATHS, string(names::PATHS, &stats.paths.to_string())?);
    put(names::THREADS, integer(stats.threads));
    put(names::SIMD, string(names::SIMD, stats.simd)?);
    put(names::INVALID_SAMPLES, string(names::INVALID_SAMPLES, &stats.invalid_samples.to_string())?);

    put(names::FORMAT_NAME, I32(names::FORMAT));
    put(names::SETTINGS, string(names::SETTINGS, &json(settings)?)?);
    if let Some(view) = &options.view {
        put(names::VIEW, string(names::VIEW, view)?);
    }
    let scene = json(&**scene)?;
    let notice = (scene.len() > options.max_scene_bytes).then(|| {
        format!(
            "the scene takes {} bytes, more than the {} stored with a picture: it was left out, open its scene file instead",
            scene.len(),
            options.max_scene_bytes
        )
    });
    match &notice {
        None => put(names::SCENE, string(names::SCENE, &scene)?),
        Some(why) => put(names::SCENE_MISSING, string(names::SCENE_MISSING, why)?),
    };
    Ok((map, notice))
}

/// serde_json writes the shortest digits that read back as the same bits.
fn json<T: serde::Serialize>(value: &T) -> Result<String, Error> {
    serde_json::to_string(value).map_err(|e| Error::Invalid(format!("the state cannot be stored: {e}")))
}

/// A string attribute, in UTF-8 as other programs do.
fn text(name: &str, value: &str) -> Result<Text, Error> {
    const LONGEST: usize = 256 << 20;
    if value.contains('\0') || value.len() > LONGEST {
        return Err(Error::Invalid(format!(
            "attribute `{name}` of {} bytes, expected at most {LONGEST} and no NUL character",
            value.len()
        )));
    }
    Ok(Text::from_slice_unchecked(value.as_bytes()))
}

/// Refuses names that OpenEXR or this module would misunderstand.
fn check_name(name: &str) -> Result<(), Error> {
    let starts_well = name.starts_with(|c: char| c.is_ascii_alphabetic());
    let clean = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !starts_well || !clean || name.len() > 31 {
        return Err(Error::Invalid(format!(
            "attribute name `{name}`, expected 1 to 31 letters, digits and `_` that start with a letter"
        )));
    }
    if names::RESERVED.contains(&name) || standard_names::ALL.contains(&name.as_bytes()) {
        return Err(Error::Invalid(format!("attribute name `{name}` has a meaning of its own, expected another")));
    }
    Ok(())
}

/// EXR's `YYYY:MM:DD hh:mm:ss`, in UTC.
fn exr_date(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, second) = (seconds / 86400, seconds % 86400);
    // Days to a civil date: years begin in March, so that leap days come last; 146097 days are 400 years
    // (Howard Hinnant, "chrono-compatible low-level date algorithms").
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}:{month:02}:{day:02} {:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60)
}

/// Sorts the attributes of an encoded file by name: the `exr` crate keeps them in a hash map and writes them in an order
/// that differs from run to run. Their total length, and so every offset in the file, stays the same.
fn sort_attributes(file: &mut [u8]) {
    const MAGIC_AND_VERSION: usize = 8;
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut at = MAGIC_AND_VERSION;
    while file[at] != 0 {
        // name, NUL, type, NUL, length (4 bytes, little endian), value
        let name = file[at..].iter().position(|&b| b == 0).expect("the encoder ends every name") + 1;
        let kind = file[at + name..].iter().position(|&b| b == 0).expect("the encoder ends every type") + 1;
        let length_at = at + name + kind;
        let length = file[length_at..length_at + 4].try_into().map(i32::from_le_bytes).expect("four bytes");
        let end = length_at + 4 + length as usize;
        attributes.push(file[at..end].to_vec());
        at = end;
    }
    attributes.sort();
    file[MAGIC_AND_VERSION..at].copy_from_slice(&attributes.concat());
}
