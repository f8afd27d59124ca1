//! The modules of the crate import from those above them alone, and those of the other libraries never in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The libraries of systems, files and reports.
const LIBRARIES: [&str; 4] = [
    "symplint-models",
    "symplint-plasma",
    "symplint-files",
    "symplint-report",
];

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

/// The modules of the crate that a file imports from.
fn imports(file: &Path, source: &Path) -> Vec<String> {
    let mut code = code(file);
    // In a file that lies in the folder of the crate, `super` is the crate.
    if file.parent() == Some(source) {
        code = code.replace("super::", "crate::");
    }
    let name = |text: &str| -> String {
        (text.trim().chars())
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let names = code.split("crate::").skip(1).flat_map(|part| {
        let list = part
            .strip_prefix('{')
            .and_then(|part| part.split('}').next());
        let items = list.map_or(vec![part], |list| list.split(',').collect());
        items.into_iter().map(name)
    });
    names.collect()
}

fn files(path: &Path) -> Vec<PathBuf> {
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
            for name in imports(&file, &source) {
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

#[test]
fn no_other_library_imports_in_a_circle() {
    for library in LIBRARIES {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../{library}/src"));
        let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for file in files(&source) {
            let module = file.strip_prefix(&source).unwrap().iter().next().unwrap();
            let module = Path::new(module).file_stem().unwrap().to_string_lossy();
            let imports = imports(&file, &source);
            (graph.entry(module.clone().into_owned()).or_default())
                .extend(imports.into_iter().filter(|name| *name != module));
        }
        // Re-exports are for users: the crate itself imports from where a thing is.
        graph.remove("lib");
        for (module, imports) in &graph {
            let unknown: Vec<_> = (imports.iter())
                .filter(|name| !graph.contains_key(*name))
                .collect();
            assert!(unknown.is_empty(), "{library}, {module}: {unknown:?}");
        }
        // Takes away modules that import from none that is left, until there are no more such modules.
        while let Some(free) = (graph.iter())
            .find(|(_, imports)| !imports.iter().any(|name| graph.contains_key(name)))
            .map(|(module, _)| module.clone())
        {
            graph.remove(&free);
        }
        assert!(graph.is_empty(), "{library}: a circle in {graph:#?}");
    }
}
