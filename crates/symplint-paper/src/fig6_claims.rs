//! What section 5.2 and the conclusion say of figure 6.

use super::claim::{Claim, Judgement};
use super::pic::{Case, Curves, PLASMAS, Setup};
use super::sweep::{Record, line_text, power_law_line};

/// The paper's statements are about these settings.
const LAMBDA: f64 = 1000.0;
const PARTICLES: usize = 128;
const STEP_SIZE: f64 = 0.1;

/// Judges figure 6, measured at one step size.
pub fn claims(curves: &Curves, setup: &Setup, step_size: f64) -> Vec<Claim> {
    let paper = setup.particles == PARTICLES && step_size == STEP_SIZE;
    let paper_cutoff = of_the_paper(setup, step_size);
    vec![
        rate(curves, 2).resolved_if(paper),
        rate(curves, 3).resolved_if(paper),
        saturation(curves).resolved_if(paper_cutoff),
        onset(curves).resolved_if(paper_cutoff),
        cubic_is_cheaper(curves).resolved_if(paper),
    ]
}

/// Whether these are the settings of the paper's figure.
pub fn of_the_paper(setup: &Setup, step_size: f64) -> bool {
    setup.particles == PARTICLES && step_size == STEP_SIZE && setup.cutoff == LAMBDA
}

fn claim(says: impl Into<String>, measured: String, judgement: Judgement) -> Claim {
    Claim::of_paper("fig6", "section 5.2", says, measured, judgement)
}

fn strang<'a>(curves: &'a Curves, plasma: &'static str, degree: usize) -> &'a [Record] {
    let case = Case {
        plasma,
        degree,
        passes: 0,
    };
    curves.of(case, "Strang")
}

fn rate(curves: &Curves, degree: usize) -> Claim {
    let of = |what: fn(&Record) -> f64| {
        PLASMAS.map(|plasma| {
            let points: Vec<(f64, f64)> = (strang(curves, plasma, degree).iter())
                .map(|r| (r.samples as f64, what(r)))
                .collect();
            power_law_line(&points)
        })
    };
    // Single errors scatter with the places of the kinks; the estimate, which bounds them, does not.
    let bounds = of(Record::uncertainty);
    let errors = of(|r| r.rule_error().map_or(f64::NAN, |error| error.size));
    let expected = -(degree as f64);
    let window = (expected - 0.5, expected + 0.5);
    let judgement = match (bounds, errors) {
        ([Some(a), Some(b)], [Some(c), Some(d)]) => {
            let bounded = [a, b]
                .iter()
                .all(|line| (line.slope - expected).abs() < 0.5);
            let refuted = ([c, d].iter()).any(|line| {
                Judgement::of_interval(line.interval(), window) == Judgement::DoesNotHold
            });
            Judgement::of(bounded && !refuted)
        }
        _ => Judgement::Unresolved,
    };
    claim(
        format!("p = {degree}: Strang converges with the samples as N^-{degree}"),
        format!(
            "the bound on its quadrature error goes as {} (Landau) and {} (two-stream), the error itself, known from \
             the piecewise rule, scatters below it as {} and {}",
            line_text("N", bounds[0]),
            line_text("N", bounds[1]),
            line_text("N", errors[0]),
            line_text("N", errors[1])
        ),
        judgement,
    )
}

/// The limit for N → ∞ of a curve whose error falls as 1/N: from its last two points, if the three last show
/// that law.
fn limit(signed: &[f64]) -> Option<f64> {
    let [.., a, b, c] = signed else { return None };
    let ratio = (a - b) / (b - c);
    (1.6..2.5).contains(&ratio).then(|| 2.0 * c - b)
}

