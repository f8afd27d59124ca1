//! What section 5.3 says of filtering and of figure 9.

use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig};

use super::claim::{Claim, Judgement};
use super::error::PaperError;
use super::estimate::Estimate;
use super::pic::{Case, Curves, Setup};
use super::sweep::{Record, power_law, trend_text, worst};
use super::true_defect;

/// The samples and particles of the paper's figure.
const SAMPLES: usize = 1 << 15;
const PARTICLES: usize = 2;

/// Filter passes.
pub const PASSES: [u32; 3] = [0, 2, 4];

/// One of the figure's cases.
pub fn filtered(degree: usize, passes: u32) -> Case {
    Case {
        plasma: "two-stream",
        degree,
        passes,
    }
}

/// Largest factor of a slight reduction.
const MAX_SLIGHT_FACTOR: f64 = 10.0;

/// Largest relative change of a defect that is almost none.
const MAX_SLIGHT_CHANGE: f64 = 0.5;

/// Largest difference of rates that are the same.
const MAX_RATE_DIFFERENCE: f64 = 0.25;

/// Judges figure 9: `steps` over the step size, `counts` over the number of samples.
pub fn claims(
    steps: &Curves,
    counts: &Curves,
    setup: &Setup,
    samples: usize,
) -> Result<Vec<Claim>, PaperError> {
    let paper = samples == SAMPLES && setup.particles == PARTICLES;
    let quadratic = errors(steps, 2);
    let cubic = errors(steps, 3);
    Ok(vec![
        linear(steps).resolved_if(paper),
        reduced("quadratic", quadratic).resolved_if(paper),
        analogous(quadratic, cubic).resolved_if(paper),
        faster(counts, 2, "quadratic").resolved_if(paper),
        faster(counts, 3, "cubic").resolved_if(paper),
        smaller_jumps(1)?,
        smaller_jumps(2)?,
    ])
}

fn claim(says: impl Into<String>, measured: String, judgement: Judgement) -> Claim {
    Claim::of_paper("fig9", "section 5.3", says, measured, judgement)
}

fn strang(curves: &Curves, degree: usize, passes: u32) -> &[Record] {
    curves.of(filtered(degree, passes), "Strang")
}

/// The largest defect of Strang for each number of passes.
fn largest(steps: &Curves, degree: usize) -> [f64; 3] {
    PASSES.map(|passes| worst(strang(steps, degree, passes)))
}

/// The largest error of the rule on Strang's loops for each number of passes, which is their defect but for what
/// the piecewise rule finds; none where it does not tell.
fn errors(steps: &Curves, degree: usize) -> Option<[Estimate; 3]> {
    let of = |passes| true_defect::largest_error(strang(steps, degree, passes));
    match PASSES.map(of) {
        [Some(plain), Some(some), Some(most)] => Some([plain, some, most]),
        _ => None,
    }
}

/// By what factor the most passes make the errors smaller, at least and at most.
fn factor(errors: Option<[Estimate; 3]>) -> (f64, f64) {
    errors.map_or((f64::NAN, f64::NAN), |[plain, _, filtered]| {
        plain.factor_over(filtered)
    })
}

/// The errors in words.
fn errors_text(errors: Option<[Estimate; 3]>) -> String {
    let Some(errors) = errors else {
        return "not known".into();
    };
    let [none, two, four] = errors.map(|estimate| estimate.size);
    let within = errors
        .iter()
        .map(|estimate| estimate.error)
        .fold(0.0, f64::max);
    let (low, high) = factor(Some(errors));
    format!(
        "{none:.1e}, {two:.1e}, {four:.1e} for s = 0, 2, 4, each known to {within:.0e}, so smaller by a factor of \
         {low:.0} to {high:.0} in all"
    )
}

/// The smallest and the largest of what is left of a defect after the most passes, over the step sizes where
/// both defects exceed their uncertainty clearly; none with fewer than three.
fn left_over(steps: &Curves, degree: usize) -> Option<(f64, f64)> {
    let clear = |r: &Record| r.defect() > 3.0 * r.uncertainty();
    let ratios: Vec<f64> = (strang(steps, degree, PASSES[0]).iter())
        .zip(strang(steps, degree, PASSES[2]))
        .filter(|(plain, filtered)| clear(plain) && clear(filtered))
        .map(|(plain, filtered)| filtered.defect() / plain.defect())
        .collect();
    let range = (ratios.iter()).fold((f64::INFINITY, 0.0f64), |(l, h), &r| (l.min(r), h.max(r)));
    (ratios.len() >= 3).then_some(range)
}

fn linear(steps: &Curves) -> Claim {
    let largest = largest(steps, 1);
    let left = left_over(steps, 1);
    let (text, judgement) = match left {
        Some((low, high)) => (
            format!(
                "; {low:.2} to {high:.2} of it is left after four passes at every step size where both exceed \
                 three times their uncertainty"
            ),
            Judgement::with_correction(low > 1.0 - MAX_SLIGHT_CHANGE, low > 0.1),
        ),
        None => (
            "; too few of them exceed three times their uncertainty".into(),
            Judgement::Unresolved,
        ),
    };
    claim(
        "linear: filtering has almost no effect on the defect",
        format!(
            "largest defect of Strang {:.1e}, {:.1e}, {:.1e} for s = 0, 2, 4{text}",
            largest[0], largest[1], largest[2]
        ),
        judgement,
    )
}

