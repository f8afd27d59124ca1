//! Formulas of the paper that can be checked without a loop.

use std::f64::consts::{PI, TAU};

use symplint::rules::logarithmic_defect;
use symplint::state::{Rows, RowsMut};
use symplint_models::Separable;
use symplint_models::bspline;
use symplint_models::integrators::{Tableau, TableauPair, tableaus};
use symplint_models::systems::TwoCell;
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::Settings;

pub const ITEM: Item = Item {
    id: "formulas",
    title: "formulas of sections 3.1, 4.3, 5.3 and appendices C, D, F",
    cost: "1 s",
    keys: &[],
    check: None,
    run,
};

fn run(_: &Settings, _: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    Ok(vec![
        logarithmic_form(),
        spline_index(),
        gaussian_filter(),
        spline_transform(),
        momentum_first_pair(),
        position_first_pair()?,
        two_cells()?,
    ])
}

fn claim(place: &'static str, says: &str, measured: String, judgement: Judgement) -> Claim {
    Claim {
        item: "formulas",
        origin: Origin::Paper,
        place,
        says: says.to_owned(),
        measured,
        judgement,
    }
}

fn logarithmic_form() -> Claim {
    // Neighbouring doubles: their difference is exact, the logarithms are rounded.
    let (mut direct, mut by_logarithms) = (0.0f64, 0.0f64);
    for k in 1..=200 {
        let initial = f64::from(k) * PI;
        let advanced = initial * (1.0 + 8.0 * f64::EPSILON);
        let exact = units_between(initial, advanced);
        direct = direct.max(((advanced - initial) / initial / f64::EPSILON - exact).abs());
        let logarithmic = logarithmic_defect(initial, advanced).unwrap_or(f64::NAN);
        by_logarithms = by_logarithms.max((logarithmic / f64::EPSILON - exact).abs());
    }
    claim(
        "section 3.1",
        "the logarithmic form of the defect is the more stable one for small errors",
        format!(
            "off by up to {by_logarithms:.1} units of round-off for integrals of 1 to 200 circles, the plain \
             difference by {direct:.1}: nearby doubles are subtracted exactly"
        ),
        Judgement::of(by_logarithms <= direct),
    )
}

/// The relative distance of two neighbours in one binade in units of `f64::EPSILON`, from their bits: the
/// number of steps between them over the significand, one rounding and no subtraction.
fn units_between(initial: f64, advanced: f64) -> f64 {
    const HIDDEN: u64 = 1 << 52;
    let steps = advanced.to_bits() - initial.to_bits();
    let significand = initial.to_bits() % HIDDEN + HIDDEN;
    steps as f64 / significand as f64 * HIDDEN as f64
}

fn spline_index() -> Claim {
    // On [q_i, q_{i+1}] the splines i−α … i live; the text sums i−α+1 … i+1.
    let (mut printed, mut corrected) = (0.0f64, 0.0f64);
    for degree in 1..=5 {
        for step in 0..=10 {
            let weights = bspline::weights(degree, f64::from(step) / 10.0);
            let all: f64 = weights.iter().sum();
            corrected = corrected.max((all - 1.0).abs());
            printed = printed.max((all - weights[0] - 1.0).abs());
        }
    }
    claim(
        "section 4.3",
        "the interpolant on [q_i, q_{i+1}] is the sum of V_j B_j over j = i−α+1 … i+1",
        format!(
            "these splines miss a sum of 1 by up to {printed:.1}; those of j = i−α … i by {corrected:.0e}"
        ),
        Judgement::with_correction(printed < 1e-14, corrected < 1e-14),
    )
}

