//! What a verdict rests on: findings with their numbers, and advice.

use serde::Serialize;

use super::jacobian::JacobianFinding;
use super::long_time::Growth;
use super::order::Fit;
use crate::breaks::Break;
use crate::evidence::{
    Contraction, LongTime, Motion, Omission, OutputPrecision, Rank, Reach, Scatter, Sector,
    SubstepDefect, WrongPeriod,
};

/// Which advanced loop a finding speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// The one after a step of this size.
    Size(f64),
    /// The image under a map without a step size.
    Map,
    /// The only one, after a step of unknown size.
    Only,
    /// One of several, counted from 1, after a step of unknown size.
    Number(usize),
}

/// A change of a loop integral with its uncertainty, relative to the integral before the step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Signed.
    pub signed: f64,
    /// Quadrature error and round-off; `None` where the quadrature error is not known.
    pub uncertainty: Option<f64>,
}

/// The range of step sizes of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StepRange {
    /// Nobody stated them.
    Unknown,
    /// The map has none.
    Map,
    /// One.
    One(f64),
    /// From the smallest to the largest.
    Between(f64, f64),
}

/// One statement about the evidence. Its sentence is its `Display`, and each variant says under which condition it is made;
/// [`crate::verdict`] has the numbers.
///
/// The first finding of a verdict decides it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum Finding {
    /// There is no evidence: no loop was advanced, and none failed.
    NothingMeasured,
    /// A position without a stated period jumps by its whole range, before the step or after it, as samples show it.
    Wrapped {
        /// Degree of freedom.
        dof: usize,
        /// The range.
        period: f64,
        /// `None` before the step.
        step: Option<Step>,
    },
    /// The samples before the step jump: they form no closed loop.
    NotClosed {
        /// The jump.
        jump: Break,
    },
    /// The map is discontinuous: an advanced loop jumps, by more than the rounding of the map, where no double lies
    /// between the two sides, and the jump stands out of the noise beside it.
    Discontinuous {
        /// The largest jump of the loop that shows it.
        jump: Break,
        /// Whether the closed integrals are conserved, where that is known.
        conserved: Option<bool>,
    },
    /// Loops that are known by their samples only jump between neighbouring samples, by more than 1e-6 of a coordinate's
    /// range, and by as much with every second and every fourth sample.
    JumpingSamples {
        /// Loops that jump.
        loops: usize,
        /// Loops in all.
        of: usize,
        /// Confirmed jumps of the loop that has most of them.
        jumps: usize,
        /// Which loop that is.
        step: Step,
        /// Samples of each loop.
        samples: usize,
    },
    /// The map changes the integral of a loop that does not wind: by more than ten times its uncertainty, and, if it is
    /// below 1e-10, with a law in h, at two step sizes, or by a hundred times its uncertainty.
    Changes {
        /// |E|.
        defect: f64,
        /// The step.
        step: Step,
        /// How it falls with h, where that is known.
        law: Option<Fit>,
    },
    /// No defect was found, on loops that bound it to 1e-6 or better and that a step moves enough to show one.
    Conserved {
        /// No defect exceeds this.
        bound: f64,
        /// Step sizes of the given loop.
        range: StepRange,
        /// Step sizes at which the map failed.
        failed: usize,
        /// Random loops that bound the defect as well.
        random: usize,
        /// Whether the given loop counts: a loop that winds does not.
        given: bool,
        /// The largest radii of a position and of a momentum, if the verdict is about loops of this size: the map has no
        /// step size, or moves them little.
        radii: Option<[f64; 2]>,
    },
    /// The largest step advances the motions of no loop by 0.05 rad, or by too little for the bound on the defect: a method of
    /// order 4 would not show one; and a larger step shows a defect, or was not tried. (In loops that another code advanced,
    /// also a kick or a free flight alone that deforms none by 0.2 of its size.)
    LittleMotion {
        /// The strongest motion of a loop.
        motion: Motion,
        /// The group of degrees of freedom whose loops these are, where it is not all.
        #[serde(default)]
        group: Option<usize>,
    },
    /// Neighbouring samples are more than half a cell of the map's grid, or a quarter of a period, apart.
    MissesGrid {
        /// Which loop.
        loop_index: usize,
        /// Cells, or half periods, between neighbouring samples.
        cells_apart: f64,
        /// The step.
        step: Step,
    },
    /// All samples came out at one state, which may be rounding: where its numbers are 0, or larger than the loop is wide.
    OneState,
    /// Jumps too small to be told from the output precision of the map.
    SmallJumps {
        /// As a part of the range of the coordinate.
        size: f64,
        /// The step.
        step: Step,
    },
    /// Cells that look like jumps and are not confirmed with fewer samples: too few to tell.
    TooFewForJumps {
        /// Cells.
        cells: usize,
        /// The step.
        step: Step,
        /// Samples.
        samples: usize,
    },
    /// The quadrature error of a sampled loop is not known.
    UnknownIntegral {
        /// Samples.
        samples: usize,
        /// The step.
        step: Step,
        /// Whether there are too few samples to tell at all.
        too_few: bool,
    },
    /// Rows look shuffled: sorted along the loop, neighbours are four times nearer to each other, or more.
    Shuffled {
        /// Mean distance of neighbouring samples over that of sorted ones.
        ratio: f64,
    },
    /// The last row of a loop of another code repeats the first one.
    RepeatedRow {
        /// Its number, counted from 0.
        row: usize,
    },
    /// The rows of a loop of another code are not equally spaced.
    UnequalRows {
        /// The widest gap between neighbours, as a part of the loop.
        widest: f64,
        /// The same in units of the mean gap.
        over_mean: f64,
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
    /// The map fails on every random loop.
    RandomLoopsFail,
    /// The budget left no random loop, and a symmetric given loop can hide a defect.
    NoRandomLoop,
    /// The given loop, or every random one, bounds the defect by no more than 1e-6.
    WeakBound {
        /// The bound.
        bound: f64,
        /// The step.
        step: Step,
        /// Whether round-off makes most of it.
        roundoff: bool,
    },
    /// Loops are conserved, but the Jacobian has a defect of more than ten times its uncertainty.
    JacobianRefutes,
    /// A loop integral changes, the Jacobian does not show why, and nine tenths of the change come from a few points, less
    /// than a thousandth of the disc within the loop.
    ChangesAtAPoint {
        /// Which loop.
        loop_index: usize,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
        /// Where it sits.
        contraction: Contraction,
    },
    /// A loop integral changes by much more than the Jacobian of the step allows, and whether the loop can be contracted in
    /// the domain of the map is not known.
    ContractionUnknown {
        /// Which loop.
        loop_index: usize,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
        /// What no defect of the Jacobian exceeds.
        bound: f64,
    },
    /// Only loops that were not given change, and whether the map projects onto a manifold, beside which that proves
    /// nothing, is not known.
    ManifoldUnknown {
        /// Which loop.
        loop_index: usize,
        /// By how much.
        change: Change,
        /// The step.
        step: Step,
    },
    /// The map projects onto a manifold (its Jacobian is singular at the loop), and the given loop does not lie on it: its
    /// integral changes significantly in one step, and in the step after that it does not.
    LoopBesideManifold {
        /// The smallest singular value of the Jacobian.
        smallest: f64,
        /// Its largest defect in one step.
        first: f64,
        /// What its defect in another step does not exceed.
        second: f64,
    },
    /// The map projects onto a manifold (its Jacobian is singular at the loop), and only random loops or tangent vectors,
    /// which leave the manifold, have a defect.
    Projects {
        /// The smallest singular value of the Jacobian.
        smallest: f64,
        /// What the defect of the given loop does not exceed.
        given: Option<f64>,
        /// The random loop with the largest defect, and this defect.
        beside: Option<(usize, f64)>,
    },
    /// A loop, or the Jacobian, shows a change in non-canonical coordinates whose symplectic form is degenerate: the rank of dϑ
    /// is below the dimension of the manifold to which the loops keep, at both points that were tested.
    DegenerateForm {
        /// The rank of the form, of the dimension of the manifold.
        rank: Rank,
        /// What the defect of the given loop does not exceed.
        given: Option<f64>,
    },
    /// The Jacobian of the step is singular at the loop, and the symplectic form is degenerate on its image.
    LosesRank {
        /// The rank of the Jacobian, of all coordinates.
        rank: Rank,
    },

    /// Where the largest jump is.
    Jump {
        /// Which loop.
        loop_index: usize,
        /// The step.
        step: Step,
        /// Breaks of that loop that were found, where they can be closed.
        breaks: Option<usize>,
        /// Whether there may be more: where a solver stops at a tolerance, two may be too close to each other to be seen.
        at_least: bool,
        /// The largest jump.
        jump: Break,
        /// Whether only samples are known.
        sampled: bool,
    },
    /// How many loops are broken.
    BrokenCount {
        /// Broken ones.
        broken: usize,
        /// Advanced loops.
        of: usize,
    },
    /// What a sampled loop does with and without chords across its jumps.
    SampledBreaks {
        /// The step.
        step: Step,
        /// Cells that look like jumps.
        cells: usize,
        /// Confirmed ones.
        confirmed: usize,
        /// Without the jumping cells.
        open: Change,
        /// With chords across them.
        closed: Change,
    },
    /// A law of the defect in h.
    Law {
        /// The fit.
        fit: Fit,
        /// Whether the loop is broken: the law is that of the absolutely continuous part.
        between_breaks: bool,
    },
    /// All loop integrals are conserved once breaks are closed.
    ClosedConserved {
        /// No closed defect exceeds this.
        bound: f64,
        /// Whether they are closed by straight chords, as substeps are not known.
        #[serde(default)]
        straight: bool,
        /// The loop with the largest.
        loop_index: usize,
        /// The step.
        step: Step,
    },
    /// A closed loop integral changes.
    ClosedChanges {
        /// By how much.
        change: Change,
        /// Whether it is closed by straight chords, as substeps are not known: that proves nothing.
        #[serde(default)]
        straight: bool,
        /// Where the change proves nothing: what other curves that close the breaks could contribute.
        #[serde(default)]
        bend: Option<f64>,
        /// Which loop.
        loop_index: usize,
        /// The step.
        step: Step,
    },
    /// Samples cannot prove a jump.
    SamplesAreNoProof {
        /// Samples.
        samples: usize,
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
    /// The defect of the Jacobian does not fall as the loop integrals do between two step sizes: no order is stated.
    OrdersDiffer {
        /// The mean slope of the defect of the Jacobian.
        by_jacobian: f64,
        /// The law of the loop integrals.
        by_loops: Fit,
        /// The two step sizes, the larger one first.
        step_sizes: [f64; 2],
    },
    /// The loop of the verdict moves degrees of freedom that the given loop leaves at rest.
    MovesRest {
        /// Which loop.
        loop_index: usize,
    },
    /// How large the defects of a loop may be.
    Bound {
        /// Which loop.
        loop_index: usize,
        /// Samples; `None` by the piecewise rule.
        samples: Option<usize>,
        /// The bound; `None` where nothing is known.
        bound: Option<f64>,
        /// |E| as measured.
        measured: f64,
        /// Its uncertainty.
        uncertainty: Option<f64>,
        /// The step.
        step: Step,
    },
    /// How large the defects in a group of degrees of freedom of similar action may be.
    Group {
        /// Which group, the one with the largest actions first.
        index: usize,
        /// All groups.
        of: usize,
        /// Its degrees of freedom.
        dofs: Vec<usize>,
        /// Its largest action, as a part of the largest of all.
        action: f64,
        /// Loops that move it.
        loops: usize,
        /// The bound of these loops.
        by_loops: Option<f64>,
        /// The bound of the Jacobian.
        by_jacobian: Option<f64>,
    },
    /// The map failed on a loop.
    LoopFailed {
        /// Which loop.
        loop_index: usize,
        /// Its error.
        reason: String,
    },
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
    /// Features narrower than the distance of samples are not resolved.
    Resolution {
        /// Samples of the given loop.
        samples: usize,
    },
    /// How the largest step moves the loops.
    Moves {
        /// The strongest motion of a loop.
        motion: Motion,
        /// Whether the map has a step size.
        has_step_size: bool,
    },
    /// What a larger step, or a larger loop of a map without a step size, shows of a map that moves loops little.
    Beyond {
        /// The loop.
        reach: Box<Reach>,
        /// Whether it moves more than the other loops.
        more: bool,
    },
    /// The decay of the Fourier coefficients of the advanced loop.
    Regularity {
        /// Sobolev exponent.
        exponent: f64,
        /// The step.
        step: Step,
    },
    /// The map rounds what it returns.
    Precision(OutputPrecision),
    /// The map works in single precision inside.
    SingleInside,
    /// Results of one state differ, by rounding or at random.
    Scatter(Scatter),
    /// A state has the same result at all step sizes.
    IgnoresStepSize,
    /// A stated period is not one of the map.
    WrongPeriod(WrongPeriod),
    /// What becomes of the defect in many steps.
    ManySteps {
        /// What was measured.
        steps: LongTime,
        /// What follows.
        growth: Growth,
    },
    /// What the substeps of the map do to the loop.
    Substeps {
        /// All of them.
        substeps: Vec<SubstepDefect>,
        /// The step.
        step: Step,
    },
    /// Which part of the disc within the loop carries the defect.
    Sectors {
        /// All of them.
        sectors: Vec<Sector>,
        /// The step.
        step: Step,
    },
    /// What the Jacobian of a step says beside the loops.
    Jacobian {
        /// What it says.
        finding: JacobianFinding,
    },
    /// Something was left out.
    Omitted {
        /// What.
        omission: Omission,
    },
    /// What the verdict cost.
    Evaluations {
        /// Made.
        made: usize,
        /// Allowed.
        budget: usize,
    },
}

/// What to do next. Its sentence is its `Display`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum Advice {
    /// Measure a loop.
    MeasureLoop,
    /// State the period of a position.
    StatePeriod,
    /// State the period of positions, if they live in a periodic box.
    PeriodIfPeriodic,
    /// Give the samples in their order.
    OrderOfSamples,
    /// Take more samples of a loop for another code.
    MoreSamplesOfFile,
    /// Use a smoother interpolation.
    SmootherForce,
    /// Tighten the tolerance of a solver inside the map.
    TightenSolver,
    /// A solver inside the map that stops at a tolerance is the likely cause of the breaks: tighten it.
    SolverTolerance {
        /// Breaks of all loops and steps at which rounding decides on which side of them a state is.
        flickering: usize,
        /// All breaks of all loops and steps.
        breaks: usize,
        /// The most that a coordinate jumps by.
        largest: f64,
    },
    /// Let the radii of the loop follow the map: `radius = "auto"`, [`balanced_radii`](crate::map::balanced_radii).
    BalancedRadii {
        /// By how much the radii differ from the ratio that the motion suggests.
        imbalance: f64,
    },
    /// Let an iteration inside the step converge, or take smaller step sizes.
    LetStepConverge {
        /// A step size at which it does.
        converges: f64,
    },
    /// Take a larger loop or more samples: rounding of the states averages out.
    LargerLoopOrMoreSamples,
    /// Take smaller step sizes: one step deforms the loop by many times its size, and a smaller loop has fewer digits.
    SmallerSteps {
        /// The largest motion of a coordinate against the mean motion, over half its range on the loop.
        deformation: f64,
    },
    /// Give more step sizes to learn the order.
    MoreStepSizes {
        /// Step sizes measured.
        given: usize,
    },
    /// The step sizes that were given show no order.
    NoOrder {
        /// Step sizes measured.
        given: usize,
        /// Whether the defects of the smaller ones drown in their uncertainty.
        drowned: bool,
    },
    /// Say the step sizes of the files.
    StateStepSizes,
    /// The defect does not fall with h.
    DefectDoesNotFall,
    /// Take larger steps.
    LargerSteps {
        /// So many times the largest one, where it can be told.
        factor: Option<f64>,
        /// The largest one, where it is known.
        step_size: Option<f64>,
    },
    /// Take a larger loop: its integral changes.
    LargerRadii {
        /// This number of times as large.
        factor: f64,
    },
    /// Take a loop on which forces act: the step is a free flight or a kick alone.
    LoopWithForces,
    /// Check that the files differ.
    CheckCopies,
    /// Check that the step returns what it advanced.
    ReturnStates,
    /// Two samples or more in each cell.
    SamplesInCells,
    /// More samples and larger steps.
    MoreSamplesAndLargerSteps,
    /// Add loops that can be contracted.
    ContractibleLoops,
    /// Take a loop that does not run round that point.
    LoopBesidePoint,
    /// Give larger radii to a group of degrees of freedom.
    LargerRadiiOfGroup,
    /// Give a loop on the constraint manifold.
    LoopOnManifold,
    /// Give a projection onto the constraint manifold.
    Project,
    /// Give Casimir functions, or a projection onto a leaf of the symplectic form.
    KeepToLeaf,
    /// Take a smaller loop that stays in the domain of the map.
    SmallerLoopInDomain,
    /// A loop that a step does not deform by so many times its size.
    SmallerLoop {
        /// The largest motion of a coordinate against the mean motion, over half its range on the loop.
        deformation: f64,
    },
    /// Take more samples, or a smaller loop.
    MoreSamplesOrSmallerLoop,
    /// Take another rule than finite differences, which are of first order.
    RuleAuto,
    /// Take a larger loop: round-off makes the bound weak.
    LargerLoop,
    /// Return more digits.
    MoreDigits,
    /// Give every row and every call the same random numbers.
    SameRandomNumbers,
    /// Take other loops: the Jacobian shows a defect that these hide.
    OtherLoops,
    /// One loop is one probe.
    MoreLoops,
    /// The same, for loops of another code.
    MoreLoopsOfFile,
    /// Raise the budget.
    MoreEvaluations {
        /// By this many evaluations, about.
        wanted: usize,
    },
}
