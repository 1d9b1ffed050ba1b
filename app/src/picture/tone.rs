//! From a number in a layer to a colour on screen: the CPU twin of `display.wgsl`.
//!
//! Every function here has its counterpart of the same name in the shader; a test holds the two
//! together within one step of 8 bits.

use bytemuck::{Pod, Zeroable};
use eframe::egui::Color32;
use mislab_renderer::Technique;

use crate::look::colormap::ColourMap;
use crate::look::layer::{Colouring, LayerLook, Quantity};
use crate::look::versus::Versus;
use crate::picture::planes::{BLIND, Planes, UNHIT, UNLIT};
use crate::state::placement::Geometry;
use crate::state::view::{ToneMap, ViewState};

/// Width of one pair of hatch stripes along a row, in points.
pub const HATCH_PERIOD: f32 = 10.0;

/// Periods of stripes beyond the height of any window.
const CROSSED_PERIODS: f32 = 2048.0;

/// How far a stale picture fades into the surround.
const STALE_FADE: f32 = 0.55;

/// How far outside [0, 1] a weight may lie by rounding alone.
const WEIGHT_SLACK: f32 = 1e-3;

/// The neutral grey round the picture, the same at every zoom.
pub fn surround(dark: bool) -> Color32 {
    Color32::from_gray(if dark { 38 } else { 208 })
}

/// The two greys of the hatching of undefined pixels.
pub fn hatch(dark: bool) -> [Color32; 2] {
    let [a, b] = if dark { [52, 88] } else { [214, 170] };
    [Color32::from_gray(a), Color32::from_gray(b)]
}

/// The same in the picture of a quantity: black is nothing in colours, and dark what has no light yet.
pub fn hatch_of(quantity: Quantity, dark: bool) -> [Color32; 2] {
    if LayerLook::of(quantity).is_colour() { [Color32::BLACK, Color32::from_gray(40)] } else { hatch(dark) }
}

/// A number that cannot be: infinite, negative where nothing negative exists, or NaN in a colour.
pub const INVALID: Color32 = Color32::from_rgb(255, 0, 0);

/// What the shader is told. All positions are physical pixels from the viewport's top left corner.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Uniforms {
    /// The viewport's top left corner in the framebuffer.
    viewport: [f32; 2],
    /// The full image's top left corner.
    origin: [f32; 2],
    /// Pixels of the frame in coordinates of the full image: left, top, right, bottom.
    bounds: [f32; 4],
    /// Image pixels per physical pixel.
    inv_scale: f32,
    /// 2^EV.
    gain: f32,
    /// Added after the gain.
    offset: f32,
    /// [`Kind`].
    kind: u32,
    /// Index in [`ToneMap::ALL`].
    tone_map: u32,
    /// Index in [`ColourMap::ALL`], the row of the table.
    row: u32,
    /// Position in the table is `slope * x + intercept`, x the number or its log10.
    slope: f32,
    intercept: f32,
    /// Hatch stripes per physical pixel along a row.
    hatch_frequency: f32,
    /// 0 a valid picture, 1 a stale one.
    stale: f32,
    /// Exposed numbers above this are striped.
    clipped_from: f32,
    /// Colours lie at multiples of 16 bytes.
    padding: u32,
    surround: [f32; 4],
    hatch_a: [f32; 4],
    hatch_b: [f32; 4],
    invalid: [f32; 4],
}

/// What the numbers of a layer are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Colour = 0,
    Weight = 1,
    Magnitude = 2,
    Signed = 3,
}

impl Uniforms {
    /// For `planes` as `view` wants them, at `geometry`. The layer is that of `planes`.
    pub fn new(planes: &Planes, view: &ViewState, geometry: &Geometry, dark: bool) -> Self {
        let corner = [0, 1].map(|i| (geometry.viewport.min[i] * geometry.pixels_per_point).round());
        let quantity = planes.quantity();
        let (slope, intercept) = table_position(quantity, view);
        let finite = |v: f32| if v.is_finite() { v } else { 0.0 };
        let bounds = planes.bounds();
        let encoded = |c: Color32| c.to_array().map(|v| f32::from(v) / 255.0);
        let [hatch_a, hatch_b] = hatch_of(quantity, dark).map(encoded);
        Self {
            viewport: corner,
            origin: [0, 1].map(|i| geometry.origin[i] - corner[i]),
            bounds: [bounds.min[0], bounds.min[1], bounds.max[0], bounds.max[1]].map(|v| v as f32),
            inv_scale: geometry.scale.recip(),
            gain: finite(view.exposure_ev).clamp(-ViewState::MAX_EV, ViewState::MAX_EV).exp2(),
            offset: finite(view.offset),
            kind: kind(quantity) as u32,
            tone_map: ToneMap::ALL.iter().position(|map| *map == view.tone_map).unwrap_or(0) as u32,
            row: colour_map(quantity, dark).row(),
            slope,
            intercept,
            hatch_frequency: (HATCH_PERIOD * geometry.pixels_per_point).recip(),
            stale: 0.0,
            clipped_from: if view.mark_clipped { clipped_from(view.tone_map) } else { f32::MAX },
            padding: 0,
            surround: encoded(surround(dark)),
            hatch_a,
            hatch_b,
            invalid: encoded(INVALID),
        }
    }

