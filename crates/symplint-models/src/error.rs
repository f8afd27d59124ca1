//! What can be wrong with a model or a method, with the numbers in it and the remedy in the text.

/// Errors of Hamiltonians, integrators and combinations of maps.
///
/// Degrees of freedom, parts and stages are counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A parameter outside the range in which it has a meaning.
    #[error("{what} is {value:?}; {remedy}")]
    OutOfRange {
        /// Which parameter.
        what: &'static str,
        /// The value given.
        value: f64,
        /// What to give instead.
        remedy: &'static str,
    },
    /// A system of nothing.
    #[error("{system} of 0 {parts} is empty; give at least 1")]
    Empty {
        /// Which system.
        system: &'static str,
        /// Its parts.
        parts: &'static str,
    },
    /// A spline degree that is not provided.
    #[error("spline degree {degree} is not provided; give {lowest} to {highest}")]
    Degree {
        /// The degree given.
        degree: usize,
        /// Lowest degree that makes sense here.
        lowest: usize,
        /// Highest degree provided.
        highest: usize,
    },
    /// A degree that a family of particle shapes does not have.
    #[error("there are no {family} shapes of degree {degree}; give 1 to {highest}")]
    ShapeDegree {
        /// Name of the family.
        family: &'static str,
        /// The degree given.
        degree: usize,
        /// Highest degree of the family.
        highest: usize,
    },
    /// Fewer cells than a spline covers, so that it would overlap itself round the period.
    #[error(
        "{cells} cells are too few for splines of degree {degree}, which cover {needed}; give at \
         least {needed} cells or a lower degree"
    )]
    TooFewCells {
        /// Spline degree.
        degree: usize,
        /// Cells given.
        cells: usize,
        /// Cells that one spline covers.
        needed: usize,
    },
    /// Too few cells for a node to have two neighbours.
    #[error(
        "on {cells} cells the neighbours of a node are one and the same, so that centred differences are 0 and no \
         particle feels a force; give at least 3 cells"
    )]
    NoCentredDifference {
        /// Cells given.
        cells: usize,
    },
    /// More cells than memory is meant to be spent on.
    #[error("{cells} cells are more than the {limit} provided for; give fewer")]
    TooManyCells {
        /// Cells given.
        cells: usize,
        /// The most that are accepted.
        limit: usize,
    },
    /// The collocation matrix has the alternating mode in its kernel.
    #[error(
        "splines of even degree {degree} on an even number of cells ({cells}) cannot match values \
         at the nodes: they all give 0 there for alternating coefficients, so the collocation \
         matrix is singular; give an odd number of cells, {} say, or an odd degree", .cells + 1
    )]
    SingularCollocation {
        /// Spline degree.
        degree: usize,
        /// Cells given.
        cells: usize,
    },
    /// A list of a state with too few or too many entries.
    #[error("there are {got} {what} where {expected} are needed; give one for each")]
    StateLength {
        /// The contents of the list.
        what: &'static str,
        /// Entries given.
        got: usize,
        /// Entries needed.
        expected: usize,
    },
    /// No integrator has this name.
    #[error("unknown integrator \"{name}\"; available: {}", .known.join(", "))]
    UnknownIntegrator {
        /// The name given.
        name: String,
        /// All names.
        known: Vec<&'static str>,
    },
    /// The integrator has no such variant.
    #[error(
        "integrator \"{integrator}\" has no variant \"{variant}\"; {}",
        if .known.is_empty() { "it has none: leave the variant out".to_owned() }
        else { format!("there are {} (the first is the default)", .known.join(", ")) }
    )]
    UnknownVariant {
        /// Name of the integrator.
        integrator: &'static str,
        /// The variant given.
        variant: String,
        /// All variants of this integrator.
        known: &'static [&'static str],
    },
    /// A tableau whose matrix and weights do not fit together.
    #[error(
        "{what} of tableau \"{tableau}\" has {got} entries for {stages} stages; give one for each"
    )]
    TableauShape {
        /// Name of the tableau.
        tableau: String,
        /// Which part.
        what: &'static str,
        /// Stages: number of weights.
        stages: usize,
        /// Entries given.
        got: usize,
    },
    /// Two tableaus of one partitioned method with different numbers of stages.
    #[error(
        "the tableaus of \"{pair}\" have {position} stages for q and {momentum} for p; pad the \
         shorter one with stages of weight 0"
    )]
    PairStages {
        /// Name of the pair.
        pair: String,
        /// Stages of the tableau for q.
        position: usize,
        /// Stages of the tableau for p.
        momentum: usize,
    },
    /// A Runge–Kutta method some of whose stages depend on each other in a circle.
    #[error(
        "\"{method}\" is implicit for this Hamiltonian: its stage {stage} (counted from 0) depends \
         on itself; step it by ImplicitRungeKutta, or take a partitioned method on a separable \
         Hamiltonian"
    )]
    Implicit {
        /// Name of the method.
        method: String,
        /// The first stage that cannot be evaluated.
        stage: usize,
    },
    /// An integrator that cannot advance this kind of system.
    #[error(
        "integrator \"{integrator}\" is for {needs}, and this is {kind}; {}",
        if .known.is_empty() { "leave the integrator out".to_owned() }
        else { format!("there are {}", .known.join(", ")) }
    )]
    NotForThis {
        /// Name of the integrator.
        integrator: &'static str,
        /// Which systems it advances.
        needs: &'static str,
        /// The kind of the system.
        kind: &'static str,
        /// The integrators that do advance it.
        known: Vec<&'static str>,
    },
    /// A solver told to do without iterations.
    #[error(
        "a solver with at most 0 iterations solves nothing; give at least 1, or take an explicit \
         method"
    )]
    NoIterations,
    /// Newton's method for a scheme that is solved by fixed-point iteration alone.
    #[error("\"{integrator}\" is solved by fixed-point iteration alone; leave out Newton's method")]
    NoNewton {
        /// The integrator.
        integrator: &'static str,
    },
    /// Newton's method for more equations than dense matrices are meant for.
    #[error(
        "Newton's method would solve {unknowns} equations for each sample with dense matrices, and \
         {limit} is the most provided for; take fixed-point iteration"
    )]
    TooManyUnknowns {
        /// 2 d s: degrees of freedom and stages.
        unknowns: usize,
        /// The most that are accepted.
        limit: usize,
    },
    /// A splitting method with nothing to do.
    #[error("splitting method \"{method}\" has no substep with a coefficient other than 0")]
    NoSubsteps {
        /// Name of the method.
        method: &'static str,
    },
    /// A composition of no maps.
    #[error("a composition of no maps is the identity, which tells nothing; give at least one map")]
    EmptyComposition,
    /// Maps on different phase spaces cannot follow one another.
    #[error(
        "map {part} of the composition has {got} degrees of freedom and map 0 has {expected}; \
         they must agree"
    )]
    ComposedDof {
        /// The map that differs.
        part: usize,
        /// Degrees of freedom of map 0.
        expected: usize,
        /// Degrees of freedom of the map that differs.
        got: usize,
    },
    /// Maps that give their coordinates different meanings cannot follow one another.
    #[error(
        "map {part} of the composition has other periods or momentum weights than map 0; they must \
         agree"
    )]
    ComposedCoordinates {
        /// The map that differs.
        part: usize,
    },
}

impl ModelError {
    /// Refuses a parameter that is not finite.
    ///
    /// # Errors
    /// If it is not finite.
    pub fn check_finite(what: &'static str, value: f64) -> Result<(), ModelError> {
        if value.is_finite() {
            Ok(())
        } else {
            Err(ModelError::OutOfRange {
                what,
                value,
                remedy: "give a finite number",
            })
        }
    }

    /// Refuses a parameter that is not finite and positive.
    ///
    /// # Errors
    /// If it is not finite, or not above 0.
    pub fn check_positive(what: &'static str, value: f64) -> Result<(), ModelError> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(ModelError::OutOfRange {
                what,
                value,
                remedy: "give a finite number above 0",
            })
        }
    }
}
