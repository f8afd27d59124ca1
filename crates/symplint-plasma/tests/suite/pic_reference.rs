//! Particle-in-cell plasmas against figures computed by independent code.

use std::collections::HashMap;
use std::sync::Arc;

use symplint::rules::Cutoffs;
use symplint::state::{Rows, RowsMut};
use symplint::{Block, Circle, Defect, Ensemble, LoopIntegral, Phases, Rule, TimeAdvance};
use symplint_models::integrators::catalogue::build;
use symplint_models::{Hamiltonian, Separable};
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig};

/// Rows of a CSV file by column name.
fn table(text: &str) -> Vec<HashMap<&str, &str>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| names.iter().copied().zip(line.split(',')).collect())
        .collect()
}

fn number(row: &HashMap<&str, &str>, column: &str) -> f64 {
    let value = row[column];
    value
        .parse()
        .unwrap_or_else(|_| panic!("{column}: {value}"))
}

/// Positions and velocities from a NumPy 1.0 file of two rows in C order.
fn state(bytes: &[u8]) -> (Vec<f64>, Vec<f64>) {
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..start]).unwrap();
    assert!(header.contains("'descr': '<f8', 'fortran_order': False, 'shape': (2,"));
    let (values, rest) = bytes[start..].as_chunks();
    assert!(rest.is_empty());
    let values: Vec<f64> = values.iter().map(|v| f64::from_le_bytes(*v)).collect();
    let (x, v) = values.split_at(values.len() / 2);
    (x.to_vec(), v.to_vec())
}

fn plasma(particles: usize, cells: usize, degree: usize, filter_passes: u32) -> Arc<Pic1d> {
    let config = PicConfig {
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        cells,
        degree,
        filter_passes,
        ..PicConfig::default()
    };
    Arc::new(Pic1d::new(config).unwrap())
}

fn integral(ensemble: &Ensemble, rule: &Rule, map: &dyn TimeAdvance) -> LoopIntegral {
    LoopIntegral::in_coordinates(ensemble, rule, &map.capabilities().coordinates).unwrap()
}

const MAPS: [(&str, &str, &str); 4] = [
    ("strang_p", "strang", "momentum-first"),
    ("strang_q", "strang", "position-first"),
    ("heun", "rk2", "heun"),
    ("midpoint", "rk2", "midpoint"),
];

fn check_defects(row: &HashMap<&str, &str>) {
    let (degree, passes) = (number(row, "order") as usize, number(row, "filter") as u32);
    let (particles, samples) = (number(row, "Np") as usize, number(row, "Ns") as usize);
    let h = number(row, "dt");
    let (x, v) = state(match particles {
        2 => include_bytes!("reference/init_two_stream_Np2.npy").as_slice(),
        _ => include_bytes!("reference/init_two_stream_Np128.npy").as_slice(),
    });
    assert_eq!(x.len(), particles);
    let circle = Circle::new(x, v, 1.0).unwrap().with_phases(Phases::Equal);
    let start = Ensemble::sample(&circle, samples).unwrap();
    let cut_off = Rule::FiniteDifference(Cutoffs::relative(1000.0));
    for (label, name, variant) in MAPS {
        let what = format!(
            "{label}, degree {degree}, filter {passes}, {particles} particles, {samples} samples, h = {h}"
        );
        let map = build(name, Some(variant), plasma(particles, 128, degree, passes)).unwrap();
        let mut advanced = start.clone();
        advanced.advance(&*map, h).unwrap();
        let defect = |rule: &Rule| -> (f64, LoopIntegral) {
            let after = integral(&advanced, rule, &*map);
            let defect = Defect::between(&integral(&start, rule, &*map), &after).unwrap();
            (defect.magnitude(), after)
        };

        let (measured, _) = defect(&Rule::Pseudospectral);
        let reference = number(row, &format!("relerr_{label}"));
        assert!(
            (measured - reference).abs() < 1e-10 + 0.01 * reference,
            "{what}: {measured:e} where the reference has {reference:e}"
        );

        let (measured, after) = defect(&cut_off);
        let reference = number(row, &format!("fd_relerr_{label}"));
        assert!(
            (measured - reference).abs() < 0.01 * reference,
            "{what}, cut-off rule: {measured:e} where the reference has {reference:e}"
        );
        let omitted = after.omitted.unwrap().len() as f64;
        let dropped = number(row, &format!("fd_dropped_{label}"));
        assert!(
            (omitted - dropped).abs() <= 2.0,
            "{what}: {omitted} omitted, not {dropped}"
        );
    }
}

#[test]
fn defects_against_step_sizes() {
    let text = include_str!("reference/two_stream_pic_dt_sweep_Ns32768.csv");
    let rows = table(text);
    assert_eq!(rows.len(), 70);
    rows.iter().for_each(check_defects);
}

#[test]
fn defects_against_samples() {
    let rows = table(include_str!("reference/two_stream_pic_Ns_sweep_dt0.1.csv"));
    assert_eq!(rows.len(), 63);
    rows.iter().for_each(check_defects);
}

/// Kinetic, field and total energy at each step of momentum-first Strang splitting. The reference
/// has energies per cell width.
fn check_energies(degree: usize, text: &str) {
    let (mut x, mut v) = state(include_bytes!("reference/init_two_stream_Np10000.npy"));
    let plasma = plasma(10_000, 200, degree, 0);
    let width = 50.0 / 200.0;
    let map = build("strang", Some("momentum-first"), plasma.clone()).unwrap();
    for (step, row) in table(text).iter().enumerate() {
        let (mut kinetic, mut field, mut total) = ([0.0], [0.0], [0.0]);
        let rows = (Rows::new(&x, 10_000, 1, 1), Rows::new(&v, 10_000, 1, 1));
        plasma.kinetic_energy(rows.1, &mut kinetic);
        plasma.potential_energy(rows.0, &mut field);
        plasma.energy(rows.0, rows.1, &mut total);
        for (what, [got], bound) in [
            ("KE", kinetic, 1e-9),
            ("EE", field, 1e-8),
            ("total", total, 1e-9),
        ] {
            let expected = number(row, what);
            let off = (got / width / expected - 1.0).abs();
            assert!(
                off < bound,
                "degree {degree}, step {step}, {what}: off by {off:e}"
            );
        }
        let mut block = Block::new(
            RowsMut::new(&mut x, 10_000, 1, 1),
            RowsMut::new(&mut v, 10_000, 1, 1),
        );
        map.advance(0.01, &mut block).unwrap();
    }
}

#[test]
fn energies_of_linear_splines() {
    check_energies(1, include_str!("reference/pic_energy_two_stream_o1.csv"));
}

#[test]
fn energies_of_quadratic_splines() {
    check_energies(2, include_str!("reference/pic_energy_two_stream_o2.csv"));
}

#[test]
fn energies_of_cubic_splines() {
    check_energies(3, include_str!("reference/pic_energy_two_stream_o3.csv"));
}
