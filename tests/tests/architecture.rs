//! Who may know whom: what ARCHITECTURE.md promises of folders and files, read from the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The kernel's modules, each of which knows only those before it.
const KERNEL: &[&str] =
    &["lanes", "request", "stop", "sampler", "warp", "bsdf", "geometry", "light", "world", "estimator", "film", "tile"];

/// The renderer's.
const RENDERER: &[&str] = &[
    "near",
    "error",
    "platform",
    "file",
    "layer",
    "memory",
    "frame",
    "engine",
    "inspect",
    "black",
    "plane",
    "pbrt",
    "snapshot",
    "metrics",
    "batch",
    "table",
    "shade",
    "blind",
    "study",
    "convergence",
    "benchmark",
];

/// The app's, from below to above; commands of the command line do without a window, but for what they open.
const APP: &[&str] = &["look", "state", "picture", "files", "panel", "lab", "layout", "app", "launch", "cli"];

/// Module path (`estimator::heuristic`) and text of each file of a crate, without its unit tests.
fn sources(krate: &str) -> BTreeMap<String, String> {
    fn visit(folder: &Path, path: &str, found: &mut BTreeMap<String, String>) {
        for entry in std::fs::read_dir(folder).expect("the crate has sources").flatten() {
            let file = entry.path();
            let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let inner = if path.is_empty() { name.clone() } else { format!("{path}::{name}") };
            if file.is_dir() && inner == "bin" {
                // Programs: they know everything and nobody knows them, as `main.rs`.
            } else if file.is_dir() {
                visit(&file, &inner, found);
            } else if file.extension().is_some_and(|e| e == "rs") && !["lib", "main"].contains(&name.as_str()) {
                let text = std::fs::read_to_string(&file).expect("a source can be read");
                let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_owned();
                let module = if name == "mod" { path.to_owned() } else { inner };
                // `cli.rs` beside `cli/` is the same module's.
                found.insert(module, text);
            }
        }
    }
    let mut found = BTreeMap::new();
    visit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(krate).join("src"), "", &mut found);
    assert!(found.len() > 5, "{krate} has sources");
    found
}

/// Paths that begin with `crate::` or `super::`, as absolute module paths of the crate; groups in braces one by one.
fn paths(module: &str, text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let code: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.starts_with("//")).collect();
    for line in code.join(" ").split_inclusive(';') {
        for (start, root) in line.match_indices("crate::").chain(line.match_indices("super::")) {
            let before = line[..start].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let mut rest = &line[start..];
            let mut base: Vec<&str> = if root == "crate::" { Vec::new() } else { module.split("::").collect() };
            if root == "super::" {
                base.pop();
                rest = &rest["super::".len()..];
                while let Some(further) = rest.strip_prefix("super::") {
                    base.pop();
                    rest = further;
                }
            } else {
                rest = &rest["crate::".len()..];
            }
            let simple = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
            let end = rest.find(|c| !simple(c)).unwrap_or(rest.len());
            let head = rest[..end].trim_end_matches("::");
            let join = |tail: &str| {
                base.iter()
                    .copied()
                    .chain(head.split("::"))
                    .chain(tail.split("::"))
                    .filter(|s| !s.is_empty())
                    .collect::<Vec<_>>()
                    .join("::")
            };
            if rest[end..].starts_with('{') {
                for item in rest[end + 1..].split(['{', '}', ',']) {
                    found.insert(join(item.trim()));
                }
            } else {
                found.insert(join(""));
            }
        }
    }
    found
}

/// The files that each file of a crate names.
fn imports(krate: &str) -> BTreeMap<String, BTreeSet<String>> {
    let sources = sources(krate);
    let mut imports = BTreeMap::new();
    for (module, text) in &sources {
        let mut known = BTreeSet::new();
        for path in paths(module, text) {
            // The longest beginning of the path that is a file.
            let parts: Vec<&str> = path.split("::").collect();
            let file = (1..=parts.len()).rev().map(|n| parts[..n].join("::")).find(|p| sources.contains_key(p));
            known.extend(file.filter(|file| file != module));
        }
        imports.insert(module.clone(), known);
    }
    imports
}

fn top(module: &str) -> &str {
    module.split("::").next().unwrap_or(module)
}

#[test]
fn folders_know_only_those_below() {
    for (krate, order) in [("renderer/kernel", KERNEL), ("renderer", RENDERER), ("app", APP)] {
        let rank = |module: &str| order.iter().position(|m| *m == top(module));
        let mut crossing = 0;
        for (module, known) in imports(krate) {
            let here = rank(&module).unwrap_or_else(|| panic!("{krate}: {module} has no place in the order"));
            for other in known {
                let there = rank(&other).unwrap_or_else(|| panic!("{krate}: {other} has no place in the order"));
                assert!(there <= here, "{krate}: {module} knows {other}, which stands above it");
                crossing += usize::from(there < here);
            }
        }
        assert!(crossing > 5, "{krate}: imports are seen");
    }
}

#[test]
fn no_two_files_import_each_other() {
    for krate in ["renderer/kernel", "renderer", "app"] {
        let mut left = imports(krate);
        // A folder's own file names what is in the folder, and the other way round.
        for (module, known) in &mut left {
            known.retain(|other| {
                !other.starts_with(&format!("{module}::")) && !module.starts_with(&format!("{other}::"))
            });
        }
        // Those that know nobody who is left can go; what remains are circles.
        loop {
            let gone: Vec<String> = left.iter().filter(|(_, known)| known.is_empty()).map(|(m, _)| m.clone()).collect();
            if gone.is_empty() {
                break;
            }
            for module in &gone {
                left.remove(module);
            }
            for known in left.values_mut() {
                known.retain(|other| !gone.contains(other));
            }
        }
        assert!(left.is_empty(), "{krate}: circles of imports among {left:#?}");
    }
}

#[test]
fn the_renderer_knows_no_window() {
    for krate in ["renderer", "renderer/kernel"] {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(krate).join("Cargo.toml");
        let manifest = std::fs::read_to_string(manifest).expect("the crate has a manifest");
        for name in ["egui", "eframe", "wgpu", "clap", "indicatif"] {
            assert!(!manifest.contains(name), "{krate} depends on {name}");
        }
    }
    for (module, text) in sources("renderer/kernel") {
        assert!(module.starts_with("lanes") || !text.contains("fearless_simd"), "{module} names the SIMD crate");
    }
}
