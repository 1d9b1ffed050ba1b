//! How large the interface is drawn: from the window's height, times what the user wants.

use eframe::egui::Vec2;

use super::theme::TypeScale;

/// Width in points at which both columns stand beside the picture.
pub const FULL_WIDTH: f32 = 1100.0;

/// One step of the interface's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoomStep {
    /// One step up.
    Larger,
    /// One step down.
    Smaller,
    /// Back to 100 %.
    Reset,
}

/// The sizes there are: whoever goes up and down comes back to where he was.
const LADDER: [f32; 14] = [0.5, 0.67, 0.75, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0];

impl ZoomStep {
    /// The size after this step from `zoom`.
    pub fn from(self, zoom: f32) -> f32 {
        let mut steps = LADDER.into_iter();
        match self {
            Self::Larger => steps.find(|step| *step > zoom + 1e-3).unwrap_or(zoom),
            Self::Smaller => steps.rfind(|step| *step < zoom - 1e-3).unwrap_or(zoom),
            Self::Reset => 1.0,
        }
    }
}

/// The toolkit's factor for a window of `native` points (at the system's own factor) and a user who wants `zoom`.
pub fn factor(native: Vec2, scale: TypeScale, zoom: f32) -> f32 {
    (automatic(native, scale) * zoom).min(room(native, scale))
}

/// At a desk type is a 64th of the window's height, and readable in the smallest window; in a hall about a 28th (26 of
/// 720), whatever the window.
fn automatic(native: Vec2, scale: TypeScale) -> f32 {
    let (by_size, least) = match scale {
        TypeScale::Desk => (native.y / 1024.0, 1.0),
        TypeScale::Hall => ((native.y / 720.0).min(native.x / 960.0), 0.4),
    };
    // Steps of a twentieth, so that type does not swim while a window is resized.
    ((by_size * 20.0 + 1e-3).floor() / 20.0).max(least)
}

/// The largest factor at which everything still fits beside the picture.
pub fn room(native: Vec2, scale: TypeScale) -> f32 {
    match scale {
        TypeScale::Desk => (native.x / FULL_WIDTH).max(1.0),
        TypeScale::Hall => automatic(native, scale),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::vec2;

    #[test]
    fn steps_up_and_down_meet_again() {
        let mut zoom = 1.0;
        for _ in 0..6 {
            zoom = ZoomStep::Larger.from(zoom);
        }
        assert!(zoom > 2.0, "{zoom}");
        for _ in 0..6 {
            zoom = ZoomStep::Smaller.from(zoom);
        }
        assert_eq!(zoom, 1.0);
        assert_eq!(ZoomStep::Larger.from(4.0), 4.0, "there is nothing above the last");
        assert_eq!(ZoomStep::Smaller.from(0.5), 0.5);
    }

    #[test]
    fn type_grows_with_the_window() {
        let desk = |w, h| factor(vec2(w, h), TypeScale::Desk, 1.0);
        assert_eq!(desk(1280.0, 720.0), 1.0);
        assert_eq!(desk(2560.0, 1440.0), 1.4);
        assert_eq!(desk(3840.0, 2160.0), 2.1);
        assert_eq!(desk(1080.0, 1920.0), 1.0, "the columns fit still");
        let body = TypeScale::Hall.sizes()[1];
        for (w, h) in [(1280.0, 720.0), (1920.0, 1080.0), (2560.0, 1440.0), (640.0, 400.0)] {
            let points = body * factor(vec2(w, h), TypeScale::Hall, 1.0);
            assert!((26.0..31.0).contains(&(h / points)), "{w} x {h}: a {}th", h / points);
        }
    }
}
