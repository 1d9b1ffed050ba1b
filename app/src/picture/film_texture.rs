//! Planes on the GPU: a shader for all pictures, compiled for what each shows, and a texture for each.

use std::collections::HashMap;
use std::future::Future;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::task::{Context, Poll, Waker};

use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, ScreenDescriptor, wgpu};
use mislab_renderer::PixelRect;

use crate::look::colormap::{ColourMap, TABLE_LEN};
use crate::picture::planes::Planes;
use crate::picture::tone::Uniforms;

/// Planes per texture. Always three: the GL backend of wgpu makes a plain 2D texture of a single layer,
/// which an array view cannot read.
const PLANES: u32 = 3;

/// Pictures above this go the CPU way, which needs no copy of the picture on the GPU.
const MAX_TEXTURE_BYTES: u64 = 256 << 20;

/// What all pictures of a window are drawn with: the shader and its tables. Clones are of handles.
#[derive(Clone)]
pub struct FilmPipeline {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layout: wgpu::BindGroupLayout,
    shader: wgpu::ShaderModule,
    target: wgpu::TextureFormat,
    /// By [`Uniforms::variant`], made when they are first needed.
    variants: Arc<Mutex<HashMap<[u32; 2], wgpu::RenderPipeline>>>,
    tables: wgpu::TextureView,
}

impl FilmPipeline {
    /// For a window of that device; `None` if the device refuses it.
    pub fn new(render_state: &egui_wgpu::RenderState) -> Option<Self> {
        let egui_wgpu::RenderState { device, queue, target_format, .. } = render_state;
        checked(device, || {
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("picture"),
                entries: &[
                    entry(
                        0,
                        wgpu::BindingType::Buffer {
                            ty: wgpu::BufferBindingType::Uniform,
                            has_dynamic_offset: false,
                            min_binding_size: None,
                        },
                    ),
                    entry(1, texture_type(false, wgpu::TextureViewDimension::D2Array)),
                    entry(2, texture_type(true, wgpu::TextureViewDimension::D2)),
                ],
            });
            Self {
                shader: device.create_shader_module(wgpu::include_wgsl!("display.wgsl")),
                target: *target_format,
                variants: Arc::default(),
                tables: tables(device, queue),
                layout,
                device: device.clone(),
                queue: queue.clone(),
            }
        })
    }

    /// The shader, compiled for these settings; `None` if the device refuses it.
    fn variant(&self, uniforms: &Uniforms) -> Option<wgpu::RenderPipeline> {
        let variant = uniforms.variant();
        let mut variants = self.variants.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = variants.get(&variant) {
            return Some(pipeline.clone());
        }
        let pipeline = checked(&self.device, || self.compile(variant))?;
        Some(variants.entry(variant).or_insert(pipeline).clone())
    }

    fn compile(&self, [kind, tone_map]: [u32; 2]) -> wgpu::RenderPipeline {
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        let encodes = f64::from(u8::from(self.target.is_srgb()));
        let constants = [("KIND", f64::from(kind)), ("TONE_MAP", f64::from(tone_map)), ("ENCODING_TARGET", encodes)];
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("picture"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &self.shader,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.shader,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                targets: &[Some(self.target.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Whether pictures of that size fit the device.
    fn fits(&self, bounds: PixelRect) -> bool {
        let side = self.device.limits().max_texture_dimension_2d;
        let bytes = bounds.area() as u64 * u64::from(PLANES) * size_of::<f32>() as u64;
        bounds.area() > 0 && bounds.width() <= side && bounds.height() <= side && bytes <= MAX_TEXTURE_BYTES
    }
}

/// One picture on the GPU: its numbers, and how they are shown.
pub struct FilmTexture {
    shared: FilmPipeline,
    uniforms: wgpu::Buffer,
    film: Option<Film>,
}

struct Film {
    texture: wgpu::Texture,
    bind_group: wgpu::BindGroup,
    /// What the texture holds, which may be gone.
    planes: Weak<Planes>,
}

impl FilmTexture {
    /// Nothing yet; `None` if the device refuses even that.
    pub fn new(shared: FilmPipeline) -> Option<Self> {
        let uniforms = checked(&shared.device, || {
            shared.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture"),
                size: size_of::<Uniforms>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        Some(Self { shared, uniforms, film: None })
    }

    /// What draws `planes`; uploads them unless they are there already. `None` if they do not fit.
    pub fn paint(&mut self, planes: &Arc<Planes>, uniforms: Uniforms) -> Option<impl CallbackTrait + 'static> {
        if !self.shared.fits(planes.bounds()) {
            self.film = None;
            return None;
        }
        let size = [planes.bounds().width(), planes.bounds().height()];
        if self.film.as_ref().is_none_or(|film| [film.texture.width(), film.texture.height()] != size) {
            // The old one goes first: the two need not fit together.
            self.film = None;
            self.film = Some(self.allocate(size)?);
        }
        let film = self.film.as_mut()?;
        if Weak::as_ptr(&film.planes) != Arc::as_ptr(planes) {
            upload(&self.shared.queue, &film.texture, planes);
            film.planes = Arc::downgrade(planes);
        }
        Some(Painter {
            pipeline: self.shared.variant(&uniforms)?,
            bind_group: film.bind_group.clone(),
            buffer: self.uniforms.clone(),
            uniforms,
        })
    }

    fn allocate(&self, [width, height]: [u32; 2]) -> Option<Film> {
        let device = &self.shared.device;
        checked(device, || {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("film"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: PLANES },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            });
            let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("film"),
                layout: &self.shared.layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: self.uniforms.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&view) },
                    wgpu::BindGroupEntry {
                        binding: 2,
                        resource: wgpu::BindingResource::TextureView(&self.shared.tables),
                    },
                ],
            });
            Film { texture, bind_group, planes: Weak::new() }
        })
    }
}

