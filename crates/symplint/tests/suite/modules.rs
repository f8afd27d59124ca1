//! The imports between modules: this crate keeps to its stated order, and no crate of the workspace has a cycle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of this crate, from the ground up: each may import from those before it.
const MODULES: [&str; 17] = [
    "signal",
    "text",
    "error",
    "state",
    "loops",
    "map",
    "breaks",
    "rules",
    "field",
    "jacobian",
    "trace",
    "evidence",
    "survey",
    "diagnosis",
    "request",
    "snapshots",
    "verdict",
];

/// The name of a module inside its crate, such as `["rules", "piecewise"]`; empty for the root.
type Module = Vec<String>;

/// The source of one crate.
struct Crate {
    name: String,
    source: PathBuf,
    /// The tokens of each module, without tests and comments.
    modules: BTreeMap<Module, Vec<String>>,
    /// The paths of the items that a module exports from other modules, by their names.
    exports: BTreeMap<(Module, String), Vec<String>>,
}

impl Crate {
    fn read(folder: &Path) -> Self {
        let source = folder.join("src");
        let modules: BTreeMap<Module, Vec<String>> = (files(&source).iter())
            .map(|file| {
                (
                    module_of(file.strip_prefix(&source).unwrap()),
                    tokens(&code(file)),
                )
            })
            .collect();
        let mut exports = BTreeMap::new();
        for (module, tokens) in &modules {
            for path in paths(tokens).filter(|path| path.is_exported) {
                let name = path.alias.or(path.segments.last().cloned()).unwrap();
                exports.insert((module.clone(), name), path.segments);
            }
        }
        Crate {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            source,
            modules,
            exports,
        }
    }

    /// All pairs of modules of which the first imports from the second.
    fn imports(&self) -> BTreeSet<(Module, Module)> {
        let mut imports = BTreeSet::new();
        for (module, tokens) in &self.modules {
            let targets = paths(tokens).filter_map(|path| self.target(module, &path.segments));
            imports.extend(targets.map(|target| (module.clone(), target)));
        }
        imports.retain(|(from, to)| from != to);
        imports
    }

    /// The module of this crate that defines the item of a path which stands in the module `at`.
    fn target(&self, at: &Module, path: &[String]) -> Option<Module> {
        let mut target = at.clone();
        let mut rest = path;
        match path[0].as_str() {
            "crate" => {
                target.clear();
                rest = &path[1..];
            }
            "self" | "super" => {}
            name if self.modules.contains_key(&child(at, name)) => {}
            _ => return None,
        }
        while let Some((name, after)) = rest.split_first() {
            match name.as_str() {
                "self" => {}
                "super" => drop(target.pop()),
                name if self.modules.contains_key(&child(&target, name)) => {
                    target.push(name.to_owned());
                }
                name => {
                    let export = self.exports.get(&(target.clone(), name.to_owned()));
                    let origin = export.and_then(|path| self.target(&target, path));
                    return Some(origin.unwrap_or(target));
                }
            }
            rest = after;
        }
        Some(target)
    }

    /// The modules that need each other, for each folder that has any. At the top of a crate all modules count, in a folder
    /// only cycles through another folder.
    fn cycles(&self) -> Vec<Cycle> {
        let mut folders: BTreeMap<Module, BTreeSet<(Module, Module)>> = BTreeMap::new();
        for import in self.imports() {
            let (from, to) = &import;
            let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
            if common < from.len() && common < to.len() {
                (folders.entry(from[..common].to_vec()).or_default()).insert(import);
            }
        }
        let mut cycles = Vec::new();
        for (folder, imports) in folders {
            let level = folder.len();
            let edges: BTreeSet<(&str, &str)> = (imports.iter())
                .map(|(from, to)| (&*from[level], &*to[level]))
                .collect();
            for names in circular(&edges) {
                let is_folder = |name: &&str| {
                    let path = folder.iter().map(String::as_str).chain([*name]);
                    self.source.join(path.collect::<PathBuf>()).is_dir()
                };
                if level == 0 || names.iter().any(is_folder) {
                    let within = imports.iter().filter(|(from, to)| {
                        names.contains(&*from[level]) && names.contains(&*to[level])
                    });
                    cycles.push(Cycle {
                        folder: folder.join("/"),
                        names: Vec::from_iter(names.iter().copied()).join(" "),
                        imports: within
                            .map(|(from, to)| format!("{} → {}", from.join("::"), to.join("::")))
                            .collect(),
                    });
                }
            }
        }
        cycles
    }
}

