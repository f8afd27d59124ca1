//! Whether the judge says of kept evidence what it said before.

use std::fs;

use serde_json::Value;
use symplint::{Evidence, judge};

use symplint_truth::kept::{folder, words};

/// Digits that differ by less are the same.
const DIGITS: f64 = 0.3;

/// Sentences that differ and are shown.
const SHOWN: usize = 20;

#[test]
#[ignore = "needs evidence that was kept: KEPT_EVIDENCE"]
fn kept_evidence_is_judged_as_before() {
    let folder = folder().expect("KEPT_EVIDENCE");
    let mut files: Vec<_> = (fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let (mut verdicts, mut sentences) = (Vec::new(), Vec::new());
    for file in &files {
        let kept: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
        let evidence: Evidence = serde_json::from_value(kept["evidence"].clone()).unwrap();
        let (before, now) = (&kept["verdict"], words(&judge(&evidence)));
        let [digits, other] = [before, &now].map(|of| of["digits"].as_f64().unwrap_or(0.0));
        let is_same = ["kind", "order"].iter().all(|key| before[key] == now[key])
            && (digits - other).abs() <= DIGITS;
        let name = kept["name"].as_str().unwrap();
        if !is_same {
            verdicts.push(format!("{name}:\n  {before}\n  {now}"));
        } else if *before != now {
            sentences.push(format!(
                "{name}:{}{}",
                new(before, &now, '-'),
                new(&now, before, '+')
            ));
        }
    }
    println!(
        "{} judged: {} verdicts and {} sentences differ",
        files.len(),
        verdicts.len(),
        sentences.len()
    );
    let shown = &sentences[..sentences.len().min(SHOWN)];
    println!("{}", shown.join("\n"));
    assert!(!files.is_empty());
    assert!(verdicts.is_empty(), "{}", verdicts.join("\n"));
}

/// The sentences of a verdict that another one does not have, each with this mark.
fn new(of: &Value, other: &Value, mark: char) -> String {
    let sentences = |of: &Value| -> Vec<Value> {
        let lists = ["findings", "advice"].iter();
        lists
            .filter_map(|key| of[key].as_array().cloned())
            .flatten()
            .collect()
    };
    let known = sentences(other);
    let new = sentences(of).into_iter().filter(|one| !known.contains(one));
    new.map(|sentence| format!("\n  {mark} {sentence}"))
        .collect()
}
