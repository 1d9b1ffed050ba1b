// The toolkit's meshes: colours times a texture, both encoded for the screen and premultiplied.

@group(0) @binding(0) var<uniform> screen: vec4<f32>;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

// Known when the pipeline is made: the target encodes what it is given.
override ENCODING_TARGET: bool;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) at: vec2<f32>,
    @location(1) colour: vec4<f32>,
}

// Positions are in points from the top left.
@vertex
fn vertex(@location(0) position: vec2<f32>, @location(1) at: vec2<f32>, @location(2) colour: vec4<f32>) -> Corner {
    let place = position / screen.xy * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
    return Corner(vec4<f32>(place, 0.0, 1.0), at, colour);
}

fn decode(encoded: vec3<f32>) -> vec3<f32> {
    let high = pow((encoded + 0.055) / 1.055, vec3<f32>(2.4));
    return select(high, encoded / 12.92, encoded <= vec3<f32>(0.04045));
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    let shown = textureSample(image, image_sampler, corner.at) * corner.colour;
    if ENCODING_TARGET {
        return vec4<f32>(decode(shown.rgb), shown.a);
    }
    return shown;
}
