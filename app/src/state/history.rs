//! Undo and redo over the whole document.

use super::document::Document;

/// What a step of undo is about: edits of one control in one gesture make one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EditKey(pub &'static str, pub usize);

/// Undo and redo.
#[derive(Debug, Default)]
pub struct History {
    undo: Vec<Document>,
    redo: Vec<Document>,
    gesture: Option<EditKey>,
}

impl History {
    /// Steps kept; a document is a few pointers and numbers.
    const DEPTH: usize = 500;

    /// Remembers `before`, unless the same gesture has already done so.
    pub fn record(&mut self, before: Document, key: EditKey) {
        self.redo.clear();
        if self.gesture == Some(key) {
            return;
        }
        self.gesture = Some(key);
        if self.undo.len() == Self::DEPTH {
            self.undo.remove(0);
        }
        self.undo.push(before);
    }

    /// The mouse button is up: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Is there anything to undo?
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Is there anything to redo?
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Goes one step back. Where one looks (zoom and pan) stays.
    pub fn undo(&mut self, document: &mut Document) {
        if let Some(previous) = self.undo.pop() {
            self.redo.push(swap(document, previous));
        }
        self.gesture = None;
    }

    /// Takes one undo back.
    pub fn redo(&mut self, document: &mut Document) {
        if let Some(next) = self.redo.pop() {
            self.undo.push(swap(document, next));
        }
        self.gesture = None;
    }
}

fn swap(document: &mut Document, mut other: Document) -> Document {
    other.view.placement = document.view.placement;
    std::mem::replace(document, other)
}
