//! How many pictures there are and how they lie in the window.

/// A way to lay out the pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// One picture.
    #[default]
    One,
    /// Two, side by side.
    Beside,
    /// Two in one place, with a divider between them.
    Wipe,
    /// Two in one place, the other one while Shift is held.
    Flip,
    /// Two as one: the first against the second.
    Difference,
    /// Four in a square.
    Four,
}

impl Arrangement {
    /// All of them, in the order shown to users.
    pub const ALL: [Self; 6] = [Self::One, Self::Beside, Self::Wipe, Self::Flip, Self::Difference, Self::Four];

    /// The name on screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::One => "One picture",
            Self::Beside => "Two side by side",
            Self::Wipe => "Two with a divider",
            Self::Flip => "Two, flipped by Shift",
            Self::Difference => "Two, A against B",
            Self::Four => "Four pictures",
        }
    }

    /// How many pictures there are.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Beside | Self::Wipe | Self::Flip | Self::Difference => 2,
            Self::Four => 4,
        }
    }

    /// Columns and rows of pictures.
    pub fn grid(self) -> [usize; 2] {
        match self {
            Self::One | Self::Wipe | Self::Flip | Self::Difference => [1, 1],
            Self::Beside => [2, 1],
            Self::Four => [2, 2],
        }
    }
}
