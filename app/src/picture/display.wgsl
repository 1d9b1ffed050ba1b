// The picture on its canvas: one triangle over it; for every physical pixel the pixel of the frame under it, exposed and tone-mapped or
// falsely coloured. The twin of tone.rs, name by name. Then the canvas on the screen.

// Of these the twin asks `kind` and `tone_map`; here KIND and TONE_MAP have their place.
struct Uniforms {
    viewport: vec2<f32>,
    origin: vec2<f32>,
    bounds: vec4<f32>,
    inv_scale: f32,
    gain: f32,
    offset: f32,
    kind: u32,
    tone_map: u32,
    row: u32,
    slope: f32,
    intercept: f32,
    hatch_frequency: f32,
    stale: f32,
    clipped_from: f32,
    padding: u32,
    surround: vec4<f32>,
    hatch_a: vec4<f32>,
    hatch_b: vec4<f32>,
    invalid: vec4<f32>,
}

const COLOUR = 0u;
const WEIGHT = 1u;
const SIGNED = 3u;
const LINEAR = 0u;
const FILMIC = 2u;
const STALE_FADE = 0.55;
const WEIGHT_SLACK = 1e-3;
const LOG10_2 = 0.30102999566;
const LAST_ENTRY = 255.0;
const CROSSED_PERIODS = 2048.0;
// Of all numbers the least: a pixel that cannot be sampled; half of that: one that has not been hit yet; and half again: one that
// reflects no light.
const BLIND = -3.40282346638528859812e38;
const UNHIT = -1.70141173319264429906e38;
const UNLIT = -8.50705866596322149530e37;

@group(0) @binding(0) var<uniform> u: Uniforms;
@group(0) @binding(1) var planes: texture_2d_array<f32>;
@group(0) @binding(2) var tables: texture_2d<f32>;
@group(0) @binding(3) var canvas: texture_2d<f32>;

// What the fragments branch by is known when a pipeline is made: Mesa's software driver works out all branches for every pixel,
// whichever is taken.
override KIND: u32;
override TONE_MAP: u32;
override ENCODING_TARGET: bool;

@vertex
fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(i & 1u), f32(i >> 1u));
    return vec4<f32>(corner * 4.0 - 1.0, 0.0, 1.0);
}

// By bits: compilers may assume that no comparison ever sees a NaN or an infinity.
fn is_nan(v: f32) -> bool {
    return (bitcast<u32>(v) & 0x7fffffffu) > 0x7f800000u;
}

fn is_finite(v: f32) -> bool {
    return (bitcast<u32>(v) & 0x7f800000u) != 0x7f800000u;
}

fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.0031308 {
        return 12.92 * linear;
    }
    return 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        return encoded / 12.92;
    }
    return pow((encoded + 0.055) / 1.055, 2.4);
}

fn filmic(linear: f32) -> f32 {
    let x = clamp(linear, 0.0, 1e4);
    return min((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
}

fn tone_map(exposed: f32) -> f32 {
    if TONE_MAP == LINEAR {
        return clamp(exposed, 0.0, 1.0);
    }
    if TONE_MAP == FILMIC {
        return srgb_encode(filmic(exposed));
    }
    return srgb_encode(clamp(exposed, 0.0, 1.0));
}

fn table_at(t: f32) -> vec3<f32> {
    let position = clamp(t, 0.0, 1.0) * LAST_ENTRY;
    let first = min(floor(position), LAST_ENTRY - 1.0);
    let a = textureLoad(tables, vec2<i32>(i32(first), i32(u.row)), 0).rgb;
    let b = textureLoad(tables, vec2<i32>(i32(first) + 1, i32(u.row)), 0).rgb;
    return mix(a, b, position - first);
}

fn stripes(at: vec2<f32>) -> f32 {
    let phase = fract((at.x + at.y) * u.hatch_frequency);
    let across = abs(phase - 0.5) / u.hatch_frequency;
    return clamp(across - 0.25 / u.hatch_frequency + 0.5, 0.0, 1.0);
}

fn hatch_at(at: vec2<f32>) -> vec3<f32> {
    return mix(u.hatch_a.rgb, u.hatch_b.rgb, stripes(at));
}

fn cross_hatch_at(at: vec2<f32>) -> vec3<f32> {
    let other = vec2<f32>(at.x + CROSSED_PERIODS / u.hatch_frequency, -at.y);
    return mix(u.hatch_a.rgb, u.hatch_b.rgb, max(stripes(at), stripes(other)));
}

fn colour(pixel: vec2<i32>, at: vec2<f32>) -> vec3<f32> {
    let v = textureLoad(planes, pixel, 0, 0).r;
    if v == UNHIT {
        return hatch_at(at);
    }
    if v == BLIND {
        return cross_hatch_at(at);
    }
    if v == UNLIT {
        return u.hatch_a.rgb;
    }
    if KIND == COLOUR {
        let rgb = vec3<f32>(v, textureLoad(planes, pixel, 1, 0).r, textureLoad(planes, pixel, 2, 0).r);
        if !(is_finite(rgb.r) && is_finite(rgb.g) && is_finite(rgb.b)) || any(rgb < vec3<f32>(0.0)) {
            return u.invalid.rgb;
        }
        let exposed = rgb * u.gain + u.offset;
        let mapped = vec3<f32>(tone_map(exposed.r), tone_map(exposed.g), tone_map(exposed.b));
        return select(mapped, mapped * stripes(at), any(exposed > vec3<f32>(u.clipped_from)));
    }
    if is_nan(v) {
        return hatch_at(at);
    }
    if KIND == SIGNED {
        if !is_finite(v) {
            return u.invalid.rgb;
        }
        return table_at(v * u.slope + u.intercept);
    }
    if !is_finite(v) || v < -WEIGHT_SLACK {
        return u.invalid.rgb;
    }
    if KIND == WEIGHT {
        if v > 1.0 + WEIGHT_SLACK {
            return u.invalid.rgb;
        }
        return table_at(v * u.slope + u.intercept);
    }
    if v < 0.0 {
        return u.invalid.rgb;
    }
    return table_at(log2(max(v, 1.17549435e-38)) * LOG10_2 * u.slope + u.intercept);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = position.xy;
    let pixel = floor((at - u.origin) * u.inv_scale);
    var shown = u.surround.rgb;
    if all(pixel >= u.bounds.xy) && all(pixel < u.bounds.zw) {
        shown = mix(colour(vec2<i32>(pixel - u.bounds.xy), at), shown, STALE_FADE * u.stale);
    }
    if ENCODING_TARGET {
        shown = vec3<f32>(srgb_decode(shown.r), srgb_decode(shown.g), srgb_decode(shown.b));
    }
    return vec4<f32>(shown, 1.0);
}

@fragment
fn from_canvas(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(canvas, vec2<i32>(position.xy - u.viewport), 0);
}