    /// The same picture as one of older settings: 0 not at all, 1 as faded as it gets.
    pub fn with_stale(self, stale: f32) -> Self {
        Self { stale, ..self }
    }

    /// The same but for where the viewport is on the screen.
    pub fn same_canvas(&self, other: &Self) -> bool {
        Self { viewport: other.viewport, ..*self } == *other
    }

    /// Number of the kind, and of the tone map where that makes a difference: what the shader is compiled for.
    pub fn variant(&self) -> [u32; 2] {
        [self.kind, if self.kind == Kind::Colour as u32 { self.tone_map } else { 0 }]
    }

    /// The same picture with `factor` by `factor` physical pixels drawn as one.
    pub fn coarser(self, factor: f32) -> Self {
        Self {
            origin: self.origin.map(|v| (v / factor).round()),
            inv_scale: self.inv_scale * factor,
            hatch_frequency: self.hatch_frequency * factor,
            ..self
        }
    }
}

/// The colour map of a layer; colour layers have none and get the one of magnitudes.
pub fn colour_map(quantity: Quantity, dark: bool) -> ColourMap {
    match LayerLook::of(quantity).colouring {
        Colouring::Signed => ColourMap::signed(dark),
        Colouring::Share { .. } => ColourMap::technique(dark),
        Colouring::Radiance | Colouring::Magnitude => ColourMap::Viridis,
    }
}

fn kind(quantity: Quantity) -> Kind {
    match LayerLook::of(quantity).colouring {
        Colouring::Signed => Kind::Signed,
        Colouring::Radiance => Kind::Colour,
        Colouring::Share { .. } => Kind::Weight,
        Colouring::Magnitude => Kind::Magnitude,
    }
}

/// Slope and intercept of the position in the colour table.
///
/// Amber stands for the light technique: it is weight 1 of a light sample, weight 0 of a BSDF sample.
fn table_position(quantity: Quantity, view: &ViewState) -> (f32, f32) {
    match LayerLook::of(quantity).colouring {
        Colouring::Signed => ((2.0 * signed_range(quantity, view)).recip(), 0.5),
        Colouring::Share { of: Technique::Bsdf, .. } => (-1.0, 1.0),
        Colouring::Magnitude => {
            let [low, high] = variance_range(view);
            let slope = (high - low).recip();
            (slope, -low * slope)
        }
        Colouring::Radiance | Colouring::Share { of: Technique::Light, .. } => (1.0, 0.0),
    }
}

/// The number at the upper end of a signed map; the lower end has its opposite.
pub fn signed_range(quantity: Quantity, view: &ViewState) -> f32 {
    match quantity {
        // Eight times as noisy or wrong, or an eighth.
        Quantity::Versus(Versus::Variances | Versus::Errors) => 3.0,
        Quantity::Versus(Versus::Difference) | Quantity::Layer(_) => {
            if view.difference_range.is_finite() {
                view.difference_range.clamp(1e-6, 1e6)
            } else {
                1.0
            }
        }
    }
}

/// The range of the variance map, log10, made sound: finite, at least a tenth of a decade, the lower end first.
pub fn variance_range(view: &ViewState) -> [f32; 2] {
    let [low, high] = view.variance_range;
    if !(low.is_finite() && high.is_finite()) {
        return ViewState::DEFAULT_VARIANCE_RANGE;
    }
    let low = low.clamp(-30.0, 30.0);
    [low, high.clamp(low + 0.1, 38.0)]
}

