//! The Jacobian test beside the verdict of the loops: whether they agree, and why they need not.

use serde::Serialize;

use super::report::{Doubt, JacobianReport, JacobianVerdict};
use crate::verdict::{Verdict, VerdictKind};

/// How two opinions stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// Both say the same.
    Agree,
    /// They differ, and both can be right.
    Differ,
    /// One of them does not decide.
    Open,
}

/// What the Jacobian test adds to the verdict of the loops.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SecondOpinion {
    /// Whether the two agree.
    pub agreement: Agreement,
    /// In words, with the reason where they differ.
    pub text: String,
}

impl JacobianReport {
    /// Compares with the verdict of loop integrals of the same map.
    ///
    /// The loops may have seen other step sizes; those of the test should be among them.
    ///
    /// ```
    /// use symplint::{Agreement, Circle, Diagnostic, JacobianTest, PerSample, VerdictKind};
    ///
    /// // Symplectic Euler on H = p²/2 + |q|: its force jumps.
    /// let map = PerSample::new(1, |h, q, p| {
    ///     p[0] -= h * if q[0] < 0.0 { -1.0 } else { 1.0 };
    ///     q[0] += h * p[0];
    /// });
    /// let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
    /// let loops = Diagnostic::halving(-1, -4).run(&map, &circle, &|_| {})?.verdict;
    /// assert_eq!(loops.kind, VerdictKind::BrokenLoops);
    /// let second = JacobianTest::default().run(&map, &circle, 0.5)?.compare(&loops);
    /// assert_eq!(second.agreement, Agreement::Differ);
    /// assert!(second.text.contains("almost everywhere"));
    /// # Ok::<(), symplint::Error>(())
    /// ```
    pub fn compare(&self, loops: &Verdict) -> SecondOpinion {
        let jacobian = format!(
            "At h = {:?} the Jacobian is {} ({}).",
            self.step_size, self.verdict, self.method
        );
        let (agreement, reason) = match (loops.kind, &self.verdict) {
            (_, JacobianVerdict::CannotTell { doubt }) => {
                return SecondOpinion {
                    agreement: Agreement::Open,
                    text: format!(
                        "At h = {:?} the Jacobian test is no second opinion ({}): {doubt}.{}",
                        self.step_size,
                        self.method,
                        no_opinion(doubt)
                    ),
                };
            }
            (VerdictKind::Undecided, JacobianVerdict::NotSymplectic { .. }) => (
                Agreement::Open,
                "The loops do not decide; a defect of the Jacobian beyond doubt is proof that the map \
                 is not symplectic."
                    .to_owned(),
            ),
            (VerdictKind::Undecided, _) => (
                Agreement::Open,
                "The loops do not decide, and the Jacobian does not see jumps: follow the advice of \
                 the loops' verdict."
                    .to_owned(),
            ),
            (VerdictKind::Symplectic, JacobianVerdict::NotSymplectic { worst }) => {
                self.hidden_from_loops(loops, worst.magnitude())
            }
            (VerdictKind::Symplectic, _) => (
                Agreement::Agree,
                "Loops and Jacobian agree: symplectic.".to_owned(),
            ),
            (VerdictKind::NotSymplectic, JacobianVerdict::NotSymplectic { .. }) => (
                Agreement::Agree,
                "Loops and Jacobian agree: not symplectic.".to_owned(),
            ),
            (VerdictKind::BrokenLoops, JacobianVerdict::NotSymplectic { .. }) => (
                Agreement::Agree,
                "Loops and Jacobian agree that the map is not symplectic: it is discontinuous, and \
                 between its jumps it does not keep the form either."
                    .to_owned(),
            ),
            (VerdictKind::BrokenLoops, _) => (
                Agreement::Differ,
                "Both are right: a map that breaks loops can have a symplectic Jacobian almost \
                 everywhere, as derivatives do not see jumps. The jumps alone change the loop integral."
                    .to_owned(),
            ),
            (VerdictKind::NotSymplectic, _) => (
                Agreement::Differ,
                self.hidden_from_derivatives(),
            ),
        };
        SecondOpinion {
            agreement,
            text: format!("{jacobian} {reason}"),
        }
    }

