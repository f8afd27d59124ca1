//! Where reports come from, and that nothing else in them depends on it.

use std::fs;

use serde_json::Value;

use super::{configuration, example, symplint, text};

/// The part of a report on standard output before its provenance, byte by byte.
pub fn results(output: &[u8]) -> String {
    let report = text(output);
    // At the top level: it is indented by two blanks, and ends the report.
    let (results, provenance) = report
        .split_once(",\n  \"provenance\": ")
        .unwrap_or_else(|| panic!("the report has no provenance: {report}"));
    let provenance = provenance.trim_end().strip_suffix('}').unwrap();
    serde_json::from_str::<Value>(provenance).expect("nothing after the provenance");
    results.to_owned()
}

#[test]
fn everything_but_the_provenance_is_the_same_on_any_number_of_threads() {
    let (_folder, path) = configuration(
        "[system]\nname = \"pendulum-array\"\npendula = 50\n[diagnostic]\nsamples = 300\n",
    );
    let path = path.to_str().unwrap();
    for command in ["check", "trace"] {
        let run = |threads: usize| {
            let threads = threads.to_string();
            symplint(&[command, path, "--json", "--threads", &threads]).stdout
        };
        let one = run(1);
        // No more than there are processors.
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        for threads in [2, 3] {
            let other = run(threads);
            assert_eq!(results(&other), results(&one));
            let other: Value = serde_json::from_slice(&other).unwrap();
            assert_eq!(other["provenance"]["threads"], threads.min(processors));
        }
    }
}

#[test]
fn a_report_says_what_made_it() {
    let (folder, path) = configuration(
        "[system]\nname = \"pendulum-array\"\npendula = 4\nseed = 7\n[diagnostic]\nseed = 11\n",
    );
    let out = folder.path().join("run");
    let arguments = [
        "check",
        path.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ];
    let output = symplint(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let written = fs::read_to_string(out.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&written).unwrap();
    let provenance = &report["provenance"];
    assert_eq!(provenance["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(provenance["seeds"]["system.seed"], 7);
    assert_eq!(provenance["seeds"]["diagnostic.seed"], 11);
    assert!(provenance["threads"].as_u64() > Some(0));
    assert!(provenance["seconds"].as_f64() > Some(0.0));
    let is_text = |key: &str| {
        provenance[key]
            .as_str()
            .is_some_and(|text| !text.is_empty())
    };
    assert!(is_text("date") && is_text("processor"));
    let commit = provenance["commit"].as_str();
    assert!(commit.is_none_or(|commit| commit.len() >= 40), "{commit:?}");
    // Nothing of the machine's folders.
    let folder = folder.path().to_str().unwrap();
    assert!(!provenance.to_string().contains(folder), "{provenance}");
}

#[test]
fn measured_files_are_named_by_their_contents() {
    let (folder, path) = configuration(&fs::read_to_string(example("pendulum.toml")).unwrap());
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let write = |name: &str, samples: &str| {
        let path = path.to_str().unwrap();
        let output = symplint(&["loop", path, "--samples", samples, "--output", &file(name)]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    };
    write("before.csv", "64");
    write("pair.npy", "64");
    let files = |after: &str| -> Vec<(String, String)> {
        let output = symplint(&["measure", &file("before.csv"), &file(after), "--json"]);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let files = report["provenance"]["files"].as_array().unwrap();
        let field = |file: &Value, key: &str| file[key].as_str().unwrap().to_owned();
        (files.iter())
            .map(|file| (field(file, "name"), field(file, "sha256")))
            .collect()
    };
    let found = files("pair_q.npy");
    let names: Vec<&str> = found.iter().map(|(name, _)| &**name).collect();
    assert_eq!(names, ["before.csv", "pair_q.npy", "pair_p.npy"]);
    assert!(found.iter().all(|(_, hash)| hash.len() == 64));
    // The hash follows the contents, not the name.
    fs::copy(file("before.csv"), file("copy.csv")).unwrap();
    fs::write(
        file("changed.csv"),
        fs::read_to_string(file("before.csv")).unwrap() + "\n",
    )
    .unwrap();
    let (copy, changed) = (files("copy.csv"), files("changed.csv"));
    assert_eq!(copy[0].1, copy[1].1);
    assert_ne!(changed[0].1, changed[1].1);
}

#[test]
fn claims_say_what_judged_them() {
    let folder = tempfile::TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    let output = symplint(&["reproduce", "families", "--set", "seed=5", "--out", out]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let claims = fs::read_to_string(folder.path().join("claims.md")).unwrap();
    let (_, provenance) = claims.split_once("\n# Provenance\n").expect(&claims);
    let version = format!("| version | {} |", env!("CARGO_PKG_VERSION"));
    for row in [
        &*version,
        "| families.seed | 5 |",
        "| time taken |",
        "| processor |",
    ] {
        assert!(provenance.contains(row), "{row}: {provenance}");
    }
    // The claims themselves are results.
    let claims = fs::read_to_string(folder.path().join("claims.json")).unwrap();
    assert!(!claims.contains("processor"));
}
