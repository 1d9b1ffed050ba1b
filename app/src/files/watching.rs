//! Notices when files change that others edit.
//!
//! A thread looks at a few files several times a second: that works on every disk, network drives included, and whatever
//! an editor does, write the file or put another in its place. A change counts when it has come to rest.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use mislab_renderer::platform;

/// How often to look.
const EVERY: Duration = Duration::from_millis(150);

/// How many looks a missing file is waited for: some editors remove it before they put the new one there.
const MISSING_FOR: u32 = 10;

/// Longer texts are not kept for comparison.
const MOST_TEXT: u64 = 4 << 20;

/// What of a file changes when its content does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    modified: Option<SystemTime>,
    bytes: u64,
    identity: u64,
}

/// The stamp of a file, `None` if it is not there.
pub fn stamp(path: &Path) -> Option<Stamp> {
    let metadata = fs::metadata(path).ok()?;
    let identity = platform::identity(&metadata);
    Some(Stamp { modified: metadata.modified().ok(), bytes: metadata.len(), identity })
}

/// A file as it was when it was read.
#[derive(Clone, Debug)]
pub struct Watched {
    /// The file.
    pub path: PathBuf,
    /// `None` if it was not there.
    pub stamp: Option<Stamp>,
    /// Its lines, if it is a text that people edit; of one that is gone, the last that were read.
    pub text: Option<Arc<str>>,
}

impl Watched {
    /// The file as it is now; `stamp` from before it was read. One that is not there has the text that it had `before`: it may
    /// be written again.
    pub fn new(path: PathBuf, stamp: Option<Stamp>, before: &[Self]) -> Self {
        if stamp.is_none() {
            let text = before.iter().find(|file| file.path == path).and_then(|file| file.text.clone());
            return Self { path, stamp, text };
        }
        let text = stamp.filter(|stamp| stamp.bytes <= MOST_TEXT && is_scene(&path));
        let text = text.and_then(|_| fs::read(&path).ok()).map(|bytes| String::from_utf8_lossy(&bytes).into());
        Self { path, stamp, text }
    }
}

fn is_scene(path: &Path) -> bool {
    path.extension().is_none_or(|e| e.eq_ignore_ascii_case("pbrt"))
}

/// A thread that looks after files; dropping it ends it.
pub struct Watcher {
    state: Arc<Mutex<State>>,
    /// Held for its end.
    _alive: Sender<()>,
}

#[derive(Default)]
struct State {
    files: Vec<(PathBuf, Option<Stamp>)>,
    /// How it looked the last time, if otherwise than it was read.
    suspected: Option<Vec<Option<Stamp>>>,
    missing: u32,
    /// What has changed has been told.
    told: bool,
}

impl Watcher {
    /// Calls `changed` once for each set of files, when one of them has changed.
    pub fn new(changed: impl Fn() + Send + 'static) -> Self {
        let state = Arc::<Mutex<State>>::default();
        let (alive, end) = channel();
        let shared = state.clone();
        // Without a thread files are read again by hand.
        let _ = std::thread::Builder::new().name("watching".into()).spawn(move || watch(&shared, &end, &changed));
        Self { state, _alive: alive }
    }

    /// Looks after these files from here on.
    pub fn watch(&self, files: &[Watched]) {
        let files = files.iter().map(|file| (file.path.clone(), file.stamp)).collect();
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = State { files, ..State::default() };
    }
}

fn watch(state: &Mutex<State>, end: &Receiver<()>, changed: &impl Fn()) {
    while end.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
        let files = {
            let state = state.lock().unwrap_or_else(PoisonError::into_inner);
            if state.told { Vec::new() } else { state.files.clone() }
        };
        if files.is_empty() {
            continue;
        }
        // Not under the lock: a network drive may take its time.
        let now: Vec<Option<Stamp>> = files.iter().map(|(path, _)| stamp(path)).collect();
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.files == files && state.look(now) {
            drop(state);
            changed();
        }
    }
}

impl State {
    /// Takes a look; true when a change has come to rest.
    fn look(&mut self, now: Vec<Option<Stamp>>) -> bool {
        let same = self.files.iter().zip(&now).all(|((_, then), now)| then == now);
        if same {
            self.suspected = None;
            self.missing = 0;
            return false;
        }
        let lost = self.files.iter().zip(&now).any(|((_, then), now)| then.is_some() && now.is_none());
        self.missing = if lost { self.missing + 1 } else { 0 };
        let at_rest = self.suspected.as_ref() == Some(&now);
        self.suspected = Some(now);
        self.told = at_rest && (!lost || self.missing >= MISSING_FOR);
        self.told
    }
}

/// What has changed from one reading to the next, in words: "line 3", "lines 3, 7 and 12", "lines 3 to 9 of lights.pbrt".
/// Empty if nothing has that is kept.
pub fn changes(before: &[Watched], after: &[Watched]) -> String {
    let mut said = Vec::new();
    for (index, new) in after.iter().enumerate() {
        let name = || new.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // The scene file itself is named elsewhere.
        let of = |lines: String| if index == 0 { lines } else { format!("{lines} of {}", name()) };
        match before.iter().find(|old| old.path == new.path) {
            Some(Watched { text: Some(old), .. }) if new.stamp.is_some() && new.text.is_some() => {
                let new = new.text.as_deref().unwrap_or_default();
                said.extend(changed_lines(old, new).map(of));
            }
            Some(old) if old.stamp != new.stamp => said.push(name()),
            Some(_) | None => {}
        }
    }
    said.join("; ")
}

