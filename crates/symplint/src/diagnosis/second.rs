//! The Jacobian's opinion beside that of the loops.

use super::probe::Subject;
use crate::jacobian::{JacobianEvidence, JacobianTest};
use crate::verdict::{JacobianVerdict, Verdict, VerdictKind, compare_jacobian};

/// Degrees of freedom from which fewer points and pairs have to do.
const MANY: usize = 256;

/// Asks the Jacobian of one step, adds what it says to the evidence, and takes back a verdict
/// `symplectic` that it refutes.
pub(super) fn opinion(
    subject: &Subject<'_>,
    h: f64,
    verdict: &mut Verdict,
) -> Option<JacobianEvidence> {
    let all = JacobianTest::default();
    let test = if subject.phase_loop.dof() < MANY {
        all
    } else {
        JacobianTest {
            points: 2,
            pairs: 4,
            ..all
        }
    };
    let evidence = match test.run_with(subject.evaluator, subject.phase_loop, h) {
        Ok(evidence) => evidence,
        // It displaces states off the loop, where the map need not be defined.
        Err(error) => {
            let line = format!("The Jacobian test could not be made: {error}.");
            verdict.evidence.push(line);
            return None;
        }
    };
    let finding = compare_jacobian(&evidence, verdict.kind, verdict.digits);
    verdict.evidence.push(finding.to_string());
    let refuted = matches!(finding.verdict, JacobianVerdict::NotSymplectic { .. });
    if verdict.kind == VerdictKind::Symplectic && refuted {
        *verdict = Verdict {
            kind: VerdictKind::Undecided,
            digits: None,
            summary: "The loops are conserved, but the Jacobian of a step is not symplectic."
                .into(),
            advice: vec![
                "Take other loops: one that is off the symmetries of the system, and a larger one."
                    .into(),
            ],
            ..verdict.clone()
        };
    }
    Some(evidence)
}

#[cfg(test)]
mod tests {
    use crate::diagnosis::Diagnostic;
    use crate::loops::Circle;
    use crate::map::PerSample;
    use crate::verdict::VerdictKind;

    #[test]
    fn a_defect_that_a_symmetric_loop_hides_is_seen() {
        // It stretches areas by 1 + h q, which is 1 on average over a circle round q = 0.
        let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| p[0] *= 1.0 + h * q[0]);
        let circle = Circle::new(vec![0.0], vec![0.3], 1.0).unwrap();
        let verdict = |jacobian| {
            let diagnostic = Diagnostic {
                loops: 1,
                jacobian,
                ..Diagnostic::default()
            };
            diagnostic.run(&map, &circle, &|_| {}).unwrap().verdict
        };
        assert_eq!(verdict(false).kind, VerdictKind::Symplectic);
        assert_eq!(verdict(true).kind, VerdictKind::Undecided);
    }
}