/// Modules of one folder that need each other.
struct Cycle {
    folder: String,
    names: String,
    imports: Vec<String>,
}

fn child(module: &Module, name: &str) -> Module {
    module.iter().cloned().chain([name.to_owned()]).collect()
}

/// The module of a file, given its path below the source folder.
fn module_of(file: &Path) -> Module {
    let mut module: Module = (file.with_extension("").iter())
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if matches!(module.last().unwrap().as_str(), "mod" | "lib" | "main") {
        module.pop();
    }
    module
}

/// The code of a file without its tests, examples and comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let end = ["#[cfg(test)]", "#[cfg(all(test"].map(|tests| text.find(tests));
    let code = &text[..end.into_iter().flatten().min().unwrap_or(text.len())];
    let lines = (code.lines()).filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap();
    let mut files: Vec<_> = entries
        .flat_map(|entry| files(&entry.unwrap().path()))
        .collect();
    files.sort();
    files
}

/// Names, `::` and single signs.
fn tokens(code: &str) -> Vec<String> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if is_name(first) {
            rest.find(|c| !is_name(c)).unwrap_or(rest.len())
        } else if rest.starts_with("::") {
            2
        } else {
            first.len_utf8()
        };
        tokens.push(rest[..length].to_owned());
        rest = rest[length..].trim_start();
    }
    tokens
}

/// A path in code or in a `use`.
struct ItemPath {
    segments: Vec<String>,
    alias: Option<String>,
    /// Whether it stands in a `pub use`.
    is_exported: bool,
}

/// All paths of a file, those in braces written out.
fn paths(tokens: &[String]) -> impl Iterator<Item = ItemPath> {
    let mut paths = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let is_use = tokens[at] == "use";
        let is_exported = is_use && at > 0 && matches!(tokens[at - 1].as_str(), "pub" | ")");
        at += usize::from(is_use);
        at = read_path(tokens, at, &[], is_exported, &mut paths).max(at + 1);
    }
    paths.into_iter()
}

/// Reads the path that begins at a token, and returns the position behind it.
fn read_path(
    tokens: &[String],
    mut at: usize,
    prefix: &[String],
    is_exported: bool,
    paths: &mut Vec<ItemPath>,
) -> usize {
    let token = |at: usize| tokens.get(at).map_or("", String::as_str);
    let is_name = |at: usize| token(at).starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let mut segments = prefix.to_vec();
    while is_name(at) {
        segments.push(tokens[at].clone());
        at += 1;
        if token(at) != "::" {
            break;
        }
        at += 1;
        if token(at) == "{" {
            at += 1;
            while !matches!(token(at), "}" | "") {
                at = read_path(tokens, at, &segments, is_exported, paths).max(at + 1);
            }
            return at + 1;
        }
    }
    if segments.len() > prefix.len() && (segments.len() > 1 || token(at) == "*") {
        let alias = (token(at) == "as").then(|| token(at + 1).to_owned());
        paths.push(ItemPath {
            segments,
            alias,
            is_exported,
        });
    }
    at
}