/// Which lines of `new` differ from `old`, in words.
fn changed_lines(old: &str, new: &str) -> Option<String> {
    const MOST: usize = 6;
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let head = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let (old, rest) = (&old[head..], &new[head..]);
    let tail = old.iter().rev().zip(rest.iter().rev()).take_while(|(a, b)| a == b).count();
    let (old, rest) = (&old[..old.len() - tail], &rest[..rest.len() - tail]);
    let lines: Vec<usize> = match (old.len(), rest.len()) {
        (0, 0) => return None,
        // Edits in place: each line by itself.
        (a, b) if a == b => (0..b).filter(|i| old[*i] != rest[*i]).map(|i| head + i + 1).collect(),
        (_, 0) => return Some(format!("lines left out after line {head}")),
        (_, b) => (head + 1..=head + b).collect(),
    };
    let (first, last) = (*lines.first()?, *lines.last()?);
    Some(match lines.as_slice() {
        [one] => format!("line {one}"),
        [some @ .., last] if lines.len() <= MOST && last - first != lines.len() - 1 => {
            let some: Vec<String> = some.iter().map(usize::to_string).collect();
            format!("lines {} and {last}", some.join(", "))
        }
        [a, b] => format!("lines {a} and {b}"),
        _ => format!("lines {first} to {last}"),
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
    use std::time::Instant;

    use super::*;

    fn read(paths: &[&Path]) -> Vec<Watched> {
        read_after(&[], paths)
    }

    fn read_after(before: &[Watched], paths: &[&Path]) -> Vec<Watched> {
        paths.iter().map(|path| Watched::new(path.to_path_buf(), stamp(path), before)).collect()
    }

    #[test]
    fn lines_are_named() {
        let old = "a\nb\nc\nd\ne\nf\n";
        for (new, words) in [
            ("a\nb\nc\nd\ne\nf\n", None),
            ("a\nB\nc\nd\ne\nf\n", Some("line 2")),
            ("a\nB\nC\nd\ne\nf\n", Some("lines 2 and 3")),
            ("A\nb\nc\nD\ne\nF\n", Some("lines 1, 4 and 6")),
            ("a\nB\nC\nD\nE\nf\n", Some("lines 2 to 5")),
            ("a\nb\nx\nc\nd\ne\nf\n", Some("line 3")),
            ("a\nb\nx\ny\nz\nd\ne\nf\n", Some("lines 3 to 5")),
            ("a\nb\ne\nf\n", Some("lines left out after line 2")),
            ("", Some("lines left out after line 0")),
        ] {
            assert_eq!(changed_lines(old, new).as_deref(), words, "{new:?}");
        }
    }

    #[test]
    fn a_file_that_was_gone_for_long_is_compared_with_what_it_was() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let main = folder.path().join("main.pbrt");
        fs::write(&main, "one\ntwo\n").expect("write");
        let first = read(&[&main]);
        fs::remove_file(&main).expect("remove");
        let gone = read_after(&first, &[&main]);
        assert_eq!(changes(&first, &gone), "main.pbrt");
        fs::write(&main, "one\n2\n").expect("write");
        assert_eq!(changes(&gone, &read_after(&gone, &[&main])), "line 2");
    }

    #[test]
    fn every_way_to_save_is_noticed_once() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (main, part) = (folder.path().join("main.pbrt"), folder.path().join("part.ply"));
        fs::write(&main, "one\ntwo\n").expect("write");
        let count = Arc::new(AtomicU32::new(0));
        let there = Arc::new(AtomicBool::new(false));
        let (counter, flag, file) = (count.clone(), there.clone(), main.clone());
        let watcher = Watcher::new(move || {
            flag.store(file.exists(), Ordering::Relaxed);
            counter.fetch_add(1, Ordering::Relaxed);
        });
        let noticed = |expected: u32, what: &str| {
            let deadline = Instant::now() + Duration::from_secs(20);
            while count.load(Ordering::Relaxed) < expected {
                assert!(Instant::now() < deadline, "not noticed: {what}");
                std::thread::sleep(Duration::from_millis(20));
            }
            std::thread::sleep(4 * EVERY);
            assert_eq!(count.load(Ordering::Relaxed), expected, "once: {what}");
        };
        let before = read(&[&main, &part]);
        watcher.watch(&before);
        noticed(0, "nothing");
        fs::write(&main, "one\n2\n").expect("write");
        noticed(1, "written in place");
        let after = read(&[&main, &part]);
        assert_eq!(changes(&before, &after), "line 2");
        watcher.watch(&after);
        let other = folder.path().join("main.pbrt~");
        fs::write(&other, "one\n2\n").expect("write");
        fs::rename(&other, &main).expect("rename");
        noticed(2, "put in its place, with the same content");
        watcher.watch(&read(&[&main, &part]));
        fs::remove_file(&main).expect("remove");
        std::thread::sleep(3 * EVERY);
        fs::write(&main, "one\n").expect("write");
        noticed(3, "gone for a moment");
        assert!(there.load(Ordering::Relaxed), "not before it is back");
        watcher.watch(&read(&[&main, &part]));
        fs::remove_file(&main).expect("remove");
        noticed(4, "gone");
        assert!(!there.load(Ordering::Relaxed), "gone for good");
        let before = read(&[&main, &part]);
        watcher.watch(&before);
        fs::write(&part, "ply").expect("write");
        noticed(5, "a file that was missing");
        assert_eq!(changes(&before, &read(&[&main, &part])), "part.ply");
    }
}
