//! What to do next.

use derive_more::Display;
use serde::Serialize;

use super::properties::Property;
use crate::text::{one_digit, power_of_h, short, size};

/// What to do next. Its sentence is its `Display`.
#[derive(Clone, Debug, Display, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum Advice {
    /// What to do about the cause of a failure.
    #[display("{text}")]
    Remedy {
        /// As a sentence.
        text: String,
    },
    /// Look for the causes that a defect of this order has.
    #[display("{}", look_for_cause(*order))]
    LookForCause {
        /// k of defect ~ h^k, or the slope at the smallest step sizes, if it is known.
        order: Option<f64>,
    },
    /// Measure a loop.
    #[display("Measure one loop or more.")]
    MeasureLoop,
    /// State the period of a position.
    #[display(
        "State the period of the position, as an array `period` in the file or as an option."
    )]
    StatePeriod,
    /// State the period of positions, if they live in a periodic box.
    #[display(
        "If a coordinate is periodic (an angle, a position in a periodic box, a momentum on a torus), keep it unwrapped or state its period."
    )]
    PeriodIfPeriodic,
    /// Give the samples in their order.
    #[display(
        "Give all samples in their order along a closed loop, in the same order before and after the step."
    )]
    OrderOfSamples,
    /// Take more samples of a loop for another code.
    #[display(
        "Take more samples, four times as many or more: a jump keeps its size, a steep slope fades."
    )]
    MoreSamplesOfFile,
    /// Make a force continuous that jumps.
    #[display(
        "If a force jumps between cells, at a cut-off or at a switch, make it continuous: interpolation of higher order, a \
         smooth switch."
    )]
    SmootherForce,
    /// Tighten the tolerance of a solver inside the map.
    #[display("If a solver inside the map stops at a tolerance, tighten it.")]
    TightenSolver,
    /// Let the radii of the loop follow the map: `radius = "auto"`, [`balanced_radii`](crate::map::balanced_radii).
    #[display(
        "Set radius = \"auto\" (in Rust, `map::balanced_radii`): the radii of q and p differ by a factor of {} from the motion on the loop.",
        one_digit(*imbalance)
    )]
    BalancedRadii {
        /// By how much the radii differ from the ratio that the motion suggests.
        imbalance: f64,
    },
    /// Let an iteration inside the step converge, or take smaller step sizes.
    #[display(
        "If the step iterates, take step sizes of {} and below, or let it converge at larger ones. Otherwise look at the states that \
         only larger steps reach: a limit, a threshold, friction in a region.",
        size(*converges)
    )]
    LetStepConverge {
        /// A step size at which it does.
        converges: f64,
    },
    /// Take a larger loop or more samples: rounding of the states averages out.
    #[display(
        "Take a larger loop or more samples: the loop integral averages over the rounding of the states."
    )]
    LargerLoopOrMoreSamples,
    /// Take smaller step sizes: one step deforms the loop by many times its size, and a smaller loop has fewer digits.
    #[display("{}", less_deformation("Take smaller step sizes", *deformation))]
    SmallerSteps {
        /// The largest motion of a coordinate against the mean motion, over half its range on the loop.
        deformation: f64,
    },
    /// Give more step sizes to learn the order.
    #[display(
        "Give four or more step sizes, each half of the one before, to learn the power of h ({given} given)."
    )]
    MoreStepSizes {
        /// Step sizes measured.
        given: usize,
    },
    /// The step sizes that were given show no order.
    #[display("{}", no_order(*given, *drowned))]
    NoOrder {
        /// Step sizes measured.
        given: usize,
        /// Whether the defects of the smaller ones drown in their uncertainty.
        drowned: bool,
    },
    /// Say the step sizes of the files.
    #[display("State the step sizes to learn the power of h.")]
    StateStepSizes,
    /// Take larger steps.
    #[display("{}", larger_steps(*factor, *step_size))]
    LargerSteps {
        /// This multiple of the largest one, if it is known.
        factor: Option<f64>,
        /// The largest one, if it is known.
        step_size: Option<f64>,
    },
    /// Take a larger loop: its integral changes.
    #[display(
        "Take a loop {} times as large: the map changes the integral of such a loop.",
        short(*factor)
    )]
    LargerRadii {
        /// This number of times as large.
        factor: f64,
    },
    /// Take a loop on which forces act: the step is a free flight or a kick alone.
    #[display(
        "Take much larger step sizes, or a loop on which forces differ: all methods conserve areas in a step that is \
         nearly a free flight or a kick."
    )]
    LoopWithForces,
    /// Check that the files differ.
    #[display("Check that the files after the step are not copies of the one before it.")]
    CheckCopies,
    /// Check that the step returns what it advanced.
    #[display(
        "Check that the step returns the states that it advanced, or writes them into the arrays that it gets; \
         if it does, take larger step sizes, or step_sizes = \"none\" for a map that is not a step in time."
    )]
    ReturnStates,
    /// Two samples or more in each cell.
    #[display(
        "Take more samples or a smaller loop: two samples or more in each cell that it crosses."
    )]
    SamplesInCells,
    /// More samples and larger steps.
    #[display(
        "Take more samples and larger step sizes: a true change grows with h, an error does not."
    )]
    MoreSamplesAndLargerSteps,
    /// Add loops that can be contracted.
    #[display("Add loops that can be contracted: set loops to 8.")]
    ContractibleLoops,
    /// Take a loop that does not go around that point.
    #[display("Take a smaller loop, or one elsewhere, that does not go around that point.")]
    LoopBesidePoint,
    /// Give larger radii to a group of degrees of freedom.
    #[display(
        "Give larger radii to these degrees of freedom, well above the rounding of their states, or leave them at rest."
    )]
    LargerRadiiOfGroup,
    /// Give a loop on the constraint manifold.
    #[display(
        "If the step keeps a constraint, give a projection onto its manifold (`project=` in Python, `with_projection` in Rust), which \
         puts all loops there. Or give a loop on the manifold, with loops = 1 and jacobian = false: random loops leave it. If not, \
         check that the step fills and returns both q and p. If it clips a coordinate, take a loop that does not reach the limit."
    )]
    LoopOnManifold,
    /// Give a projection onto the constraint manifold.
    #[display(
        "Give a projection onto the constraint manifold (`project=` in Python, `with_projection` in Rust; systems of the program have \
         one): it keeps random loops and the Jacobian on the manifold. Or test your loop alone: loops = 1, jacobian = false."
    )]
    Project,
    /// Give Casimir functions, or a projection onto a leaf of the symplectic form.
    #[display(
        "If dϑ should have full rank, look for a pair that ϑ lacks. Otherwise, state all Casimir functions of the form (`casimir`, \
         `OneForm::project`), or a projection onto a leaf (`project`): they keep all loops and the Jacobian on one leaf."
    )]
    KeepToLeaf,
    /// Take a smaller loop that stays in the domain of the map.
    #[display("Take a smaller loop, well inside the domain of the map, or set loops to 1.")]
    SmallerLoopInDomain,
    /// A smaller loop, which a step deforms less.
    #[display("{}", less_deformation("Take a loop ten times smaller, or smaller step sizes", *deformation))]
    SmallerLoop {
        /// The largest motion of a coordinate against the mean motion, over half its range on the loop.
        deformation: f64,
    },
    /// Take more samples, or a smaller loop.
    #[display("Take more samples or a smaller loop.")]
    MoreSamplesOrSmallerLoop,
    /// Take another rule than finite differences, which are of first order.
    #[display(
        "Set rule to \"auto\": finite differences are of first order, and only good to a few digits."
    )]
    RuleAuto,
    /// Take a larger loop: round-off makes the bound weak.
    #[display(
        "Rounding errors, or other noise of the map, make most of the bound: take a larger loop, nearer to the origin, and states in \
         double precision. Tighten the tolerances of solvers, and interpolate tables smoothly."
    )]
    LargerLoop,
    /// Return more digits.
    #[display(
        "Return more digits to learn more: compute in double precision, do not round (17 digits, if states are printed), and \
         return no integers."
    )]
    MoreDigits,
    /// Give every row and every call the same random numbers.
    #[display(
        "If the step draws random numbers: give every row and every call the same ones (one seed at the start of \
         every step, and one draw for all rows). If it keeps a force, a neighbour list or a first guess from earlier calls: compute \
         it from the state, or restore it before each call (`reset`)."
    )]
    SameRandomNumbers,
    /// Take other loops: the Jacobian shows a defect that these hide.
    #[display("Take other loops: one that is off the symmetries of the system, and a larger one.")]
    OtherLoops,
    /// One loop is one probe.
    #[display("One loop tests one region of phase space: set loops to 8.")]
    MoreLoops,
    /// The same, for loops of another code.
    #[display(
        "One loop tests one region of phase space: also measure others, such as a random one, by `--shape fourier --seed 2` in the \
         command `symplint loop` of this loop."
    )]
    MoreLoopsOfFile,
    /// Raise the budget.
    #[display("Raise the budget by about {wanted} evaluations: this loop needs more samples.")]
    MoreEvaluations {
        /// By this many evaluations, about.
        wanted: usize,
    },
    /// Find out why a step leaves the manifold of the loops.
    #[display(
        "Check the projection or the Casimir functions that you gave: the step has to conserve them. If they are right, look for \
         friction, or for a constraint that the step does not solve to rounding error."
    )]
    KeepToManifold,
    /// Check that a map without a step size, which moves nothing, returns what it advanced.
    #[display(
        "The map moves no state of the loops: check that it returns the states that it advanced, or writes them into the arrays that \
         it gets."
    )]
    MovesNothing,
    /// Correct a period.
    #[display(
        "Correct the period that you stated, or leave it out: no random loop winds around it."
    )]
    CorrectPeriod,
    /// Look for causes other than friction, which the properties of the map exclude.
    #[display(
        "The step preserves volume where it was tested, so friction is not the likely cause. Look for a force that is not a gradient \
         (`check_force`): a pair force without its reaction, a coupling with a wrong sign. Look for momenta that are not canonical, and \
         for steps of different lengths for different states."
    )]
    LookBeyondFriction,
    /// Test several steps at once, as larger steps fail.
    #[display(
        "Larger steps fail, so test {repeat} steps at once (repeat = {repeat}, or {repeat} times the present repeat{}): together they \
         should rotate the loop by about a radian.",
        budget.map_or_else(String::new, |budget| format!("; budget = {budget} or more"))
    )]
    StepsAtOnce {
        /// This multiple of the present number.
        repeat: usize,
        /// Evaluations that such a check needs, about, if they are more than the present budget.
        budget: Option<usize>,
    },
    /// Let the step use the step size, or state that it has none.
    #[display(
        "If the step has a time step of its own, let it use h. If it has none, state this (step_sizes = \"none\")."
    )]
    UseStepSize,
}

