//! The graphics device: errors that would end the program, and pipelines.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use eframe::egui_wgpu::wgpu;

/// A buffer of uniforms.
pub const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

/// What a pipeline runs: the module's `vertex` and one of its fragment shaders, over one sample a pixel and no depth.
pub struct Program<'a> {
    /// Both shaders.
    pub module: &'a wgpu::ShaderModule,
    /// Groups of bindings, in their order.
    pub layouts: Vec<&'a wgpu::BindGroupLayout>,
    /// Name of the fragment shader.
    pub fragment: &'a str,
    /// What a corner of a triangle has; `None`: its index alone.
    pub corners: Option<wgpu::VertexBufferLayout<'a>>,
}

impl Program<'_> {
    /// The pipeline, with the shader's constants set.
    pub fn pipeline(
        &self,
        device: &wgpu::Device,
        target: wgpu::ColorTargetState,
        constants: &[(&str, f64)],
    ) -> wgpu::RenderPipeline {
        let layouts: Vec<_> = self.layouts.iter().copied().map(Some).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.fragment),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let buffers: Vec<_> = self.corners.iter().cloned().map(Some).collect();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some(self.fragment),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                targets: &[Some(target)],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Runs `create`, which makes objects on `device`; `None` if the device reports an error, which would
/// otherwise end the program.
pub fn checked<T>(device: &wgpu::Device, create: impl FnOnce() -> T) -> Option<T> {
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
