//! The order of a defect.

use serde::Serialize;

use super::thresholds::{
    MAX_DISTANCE_TO_WHOLE, MAX_ERROR_OF_SLOPE, MAX_ORDER, MAX_POINTS, MAX_RELATIVE_MISFIT,
    MIN_DEFECT_OVER_UNCERTAINTY, MIN_TREND,
};
use crate::evidence::{LoopEvidence, MIN_RANGE_OF_LAW, MIN_STEP_SIZES_OF_LAW, StepEvidence};
use crate::signal::NEGLIGIBLE;

/// A power law |quantity − constant| ~ against^slope over a range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// The fit.
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
    /// The part of the quantity that does not depend on the step size, if it is needed to fit the law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub constant: Option<f64>,
    /// Smallest abscissa used.
    pub from: f64,
    /// Largest abscissa used.
    pub to: f64,
}

impl Fit {
    /// The order that the slope stands for: the whole number within 0.15 of it, and of all local slopes of which it is the mean.
    /// `None` for other slopes: the range is not asymptotic.
    pub fn whole(&self) -> Option<f64> {
        let whole = self.slope.round();
        let distance = (self.slope - whole).abs();
        (distance == 0.0 || distance + self.uncertainty <= MAX_DISTANCE_TO_WHOLE).then_some(whole)
    }
}

impl Fit {
    /// The leading terms of the law at a step size, from the defect at the smallest one of the fit.
    pub(super) fn at(&self, loops: &[LoopEvidence], h: f64) -> Option<f64> {
        let found = loops.iter().find(|found| found.index == self.loop_index)?;
        let is_first = |step: &&StepEvidence| step.step_size.map(f64::abs) == Some(self.from.abs());
        let first = found.steps.iter().find(is_first)?.defect.signed;
        let constant = self.constant.unwrap_or(0.0);
        Some(constant + (first - constant) * (h / self.from).abs().powf(self.slope))
    }
}

/// Resolution of exponents.
const EXPONENT_STEP: f64 = 0.01;

/// One point of the fit: |h|, the signed defect, its uncertainty.
pub(super) type Datum = (f64, f64, f64);

/// Fits the defect's power of h at the smallest steps where the defect is well above its uncertainty.
///
/// The law is E = h^k (a + b h + c h²), signed: a sign change of E, which bends the curve of |E|, is part of the law. k is a
/// whole number. With three points, or if no such law fits, the fit is the mean slope.
///
/// A constant part cancels in the differences between neighbouring step sizes. They have to follow the same law; if they
/// follow one and the defects do not, the constant is a term of the law. `None` with fewer than three points, over less than
/// a factor of four, if the slopes disagree, or if defects and differences follow different laws.
pub(super) fn fit_order(evidence: &LoopEvidence) -> Option<Fit> {
    let known = known_data(evidence);
    let data = &clear(&known)[..];
    let wide = |data: &[Datum]| {
        data.len() >= MIN_STEP_SIZES_OF_LAW
            && data[data.len() - 1].0 >= MIN_RANGE_OF_LAW * data[0].0
    };
    let changes = differences(&known);
    // At smaller steps, but for one, the constant alone is seen: no local slope differs from 0.
    let is_seen =
        |(change, known): (&Datum, &Datum)| change.1.abs() > MAX_DISTANCE_TO_WHOLE * known.1.abs();
    let seen = changes.iter().zip(&known).position(is_seen);
    let changes = &changes[seen.unwrap_or(changes.len()).saturating_sub(1)..];
    let changes = &clear(changes)[..];
    let of_changes = wide(changes).then(|| whole_law(changes)).flatten();
    let is_same = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs() <= MAX_DISTANCE_TO_WHOLE;
    let hidden =
        || hidden_law(data).filter(|law| of_changes.is_none_or(|other| is_same(*law, other)));
    let of_defects = wide(data)
        .then(|| whole_law(data).or_else(hidden).or_else(|| plain_law(data)))
        .flatten();
    let sign = sign_of_steps(evidence);
    let fit = |(slope, uncertainty): (f64, f64), constant, data: &[Datum]| Fit {
        quantity: "defect",
        against: "step_size",
        loop_index: evidence.index,
        slope,
        uncertainty,
        constant,
        from: sign * data[0].0,
        to: sign * data[data.len() - 1].0,
    };
    let with_constant = |law: (f64, f64)| {
        // The defects between which the changes are.
        let first = known.iter().position(|known| known.0 == changes[0].0)?;
        let data = &known[first..=first + changes.len()];
        constant(data, law.0).map(|constant| fit(law, Some(constant), data))
    };
    match (of_defects, of_changes) {
        (Some(law), None) => Some(fit(law, None, data)),
        (Some(law), Some(other)) if is_same(law, other) => Some(fit(law, None, data)),
        (Some(law), Some(other)) if law.0 <= MIN_TREND => {
            with_constant(other).or_else(|| Some(fit(law, None, data)))
        }
        // No order fits both.
        (Some(law), Some(_)) if law.0.fract() == 0.0 => None,
        (_, Some(law)) => with_constant(law),
        (None, None) => None,
    }
}

