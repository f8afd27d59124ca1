//! What can go wrong, with the numbers in it and the remedy in the text.

use std::fmt;

use crate::text::{given, two_digits};

/// The remedy of [`Error::NotFinite`] for a state that a map without a step size returned.
pub const LOOK_AT_MAP: &str = "look at the map there, or take a smaller loop";

/// ` with h = 0.5`.
fn with(step_size: Option<f64>) -> String {
    step_size.map_or(String::new(), |h| format!(" with h = {}", given(h)))
}

/// How small the area of a loop is, and what helps.
fn without_area(integral: f64, scale: f64) -> String {
    if scale == 0.0 {
        return " in double precision; take a larger loop, or a centre nearer to the origin"
            .to_owned();
    }
    format!(
        ": its loop integral is {} where its size would allow {}; take a loop whose areas do not cancel, such as a circle whose radii \
         differ, another radius, or a centre nearer to the origin",
        two_digits(integral),
        two_digits(scale)
    )
}

/// Which state an error is about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StateLocation {
    /// A sample of the loop, counted from 0.
    Sample(usize),
    /// A sample of the loop, counted from 0, of this number of equispaced ones: it lies at s = `sample`/`samples`.
    SampleOf {
        /// Which.
        sample: usize,
        /// How many there are.
        samples: usize,
    },
    /// The state of the loop at this s, between samples.
    Loop(f64),
    /// The centre of the loops.
    Centre,
    /// The state of a random loop of a test of a force, at this s.
    RandomLoop(f64),
    /// A state displaced from that of the loop at this s, to measure derivatives.
    Displaced(f64),
    /// A state on the boundary of a sector of the disc within the loop, by its own parameter from 0 to 1.
    Sector(f64),
    /// A state of a segment that closes a break of the loop, by its own parameter from 0 to 1.
    Segment(f64),
    /// The state of an orbit near the loop.
    Orbit,
}

impl fmt::Display for StateLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StateLocation::Sample(sample) => write!(f, "sample {sample}"),
            StateLocation::SampleOf { sample, samples } => {
                let s = *sample as f64 / *samples as f64;
                write!(f, "sample {sample} of {samples} (s = {s:?})")
            }
            StateLocation::Loop(s) => write!(
                f,
                "s = {s:?} of the loop, between samples (sample the loop at this s and take one step)"
            ),
            StateLocation::Centre => f.write_str("the centre of the loops"),
            StateLocation::RandomLoop(s) => write!(f, "s = {s:?} of a random loop"),
            StateLocation::Displaced(s) => write!(
                f,
                "s = {s:?} of the loop (displaced from its state there to measure derivatives)"
            ),
            StateLocation::Sector(t) => write!(
                f,
                "t = {t:?} of the boundary of a sector of the disc within the loop"
            ),
            StateLocation::Segment(t) => write!(
                f,
                "t = {t:?} of a segment that closes a break of the loop (0 is the one side of the break, 1 the \
                 other; between them the map need not be defined, and Closure::Chords stays away from there)"
            ),
            StateLocation::Orbit => f.write_str("the orbit next to the loop"),
        }
    }
}

/// A dependence of the result of a step, apart from h and the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Dependence {
    /// The states that were advanced before.
    EarlierCalls,
    /// The states that were advanced before, or the other rows of the batch.
    Either,
}

impl Dependence {
    fn remedy(self) -> &'static str {
        match self {
            Dependence::EarlierCalls => {
                "Compute times, forces, neighbour lists and first guesses from these, or restore them before each call (`reset`), and draw \
                 the same random numbers in every call"
            }
            Dependence::Either => {
                "If it draws random numbers, give every row and every call the same ones"
            }
        }
    }
}

impl fmt::Display for Dependence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Dependence::EarlierCalls => "earlier calls",
            Dependence::Either => "earlier calls or on the other rows of the batch",
        })
    }
}

