//! The commit that the program is built from, for the provenance of reports, if it is built from a repository.

use std::fs;
use std::path::{Path, PathBuf};

fn main() {
    let package = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    println!("cargo::rerun-if-changed=build.rs");
    if let Some(commit) = commit(&package.join("../../.git")) {
        println!("cargo::rustc-env=SYMPLINT_COMMIT={commit}");
    }
}

/// The commit that is checked out. Git itself need not be there.
fn commit(git: &Path) -> Option<String> {
    // In a second working tree `.git` is a file that names the folder.
    let folder = match read(git) {
        Some(text) => git.parent()?.join(text.strip_prefix("gitdir:")?.trim()),
        None => git.to_owned(),
    };
    // Branches are in the first working tree's folder.
    let common = read(&folder.join("commondir"));
    let common = common.map_or(folder.clone(), |text| folder.join(text.trim()));
    let head = watched(&folder.join("HEAD"))?;
    let Some(branch) = head.strip_prefix("ref:").map(str::trim) else {
        return hash(&head);
    };
    // A packed branch gets its own file with its next commit.
    println!(
        "cargo::rerun-if-changed={}",
        common.join("refs/heads").display()
    );
    if let Some(text) = watched(&common.join(branch)) {
        return hash(&text);
    }
    let packed = watched(&common.join("packed-refs"))?;
    let line = packed
        .lines()
        .find(|line| line.ends_with(&format!(" {branch}")))?;
    hash(line.split(' ').next()?)
}

fn hash(text: &str) -> Option<String> {
    let text = text.trim();
    let is_hash = text.len() >= 40 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_hash.then(|| text.to_owned())
}

fn read(path: &Path) -> Option<String> {
    fs::read_to_string(path).ok()
}

/// Reads a file that changes when another commit is checked out.
fn watched(path: &Path) -> Option<String> {
    if path.exists() {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    read(path)
}
