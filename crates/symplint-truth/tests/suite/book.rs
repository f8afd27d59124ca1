//! The tables of docs/truth.md.
//!
//! The tests that run all members print their tables and write them to `target/tmp/truth`. `python/tools/run_pages.py` compares
//! the page with these files.

use std::fs;
use std::path::Path;

/// Writes the table to `NAME.md`, and prints it.
pub fn publish(name: &str, markdown: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("truth");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(name).with_extension("md"), markdown).unwrap();
    println!("{markdown}");
}

/// With a comma before each group of three digits.
pub fn grouped(count: usize) -> String {
    match count {
        0..1000 => count.to_string(),
        _ => format!("{},{:03}", grouped(count / 1000), count % 1000),
    }
}

/// With two significant digits, or three next to a power of ten.
pub fn short(value: f64) -> String {
    let exponent = value.log10().floor();
    match value {
        0.0 => "0".to_owned(),
        _ if (-4.0..2.0).contains(&exponent) => {
            format!("{value:.*}", (1.0 - exponent) as usize)
        }
        _ => format!("{value:.1e}"),
    }
}

#[test]
fn numbers_are_written_as_in_the_book() {
    let counts = [7, 999, 1000, 52_370, 1_002_003].map(grouped);
    assert_eq!(counts, ["7", "999", "1,000", "52,370", "1,002,003"]);
    let numbers = [0.0, 1.78, 0.337, 0.0189, 2.66e-5, 40.0].map(short);
    assert_eq!(numbers, ["0", "1.8", "0.34", "0.019", "2.7e-5", "40"]);
}