/// Errors of the diagnostic.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A list has another length than there are degrees of freedom.
    #[error("{what}: got {got} values for d = {expected}; give one for each degree of freedom")]
    Length {
        /// Which list.
        what: &'static str,
        /// Degrees of freedom.
        expected: usize,
        /// Values given.
        got: usize,
    },
    /// A period or weight that is not valid.
    #[error("{what}[{dof}] is {}; {remedy}", given(*.value))]
    BadCoordinate {
        /// Period or weight.
        what: &'static str,
        /// Degree of freedom.
        dof: usize,
        /// The value given.
        value: f64,
        /// What to give instead.
        remedy: &'static str,
    },
    /// Too few samples for a loop integral.
    #[error("a loop integral from {samples} samples has no meaning; use 3 or more")]
    TooFewSamples {
        /// Samples given.
        samples: usize,
    },
    /// Fewer samples than the streaming rule's stencil spans.
    #[error(
        "a stencil of half width {half_width} spans {} samples, and the loop has {samples}; take more samples",
        2 * .half_width + 1
    )]
    StencilTooWide {
        /// Samples given.
        samples: usize,
        /// Neighbours on either side.
        half_width: usize,
    },
    /// A quantity is outside the range in which it has a meaning.
    #[error("{what} is {}; {remedy}", given(*.value))]
    OutOfRange {
        /// Which quantity.
        what: &'static str,
        /// The value given.
        value: f64,
        /// What to give instead.
        remedy: &'static str,
    },
    /// A degree of freedom that is not there.
    #[error("degree of freedom {dof} does not exist: there are {count}, counted from 0")]
    NoSuchDof {
        /// The number given.
        dof: usize,
        /// Degrees of freedom.
        count: usize,
    },
    /// The centre of a loop is not finite.
    #[error("the loop's centre {coordinate}[{dof}] is {value}; give finite centres")]
    BadCentre {
        /// `q` or `p`.
        coordinate: &'static str,
        /// Degree of freedom.
        dof: usize,
        /// NaN or an infinity.
        value: f64,
    },
    /// A state that is not finite.
    #[error(
        "{coordinate}[{dof}] is {value} at {at}{}; {remedy}",
        .step_size.map_or(String::new(), |h| format!(" after a step of h = {}", given(h)))
    )]
    NotFinite {
        /// `q` or `p`.
        coordinate: &'static str,
        /// Degree of freedom.
        dof: usize,
        /// Which state.
        at: StateLocation,
        /// The step size, if a map made the state.
        step_size: Option<f64>,
        /// NaN or an infinity.
        value: f64,
        /// What to do.
        remedy: &'static str,
    },
    /// The map reported a failure.
    #[error("the map failed at {at}{}: {reason}", with(*.step_size))]
    StepFailed {
        /// Which state.
        at: StateLocation,
        /// The step size; `None` for a map without one.
        step_size: Option<f64>,
        /// The map's reason.
        reason: String,
    },
    /// A step of several went wrong.
    #[error("in step {step}: {error}")]
    InStep {
        /// Which one, counted from 1.
        step: usize,
        /// What happened.
        error: Box<Error>,
    },
    /// A rule that evaluates the map between the samples, asked to integrate samples alone.
    #[error(
        "the {rule} rule evaluates the map and cannot integrate samples alone; use the pseudospectral or the \
         finite-difference rule"
    )]
    NeedsMap {
        /// The rule's name.
        rule: &'static str,
    },
    /// A loop integral beyond the range of double precision.
    #[error(
        "the loop integral of q[{dof}] and p[{dof}] overflows (it is {value}); choose units in which positions and momenta are of moderate \
         size"
    )]
    Overflow {
        /// Degree of freedom.
        dof: usize,
        /// NaN or an infinity.
        value: f64,
    },
    /// An ensemble that no memory holds.
    #[error(
        "{samples} samples of {dof} degrees of freedom are {bytes:.1e} bytes; take fewer samples or \
         degrees of freedom"
    )]
    TooLarge {
        /// Degrees of freedom.
        dof: usize,
        /// Samples.
        samples: usize,
        /// Size of the ensemble.
        bytes: f64,
    },
    /// The same state does not always become the same state.
    #[error(
        "the result depends on {dependence}: the state{} has another result {circumstance} ({coordinate}[{dof}] differs by \
         {difference:.1e}{}). A step must depend only on h and the state. {}",
        match .s { Some(s) => format!(" at s = {s} of the loop"), None => String::new() },
        with(*.step_size),
        dependence.remedy()
    )]
    Memory {
        /// How it was advanced the second time.
        circumstance: &'static str,
        /// The dependence.
        dependence: Dependence,
        /// The loop parameter, if the state is one of the given loop that was advanced to test this.
        s: Option<f64>,
        /// `'q'` or `'p'`.
        coordinate: char,
        /// Degree of freedom.
        dof: usize,
        /// How far apart the two states are.
        difference: f64,
        /// The step size; `None` for a map without one.
        step_size: Option<f64>,
    },
    /// A stated period is not one of the map.
    #[error(
        "{} is not a period of {coordinate}[{dof}]: after the step, two states that differ by it are {} further apart; correct \
         the period, or leave it out",
        given(*.period),
        two_digits(*.difference)
    )]
    NotAPeriod {
        /// `'q'` or `'p'`.
        coordinate: char,
        /// Degree of freedom.
        dof: usize,
        /// The stated period.
        period: f64,
        /// The largest difference of a coordinate between Φ(q + P, p) and Φ(q, p) + (P, 0).
        difference: f64,
    },
    /// A stated period is not one of a force or a vector field.
    #[error(
        "{} is not a period of the force in q[{dof}]: at two positions that differ by it, the work over the radius of a \
         loop differs by {}; correct the period, or leave it out",
        given(*.period),
        two_digits(*.difference)
    )]
    NotAPeriodOfForce {
        /// Degree of freedom.
        dof: usize,
        /// The stated period.
        period: f64,
        /// The largest difference of a component times the radius of its coordinate.
        difference: f64,
    },
    /// The loop is smaller than the rounding of its states.
    #[error(
        "the loop is too small for double precision at its distance from the origin: its loop integral is {}, of which double \
         precision leaves {} uncertain; take a larger loop, or coordinates in which it is nearer to the origin",
        two_digits(*.integral),
        two_digits(*.roundoff)
    )]
    LostInRounding {
        /// The loop integral.
        integral: f64,
        /// What rounding leaves uncertain of it.
        roundoff: f64,
    },
    /// A loop that does not end where it begins.
    #[error(
        "the loop is not closed: {coordinate}[{dof}] is {gap:.2e} away from where it began when s reaches 1; let s run through full turns (2π, not 6.28), or state the period of the coordinate"
    )]
    OpenLoop {
        /// `'q'` or `'p'`.
        coordinate: char,
        /// Degree of freedom.
        dof: usize,
        /// The widest gap of all coordinates.
        gap: f64,
    },
    /// A loop function that does not repeat itself.
    #[error(
        "the loop function is random: at s = {s} of the loop, {coordinate}[{dof}] differs by {difference:.1e} when it is \
         called again; let it depend only on s"
    )]
    RandomLoop {
        /// The loop parameter.
        s: f64,
        /// `'q'` or `'p'`.
        coordinate: char,
        /// Degree of freedom.
        dof: usize,
        /// How far apart the two states are.
        difference: f64,
    },
    /// A loop that winds round a torus, on which ∮ p·dq has no value.
    #[error(
        "the loop winds around a period of q[{dof}] or p[{dof}], and both are periodic: ∮ p·dq has no value then; take a loop that can be \
         contracted to a point"
    )]
    WindsRoundTorus {
        /// Degree of freedom.
        dof: usize,
    },
    /// The loop integral of the initial loop vanishes, so a relative defect has no meaning.
    #[error("the initial loop encloses no area{}", without_area(*.integral, *.scale))]
    NoArea {
        /// The loop integral.
        integral: f64,
        /// Sum of the absolute contributions that could have been.
        scale: f64,
    },
    /// Loops of which one cannot be the other after a step.
    #[error(
        "loop {} after the step has {} samples of {} degrees of freedom where the loop before it has {} of \
         {}; give the same samples before and after",
        .index + 1, .after.0, .after.1, .before.0, .before.1
    )]
    ShapesDiffer {
        /// Which of the loops after the step, counted from 0.
        index: usize,
        /// Samples and degrees of freedom before the step.
        before: (usize, usize),
        /// Samples and degrees of freedom after it.
        after: (usize, usize),
    },
    /// Two loops are said to be made by steps of one size.
    #[error("h = {} is stated for two loops; give one for each step size", given(*.step_size))]
    RepeatedStep {
        /// The step size.
        step_size: f64,
    },
    /// More evaluations than the budget has left.
    #[error(
        "the budget of {budget} evaluations has {left} left where {wanted} are needed at once; raise the budget"
    )]
    BudgetSpent {
        /// Evaluations allowed in all.
        budget: usize,
        /// Evaluations that may still be made.
        left: usize,
        /// Evaluations that were asked for.
        wanted: usize,
    },
    /// A one-form whose number of coordinates does not fit the degrees of freedom of the map.
    #[error(
        "the one-form has {dimension} coordinates and the map {dof} degrees of freedom; there must be twice as many coordinates, or as many with NonCanonical::of_positions"
    )]
    FormDimension {
        /// Coordinates of the one-form.
        dimension: usize,
        /// Degrees of freedom of the map.
        dof: usize,
    },
    /// The map asked to end the diagnosis ([`Capabilities::is_stopped`](crate::map::Capabilities::is_stopped)).
    #[error("the diagnosis was stopped before it was over")]
    Stopped,
    /// Map and loop live in different phase spaces.
    #[error("the degrees of freedom differ: the map has {map} and the loop {phase_loop}")]
    DofMismatch {
        /// Degrees of freedom of the map.
        map: usize,
        /// Degrees of freedom of the loop.
        phase_loop: usize,
    },
}

