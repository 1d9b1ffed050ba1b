//! Frames and pictures from files that were kept to be compared with.

use std::collections::VecDeque;
use std::sync::Arc;

use mislab_renderer::Frame;

use crate::picture::content::Content;
use crate::picture::foreign::Foreign;
use crate::state::document::Kept;

/// The last ones kept. Undo may ask for one that has gone: then a frame is rendered again, from the same seed, and a file
/// has only its name left.
#[derive(Default)]
pub struct Shelf {
    frames: VecDeque<(Kept, Content)>,
    files: Vec<(Kept, Content)>,
    next: u64,
}

impl Shelf {
    /// Each costs a set of sums.
    const FRAMES: usize = 2;
    /// As many as there are pictures in the window.
    const FILES: usize = 4;

    /// Keeps a frame.
    pub fn put(&mut self, frame: Arc<Frame>) -> Kept {
        if self.frames.len() == Self::FRAMES {
            self.frames.pop_front();
        }
        let kept = Kept::Frame(self.number());
        self.frames.push_back((kept, Content::Frame(frame)));
        kept
    }

    /// Keeps a picture from a file.
    pub fn put_file(&mut self, file: Foreign) -> Kept {
        let kept = Kept::File(self.number());
        self.files.push((kept, Content::File(Arc::new(file))));
        if let Some(oldest) = self.files.len().checked_sub(Self::FILES + 1)
            && let (_, Content::File(file)) = &mut self.files[oldest]
        {
            *file = Arc::new(file.emptied());
        }
        kept
    }

    fn number(&mut self) -> u64 {
        self.next += 1;
        self.next
    }

    /// What was kept, if it is still there.
    pub fn get(&self, kept: Kept) -> Option<&Content> {
        self.frames.iter().chain(&self.files).find(|(number, _)| *number == kept).map(|(_, content)| content)
    }
}