fn reduced(name: &str, errors: Option<[Estimate; 3]>) -> Claim {
    claim(
        format!("{name}: filtering reduces the defect slightly"),
        format!(
            "largest defect of Strang, all of it quadrature error by the piecewise rule: {}",
            errors_text(errors)
        ),
        Judgement::of_interval(factor(errors), (1.0, MAX_SLIGHT_FACTOR))
            .or_corrected(Judgement::of_interval(factor(errors), (1.0, f64::INFINITY))),
    )
}

fn analogous(quadratic: Option<[Estimate; 3]>, cubic: Option<[Estimate; 3]>) -> Claim {
    let (of_quadratic, of_cubic) = (factor(quadratic), factor(cubic));
    let more = (1.0, f64::INFINITY);
    let ratio = (of_quadratic.0 / of_cubic.1, of_quadratic.1 / of_cubic.0);
    let both_smaller = [of_quadratic, of_cubic].map(|f| Judgement::of_interval(f, more));
    let judgement = if both_smaller == [Judgement::Holds; 2] {
        Judgement::of_interval(ratio, (1.0 / MAX_SLIGHT_FACTOR, MAX_SLIGHT_FACTOR))
            .or_corrected(Judgement::Holds)
    } else if both_smaller.contains(&Judgement::DoesNotHold) {
        Judgement::DoesNotHold
    } else {
        Judgement::Unresolved
    };
    claim(
        "the cubic case is entirely analogous to the quadratic one",
        format!(
            "largest defect of Strang, all of it quadrature error: {}; quadratic: by {:.0} to {:.0}",
            errors_text(cubic),
            of_quadratic.0,
            of_quadratic.1
        ),
        judgement,
    )
}

fn faster(counts: &Curves, degree: usize, name: &str) -> Claim {
    let curves = PASSES.map(|passes| -> Vec<(f64, f64)> {
        (strang(counts, degree, passes).iter())
            .map(|r| (r.samples as f64, r.uncertainty()))
            .collect()
    });
    let rates = [0, 1, 2].map(|k| power_law(&curves[k]));
    // The points at which the unfiltered error is above round-off.
    let gains: Vec<f64> = (curves[0].iter().zip(&curves[2]))
        .filter(|(plain, filtered)| plain.1 > 1e-13 && filtered.1 > 1e-13)
        .map(|(plain, filtered)| plain.1 / filtered.1)
        .collect();
    let least = gains.iter().copied().fold(f64::INFINITY, f64::min);
    let most = gains.iter().copied().fold(0.0, f64::max);
    let judgement = match rates {
        [Some(plain), _, Some(filtered)] => {
            Judgement::with_correction(filtered < plain - MAX_RATE_DIFFERENCE, least > 1.0)
        }
        _ => Judgement::Unresolved,
    };
    claim(
        format!(
            "{name}: filtering modifies the trend in N_s, so that the loop integral converges more quickly"
        ),
        format!(
            "quadrature error of Strang as {}, {}, {} for s = 0, 2, 4, and smaller by a factor of {least:.1} to \
             {most:.0} with four passes",
            trend_text("N", rates[0]),
            trend_text("N", rates[1]),
            trend_text("N", rates[2])
        ),
        judgement,
    )
}

/// How much the (p − 1)-th derivative of the force on a particle jumps at most as it crosses a grid point: that
/// is the p-th of the potential.
fn jump(degree: usize, passes: u32) -> Result<f64, PaperError> {
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Equal {
            particles: 2,
            density: 1.0,
        },
        degree,
        filter_passes: passes,
        ..PicConfig::default()
    })?;
    let config = PicConfig::default();
    let cell = config.length / config.cells as f64;
    // Both in mid-box, the other one anywhere near: the jump changes its sign with the distance. Splines of
    // degrees 1 and 2 have their knots on the grid points.
    let at = 20.0 * cell;
    let (near, far) = (1e-7, 1e-3);
    let jump_beside = |other: f64| {
        let force = |cells: f64| pic.field(&[at + cells * cell, at + other * cell])[0];
        match degree {
            1 => force(near) - force(-near),
            _ => {
                ((force(far) - force(near)) - (force(-near) - force(-far))) / ((far - near) * cell)
            }
        }
    };
    Ok((0..100)
        .map(|k| jump_beside(0.05 + 0.1 * f64::from(k)).abs())
        .fold(0.0, f64::max))
}

fn smaller_jumps(degree: usize) -> Result<Claim, PaperError> {
    let mut jumps = [0.0; 3];
    for (jump_of, passes) in jumps.iter_mut().zip(PASSES) {
        *jump_of = jump(degree, passes)?;
    }
    Ok(claim(
        format!(
            "p = {degree}: filtering decreases the jump of the derivative of order {degree} of the potential"
        ),
        format!(
            "{:.2e}, {:.2e}, {:.2e} for s = 0, 2, 4 at most, where a particle crosses a grid point with another up \
             to ten cells off",
            jumps[0], jumps[1], jumps[2]
        ),
        Judgement::of(jumps[0] > jumps[1] && jumps[1] > jumps[2]).if_resolved(jumps[0] > 1e-6),
    ))
}
