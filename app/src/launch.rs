//! From the program to its window, or to the reason why there is none.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup};

use crate::app::{AppOptions, MisLabApp};

/// Why there is no window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoWindow {
    /// One sentence for the terminal.
    pub reason: String,
}

/// Opens the window and stays until it is closed.
///
/// # Errors
/// If there is no display or no way to draw on it.
pub fn run_app(scene: Option<PathBuf>) -> Result<(), NoWindow> {
    let viewport = egui::ViewportBuilder::default()
        .with_title("MIS Lab")
        .with_app_id("mislab")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([960.0, 600.0])
        .with_drag_and_drop(true);
    let mut native = eframe::NativeOptions { viewport, ..Default::default() };
    allow_large_windows(&mut native.wgpu_options);
    let options = AppOptions { scene, ..AppOptions::default() };
    let created = Arc::new(AtomicBool::new(false));
    let there = created.clone();
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        there.store(true, Ordering::Relaxed);
        Ok(Box::new(MisLabApp::new(cc, options)))
    });
    // A missing keyboard library panics inside the window library, instead of being an error.
    let result = catch_unwind(AssertUnwindSafe(|| eframe::run_native("mislab", native, create)));
    let reason = match result {
        Ok(Ok(())) => return Ok(()),
        // What the library adds names its own source files.
        Ok(Err(eframe::Error::WinitEventLoop(_))) => "no display to open a window on".to_owned(),
        Ok(Err(eframe::Error::Winit(error))) => format!("the window could not be opened ({error})"),
        Ok(Err(eframe::Error::Wgpu(error))) => format!("no graphics to draw with ({error})"),
        Ok(Err(error)) => format!("the window could not be opened ({error})"),
        // A fault of ours, not a missing display.
        Err(panic) if created.load(Ordering::Relaxed) => resume_unwind(panic),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            format!("a library of the window system is missing ({})", text.unwrap_or_default())
        }
    };
    Err(NoWindow { reason })
}

/// The toolkit asks for textures of 8192 pixels, whatever the device can do: less is refused where
/// the device has less, and a window larger than that is a panic.
fn allow_large_windows(options: &mut WgpuConfiguration) {
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_setup {
        let usual = setup.device_descriptor.clone();
        setup.device_descriptor = Arc::new(move |adapter| {
            let mut descriptor = usual(adapter);
            descriptor.required_limits.max_texture_dimension_2d = adapter.limits().max_texture_dimension_2d;
            descriptor
        });
    }
}
