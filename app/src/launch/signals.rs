//! The end asked for from outside: by a system that shuts down, by `kill`, by Ctrl+C in the terminal.

use eframe::egui::{Context, ViewportCommand, ViewportId};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// From now on SIGTERM, SIGINT and SIGHUP close the window as its button does, so that what was to be saved is saved. Where the
/// system refuses, they end the program at once, as they end any.
pub(super) fn close_window_on_signal(ctx: &Context) {
    let Ok(mut signals) = Signals::new([SIGTERM, SIGINT, SIGHUP]) else { return };
    let handle = signals.handle();
    let ctx = ctx.clone();
    let work = move || {
        for _ in signals.forever() {
            ctx.send_viewport_cmd_to(ViewportId::ROOT, ViewportCommand::Close);
        }
    };
    if std::thread::Builder::new().name("signals".into()).spawn(work).is_err() {
        handle.close();
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::time::{Duration, Instant};

    use eframe::egui::RawInput;

    use super::*;

    /// Whether a pass of the window tells it to close.
    fn closes(ctx: &Context) -> bool {
        let mut output = ctx.run_ui(RawInput::default(), |_| {});
        // Nothing is drawn; the toolkit wants to hear so.
        output.textures_delta.clear();
        output.viewport_output.values().any(|window| window.commands.contains(&ViewportCommand::Close))
    }

    #[test]
    fn a_signal_closes_the_window_and_not_the_program() {
        let ctx = Context::default();
        close_window_on_signal(&ctx);
        assert!(!closes(&ctx), "nobody has asked yet");
        for signal in ["-TERM", "-INT"] {
            let sent = Command::new("kill").args([signal, &std::process::id().to_string()]).status();
            assert!(sent.expect("there is kill").success());
            let deadline = Instant::now() + Duration::from_secs(20);
            while !closes(&ctx) {
                assert!(Instant::now() < deadline, "{signal} arrives");
                std::thread::sleep(Duration::from_millis(5));
            }
        }
    }
}