/// −1 for loops that all steps take backwards.
pub(super) fn sign_of_steps(evidence: &LoopEvidence) -> f64 {
    let is_negative = |h: f64| h < 0.0;
    match (evidence.steps.iter()).all(|step| step.step_size.is_some_and(is_negative)) {
        true => -1.0,
        false => 1.0,
    }
}

/// Whether the slopes of the defects are of an order at large steps and move away from it as the steps shrink: a term of lower order
/// takes over.
pub(super) fn leaves(evidence: &LoopEvidence, order: f64) -> bool {
    let data = clear(&known_data(evidence));
    let slopes: Vec<f64> = (data.windows(2))
        .map(|pair| local_slope(&pair[0], &pair[1]))
        .collect();
    let is_other = |slope: &f64| (slope - order).abs() > MAX_DISTANCE_TO_WHOLE;
    let [fine, .., coarse] = &slopes[..] else {
        return false;
    };
    is_other(fine) && !is_other(coarse) && departs(&data, order)
}

/// The defects with a known uncertainty, the smallest step first.
pub(super) fn known_data(evidence: &LoopEvidence) -> Vec<Datum> {
    let mut data: Vec<Datum> = (evidence.steps.iter())
        .filter_map(|step| {
            let defect = &step.defect;
            Some((step.step_size?.abs(), defect.signed, defect.uncertainty()))
        })
        .filter(|(_, signed, uncertainty)| signed.is_finite() && uncertainty.is_finite())
        .collect();
    data.sort_by(|a, b| a.0.total_cmp(&b.0));
    data.dedup_by(|a, b| a.0 == b.0);
    data
}

/// The data of the smallest steps from the first one on that is clear of its uncertainty.
pub(super) fn clear(known: &[Datum]) -> Vec<Datum> {
    // A value that is not above its uncertainty is not a point of a law.
    let above = known.iter().filter(|datum| datum.1.abs() > datum.2);
    let clear = above.skip_while(|datum| datum.1.abs() <= MIN_DEFECT_OVER_UNCERTAINTY * datum.2);
    clear.take(MAX_POINTS).copied().collect()
}

/// The differences of the defects at neighbouring step sizes, each with the smaller one; none if the step sizes are not a
/// geometric sequence. Of Σ c_k h^k they are Σ c_k (r^k − 1) h^k: the constant is gone, and the order is the same.
fn differences(known: &[Datum]) -> Vec<Datum> {
    let ratios = || known.windows(2).map(|pair| pair[1].0 / pair[0].0);
    let Some(first) = ratios().next() else {
        return Vec::new();
    };
    // Step sizes are often rounded to a few digits.
    if ratios().any(|ratio| (ratio / first - 1.0).abs() > NEGLIGIBLE) {
        return Vec::new();
    }
    let pairs = known.windows(2);
    pairs
        .map(|pair| (pair[0].0, pair[1].1 - pair[0].1, pair[0].2 + pair[1].2))
        .collect()
}

pub(super) fn local_slope(a: &Datum, b: &Datum) -> f64 {
    (b.1 / a.1).abs().ln() / (b.0 / a.0).ln()
}

/// The smallest and the largest local slope between neighbours.
fn local_slopes(data: &[Datum]) -> (f64, f64) {
    (data.windows(2).map(|pair| local_slope(&pair[0], &pair[1])))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| {
            (l.min(s), h.max(s))
        })
}

/// The highest exponent of h^k (a + b h + c h²) that fits, and the largest whole number not above it. `None` if that number does not
/// fit; it fits for every smooth map.
fn highest_exponent(data: &[Datum]) -> Option<(f64, f64)> {
    if data.len() < 4 {
        return None;
    }
    // Terms of higher order pass for a lower one with a vanishing leading term: the highest exponent
    // that fits is the true one.
    let fits = |&k: &f64| misfit(data, k, &[0, 1, 2]) <= 1.0;
    let highest = exponents(0.0, MAX_ORDER).rev().find(fits)?;
    if highest >= MAX_ORDER {
        // Any exponent fits.
        return None;
    }
    let whole = Some((highest + EXPONENT_STEP / 2.0).floor()).filter(fits)?;
    Some((highest, whole))
}

/// The exponent k of h^k (a + b h + c h²), and how far it can be off: a whole number within the local slopes.
fn whole_law(data: &[Datum]) -> Option<(f64, f64)> {
    let (highest, whole) = highest_exponent(data)?;
    let (low, high) = local_slopes(data);
    let within = (low - MAX_DISTANCE_TO_WHOLE..=high + MAX_DISTANCE_TO_WHOLE).contains(&whole);
    let uncertainty = highest - whole;
    (within && uncertainty <= MAX_ERROR_OF_SLOPE).then_some((whole, uncertainty))
}

