//! Planes on the GPU: a shader for all pictures, compiled for what each shows, and two textures for each: its numbers, and what is seen of
//! them. The second is drawn when something about it changes, and each pass of the window copies it.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, ScreenDescriptor, wgpu};
use mislab_renderer::PixelRect;

use crate::look::colormap::{ColourMap, TABLE_LEN};
use crate::picture::device::{Program, UNIFORM, checked};
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
    canvas_layout: wgpu::BindGroupLayout,
    /// Copies a canvas to the screen.
    from_canvas: wgpu::RenderPipeline,
    shader: wgpu::ShaderModule,
    target: wgpu::TextureFormat,
    /// By [`Uniforms::variant`], made when they are first needed.
    variants: Arc<Mutex<HashMap<[u32; 2], wgpu::RenderPipeline>>>,
    tables: wgpu::TextureView,
    spare: Spare,
}

impl FilmPipeline {
    /// For a window of that device; `None` if the device refuses it.
    pub fn new(render_state: &egui_wgpu::RenderState) -> Option<Self> {
        let egui_wgpu::RenderState { device, queue, target_format, .. } = render_state;
        checked(device, || {
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("picture"),
                entries: &[
                    entry(0, UNIFORM),
                    entry(1, texture_type(false, wgpu::TextureViewDimension::D2Array)),
                    entry(2, texture_type(true, wgpu::TextureViewDimension::D2)),
                ],
            });
            let canvas_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("canvas"),
                entries: &[entry(0, UNIFORM), entry(3, texture_type(true, wgpu::TextureViewDimension::D2))],
            });
            let shader = device.create_shader_module(wgpu::include_wgsl!("display.wgsl"));
            Self {
                from_canvas: over_all(&shader, &canvas_layout, "from_canvas").pipeline(
                    device,
                    (*target_format).into(),
                    &[],
                ),
                shader,
                target: *target_format,
                variants: Arc::default(),
                tables: tables(device, queue),
                layout,
                canvas_layout,
                spare: Spare::default(),
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
        let encodes = f64::from(u8::from(self.target.is_srgb()));
        let constants = [("KIND", f64::from(kind)), ("TONE_MAP", f64::from(tone_map)), ("ENCODING_TARGET", encodes)];
        over_all(&self.shader, &self.layout, "fragment").pipeline(&self.device, self.target.into(), &constants)
    }

    /// Lays planes out for the device, in memory that it copies from; `None` if it refuses that.
    pub fn stage(&self, planes: &Planes) -> Option<Staged> {
        let bounds = planes.bounds();
        if !self.fits(bounds) {
            return None;
        }
        let row = 4 * bounds.width();
        let bytes_per_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let size = u64::from(PLANES) * u64::from(bytes_per_row) * u64::from(bounds.height());
        let buffer = self.spare.take(size).or_else(|| self.allocate_spare(size))?;
        {
            let mut mapped = buffer.get_mapped_range_mut(..).ok()?;
            let rows = planes.channels().flat_map(|plane| plane.chunks_exact(bounds.width() as usize));
            for (index, numbers) in rows.enumerate() {
                let at = index * bytes_per_row as usize;
                mapped.slice(at..at + row as usize).copy_from_slice(bytemuck::cast_slice(numbers));
            }
        }
        buffer.unmap();
        let layers = planes.channels().count() as u32;
        let spare = self.spare.clone();
        Some(Staged { buffer, bytes_per_row, size: [bounds.width(), bounds.height()], layers, spare })
    }

    fn allocate_spare(&self, size: u64) -> Option<wgpu::Buffer> {
        checked(&self.device, || {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("film"),
                size,
                usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::MAP_WRITE,
                mapped_at_creation: true,
            })
        })
    }

    /// Whether pictures of that size fit the device.
    fn fits(&self, bounds: PixelRect) -> bool {
        let side = self.device.limits().max_texture_dimension_2d;
        let bytes = bounds.area() as u64 * u64::from(PLANES) * size_of::<f32>() as u64;
        bounds.area() > 0 && bounds.width() <= side && bounds.height() <= side && bytes <= MAX_TEXTURE_BYTES
    }
}