/// Steps that have to be longer by more than this, or that deform a loop by more times its size, suit another loop. Conventional.
const MAX_USUAL_FACTOR: f64 = 300.0;

impl Advice {
    /// The likeliest causes of a defect of this order, if none is known.
    pub(super) fn on_order(order: Option<f64>, properties: &[Property]) -> Self {
        // Those of a method depend on the order alone.
        let is_of_method = order.is_some_and(|order| order.round() >= 2.0);
        match !is_of_method && properties.iter().any(Property::excludes_friction) {
            true => Advice::LookBeyondFriction,
            false => Advice::LookForCause { order },
        }
    }

    /// Whether it helps to learn the order of a defect, and names no cause.
    pub(super) fn is_of_order(&self) -> bool {
        matches!(
            self,
            Advice::StateStepSizes
                | Advice::MoreStepSizes { .. }
                | Advice::MoreEvaluations { .. }
                | Advice::NoOrder { .. }
        )
    }

    /// Whether it stands for any cause, as the cause is not known.
    pub(super) fn is_general(&self) -> bool {
        matches!(
            self,
            Advice::SmootherForce | Advice::PeriodIfPeriodic | Advice::TightenSolver
        )
    }
}

/// Why the step sizes that were given show no order, and which step sizes would show one.
fn no_order(given: usize, drowned: bool) -> String {
    match drowned {
        true => format!(
            "The changes at the smaller of {given} step sizes are not above their uncertainty: give larger step sizes, each half \
             of the one before, to learn the power of h."
        ),
        false => format!(
            "The changes at {given} step sizes do not follow one power of h: give smaller step sizes, each half of the one before, \
             to learn the power."
        ),
    }
}

