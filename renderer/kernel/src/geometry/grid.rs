//! How an image is cut into blocks and patches of pixels.

/// Width and height of a block in pixels, [`crate::lanes::PACKET`] in all.
pub const BLOCK: [u32; 2] = [8, 4];

/// Side of a patch in pixels.
pub const SIDE: u32 = 8;

/// Width and height of a patch in blocks.
pub const PATCH: [u32; 2] = [SIDE / BLOCK[0], SIDE / BLOCK[1]];
