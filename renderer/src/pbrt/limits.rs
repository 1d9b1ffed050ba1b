//! How large a mesh of a scene file may be.

/// Most triangles of one mesh.
pub(super) const MAX_TRIANGLES: usize = 1 << 24;
/// Most vertices of one mesh.
pub(super) const MAX_VERTICES: usize = 1 << 24;
