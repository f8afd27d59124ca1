//! Files of words and numbers, and how they are compared.

use std::fs;
use std::path::Path;

/// Numbers agree to this part of them. What is estimated from rounding depends on the vector instructions of the
/// processor: so do digits.
const RELATIVE: f64 = 1e-2;
/// Round-off of numbers about 1 is no difference.
pub const ROUND_OFF: f64 = 1e-11;

/// Compares `found` with `results/NAME.txt` word by word, or writes it there.
pub fn check(name: &str, found: &str) {
    let file = format!("tests/suite/recorded/results/{name}.txt");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(&file);
    if std::env::var_os("RECORD").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, found).unwrap();
        return;
    }
    let expected = fs::read_to_string(path).unwrap_or_else(|e| panic!("{file}: {e}"));
    let lines = expected.lines().zip(found.lines()).enumerate();
    for (number, (expected, found)) in lines {
        assert!(
            agree(expected, found),
            "{file}, line {}:\n recorded {expected}\n    found {found}",
            number + 1
        );
    }
    let counts = [&*expected, found].map(|text| text.lines().count());
    assert_eq!(counts[0], counts[1], "lines recorded and found of {file}");
}

fn agree(expected: &str, found: &str) -> bool {
    let words = [expected, found].map(|line| line.split_whitespace().collect::<Vec<_>>());
    words[0].len() == words[1].len()
        && words[0]
            .iter()
            .zip(&words[1])
            .all(|(a, b)| word_agrees(a, b))
}

fn word_agrees(expected: &str, found: &str) -> bool {
    let bare = |word: &str| -> Option<f64> {
        word.trim_matches(|c: char| !c.is_ascii_digit() && c != '-' && c != '+')
            .parse()
            .ok()
    };
    // Counts are written without a point.
    let is_count = |word: &str| !word.contains(['.', 'e']);
    match (bare(expected), bare(found)) {
        (Some(a), Some(b)) if !(is_count(expected) && is_count(found)) => {
            let size = a.abs().max(b.abs());
            (a - b).abs() <= RELATIVE * size + ROUND_OFF
        }
        _ => expected == found,
    }
}

#[test]
fn differences_are_seen() {
    assert!(agree("s 0.250, of 3 breaks", "s 0.251, of 3 breaks"));
    assert!(!agree("s 0.250, of 3 breaks", "s 0.255, of 3 breaks"));
    assert!(!agree("s 0.250, of 3 breaks", "s 0.250, of 4 breaks"));
    assert!(!agree("1000 evaluations", "1001 evaluations"));
    assert!(!agree("error Some(1e-3)", "error None"));
    assert!(!agree("broken", "closed"));
    assert!(agree("\"roundoff\": 1.3e-15,", "\"roundoff\": 2.6e-16,"));
}
