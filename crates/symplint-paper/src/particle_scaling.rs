//! Section 5.2: how the error of the finite-difference rule grows with the particles.

use serde::Serialize;
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement};
use super::error::PaperError;
use super::pic::{Case, PLASMAS, Setup, SweepRange};
use super::sweep::{doublings, line_text, power_law_line};

/// Numbers of particles; so few that λ = 1000 finds all their jumps with the samples below.
const PARTICLES: [usize; 4] = [2, 4, 8, 16];

/// Least number of samples.
const MIN_SAMPLES: u64 = 1 << 13;

/// The paper's choice, for which it expects four to five digits.
const PAPER_SAMPLES: usize = 1 << 15;

#[derive(Serialize)]
struct Row {
    plasma: &'static str,
    particles: usize,
    samples: usize,
    signed_defect: f64,
    omitted_cells: Option<usize>,
}

/// How the error of one plasma and number of particles scales with samples.
struct ErrorScaling {
    /// The factor of 1/N_s in the error; none where the jumps are not all left out.
    factor: Option<f64>,
    /// The error of the paper's number of samples, against the most samples.
    error: Option<f64>,
}

/// Measures linear splines at step size `h` with up to `to` samples, and judges.
pub fn claims(
    setup: &Setup,
    h: f64,
    to: u64,
    folder: &RunFolder,
) -> Result<Vec<Claim>, PaperError> {
    let over = SweepRange::Samples {
        counts: doublings(MIN_SAMPLES, to.max(MIN_SAMPLES)),
        step_size: h,
    };
    let mut rows = Vec::new();
    let mut found = Vec::new();
    for plasma in PLASMAS {
        for particles in PARTICLES {
            let case = Case {
                plasma,
                degree: 1,
                passes: 0,
            };
            let curve = setup
                .with_particles(particles)
                .measure(case, "Strang", &over)?;
            let of_curve: Vec<Row> = (curve.records.iter())
                .map(|record| Row {
                    plasma,
                    particles,
                    samples: record.samples,
                    signed_defect: record.signed_defect,
                    omitted_cells: record.omitted_cells,
                })
                .collect();
            found.push((plasma, particles, error_of(&of_curve)));
            rows.extend(of_curve);
        }
    }
    folder.write_csv("fig6_particles.csv", &rows)?;
    Ok(vec![growth(&found), digits(&found)])
}

fn error_of(rows: &[Row]) -> ErrorScaling {
    let Some(last) = rows.last() else {
        return ErrorScaling {
            factor: None,
            error: None,
        };
    };
    // Where further samples find further jumps, the sum is not yet that of the broken loop.
    let settled =
        |row: &&Row| row.omitted_cells == last.omitted_cells && row.omitted_cells > Some(0);
    let settled: Vec<&Row> = rows.iter().filter(settled).collect();
    // An error c/N changes by c/2N from N to 2N; jumps that move within their cells make c scatter.
    let factors: Vec<f64> = (settled.windows(2))
        .map(|pair| {
            2.0 * pair[0].samples as f64 * (pair[1].signed_defect - pair[0].signed_defect).abs()
        })
        .collect();
    let mean = factors.iter().sum::<f64>() / factors.len() as f64;
    let chosen = (settled.iter()).find(|row| row.samples == PAPER_SAMPLES);
    ErrorScaling {
        factor: (factors.len() >= 2).then_some(mean),
        error: chosen
            .filter(|row| last.samples >= 4 * row.samples)
            .map(|row| (last.signed_defect - row.signed_defect).abs()),
    }
}

fn growth(found: &[(&'static str, usize, ErrorScaling)]) -> Claim {
    let mut texts = Vec::new();
    let mut rates = Vec::new();
    for plasma in PLASMAS {
        let factors: Vec<(f64, f64)> = (found.iter())
            .filter(|(name, ..)| *name == plasma)
            .filter_map(|(_, particles, found)| Some((*particles as f64, found.factor?)))
            .collect();
        let rate = power_law_line(&factors);
        let list: Vec<String> = factors.iter().map(|f| format!("{:.1}", f.1)).collect();
        texts.push(format!(
            "{plasma}: c = {}, as {}",
            list.join(", "),
            line_text("N_p", rate)
        ));
        rates.push(rate);
    }
    let judgement = match rates[..] {
        [Some(a), Some(b)] => linear_growth([a.interval(), b.interval()]),
        _ => Judgement::Unresolved,
    };
    Claim::of_paper(
        "fig6",
        "section 5.2",
        "p = 1: the error is about O(N_p/N_s)",
        format!(
            "the error, relative to a loop integral that grows as N_p itself, is c/N_s with, for N_p = 2, 4, 8, \
             16, {}",
            texts.join("; ")
        ),
        judgement,
    )
}

/// Largest distance from 1 of the exponent of an error that grows as N_p.
const MAX_EXPONENT_ERROR: f64 = 0.25;

/// Whether both exponents, each somewhere in an interval, are about 1.
fn linear_growth([a, b]: [(f64, f64); 2]) -> Judgement {
    let both = |wanted| {
        // One that is elsewhere contradicts the claim, whatever the other one is.
        match [a, b].map(|interval| Judgement::of_interval(interval, wanted)) {
            [Judgement::Holds, Judgement::Holds] => Judgement::Holds,
            [Judgement::DoesNotHold, _] | [_, Judgement::DoesNotHold] => Judgement::DoesNotHold,
            _ => Judgement::Unresolved,
        }
    };
    // Slower growth keeps to the bound O(N_p/N_s), but is not a scaling like it.
    both((1.0 - MAX_EXPONENT_ERROR, 1.0 + MAX_EXPONENT_ERROR))
        .or_corrected(both((f64::NEG_INFINITY, 1.0)))
}

fn digits(found: &[(&'static str, usize, ErrorScaling)]) -> Claim {
    let errors: Vec<Option<f64>> = (found.iter())
        .filter(|(_, particles, _)| *particles == 2)
        .map(|(.., found)| found.error)
        .collect();
    let (measured, judgement) = match errors[..] {
        [Some(landau), Some(beams)] => {
            let places = |error: f64| -error.log10();
            (
                format!(
                    "error {landau:.1e} (Landau) and {beams:.1e} (two-stream) against the most samples, that is {:.1} \
                     and {:.1} decimal places",
                    places(landau),
                    places(beams)
                ),
                Judgement::with_correction(
                    // To half a place, as everywhere.
                    [landau, beams].iter().all(|&e| places(e) >= 3.5),
                    [landau, beams].iter().all(|&e| places(e) >= 2.5),
                ),
            )
        }
        _ => (
            "too few samples to find all jumps".into(),
            Judgement::Unresolved,
        ),
    };
    Claim::of_paper(
        "fig6",
        "section 5.2",
        "p = 1: four to five decimal places with N_p = 2 and N_s = 2^15",
        measured,
        judgement,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_that_may_be_anything_decide_nothing() {
        assert_eq!(
            linear_growth([(0.1, 1.2), (-1.0, 1.5)]),
            Judgement::Unresolved
        );
        assert_eq!(linear_growth([(0.9, 1.1), (0.8, 1.2)]), Judgement::Holds);
        assert_eq!(
            linear_growth([(0.4, 0.6), (0.2, 0.7)]),
            Judgement::HoldsCorrected
        );
        assert_eq!(
            linear_growth([(1.9, 2.1), (0.9, 1.1)]),
            Judgement::DoesNotHold
        );
    }
}