/// The exponent of h^k (a + b h) if no local slope equals k: the second term is larger at all steps, or has the other sign. Three terms,
/// or fewer points, would fit defects without an order, too.
fn hidden_law(data: &[Datum]) -> Option<(f64, f64)> {
    if data.len() < MAX_POINTS {
        return None;
    }
    let (highest, whole) = highest_exponent(data)?;
    let fits = |&k: &f64| misfit(data, k, &[0, 1]) <= 1.0;
    let highest = exponents(whole, highest).rev().find(fits)?;
    let uncertainty = highest - whole;
    (fits(&whole) && uncertainty <= MAX_DISTANCE_TO_WHOLE).then_some((whole, uncertainty))
}

/// The constant e of E = e + h^k (a + b h), if no power of h below k takes its place and two neighbouring local slopes of
/// |E| are k.
fn constant(data: &[Datum], order: f64) -> Option<f64> {
    let slopes = data.windows(2).map(|pair| local_slope(&pair[0], &pair[1]));
    let near: Vec<bool> = slopes
        .map(|s| (s - order).abs() <= MAX_DISTANCE_TO_WHOLE)
        .collect();
    let fits = |lower: i32| misfit(data, order, &[lower - order as i32, 0, 1]) <= 1.0;
    let is_known =
        near.windows(2).any(|pair| pair[0] && pair[1]) && fits(0) && !(1..order as i32).any(fits);
    // At the smallest step the rest is smallest.
    let [first, second, ..] = data else {
        return None;
    };
    let growth = (second.0 / first.0).powf(order) - 1.0;
    is_known.then(|| first.1 - (second.1 - first.1) / growth)
}

/// The mean slope of log |E| over log h, and how far local slopes are from it.
fn plain_law(data: &[Datum]) -> Option<(f64, f64)> {
    if (data.windows(2)).any(|pair| pair[0].1.signum() != pair[1].1.signum()) {
        return None;
    }
    let (low, high) = local_slopes(data);
    let mean = local_slope(&data[0], &data[data.len() - 1]);
    let uncertainty = (high - mean).max(mean - low);
    // A term of lower order takes over at steps that were not tried.
    let least = match departs(data, mean.round()) {
        true => MAX_ERROR_OF_SLOPE,
        false => 0.0,
    };
    (uncertainty <= MAX_ERROR_OF_SLOPE).then_some((mean, uncertainty.max(least)))
}

/// Whether the three local slopes of the smallest steps move away from an order as the steps shrink, by more than the
/// uncertainty of the defects. Those of E = h^k (1 + b h + c h²) do so between two neighbouring pairs at most.
fn departs(data: &[Datum], order: f64) -> bool {
    let [first, second, third, fourth, ..] = data else {
        return false;
    };
    let distance = |a, b| (local_slope(a, b) - order).abs();
    let [fine, middle, coarse] = [
        distance(first, second),
        distance(second, third),
        distance(third, fourth),
    ];
    let noise = (first.2 / first.1.abs() + second.2 / second.1.abs()) / (second.0 / first.0).ln();
    fine > middle + noise && middle > coarse
}

fn exponents(from: f64, to: f64) -> impl DoubleEndedIterator<Item = f64> {
    (0..=((to - from) / EXPONENT_STEP).round() as usize)
        .map(move |n| from + n as f64 * EXPONENT_STEP)
}

/// A number for each point of a fit. There are at most [`MAX_POINTS`] + 1: those between which as many differences are. Slots without a
/// point have the weight 0.
type Values = [f64; MAX_POINTS + 1];

/// How badly E/h^k is a sum of these powers of h (fewer with few points): the largest residual over
/// what it may be, 1 or less if the law holds.
fn misfit(data: &[Datum], exponent: f64, powers: &[i32]) -> f64 {
    // In units of the largest step, so that nothing overflows.
    let unit = data[data.len() - 1].0;
    let mut x: Values = [1.0; MAX_POINTS + 1];
    let [mut powers_of_x, mut reduced, mut allowed, mut weights] = [Values::default(); 4];
    for (i, &(h, defect, _)) in data.iter().enumerate() {
        x[i] = h / unit;
        powers_of_x[i] = x[i].powf(exponent);
        reduced[i] = defect / powers_of_x[i];
    }
    for (i, datum) in data.iter().enumerate() {
        let scale = nearby(&reduced[..data.len()], i);
        allowed[i] = MAX_RELATIVE_MISFIT * scale + 3.0 * (datum.2 / powers_of_x[i]);
        weights[i] = 1.0 / (allowed[i] * allowed[i]);
    }
    // One point more than the terms and the exponent together.
    let powers = &powers[..(data.len() - 2).min(powers.len())];
    let fitted = combination(&x, &reduced, &weights, powers);
    (reduced.iter().zip(&fitted).zip(&allowed))
        .take(data.len())
        .map(|((r, f), a)| (r - f).abs() / a)
        .fold(0.0, f64::max)
}

