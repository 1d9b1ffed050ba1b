//! The scene reader: pbrt-v3 files to a [`Scene`] and [`Settings`].
//!
//! Reading order: `lexer` turns text into tokens, `parser` groups them into directives and
//! follows `Include`, `params` looks up typed parameters, `builder` applies directives to the
//! graphics state, with `header` (camera, film, sampler, integrator), `material` and `shape` beside
//! it. `log` collects warnings and knows where everything stands.
//!
//! What pbrt-v3 would do is the rule. What cannot be read of the scene is left out by itself and named in a warning, the
//! rest renders; but this reader stops and says where if what is computed would be another thing than its name says (a
//! wrong image size, a misspelt integrator), and where it cannot tell what is text and what is not.
//! Nothing recurses on the input, sizes are checked before memory is asked for, and no input panics.

mod builder;
mod directives;
mod header;
mod lexer;
mod limits;
mod log;
mod material;
mod params;
mod parser;
mod ply;
mod same_place;
mod shape;
mod transform;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mislab_kernel::request::scene::Scene;
use mislab_kernel::request::{Settings, Strategy};

use self::builder::Builder;
use self::log::Log;
use self::parser::Parser;
use crate::error::{Diagnostic, Error};

/// The default scene (Veach's plates, plate 1 a mirror, four lights), as text to edit.
pub const DEFAULT_SCENE: &str = include_str!("../../../assets/veach_mis.pbrt");

/// The public version of the scene: plastic plates and an overhead light, as text to edit.
pub const PLASTIC_SCENE: &str = include_str!("../../../assets/veach_mis_plastic.pbrt");

/// What a scene file says.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Camera, materials and shapes, all in world space.
    pub scene: Scene,
    /// Strategy, samples and image as the file has them; where it says nothing, as pbrt-v3 has them. A file without a
    /// strategy has that of [`Settings::default`], one with the tutorial's integrator and without a sampler its samples.
    pub settings: Settings,
    /// The Film's `filename`; "pbrt.exr", as in pbrt, if the file names none.
    pub film_filename: String,
    /// The file asks for this integrator of another program, in whose place one of the four strategies stands.
    pub foreign_integrator: Option<String>,
    /// The file asks for one strategy and then for another, which counts, but has one Film, whose name may be meant for either.
    pub contradicts_itself: bool,
    /// What was not understood or is not used, each said once, in the order of the file.
    pub warnings: Vec<Diagnostic>,
    /// The file as the user named it, or "embedded".
    pub source: String,
}

/// A file name with the strategy in it, `a.exr` as `a_mis_all.exr`: for pictures of scenes that ask for another program's
/// integrator ([`SceneFile::foreign_integrator`]) or for two strategies ([`SceneFile::contradicts_itself`]), so that they are not taken for what they are not.
pub fn name_with_strategy(filename: &str, strategy: Strategy) -> String {
    let (stem, extension) = filename.rfind('.').map_or((filename, ""), |dot| filename.split_at(dot));
    format!("{stem}_{}{extension}", strategy.name())
}

/// Reads a scene file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::File`] if it is not a scene file at all,
/// [`Error::Scene`] with file, line and column if it (or a file that it includes) cannot be told apart into directives, or if
/// one that says what is computed is wrong.
pub fn load(path: &Path) -> Result<SceneFile, Error> {
    load_with_files(path).0
}

/// As [`load`], with the files that the answer depends on, also where that is an error: the scene file itself, what it
/// includes and its meshes, those that are missing among them.
pub fn load_with_files(path: &Path) -> (Result<SceneFile, Error>, Vec<PathBuf>) {
    let mut log = Log::default();
    log.add_file(path);
    let scene = load_into(path, &mut log);
    (scene, log.take_files())
}

fn load_into(path: &Path, log: &mut Log) -> Result<SceneFile, Error> {
    let name = path.display().to_string();
    let text = parser::read_scene_text(path)?;
    // `parent` of a bare file name is the empty path, which joins to the same bare name: the
    // current folder, as wanted.
    let folder: Option<Arc<Path>> = path.parent().map(Arc::from);
    let mut parser = Parser::new(log, &name, text, folder, Some(path))?;
    read(&mut parser, log, name)
}

/// Reads scene text. `name` stands for the file in messages; its stem becomes the name of the scene.
/// Relative names in `Include` and `plymesh` are looked up in `include_dir`; without one they are
/// errors.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, name: &str, include_dir: Option<&Path>) -> Result<SceneFile, Error> {
    let mut log = Log::default();
    let mut parser = Parser::new(&mut log, name, text.to_owned(), include_dir.map(Arc::from), None)?;
    read(&mut parser, &mut log, name.to_owned())
}

/// The default scene, built into the binary.
pub fn embedded_scene() -> SceneFile {
    embedded(DEFAULT_SCENE, "veach_mis.pbrt")
}

/// The public plastic version with the overhead light, built into the binary.
pub fn embedded_plastic_scene() -> SceneFile {
    embedded(PLASTIC_SCENE, "veach_mis_plastic.pbrt")
}

fn embedded(text: &str, name: &str) -> SceneFile {
    // The text is fixed when the program is compiled, and a test reads it.
    let mut file = parse(text, name, None).expect("the embedded scene is valid");
    file.source = "embedded".to_owned();
    file
}

fn read(parser: &mut Parser, log: &mut Log, name: String) -> Result<SceneFile, Error> {
    let mut builder = Builder::default();
    while let Some(directive) = parser.next_directive(log)? {
        builder.apply(directive, log)?;
    }
    let stem = Path::new(&name).file_stem().map_or_else(|| name.clone(), |s| s.to_string_lossy().into_owned());
    builder.finish(stem, name, log, parser.end())
}
