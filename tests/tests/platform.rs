//! What differs by operating system stands in few places.

use std::path::Path;

/// Where it may: files, the window's surroundings and signals, and what Windows starts by a double click.
const PLACES: [&str; 5] = [
    "renderer/src/platform.rs",
    "app/src/files/room.rs",
    "app/src/launch/mod.rs",
    "app/src/launch/surroundings.rs",
    "app/src/bin/mislab-window.rs",
];

/// What such code says.
const SIGNS: [&str; 7] = ["std::os::", "target_os", "target_family", "(unix", "(windows", "unix,", "windows,"];

/// Files of a folder that differ by operating system, without their unit tests.
fn differing(root: &Path, folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(root.join(folder)).expect("a folder of sources").flatten() {
        let path = folder.join(entry.file_name());
        if entry.path().is_dir() {
            differing(root, &path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(entry.path()).expect("a source can be read");
            let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
            let differs = |line: &str| {
                (line.contains("cfg") || line.contains("std::os::")) && SIGNS.iter().any(|sign| line.contains(sign))
            };
            if code.lines().any(differs) {
                found.push(path.to_string_lossy().replace('\\', "/"));
            }
        }
    }
}

#[test]
fn systems_differ_in_few_places() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    for krate in ["app/src", "renderer/src", "renderer/kernel/src"] {
        differing(&root, Path::new(krate), &mut found);
    }
    found.sort();
    let mut expected = PLACES.map(str::to_owned).to_vec();
    expected.sort();
    assert_eq!(found, expected);
}
