//! Chooses the vector levels that kernels are compiled for: all, or (without the feature `all-levels`) the one of this
//! machine.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(level, values(\"avx512\", \"avx2\", \"sse4_2\"))");
    let all = std::env::var_os("CARGO_FEATURE_ALL_LEVELS").is_some();
    for (level, own) in own_level() {
        if all || own {
            println!("cargo:rustc-cfg=level=\"{level}\"");
        }
    }
}

/// The levels of x86, and whether each is the best of this machine.
fn own_level() -> [(&'static str, bool); 3] {
    #[cfg(target_arch = "x86_64")]
    let (avx512, avx2) = (is_x86_feature_detected!("avx512f"), is_x86_feature_detected!("avx2"));
    #[cfg(not(target_arch = "x86_64"))]
    let (avx512, avx2) = (false, false);
    [("avx512", avx512), ("avx2", avx2 && !avx512), ("sse4_2", !avx2)]
}
