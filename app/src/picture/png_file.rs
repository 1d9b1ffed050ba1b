//! PNG files of what is seen.

/// The bytes of an 8-bit, sRGB-encoded PNG. `rgba`: rows from the top left, four bytes each pixel.
///
/// # Errors
/// As the encoder, e.g. if `rgba` is not `width * height` pixels.
pub fn encode(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    encoder.write_header()?.write_image_data(rgba)?;
    Ok(bytes)
}
