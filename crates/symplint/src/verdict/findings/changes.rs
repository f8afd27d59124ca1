//! Loop integrals that change, and how the change depends on the step size.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::{Change, Step, coordinates};
use crate::text::{capitalised, loop_name, power_of_h, size, two_digits};
use crate::verdict::order::Fit;

/// Loop integrals that change, and how the change depends on the step size.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum ChangeFinding {
    /// The map changes the integral of a loop that does not wind: by more than ten times its uncertainty, and, if it is
    /// below 1e-10, with a law in h, at two step sizes, or by a hundred times its uncertainty.
    Changes {
        /// |E|.
        defect: f64,
        /// The step.
        step: Step,
        /// How it falls with h, if that is known.
        law: Option<Fit>,
    },
    /// The largest significant defect.
    Significant {
        /// By how much.
        change: Change,
        /// Which loop.
        loop_index: usize,
        /// The step.
        step: Step,
    },
    /// The defect at one step size is gone at the next smaller one, faster than h^14 falls, on all loops.
    FailsToConverge {
        /// |E|.
        defect: f64,
        /// The smallest step with a defect.
        step: Step,
        /// The next smaller one.
        smaller: Step,
        /// |E| there is not above this.
        bound: f64,
    },
    /// A law of the defect in h.
    Law {
        /// The fit.
        fit: Fit,
        /// Whether the loop is broken: then the law is the law of the absolutely continuous part.
        between_breaks: bool,
    },
    /// The defect of the Jacobian does not fall as the loop integrals do between two step sizes: no order is stated.
    OrdersDiffer {
        /// The mean slope of the defect of the Jacobian.
        by_jacobian: f64,
        /// The law of the loop integrals.
        by_loops: Fit,
        /// The two step sizes, the larger one first.
        step_sizes: [f64; 2],
    },
    /// A defect of 3 to 10 times its uncertainty, 1e-10 or larger; or a smaller one that is significant and not confirmed.
    Unexplained {
        /// |E|.
        defect: f64,
        /// Its uncertainty.
        uncertainty: f64,
        /// The step.
        step: Step,
    },
    /// Every loop winds round a period.
    AllLoopsWind,
    /// A loop that winds changes: the map is not exact.
    NotExact {
        /// Which loop.
        loop_index: usize,
        /// The degrees of freedom round whose periods it winds.
        #[serde(default)]
        wound: Vec<usize>,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
    },
    /// A loop that winds is conserved: round these periods the map is exact.
    Exact {
        /// Which loop.
        loop_index: usize,
        /// What its defect does not exceed.
        bound: f64,
        /// The degrees of freedom round whose periods it winds.
        #[serde(default)]
        wound: Vec<usize>,
    },
}

impl Display for ChangeFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            ChangeFinding::Changes {
                defect,
                step,
                law: fit,
            } => {
                let law = fit.as_ref().map_or(String::new(), |fit| format!(", {}", law(fit)));
                write!(
                    f,
                    "The map changes loop integrals by up to {} {step}{law}.",
                    two_digits(*defect)
                )
            }
            ChangeFinding::Significant {
                change,
                loop_index,
                step,
            } => write!(
                f,
                "The integral of {} {step} changes by {:+.3e}, relative to its value; the uncertainty is {:.1e}.",
                loop_name(*loop_index),
                change.signed,
                change.uncertainty.unwrap_or(f64::INFINITY)
            ),
            ChangeFinding::FailsToConverge {
                defect,
                step,
                smaller,
                bound,
            } => write!(
                f,
                "The change of {defect:.1e} {step} is gone {smaller} (|E| ≤ {bound:.1e}), which no power of h explains: an iteration fails \
                 to converge {step}, or larger steps reach states at which the step is wrong."
            ),
            ChangeFinding::Law {
                fit,
                between_breaks,
            } => f.write_str(&slope(fit, *between_breaks)),
            ChangeFinding::OrdersDiffer {
                by_jacobian,
                by_loops,
                step_sizes: [large, small],
            } => write!(
                f,
                "No power of h is stated: between h = {} and h = {}, the change of {} is proportional to h^{:.2}, and the defect of the \
                 Jacobian to h^{by_jacobian:.2}.",
                size(*small),
                size(*large),
                loop_name(by_loops.loop_index),
                by_loops.slope
            ),
            ChangeFinding::Unexplained {
                defect,
                uncertainty,
                step,
            } => write!(
                f,
                "The integral changes by {defect:.1e} {step}, with an uncertainty of {uncertainty:.1e}: not enough for a verdict."
            ),
            ChangeFinding::AllLoopsWind => f.write_str(
                "Every loop winds around a period: even a symplectic map may change such an integral.",
            ),
            ChangeFinding::NotExact {
                loop_index,
                wound,
                change,
                step,
            } => write!(
                f,
                "{} winds around {}, and its integral changes by {:+.3e} {step}: no Hamiltonian with this period generates the map. It may \
                 still be symplectic.",
                capitalised(&loop_name(*loop_index)),
                periods(wound),
                change.signed
            ),
            ChangeFinding::Exact {
                loop_index,
                bound,
                wound,
            } => write!(
                f,
                "{} winds around {}, and cannot be contracted to a point. Its integral is also conserved, to {bound:.1e}, as by a map that \
                 a Hamiltonian with this period generates.",
                capitalised(&loop_name(*loop_index)),
                periods(wound)
            ),
        }
    }
}

/// The sentence about the slope of defects against h.
fn slope(fit: &Fit, between_breaks: bool) -> String {
    let what = match between_breaks {
        true => "the integral between the breaks".to_owned(),
        false => loop_name(fit.loop_index),
    };
    let constant = fit.constant.map_or(String::new(), |constant| {
        format!(", next to a constant part of {constant:+.1e}")
    });
    format!(
        "The leading power of h in the change of {what} is {:.2} ± {:.2}{constant}, for h from {} to {}.",
        fit.slope,
        fit.uncertainty,
        size(fit.from),
        size(fit.to)
    )
}

/// `in proportion to h³`.
fn law(fit: &Fit) -> String {
    let to = fit.constant.map_or(String::new(), |constant| {
        format!(" to a constant part of {constant:+.1e}")
    });
    match fit.whole() {
        Some(order) if fit.constant.is_none() => {
            format!("in proportion to {}", power_of_h(order))
        }
        Some(order) => format!("falling as {}{to}", power_of_h(order)),
        None => format!("about as h^{:.1} in the range that was tried", fit.slope),
    }
}

/// The periods of these degrees of freedom.
fn periods(dofs: &[usize]) -> String {
    match dofs {
        [] => "a period".to_owned(),
        dofs => format!("the period of {}", coordinates('q', dofs)),
    }
}
