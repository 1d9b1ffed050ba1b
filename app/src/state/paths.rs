//! Paths as people type them, and as they are shown.

use std::path::{Path, PathBuf};

use mislab_renderer::platform;

/// A path as people type it: with the quotes or the `file://` that a file manager copies, `~` for the home folder.
pub fn typed(text: &str) -> PathBuf {
    let text = text.trim().trim_matches(['"', '\'']);
    match text.strip_prefix("file://") {
        // As addresses are written: %20 for a space.
        Some(address) => platform::path_of_address(&decoded(address)),
        None => expand_home(PathBuf::from(text)),
    }
}

/// `~` and `~/...` in the home folder of this user; shells do that for some arguments and not for others.
pub fn expand_home(path: PathBuf) -> PathBuf {
    match (path.strip_prefix("~"), std::env::home_dir()) {
        (Ok(rest), Some(home)) => home.join(rest),
        _ => path,
    }
}

/// The name of a file, its middle left out if it is long.
pub fn short_name(path: &Path) -> String {
    let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    shortened(&name, 48)
}

/// At most `most` characters: of longer text the beginning and the end, which tell paths and names apart.
pub fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let kept = most.saturating_sub(1);
    let (head, tail) = (kept / 2, kept - kept / 2);
    let head: String = text.chars().take(head).collect();
    let tail: String = text.chars().skip(count - tail).collect();
    format!("{head}\u{2026}{tail}")
}

/// Without the `%XX` of addresses; what is no such thing stays.
fn decoded(address: &str) -> String {
    let mut bytes = Vec::with_capacity(address.len());
    let mut rest = address.as_bytes();
    while let [first, others @ ..] = rest {
        let escaped = (*first == b'%').then(|| others.get(..2)).flatten();
        let byte =
            escaped.and_then(|hex| std::str::from_utf8(hex).ok()).and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &others[2..] } else { others };
    }
    String::from_utf8(bytes).unwrap_or_else(|_| address.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typed_paths_lose_their_wrapping() {
        assert_eq!(typed(" \"/a b/c.pbrt\" "), PathBuf::from("/a b/c.pbrt"));
        assert_eq!(typed("file:///a/c.exr"), PathBuf::from("/a/c.exr"));
        assert_eq!(typed("file:///a/my%20scene%.pbrt"), PathBuf::from("/a/my scene%.pbrt"));
        assert_eq!(typed("100%25.pbrt"), PathBuf::from("100%25.pbrt"), "a path is no address");
        let home = std::env::home_dir().expect("a home folder");
        assert_eq!(typed("~/a.pbrt"), home.join("a.pbrt"));
        assert_eq!(typed("~"), home.join(""));
        assert_eq!(typed("a~/b"), PathBuf::from("a~/b"));
    }

    #[test]
    fn long_names_keep_both_ends() {
        assert_eq!(shortened("short", 10), "short");
        assert_eq!(shortened("a_long_name_64spp.exr", 11), "a_lon\u{2026}p.exr");
        assert_eq!(short_name(&Path::new("/a").join("x".repeat(300))).chars().count(), 48);
    }
}
