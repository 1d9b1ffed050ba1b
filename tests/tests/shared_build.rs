//! The program and the tests are built from the same libraries, once: a feature that only the tests ask for would have cargo compile
//! the library again, and all that use it.

use std::collections::BTreeSet;
use std::process::Command;

/// Lines of a package and its features, as cargo resolves them for what `arguments` name.
fn packages(arguments: &[&str]) -> BTreeSet<String> {
    let mut tree = Command::new(env!("CARGO"));
    tree.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    tree.args(["tree", "--locked", "--offline", "--prefix", "none", "--format", "{p} with {f}", "--edges"]);
    let output = tree.args(arguments).output().expect("cargo can be started");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("cargo prints text");
    // Our own crates are compiled again with assertions on, whatever their features. A star marks what stands above.
    let of_others = text.lines().filter(|line| !line.starts_with("mislab") && !line.is_empty());
    of_others.map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

#[test]
fn tests_ask_no_more_of_the_programs_libraries() {
    let program = packages(&["normal,build", "--package", "mislab"]);
    let tests = packages(&["normal,build,dev", "--workspace"]);
    assert!(program.len() > 100, "{program:?}");
    let again: Vec<&String> = program.difference(&tests).collect();
    assert!(again.is_empty(), "with the tests these get other features, and are compiled again: {again:#?}");
}
