//! Long work that nobody may want any more by the time it is done.

/// The work was given up: somebody asked for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Whom long work asks, every millisecond or so, whether to go on.
#[derive(Clone, Copy)]
pub struct Stop<'a>(&'a dyn Fn() -> bool);

impl<'a> Stop<'a> {
    /// Work that is always finished.
    pub const NEVER: Stop<'static> = Stop(&|| false);

    /// Work to be given up as soon as `stopped` is true.
    pub fn when(stopped: &'a dyn Fn() -> bool) -> Self {
        Self(stopped)
    }

    /// Asks.
    ///
    /// # Errors
    /// [`Stopped`] if the work is to be given up.
    pub fn check(self) -> Result<(), Stopped> {
        if (self.0)() { Err(Stopped) } else { Ok(()) }
    }

    /// Asks in every thousandth turn of a loop, whose counter is `i`.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_in_turn(self, i: usize) -> Result<(), Stopped> {
        if i.is_multiple_of(1024) { self.check() } else { Ok(()) }
    }
}