/// Linear light to sRGB code values, both in [0, 1] (IEC 61966-2-1).
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The filmic curve: Narkowicz 2016, "ACES Filmic Tone Mapping Curve", a fit of the ACES output
/// transform that takes 1 to 0.8. From [0, inf) to [0, 1], linear light on both sides.
pub fn filmic(linear: f32) -> f32 {
    // The curve has long reached 1 where squares would overflow.
    let x = linear.clamp(0.0, 1e4);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

/// Exposed scene-linear light to a display value in [0, 1].
pub fn tone_map(map: ToneMap, exposed: f32) -> f32 {
    match map {
        ToneMap::Linear => exposed.clamp(0.0, 1.0),
        ToneMap::SrgbClip => srgb_encode(exposed.clamp(0.0, 1.0)),
        ToneMap::Filmic => srgb_encode(filmic(exposed)),
    }
}

/// The exposed number from which a tone map shows nothing but white.
pub fn clipped_from(map: ToneMap) -> f32 {
    match map {
        ToneMap::Linear | ToneMap::SrgbClip => 1.0,
        // Where the fit reaches 1: 0.08 x^2 - 0.56 x - 0.14 = 0.
        ToneMap::Filmic => 7.241_85,
    }
}

/// How much of the second colour the stripes have at a physical pixel of the viewport.
fn stripes(u: &Uniforms, [x, y]: [f32; 2]) -> f32 {
    let phase = ((x + y) * u.hatch_frequency).fract();
    let across = (phase - 0.5).abs() / u.hatch_frequency;
    (across - 0.25 / u.hatch_frequency + 0.5).clamp(0.0, 1.0)
}

/// The colour of the hatching at a physical pixel of the viewport.
fn hatch_at(u: &Uniforms, at: [f32; 2]) -> [f32; 3] {
    let blend = stripes(u, at);
    [0, 1, 2].map(|i| u.hatch_a[i] + (u.hatch_b[i] - u.hatch_a[i]) * blend)
}

/// The same of what cannot be sampled: stripes both ways.
fn cross_hatch_at(u: &Uniforms, at: [f32; 2]) -> [f32; 3] {
    // Along the other diagonal; whole periods keep the phase positive.
    let other = [at[0] + CROSSED_PERIODS / u.hatch_frequency, -at[1]];
    let blend = stripes(u, at).max(stripes(u, other));
    [0, 1, 2].map(|i| u.hatch_a[i] + (u.hatch_b[i] - u.hatch_a[i]) * blend)
}

fn rgb([r, g, b, _]: [f32; 4]) -> [f32; 3] {
    [r, g, b]
}

/// The display colour of one pixel of the frame; `at` is the physical pixel it is drawn to.
fn colour(u: &Uniforms, value: [f32; 3], at: [f32; 2]) -> [f32; 3] {
    let (tone, map) = (ToneMap::ALL[u.tone_map as usize], ColourMap::ALL[u.row as usize]);
    let v = value[0];
    if v == UNHIT {
        return hatch_at(u, at);
    }
    if v == BLIND {
        return cross_hatch_at(u, at);
    }
    if v == UNLIT {
        return rgb(u.hatch_a);
    }
    if u.kind == Kind::Colour as u32 {
        if value.iter().any(|v| !v.is_finite() || *v < 0.0) {
            return rgb(u.invalid);
        }
        let exposed = value.map(|v| v * u.gain + u.offset);
        let ink = if exposed.iter().any(|v| *v > u.clipped_from) { stripes(u, at) } else { 1.0 };
        return exposed.map(|v| tone_map(tone, v) * ink);
    }
    if v.is_nan() {
        return hatch_at(u, at);
    }
    if u.kind == Kind::Weight as u32 {
        if !(-WEIGHT_SLACK..=1.0 + WEIGHT_SLACK).contains(&v) {
            return rgb(u.invalid);
        }
        return map.at(v * u.slope + u.intercept);
    }
    if u.kind == Kind::Signed as u32 {
        return if v.is_finite() { map.at(v * u.slope + u.intercept) } else { rgb(u.invalid) };
    }
    if !v.is_finite() || v < 0.0 {
        return rgb(u.invalid);
    }
    map.at(v.max(f32::MIN_POSITIVE).log10() * u.slope + u.intercept)
}

/// The display colour, in [0, 1], of a pixel with these numbers, at the corner of the viewport.
pub fn at_pixel(u: &Uniforms, value: [f32; 3]) -> [f32; 3] {
    colour(u, value, [0.0, 0.0])
}

/// What the shader draws, `size` physical pixels of the viewport from its top left corner: RGBA8 rows.
pub fn render(planes: &Planes, u: &Uniforms, size: [usize; 2]) -> Vec<u8> {
    let bounds = planes.bounds();
    // The pixel of the frame at a physical pixel, per axis.
    let lookup = |axis: usize| -> Vec<Option<u32>> {
        (0..size[axis])
            .map(|i| {
                let at = ((i as f32 + 0.5 - u.origin[axis]) * u.inv_scale).floor();
                let inside = at >= u.bounds[axis] && at < u.bounds[axis + 2];
                inside.then(|| at as u32 - bounds.min[axis])
            })
            .collect()
    };
    let (columns, rows) = (lookup(0), lookup(1));
    let surround = rgb(u.surround);
    let fade = STALE_FADE * u.stale;
    let mut out = vec![255; size[0] * size[1] * 4];
    for (y, (row, line)) in rows.iter().zip(out.chunks_exact_mut((size[0] * 4).max(1))).enumerate() {
        for (x, (column, pixel)) in columns.iter().zip(line.chunks_exact_mut(4)).enumerate() {
            let shown = match (column, row) {
                (Some(column), Some(row)) => {
                    let at = [x as f32 + 0.5, y as f32 + 0.5];
                    let c = colour(u, planes.value(*column, *row), at);
                    [0, 1, 2].map(|i| c[i] + (surround[i] - c[i]) * fade)
                }
                _ => surround,
            };
            pixel[..3].copy_from_slice(&shown.map(|v| (v * 255.0 + 0.5) as u8));
        }
    }
    out
}
