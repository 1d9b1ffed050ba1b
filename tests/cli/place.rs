//! A folder to run the built program in, and what a run leaves.

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use mislab_renderer::{pbrt, snapshot};
use serde_json::Value;

/// A folder of its own to run the program in.
pub struct Place(pub tempfile::TempDir);

impl Place {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("the folder can be written to");
    }

    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder can be read");
        let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
        let mut names: Vec<String> = entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mislab"));
        command.args(line.split_whitespace()).current_dir(self.0.path()).stdin(Stdio::null());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command
    }

    /// Runs `mislab LINE`.
    pub fn run(&self, line: &str) -> Ran {
        Ran::new(line, self.command(line).output().expect("the program starts"))
    }

    /// Runs `mislab LINE --json -` and reads what it prints.
    pub fn json(&self, line: &str) -> Value {
        let ran = self.run(&format!("{line} --json -"));
        ran.expect_code(0);
        serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{line}: not JSON ({e}): {}", ran.out))
    }

    pub fn image(&self, name: &str) -> snapshot::Image {
        snapshot::load_image(&self.path(name)).expect("an EXR file")
    }
}

pub struct Ran {
    line: String,
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    pub fn new(line: &str, output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8 text");
        Self { line: line.to_owned(), code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    #[track_caller]
    pub fn expect_code(&self, code: i32) -> &Self {
        assert_eq!(self.code, Some(code), "mislab {}\n{}\n{}", self.line, self.out, self.err);
        self
    }

    #[track_caller]
    pub fn expect_err(&self, parts: &[&str]) -> &Self {
        for part in parts {
            assert!(self.err.contains(part), "mislab {}: no {part:?} in: {}", self.line, self.err);
        }
        self
    }
}

/// The shipped scene with other header lines, as the tutorial asks for.
pub fn scene_with_header(header: &str) -> String {
    let text = pbrt::DEFAULT_SCENE;
    let camera = text.find("LookAt").expect("the scene has a camera");
    format!("{header}\n{}", &text[camera..])
}

pub const SMALL: &str = "render --size 16x12 --spp 4 --quiet";