/// Buffers to lay planes out in, ready to be written: the next planes take those that the device has copied. New ones for each would
/// wander over all memory that the device has asked for.
#[derive(Clone, Default)]
struct Spare(Arc<Mutex<Vec<wgpu::Buffer>>>);

impl Spare {
    /// So many are kept.
    const MOST: usize = 2;

    fn list(&self) -> MutexGuard<'_, Vec<wgpu::Buffer>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self, size: u64) -> Option<wgpu::Buffer> {
        let mut list = self.list();
        let at = list.iter().position(|buffer| buffer.size() == size)?;
        Some(list.swap_remove(at))
    }

    /// Keeps a buffer once the device has done what was submitted with it.
    fn give_back(&self, buffer: &wgpu::Buffer) {
        let (spare, kept) = (self.clone(), buffer.clone());
        buffer.map_async(wgpu::MapMode::Write, .., move |mapped| {
            if mapped.is_ok() {
                let mut list = spare.list();
                list.push(kept);
                let excess = list.len().saturating_sub(Self::MOST);
                list.drain(..excess);
            }
        });
    }
}

/// Planes laid out in memory that the graphics device copies from.
pub struct Staged {
    buffer: wgpu::Buffer,
    bytes_per_row: u32,
    size: [u32; 2],
    layers: u32,
    spare: Spare,
}

impl Staged {
    /// Has the device copy them, before it draws what is encoded later.
    fn copy(&self, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) {
        let [width, height] = self.size;
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(self.bytes_per_row),
            rows_per_image: Some(height),
        };
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout },
            texture.as_image_copy(),
            wgpu::Extent3d { width, height, depth_or_array_layers: self.layers },
        );
    }
}

/// One picture on the GPU: its numbers, and how they are shown.
pub struct FilmTexture {
    shared: FilmPipeline,
    uniforms: wgpu::Buffer,
    film: Option<Film>,
    canvas: Option<Canvas>,
    state: Arc<Mutex<State>>,
}

/// The numbers.
struct Film {
    texture: wgpu::Texture,
    bind_group: wgpu::BindGroup,
    /// Whose they are or will be when the next pass is drawn; these may be gone.
    planes: Weak<Planes>,
}

/// What is seen of them, at the size of the viewport.
struct Canvas {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    bind_group: wgpu::BindGroup,
}