fn saturation(curves: &Curves) -> Claim {
    let mut texts = Vec::new();
    let (mut at_once, mut later) = (true, true);
    let mut resolved = true;
    for plasma in PLASMAS {
        let kept: Vec<&Record> = (strang(curves, plasma, 1).iter())
            .take_while(|r| r.omitted_cells == Some(0))
            .collect();
        let signed: Vec<f64> = kept.iter().map(|r| r.signed_defect).collect();
        let first = kept.iter().find(|r| r.samples as f64 > LAMBDA);
        let (Some(first), Some(last), Some(limit)) = (first, kept.last(), limit(&signed)) else {
            texts.push(format!("{plasma}: too few samples to tell"));
            resolved = false;
            continue;
        };
        at_once &= (first.signed_defect / limit - 1.0).abs() < 0.25;
        later &= (last.signed_defect / limit - 1.0).abs() < 0.5;
        texts.push(format!(
            "{plasma}: {:.1e} with {} samples, {:.1e} with {}, still falling as 1/N to {limit:.1e}",
            first.signed_defect, first.samples, last.signed_defect, last.samples
        ));
    }
    claim(
        "p = 1: no convergence is seen, because the quadrature error has saturated for N_s > 1000",
        texts.join("; "),
        Judgement::with_correction(at_once, later).if_resolved(resolved),
    )
}

fn onset(curves: &Curves) -> Claim {
    let mut texts = Vec::new();
    let (mut near, mut above) = (true, true);
    let mut resolved = true;
    for plasma in PLASMAS {
        let records = strang(curves, plasma, 1);
        resolved &= records.iter().any(|r| r.samples as f64 > LAMBDA);
        let first = (records.iter()).find(|r| r.omitted_cells.is_some_and(|cells| cells > 0));
        let Some((first, last)) = first.zip(records.last()) else {
            resolved = false;
            texts.push(format!("{plasma}: none left out at any number"));
            continue;
        };
        near &= (LAMBDA..=2.0 * LAMBDA).contains(&(first.samples as f64));
        above &= first.samples as f64 > LAMBDA;
        texts.push(format!(
            "{plasma}: cells left out from {} samples on, {} with {}, defect {:.1e}",
            first.samples,
            last.omitted_cells.unwrap_or(0),
            last.samples,
            last.signed_defect
        ));
    }
    claim(
        "p = 1: with λ = 1000 jumps are left out, and the sum converges, only for N_s > 1000",
        texts.join("; "),
        Judgement::with_correction(near && above, above).if_resolved(resolved),
    )
}

fn cubic_is_cheaper(curves: &Curves) -> Claim {
    const MAX_DEFECT: f64 = 1e-8;
    let needed = |degree: usize| {
        PLASMAS.map(|plasma| {
            // From where on it stays there: a single error may be small by accident.
            (strang(curves, plasma, degree).iter().rev())
                .take_while(|r| r.rule_error().is_some_and(|error| error.size < MAX_DEFECT))
                .last()
                .map(|r| r.samples)
        })
    };
    let (quadratic, cubic) = (needed(2), needed(3));
    let text = |needed: Option<usize>| needed.map_or("more than tried".into(), |n| n.to_string());
    let fewer = |(quadratic, cubic): (&Option<usize>, &Option<usize>)| {
        quadratic.is_none_or(|quadratic| cubic.is_some_and(|cubic| cubic < quadratic))
    };
    let holds = quadratic.iter().zip(&cubic).all(fewer);
    // If the fewest samples are enough for both, there is nothing to compare.
    let fewest = PLASMAS.map(|plasma| strang(curves, plasma, 2).first().map(|r| r.samples));
    let resolved = cubic.iter().all(Option::is_some) && quadratic != fewest;
    Claim::of_paper(
        "fig6",
        "section 6",
        "cubic splines need a smaller ensemble than quadratic ones",
        format!(
            "quadrature error below 1e-8 from {} (Landau) and {} (two-stream) samples on, quadratic: from {} and {}",
            text(cubic[0]),
            text(cubic[1]),
            text(quadratic[0]),
            text(quadratic[1])
        ),
        Judgement::of(holds).if_resolved(resolved),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_need_the_law_they_are_taken_from() {
        let law: Vec<f64> = (6..12).map(|m| -0.2 + 3.0 * 0.5f64.powi(m)).collect();
        assert!((limit(&law).unwrap() + 0.2).abs() < 1e-12);
        assert_eq!(limit(&law[..2]), None);
        assert_eq!(limit(&[-0.2, -0.3, -0.5]), None);
    }
}