/// Advice to take larger steps: by a factor, if it is known, than this size, if it is known.
fn larger_steps(factor: Option<f64>, step_size: Option<f64>) -> String {
    let sizes = match (factor, step_size) {
        (Some(factor), Some(h)) => format!(", near {}", one_digit(factor * h)),
        (Some(factor), None) => format!(", about {} times the present one", one_digit(factor)),
        (None, _) => String::new(),
    };
    let other_loop = match factor {
        Some(factor) if factor > MAX_USUAL_FACTOR => {
            " If the present ones are those of your simulation, take a smaller loop instead, of the size of a cell, a wave or an orbit."
        }
        _ => "",
    };
    format!(
        "Take larger step sizes{sizes}: one step should rotate the loop by about a radian, or far enough that a change would exceed \
         the bound.{other_loop}"
    )
}

/// What to do if a step deforms the loop: `remedy`, or other units if the step deforms it very much.
fn less_deformation(remedy: &str, deformation: f64) -> String {
    let times = short(deformation);
    match deformation > MAX_USUAL_FACTOR {
        true => format!(
            "Set radius = \"auto\", and step_sizes or typical_step to those of your simulation: one step deforms this loop by {times} \
             times its size, as in other units."
        ),
        false => format!("{remedy}: one step deforms this loop by {times} times its size."),
    }
}

