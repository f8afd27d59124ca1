//! Where the system finds a program.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The file that is run by this name in a folder: one of a folder of `PATH` where the name has none.
pub fn found_in_path(name: &str, folder: &Path) -> Option<PathBuf> {
    found_in(&std::env::var_os("PATH")?, name, folder)
}

fn found_in(path: &OsStr, name: &str, folder: &Path) -> Option<PathBuf> {
    if Path::new(name).components().count() > 1 || name.contains('/') {
        return Some(folder.join(name));
    }
    let named = name.to_owned() + std::env::consts::EXE_SUFFIX;
    (std::env::split_paths(path))
        .flat_map(|place| [name, &named].map(|name| folder.join(&place).join(name)))
        .find(|path| is_program(path))
}

#[cfg(unix)]
fn is_program(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;

    (path.metadata()).is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_program(path: &Path) -> bool {
    path.is_file()
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_name_is_looked_for_in_path_and_a_path_in_the_folder() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        for (name, mode) in [("one/step", 0o644), ("two/step", 0o755), ("step", 0o755)] {
            fs::create_dir_all(path(name).parent().unwrap()).unwrap();
            fs::write(path(name), "").unwrap();
            fs::set_permissions(path(name), fs::Permissions::from_mode(mode)).unwrap();
        }
        let found = |name: &str| found_in(OsStr::new("one:two"), name, folder.path());
        // The first is no program, and the folder itself is not searched.
        assert_eq!(found("step"), Some(path("two/step")));
        assert_eq!(found("./step"), Some(path("./step")));
        assert_eq!(found("no-such-step"), None);
    }
}
