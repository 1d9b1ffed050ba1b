//! What is kept between runs.

use std::path::{Path, PathBuf};

use eframe::egui::ThemePreference;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The window as it was left. Its place is the window system's to choose: the screen it was on may be gone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindowPrefs {
    /// Width and height in points at an interface scale of 1, while it does not fill the screen.
    pub size: [f32; 2],
    /// It filled the screen.
    pub maximized: bool,
    /// Widths of the left and the right column in points.
    pub columns: [f32; 2],
}

impl Default for WindowPrefs {
    fn default() -> Self {
        Self { size: [1440.0, 900.0], maximized: false, columns: [320.0, 340.0] }
    }
}

/// Everything kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Prefs {
    /// Light, dark or as the system.
    #[serde(serialize_with = "write_theme", deserialize_with = "read_theme")]
    pub theme: ThemePreference,
    /// Interface scale.
    pub zoom: f32,
    /// The left panel and the status bar are shown; without them it is the projector view.
    pub panels: bool,
    /// The right panel is shown.
    pub inspector: bool,
    /// No fades: what changes, changes at once.
    pub reduce_motion: bool,
    /// A PNG of the view beside each snapshot.
    pub png: bool,
    /// The window.
    pub window: WindowPrefs,
    /// Files opened and saved, the last one first.
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
            png: false,
            window: WindowPrefs::default(),
            recent: Vec::new(),
        }
    }
}

impl Prefs {
    /// Scenes remembered, and as many snapshots: saving many must not push out what they were made from.
    const RECENT: usize = 6;
    /// Interface scales offered.
    pub const ZOOM: std::ops::RangeInclusive<f32> = 0.5..=4.0;
    /// Sides of a window that some screen may have, in points.
    const SIDE: std::ops::RangeInclusive<f32> = 200.0..=16384.0;
    /// Widths of a column.
    const COLUMN: std::ops::RangeInclusive<f32> = 200.0..=1000.0;

    /// Puts a file at the top of the recent ones.
    pub fn remember(&mut self, path: PathBuf) {
        // The next run may be started elsewhere.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.forget_oldest();
    }

    fn forget_oldest(&mut self) {
        let mut left = [Self::RECENT; 2];
        self.recent.retain(|path| {
            let left = &mut left[usize::from(is_snapshot(path))];
            let kept = *left > 0;
            *left -= usize::from(kept);
            kept
        });
    }

    /// From a text that anyone may have written, and what of it cannot be used and was left out.
    pub fn from_json(text: &str) -> (Self, Vec<String>) {
        let mut dropped = Vec::new();
        let stored = match serde_json::from_str(text) {
            Ok(serde_json::Value::Object(stored)) => stored,
            Ok(_) => return (Self::default(), vec!["all of it: expected an object".into()]),
            Err(error) => return (Self::default(), vec![format!("all of it: {error}")]),
        };
        // One bad entry costs that entry.
        let mut prefs = Self::default();
        for (key, value) in stored {
            let mut with_it = match serde_json::to_value(&prefs) {
                Ok(serde_json::Value::Object(map)) => map,
                Ok(_) | Err(_) => continue,
            };
            if with_it.insert(key.clone(), value.clone()).is_none() {
                // Of another version.
                continue;
            }
            match serde_json::from_value(serde_json::Value::Object(with_it)) {
                Ok(better) => prefs = better,
                Err(_) => dropped.push(format!("{key}: {value}")),
            }
        }
        prefs.check(&mut dropped);
        (prefs, dropped)
    }

