//! The file that preferences are kept in: read before there is a window, written whenever something changes.

use std::fs;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mislab_renderer::snapshot::write_file;

use crate::state::paths::shortened;
use crate::state::prefs::Prefs;

/// Longer files are none of ours.
const MOST_BYTES: u64 = 1 << 20;

/// How long a change waits for the next one: a window that is being resized changes at every pass.
const REST: Duration = Duration::from_millis(1500);

/// Where preferences are kept on this machine; `None` without a home.
pub fn place() -> Option<PathBuf> {
    Some(directories::ProjectDirs::from("", "", "mislab")?.data_dir().join("preferences.json"))
}

/// The preferences in a file, and a sentence about what could not be used. No file is nothing to be said.
pub fn load(path: &Path) -> (Prefs, Option<String>) {
    let mut text = String::new();
    let read = match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => Err("this is no file".to_owned()),
        Ok(_) => fs::File::open(path)
            .and_then(|file| file.take(MOST_BYTES).read_to_string(&mut text))
            .map_err(|error| error.to_string()),
        Err(error) if error.kind() == ErrorKind::NotFound => return (Prefs::default(), None),
        Err(error) => Err(error.to_string()),
    };
    let (prefs, dropped) = match read {
        Ok(_) => Prefs::from_json(&text),
        Err(error) => (Prefs::default(), vec![format!("all of it: {error}")]),
    };
    let said = (!dropped.is_empty()).then(|| {
        let dropped: Vec<String> = dropped.iter().map(|entry| shortened(entry, 60)).collect();
        format!("Of the settings kept from the last run this could not be used: {}.", dropped.join("; "))
    });
    (prefs, said)
}

/// Writes the preferences. A disk that is full or read-only costs them, and no word: pictures will say it.
pub fn write(path: &Path, prefs: &Prefs) {
    let Ok(text) = serde_json::to_string_pretty(prefs) else { return };
    if let Some(folder) = path.parent() {
        let _ = fs::create_dir_all(folder);
    }
    let _ = write_file(path, text.as_bytes());
}

/// When a file with preferences is to be written again.
pub struct Kept {
    /// The file.
    pub path: PathBuf,
    written: Option<Prefs>,
    changed_at: Option<Instant>,
}

/// What is to be done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// The file is as it should be.
    No,
    /// Something has changed: ask again then.
    In(Duration),
    /// It is to be written.
    Now,
}

impl Kept {
    /// For a file that holds `written`; `None` if it holds something that could not be used, lest that be said again.
    pub fn new(path: PathBuf, written: Option<Prefs>) -> Self {
        Self { path, written, changed_at: None }
    }

    /// Whether `prefs` are to be written; after [`Due::Now`] they count as written.
    pub fn due(&mut self, prefs: &Prefs, closing: bool) -> Due {
        if self.written.as_ref() == Some(prefs) {
            self.changed_at = None;
            return Due::No;
        }
        let since = self.changed_at.get_or_insert_with(Instant::now).elapsed();
        let left = REST.saturating_sub(since);
        if !left.is_zero() && !closing {
            return Due::In(left);
        }
        self.written = Some(prefs.clone());
        self.changed_at = None;
        Due::Now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_written_when_they_have_come_to_rest() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deep").join("preferences.json");
        assert_eq!(load(&path), (Prefs::default(), None), "no file yet");
        let mut kept = Kept::new(path.clone(), Some(Prefs::default()));
        assert_eq!(kept.due(&Prefs::default(), true), Due::No, "nothing to write");
        let changed = Prefs { zoom: 1.5, ..Prefs::default() };
        assert!(matches!(kept.due(&changed, false), Due::In(_)), "not at once");
        kept.changed_at = Instant::now().checked_sub(REST);
        assert_eq!(kept.due(&changed, false), Due::Now, "and long before the end of the run");
        assert_eq!(kept.due(&changed, true), Due::No, "once");
        assert_eq!(kept.due(&Prefs::default(), true), Due::Now, "at the end at once");
        write(&path, &changed);
        assert_eq!(load(&path), (changed, None));
    }

    #[test]
    fn a_damaged_file_is_said_in_one_sentence() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("preferences.json");
        fs::write(&path, b"\xff\xfe\0").expect("write");
        let (prefs, said) = load(&path);
        assert_eq!(prefs, Prefs::default());
        assert!(said.is_some_and(|said| said.starts_with("Of the settings kept")));
        let (prefs, said) = load(folder.path());
        assert!(prefs == Prefs::default() && said.is_some(), "a folder in its place");
    }
}
