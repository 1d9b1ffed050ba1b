//! What rays hit.

use crate::lanes::Lanes;

/// What a packet of rays hit first.
#[derive(Clone, Copy)]
pub struct Nearest<L: Lanes> {
    /// Distance; infinite if nothing was hit.
    pub t: L::F,
    /// Primitive id; meaningless where `t` is infinite.
    pub id: L::U,
}