fn gaussian_filter() -> Claim {
    // σ = √s Δx fixed, kσ = 1: the distance falls as 1/s.
    let distance = |passes: f64| {
        let kappa = 1.0 / passes.sqrt();
        ((0.5 + 0.5 * kappa.cos()).powf(passes) - (-0.25f64).exp()).abs()
    };
    let ratio = distance(64.0) / distance(256.0);
    claim(
        "section 5.3",
        "many passes of the filter tend to exp(−(σk/2)²), σ = √s Δx",
        format!(
            "off by {:.1e} after 64 passes and {:.1e} after 256 at σk = 1",
            distance(64.0),
            distance(256.0)
        ),
        Judgement::of((ratio - 4.0).abs() < 0.2),
    )
}

fn spline_transform() -> Claim {
    // The unitary transform of the hat at k = 1 by the midpoint rule.
    const N: i32 = 20_000;
    let sum: f64 = (0..N)
        .map(|m| 2.0 * (f64::from(m) + 0.5) / f64::from(N) - 1.0)
        .map(|x| (1.0 - x.abs()) * x.cos())
        .sum();
    let measured = sum * 2.0 / f64::from(N) / TAU.sqrt();
    let sinc = 0.5f64.sin() / 0.5;
    let printed = (sinc / TAU.sqrt()).powi(2);
    let corrected = sinc.powi(2) / TAU.sqrt();
    claim(
        "appendix C",
        "the transform of B_p is (sinc(k/2)/√(2π))^{p+1}",
        format!(
            "for p = 1, k = 1 it is {measured:.6}, not {printed:.6}: each convolution brings √(2π), which gives \
             sinc(k/2)^{{p+1}}/√(2π) = {corrected:.6}; the decay, and so the regularity, is the same"
        ),
        Judgement::with_correction(
            (measured - printed).abs() < 1e-6,
            (measured - corrected).abs() < 1e-6,
        ),
    )
}

fn momentum_first_pair() -> Claim {
    let residual = tableaus::strang_momentum_first().symplecticity_residual();
    claim(
        "appendix D",
        "momentum-first Strang splitting meets b_i â_ij + b̂_j a_ji = b_i b̂_j",
        format!("largest residual {:.0e}", residual.value.abs()),
        Judgement::of(residual.vanishes()),
    )
}

fn position_first_pair() -> Result<Claim, PaperError> {
    let printed = TableauPair::new(
        "as printed",
        tableaus::strang_position_first().position().clone(),
        Tableau::new("momentum", 2, &[&[0.0, 0.0], &[1.0, 0.0]], &[0.0, 1.0], "")?,
    )?;
    let residual = printed.symplecticity_residual();
    let corrected = tableaus::strang_position_first().symplecticity_residual();
    Ok(claim(
        "appendix D",
        "position-first Strang splitting with b̂ = (0, 1) meets the same condition",
        format!(
            "it misses it by {:.2} at i = {}, j = {}; b̂ = (1, 0), which gives the same step, meets it to {:.0e}",
            residual.value.abs(),
            residual.i + 1,
            residual.j + 1,
            corrected.value.abs()
        ),
        Judgement::with_correction(residual.vanishes(), corrected.vanishes()),
    ))
}

fn two_cells() -> Result<Claim, PaperError> {
    let cell = 2.5;
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Each(vec![1.0 / cell]),
        cells: 2,
        length: 2.0 * cell,
        degree: 1,
        ..PicConfig::default()
    })?;
    let formula = TwoCell::new(cell)?;
    let mut largest: f64 = 0.0;
    for k in 0..1000 {
        // Not at a cell's boundary, where the force jumps.
        let x = cell * (f64::from(k) + 0.5) / 250.0 - 2.0 * cell;
        let mut force = [0.0];
        let mut row = RowsMut::new(&mut force, 1, 1, 1);
        formula.kick(1.0, Rows::new(&[x], 1, 1, 1), &mut row);
        largest = largest.max((pic.field(&[x])[0] - force[0]).abs());
    }
    Ok(claim(
        "appendix F",
        "a particle in its own field on two cells feels (½ − |x/L|) sign(x)/2L",
        format!("the particle-in-cell force differs from it by at most {largest:.0e}"),
        Judgement::of(largest < 1e-15),
    ))
}
