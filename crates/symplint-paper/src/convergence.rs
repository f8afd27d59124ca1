//! Section 2.4: how the errors of both rules add up over degrees of freedom, and which rule is the faster.

use serde::Serialize;
use symplint::rules::{Cutoff, Cutoffs};
use symplint::{Ensemble, LoopIntegral, Rule};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, reference_slope, series};
use symplint_report::run_folder::RunFolder;

use super::appendix_a::{self, Curve, OFFSET, START, bernoulli};
use super::appendix_b;
use super::claim::{Claim, Judgement};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{doublings, power_law, trend_text};

pub const ITEM: Item = Item {
    id: "convergence",
    title: "errors of both rules over degrees of freedom, and which rule is faster (section 2.4)",
    cost: "1 s",
    keys: &[
        Key::whole_between("from", 1 << 6, (3, 1 << 16), "fewest samples, made odd"),
        Key::whole_between("to", 1 << 13, (3, 1 << 16), "most samples, made odd"),
        Key::whole_between("dof", 256, (1, 1 << 10), "most degrees of freedom"),
    ],
    check: None,
    run,
};

/// All differences count.
const WHOLE: Rule = Rule::FiniteDifference(Cutoffs {
    q: Cutoff::Absolute(f64::INFINITY),
    p: Cutoff::Absolute(f64::INFINITY),
});

/// Jumps of the loop of appendix B are left out from some hundred samples on.
const WITHOUT_JUMPS: Rule = Rule::FiniteDifference(Cutoffs {
    q: Cutoff::Absolute(15.0),
    p: Cutoff::Absolute(5.0),
});

/// Degree of the Bernoulli polynomials of the smooth components: in H^r for r < 3/2, so that β = 3/2.
const DEGREE: usize = 2;

/// Component i of a loop: (q, p) at s.
type Component = fn(usize, f64) -> (f64, f64);

/// Kinks at other places for every component.
fn kinked(i: usize, s: f64) -> (f64, f64) {
    let at = s + START + i as f64 * OFFSET;
    (bernoulli(DEGREE, at), bernoulli(DEGREE, at + OFFSET))
}

/// The loop of appendix B from another start for every component.
fn jumping(i: usize, s: f64) -> (f64, f64) {
    let shifted = s + i as f64 * OFFSET;
    let s = shifted - shifted.floor();
    (appendix_b::q(s), appendix_b::p(s))
}

fn sampled(component: Component, dof: std::ops::Range<usize>, samples: usize) -> Ensemble {
    let mut ensemble = Ensemble::zeros(dof.len(), samples);
    let mut block = ensemble.block();
    for (row, i) in dof.enumerate() {
        for k in 0..samples {
            let (q, p) = component(i, k as f64 / samples as f64);
            (block.q.row_mut(row)[k], block.p.row_mut(row)[k]) = (q, p);
        }
    }
    ensemble
}

#[derive(Serialize)]
struct Row {
    rule: &'static str,
    dof: usize,
    samples: usize,
    error: f64,
    /// The largest error of one component, times their number.
    errors_added: f64,
    /// The bound of section 2.4, if it has no unknown constant.
    bound: Option<f64>,
}

/// A rule with the loops that it is for.
struct Case {
    name: &'static str,
    rule: Rule,
    component: Component,
    exact: f64,
    bound: Option<fn(f64) -> f64>,
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let counts = doublings(settings.whole("from"), settings.whole("to"));
    let counts: Vec<usize> = counts.into_iter().map(|count| count | 1).collect();
    let most = settings.count("dof");
    let cases = [
        Case {
            name: "pseudospectral",
            rule: Rule::Pseudospectral,
            component: kinked,
            exact: appendix_a::exact(DEGREE),
            bound: None,
        },
        Case {
            name: "finite-difference",
            rule: WITHOUT_JUMPS,
            component: jumping,
            exact: appendix_b::exact(),
            bound: Some(appendix_b::bound),
        },
    ];
    let (mut rows, mut claims, mut panels) = (Vec::new(), Vec::new(), Vec::new());
    for case in &cases {
        let of_case = errors(case, &counts, most)?;
        claims.push(splits(case, most.min(16), counts[counts.len() - 1])?);
        claims.push(grows(case, &of_case, most));
        panels.push(panel(case, &of_case));
        rows.extend(of_case);
    }
    claims.extend(faster(&counts)?);
    folder.write_csv("convergence.csv", &rows)?;
    Figure::new(panels, 2).save(&folder.figures(), "convergence")?;
    Ok(claims)
}

/// For 1, 4, 16, … degrees of freedom and every number of samples.
fn errors(case: &Case, counts: &[usize], most: usize) -> Result<Vec<Row>, PaperError> {
    let mut rows = Vec::new();
    for &samples in counts {
        let mut worst = 0f64;
        for i in 0..most {
            let one = sampled(case.component, i..i + 1, samples);
            let integral = LoopIntegral::of(&one, &case.rule)?.value;
            worst = worst.max((integral - case.exact).abs());
        }
        for dof in std::iter::successors(Some(1), |dof| Some(4 * dof)).take_while(|&d| d <= most) {
            let whole = sampled(case.component, 0..dof, samples);
            let integral = LoopIntegral::of(&whole, &case.rule)?.value;
            rows.push(Row {
                rule: case.name,
                dof,
                samples,
                error: (integral - dof as f64 * case.exact).abs(),
                errors_added: dof as f64 * worst,
                bound: case.bound.map(|bound| dof as f64 * bound(samples as f64)),
            });
        }
    }
    Ok(rows)
}

