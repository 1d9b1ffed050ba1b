//! Frames that were kept to be compared with.

use std::collections::VecDeque;
use std::sync::Arc;

use mislab_renderer::Frame;

use crate::state::document::KeptFrame;

/// The last frames kept. Undo may ask for one that has gone: then its picture is rendered again, from the same seed.
#[derive(Default)]
pub struct Shelf {
    frames: VecDeque<(KeptFrame, Arc<Frame>)>,
    next: u64,
}

impl Shelf {
    /// Each costs a set of sums.
    const ROOM: usize = 2;

    /// Keeps a frame.
    pub fn put(&mut self, frame: Arc<Frame>) -> KeptFrame {
        if self.frames.len() == Self::ROOM {
            self.frames.pop_front();
        }
        let kept = KeptFrame(self.next);
        self.next += 1;
        self.frames.push_back((kept, frame));
        kept
    }

    /// A frame that was kept, if it is still there.
    pub fn get(&self, kept: KeptFrame) -> Option<&Arc<Frame>> {
        self.frames.iter().find(|(number, _)| *number == kept).map(|(_, frame)| frame)
    }
}
