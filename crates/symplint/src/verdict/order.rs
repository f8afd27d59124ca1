//! The order of a defect.

use serde::Serialize;

use super::thresholds::{
    CLEAR, FEWEST_POINTS, HIGHEST_ORDER, MISFIT, MOST_POINTS, MOST_UNCERTAIN, NARROWEST_RANGE,
    WHOLE,
};
use crate::evidence::LoopEvidence;

/// A power law |quantity| ~ against^slope over a range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// What was fitted.
    pub quantity: &'static str,
    /// Against what.
    pub against: &'static str,
    /// Which loop.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Exponent.
    pub slope: f64,
    /// How far off the exponent may be.
    pub uncertainty: f64,
    /// Smallest abscissa used.
    pub from: f64,
    /// Largest abscissa used.
    pub to: f64,
}

impl Fit {
    /// The order that the slope stands for: the whole number within 0.15 of it. `None` for other slopes, which
    /// are those of a range that is not asymptotic yet.
    pub fn whole(&self) -> Option<f64> {
        let whole = self.slope.round();
        ((self.slope - whole).abs() <= WHOLE).then_some(whole)
    }
}

/// Resolution of exponents.
const STEP: f64 = 0.01;

/// One point of the fit: |h|, the signed defect, its uncertainty.
type Datum = (f64, f64, f64);

/// Fits the defect's power of h at the smallest steps where it is clear of its uncertainty.
///
/// The law is E = h^k (a + b h + c h²), signed: a sign change of E, which bends the curve of |E|,
/// is part of it. With three points, or where no such law passes through them, the mean slope. `None`
/// with fewer than three points, over less than a factor of four, or where the slopes disagree.
pub(super) fn fit_order(evidence: &LoopEvidence) -> Option<Fit> {
    let data = &clear_data(evidence)[..];
    if data.len() < FEWEST_POINTS || data[data.len() - 1].0 < NARROWEST_RANGE * data[0].0 {
        return None;
    }
    let plain = || Some(plain_law(data)).filter(|(_, uncertainty)| *uncertainty <= MOST_UNCERTAIN);
    let (slope, uncertainty) = polynomial_law(data).or_else(plain)?;
    let is_negative = |h: f64| h < 0.0;
    let backwards = (evidence.steps.iter()).all(|step| step.step_size.is_some_and(is_negative));
    let sign = if backwards { -1.0 } else { 1.0 };
    Some(Fit {
        quantity: "defect",
        against: "step_size",
        loop_index: evidence.index,
        slope,
        uncertainty,
        from: sign * data[0].0,
        to: sign * data[data.len() - 1].0,
    })
}

/// The slope of log |E| over log h between the two smallest steps where the defect is clear of its uncertainty.
pub(super) fn smallest_steps_slope(evidence: &LoopEvidence) -> Option<f64> {
    match clear_data(evidence)[..] {
        [fine, coarse, ..] => Some(local_slope(&fine, &coarse)),
        _ => None,
    }
}

/// The defects at the smallest steps where it is clear of its uncertainty, the smallest first.
fn clear_data(evidence: &LoopEvidence) -> Vec<Datum> {
    let mut data: Vec<Datum> = (evidence.steps.iter())
        .filter_map(|step| {
            let defect = &step.defect;
            Some((step.step_size?.abs(), defect.signed, defect.uncertainty()))
        })
        // What is not known, or not above its uncertainty, is not a point of a law.
        .filter(|&(_, signed, uncertainty)| signed.abs() > uncertainty)
        .collect();
    data.sort_by(|a, b| a.0.total_cmp(&b.0));
    data.dedup_by(|a, b| a.0 == b.0);
    let clear = data.into_iter().skip_while(|d| d.1.abs() <= CLEAR * d.2);
    clear.take(MOST_POINTS).collect()
}

fn local_slope(a: &Datum, b: &Datum) -> f64 {
    (b.1 / a.1).abs().ln() / (b.0 / a.0).ln()
}

/// The exponent k of h^k (a + b h + c h²), and how far it can be off: a whole number if one fits,
/// as it does for every smooth map.
fn polynomial_law(data: &[Datum]) -> Option<(f64, f64)> {
    if data.len() < 4 {
        return None;
    }
    // Terms of higher order pass for a lower one with a vanishing leading term: the highest exponent
    // that fits is the true one.
    let fits = |&k: &f64| misfit(data, k) <= 1.0;
    let highest = exponents(0.0, HIGHEST_ORDER).rev().find(fits)?;
    if highest >= HIGHEST_ORDER {
        // Any exponent fits.
        return None;
    }
    let whole = Some((highest + STEP / 2.0).floor()).filter(fits);
    let slope = whole.or_else(|| {
        exponents(highest - 0.5, highest)
            .min_by(|&a, &b| misfit(data, a).total_cmp(&misfit(data, b)))
    })?;
    // Orders of smooth maps are whole: where none fits, the law leaves something out.
    let from_whole = match whole {
        Some(_) => 0.0,
        None => (slope - slope.round()).abs(),
    };
    Some((slope, (highest - slope).max(from_whole)))
}

/// The mean slope of log |E| over log h, and half the spread of the local slopes.
fn plain_law(data: &[Datum]) -> (f64, f64) {
    if data
        .windows(2)
        .any(|pair| pair[0].1.signum() != pair[1].1.signum())
    {
        return (f64::NAN, f64::INFINITY);
    }
    let (low, high) = (data.windows(2).map(|pair| local_slope(&pair[0], &pair[1])))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| {
            (l.min(s), h.max(s))
        });
    (
        local_slope(&data[0], &data[data.len() - 1]),
        (high - low) / 2.0,
    )
}

fn exponents(from: f64, to: f64) -> impl DoubleEndedIterator<Item = f64> {
    (0..=((to - from) / STEP).round() as usize).map(move |n| from + n as f64 * STEP)
}

