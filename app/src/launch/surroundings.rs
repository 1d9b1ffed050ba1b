//! What a desktop should have set for a program, and what is done where it has not.

#[cfg(any(unix, test))]
use std::ffi::OsString;
#[cfg(any(unix, test))]
use std::path::{Path, PathBuf};

/// A variable, and its value or that it should not be there.
#[cfg(any(unix, test))]
type Change = (&'static str, Option<OsString>);

/// Starts the program again with what the window library needs, where that is missing or misleading: it reads its
/// environment only, and does not try the other window system where the first does not answer.
pub fn mend() {
    #[cfg(unix)]
    {
        use std::os::unix::net::UnixStream;

        let answers = |socket: &Path| UnixStream::connect(socket).is_ok();
        let changes = changes(|name| std::env::var_os(name), answers, Path::is_dir, private_folder);
        if changes.is_empty() {
            return;
        }
        let Ok(program) = std::env::current_exe() else { return };
        let mut command = std::process::Command::new(program);
        command.args(std::env::args_os().skip(1));
        for (name, value) in changes {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        // Returns only if it fails; then it is tried as it is.
        let _ = std::os::unix::process::CommandExt::exec(&mut command);
    }
}

/// A folder of this user's only, in place of the one that a login should have made.
#[cfg(unix)]
fn private_folder() -> Option<PathBuf> {
    use std::os::unix::fs::DirBuilderExt as _;

    let folder = directories::ProjectDirs::from("", "", "mislab")?.data_dir().join("runtime");
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&folder).ok()?;
    Some(folder)
}

/// What has to be otherwise before a window can be opened. After these changes, nothing has.
#[cfg(any(unix, test))]
fn changes(
    variable: impl Fn(&str) -> Option<OsString>,
    answers: impl Fn(&Path) -> bool,
    is_folder: impl Fn(&Path) -> bool,
    private_folder: impl Fn() -> Option<PathBuf>,
) -> Vec<Change> {
    let set = |name: &str| variable(name).filter(|value| !value.is_empty());
    let (wayland, x11) = (set("WAYLAND_DISPLAY"), set("DISPLAY"));
    let runtime = set("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|folder| is_folder(folder));
    let mut changes = Vec::new();
    // A session that has ended leaves its name behind, in a terminal that lives on or over a remote connection.
    if let (Some(name), Some(_), None) = (&wayland, &x11, set("WAYLAND_SOCKET")) {
        let socket = Path::new(name);
        let socket =
            if socket.is_absolute() { Some(socket.to_owned()) } else { runtime.as_ref().map(|r| r.join(socket)) };
        if !socket.is_some_and(|socket| answers(&socket)) {
            changes.push(("WAYLAND_DISPLAY", None));
        }
    }
    // Libraries complain about this one on the terminal, in lines of their own.
    if runtime.is_none()
        && (wayland.is_some() || x11.is_some())
        && let Some(folder) = private_folder()
    {
        changes.push(("XDG_RUNTIME_DIR", Some(folder.into())));
    }
    changes
}

/// Why there is no display, from what a desktop should have set.
pub fn no_display() -> String {
    let set = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let tried: Vec<String> = ["WAYLAND_DISPLAY", "DISPLAY"]
        .into_iter()
        .filter_map(|name| set(name).map(|value| format!("{name}={value}")))
        .collect();
    if !cfg!(target_os = "linux") {
        return "there is no display to open one on".into();
    }
    if tried.is_empty() {
        return "there is no display to open one on (neither DISPLAY nor WAYLAND_DISPLAY is set)".into();
    }
    format!("no display answers at {}", tried.join(" or "))
}

/// Ends a sentence with how to get what is missing.
pub fn how_to_install(packages: &str) -> String {
    if cfg!(target_os = "linux") {
        format!("; on Debian and Ubuntu, `apt-get install {packages}` installs what is needed")
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The changes for these variables, where `there` are folders and sockets that answer.
    fn found(variables: &[(&str, &str)], there: &[&str]) -> Vec<(&'static str, Option<String>)> {
        let variable = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| OsString::from(*value));
        let exists = |path: &Path| there.iter().any(|known| Path::new(known) == path);
        let found = changes(variable, exists, exists, || Some("/mine".into()));
        found.into_iter().map(|(name, value)| (name, value.map(|v| v.to_string_lossy().into_owned()))).collect()
    }

    #[test]
    fn a_stale_wayland_does_not_hide_a_good_x11() {
        let x11 = [("DISPLAY", ":0"), ("XDG_RUNTIME_DIR", "/run/me")];
        let with = |more: &'static str| [x11[0], x11[1], ("WAYLAND_DISPLAY", more)];
        let gone = vec![("WAYLAND_DISPLAY", None)];
        assert_eq!(found(&x11, &["/run/me"]), []);
        assert_eq!(found(&with("wayland-0"), &["/run/me", "/run/me/wayland-0"]), [], "it answers");
        assert_eq!(found(&with("wayland-0"), &["/run/me"]), gone);
        assert_eq!(found(&with("/else/where"), &["/run/me", "/else/where"]), []);
        assert_eq!(found(&with("/else/where"), &["/run/me"]), gone);
        assert_eq!(found(&with(""), &["/run/me"]), [], "empty is not set");
        let alone = [("WAYLAND_DISPLAY", "wayland-0"), ("XDG_RUNTIME_DIR", "/run/me")];
        assert_eq!(found(&alone, &["/run/me"]), [], "there is nothing to fall back to");
    }

    #[test]
    fn a_missing_runtime_folder_is_replaced() {
        let mine = vec![("XDG_RUNTIME_DIR", Some("/mine".to_owned()))];
        assert_eq!(found(&[("DISPLAY", ":0")], &[]), mine);
        assert_eq!(found(&[("DISPLAY", ":0"), ("XDG_RUNTIME_DIR", "/gone")], &[]), mine);
        assert_eq!(found(&[], &[]), [], "without a display nobody asks for it");
        let mut both = vec![("WAYLAND_DISPLAY", None)];
        both.extend(mine);
        assert_eq!(found(&[("DISPLAY", ":0"), ("WAYLAND_DISPLAY", "wayland-0")], &[]), both);
        // Started again, nothing is left to change.
        assert_eq!(found(&[("DISPLAY", ":0"), ("XDG_RUNTIME_DIR", "/mine")], &["/mine"]), []);
    }
}
