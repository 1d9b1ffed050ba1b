//! What goes wrong with the graphics device.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;
use eframe::egui_wgpu::RenderState;

/// What the graphics driver reported, from whatever thread.
pub type GpuTrouble = Arc<Mutex<Option<String>>>;

/// Puts what the driver reports into `trouble`. Without this the default handler ends the process.
pub fn watch_gpu(state: &RenderState, trouble: &GpuTrouble, ctx: &Context) {
    let report = |trouble: &GpuTrouble, ctx: &Context, message: String| {
        *trouble.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        ctx.request_repaint();
    };
    let (slot, context) = (trouble.clone(), ctx.clone());
    state.device.set_device_lost_callback(move |reason, message| {
        // Said as well when the window closes and takes its device along.
        if reason != eframe::wgpu::DeviceLostReason::Destroyed {
            report(&slot, &context, format!("the graphics device was lost: {message}"));
        }
    });
    let (slot, context) = (trouble.clone(), ctx.clone());
    state.device.on_uncaptured_error(Arc::new(move |error: eframe::wgpu::Error| {
        report(&slot, &context, format!("the graphics driver reported: {error}"));
    }));
}