/// Draws the picture inside egui's render pass.
struct Painter {
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
    buffer: wgpu::Buffer,
    uniforms: Uniforms,
}

impl CallbackTrait for Painter {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&self.uniforms));
        Vec::new()
    }

    fn paint(
        &self,
        _info: eframe::egui::PaintCallbackInfo,
        render_pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        render_pass.set_pipeline(&self.pipeline);
        render_pass.set_bind_group(0, &self.bind_group, &[]);
        render_pass.draw(0..3, 0..1);
    }
}

/// Runs `create`, which makes objects on `device`; `None` if the device reports an error, which would
/// otherwise end the program.
fn checked<T>(device: &wgpu::Device, create: impl FnOnce() -> T) -> Option<T> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let created = create();
    let failed = [validation.pop().now(), memory.pop().now()].into_iter().any(|e| e.is_some());
    (!failed).then_some(created)
}

/// The result of a future that is known to be ready, as error scopes are on native devices. In a browser the
/// answer comes later; there the objects are taken as good.
trait Now: Future<Output = Option<wgpu::Error>> + Sized {
    fn now(self) -> Option<wgpu::Error> {
        match pin!(self).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(error) => error,
            Poll::Pending => None,
        }
    }
}

impl<F: Future<Output = Option<wgpu::Error>>> Now for F {}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::VERTEX_FRAGMENT, ty, count: None }
}

fn texture_type(filterable: bool, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    }
}

/// The colour tables, one row each.
fn tables(device: &wgpu::Device, queue: &wgpu::Queue) -> wgpu::TextureView {
    let size =
        wgpu::Extent3d { width: TABLE_LEN as u32, height: ColourMap::ALL.len() as u32, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("colour tables"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let rows: Vec<u8> = ColourMap::ALL.iter().flat_map(|map| map.table().as_flattened()).copied().collect();
    queue.write_texture(texture.as_image_copy(), &rows, rows_of(size.width), size);
    texture.create_view(&Default::default())
}

/// Writes every channel into its layer of the texture.
fn upload(queue: &wgpu::Queue, texture: &wgpu::Texture, planes: &Planes) {
    let size = wgpu::Extent3d { width: texture.width(), height: texture.height(), depth_or_array_layers: 1 };
    for (z, plane) in (0..PLANES).zip(planes.channels()) {
        let mut target = texture.as_image_copy();
        target.origin.z = z;
        queue.write_texture(target, bytemuck::cast_slice(plane), rows_of(size.width), size);
    }
}

/// Rows of `width` texels of four bytes, one after the other.
fn rows_of(width: u32) -> wgpu::TexelCopyBufferLayout {
    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None }
}
