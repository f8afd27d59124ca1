//! The verdict of a Jacobian test, alone and compared with the verdict of the loops.

use serde::{Deserialize, Serialize};

use super::VerdictKind;
use crate::evidence::{MAX_BOUND_ON_DEFECT, MIN_DEFORMATION};
use crate::jacobian::{JacobianEvidence, JacobianMethod, TangentDefect};
use crate::signal::{SIGNIFICANT, UNEXPLAINED};

/// The answer of a Jacobian test alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum JacobianVerdict {
    /// No pair of tangent vectors has a defect, at the points where the map is differentiable. That
    /// says nothing about jumps.
    SymplecticAlmostEverywhere {
        /// Digits to which the form is conserved.
        digits: f64,
    },
    /// A pair of tangent vectors has a significant defect.
    NotSymplectic {
        /// The largest one.
        worst: TangentDefect,
    },
    /// The numbers do not decide.
    Undecided {
        /// Why.
        reason: InconclusiveReason,
    },
}

/// Why a Jacobian test does not decide.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "why")]
pub enum InconclusiveReason {
    /// The budget of evaluations left no point to measure at.
    NoPoints,
    /// Half the points or more have no derivative: jumps or kinks are everywhere.
    NoDerivative {
        /// Points without a derivative.
        points: usize,
        /// All points.
        of: usize,
    },
    /// The step deforms tangent vectors so little that every integrator would pass.
    LittleDeformation {
        /// Largest change of a component of a tangent vector, relative to the vector.
        deformation: f64,
    },
    /// Truncation, or noise of the map (single precision for example), leaves only a weak bound.
    WeakBound {
        /// The bound on the defect.
        bound: f64,
        /// Noise of one coordinate relative to its size on the loop.
        noise: f64,
    },
    /// A defect larger than its uncertainty, and not significant.
    Unexplained {
        /// The defect.
        worst: TangentDefect,
    },
}

/// How a Jacobian test and the verdict of the loops stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Agreement {
    /// Both say symplectic.
    Symplectic,
    /// Both say not symplectic.
    NotSymplectic,
    /// Loops break, and the map is not symplectic between the breaks either.
    NotSymplecticBetweenBreaks,
    /// Loops break, and the map is symplectic between the breaks. Both are right.
    BreaksAlone,
    /// The Jacobian has a defect that is not above the bound of the loops. Both are right.
    BelowBoundOfLoops {
        /// The bound.
        bound: f64,
    },
    /// The Jacobian has a defect that the loops do not show. The Jacobian is right.
    HiddenFromLoops,
    /// The loops have a defect that the Jacobian does not show. The loops are right.
    HiddenFromJacobian {
        /// Whether all pairs of unit vectors were tried.
        full: bool,
        /// Defects that the Jacobian would not show.
        bound: Option<f64>,
    },
    /// The loops do not decide, and the Jacobian has a significant defect.
    OnlyJacobianDecides,
    /// The loops do not decide, and the Jacobian has no defect.
    LoopsUndecided,
    /// The Jacobian test does not decide.
    JacobianUndecided,
}

/// A Jacobian test compared with the verdict of the loops; its text is one paragraph.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JacobianFinding {
    /// Step size of the test; `None` for a map without one.
    pub step_size: Option<f64>,
    /// Number of the loop on which its points are.
    #[serde(default, skip_serializing_if = "crate::jacobian::is_given")]
    pub loop_index: usize,
    /// How derivatives were computed.
    pub method: JacobianMethod,
    /// The answer of the test.
    pub verdict: JacobianVerdict,
    /// Whether it agrees with the loops, and why not.
    pub agreement: Agreement,
}

/// The answer of a Jacobian test alone.
pub fn judge_jacobian(evidence: &JacobianEvidence) -> JacobianVerdict {
    let undecided = |reason| JacobianVerdict::Undecided { reason };
    if evidence.points.is_empty() {
        return undecided(InconclusiveReason::NoPoints);
    }
    let no_derivative = undecided(InconclusiveReason::NoDerivative {
        points: evidence.not_differentiable,
        of: evidence.points.len(),
    });
    let (Some(worst), Some(bound)) = (evidence.worst, evidence.bound) else {
        return no_derivative;
    };
    let of_groups = evidence.bounds_of_groups.iter().flatten().copied();
    let bound = of_groups.fold(bound, f64::max);
    let exceeds = |times: f64| {
        worst.magnitude() > (evidence.method.least_defect()).max(times * worst.uncertainty)
    };
    if exceeds(SIGNIFICANT) {
        return JacobianVerdict::NotSymplectic { worst };
    }
    if 2 * evidence.not_differentiable >= evidence.points.len() {
        return no_derivative;
    }
    // A map without a step size approximates nothing: it is judged itself, however little it deforms.
    if evidence.step_size.is_some() && evidence.deformation < MIN_DEFORMATION {
        return undecided(InconclusiveReason::LittleDeformation {
            deformation: evidence.deformation,
        });
    }
    if exceeds(UNEXPLAINED) {
        return undecided(InconclusiveReason::Unexplained { worst });
    }
    // Not `bound > …`: a bound that is NaN is not valid.
    if !matches!(bound, 0.0..=MAX_BOUND_ON_DEFECT) {
        return undecided(InconclusiveReason::WeakBound {
            bound,
            noise: evidence.noise,
        });
    }
    JacobianVerdict::SymplecticAlmostEverywhere {
        digits: (-bound.max(f64::EPSILON).log10() * 10.0).floor() / 10.0,
    }
}