/// The integral of a loop in several dimensions is the sum of those of its components.
fn splits(case: &Case, dof: usize, samples: usize) -> Result<Claim, PaperError> {
    let whole = LoopIntegral::of(&sampled(case.component, 0..dof, samples), &case.rule)?;
    let mut sum = 0.0;
    for i in 0..dof {
        sum += LoopIntegral::of(&sampled(case.component, i..i + 1, samples), &case.rule)?.value;
    }
    let off = (whole.value / sum - 1.0).abs();
    Ok(Claim::of_paper(
        ITEM.id,
        "section 2.4",
        format!(
            "the {} approximation splits additively over the degrees of freedom",
            case.name
        ),
        format!("{dof} of them together and one by one agree to {off:.0e}"),
        Judgement::of(off < 1e-12),
    ))
}

/// The error is at most that of the components added, and falls as theirs.
fn grows(case: &Case, rows: &[Row], most: usize) -> Claim {
    let of_most: Vec<(f64, f64)> = (rows.iter())
        .filter(|row| row.dof == rows.last().map_or(1, |last| last.dof))
        .map(|row| (row.samples as f64, row.errors_added))
        .collect();
    let rate = power_law(&of_most);
    let share = (rows.iter())
        .map(|row| row.error / row.errors_added)
        .fold(0.0, f64::max);
    let below = (rows.iter()).all(|row| row.bound.is_none_or(|bound| row.error <= bound));
    /// Rounding of sums.
    const MAX_ROUNDING_ERROR: f64 = 1e-9;
    /// β(r) of kinks.
    const ORDER: f64 = 1.5;
    let says = match case.bound {
        None => "the error is O(d N^-β(r)), here N^-1.5",
        Some(_) => "the error is at most Σ_i L_qi (TV(p_i) + #O_i ‖p_i‖∞)/N, O(d/N)",
    };
    Claim::of_paper(
        ITEM.id,
        "section 2.4",
        format!("{} rule: {says}", case.name),
        format!(
            "up to {most} degrees of freedom the error is at most {share:.2} of d times the largest of a component, \
             which goes as {}{}",
            trend_text("N", rate),
            match case.bound {
                Some(_) if below => "; below the bound at every N",
                Some(_) => "; above the bound",
                None => "",
            }
        ),
        // A bound holds or not, however fast the error falls.
        match (case.bound, rate) {
            (Some(_), _) => Judgement::of(share < 1.0 + MAX_ROUNDING_ERROR && below),
            (None, Some(rate)) => {
                Judgement::of(share < 1.0 + MAX_ROUNDING_ERROR && -rate > ORDER - 0.1)
            }
            (None, None) => Judgement::Unresolved,
        },
    )
}

/// Which rule converges faster on loops in H^r: on kinks, r < 3/2, and on a lacunary series, r < 1.
fn faster(counts: &[usize]) -> Result<[Claim; 2], PaperError> {
    let rate = |curve: &Curve, rule: Rule| -> Result<Option<f64>, PaperError> {
        let mut points = Vec::new();
        for &samples in counts {
            let mut ensemble = Ensemble::zeros(1, samples);
            let mut block = ensemble.block();
            for k in 0..samples {
                let (q, p) = curve.at(k, samples);
                (block.q.row_mut(0)[k], block.p.row_mut(0)[k]) = (q, p);
            }
            let integral = LoopIntegral::of(&ensemble, &rule)?.value;
            points.push((samples as f64, (integral - curve.exact()).abs()));
        }
        Ok(power_law(&points))
    };
    let both = |curve: &Curve| {
        Ok::<_, PaperError>([rate(curve, Rule::Pseudospectral)?, rate(curve, WHOLE)?])
    };
    let claim = |says: &str, rates: [Option<f64>; 2], holds: fn(f64, f64) -> bool| {
        let [spectral, differences] = rates;
        Claim::of_paper(
            ITEM.id,
            "section 2.4",
            says,
            format!(
                "pseudospectral {}, finite differences {}",
                trend_text("N", spectral),
                trend_text("N", differences)
            ),
            match (spectral, differences) {
                (Some(spectral), Some(differences)) => {
                    Judgement::of(holds(-spectral, -differences))
                }
                _ => Judgement::Unresolved,
            },
        )
    };
    Ok([
        claim(
            "for r > 1 the pseudospectral rule is asymptotically faster than first order, and than finite differences",
            both(&Curve::Bernoulli(DEGREE))?,
            |spectral, differences| spectral > 1.1 && spectral > differences + 0.1,
        ),
        claim(
            "at r = 1 both are first order",
            both(&Curve::Lacunary(1.0))?,
            |spectral, differences| {
                (spectral - 1.0).abs() < 0.15 && (differences - 1.0).abs() < 0.15
            },
        ),
    ])
}

fn panel(case: &Case, rows: &[Row]) -> Panel {
    let mut dofs: Vec<usize> = rows.iter().map(|row| row.dof).collect();
    dofs.sort_unstable();
    dofs.dedup();
    let mut drawn = Vec::new();
    for (k, &dof) in dofs.iter().enumerate() {
        let curve: Vec<(f64, f64)> = (rows.iter())
            .filter(|row| row.dof == dof)
            .map(|row| (row.samples as f64, row.error))
            .collect();
        drawn.push(series(
            &format!("d = {dof}"),
            curve.clone(),
            Style::LineAndPoints,
            k,
        ));
        if k + 1 == dofs.len() {
            let order = if case.bound.is_some() {
                -1.0
            } else {
                -(DEGREE as f64)
            };
            drawn.push(reference_slope(&curve, order, "N"));
        }
    }
    Panel {
        title: format!("{} rule", case.name),
        x: axis("samples Nₛ", Scale::Log2),
        y: axis("error of ∮ p dq", Scale::Log10),
        series: drawn,
        equal_aspect: false,
    }
}
