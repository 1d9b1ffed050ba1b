//! SCENE: a pbrt file, a picture saved by this program, or the scene built into it.

use std::path::Path;
use std::sync::Arc;

use mislab_renderer::{Diagnostic, Scene, Settings, Strategy, pbrt, snapshot};

use super::failure::Failure;
use super::output;

/// What SCENE says.
pub(super) struct Input {
    pub(super) scene: Arc<Scene>,
    pub(super) settings: Settings,
    film_filename: String,
    /// The scene does not clearly ask for its strategy: for another program's integrator, or for two strategies.
    doubtful: bool,
    /// The scene as the user named it, or "embedded".
    pub(super) source: String,
    warnings: Vec<Diagnostic>,
}

impl Input {
    /// Reads SCENE.
    pub(super) fn load(path: Option<&Path>) -> Result<Self, Failure> {
        let file = match path {
            Some(path) if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) => {
                return Self::restore(path);
            }
            Some(path) => pbrt::load(path)?,
            None => pbrt::embedded_scene(),
        };
        let pbrt::SceneFile {
            scene,
            settings,
            film_filename,
            foreign_integrator,
            contradicts_itself,
            warnings,
            source,
        } = file;
        let doubtful = foreign_integrator.is_some() || contradicts_itself;
        Ok(Self { scene: Arc::new(scene), settings, film_filename, doubtful, source, warnings })
    }

    /// The state a picture was saved in; its samples per pixel are those it had got.
    fn restore(path: &Path) -> Result<Self, Failure> {
        let request = snapshot::restore(path)?.picture_request();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Ok(Self {
            scene: request.scene,
            settings: request.settings,
            // Not the name of the picture itself, which may hold hours of work.
            film_filename: format!("{stem}_again.exr"),
            doubtful: false,
            source: path.display().to_string(),
            warnings: Vec::new(),
        })
    }

    /// File to save a picture by `strategy` in, where the command line names none.
    pub(super) fn picture_name(&self, strategy: Strategy) -> String {
        // A file that is named for one strategy must not show another.
        if self.doubtful || strategy != self.settings.estimator.strategy {
            return pbrt::name_with_strategy(&self.film_filename, strategy);
        }
        self.film_filename.clone()
    }

    /// Says what in the file was not understood.
    pub(super) fn warn(&self, quiet: bool) {
        if !quiet {
            for Diagnostic { location, message } in &self.warnings {
                output::message(&format!("{location}: warning: {message}"));
            }
        }
    }

    /// The same, one line each, with the place.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> {
        self.warnings.iter().map(Diagnostic::to_string)
    }
}
