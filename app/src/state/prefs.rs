//! What is kept between runs.

use std::path::PathBuf;

use eframe::egui::ThemePreference;
use serde::{Deserialize, Serialize};

/// Where snapshots go.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SavePrefs {
    /// The folder.
    pub folder: PathBuf,
    /// The name, without number and extension.
    pub stem: String,
    /// A PNG of the view beside the EXR.
    pub png: bool,
}

impl Default for SavePrefs {
    fn default() -> Self {
        let folder = std::env::current_dir().ok().filter(|f| f.parent().is_some());
        let folder = folder.or_else(std::env::home_dir).unwrap_or_else(|| PathBuf::from("."));
        Self { folder, stem: String::new(), png: false }
    }
}

/// Everything kept; the size and place of the window is kept by the window library.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Prefs {
    /// Light, dark or as the system.
    pub theme: ThemePreference,
    /// Interface scale.
    pub zoom: f32,
    /// The left panel and the status bar are shown; without them it is the projector view.
    pub panels: bool,
    /// The right panel is shown.
    pub inspector: bool,
    /// No fades: what changes, changes at once.
    pub reduce_motion: bool,
    /// Snapshots.
    pub save: SavePrefs,
    /// Files opened, the last one first.
    pub recent: Vec<PathBuf>,
}

impl Default for Prefs {
    fn default() -> Self {
        Self {
            theme: ThemePreference::System,
            zoom: 1.0,
            panels: true,
            inspector: true,
            reduce_motion: false,
            save: SavePrefs::default(),
            recent: Vec::new(),
        }
    }
}

impl Prefs {
    /// Files remembered.
    const RECENT: usize = 10;
    /// Interface scales offered.
    pub const ZOOM: std::ops::RangeInclusive<f32> = 0.5..=4.0;

    /// Puts a file at the top of the recent ones.
    pub fn remember(&mut self, path: PathBuf) {
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.recent.truncate(Self::RECENT);
    }

    /// Values from a file that may have been written by anyone.
    pub fn sane(mut self) -> Self {
        if !Self::ZOOM.contains(&self.zoom) {
            self.zoom = 1.0;
        }
        self.recent.truncate(Self::RECENT);
        self
    }
}
