//! Every action of the user, as data: panels, keys and the palette all say what they want in these.

use std::path::PathBuf;

use eframe::egui::ThemePreference;

use super::edit::Edit;
use super::study::Study;
use crate::look::zoom::ZoomStep;

/// One action.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Changes the document.
    Edit(Edit),

    /// Makes that picture the one that controls are about.
    Activate(usize),
    /// The same with the next picture.
    ActivateNext,
    /// Keeps the frame on screen, to compare what comes with it.
    Keep,

    /// Opens a study, or closes it.
    ToggleStudy(Study),
    /// Explains that pixel of the full image wherever the mouse is, or the one under the mouse again.
    Pin(Option<[u32; 2]>),

    /// Asks for a picture to measure errors against.
    OpenReference,
    /// Measures errors against a picture from a file.
    ReferencePath(PathBuf),
    /// Measures against a rendered picture again.
    RenderReference,
    /// Saves what a study has measured, for spreadsheets, under the next free name.
    SaveCsv {
        /// Of the file, without its end.
        name: &'static str,
        /// What it holds.
        text: String,
    },

    /// Sets the exposure from the picture, once, in plain sight.
    Normalise,
    /// Whole picture in the window.
    Fit,
    /// The plates and lights alone, as large as they fit.
    FitThings,
    /// One image pixel per screen pixel.
    ActualSize,

    /// Holds or goes on.
    TogglePause,
    /// One pass, holding.
    Step,
    /// Passes per second, `None` for full speed.
    SetRate(Option<f32>),
    /// Again from the first sample.
    Restart,

    /// One step back.
    Undo,
    /// One step forward.
    Redo,

    /// Asks for a file to open.
    Open,
    /// Asks for a path to open, without a dialog of the desktop.
    OpenTyped,
    /// Opens a scene or a snapshot.
    OpenPath(PathBuf),
    /// Asks for a picture to compare with.
    Compare,
    /// Shows a picture from a file beside the active one.
    ComparePath(PathBuf),
    /// Reads the open file again.
    Reload,
    /// Puts away what is said about a file that could not be opened.
    DismissOpenError,
    /// Opens a scene shipped in the program.
    OpenShipped(Shipped),
    /// Saves a snapshot under the next free name.
    Save,
    /// The same, where the folder for it is missing and is to be created.
    SaveCreatingFolder,
    /// Shows where a file lies.
    ShowInFolder(PathBuf),
    /// Copies the path of a file.
    CopyPath(PathBuf),
    /// Asks for the folder of snapshots.
    ChooseFolder,
    /// Copies the picture as it is shown.
    CopyPicture,
    /// Copies the values under the cursor.
    CopyValues,
    /// Writes what is seen, as a figure.
    Export(Figure),

    /// Shows or hides the side panels (the projector view).
    TogglePanels,
    /// Shows or hides the panel on the right.
    ToggleInspector,
    /// No fades, or fades again.
    ToggleMotion,
    /// Full screen and back.
    ToggleFullScreen,
    /// Light, dark or as the system.
    SetTheme(ThemePreference),
    /// Makes everything larger or smaller.
    ZoomInterface(ZoomStep),
    /// The sheet of keys.
    ToggleHelp,
    /// The list of all commands.
    TogglePalette,
    /// The tutorial's table.
    ToggleTable,
    /// Stops the table that is being made.
    StopTable,
}

/// What is made of what is seen: of the study if one is open, or else of all pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// A PNG beside the snapshots, two pixels to a point.
    Png,
    /// The same on the clipboard.
    Clipboard,
    /// An SVG of a study.
    Svg,
}

impl From<Edit> for Command {
    fn from(edit: Edit) -> Self {
        Self::Edit(edit)
    }
}

/// Scenes inside the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shipped {
    /// The tutorial's scene.
    Veach,
    /// The public plastic version with an overhead light.
    VeachPlastic,
}

impl Shipped {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Veach, Self::VeachPlastic];

    /// Name in menus.
    pub fn name(self) -> &'static str {
        match self {
            Self::Veach => "Veach's plates (the tutorial)",
            Self::VeachPlastic => "Veach's plates in plastic, five lights",
        }
    }
}
