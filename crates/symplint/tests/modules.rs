//! The modules of the crate import from those above them alone.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The modules, from the ground up: each may import from those before it.
const MODULES: [&str; 14] = [
    "error",
    "signal",
    "state",
    "loops",
    "map",
    "breaks",
    "rules",
    "jacobian",
    "trace",
    "evidence",
    "survey",
    "diagnosis",
    "snapshots",
    "verdict",
];

/// The code of a file without its tests, examples and comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap();
    let lines = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

fn files(path: &Path) -> Vec<std::path::PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.flat_map(|path| files(&path)).collect();
    files.sort();
    files
}

#[test]
fn no_module_imports_from_one_below_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    for (position, module) in MODULES.iter().enumerate() {
        let folder = source.join(module);
        let path = match folder.is_dir() {
            true => folder,
            false => source.join(format!("{module}.rs")),
        };
        for file in files(&path) {
            for part in code(&file).split("crate::").skip(1) {
                let name: String = (part.chars())
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                match MODULES.iter().position(|other| *other == name) {
                    Some(other) if other > position => {
                        wrong.push(format!("{} imports from {name}", file.display()));
                    }
                    Some(_) => {}
                    None => wrong.push(format!("{} imports crate::{name}", file.display())),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_module_stands_in_the_order() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let found: BTreeSet<String> = (fs::read_dir(source).unwrap())
        .map(|entry| entry.unwrap().path())
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| name != "lib")
        .collect();
    let named: BTreeSet<String> = MODULES.iter().map(|module| (*module).to_owned()).collect();
    assert_eq!(found, named);
}
