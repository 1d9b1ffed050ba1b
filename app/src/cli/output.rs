//! Where results go: standard output, files that appear whole or not at all, and messages on standard error.

use std::convert::Infallible;
use std::ffi::OsStr;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use mislab_renderer::{Error, Frame, Layer, Strategy, Technique, snapshot};

use super::failure::Failure;
use crate::files::saving::{write_free, write_over};
use crate::picture::still::render_to_rgba8;
use crate::state::file_name;
use crate::state::paths::expand_home;
use crate::state::view::{ToneMap, ViewState};

/// A line on standard error. Nobody is left to be told if that fails.
pub(super) fn message(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Text for standard output. A reader that has seen enough (`| head`) is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Run(format!("standard output: cannot write: {error}")))
        }
        _ => Ok(()),
    }
}

/// A technique in text and JSON.
pub(super) fn technique_name(technique: Technique) -> &'static str {
    match technique {
        Technique::Light => Strategy::Light.name(),
        Technique::Bsdf => Strategy::Bsdf.name(),
    }
}

/// Where JSON goes.
#[derive(Clone, Debug)]
pub(super) enum Destination {
    StandardOutput,
    File(PathBuf),
}

impl FromStr for Destination {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(if text == "-" { Self::StandardOutput } else { Self::File(expand_home(text.into())) })
    }
}

impl Destination {
    /// As [`check_place`], for a file; refuses the names of scenes and pictures, which would be replaced.
    pub(super) fn check(&self) -> Result<(), Failure> {
        const OTHERS: [&str; 4] = ["pbrt", "ply", "exr", "png"];
        let Self::File(path) = self else { return Ok(()) };
        if path.extension().is_some_and(|e| OTHERS.iter().any(|other| e.eq_ignore_ascii_case(other))) {
            return Err(Failure::Usage(format!(
                "{}: this is the name of a scene or picture, expected one for numbers, e.g. numbers.json or numbers.csv",
                path.display()
            )));
        }
        check_place(path)
    }

    /// Writes `value` as indented JSON.
    pub(super) fn write(&self, value: &impl serde::Serialize) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(value).map_err(|error| Failure::Run(format!("JSON: {error}")))? + "\n";
        self.write_text(&text)
    }

    /// Writes text as it is.
    pub(super) fn write_text(&self, text: &str) -> Result<(), Failure> {
        match self {
            Self::StandardOutput => print(text),
            Self::File(path) => replace(path, text.as_bytes().to_vec()).map(drop),
        }
    }
}

/// Prints a report as text and writes it as JSON where that is asked for; to standard output in place of the text.
pub(super) fn report(json: Option<&Destination>, report: &impl serde::Serialize, text: &str) -> Result<(), Failure> {
    if json.is_none_or(|json| matches!(json, Destination::File(_))) {
        print(text)?;
    }
    json.map_or(Ok(()), |json| json.write(report))
}

/// A file to save a picture in, of a kind we write.
#[derive(Clone, Debug)]
pub(super) struct PictureFile {
    path: PathBuf,
    is_png: bool,
}

impl PictureFile {
    /// `None` if the extension is neither .exr nor .png.
    pub(super) fn new(path: PathBuf) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        let is_png = extension.eq_ignore_ascii_case("png");
        (is_png || extension.eq_ignore_ascii_case("exr")).then_some(Self { path, is_png })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// As [`check_place`].
    pub(super) fn check(&self) -> Result<(), Failure> {
        check_place(&self.path)
    }

    /// Saves the picture, over an older file of that name or, where that cannot be replaced, under the next free one, which
    /// becomes the name of this.
    ///
    /// Returns what the user should know about the file.
    pub(super) fn save(&mut self, frame: &Frame) -> Result<Option<String>, Failure> {
        let (bytes, notice) = self.encode(frame)?;
        self.path = replace(&self.path, bytes)?;
        Ok(notice)
    }

    /// Saves the picture under this name or, if a file has it, under the next free one, which becomes the name of this.
    ///
    /// Returns what the user should know about the file, and the name of the file that was kept.
    pub(super) fn save_beside(&mut self, frame: &Frame) -> Result<(Option<String>, Option<PathBuf>), Failure> {
        let (bytes, notice) = self.encode(frame)?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let part = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let (stem, extension) = (part(self.path.file_stem()), part(self.path.extension()));
        let path = write_free(folder, &stem, &[(&extension, bytes)])?;
        let wanted = std::mem::replace(&mut self.path, path);
        Ok((notice, Some(wanted).filter(|wanted| *wanted != self.path)))
    }

    fn encode(&self, frame: &Frame) -> Result<(Vec<u8>, Option<String>), Failure> {
        if !self.is_png {
            return Ok(snapshot::encode(frame, &snapshot::SaveOptions::default())?);
        }
        let view = ViewState { tone_map: ToneMap::SrgbClip, ..ViewState::default() };
        let (width, height, rgba) = render_to_rgba8(frame, Layer::Picture, &view, true);
        let bytes = crate::picture::png_file::encode(width, height, &rgba)
            .map_err(|error| Failure::Run(format!("{}: cannot encode: {error}", self.path.display())))?;
        Ok((bytes, None))
    }
}

/// Writes a file over an older one or, where that cannot be replaced, under the next free name, which is said also with
/// `--quiet`; returns its name.
fn replace(path: &Path, bytes: Vec<u8>) -> Result<PathBuf, Failure> {
    let (written, why) = write_over(path, bytes)?;
    if let Some(why) = why {
        message(&not_replaced(&why, &written));
    }
    Ok(written)
}

/// Says why a file could not be replaced and which name was taken.
pub(super) fn not_replaced(why: &Error, instead: &Path) -> String {
    format!("{why}; it is kept as it was, and what was to replace it is {}", instead.display())
}

/// Says that a file was there before and another name was taken.
pub(super) fn kept(file: &Path, instead: &Path) -> String {
    format!("{}: was there before and is kept as it was, the picture is {}", file.display(), instead.display())
}

/// Finds out before hours of rendering that a file could not be saved: its folder is missing, it is a folder itself, or its
/// name is one that some machine cannot hold.
pub(super) fn check_place(path: &Path) -> Result<(), Failure> {
    // The same pictures are handed in from another machine.
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    file_name::check(&name).map_err(|why| Failure::Run(format!("{}: cannot save: {why}", path.display())))?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        return Err(Failure::Run(format!("{}: cannot save: there is no folder {}", path.display(), folder.display())));
    }
    if path.is_dir() {
        return Err(Failure::Run(format!("{}: cannot save: this is a folder, expected a file", path.display())));
    }
    if path.metadata().is_ok_and(|there| !there.is_file()) {
        return Err(Failure::Run(format!(
            "{}: cannot save: this is a pipe or device, expected a file",
            path.display()
        )));
    }
    Ok(())
}