/// The sets of names that reach each other along the edges.
fn circular<'a>(edges: &BTreeSet<(&'a str, &'a str)>) -> BTreeSet<BTreeSet<&'a str>> {
    let reach = |start: &'a str| {
        let mut reached = BTreeSet::new();
        let mut next = vec![start];
        while let Some(name) = next.pop() {
            let targets =
                (edges.iter()).filter(|(from, to)| *from == name && !reached.contains(to));
            let targets: Vec<&str> = targets.map(|(_, to)| *to).collect();
            reached.extend(&targets);
            next.extend(targets);
        }
        reached
    };
    let names: BTreeSet<&str> = edges.iter().flat_map(|&(a, b)| [a, b]).collect();
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        names.iter().map(|&name| (name, reach(name))).collect();
    (names.iter())
        .filter(|&name| reached[name].contains(name))
        .map(|&name| {
            let back = (reached[name].iter()).filter(|other| reached[*other].contains(name));
            back.copied().collect()
        })
        .collect()
}

/// All crates of the workspace.
fn crates() -> Vec<Crate> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut folders: Vec<PathBuf> = (fs::read_dir(root.join("crates")).unwrap())
        .map(|entry| entry.unwrap().path())
        .chain([root.join("python")])
        .filter(|folder| folder.join("Cargo.toml").exists())
        .collect();
    folders.sort();
    folders.iter().map(|folder| Crate::read(folder)).collect()
}

#[test]
fn no_module_imports_from_one_below_it() {
    let symplint = Crate::read(Path::new(env!("CARGO_MANIFEST_DIR")));
    let position = |module: &Module| {
        MODULES
            .iter()
            .position(|name| Some(*name) == module.first().map(String::as_str))
    };
    let wrong: Vec<String> = (symplint.imports().iter())
        .filter(|(from, to)| {
            !from.is_empty() && position(to).is_none_or(|to| Some(to) > position(from))
        })
        .map(|(from, to)| format!("{} imports from crate::{}", from.join("::"), to.join("::")))
        .collect();
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
fn no_crate_has_a_cycle_between_folders_or_top_level_modules() {
    let mut wrong = Vec::new();
    for package in crates() {
        for cycle in package.cycles() {
            wrong.push(format!(
                "{}, src/{}: a cycle between {}\n  {}",
                package.name,
                cycle.folder,
                cycle.names,
                cycle.imports.join("\n  ")
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_module_imports_an_item_that_the_root_of_its_crate_defines() {
    let wrong: Vec<String> = (crates().iter())
        .flat_map(|package| {
            let of_root = (package.imports().into_iter()).filter(|(_, to)| to.is_empty());
            of_root.map(|(from, _)| format!("{}: {}", package.name, from.join("::")))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn imports_and_cycles_are_found() {
    let module = |name: &str| -> Module {
        name.split("::")
            .filter(|part| !part.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let sources = [
        ("", "mod a; mod b; mod c; pub use a::Thing as Other;"),
        (
            "a",
            "use std::fmt; use super::{b::inner::{self, Part}, c}; struct Thing;",
        ),
        ("b", "mod inner;"),
        ("b::inner", "fn f() { crate::c::g(); }"),
        ("c", "use crate::Other;"),
    ];
    let exports = [(("", "Other"), "a::Thing")];
    let package = Crate {
        name: String::new(),
        source: PathBuf::new(),
        modules: sources
            .map(|(name, code)| (module(name), tokens(code)))
            .into(),
        exports: exports
            .map(|((at, name), path)| ((module(at), name.to_owned()), module(path)))
            .into(),
    };
    let imports = package.imports();
    for (from, to) in [("a", "b::inner"), ("a", "c"), ("b::inner", "c"), ("c", "a")] {
        assert!(
            imports.contains(&(module(from), module(to))),
            "{from} → {to}: {imports:?}"
        );
    }
    assert!(!imports.contains(&(module("c"), Vec::new())));
    let cycles = package.cycles();
    assert_eq!(cycles.len(), 1);
    assert_eq!(cycles[0].names, "a b c");
}
