//! The toolkit's meshes on the graphics device, by a shader that does no more than it has to.
//!
//! The toolkit's own renderer can also filter textures by hand, which tests that compare pixels ask for. It decides that in its shader, and
//! software drivers work out both ways, with all their integer divisions, for every pixel of a letter: three times the processor
//! time of a pass. Here its output is turned into callbacks, which it calls in their order among those of pictures.

use std::collections::HashMap;
use std::ops::Range;

use eframe::egui::epaint::{ClippedPrimitive, ClippedShape, ImageDelta, Primitive, Vertex};
use eframe::egui::plugin::Plugin;
use eframe::egui::{
    Context, FullOutput, ImageData, PaintCallbackInfo, Rect, Shape, TextureFilter, TextureId, TextureOptions,
    TextureWrapMode,
};
use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor, wgpu};

use crate::picture::device::{Program, UNIFORM, checked};

/// What meshes are drawn with, and the textures of the window.
pub struct Meshes {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    /// Width and height of the screen in points.
    screen: (wgpu::Buffer, wgpu::BindGroup),
    textures: HashMap<TextureId, Texture>,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
}

struct Texture {
    texture: wgpu::Texture,
    options: TextureOptions,
    bind_group: wgpu::BindGroup,
}

/// Some of the indices with one texture, as far as they lie in a part of the screen.
struct Draw {
    clip: Rect,
    indices: Range<u32>,
    bind_group: wgpu::BindGroup,
}

/// Meshes that nothing else is drawn between.
struct Run {
    pipeline: wgpu::RenderPipeline,
    screen: (wgpu::Buffer, wgpu::BindGroup),
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    draws: Vec<Draw>,
}

impl Meshes {
    /// For a window of that device; `None` if the device refuses it: then the toolkit draws them.
    pub fn new(render_state: &RenderState) -> Option<Self> {
        let RenderState { device, queue, target_format, .. } = render_state;
        checked(device, || {
            let screen_layout = bind_group_layout(device, &[(wgpu::ShaderStages::VERTEX, UNIFORM)]);
            let sampled = wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            };
            let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
            let stage = wgpu::ShaderStages::FRAGMENT;
            let layout = bind_group_layout(device, &[(stage, sampled), (stage, sampler)]);
            let screen = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("screen"),
                size: size_of::<[f32; 4]>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("screen"),
                layout: &screen_layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: screen.as_entire_binding() }],
            });
            Self {
                pipeline: pipeline(device, [&screen_layout, &layout], *target_format),
                vertices: buffer(device, 0, wgpu::BufferUsages::VERTEX),
                indices: buffer(device, 0, wgpu::BufferUsages::INDEX),
                screen: (screen, bind_group),
                textures: HashMap::new(),
                device: device.clone(),
                queue: queue.clone(),
                layout,
            }
        })
    }

    /// Takes over what has changed of a texture.
    fn update(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let [width, height] = image.size.map(|side| side as u32);
        if width == 0 || height == 0 {
            return;
        }
        let fits = |texture: &Texture| {
            [texture.texture.width(), texture.texture.height()] == [width, height] && texture.options == delta.options
        };
        if delta.pos.is_none() && !self.textures.get(&id).is_some_and(fits) {
            let texture = self.create(width, height, delta.options);
            self.textures.insert(id, texture);
        }
        let Some(Texture { texture, .. }) = self.textures.get(&id) else { return };
        let mut target = texture.as_image_copy();
        if let Some([x, y]) = delta.pos {
            target.origin = wgpu::Origin3d { x: x as u32, y: y as u32, z: 0 };
        }
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: Some(height) };
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        self.queue.write_texture(target, bytemuck::cast_slice(&image.pixels), rows, size);
    }

    fn create(&self, width: u32, height: u32, options: TextureOptions) -> Texture {
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("texture of the window"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            // Colours are encoded, and blended as they are.
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let filter = |filter| match filter {
            TextureFilter::Nearest => wgpu::FilterMode::Nearest,
            TextureFilter::Linear => wgpu::FilterMode::Linear,
        };
        let wrap = match options.wrap_mode {
            TextureWrapMode::ClampToEdge => wgpu::AddressMode::ClampToEdge,
            TextureWrapMode::Repeat => wgpu::AddressMode::Repeat,
            TextureWrapMode::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        };
        let sampler = self.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: filter(options.magnification),
            min_filter: filter(options.minification),
            address_mode_u: wrap,
            address_mode_v: wrap,
            ..Default::default()
        });
        let view = texture.create_view(&Default::default());
        let bind_group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("texture of the window"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&sampler) },
            ],
        });
        Texture { texture, options, bind_group }
    }

    /// The meshes of each run, with all vertices and indices in the two buffers; between runs the callback that comes there.
    fn runs(&mut self, primitives: Vec<ClippedPrimitive>) -> Vec<(Vec<Draw>, Option<ClippedShape>)> {
        let (mut vertices, mut indices): (Vec<Vertex>, Vec<u32>) = Default::default();
        let (mut runs, mut draws) = (Vec::new(), Vec::new());
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            match primitive {
                Primitive::Mesh(mesh) => {
                    let Some(texture) = self.textures.get(&mesh.texture_id) else { continue };
                    let first = indices.len() as u32;
                    // Old devices have no base vertex.
                    let before = vertices.len() as u32;
                    vertices.extend_from_slice(&mesh.vertices);
                    indices.extend(mesh.indices.iter().map(|index| before + index));
                    let (indices, bind_group) = (first..indices.len() as u32, texture.bind_group.clone());
                    draws.push(Draw { clip: clip_rect, indices, bind_group });
                }
                Primitive::Callback(callback) => {
                    let shape = ClippedShape::new(clip_rect, Shape::Callback(callback));
                    runs.push((std::mem::take(&mut draws), Some(shape)));
                }
            }
        }
        runs.push((draws, None));
        fill(self, bytemuck::cast_slice(&vertices), |meshes| &mut meshes.vertices, wgpu::BufferUsages::VERTEX);
        fill(self, bytemuck::cast_slice(&indices), |meshes| &mut meshes.indices, wgpu::BufferUsages::INDEX);
        runs
    }
}