/// The likeliest causes of a defect of this order.
fn look_for_cause(order: Option<f64>) -> String {
    match order {
        Some(order) if order.round() >= 2.0 => {
            // A method of order p changes areas in proportion to h^(p + 1). On an oscillator odd powers vanish, and p + 2 is left
            // of an even p. A slope between two orders names no method.
            let [methods, law] = match order {
                k if k.fract() == 0.0 && k % 2.0 == 0.0 && k > 2.0 => [
                    format!("a Runge–Kutta method of order {} or {}", k - 2.0, k - 1.0),
                    power_of_h(k),
                ],
                k if k.fract() == 0.0 => [
                    format!("a Runge–Kutta method of order {}", k - 1.0),
                    power_of_h(k),
                ],
                _ => [
                    "an explicit Runge–Kutta method".to_owned(),
                    "h² or a higher power".to_owned(),
                ],
            };
            format!(
                "Check the method: {methods}, for example, changes loop integrals in proportion to {law}. Use a symplectic method of the \
                 same order. A splitting such as leapfrog is symplectic if H = T(p) + V(q): forces do not depend on p, and each substep \
                 uses the newest q and p. An implicit method has to solve its equations to all digits. With several degrees of freedom, \
                 test the force (`check_force` in Python and C)."
            )
        }
        Some(order) if order > 0.0 => {
            "Look for friction, a force that is not a gradient (`check_force`), momenta that are not canonical (velocities: \
             `weight`, or `mass_matrix` if masses depend on q; p = γ m v; a magnetic field), steps of different lengths for different \
             states, a force that depends on p, and for the explicit Euler method."
                .to_owned()
        }
        _ => {
            "Look for friction, a force that is not a gradient (`check_force`), momenta that are not canonical, and for a method \
             that is not symplectic."
                .to_owned()
        }
    }
}