impl Error {
    /// The same where the loop was the boundary of a sector.
    pub(crate) fn in_sector(mut self) -> Error {
        if let Error::NotFinite { at, .. } | Error::StepFailed { at, .. } = &mut self
            && let StateLocation::Loop(t) = *at
        {
            *at = StateLocation::Sector(t);
        }
        self
    }

    /// Whether the map failed or returned a state that is not finite, and nothing is wrong with the request.
    pub(crate) fn is_of_map(&self) -> bool {
        match self {
            Error::NotFinite { .. } | Error::StepFailed { .. } => true,
            Error::InStep { error, .. } => error.is_of_map(),
            _ => false,
        }
    }

    /// The same about the state that a sample of a batch stands for.
    pub(crate) fn at(mut self, state: impl Fn(usize) -> StateLocation) -> Error {
        if let Error::NotFinite { at, .. } | Error::StepFailed { at, .. } = &mut self
            && let StateLocation::Sample(sample) = *at
        {
            *at = state(sample);
        }
        self
    }

    pub(crate) fn check_length(
        what: &'static str,
        expected: usize,
        got: usize,
    ) -> Result<(), Error> {
        if got == expected {
            Ok(())
        } else {
            Err(Error::Length {
                what,
                expected,
                got,
            })
        }
    }
}