/// How badly E/h^k is a polynomial of h of degree 2 (less with fewer points): the largest residual over
/// what it may be, 1 or less where the law holds.
fn misfit(data: &[Datum], exponent: f64) -> f64 {
    // In units of the largest step, so that nothing overflows.
    let unit = data[data.len() - 1].0;
    let x: Vec<f64> = data.iter().map(|d| d.0 / unit).collect();
    let reduced: Vec<f64> = data
        .iter()
        .zip(&x)
        .map(|(d, x)| d.1 / x.powf(exponent))
        .collect();
    let noise: Vec<f64> = data
        .iter()
        .zip(&x)
        .map(|(d, x)| d.2 / x.powf(exponent))
        .collect();
    let allowed: Vec<f64> = (noise.iter().enumerate())
        .map(|(i, n)| MISFIT * nearby(&reduced, i) + 3.0 * n)
        .collect();
    // One point more than the terms and the exponent together.
    let terms = (data.len() - 2).min(3);
    let fitted = polynomial(&x, &reduced, &allowed, terms);
    (reduced.iter().zip(&fitted).zip(&allowed))
        .map(|((r, f), a)| (r - f).abs() / a)
        .fold(0.0, f64::max)
}

/// Median size of the three values round `i`: their scale, even where one is near a sign change.
fn nearby(values: &[f64], i: usize) -> f64 {
    let from = i.saturating_sub(1).min(values.len().saturating_sub(3));
    let mut sizes: Vec<f64> = (values.iter().skip(from).take(3))
        .map(|v| v.abs())
        .collect();
    sizes.sort_by(f64::total_cmp);
    sizes[sizes.len() / 2]
}

/// Weighted least squares by orthogonal polynomials: the fitted values at `x`.
fn polynomial(x: &[f64], y: &[f64], errors: &[f64], terms: usize) -> Vec<f64> {
    let weights: Vec<f64> = errors.iter().map(|e| 1.0 / (e * e)).collect();
    let dot = |a: &[f64], b: &[f64]| -> f64 {
        (a.iter().zip(b).zip(&weights))
            .map(|((a, b), w)| a * b * w)
            .sum()
    };
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut fitted = vec![0.0; x.len()];
    for power in 0..terms {
        let mut column: Vec<f64> = x.iter().map(|x| x.powi(power as i32)).collect();
        for other in &basis {
            let share = dot(&column, other) / dot(other, other);
            column
                .iter_mut()
                .zip(other)
                .for_each(|(c, o)| *c -= share * o);
        }
        let share = dot(y, &column) / dot(&column, &column);
        fitted
            .iter_mut()
            .zip(&column)
            .for_each(|(f, c)| *f += share * c);
        basis.push(column);
    }
    fitted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::{LoopKind, StepEvidence};
    use crate::rules::Defect;

    fn evidence(law: impl Fn(f64) -> f64, noise: f64) -> LoopEvidence {
        let mut evidence = LoopEvidence::new(0, LoopKind::Given);
        evidence.steps = (1..=10)
            .map(|m| {
                let h = 0.5f64.powi(m);
                // A noise that is the same in every run.
                let wobble = noise * (f64::from(m) * 2.7).sin();
                StepEvidence {
                    step_size: Some(h),
                    defect: Defect {
                        signed: law(h) + wobble,
                        quadrature_error: Some(noise),
                        roundoff: 0.0,
                    },
                    ..StepEvidence::default()
                }
            })
            .collect();
        evidence
    }

    fn order(law: impl Fn(f64) -> f64) -> f64 {
        let fit = fit_order(&evidence(law, 2e-16)).expect("a law");
        fit.whole().expect("a whole one")
    }

    #[test]
    fn pure_powers() {
        for k in 0..=8 {
            assert_eq!(order(|h| 0.3 * h.powi(k)), f64::from(k));
            assert_eq!(order(|h| -20.0 * h.powi(k)), f64::from(k));
        }
    }

    #[test]
    fn higher_terms_and_sign_changes_do_not_bend_the_order() {
        assert_eq!(order(|h| h.powi(3) * (1.0 - 30.0 * h)), 3.0);
        assert_eq!(order(|h| h.powi(3) * (1.0 - 300.0 * h)), 3.0);
        assert_eq!(order(|h| h.powi(2) * (0.1 + 5.0 * h - 40.0 * h * h)), 2.0);
        assert_eq!(order(|h| (h.powi(3) * 0.2).sin() + h.powi(4)), 3.0);
    }

    #[test]
    fn noise_leaves_the_order_alone() {
        for noise in [1e-12, 1e-9, 1e-7] {
            let fit = fit_order(&evidence(|h| 0.1 * h.powi(3), noise)).expect("a law");
            assert_eq!(fit.whole(), Some(3.0), "noise {noise:e}: {fit:?}");
        }
    }

    #[test]
    fn broken_powers_are_told_as_they_are() {
        let fit = fit_order(&evidence(|h| h.powf(1.5), 1e-15)).expect("a law");
        assert!((fit.slope - 1.5).abs() < 0.1, "{fit:?}");
    }

    #[test]
    fn noise_alone_has_no_order() {
        assert_eq!(fit_order(&evidence(|_| 0.0, 1e-14)), None);
    }

    #[test]
    fn defects_that_are_not_known_are_no_points_of_a_law() {
        // Of ten points three are known: any three lie on a law of some order.
        let mut found = evidence(|_| -1.0, 1e-12);
        for step in &mut found.steps[..7] {
            step.defect.quadrature_error = None;
        }
        let order = fit_order(&found).and_then(|fit| fit.whole());
        assert!(order.is_none_or(|order| order == 0.0), "{order:?}");
    }
}
