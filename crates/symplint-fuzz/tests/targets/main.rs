//! Every target on its seeds, on kept findings, and on mutations of both that depend on a seed alone.
//!
//! An input may take so much time, and so much memory as its size allows. More of it, as long as one likes: `cargo fuzz`.

mod memory;
mod mutation;

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use symplint_fuzz::{TARGETS, seeds};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Time that an input may take: thousands of times what it takes, and less than an endless loop does.
const MAX_TIME: Duration = Duration::from_secs(10);

/// Inputs of structured targets, which have no seeds.
const RANDOM_SEEDS: usize = 24;

/// The polynomials through 256 rows that a comparison of loops keeps in each thread: of five orders, at 12 nodes, 11 kB for a row.
const POLYNOMIALS: usize = 3 << 20;

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The most that a target may allocate at once: a constant, and a number of bytes for each byte of the input. Of archives, by the factor up to
/// which entries are unpacked; of reports, a number in two bytes becomes a value of JSON and then one of the evidence.
fn allowed(target: &str, input: usize) -> usize {
    let (constant, factor) = match target {
        "journal" => (1 << 20, 64),
        "npy" | "csv" => ((1 << 20) + POLYNOMIALS * threads(), 64),
        // What any archive may unpack to, while the buffer for it grows.
        "npz" => (64 << 20, 64),
        "report" => (8 << 20, 200),
        "configuration" => (64 << 20, 1000),
        _ => (256 << 20, 1000),
    };
    constant + factor * input
}

fn run(target: &str, function: fn(&[u8]), input: &[u8]) {
    let start = Instant::now();
    let peak = memory::peak_of(|| function(input));
    let took = start.elapsed();
    assert!(took < MAX_TIME, "{target} took {took:?} of {input:?}");
    let most = allowed(target, input.len());
    assert!(
        peak <= most,
        "{target} took {peak} bytes, more than {most}, for {} bytes: {input:?}",
        input.len()
    );
}

fn mutations(target: &str, function: fn(&[u8]), count: usize) {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut inputs = seeds::of(target);
    if inputs.is_empty() {
        let random_bytes = |k: usize| {
            let mut bytes = vec![0; 32 << (k % 5)];
            random.fill_bytes(&mut bytes);
            bytes
        };
        inputs = (0..RANDOM_SEEDS).map(random_bytes).collect();
    }
    inputs.extend(kept(target));
    if target == "npz" {
        run(target, function, &archive_bomb());
    }
    for input in &inputs {
        run(target, function, input);
    }
    for _ in 0..count {
        let input = mutation::of(&inputs, &mut random);
        run(target, function, &input);
    }
}

/// An archive of 130 kB with 128 MiB of zeros.
fn archive_bomb() -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    zip.start_file("q.npy", options).expect("an entry");
    for _ in 0..128 {
        zip.write_all(&[0; 1 << 20]).expect("memory");
    }
    zip.finish().expect("an archive").into_inner()
}

/// Inputs that failed before.
fn kept(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("findings")
        .join(target);
    let Ok(files) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut paths: Vec<_> = files.flatten().map(|file| file.path()).collect();
    paths.sort();
    (paths.iter())
        .map(|path| fs::read(path).expect("a finding can be read"))
        .collect()
}

#[test]
fn no_target_panics_hangs_or_takes_memory() {
    for (target, function) in TARGETS {
        // That of the first call: tables, seeds.
        function(&[]);
        let count = match target {
            "evidence" | "check" => 2000,
            _ => 3000,
        };
        let start = Instant::now();
        mutations(target, function, count);
        println!("{target}: {:?}", start.elapsed());
    }
}
