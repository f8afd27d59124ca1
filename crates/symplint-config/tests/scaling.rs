//! Canonical scalings (q, p) → (a q, p/a) of the examples: verdicts do not depend on units. `SYMPLINT_SCALINGS=20` tries more of
//! them.

use std::path::{Path, PathBuf};

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use symplint::{Verdict, VerdictKind};
use symplint_config::Config;
use symplint_truth::scaled::ScalingAdapter;

/// From 1e-9 to 1e9 with equal chance in the logarithm.
fn factor(random: &mut ChaCha8Rng) -> f64 {
    10f64.powf(18.0 * (f64::from(random.next_u32()) / f64::from(u32::MAX)) - 9.0)
}

fn examples() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = paths
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    paths.sort();
    paths
}

/// The verdict in coordinates that are scaled by these factors.
fn verdict(config: &Config, factors: Vec<f64>) -> Verdict {
    let map = ScalingAdapter::new(&*config.map, factors.clone());
    let phase_loop = ScalingAdapter::new(&*config.phase_loop, factors);
    config.diagnostic.run(&map, &phase_loop).unwrap().verdict
}

#[test]
fn examples_keep_their_verdicts_in_all_units() {
    keep_their_verdicts(&[]);
}

#[test]
fn examples_keep_their_verdicts_by_rk2_in_all_units() {
    keep_their_verdicts(&["integrator.name=rk2".to_owned()]);
}

fn keep_their_verdicts(settings: &[String]) {
    let scalings = std::env::var("SYMPLINT_SCALINGS").map_or(1, |count| count.parse().unwrap());
    let mut wrong = Vec::new();
    for path in examples() {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        // Maps have no integrator.
        let Ok(config) = Config::load(&path, settings) else {
            continue;
        };
        let dof = config.map.dof();
        let plain = verdict(&config, vec![1.0; dof]);
        assert_ne!(plain.kind, VerdictKind::Undecided, "{name}: {plain}");
        for seed in 0..scalings {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            // A grid has one spacing for all positions.
            let factors = match config.map.capabilities().coordinates.grid_spacing() > 0.0 {
                true => vec![factor(&mut random); dof],
                false => (0..dof).map(|_| factor(&mut random)).collect(),
            };
            let found = verdict(&config, factors);
            let same_digits = match (plain.digits, found.digits) {
                (Some(a), Some(b)) => (a - b).abs() <= 1.0,
                (a, b) => a == b,
            };
            let same = found.kind == plain.kind
                && found.order == plain.order
                && found.conserved_once_closed == plain.conserved_once_closed;
            if !(same && same_digits) {
                wrong.push(format!(
                    "{name} {settings:?}, scaling {seed}: {plain}, scaled {found}"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