impl JacobianEvidence {
    /// The answer of the test alone; its `Display` is English.
    pub fn verdict(&self) -> JacobianVerdict {
        judge_jacobian(self)
    }
}

/// Compares a Jacobian test with the verdict of loop integrals of the same map, and its digits.
///
/// The loops may have been advanced by other step sizes; that of the test should be among them.
///
/// ```
/// use symplint::{Circle, Diagnostic, JacobianTest, PerSample, VerdictKind};
/// use symplint::verdict::{Agreement, compare_jacobian};
///
/// // Symplectic Euler on H = p²/2 + |q|: its force jumps.
/// let map = PerSample::new(1, |h, q, p| {
///     p[0] -= h * if q[0] < 0.0 { -1.0 } else { 1.0 };
///     q[0] += h * p[0];
/// });
/// let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
/// let loops = Diagnostic::halving(-1, -4).run(&map, &circle)?.verdict;
/// assert_eq!(loops.kind, VerdictKind::BrokenLoops);
/// let evidence = JacobianTest::default().run(&map, &circle, 0.5)?;
/// let finding = compare_jacobian(&evidence, loops.kind, loops.digits);
/// assert_eq!(finding.agreement, Agreement::BreaksAlone);
/// # Ok::<(), symplint::Error>(())
/// ```
pub fn compare_jacobian(
    evidence: &JacobianEvidence,
    kind: VerdictKind,
    digits: Option<f64>,
) -> JacobianFinding {
    let verdict = judge_jacobian(evidence);
    let agreement = match (kind, &verdict) {
        (_, JacobianVerdict::Undecided { .. }) => Agreement::JacobianUndecided,
        (VerdictKind::Undecided, JacobianVerdict::NotSymplectic { .. }) => {
            Agreement::OnlyJacobianDecides
        }
        (VerdictKind::Undecided, _) => Agreement::LoopsUndecided,
        (VerdictKind::Symplectic, JacobianVerdict::NotSymplectic { worst }) => {
            let bound = digits.map(|digits| 10f64.powf(-digits));
            match bound.filter(|&bound| worst.magnitude() <= bound) {
                Some(bound) => Agreement::BelowBoundOfLoops { bound },
                None => Agreement::HiddenFromLoops,
            }
        }
        (VerdictKind::Symplectic, _) => Agreement::Symplectic,
        (VerdictKind::NotSymplectic, JacobianVerdict::NotSymplectic { .. }) => {
            Agreement::NotSymplectic
        }
        (VerdictKind::NotSymplectic, _) => Agreement::HiddenFromJacobian {
            full: evidence.full,
            bound: evidence.bound,
        },
        (VerdictKind::BrokenLoops, JacobianVerdict::NotSymplectic { .. }) => {
            Agreement::NotSymplecticBetweenBreaks
        }
        (VerdictKind::BrokenLoops, _) => Agreement::BreaksAlone,
    };
    JacobianFinding {
        step_size: evidence.step_size,
        loop_index: evidence.loop_index,
        method: evidence.method,
        verdict,
        agreement,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jacobian::JacobianPoint;

    /// Evidence on one side of every threshold: symplectic, by a tangent map, at four points.
    fn evidence() -> JacobianEvidence {
        let worst = defect(1e-13, 1e-13);
        let point = JacobianPoint {
            s: worst.s,
            worst: Some(worst),
            bound: Some(2e-13),
        };
        JacobianEvidence {
            volume: None,
            blocks: None,
            step_size: Some(0.5),
            loop_index: 0,
            method: JacobianMethod::TangentMap,
            points: vec![point; 4],
            not_differentiable: 0,
            full: true,
            projected: false,
            worst: Some(worst),
            bound: Some(2e-13),
            bounds_of_groups: vec![Some(2e-13)],
            deformation: 1.0,
            noise: 1e-16,
            evaluations: 100,
        }
    }

    fn defect(signed: f64, uncertainty: f64) -> TangentDefect {
        TangentDefect {
            s: 0.25,
            signed,
            uncertainty,
            dofs: Some((1, 4)),
        }
    }

    fn of_defect(method: JacobianMethod, signed: f64, uncertainty: f64) -> JacobianEvidence {
        JacobianEvidence {
            volume: None,
            blocks: None,
            method,
            worst: Some(defect(signed, uncertainty)),
            bound: Some(signed.abs() + uncertainty),
            ..evidence()
        }
    }

    fn name(verdict: JacobianVerdict) -> &'static str {
        match verdict {
            JacobianVerdict::SymplecticAlmostEverywhere { .. } => "symplectic",
            JacobianVerdict::NotSymplectic { .. } => "not symplectic",
            JacobianVerdict::Undecided { reason } => match reason {
                InconclusiveReason::NoPoints => "no points",
                InconclusiveReason::NoDerivative { .. } => "no derivative",
                InconclusiveReason::LittleDeformation { .. } => "little deformation",
                InconclusiveReason::WeakBound { .. } => "weak bound",
                InconclusiveReason::Unexplained { .. } => "unexplained",
            },
        }
    }

    #[test]
    fn every_threshold_decides_between_its_two_sides() {
        let differences = JacobianMethod::CentralDifferences { rejected: None };
        let tangent = JacobianMethod::TangentMap;
        let mut cases = vec![("symplectic", evidence())];
        for (expected, method, signed, uncertainty) in [
            // Ten times the uncertainty.
            ("not symplectic", tangent, -1.01e-9, 1e-10),
            ("unexplained", tangent, 0.99e-9, 1e-10),
            // Three times.
            ("unexplained", tangent, -3.01e-9, 1e-9),
            ("symplectic", tangent, 2.99e-9, 1e-9),
            // The least defect of each method.
            ("not symplectic", tangent, 1.01e-12, 1e-15),
            ("symplectic", tangent, 0.99e-12, 1e-15),
            ("not symplectic", differences, 1.01e-10, 1e-15),
            ("symplectic", differences, 0.99e-10, 1e-15),
            // The weakest bound.
            ("weak bound", differences, 1e-8, 1e-6),
            ("symplectic", differences, 1e-8, 0.98e-6),
        ] {
            cases.push((expected, of_defect(method, signed, uncertainty)));
        }
        let without = |not_differentiable| JacobianEvidence {
            not_differentiable,
            ..evidence()
        };
        cases.push(("symplectic", without(1)));
        cases.push(("no derivative", without(2)));
        // A defect of the rest counts all the same.
        let few = JacobianEvidence {
            not_differentiable: 3,
            ..of_defect(tangent, 1e-3, 1e-9)
        };
        cases.push(("not symplectic", few));
        let nowhere = JacobianEvidence {
            worst: None,
            bound: None,
            ..without(4)
        };
        cases.push(("no derivative", nowhere));
        let no_points = JacobianEvidence {
            points: Vec::new(),
            ..evidence()
        };
        cases.push(("no points", no_points));
        for (expected, deformation) in [("symplectic", 0.201), ("little deformation", 0.199)] {
            let of_deformation = JacobianEvidence {
                deformation,
                ..evidence()
            };
            cases.push((expected, of_deformation));
        }
        for (expected, evidence) in cases {
            assert_eq!(name(evidence.verdict()), expected, "{evidence:?}");
        }
    }

    #[test]
    fn every_pair_of_verdicts_has_its_reason() {
        let of = |signed| of_defect(JacobianMethod::TangentMap, signed, 1e-15);
        let (symplectic, not) = (of(1e-13), of(-0.5));
        let noise = of_defect(JacobianMethod::TangentMap, 0.0, 1e-4);
        let hidden = Agreement::HiddenFromJacobian {
            full: true,
            bound: symplectic.bound,
        };
        let below = Agreement::BelowBoundOfLoops { bound: 1e-11 };
        use VerdictKind::{BrokenLoops, NotSymplectic, Symplectic, Undecided};
        let cases = [
            (Symplectic, &symplectic, Agreement::Symplectic, "agree."),
            (Symplectic, &not, Agreement::HiddenFromLoops, "symmetry"),
            (Symplectic, &of(5e-12), below, "do not contradict"),
            (
                Symplectic,
                &noise,
                Agreement::JacobianUndecided,
                "average it",
            ),
            (
                BrokenLoops,
                &symplectic,
                Agreement::BreaksAlone,
                "detect jumps",
            ),
            (
                BrokenLoops,
                &not,
                Agreement::NotSymplecticBetweenBreaks,
                "between (q[1], p[1]) and (q[4], p[4])",
            ),
            (NotSymplectic, &not, Agreement::NotSymplectic, "agree."),
            (NotSymplectic, &symplectic, hidden, "Other points"),
            (
                NotSymplectic,
                &noise,
                Agreement::JacobianUndecided,
                "1.0e-4",
            ),
            (Undecided, &symplectic, Agreement::LoopsUndecided, "jumps"),
            (Undecided, &not, Agreement::OnlyJacobianDecides, "probably"),
        ];
        for (kind, evidence, agreement, words) in cases {
            let digits = (kind == Symplectic).then_some(11.0);
            let finding = compare_jacobian(evidence, kind, digits);
            assert_eq!(finding.agreement, agreement, "{kind}: {finding}");
            assert!(finding.to_string().contains(words), "{kind}: {finding}");
        }
    }
}
