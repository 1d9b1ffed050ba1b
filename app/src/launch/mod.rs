//! From the program to its window, or to the reason why there is none.

#[cfg(unix)]
mod signals;
mod surroundings;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup};
use eframe::wgpu::Backends;

use crate::app::{AppOptions, MisLabApp};
use crate::files::kept;
use crate::state::passes::Meter;
use crate::state::prefs::Prefs;

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
    surroundings::mend();
    let prefs_file = kept::place();
    let (prefs, remark) = prefs_file.as_deref().map_or_else(|| (Prefs::default(), None), kept::load);
    let viewport = egui::ViewportBuilder::default()
        .with_title("MIS Lab")
        .with_app_id("mislab")
        .with_icon(icon())
        .with_inner_size(prefs.window.size)
        .with_maximized(prefs.window.maximized)
        .with_min_inner_size([960.0, 600.0])
        .with_drag_and_drop(true);
    // The toolkit is built without storage: numbers in its file that no screen can have are a panic.
    let mut native = eframe::NativeOptions { viewport, dithering: false, ..Default::default() };
    allow_large_windows(&mut native.wgpu_options);
    let options = AppOptions { scene, threads: 0, meter: Meter::of_process(), prefs, prefs_file, remark };
    let created = Arc::new(AtomicBool::new(false));
    silence_panics_until(created.clone());
    let open = |backends: Backends| {
        let (there, options, mut native) = (created.clone(), options.clone(), native.clone());
        if let WgpuSetup::CreateNew(setup) = &mut native.wgpu_options.wgpu_setup {
            setup.instance_descriptor.backends = backends;
        }
        let create: eframe::AppCreator<'_> = Box::new(move |cc| {
            there.store(true, Ordering::Relaxed);
            #[cfg(unix)]
            signals::close_window_on_signal(&cc.egui_ctx);
            Ok(Box::new(MisLabApp::new(cc, options)))
        });
        // A missing keyboard library panics inside the window library, instead of being an error.
        catch_unwind(AssertUnwindSafe(|| eframe::run_native("mislab", native, create)))
    };
    let mut backends = Backends::from_env().map_or_else(|| DRAWN_BY.to_vec(), |asked| vec![asked]).into_iter();
    let mut result = open(backends.next().unwrap_or_default());
    while matches!(result, Ok(Err(eframe::Error::Wgpu(_)))) && !created.load(Ordering::Relaxed) {
        let Some(next) = backends.next() else { break };
        result = open(next);
    }
    // What libraries say names their own source files and, of adapters, empty lists.
    let reason = match result {
        Ok(Ok(())) => return Ok(()),
        Ok(Err(eframe::Error::WinitEventLoop(_))) => surroundings::no_display(),
        Ok(Err(eframe::Error::Wgpu(_))) => {
            format!("neither Vulkan nor OpenGL offers a device to draw with{}", surroundings::how_to_install(GRAPHICS))
        }
        Ok(Err(error)) => format!("it could not be opened ({})", without_place(&error.to_string())),
        // A fault of ours, not a missing display.
        Err(panic) if created.load(Ordering::Relaxed) => resume_unwind(panic),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
            let text = text.map_or(String::new(), |text| format!(" ({})", text.trim_end_matches(['.', ' '])));
            format!("a library of the window system is missing{text}{}", surroundings::how_to_install(WINDOW))
        }
    };
    Err(NoWindow { reason })
}

/// What draws, in the order tried: what the toolkit prefers of all there is, then each that is found on more than one system, by
/// itself. A driver may offer a device and then not make it, as wine does for Direct3D 12.
const DRAWN_BY: [Backends; 3] = [Backends::PRIMARY.union(Backends::GL), Backends::VULKAN, Backends::GL];

/// What window and task bar show; nothing if it cannot be decoded.
fn icon() -> egui::IconData {
    let mut reader =
        match png::Decoder::new(std::io::Cursor::new(include_bytes!("../../../assets/mislab.png"))).read_info() {
            Ok(reader) => reader,
            Err(_) => return egui::IconData::default(),
        };
    let mut rgba = vec![0; reader.output_buffer_size().unwrap_or(0)];
    match reader.next_frame(&mut rgba) {
        Ok(info) if info.color_type == png::ColorType::Rgba => {
            egui::IconData { rgba, width: info.width, height: info.height }
        }
        Ok(_) | Err(_) => egui::IconData::default(),
    }
}

/// Debian's packages that a window needs.
const WINDOW: &str = "libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6";
/// And those that draw on it.
const GRAPHICS: &str = "libvulkan1 mesa-vulkan-drivers libegl1 libgl1-mesa-dri";

/// Until the app is there, a panic is a missing library, which is said in a sentence of ours.
fn silence_panics_until(created: Arc<AtomicBool>) {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if created.load(Ordering::Relaxed) {
            usual(info);
        }
    }));
}

/// "os error at FILE:LINE: what", without the first part.
fn without_place(text: &str) -> &str {
    match text.split_once(": ") {
        Some((place, what)) if place.contains(".rs:") => what,
        Some(_) | None => text,
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_an_icon() {
        let icon = icon();
        assert_eq!([icon.width, icon.height], [128, 128]);
        assert_eq!(icon.rgba.len(), 128 * 128 * 4);
        assert!(icon.rgba.chunks_exact(4).any(|p| p == [0xE6, 0x9F, 0x00, 0xFF]), "the light technique's amber");
    }

    #[test]
    fn places_in_libraries_are_nobodys_business() {
        assert_eq!(without_place("os error at /a/b/src/x11.rs:12: no such atom"), "no such atom");
        assert_eq!(without_place("wrong: number"), "wrong: number");
    }
}
