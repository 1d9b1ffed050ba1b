//! False colours: tables from a number in [0, 1] to a colour, shared by the shader and the CPU path.

use std::sync::LazyLock;

/// The light technique's colour everywhere (Okabe-Ito orange), sRGB.
pub const LIGHT_TECHNIQUE: [u8; 3] = [0xE6, 0x9F, 0x00];
/// The BSDF technique's colour everywhere (Okabe-Ito blue), sRGB.
pub const BSDF_TECHNIQUE: [u8; 3] = [0x00, 0x72, 0xB2];

/// Ends of the map of what is signed: hues of no strategy.
const LESS: [u8; 3] = [0x8E, 0x6B, 0xD6];
/// See [`LESS`].
const MORE: [u8; 3] = [0xA3, 0xAD, 0x2B];

/// Entries of one table.
pub const TABLE_LEN: usize = 256;

/// A way to colour numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColourMap {
    /// From the BSDF technique's blue (0) through near-white (1/2) to the light technique's amber (1).
    TechniqueOnWhite,
    /// The same through near-black, for the dark theme.
    TechniqueOnBlack,
    /// viridis, by van der Walt, Smith and Firing: magnitudes.
    Viridis,
    /// From violet (0) through near-white (1/2) to olive (1): what is less and what is more.
    SignedOnWhite,
    /// The same through near-black.
    SignedOnBlack,
}

impl ColourMap {
    /// All maps, in the order of the rows of the shader's table.
    pub const ALL: [Self; 5] =
        [Self::TechniqueOnWhite, Self::TechniqueOnBlack, Self::Viridis, Self::SignedOnWhite, Self::SignedOnBlack];

    /// The diverging map of a theme.
    pub fn technique(dark: bool) -> Self {
        if dark { Self::TechniqueOnBlack } else { Self::TechniqueOnWhite }
    }

    /// The map of signed numbers of a theme.
    pub fn signed(dark: bool) -> Self {
        if dark { Self::SignedOnBlack } else { Self::SignedOnWhite }
    }

    /// Row of the map in the shader's table.
    pub fn row(self) -> u32 {
        match self {
            Self::TechniqueOnWhite => 0,
            Self::TechniqueOnBlack => 1,
            Self::Viridis => 2,
            Self::SignedOnWhite => 3,
            Self::SignedOnBlack => 4,
        }
    }

    /// The table: sRGB and alpha 255, the ends included.
    pub fn table(self) -> &'static [[u8; 4]; TABLE_LEN] {
        &TABLES[self.row() as usize]
    }

    /// The colour of `t`, clamped to [0, 1]: sRGB-encoded, in [0, 1], linear between table entries.
    pub fn at(self, t: f32) -> [f32; 3] {
        let position = t.clamp(0.0, 1.0) * (TABLE_LEN - 1) as f32;
        let first = (position as usize).min(TABLE_LEN - 2);
        let blend = position - first as f32;
        let table = self.table();
        let (a, b) = (table[first], table[first + 1]);
        [0, 1, 2].map(|i| (f32::from(a[i]) * (1.0 - blend) + f32::from(b[i]) * blend) / 255.0)
    }
}

static TABLES: LazyLock<[[[u8; 4]; TABLE_LEN]; 5]> = LazyLock::new(|| ColourMap::ALL.map(build));

fn build(map: ColourMap) -> [[u8; 4]; TABLE_LEN] {
    std::array::from_fn(|i| {
        let t = i as f64 / (TABLE_LEN - 1) as f64;
        let [r, g, b] = match map {
            ColourMap::TechniqueOnWhite => diverging([BSDF_TECHNIQUE, [0xF5; 3], LIGHT_TECHNIQUE], t),
            ColourMap::TechniqueOnBlack => diverging([BSDF_TECHNIQUE, [0x14; 3], LIGHT_TECHNIQUE], t),
            ColourMap::SignedOnWhite => diverging([LESS, [0xF5; 3], MORE], t),
            ColourMap::SignedOnBlack => diverging([LESS, [0x14; 3], MORE], t),
            ColourMap::Viridis => colorous::VIRIDIS.eval_continuous(t).as_array(),
        };
        [r, g, b, 255]
    })
}

/// Two straight lines in Oklab that meet at `middle`, so that either half is even in lightness and hue.
fn diverging([low, middle, high]: [[u8; 3]; 3], t: f64) -> [u8; 3] {
    let (from, to, blend) = if t < 0.5 { (low, middle, 2.0 * t) } else { (middle, high, 2.0 * t - 1.0) };
    let (from, to) = (oklab(from), oklab(to));
    srgb([0, 1, 2].map(|i| from[i] * (1.0 - blend) + to[i] * blend))
}

/// sRGB to Oklab (Ottosson 2020, "A perceptual color space for image processing").
fn oklab(colour: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = colour.map(|v| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    });
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    [
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    ]
}

/// The inverse of [`oklab`], rounded.
fn srgb([lightness, a, b]: [f64; 3]) -> [u8; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
    .map(|v| {
        let v = v.clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}
