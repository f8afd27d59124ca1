//! The checks of a diagnosis: the evaluations that each made, and what was left out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The checks, a row for each: what it tests, its name, what progress calls it, and what a report says if it is left out.
macro_rules! checks {
    ($($(#[$doc:meta])* $name:ident: $label:literal, $left_out:literal;)*) => {
        /// A test of a map.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum Check {
            $($(#[$doc])* $name,)*
        }

        impl Check {
            /// What progress calls it: "random loops", for example.
            pub fn label(self) -> &'static str {
                match self {
                    $(Check::$name => $label,)*
                }
            }

            /// The sentence of a report if the check is left out.
            pub(crate) fn left_out(self) -> &'static str {
                match self {
                    $(Check::$name => $left_out,)*
                }
            }
        }
    };
}

checks! {
    /// Radii of the loop that fit the map, if they are not given.
    Radii: "radius of the loop", "The search for radii was left out";
    /// Step sizes that test something, if they are not given.
    StepSizes: "step sizes", "The search for step sizes was left out";
    /// Whether results depend on earlier calls, on other rows of a batch or on random numbers; their precision.
    Memory: "repeated calls", "Whether results depend on earlier calls was not tested";
    /// The given loop at all step sizes.
    GivenLoop: "your loop", "Your loop was left out";
    /// The given loop with different numbers of samples.
    SampleSweep: "numbers of samples", "The sweep over numbers of samples was cut short";
    /// Random loops, and larger steps or loops if all others move little.
    RandomLoops: "random loops", "Random loops were left out";
    /// The Jacobian of a step.
    Jacobian: "Jacobian", "The Jacobian was left out";
    /// Whether the map projects onto a constraint manifold, or its form is degenerate.
    Constraint: "constraints", "Whether the map projects onto a constraint manifold was not tested";
    /// Whether a loop whose integral changes can be contracted in the domain of the map.
    Contraction: "smaller loops", "Whether the loop can be contracted in the domain of the map was not tested";
    /// Which substep and which part of a loop has a defect.
    Localisation: "where the change arises", "The origin of the change was not searched";
    /// The given loop in many steps.
    ManySteps: "many steps", "Many steps were left out";
    /// Why loops break: both sides of a break.
    BreakSides: "both sides of a break", "The cause of the breaks was not searched";
    /// Whether a map whose loops change preserves another constant two-form.
    PreservedForm: "other variables", "Whether another form is preserved was not tested";
    /// Whether steps back undo a step.
    Structure: "further properties", "Time reversal and symmetry were not tested";
}

/// A check that was left out, or a part of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Omission {
    /// Which.
    pub check: Check,
    /// Why.
    pub why: OmissionReason,
}

/// Why a check was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum OmissionReason {
    /// The budget was too small.
    Budget {
        /// The least number that is missing: step sizes of the given loop, numbers of samples of a sweep, random loops; 1 of other checks.
        missing: usize,
    },
    /// The budget was too small for samples that resolve the loop to round-off.
    Unresolved,
    /// Ensembles of this many samples would take more than 512 MiB.
    Memory {
        /// How many.
        samples: usize,
    },
    /// The map failed.
    Failed {
        /// At a step size of the given loop, if it has one: others were measured.
        step_size: Option<f64>,
        /// The error of the map.
        reason: String,
    },
}

impl OmissionReason {
    /// Of a check of one part that the budget did not allow.
    pub(crate) const BUDGET: OmissionReason = OmissionReason::Budget { missing: 1 };
}

impl Omission {
    /// What of this check the budget did not allow; 0 if this is another omission.
    pub(crate) fn missing(&self, check: Check) -> usize {
        match self.why {
            OmissionReason::Budget { missing } if self.check == check => missing,
            _ => 0,
        }
    }
}

/// Evaluations of the map: states advanced by one step.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Evaluations {
    /// Made in all.
    pub made: usize,
    /// Allowed.
    pub budget: usize,
    /// 0: what is measured does not depend on where evaluations come from. The provenance of a report says how many were taken
    /// from a journal.
    #[serde(default)]
    pub replayed: usize,
    /// More that would resolve the loops, about and at most; 0 where they are resolved, and where no number is known
    /// to resolve them.
    pub wanted: usize,
    /// Made by each check.
    pub by_check: BTreeMap<Check, usize>,
}

impl Evaluations {
    /// Made by a check.
    pub fn of(&self, check: Check) -> usize {
        self.by_check.get(&check).copied().unwrap_or(0)
    }

    /// Counts those of a check.
    pub(crate) fn add(&mut self, check: Check, evaluations: usize) {
        if evaluations > 0 {
            *self.by_check.entry(check).or_default() += evaluations;
        }
    }

    /// Counts those that were made to find radii, before the diagnosis and in addition to its budget.
    pub(crate) fn add_radii(&mut self, evaluations: usize) {
        self.add(Check::Radii, evaluations);
        self.made += evaluations;
        self.budget += evaluations;
    }

    /// Those of a map that is applied this number of times to each state.
    pub(crate) fn times(self, repeat: usize) -> Self {
        let times = |count: usize| count.saturating_mul(repeat);
        let by_check = self.by_check.into_iter();
        Evaluations {
            made: times(self.made),
            budget: times(self.budget),
            replayed: self.replayed,
            wanted: times(self.wanted),
            by_check: (by_check.map(|(check, count)| (check, times(count)))).collect(),
        }
    }
}
