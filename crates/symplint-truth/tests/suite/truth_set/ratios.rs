//! True errors over stated ones, and their quantiles.

use std::collections::BTreeMap;

use symplint::breaks::Break;
use symplint::evidence::StepEvidence;
use symplint::{Diagnosis, VerdictKind};

use crate::truth_set::member::{Expected, Member, Truth};

/// Ratios by their quantity.
pub type Ratios = BTreeMap<String, Vec<f64>>;

/// All ratios of a member.
pub fn ratios(member: &Member, diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let mut found = integrals(&member.truth, diagnosis);
    found.extend(breaks(&member.truth, diagnosis));
    found.extend(order(&member.truth, diagnosis));
    found.extend(digits(&member.truth, diagnosis));
    found
}

/// Truths and results are known to one rounding, in units of the loop integral, and positions to one of s; errors below that count as
/// that much.
const ROUNDING: f64 = 0.5 * f64::EPSILON;

/// 0 for no error, infinite for an error where none is stated.
fn ratio(error: f64, stated: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / stated }
}

fn kind(truth: &Truth) -> &'static str {
    match truth.expected {
        Expected::Broken { .. } => ", broken loops",
        Expected::Tolerance { .. } => ", solver tolerance",
        _ => "",
    }
}

fn integrals(truth: &Truth, diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let Some(change) = &truth.change else {
        return Vec::new();
    };
    // Rounded maps have a rounded truth.
    let mut found = Vec::new();
    for of_loop in &diagnosis.evidence.loops {
        if of_loop.winds || (of_loop.index > 0 && !truth.of_all_loops) {
            continue;
        }
        for step in &of_loop.steps {
            // A map without a step size is called with 1.
            let h = step.step_size.unwrap_or(1.0);
            let Some(_) = step.defect.quadrature_error else {
                continue;
            };
            let known = change(h);
            if known.is_nan() {
                continue;
            }
            let stated = step.defect.uncertainty();
            let name = format!("{}{}", step.rule, kind(truth));
            let error = (step.defect.signed - known).abs();
            let of_change = ratio(error.max(ROUNDING), stated);
            found.push((format!("change, {name}"), of_change));
            if let (Some(initial), 0) = (truth.initial, of_loop.index) {
                let after = initial + known * initial.abs();
                let error = (step.advanced - after).abs() / initial.abs();
                let of_integral = ratio(error.max(ROUNDING), stated);
                found.push((format!("integral after the step, {name}"), of_integral));
            }
            if let (Some(closing), Expected::Broken { closed: Some(true) }) =
                (step.closing, truth.expected)
            {
                let closed = closing.closed;
                let name = format!("change once closed, {}", step.rule);
                found.push((
                    name,
                    ratio(closed.magnitude().max(ROUNDING), closed.uncertainty()),
                ));
            }
        }
    }
    found
}

/// Positions of the breaks that were found. Those that were missed are counted apart.
fn breaks(truth: &Truth, diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let name = format!("break position{}", kind(truth));
    (found_breaks(truth, diagnosis)
        .into_iter()
        .flatten()
        .flatten())
    .map(|(distance, uncertainty)| (name.clone(), ratio(distance.max(ROUNDING), uncertainty)))
    .collect()
}

/// How far each known break is from the found one nearest to it, and how well the position of that is said to be known. A break
/// that is nearest to no found one was missed. Nothing where the diagnosis did not close the loop.
pub fn found_breaks(truth: &Truth, diagnosis: &Diagnosis) -> Option<Vec<Option<(f64, f64)>>> {
    let (found, known) = given_breaks(diagnosis).zip(truth.breaks.as_ref())?;
    let apart = |a: f64, b: f64| ((a - b + 0.5).rem_euclid(1.0) - 0.5).abs();
    let mut nearest: Vec<Option<(f64, f64)>> = vec![None; known.len()];
    for at in &found {
        let distances = known.iter().map(|known| apart(at.s, known.s)).enumerate();
        let Some((k, distance)) = distances.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        if nearest[k].is_none_or(|(other, _)| distance < other) {
            nearest[k] = Some((distance, at.uncertainty));
        }
    }
    Some(nearest)
}

/// The step of the given loop with the largest step size.
fn largest_step(diagnosis: &Diagnosis) -> Option<&StepEvidence> {
    let given = diagnosis.evidence.loops.first()?;
    let largest = given
        .steps
        .iter()
        .map(|step| step.step_size.unwrap_or(0.0))
        .fold(0.0, f64::max);
    given
        .steps
        .iter()
        .find(|step| step.step_size == Some(largest))
}

/// Whether the diagnosis says that there may be more breaks than it found.
pub fn may_be_more(diagnosis: &Diagnosis) -> bool {
    largest_step(diagnosis).is_some_and(|step| step.flickering > 0)
}

/// The breaks of the given loop after the largest step, if it could be closed.
pub fn given_breaks(diagnosis: &Diagnosis) -> Option<Vec<Break>> {
    let step = largest_step(diagnosis)?;
    step.closing?;
    let of_step = (diagnosis.evidence.breaks.iter())
        .filter(|at| at.loop_index == 0 && at.step_size == step.step_size);
    Some(of_step.map(|at| at.found).collect())
}

fn order(truth: &Truth, diagnosis: &Diagnosis) -> Option<(String, f64)> {
    let [known] = truth.orders[..] else {
        return None;
    };
    diagnosis.verdict.order?;
    let fit = (diagnosis.fits().iter())
        .filter(|fit| fit.slope > 0.5)
        .min_by(|a, b| a.slope.total_cmp(&b.slope))?;
    let error = (fit.slope - known).abs();
    Some((
        "slope of a stated order".into(),
        ratio(error, fit.uncertainty),
    ))
}

/// The true defect over the bound that the digits state.
fn digits(truth: &Truth, diagnosis: &Diagnosis) -> Option<(String, f64)> {
    let change = truth.change.as_ref()?;
    let digits = diagnosis.verdict.digits?;
    let defect = (diagnosis.points().iter())
        .map(|at| match at.step_size.is_nan() {
            true => change(1.0).abs(),
            false => change(at.step_size).abs(),
        })
        .filter(|defect| defect.is_finite())
        .fold(0.0, f64::max);
    let known = diagnosis.verdict.kind == VerdictKind::Symplectic && defect > 0.0;
    known.then(|| {
        (
            "defect over the bound of the digits".into(),
            defect * 10f64.powf(digits),
        )
    })
}

/// The quantile of sorted numbers, by the nearest rank.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    let rank = (part * sorted.len() as f64).ceil() as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}
