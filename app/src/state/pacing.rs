//! How fast the live pictures go.

use mislab_renderer::Pace;

/// Held, slowly or at full speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pacing {
    /// Held.
    pub paused: bool,
    /// Passes per second; `None` is full speed.
    pub rate: Option<f32>,
    /// The last rate there was, to come back to.
    pub last_rate: f32,
}

impl Default for Pacing {
    fn default() -> Self {
        Self { paused: false, rate: None, last_rate: 2.0 }
    }
}

impl Pacing {
    /// The same for the renderer.
    pub fn pace(self) -> Pace {
        match self {
            Self { paused: true, .. } => Pace::Paused,
            Self { rate: Some(rate), .. } => Pace::PassesPerSecond(rate),
            Self { rate: None, .. } => Pace::Full,
        }
    }

    /// Goes on at that rate.
    pub fn set_rate(&mut self, rate: Option<f32>) {
        self.rate = rate;
        self.last_rate = rate.unwrap_or(self.last_rate);
        self.paused = false;
    }
}
