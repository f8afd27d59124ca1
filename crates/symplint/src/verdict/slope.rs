//! The slope of a defect against the step size, whether it follows a law or not.

use super::order::{Datum, Fit, clear, known_data, local_slope, sign_of_steps};
use super::thresholds::{MAX_ERROR_OF_SLOPE, MAX_ORDER, MIN_TREND};
use crate::evidence::{Evidence, LoopEvidence, MIN_RANGE_OF_LAW};
use crate::jacobian::JacobianDecay;
use crate::signal::UNEXPLAINED;

/// The slope of log |E| over log h between the two smallest steps where the defect is clear of its uncertainty.
pub(super) fn smallest_steps_slope(evidence: &LoopEvidence) -> Option<f64> {
    match clear(&known_data(evidence))[..] {
        [fine, coarse, ..] => Some(local_slope(&fine, &coarse)),
        _ => None,
    }
}

/// The slope of the first loop that shows one, or of the Jacobian; `None` if it fits neither an order nor a constant.
pub(super) fn slope_of(evidence: &Evidence) -> Option<f64> {
    let contractible = || evidence.loops.iter().filter(|found| !found.winds);
    let mean = || contractible().find_map(mean_slope);
    let of_jacobian = || slope_of_jacobian(evidence.jacobian_decay?);
    let slope = (contractible().find_map(smallest_steps_slope))
        .or_else(|| mean().or_else(of_jacobian).map(|fit| fit.slope))?;
    (-MIN_TREND..=MAX_ORDER).contains(&slope).then_some(slope)
}

/// The slope between the smallest and the largest step whose defects are not explained by their uncertainty. These may be too few, or
/// too uncertain, for an order. The uncertainty is the largest distance from that line, errors included.
fn mean_slope(evidence: &LoopEvidence) -> Option<Fit> {
    let mut data = known_data(evidence);
    data.retain(|datum| datum.1.abs() > UNEXPLAINED * datum.2);
    let [first, .., last] = &data[..] else {
        return None;
    };
    if data.iter().any(|datum| datum.1 * first.1 < 0.0) {
        return None;
    }
    let slope = local_slope(first, last);
    let error = |datum: &Datum| datum.2 / datum.1.abs();
    let distance = |datum: &Datum| {
        let of_line = slope * (datum.0 / first.0).ln();
        ((datum.1 / first.1).ln() - of_line).abs() + error(datum) + error(first)
    };
    let distances = data[1..].iter().map(distance);
    let uncertainty = distances.fold(0.0, f64::max) / (last.0 / first.0).ln();
    (uncertainty <= MAX_ERROR_OF_SLOPE).then(|| {
        let sign = sign_of_steps(evidence);
        Fit {
            quantity: "defect",
            against: "step_size",
            loop_index: evidence.index,
            slope,
            uncertainty,
            constant: None,
            from: sign * first.0,
            to: sign * last.0,
        }
    })
}

/// The slope of the defect of the Jacobian between two step sizes.
pub(super) fn slope_of_jacobian(decay: JacobianDecay) -> Option<Fit> {
    let [to, from] = decay.step_sizes;
    let [large, small] = decay.defects;
    let range = (to / from).abs().ln();
    let error = large.uncertainty / large.magnitude() + small.uncertainty / small.magnitude();
    let uncertainty = error / range;
    (uncertainty <= MAX_ERROR_OF_SLOPE).then(|| Fit {
        quantity: "defect of the Jacobian",
        against: "step_size",
        loop_index: 0,
        slope: (large.magnitude() / small.magnitude()).ln() / range,
        uncertainty,
        constant: None,
        from,
        to,
    })
}

/// The law of a defect that is the same at all step sizes: the first of these laws or, without a law, the mean slope of the first loop
/// that shows one. If loops show none over a factor of four, the slope of the Jacobian.
pub(super) fn constant_defect(
    loops: &[LoopEvidence],
    fits: &[Fit],
    decay: Option<JacobianDecay>,
) -> Option<Fit> {
    let mut contractible = loops.iter().filter(|found| !found.winds);
    let is_wide = |law: &Fit| law.to.abs() >= MIN_RANGE_OF_LAW * law.from.abs();
    let of_loops = (fits.first().cloned()).or_else(|| contractible.find_map(mean_slope));
    (of_loops.filter(is_wide))
        .or_else(|| slope_of_jacobian(decay?).filter(is_wide))
        .filter(|law| law.whole() == Some(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::order::fit_order;
    use crate::verdict::order::tests::evidence;

    fn slope(loops: [LoopEvidence; 1]) -> Option<f64> {
        slope_of(&Evidence {
            loops: loops.into(),
            ..Evidence::default()
        })
    }

    #[test]
    fn defects_near_their_uncertainty_have_a_slope_and_no_law() {
        for (k, size, noise) in [(0, 1e-13, 2.2e-15), (1, 1e-13, 2.2e-15), (4, 1e-12, 5e-15)] {
            let loops = [evidence(|h| -size * (2.0 * h).powi(k), noise)];
            assert_eq!(fit_order(&loops[0]), None);
            let is_constant = constant_defect(&loops, &[], None).is_some();
            assert_eq!(is_constant, k == 0, "h^{k}");
            let slope = slope(loops).expect("a slope");
            assert!((slope - f64::from(k)).abs() < 0.2, "h^{k}: {slope}");
        }
        // Noise alone, and a sign that changes.
        assert_eq!(slope([evidence(|_| 0.0, 5e-15)]), None);
        assert_eq!(slope([evidence(|h| 1e-13 * (h - 0.1), 1e-15)]), None);
        // Values that go up and down around the same size are not the same.
        let wave = evidence(|h| 1e-13 * (2.0 + 1.8 * (4.0 * h.ln()).sin()), 5e-15);
        assert_eq!(constant_defect(&[wave], &[], None), None);
        // Over a factor of two, every smooth law is nearly constant.
        let mut narrow = evidence(|h| 1e-13 * (1.0 + 0.1 * h), 5e-15);
        narrow.steps.truncate(2);
        assert_eq!(constant_defect(&[narrow], &[], None), None);
    }
}