impl Plugin for Meshes {
    fn debug_name(&self) -> &'static str {
        "meshes"
    }

    fn output_hook(&mut self, ctx: &Context, output: &mut FullOutput) {
        for (id, changes) in output.textures_delta.set.drain() {
            for delta in changes {
                self.update(id, &delta);
            }
        }
        let primitives = ctx.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
        let everywhere = ctx.input(|input| input.viewport_rect());
        for (draws, callback) in self.runs(primitives) {
            if !draws.is_empty() {
                let run = Run {
                    pipeline: self.pipeline.clone(),
                    screen: self.screen.clone(),
                    vertices: self.vertices.clone(),
                    indices: self.indices.clone(),
                    draws,
                };
                let callback = egui_wgpu::Callback::new_paint_callback(everywhere, run);
                output.shapes.push(ClippedShape::new(everywhere, Shape::Callback(callback)));
            }
            output.shapes.extend(callback);
        }
        // What is drawn with them holds them.
        for id in output.textures_delta.free.drain() {
            self.textures.remove(&id);
        }
    }
}

impl CallbackTrait for Run {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let [width, height] = screen.size_in_pixels.map(|side| side as f32 / screen.pixels_per_point);
        queue.write_buffer(&self.screen.0, 0, bytemuck::bytes_of(&[width, height, 0.0, 0.0]));
        Vec::new()
    }

    fn paint(&self, info: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _resources: &CallbackResources) {
        let [width, height] = info.screen_size_px;
        pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.screen.1, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for draw in &self.draws {
            // Rounded to whole pixels, as all that is clipped by the same edge.
            let edge = |at: f32, most: u32| ((at * info.pixels_per_point).round().max(0.0) as u32).min(most);
            let [left, top] = [edge(draw.clip.min.x, width), edge(draw.clip.min.y, height)];
            let [right, bottom] = [edge(draw.clip.max.x, width), edge(draw.clip.max.y, height)];
            if right <= left || bottom <= top {
                continue;
            }
            pass.set_scissor_rect(left, top, right - left, bottom - top);
            pass.set_bind_group(1, &draw.bind_group, &[]);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
        }
    }
}

/// Writes them into a buffer, or into a larger one in its place.
fn fill(meshes: &mut Meshes, bytes: &[u8], which: fn(&mut Meshes) -> &mut wgpu::Buffer, usage: wgpu::BufferUsages) {
    let needed = bytes.len() as u64;
    if which(meshes).size() < needed {
        let larger = buffer(&meshes.device, needed, usage);
        *which(meshes) = larger;
    }
    let target = which(meshes).clone();
    meshes.queue.write_buffer(&target, 0, bytes);
}

fn buffer(device: &wgpu::Device, needed: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("meshes"),
        size: needed.next_power_of_two().max(1 << 16),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn bind_group_layout(
    device: &wgpu::Device,
    entries: &[(wgpu::ShaderStages, wgpu::BindingType)],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, &(visibility, ty)): (usize, &(wgpu::ShaderStages, wgpu::BindingType))| {
        wgpu::BindGroupLayoutEntry { binding: binding as u32, visibility, ty, count: None }
    };
    let entries: Vec<_> = entries.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("meshes"), entries: &entries })
}

fn pipeline(
    device: &wgpu::Device,
    [screen, texture]: [&wgpu::BindGroupLayout; 2],
    target: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("meshes.wgsl"));
    let attributes = wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4];
    let constants = [("ENCODING_TARGET", f64::from(u8::from(target.is_srgb())))];
    // Colours are premultiplied.
    let blend =
        |src_factor, dst_factor| wgpu::BlendComponent { src_factor, dst_factor, operation: wgpu::BlendOperation::Add };
    let blend = wgpu::BlendState {
        color: blend(wgpu::BlendFactor::One, wgpu::BlendFactor::OneMinusSrcAlpha),
        alpha: blend(wgpu::BlendFactor::OneMinusDstAlpha, wgpu::BlendFactor::One),
    };
    let corners = wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &attributes,
    };
    let target = wgpu::ColorTargetState { format: target, blend: Some(blend), write_mask: wgpu::ColorWrites::ALL };
    let program =
        Program { module: &module, layouts: vec![screen, texture], fragment: "fragment", corners: Some(corners) };
    program.pipeline(device, target, &constants)
}
