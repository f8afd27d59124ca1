//! The sentences of a report on a force or a vector field.

use std::fmt;

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use super::evidence::{Curl, FieldKind, FieldLoopKind, LoopWork, OmittedPart};
use super::judge::{Certainty, FieldReport, FieldVerdict};
use crate::signal::SIGNIFICANT;
use crate::text::{plain_numbers, two_digits};

/// Noise below this is rounding in double precision, and is not mentioned.
const MAX_UNMENTIONED_NOISE: f64 = 1e-12;

impl FieldReport {
    fn is_force(&self) -> bool {
        self.evidence.kind == FieldKind::Force
    }

    fn subject(&self) -> &'static str {
        if self.is_force() { "force" } else { "field" }
    }

    /// The integral as messages write it.
    fn integral(&self) -> &'static str {
        match self.is_force() {
            true => "∮F·dq",
            false => "∮(f_q·dp − f_p·dq)",
        }
    }

    /// `1.2e-3 ± 1e-9 of its scale on a random loop`.
    fn value_of(&self, index: usize) -> String {
        let Some(work) = self.evidence.loops.get(index) else {
            return String::new();
        };
        format!(
            "{} ± {} ({} of the integral of a pure rotation) {}",
            two_digits(work.integral),
            two_digits(work.error()),
            two_digits(work.relative()),
            place(work)
        )
    }

    /// The answer in a few words.
    pub fn headline(&self) -> String {
        match self.digits {
            Some(digits) => format!("{} to {digits} digits", self.verdict),
            None => self.verdict.to_string(),
        }
    }

    /// The reason as a sentence.
    pub fn summary(&self) -> String {
        let (subject, integral) = (self.subject(), self.integral());
        match self.certainty {
            Certainty::Closed => {
                let bound = self.evidence.loops.iter();
                let bound = bound
                    .filter(|work| {
                        !matches!(
                            work.kind,
                            FieldLoopKind::Directions | FieldLoopKind::Coordinates { .. }
                        )
                    })
                    .map(LoopWork::bound)
                    .fold(0.0, f64::max);
                format!(
                    "{integral} is zero on every loop tried, within {} of the integral of a pure rotation.",
                    two_digits(bound)
                )
            }
            Certainty::Constant => format!("The {subject} is constant on all loops, to rounding."),
            Certainty::OnePosition => {
                "Every force of one position is a gradient, if the position is not periodic.".into()
            }
            Certainty::Work(index) => format!("{integral} is {}.", self.value_of(index)),
            Certainty::WorkAcrossJumps(index) => {
                let at = self.evidence.loops.get(index).and_then(|work| work.jump_at);
                format!(
                    "The {subject} jumps, and loops across the jump do not close: {integral} is {}{}.",
                    self.value_of(index),
                    at.map_or(String::new(), |s| format!(", with a jump at s = {s:.6}"))
                )
            }
            Certainty::WorkAroundPeriod(index) => format!(
                "Loops that can be contracted close, but around a period {integral} is {}: no {} has that period.",
                self.value_of(index),
                if self.is_force() {
                    "potential"
                } else {
                    "Hamiltonian"
                }
            ),
            Certainty::Tolerance(index) => format!(
                "{integral} is {}: not zero, but small compared with jumps of the {subject}. A solver that stops at a tolerance leaves that.",
                self.value_of(index)
            ),
            Certainty::Small(index) => format!(
                "{integral} is {}: not zero, but a solver that stops at a tolerance could leave that, and the budget was too small to \
                 search for its jumps.",
                self.value_of(index)
            ),
            Certainty::Steep(index) => format!(
                "{integral} is {}: not zero, but the {subject} has a steep part that the samples do not resolve.",
                self.value_of(index)
            ),
            Certainty::NoFunction(index) => format!(
                "{integral} is {} although there is one position: the {subject} is not a function of the position, or samples miss \
                 a narrow part of it.",
                self.value_of(index)
            ),
            Certainty::Repetitions => format!(
                "The {subject} differs by {} of its change along a loop when the same state is evaluated again.",
                two_digits(self.evidence.repetitions)
            ),
            Certainty::Noise(index) => format!(
                "The {subject} is not known exactly enough: {integral} is {}.",
                self.value_of(index)
            ),
            Certainty::Unresolved(index) => format!(
                "{} samples do not resolve the {subject}: {integral} is {}.",
                self.evidence
                    .loops
                    .get(index)
                    .map_or(0, |work| work.samples),
                self.value_of(index)
            ),
        }
    }

    /// The other findings as sentences.
    pub fn sentences(&self) -> Vec<String> {
        let evidence = &self.evidence;
        let subject = self.subject();
        let mut found = Vec::new();
        if let Some(curl) = &evidence.curl
            && curl.value.max(curl.error) < 1.0
        {
            found.push(measured_curl(curl));
        }
        if let Some(worst) = evidence.worst {
            let [of_first, of_second] = match self.is_force() {
                true => [worst.first, worst.second].map(|c| format!("F[{}]", c.dof)),
                false => [worst.first, worst.second].map(|c| format!("G of {c}")),
            };
            found.push(format!(
                "Largest curl found: ∂{of_second}/∂{} − ∂{of_first}/∂{} = {} ± {}{}.",
                worst.first,
                worst.second,
                two_digits(worst.curl),
                two_digits(worst.error),
                match self.is_force() {
                    true => "",
                    false => ", with G = −w f_p for positions and w f_q for momenta of weight w",
                }
            ));
        }
        if let Some((rate, error)) = evidence.damping {
            let [change, kind] = match rate > 0.0 {
                true => ["shrink", "friction on momenta"],
                false => ["grow", "growth of momenta"],
            };
            found.push(format!(
                "All loops {change} at the same rate {} ± {}: uniform {kind} (a conformally Hamiltonian field).",
                two_digits(rate.abs()),
                two_digits(error)
            ));
        }
        if let Certainty::Work(_) = self.certainty
            && evidence.is_small()
            && evidence.jumps() == 0.0
        {
            found.push(
                "Larger loops show no jumps. A curl this small can also come from a solver, a table or finite differences inside; \
                 it is then proportional to the tolerance, or to the distance between entries of the table."
                    .into(),
            );
        }
        if evidence.jumps() > 0.0 {
            found.push(format!(
                "The {subject} jumps on random loops, by up to {} of the scale: cut-offs, tables without interpolation, neighbour lists \
                 and solvers do that.",
                two_digits(evidence.jumps())
            ));
        }
        if evidence.noise > MAX_UNMENTIONED_NOISE {
            found.push(format!(
                "Over short distances the {subject} has a noise of {} of its change along a loop.",
                two_digits(evidence.noise)
            ));
        }
        if evidence.repetitions > MAX_UNMENTIONED_NOISE && self.certainty != Certainty::Repetitions
        {
            found.push(format!(
                "The {subject} differs by {} of its change when the same state is evaluated again.",
                two_digits(evidence.repetitions)
            ));
        }
        let radius = match evidence.radius {
            (least, most) if least == most => two_digits(most),
            (least, most) => format!("{} to {}", two_digits(least), two_digits(most)),
        };
        found.push(format!(
            "Loops reach {radius} from the centre; other regions were not tested."
        ));
        for omitted in &evidence.omitted {
            found.push(match omitted {
                OmittedPart::Loops { count } => {
                    format!("Not tested: {count} more random loops; the budget was too small.")
                }
                OmittedPart::Pairs => {
                    "Not tested: pairs of directions; the budget was too small.".into()
                }
                OmittedPart::Periods { count } => {
                    format!("Not tested: loops around the periods of {count} positions.")
                }
            });
        }
        found
    }

    /// What to do next, as sentences.
    pub fn advice(&self) -> Vec<String> {
        let subject = self.subject();
        let advice: &[&str] = match self.certainty {
            Certainty::Closed if self.evidence.jumps() > 0.0 => &[
                "Jumps of the force limit the digits: more evaluations, or a switching function at a cut-off, show smaller curls.",
            ],
            Certainty::Closed | Certainty::Constant | Certainty::OnePosition => &[],
            Certainty::Work(_) if self.evidence.damping.is_some() => &[
                "Test the field without friction, or use an integrator for conformally Hamiltonian fields.",
            ],
            Certainty::Work(_) if self.is_force() => &[
                "Check the formula first: signs, indices, a force that acts on only one of two particles (Newton's third law), accelerations \
                 instead of forces.",
                "A neural network that predicts forces directly gives no gradient: let it predict the energy, and differentiate.",
            ],
            Certainty::Work(_) => &[
                "Check first: friction, a force that is not a gradient (check_force), velocities instead of momenta (state masses as weights), a \
                 wrong sign.",
            ],
            Certainty::WorkAcrossJumps(_) => &[
                "Make the force continuous: use a switching function at the cut-off, of the same distances that the energy depends on.",
            ],
            Certainty::WorkAroundPeriod(_) => &[
                "A constant driving force does that; energy is then not a function on the periodic domain. Symplectic integrators stay symplectic.",
            ],
            Certainty::Tolerance(_) => &[
                "Tighten the tolerance of solvers inside, and test again: if the integral falls with it, the force is a gradient.",
            ],
            Certainty::Small(_) => &["Give a larger budget."],
            Certainty::Steep(_) | Certainty::Unresolved(_) => &[
                "Give a smaller radius, or a larger budget. If the force has a cut-off, test it with a switching function.",
            ],
            Certainty::NoFunction(_) | Certainty::Repetitions => &[
                "Let the result depend only on the state: fix random numbers, rebuild neighbour lists, leave no state of earlier calls.",
            ],
            Certainty::Noise(_) => {
                &["Give a larger radius, compute in double precision, or tighten tolerances."]
            }
        };
        advice
            .iter()
            .map(|text| match subject {
                "field" => text.replace("the force", "the field"),
                _ => (*text).to_owned(),
            })
            .collect()
    }
}

