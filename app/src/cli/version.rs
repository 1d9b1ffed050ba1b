//! What `--version` says.

use std::sync::LazyLock;

use mislab_renderer::simd_level_name;

/// Version, commit, platform, and the vector level that this machine renders with.
pub(super) fn version() -> &'static str {
    static VERSION: LazyLock<String> = LazyLock::new(|| {
        let (number, commit) = (env!("CARGO_PKG_VERSION"), env!("MISLAB_COMMIT"));
        format!("{number} ({commit}, {}, {})", env!("MISLAB_PLATFORM"), simd_level_name())
    });
    VERSION.as_str()
}
