//! Evidence kept outside the repository: after a change of the judge, its verdicts are compared with those of before, without a map.
//!
//! ```text
//! export KEPT_EVIDENCE=FOLDER
//! cargo test --release -p symplint-truth truth_set::all_members -- --ignored # some minutes: writes
//! cargo test --release -p symplint-truth truth_table::                               # writes
//! cargo test --release -p symplint-truth truth_set::kept_evidence -- --ignored # compares
//! ```

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};
use symplint::{Evidence, Verdict};

/// Where evidence is kept, if it is.
pub fn folder() -> Option<PathBuf> {
    std::env::var_os("KEPT_EVIDENCE").map(PathBuf::from)
}

/// Keeps the evidence and the verdict of a case, in a file of its name.
pub fn keep(name: &str, evidence: &Evidence, verdict: &Verdict) {
    let Some(folder) = folder() else {
        return;
    };
    fs::create_dir_all(&folder).unwrap();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.=".contains(c);
    let file: String = (name.chars())
        .map(|c| if is_plain(c) { c } else { '_' })
        .collect();
    let kept = json!({
        "name": name,
        "evidence": evidence,
        "verdict": words(verdict),
    });
    fs::write(folder.join(file + ".json"), kept.to_string()).unwrap();
}

/// The contents of a verdict.
pub fn words(verdict: &Verdict) -> Value {
    let findings: Vec<String> = verdict.findings.iter().map(ToString::to_string).collect();
    json!({
        "kind": verdict.kind.to_string(),
        "order": verdict.order,
        "digits": verdict.digits,
        "findings": findings,
        "advice": verdict.advice(),
    })
}