    /// Replaces what no screen can have.
    fn check(&mut self, dropped: &mut Vec<String>) {
        let usual = Self::default();
        if !Self::ZOOM.contains(&self.zoom) {
            dropped.push(format!("zoom: {:?}", self.zoom));
            self.zoom = usual.zoom;
        }
        let WindowPrefs { size, maximized: _, columns } = &mut self.window;
        if !size.iter().all(|side| Self::SIDE.contains(side)) {
            dropped.push(format!("window size: {:?} x {:?}", size[0], size[1]));
            *size = usual.window.size;
        }
        if !columns.iter().all(|width| Self::COLUMN.contains(width)) {
            dropped.push(format!("widths of the columns: {:?} and {:?}", columns[0], columns[1]));
            *columns = usual.window.columns;
        }
        self.forget_oldest();
    }
}

fn is_snapshot(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// The themes as they are called in the file.
const THEMES: [(&str, ThemePreference); 3] =
    [("light", ThemePreference::Light), ("dark", ThemePreference::Dark), ("system", ThemePreference::System)];

fn write_theme<S: Serializer>(theme: &ThemePreference, to: S) -> Result<S::Ok, S::Error> {
    let name = THEMES.iter().find(|(_, t)| t == theme).map_or("system", |(name, _)| name);
    to.serialize_str(name)
}

fn read_theme<'de, D: Deserializer<'de>>(from: D) -> Result<ThemePreference, D::Error> {
    let name = String::deserialize(from)?;
    let found = THEMES.iter().find(|(n, _)| *n == name).map(|(_, theme)| *theme);
    found.ok_or_else(|| serde::de::Error::custom("expected light, dark or system"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back() {
        let mut prefs =
            Prefs { theme: ThemePreference::Dark, zoom: 1.25, panels: false, png: true, ..Prefs::default() };
        prefs.window = WindowPrefs { size: [1000.5, 700.0], maximized: true, columns: [300.0, 400.0] };
        prefs.remember("/a/b.pbrt".into());
        let text = serde_json::to_string(&prefs).expect("can be written");
        assert_eq!(Prefs::from_json(&text), (prefs, Vec::new()));
    }

    #[test]
    fn what_cannot_be_is_left_out_and_named_and_the_rest_is_kept() {
        for (bad, named) in [
            (r#""zoom": 1e30"#, "zoom"),
            (r#""zoom": "large""#, "zoom"),
            (r#""window": {"size": [1e9, 700]}"#, "window size: 1000000000.0 x 700.0"),
            (r#""window": {"size": [1000, -5]}"#, "window size"),
            (r#""window": {"size": [1e999, 700]}"#, ""),
            (r#""window": {"columns": [0, 300]}"#, "columns"),
            (r#""theme": "pink""#, "theme: \"pink\""),
            (r#""recent": [3]"#, "recent"),
        ] {
            let (prefs, dropped) = Prefs::from_json(&format!("{{\"png\": true, {bad}, \"inspector\": false}}"));
            assert_eq!(dropped.len(), 1, "{bad}: {dropped:?}");
            assert!(dropped[0].contains(named), "{bad}: {dropped:?}");
            // A number that no float can hold is no JSON at all.
            if !named.is_empty() {
                assert!(prefs.png && !prefs.inspector, "{bad} costs nothing else");
            }
            assert_eq!((prefs.zoom, prefs.window), (1.0, WindowPrefs::default()), "{bad}");
        }
        for text in ["", "[]", "(not: json)", "{\"zoom\": NaN}"] {
            let (prefs, dropped) = Prefs::from_json(text);
            assert_eq!((prefs, dropped.len()), (Prefs::default(), 1), "{text}");
        }
        assert_eq!(Prefs::from_json(r#"{"later": 1}"#), (Prefs::default(), Vec::new()), "another version is no fault");
    }

    #[test]
    fn many_snapshots_leave_the_scenes() {
        let mut prefs = Prefs::default();
        prefs.remember("/a/scene.pbrt".into());
        for n in 0..20 {
            prefs.remember(format!("/a/{n}.exr").into());
        }
        assert_eq!(prefs.recent.len(), Prefs::RECENT + 1);
        assert_eq!(prefs.recent.last(), Some(&PathBuf::from("/a/scene.pbrt")));
    }
}
