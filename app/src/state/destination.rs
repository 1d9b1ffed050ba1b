//! Where snapshots go: beside the scene, named for what they show, unless the user says otherwise about this scene.

use std::path::{Path, PathBuf};

use super::document::Document;
use super::{file_name, paths};

/// What the user has said about the scene that is open; another scene starts with nothing said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Destination {
    /// The name as typed, `None` for [`Self::default_name`].
    pub name: Option<String>,
    /// The folder as typed, `None` for [`Self::default_folder`].
    pub folder: Option<String>,
}

impl Destination {
    /// Scene, strategy and samples per pixel: `veach_mis_light_64spp`.
    pub fn default_name(document: &Document, spp: u32) -> String {
        let scene = file_name::usable(&document.scene.name);
        format!("{scene}_{}_{spp}spp", document.active().estimator.strategy.name())
    }

    /// The folder of the scene; of scenes in the program the current one, or home where that is the root of everything.
    pub fn default_folder(document: &Document) -> PathBuf {
        let of_scene = document.opened.path.as_deref().and_then(Path::parent);
        let folder = match of_scene {
            Some(folder) => std::path::absolute(folder).ok().or_else(|| std::env::current_dir().ok()),
            None => std::env::current_dir().ok().filter(|f| f.parent().is_some()).or_else(std::env::home_dir),
        };
        folder.unwrap_or_else(|| PathBuf::from("."))
    }

    /// The name without number and extension, which may still be one that [`file_name::check`] refuses.
    /// Of one picture with so many samples per pixel; without them it is about several, or none.
    pub fn name(&self, document: &Document, spp: Option<u32>) -> String {
        let typed = self.name.as_deref().map(without_extension).filter(|name| !name.is_empty());
        typed.map(str::to_owned).unwrap_or_else(|| match spp {
            Some(spp) => Self::default_name(document, spp),
            None => file_name::usable(&document.scene.name),
        })
    }

    /// The folder; a relative one counts from the default.
    pub fn folder(&self, document: &Document) -> PathBuf {
        let default = Self::default_folder(document);
        let typed = self.folder.as_deref().map(str::trim).filter(|folder| !folder.is_empty());
        typed.map_or(default.clone(), |folder| default.join(paths::typed(folder)))
    }
}

/// As typed, less blanks around it and an extension that is added anyway.
fn without_extension(name: &str) -> &str {
    let name = name.trim();
    let ends = |end: &str| name.len() > end.len() && name.is_char_boundary(name.len() - end.len());
    let cut =
        [".exr", ".png"].into_iter().find(|end| ends(end) && name[name.len() - end.len()..].eq_ignore_ascii_case(end));
    cut.map_or(name, |end| &name[..name.len() - end.len()])
}

#[cfg(test)]
mod tests {
    use mislab_renderer::{Strategy, pbrt};

    use super::*;
    use crate::state::document::Opened;
    use crate::state::edit::Edit;

    #[test]
    fn names_and_folders_follow_the_scene_until_told_otherwise() {
        let path = Path::new("/lesson/veach_mis.pbrt").to_owned();
        let mut document = Document::new(Opened::from_scene_file(pbrt::embedded_scene(), Some(path)));
        let mut destination = Destination::default();
        Edit::SetStrategy(Strategy::Light).apply(&mut document);
        assert_eq!(destination.name(&document, Some(64)), "veach_mis_light_64spp");
        assert_eq!(destination.folder(&document), std::path::absolute("/lesson").expect("a path"));
        Edit::SetStrategy(Strategy::MisAll).apply(&mut document);
        assert_eq!(destination.name(&document, Some(7)), "veach_mis_mis_all_7spp");

        assert_eq!(destination.name(&document, None), "veach_mis");
        destination.name = Some(" mine.EXR ".into());
        destination.folder = Some("pictures".into());
        assert_eq!(destination.name(&document, Some(64)), "mine");
        assert!(destination.folder(&document).ends_with("lesson/pictures"));
        destination.folder = Some("~/pictures".into());
        assert_eq!(destination.folder(&document), std::env::home_dir().expect("a home folder").join("pictures"));
        destination.name = Some("  ".into());
        assert_eq!(destination.name(&document, Some(64)), "veach_mis_mis_all_64spp", "nothing typed is nothing said");
    }
}