    /// Why loops may not see a defect of the Jacobian.
    fn hidden_from_loops(&self, loops: &Verdict, defect: f64) -> (Agreement, String) {
        let bound = loops.digits.map(|digits| 10f64.powf(-digits));
        let reason = match bound.filter(|&bound| defect <= bound) {
            Some(bound) => format!(
                "Both can be right: the loops bound their defect by {bound:.1e}, and that of the \
                 Jacobian is not above it."
            ),
            None => "The Jacobian counts: a loop integral changes by the defect averaged over the area \
                     within the loop, where parts of either sign cancel, by a symmetry of the loop for \
                     one, and a loop that does not move these degrees of freedom sees nothing of them. Try \
                     loops without symmetry, through the point named."
                .to_owned(),
        };
        (Agreement::Differ, reason)
    }

    /// Why the Jacobian may not see a defect of loops.
    fn hidden_from_derivatives(&self) -> String {
        let mut text = String::from(
            "The loops count: a derivative knows only the points where it was taken. The loop integral \
             can change within the loop, in a stretch of it between the points, or at jumps that the \
             samples do not show as breaks",
        );
        if !self.full {
            text += ", or in directions that random pairs mix with too many others";
        }
        if let Some(bound) = self.bound {
            text += &format!("; and a defect below {bound:.1e} is not seen at all");
        }
        text += ". Try more points and more samples.";
        text
    }
}

/// What the reader should know of a test without an answer.
fn no_opinion(doubt: &Doubt) -> &'static str {
    match doubt {
        Doubt::WeakBound { .. } => {
            " Derivatives enlarge the noise of a map; loop integrals average it and bound the defect better."
        }
        Doubt::NotDifferentiable { .. } => {
            " Loop integrals need no derivative: their verdict stands alone."
        }
        Doubt::LittleDeformation { .. } | Doubt::Unexplained { .. } => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jacobian::{JacobianMethod, TangentDefect};

    fn report(verdict: JacobianVerdict) -> JacobianReport {
        JacobianReport {
            step_size: 0.5,
            method: JacobianMethod::TangentMap,
            verdict,
            points: Vec::new(),
            not_differentiable: 0,
            full: true,
            worst: None,
            bound: Some(1e-11),
            deformation: 1.0,
            noise: 1e-16,
            evaluations: 0,
        }
    }

    fn loops(kind: VerdictKind) -> Verdict {
        Verdict {
            kind,
            digits: (kind == VerdictKind::Symplectic).then_some(13.0),
            order: None,
            summary: String::new(),
            evidence: Vec::new(),
            advice: Vec::new(),
        }
    }

    #[test]
    fn every_pair_of_opinions_has_its_reason() {
        let worst = |signed| TangentDefect {
            s: 0.25,
            signed,
            uncertainty: 1e-15,
            dofs: Some((1, 4)),
        };
        let symplectic = JacobianVerdict::SymplecticAlmostEverywhere { digits: 11.0 };
        let not = |signed| JacobianVerdict::NotSymplectic {
            worst: worst(signed),
        };
        let noise = JacobianVerdict::CannotTell {
            doubt: Doubt::WeakBound {
                bound: 1e-4,
                noise: 1e-7,
            },
        };
        use Agreement::{Agree, Differ, Open};
        use VerdictKind::{BrokenLoops, NotSymplectic, Symplectic, Undecided};
        let cases = [
            (Symplectic, symplectic, Agree, "symplectic"),
            (Symplectic, not(1e-3), Differ, "symmetry"),
            (Symplectic, not(1e-14), Differ, "not above it"),
            (Symplectic, noise, Open, "bound the defect by 1.0e-4"),
            (BrokenLoops, symplectic, Differ, "almost everywhere"),
            (
                BrokenLoops,
                not(-0.5),
                Agree,
                "between degrees of freedom 1 and 4",
            ),
            (NotSymplectic, not(-0.5), Agree, "not symplectic"),
            (NotSymplectic, symplectic, Differ, "between the points"),
            (NotSymplectic, noise, Open, "average it"),
            (Undecided, symplectic, Open, "jumps"),
            (Undecided, not(1.0), Open, "proof"),
        ];
        for (kind, verdict, agreement, words) in cases {
            let second = report(verdict).compare(&loops(kind));
            assert_eq!(second.agreement, agreement, "{kind} beside {verdict}");
            assert!(second.text.contains(words), "{kind}: {}", second.text);
        }
    }
}
