//! Names of files: what may be one on every machine of a class.

/// Characters that Windows cannot hold in a name, besides the two slashes.
const FORBIDDEN: [char; 7] = ['<', '>', ':', '"', '|', '?', '*'];
/// Longest name, in bytes: file systems end at 255, and a number and an extension come after it.
const LONGEST: usize = 200;
/// Longest beginning that comes from the name of a scene, in characters.
const LONGEST_DEFAULT: usize = 80;

/// Why `name` cannot be the name of a file, without extension, on some machine that it may be carried to.
///
/// # Errors
/// One sentence: what was found and what to do instead.
pub fn check(name: &str) -> Result<(), String> {
    if name.is_empty() {
        return Err("a name is missing".into());
    }
    if let Some(slash) = name.chars().find(|c| matches!(c, '/' | '\\')) {
        return Err(format!("a name has no {slash} in it: folders are named apart from it"));
    }
    if name == "." || name == ".." {
        return Err(format!("{name} is a folder, expected a name"));
    }
    if let Some(c) = name.chars().find(|c| FORBIDDEN.contains(c)) {
        return Err(format!("Windows cannot hold {c} in a name: leave it out"));
    }
    if name.chars().any(char::is_control) {
        return Err("there is an invisible control character in this name: type it anew".into());
    }
    if name.ends_with(['.', ' ']) {
        return Err("Windows cannot hold a name that ends in a dot or a space".into());
    }
    if is_device(name) {
        return Err(format!("Windows keeps the name {name} for a device: choose another"));
    }
    if name.len() > LONGEST {
        return Err(format!("this name has {} bytes, expected at most {LONGEST}", name.len()));
    }
    Ok(())
}

/// The nearest to `text` that [`check`] accepts.
pub fn usable(text: &str) -> String {
    let replaced = |c: char| if c.is_control() || matches!(c, '/' | '\\') || FORBIDDEN.contains(&c) { '_' } else { c };
    let mut name: String = text.trim().chars().map(replaced).take(LONGEST_DEFAULT).collect();
    // A character takes up to four bytes.
    while name.len() > LONGEST / 2 {
        name.pop();
    }
    name.truncate(name.trim_end_matches(['.', ' ']).len());
    if name.is_empty() {
        return "mislab".into();
    }
    if is_device(&name) { format!("{name}_") } else { name }
}

/// Names of devices, with whatever extension.
fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or(name).trim_end().to_ascii_uppercase();
    let numbered = |device: &str| {
        stem.strip_prefix(device).is_some_and(|n| n.len() == 1 && n.starts_with(|c: char| ('1'..='9').contains(&c)))
    };
    matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL") || numbered("COM") || numbered("LPT")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_some_machine_cannot_hold_are_refused_with_words() {
        for (name, words) in [
            ("", "missing"),
            ("a/b", "no / in it"),
            ("../b", "no / in it"),
            ("a\\b", "no \\ in it"),
            ("..", "folder"),
            ("what?", "Windows cannot hold ?"),
            ("a:b", "Windows cannot hold :"),
            ("a\tb", "control character"),
            ("name.", "dot or a space"),
            ("nul", "device"),
            ("COM1.old", "device"),
            (&"x".repeat(300), "300 bytes"),
        ] {
            let message = check(name).expect_err(name);
            assert!(message.contains(words), "{name}: {message}");
        }
        for name in ["veach_mis_light_64spp", "a..b", ".hidden", "Übung 3", "console", "COM10", &"x".repeat(200)] {
            assert_eq!(check(name), Ok(()), "{name}");
        }
    }

    #[test]
    fn any_name_of_a_scene_becomes_usable() {
        let names = ["", "..", "a/b", "a?b:c", "con", "name. ", &"x".repeat(300), &"\u{1f600}".repeat(300), "\u{0}"];
        for name in names {
            assert_eq!(check(&usable(name)), Ok(()), "{name:?} became {:?}", usable(name));
        }
        assert_eq!(usable("veach_mis"), "veach_mis");
        assert_eq!(usable("a?b"), "a_b");
    }
}
