//! Shows where a file lies, with the desktop's own file manager.

use std::path::Path;

/// Opens the folder of `path`.
///
/// # Errors
/// One sentence, with the folder in it.
pub fn show_in_folder(path: &Path) -> Result<(), String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(format!("There is no folder {} any more", folder.display()));
    }
    // Its own words name programs that nobody has heard of.
    open::that_detached(folder)
        .map_err(|_| format!("This desktop offers no file manager; the folder is {}", folder.display()))
}