/// Median size of the three values round `i`: their scale, even where one is near a sign change.
fn nearby(values: &[f64], i: usize) -> f64 {
    let from = i.saturating_sub(1).min(values.len().saturating_sub(3));
    let around = &values[from..(from + 3).min(values.len())];
    let mut sizes = [f64::INFINITY; 3];
    for (size, value) in sizes.iter_mut().zip(around) {
        *size = value.abs();
    }
    sizes.sort_by(f64::total_cmp);
    sizes[around.len() / 2]
}

/// Weighted least squares by orthogonal combinations of these powers of `x`, three at most: the fitted values.
fn combination(x: &Values, y: &Values, weights: &Values, powers: &[i32]) -> Values {
    let dot = |a: &Values, b: &Values| -> f64 {
        (a.iter().zip(b).zip(weights))
            .map(|((a, b), w)| a * b * w)
            .sum()
    };
    let add_multiple = |sum: &mut Values, factor: f64, column: &Values| {
        (sum.iter_mut().zip(column)).for_each(|(sum, value)| *sum += factor * value);
    };
    let mut basis = [(Values::default(), 0.0); 3];
    let mut fitted = Values::default();
    for (n, &power) in powers.iter().enumerate() {
        let mut column = x.map(|x| x.powi(power));
        for (other, square) in &basis[..n] {
            let share = dot(&column, other) / square;
            add_multiple(&mut column, -share, other);
        }
        let square = dot(&column, &column);
        add_multiple(&mut fitted, dot(y, &column) / square, &column);
        basis[n] = (column, square);
    }
    fitted
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::evidence::{LoopKind, StepEvidence};
    use crate::rules::Defect;

    pub fn evidence(law: impl Fn(f64) -> f64, noise: f64) -> LoopEvidence {
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
    fn a_leading_term_that_is_smaller_at_all_steps_is_the_order() {
        // As on loops near a symmetry of the system. The second one changes its sign between the smallest steps.
        assert_eq!(order(|h| h.powi(4) + 4e-4 * h.powi(3)), 3.0);
        assert_eq!(order(|h| h.powi(4) - 2.5e-3 * h.powi(3)), 3.0);
        // Too small to be told from another law.
        let fit = fit_order(&evidence(|h| h.powi(4) + 1e-5 * h.powi(3), 1e-16)).expect("a law");
        assert_ne!(fit.whole(), Some(3.0), "{fit:?}");
    }

    #[test]
    fn few_points_hide_no_order() {
        // Four points fit h^0 (a + b h), and h^2 (a + b h).
        for law in [|h: f64| h + 0.1 * h.sqrt(), |h: f64| h.powi(3) - 6e-3 * h] {
            let mut found = evidence(law, 2e-16);
            found.steps.truncate(4);
            let whole = fit_order(&found).and_then(|fit| fit.whole());
            assert_eq!(whole, None);
        }
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
    fn slopes_that_leave_an_order_as_steps_shrink_are_not_of_it() {
        // The random loop of `examples/fput.toml` with Runge–Kutta 4, whose Jacobian has a defect of order 5.
        let defects = [
            -0.12096678487669076,
            -0.0029782795078520706,
            -5.097308059977779e-05,
            -8.202612100966769e-07,
            -1.3121370081741036e-08,
            -2.129039606348587e-10,
            -3.5671070761349597e-12,
        ];
        let law = |h: f64| match 1.0 - h.log2() {
            m if m < 8.5 => defects[m as usize - 2],
            _ => f64::NAN,
        };
        let fit = fit_order(&evidence(law, 1e-15)).expect("a slope");
        assert_eq!(fit.whole(), None, "{fit:?}");
    }

    #[test]
    fn a_loop_leaves_an_order_that_a_lower_one_takes_over_from() {
        let leaves_4 = |law: fn(f64) -> f64| leaves(&evidence(law, 1e-10), 4.0);
        // A small term of order 3, of the other sign; below 2^-6 there is noise.
        assert!(leaves_4(|h| h.powi(4) - 1e-2 * h.powi(3)));
        assert!(!leaves_4(|h| h.powi(4)));
        assert!(!leaves_4(|h| h.powi(4) + 3.0 * h.powi(5)));
        // Of order 3, with a term of order 4 that is larger at large steps and does not hide it.
        assert!(!leaves(
            &evidence(|h| h.powi(3) - 4.0 * h.powi(4), 1e-16),
            3.0
        ));
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