/// The curl that was measured, as a sentence.
fn measured_curl(curl: &Curl) -> String {
    let value = match curl.value > curl.error {
        true => format!(
            "λ = {} ± {}",
            two_digits(curl.value),
            two_digits(curl.error)
        ),
        false if curl.value + curl.error == 0.0 => "λ = 0".into(),
        false => format!("λ is below {}", two_digits(curl.value + curl.error)),
    };
    let pairs = match (curl.all, curl.pairs) {
        (true, 1) => "the pair of coordinates".into(),
        (true, count) => format!("all {count} pairs of coordinates"),
        (false, count) => format!("{count} random pairs of directions"),
    };
    format!(
        "{value} (antisymmetric part of the Jacobian over the Jacobian, in units of the radii), from {pairs}."
    )
}

/// `on a random loop`.
fn place(work: &LoopWork) -> String {
    match work.kind {
        FieldLoopKind::Random => "on a random loop".into(),
        FieldLoopKind::Directions => "around a small ellipse along two random directions".into(),
        FieldLoopKind::Coordinates { first, second } => {
            format!("around a small circle in the plane of {first} and {second}")
        }
        FieldLoopKind::Winding { dof } => format!("around the period of q[{dof}]"),
    }
}

impl fmt::Display for FieldReport {
    /// A table of the loops, the answer and the findings.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}",
            match self.verdict {
                FieldVerdict::NotAGradient => "NOT A GRADIENT".to_owned(),
                FieldVerdict::NotHamiltonian => "NOT HAMILTONIAN".to_owned(),
                FieldVerdict::Undecided => "INCONCLUSIVE".to_owned(),
                _ => match self.headline().split_once(' ') {
                    Some((answer, rest)) => format!("{} {rest}", answer.to_uppercase()),
                    None => self.headline().to_uppercase(),
                },
            }
        )?;
        writeln!(f, "{}", self.summary())?;
        writeln!(
            f,
            "\n  {:<28}{:>8}{:>12}{:>12}{:>12}",
            "loop", "samples", "integral", "error", "scale"
        )?;
        for work in &self.evidence.loops {
            let name = match work.kind {
                FieldLoopKind::Random => "random".into(),
                FieldLoopKind::Directions => "two random directions".into(),
                FieldLoopKind::Coordinates { first, second } => {
                    format!("plane of {first}, {second}")
                }
                FieldLoopKind::Winding { dof } => format!("around the period of q[{dof}]"),
            };
            let mark = match work.integral.abs() > SIGNIFICANT * work.error() {
                true => " *",
                false => "",
            };
            writeln!(
                f,
                "  {name:<28}{:>8}{:>12}{:>12}{:>12}{mark}",
                work.samples,
                plain_numbers(&format!("{:+.1e}", work.integral)),
                plain_numbers(&format!("{:.0e}", work.error())),
                plain_numbers(&format!("{:.1e}", work.scale)),
            )?;
        }
        writeln!(f)?;
        for sentence in self.sentences().iter().chain(&self.advice()) {
            writeln!(f, "  {sentence}")?;
        }
        let (made, budget) = (self.evidence.evaluations, self.evidence.budget);
        write!(f, "\n{made} evaluations of at most {budget}.")
    }
}

impl Serialize for FieldReport {
    /// The verdict with its sentences, and the evidence.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("FieldReport", 8)?;
        fields.serialize_field("schema", "symplint/field/1")?;
        fields.serialize_field("kind", &self.verdict)?;
        fields.serialize_field("digits", &self.digits)?;
        fields.serialize_field("summary", &self.summary())?;
        fields.serialize_field("sentences", &self.sentences())?;
        fields.serialize_field("advice", &self.advice())?;
        fields.serialize_field("text", &self.to_string())?;
        fields.serialize_field("evidence", &self.evidence)?;
        fields.end()
    }
}