/// What has become of them on the device: a pass of the window may be given up before it is drawn.
#[derive(Default)]
struct State {
    /// Numbers laid out that the device has not copied yet, and whose they are.
    staged: Option<(Weak<Planes>, Staged)>,
    /// What the canvas shows.
    drawn: Option<(Weak<Planes>, Uniforms)>,
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
        Some(Self { shared, uniforms, film: None, canvas: None, state: Arc::default() })
    }

    /// What it is drawn with.
    pub fn pipeline(&self) -> &FilmPipeline {
        &self.shared
    }

    /// The same numbers as in `planes`, laid out: to be drawn next.
    pub fn stage(&mut self, planes: &Arc<Planes>, staged: Staged) {
        self.state().staged = Some((Arc::downgrade(planes), staged));
    }

    /// What draws `planes` over a viewport of so many pixels of the screen; uploads them unless they are there already. `None` if they do
    /// not fit.
    pub fn paint(
        &mut self,
        planes: &Arc<Planes>,
        uniforms: Uniforms,
        viewport: [u32; 2],
    ) -> Option<impl CallbackTrait + 'static> {
        if !self.shared.fits(planes.bounds()) {
            (self.film, self.canvas) = (None, None);
            return None;
        }
        let size = [planes.bounds().width(), planes.bounds().height()];
        if self.film.as_ref().is_none_or(|film| size_of_texture(&film.texture) != size) {
            // The old one goes first: the two need not fit together.
            self.film = None;
            self.film = Some(self.allocate(size)?);
        }
        if self.canvas.as_ref().is_none_or(|canvas| size_of_texture(&canvas.texture) != viewport) {
            self.canvas = None;
            self.canvas = Some(self.allocate_canvas(viewport)?);
            self.state().drawn = None;
        }
        let laid_out = self.state().staged.as_ref().is_some_and(|(of, _)| Weak::as_ptr(of) == Arc::as_ptr(planes));
        if !laid_out {
            // What is laid out, if anything, is about others and may not come over these.
            self.state().staged = None;
        }
        let film = self.film.as_mut()?;
        if !laid_out && Weak::as_ptr(&film.planes) != Arc::as_ptr(planes) {
            upload(&self.shared.queue, &film.texture, planes);
        }
        film.planes = Arc::downgrade(planes);
        let canvas = self.canvas.as_ref()?;
        Some(Painter {
            pipelines: [self.shared.variant(&uniforms)?, self.shared.from_canvas.clone()],
            bind_groups: [film.bind_group.clone(), canvas.bind_group.clone()],
            film: film.texture.clone(),
            canvas: canvas.view.clone(),
            buffer: self.uniforms.clone(),
            planes: film.planes.clone(),
            uniforms,
            state: self.state.clone(),
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
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

    fn allocate_canvas(&self, [width, height]: [u32; 2]) -> Option<Canvas> {
        let device = &self.shared.device;
        let side = device.limits().max_texture_dimension_2d;
        if width.min(height) == 0 || width.max(height) > side {
            return None;
        }
        checked(device, || {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("canvas"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                // That of the window: what is drawn is rounded once.
                format: self.shared.target,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            let view = texture.create_view(&Default::default());
            let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("canvas"),
                layout: &self.shared.canvas_layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: self.uniforms.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&view) },
                ],
            });
            Canvas { texture, view, bind_group }
        })
    }
}

fn size_of_texture(texture: &wgpu::Texture) -> [u32; 2] {
    [texture.width(), texture.height()]
}

/// Draws the picture on its canvas where that shows another one, and copies it inside egui's render pass. Of two things the first is about
/// the canvas and the second about the screen.
struct Painter {
    pipelines: [wgpu::RenderPipeline; 2],
    bind_groups: [wgpu::BindGroup; 2],
    film: wgpu::Texture,
    canvas: wgpu::TextureView,
    buffer: wgpu::Buffer,
    planes: Weak<Planes>,
    uniforms: Uniforms,
    state: Arc<Mutex<State>>,
}

impl CallbackTrait for Painter {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&self.uniforms));
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |(planes, uniforms): &(Weak<Planes>, Uniforms)| {
            planes.ptr_eq(&self.planes) && uniforms.same_canvas(&self.uniforms)
        };
        if state.drawn.as_ref().is_some_and(same) {
            return Vec::new();
        }
        // With commands of its own: those of the toolkit are dropped where the window has nothing to draw on.
        let mut encoder = device.create_command_encoder(&Default::default());
        let staged = state.staged.take().map(|(_, staged)| staged);
        if let Some(staged) = &staged {
            staged.copy(&mut encoder, &self.film);
        }
        {
            let target = wgpu::RenderPassColorAttachment {
                view: &self.canvas,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("canvas"),
                color_attachments: &[Some(target)],
                ..Default::default()
            });
            self.draw(0, &mut pass);
        }
        queue.submit([encoder.finish()]);
        if let Some(staged) = staged {
            staged.spare.give_back(&staged.buffer);
        }
        state.drawn = Some((self.planes.clone(), self.uniforms));
        Vec::new()
    }

    fn paint(
        &self,
        _info: eframe::egui::PaintCallbackInfo,
        render_pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        self.draw(1, render_pass);
    }
}

impl Painter {
    fn draw(&self, which: usize, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipelines[which]);
        pass.set_bind_group(0, &self.bind_groups[which], &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A shader of the module over all of a target.
fn over_all<'a>(module: &'a wgpu::ShaderModule, layout: &'a wgpu::BindGroupLayout, fragment: &'a str) -> Program<'a> {
    Program { module, layouts: vec![layout], fragment, corners: None }
}

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
