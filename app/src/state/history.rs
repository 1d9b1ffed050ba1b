//! Undo and redo over the whole document.

use super::document::Document;

/// What a step of undo is about: edits of one control in one gesture make one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EditKey(pub &'static str, pub usize);

impl EditKey {
    /// What it is called, with the name of the plate or light in `document`.
    pub fn words(self, document: &Document) -> String {
        let Self(what, index) = self;
        let scene = &document.scene;
        let name = match what {
            "roughness" => scene.materials.get(index).map(|material| &material.name),
            "radius" | "switch" => scene.shapes.get(index).and_then(|shape| Some(&shape.light.as_ref()?.name)),
            _ => None,
        };
        name.map_or_else(|| what.to_owned(), |name| format!("{what} of {name}"))
    }
}

/// A document, and the edit between it and the present one.
#[derive(Debug)]
struct Step {
    document: Document,
    key: EditKey,
}

/// Undo and redo.
#[derive(Debug, Default)]
pub struct History {
    undo: Vec<Step>,
    redo: Vec<Step>,
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
        self.undo.push(Step { document: before, key });
    }

    /// The mouse button is up: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// What undo would take back.
    pub fn next_undo(&self) -> Option<EditKey> {
        self.undo.last().map(|step| step.key)
    }

    /// What redo would bring back.
    pub fn next_redo(&self) -> Option<EditKey> {
        self.redo.last().map(|step| step.key)
    }

    /// Goes one step back and says over what. Where one looks (zoom and pan) stays.
    pub fn undo(&mut self, document: &mut Document) -> Option<EditKey> {
        self.gesture = None;
        let Step { document: previous, key } = self.undo.pop()?;
        self.redo.push(Step { document: swap(document, previous), key });
        Some(key)
    }

    /// Takes one undo back and says over what.
    pub fn redo(&mut self, document: &mut Document) -> Option<EditKey> {
        self.gesture = None;
        let Step { document: next, key } = self.redo.pop()?;
        self.undo.push(Step { document: swap(document, next), key });
        Some(key)
    }
}

fn swap(document: &mut Document, mut other: Document) -> Document {
    other.view.placement = document.view.placement;
    std::mem::replace(document, other)
}
