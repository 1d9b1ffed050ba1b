//! Short lists of primitives, as bits.

/// Most primitives, lights among them, of a scene that lists are made for.
pub const MOST: usize = 32;

/// Numbers of primitives below [`MOST`], as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct List(u32);

impl List {
    /// The numbers 0 .. n, or none if they are more than [`MOST`].
    pub fn all(n: usize) -> Self {
        if n > MOST { Self(0) } else { Self(((1u64 << n) - 1) as u32) }
    }

    /// Those whose bits are set, number i being bit i.
    pub fn of_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// How many there are.
    #[inline(always)]
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// True if there is none.
    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The smallest, 32 if there is none.
    #[inline(always)]
    pub fn first(self) -> usize {
        self.0.trailing_zeros() as usize
    }

    /// Those below `n`, and the others.
    #[inline(always)]
    pub fn split(self, n: usize) -> (Self, Self) {
        let below = Self::all(n.min(MOST)).0;
        (Self(self.0 & below), Self(self.0 & !below))
    }

    /// Takes the smallest out.
    #[inline(always)]
    pub fn take_first(&mut self) -> Option<usize> {
        let first = self.first();
        let some = !self.is_empty();
        self.0 &= self.0.wrapping_sub(1);
        some.then_some(first)
    }
}
