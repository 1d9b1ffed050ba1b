//! How much work the tests do: little enough to run after every change, or as much as the claims deserve.

use std::sync::LazyLock;

/// The environment variable that `cargo xtask test --deep` sets to 1.
const VARIABLE: &str = "MISLAB_DEEP";

/// True in the deep run: the same tests, with the numbers of samples, cases and directions that
/// take too long for every change.
pub fn is_deep() -> bool {
    static DEEP: LazyLock<bool> = LazyLock::new(|| std::env::var_os(VARIABLE).is_some_and(|value| value == "1"));
    *DEEP
}

/// `ordinary`, or in the deep run `deep`.
pub fn depth<T>(ordinary: T, deep: T) -> T {
    if is_deep() { deep } else { ordinary }
}
