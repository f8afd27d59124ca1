//! The sentences of findings: all English of a verdict is here and in the folder beside this file.

mod advice;
mod domain;
mod jacobian;

use std::fmt::{Display, Formatter, Result};

use super::finding::{Change, Finding, Step, StepRange};
use super::long_time::Growth;
use super::number::{capitalised, jumping, loop_name, short, size};
use super::order::Fit;
use crate::breaks::Break;
use crate::evidence::{
    LongTime, Motion, OutputFormat, OutputPrecision, Reach, SIGNIFICANT, Scatter, ScatterKind,
    Sector, SubstepDefect,
};
use domain::degrees_of_freedom;

impl Display for Step {
    /// `at h = 2^-1`, `in one application`, `after the step`, `in loop 2 after the step`.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Step::Size(h) => write!(f, "at h = {}", size(*h)),
            Step::Map => f.write_str("in one application"),
            Step::Only => f.write_str("after the step"),
            Step::Number(number) => write!(f, "in loop {number} after the step"),
        }
    }
}

impl Display for Change {
    /// `+1.2e-3 ± 4.5e-15`.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.uncertainty {
            Some(uncertainty) => write!(f, "{:+.3e} ± {uncertainty:.1e}", self.signed),
            None => write!(f, "{:+.3e}, with an unknown quadrature error", self.signed),
        }
    }
}

impl Display for StepRange {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            StepRange::Unknown => f.write_str("; the step size is not stated"),
            StepRange::Map => Ok(()),
            StepRange::One(h) => write!(f, " at h = {}", size(*h)),
            StepRange::Between(low, high) => {
                write!(f, " for h from {} to {}", size(*low), size(*high))
            }
        }
    }
}

/// `falling as h^3`.
fn law(fit: &Fit) -> String {
    let to = fit.constant.map_or(String::new(), |constant| {
        format!(" to a constant part of {constant:+.1e}")
    });
    match fit.whole() {
        Some(order) => format!("falling as h^{order}{to}"),
        None => format!(
            "falling about as h^{:.1} in the range that was tried",
            fit.slope
        ),
    }
}

/// `, and the bound of a range`, for random loops.
fn random_loops(count: usize, range: &StepRange) -> String {
    let high = match range {
        StepRange::Unknown | StepRange::Map => String::new(),
        StepRange::One(h) => format!(" at h = {}", size(*h)),
        StepRange::Between(low, high) => {
            let largest = if low.abs() > high.abs() { low } else { high };
            format!(" at h = {}", size(*largest))
        }
    };
    match count {
        0 => String::new(),
        1 => format!(", nor on a random one{high}"),
        others => format!(", nor on {others} random ones{high}"),
    }
}

/// ` (the map failed at 2 others)`, after a range of step sizes.
fn but_failed(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => " (the map failed at another one)".to_owned(),
        others => format!(" (the map failed at {others} others)"),
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Finding::NothingMeasured => f.write_str("No loop was measured."),
            Finding::Wrapped { dof, period, step } => {
                let when = step.map_or("before the step".into(), |step| step.to_string());
                write!(
                    f,
                    "q of degree of freedom {dof} jumps by its whole range of {} {when}, as a position in a \
                     periodic box does.",
                    short(*period)
                )
            }
            Finding::NotClosed { jump } => write!(
                f,
                "Degree of freedom {} already jumps before the step, by {} in q and {} in p near s = {:.6}: the \
                 samples form no closed loop.",
                jump.dof,
                short(jump.jump_q),
                short(jump.jump_p),
                jump.s
            ),
            Finding::Shuffled { ratio } => write!(
                f,
                "Neighbouring samples of a loop are {} times as far apart as they are when sorted along it: the \
                 rows do not seem to be in order.",
                short(*ratio)
            ),
            Finding::Discontinuous { jump, conserved } => {
                let closed = match conserved {
                    Some(true) => " With the breaks closed its loop integrals are conserved.",
                    Some(false) => " Its loop integrals change even with the breaks closed.",
                    None => "",
                };
                write!(
                    f,
                    "The map is discontinuous, as far as double precision can tell: {} of degree of freedom {} \
                     jumps at s = {:.12}.{closed}",
                    jumping(jump.jump_q, jump.jump_p),
                    jump.dof,
                    jump.s
                )
            }
            Finding::JumpingSamples {
                loops,
                of,
                jumps,
                step,
                samples,
            } => write!(
                f,
                "{loops} of {of} advanced loops jump between neighbouring samples, {jumps} times {step}: the map \
                 is discontinuous as far as {samples} samples can tell."
            ),
            Finding::Changes {
                defect,
                step,
                law: fit,
            } => {
                let law = fit.as_ref().map_or(String::new(), |fit| format!(", {}", law(fit)));
                write!(
                    f,
                    "The map changes a loop integral by {defect:.1e} {step}{law}."
                )
            }
            Finding::Conserved {
                bound,
                range,
                failed,
                random,
                given,
                radii,
            } => {
                match given {
                    true => write!(
                        f,
                        "No defect above {bound:.1e} on the given loop{range}{}{}",
                        but_failed(*failed),
                        random_loops(*random, range)
                    )?,
                    false => write!(
                        f,
                        "No defect above {bound:.1e} on {random} random loop{}{range}{}; the given one winds round a \
                         period",
                        plural(*random),
                        but_failed(*failed)
                    )?,
                }
                if let Some([q, p]) = radii {
                    write!(
                        f,
                        ": on loops with radii up to {} in q and {} in p",
                        short(*q),
                        short(*p)
                    )?;
                }
                f.write_str(".")
            }
            Finding::LittleMotion { motion, group } => little_motion(f, motion, *group),
            Finding::MissesGrid {
                loop_index,
                cells_apart,
                step,
            } => write!(
                f,
                "Neighbouring samples of {} are {} cells of the map's grid, or half periods, apart {step}: they \
                 do not resolve it.",
                loop_name(*loop_index),
                short(*cells_apart)
            ),
            Finding::OneState => f.write_str(
                "All samples of the loop came out at one state: the step returns no others, or rounds to more than the \
                 loop's size.",
            ),
            Finding::SmallJumps { size, step } => write!(
                f,
                "Jumps of {} of a coordinate's range {step} may be breaks, or the output precision of single \
                 precision or of a solver inside the step.",
                short(*size)
            ),
            Finding::TooFewForJumps {
                cells,
                step,
                samples,
            } => write!(
                f,
                "{cells} cells look like jumps {step}, but {samples} samples are too few to tell a jump from a \
                 steep slope."
            ),
            Finding::UnknownIntegral {
                samples,
                step,
                too_few,
            } => match too_few {
                true => write!(
                    f,
                    "{samples} samples do not show whether a loop is smooth; {} can: its integral is not known.",
                    crate::evidence::FEWEST_SAMPLES
                ),
                false => write!(
                    f,
                    "{samples} samples do not resolve the loop {step}: its integral is not known."
                ),
            },
            Finding::RepeatedRow { row } => write!(
                f,
                "Row {row} repeats row 0, as if both ends of the loop were included: it was left out."
            ),
            Finding::UnequalRows { widest, over_mean } => write!(
                f,
                "The rows are not equally spaced: the widest gap is {} times the mean, {:.2}% of the loop. The integrals \
                 are interpolated, and their errors include the gaps.",
                short(*over_mean),
                100.0 * widest
            ),
            Finding::Unexplained {
                defect,
                uncertainty,
                step,
            } => write!(
                f,
                "A defect of {defect:.1e} {step} is more than quadrature error and round-off explain \
                 ({uncertainty:.1e}), but not significant."
            ),
            Finding::AllLoopsWind => f.write_str(
                "Every loop winds round a period: even a symplectic map may change such an integral.",
            ),
            Finding::RandomLoopsFail => {
                f.write_str("The map fails on every random loop of the given one's size.")
            }
            Finding::NoRandomLoop => f.write_str(
                "Only the given loop was tried, before the budget was spent, and a symmetric loop can hide a defect.",
            ),
            Finding::WeakBound { bound, step, .. } => {
                write!(f, "The defect {step} is only bounded by {bound:.1e}.")
            }
            Finding::JacobianRefutes => f.write_str(
                "The loops are conserved, but the Jacobian of a step is not symplectic.",
            ),
            Finding::ChangesAtAPoint {
                loop_index,
                change,
                step,
                contraction,
            } => domain::at_a_point(f, *loop_index, change, step, contraction),
            Finding::ContractionUnknown {
                loop_index,
                change,
                step,
                bound,
            } => domain::contraction_unknown(f, *loop_index, change, step, *bound),
            Finding::ManifoldUnknown {
                loop_index,
                change,
                step,
            } => domain::manifold_unknown(f, *loop_index, change, step),
            Finding::LoopBesideManifold {
                smallest,
                first,
                second,
            } => domain::beside_manifold(f, *smallest, [*first, *second]),
            Finding::Projects {
                smallest,
                given,
                beside,
            } => domain::projects(f, *smallest, *given, *beside),
            Finding::DegenerateForm { rank, given } => domain::degenerate_form(f, *rank, *given),
            Finding::LosesRank { rank } => write!(
                f,
                "The step projects: its Jacobian has rank {} of {} at the loop. Such a step is not symplectic on the whole phase \
                 space; it may be on the manifold onto which it projects.",
                rank.rank, rank.of
            ),
            Finding::Jump {
                loop_index,
                step,
                breaks,
                at_least,
                jump,
                sampled,
            } => match sampled {
                true => fmt_sampled_jump(f, step, jump),
                false => fmt_jump(f, *loop_index, step, (*breaks, *at_least), jump),
            },
            Finding::BrokenCount { broken, of } => {
                write!(f, "{broken} of {of} advanced loops are broken.")
            }
            Finding::SampledBreaks {
                step,
                cells,
                confirmed,
                open,
                closed,
            } => write!(
                f,
                "{}: {cells} cells jump, {confirmed} confirmed. The relative change of the loop integral is \
                 {open} without them, {closed} with chords across them.",
                capitalised(&step.to_string())
            ),
            Finding::Law {
                fit,
                between_breaks,
            } => {
                let what = match between_breaks {
                    true => "what is left between the breaks".to_owned(),
                    false => loop_name(fit.loop_index),
                };
                let constant = fit.constant.map_or(String::new(), |constant| {
                    format!(" and a constant part of {constant:+.1e}")
                });
                write!(
                    f,
                    "The defect of {what} goes as h^({:.3} ± {:.3}){constant} between h = {} and h = {}.",
                    fit.slope,
                    fit.uncertainty,
                    size(fit.from),
                    size(fit.to)
                )
            }
            Finding::ClosedConserved {
                bound,
                straight,
                loop_index,
                step,
            } => write!(
                f,
                "With their breaks closed{} all loop integrals are conserved to {bound:.1e} (worst case: {}, {step}).",
                by_chords(*straight),
                loop_name(*loop_index)
            ),
            Finding::ClosedChanges {
                change,
                straight,
                bend,
                loop_index,
                step,
            } => {
                let (by_chords, name) = (by_chords(*straight), loop_name(*loop_index));
                match (straight, bend) {
                    (false, None) => write!(
                        f,
                        "With its breaks closed the integral of {name} still changes by {change} {step}."
                    ),
                    (false, Some(bend)) => write!(
                        f,
                        "With its breaks closed by straight segments the integral of {name} differs by {change} {step}. That \
                         proves nothing: q and p of a degree of freedom jump together, and other curves across the \
                         breaks contribute about as much as {bend:.1e}."
                    ),
                    (true, _) => write!(
                        f,
                        "With its breaks closed{by_chords} the integral of {name} differs by {change} {step}. That proves \
                         nothing: a step may bend what closes a break."
                    ),
                }
            }
            Finding::SamplesAreNoProof { samples } => write!(
                f,
                "Samples do not prove a jump: a slope steeper than 1/{samples} of the loop looks the same."
            ),
            Finding::Significant {
                change,
                loop_index,
                step,
            } => write!(
                f,
                "The relative change of the integral of {} {step} is {:+.3e}; quadrature error and round-off are \
                 below {:.1e}.",
                loop_name(*loop_index),
                change.signed,
                change.uncertainty.unwrap_or(f64::INFINITY)
            ),
            Finding::FailsToConverge {
                defect,
                step,
                smaller,
                bound,
            } => write!(
                f,
                "The defect of {defect:.1e} {step} is gone {smaller} (|E| ≤ {bound:.1e}), which no power of h explains: the step \
                 fails to converge {step}, or takes another branch there."
            ),
            Finding::OrdersDiffer {
                by_jacobian,
                by_loops,
                step_sizes: [large, small],
            } => write!(
                f,
                "No order is stated: {} falls as h^{:.2}, and the defect of the Jacobian as h^{by_jacobian:.2} between h = {} \
                 and h = {}.",
                loop_name(by_loops.loop_index),
                by_loops.slope,
                size(*small),
                size(*large)
            ),
            Finding::MovesRest { loop_index } => write!(
                f,
                "{} also moves degrees of freedom that the given loop leaves at rest.",
                capitalised(&loop_name(*loop_index))
            ),
            Finding::Bound {
                loop_index,
                samples,
                bound,
                measured,
                uncertainty,
                step,
            } => {
                let by = samples.map_or("piecewise".into(), |samples| format!("{samples} samples"));
                let name = capitalised(&loop_name(*loop_index));
                match (bound, uncertainty) {
                    (Some(bound), Some(uncertainty)) => write!(
                        f,
                        "{name} ({by}) {step}: |E| ≤ {bound:.1e}; measured {} ± {uncertainty:.1e}.",
                        short(*measured)
                    ),
                    _ => write!(f, "{name} ({by}) {step}: E is not known."),
                }
            }
            Finding::Group {
                index,
                of,
                dofs,
                action,
                loops,
                by_loops,
                by_jacobian,
            } => domain::group(
                f,
                [*index, *of],
                dofs,
                *action,
                (*loops, *by_loops),
                *by_jacobian,
            ),
            Finding::LoopFailed { loop_index, reason } => write!(
                f,
                "{} was not measured, the map fails on it: {reason}.",
                capitalised(&loop_name(*loop_index))
            ),
            Finding::NotExact {
                loop_index,
                wound,
                change,
                step,
            } => write!(
                f,
                "{} winds round {}, and its integral changes by {:+.3e} {step}: the map is not exact; no \
                 Hamiltonian of that period generates it.",
                capitalised(&loop_name(*loop_index)),
                periods(wound),
                change.signed
            ),
            Finding::Exact {
                loop_index,
                bound,
                wound,
            } => write!(
                f,
                "{} winds round {}, cannot be contracted, and is conserved to {bound:.1e}, too: round that period the \
                 map is exact, as far as that tells.",
                capitalised(&loop_name(*loop_index)),
                periods(wound)
            ),
            Finding::Resolution { samples } => write!(
                f,
                "Features narrower than 1/{samples} of the loop are not resolved."
            ),
            Finding::Moves {
                motion,
                has_step_size,
            } => moves(f, motion, *has_step_size),
            Finding::Beyond { reach, more } => beyond(f, reach, *more),
            Finding::Regularity { exponent, step } => write!(
                f,
                "{} the Fourier coefficients of the given loop decay as those of a function in H^{exponent:.1}: \
                 {}, or on slopes that the samples do not resolve.",
                capitalised(&step.to_string()),
                roughness(*exponent).unwrap_or("as of a smooth function")
            ),
            Finding::Precision(precision) => fmt_precision(f, precision),
            Finding::SingleInside => f.write_str(
                "States that are a few units of single precision apart scatter by as much after the step: the map \
                 works in single precision inside, or rounds as coarsely.",
            ),
            Finding::Scatter(scatter) => fmt_scatter(f, scatter),
            Finding::IgnoresStepSize => f.write_str(
                "The step ignores h: a state has the same result at all step sizes, so that the defect has no order in h.",
            ),
            Finding::WrongPeriod(wrong) => write!(
                f,
                "{:?} is not a period of the map in {}[{}]: two states that differ by it differ after the step by {:.1e} \
                 more. No random loop winds round it. Correct the period, or leave it out.",
                wrong.period, wrong.coordinate, wrong.dof, wrong.difference
            ),
            Finding::ManySteps { steps, growth } => fmt_long_time(f, steps, *growth),
            Finding::Substeps { substeps, step } => fmt_substeps(f, substeps, step),
            Finding::Sectors { sectors, step } => fmt_sectors(f, sectors, step),
            Finding::Jacobian { finding } => finding.fmt(f),
            Finding::Omitted { omission } => omission.fmt(f),
            Finding::Evaluations { made, budget } => {
                write!(f, "Evaluations of the map: {made}, of at most {budget}.")
            }
        }
    }
}

fn fmt_sampled_jump(f: &mut Formatter<'_>, step: &Step, jump: &Break) -> Result {
    write!(
        f,
        "The largest jump {step}, in degree of freedom {} near s = {:.6}, is {:.3e} in q and {:.3e} in p, \
         with every sample as with every second and every fourth.",
        jump.dof, jump.s, jump.jump_q, jump.jump_p
    )
}

fn fmt_jump(
    f: &mut Formatter<'_>,
    loop_index: usize,
    step: &Step,
    (breaks, at_least): (Option<usize>, bool),
    jump: &Break,
) -> Result {
    let times = breaks.map_or(String::new(), |count| {
        let at_least = if at_least { "at least " } else { "" };
        format!(" in {at_least}{count} place{}", plural(count))
    });
    write!(
        f,
        "{} {} breaks{times}; the largest jump, {:.3e} in q and {:.3e} in p of degree of freedom {}, is at \
         s = {:.15}",
        capitalised(&step.to_string()),
        loop_name(loop_index),
        jump.jump_q,
        jump.jump_p,
        jump.dof,
        jump.s
    )?;
    match jump.substep {
        Some(substep) => write!(
            f,
            ", made by substep {} of the map.",
            substep.saturating_add(1)
        ),
        None => f.write_str("."),
    }
}

fn fmt_scatter(f: &mut Formatter<'_>, scatter: &Scatter) -> Result {
    let Scatter {
        coordinate,
        dof,
        size,
        kind,
    } = scatter;
    match kind {
        ScatterKind::Rounding => write!(
            f,
            "Results of one state differ from batch to batch, by up to {size:.0e} in {coordinate}[{dof}]. That is rounding, as \
             in matrix products that add up in another order."
        ),
        ScatterKind::Noise => write!(
            f,
            "Results of one state differ at random, by {size:.0e} in {coordinate}[{dof}], as in parallel sums or after a \
             solver that starts at random. Figures differ from run to run by this noise."
        ),
        ScatterKind::RandomNumbers => write!(
            f,
            "Results of one state differ at random, by {size:.0e} in {coordinate}[{dof}], and rounding is smaller: the step \
             draws random numbers."
        ),
    }
}

fn fmt_precision(f: &mut Formatter<'_>, precision: &OutputPrecision) -> Result {
    let format = match precision.format {
        OutputFormat::Decimal { digits } => format!("has no more than {digits} decimal digits"),
        OutputFormat::Multiples => "takes values at equal distances".into(),
        OutputFormat::Single => "is a number of single precision".into(),
        OutputFormat::Binary { digits: 11 } => "is a number of half precision".into(),
        OutputFormat::Binary { digits: 8 } => "is a number of bfloat16".into(),
        OutputFormat::Binary { digits } => format!("has no more than {digits} binary digits"),
    };
    write!(
        f,
        "After the step {} of degree of freedom {} {format}, at every sample: the map rounds what it returns, to \
         about {:.0e}. Its states are no better than that; the loop integral averages over them.",
        precision.coordinate, precision.dof, precision.unit
    )
}

fn fmt_long_time(f: &mut Formatter<'_>, found: &LongTime, growth: Growth) -> Result {
    let LongTime {
        asked,
        steps,
        samples,
        early,
        late,
        least,
        ..
    } = found;
    match growth {
        Growth::None => write!(f, "No defect adds up in {steps} steps.")?,
        Growth::Bounded => write!(
            f,
            "In {steps} steps the defect stays bounded, {early:.1e} in the first quarter and {late:.1e} in the \
             last, and returns to {least:.1e}: as that of a method conjugate to a symplectic one."
        )?,
        Growth::Grows => write!(
            f,
            "In {steps} steps the defect adds up, from {early:.1e} in the first quarter to {late:.1e} in the \
             last."
        )?,
        Growth::Undecided => write!(
            f,
            "In {steps} steps nothing can be said of whether the defect adds up."
        )?,
    }
    if steps < asked {
        write!(
            f,
            " Of the {asked} steps that were asked for, {samples} samples resolve no more: the loop is folded too \
             finely from there on. Take a smaller loop or more samples."
        )?;
    }
    Ok(())
}

fn fmt_substeps(f: &mut Formatter<'_>, substeps: &[SubstepDefect], step: &Step) -> Result {
    let mut found = Vec::new();
    let mut others = 0.0f64;
    for substep in substeps {
        let uncertainty = substep.uncertainty.unwrap_or(f64::INFINITY);
        let changes = substep.change.abs() > SIGNIFICANT * uncertainty;
        let breaks = substep.new_breaks > 0;
        if !(changes || breaks) {
            others = others.max(substep.change.abs() + uncertainty);
            continue;
        }
        let mut text = format!(
            "substep {} ({})",
            substep.substep.saturating_add(1),
            substep.name
        );
        if breaks {
            text += " breaks the loop";
        }
        if changes {
            let and = if breaks { " and" } else { "" };
            text += &format!("{and} changes the loop integral by {:+.2e}", substep.change);
        }
        found.push(text);
    }
    let count = substeps.len();
    if found.is_empty() {
        return write!(
            f,
            "None of the {count} substeps {step} changes the loop integral significantly."
        );
    }
    let rest = match found.len() == count {
        true => String::new(),
        false if others.is_finite() => format!("; the others conserve it to {others:.1e}"),
        false => "; the changes by the others are not known".into(),
    };
    write!(
        f,
        "Of the {count} substeps {step}, {}{rest}.",
        found.join(", ")
    )
}

/// A sector that makes this part of all changes is named. Conventional.
const LARGE_SHARE: f64 = 0.4;

/// The sector that changes most, if that is more than its uncertainty.
pub(super) fn largest_sector(sectors: &[Sector]) -> Option<&Sector> {
    (sectors.iter())
        .max_by(|a, b| a.change.abs().total_cmp(&b.change.abs()))
        .filter(|sector| sector.uncertainty.is_some_and(|u| sector.change.abs() > u))
}

fn fmt_sectors(f: &mut Formatter<'_>, sectors: &[Sector], step: &Step) -> Result {
    let Some(largest) = largest_sector(sectors) else {
        return write!(
            f,
            "No sector of the disc within the loop stands out {step}."
        );
    };
    let all: f64 = sectors.iter().map(|sector| sector.change.abs()).sum();
    let share = largest.change.abs() / all;
    let (count, percent) = (sectors.len(), (100.0 * share).round());
    if share >= LARGE_SHARE {
        write!(
            f,
            "Of {count} sectors of the disc within the loop, that from s = {} to {} changes most {step}: by \
             {:+.2e}, {percent}% of the sum of all absolute changes.",
            largest.from, largest.to, largest.change
        )
    } else {
        write!(
            f,
            "The defect {step} is spread over the disc within the loop: of {count} sectors none makes more than \
             {percent}% of the sum of all absolute changes."
        )
    }
}

/// What a Sobolev exponent says of a loop that is not smooth.
pub(super) fn roughness(exponent: f64) -> Option<&'static str> {
    match exponent {
        0.25..1.0 => Some("as at jumps"),
        1.0..2.0 => Some("as at kinks"),
        2.0..4.5 => Some("as where a higher derivative jumps"),
        _ => None,
    }
}

fn moves(f: &mut Formatter<'_>, motion: &Motion, has_step_size: bool) -> Result {
    let subject = match has_step_size {
        true => "The largest step",
        false => "The map",
    };
    if motion.deformation == 0.0 && !motion.moves {
        write!(f, "{subject} leaves every state of the loops where it is.")
    } else if motion.shear {
        write!(
            f,
            "{subject} is a kick or a free flight alone, and deforms a loop by {} of its size.",
            short(motion.deformation)
        )
    } else {
        write!(
            f,
            "{subject} advances the motions on a loop by {} rad.",
            short(motion.phase_advance)
        )
    }
}

fn beyond(f: &mut Formatter<'_>, reach: &Reach, more: bool) -> Result {
    let step = &reach.step;
    match step.step_size {
        Some(_) if !more => {
            f.write_str("Larger step sizes move the loops no further: a random loop")?
        }
        Some(h) => write!(f, "At h = {} a random loop", size(h))?,
        None => write!(f, "A random loop {} times as large", short(reach.factor))?,
    }
    let moved = step.motion.filter(|moved| more && !moved.shear);
    if let Some(moved) = moved {
        write!(f, " is advanced by {} rad, and", short(moved.phase_advance))?;
    }
    match reach.shows_defect() {
        true => write!(
            f,
            " changes its integral by {:+.3e}, with an uncertainty of {:.1e}.",
            step.defect.signed,
            step.defect.uncertainty()
        ),
        false => write!(f, " is conserved to {:.1e}.", step.bound()),
    }
}

fn little_motion(f: &mut Formatter<'_>, motion: &Motion, group: Option<usize>) -> Result {
    if motion.deformation == 0.0 {
        f.write_str("The step did not move the loop, or only as a whole.")
    } else if motion.shear {
        write!(
            f,
            "The largest step is a kick or a free flight alone, and deforms a loop by only {:.1e} of its size, too \
             little to show a defect.",
            motion.deformation
        )
    } else {
        write!(
            f,
            "The largest step advances the motions on a loop{} by only {:.1e} rad, too little to show a defect.",
            match group {
                None => String::new(),
                Some(index) => format!(" of group {}", index + 1),
            },
            motion.phase_advance
        )
    }
}

/// How breaks are closed, where it is not in the substeps that cause them.
fn by_chords(straight: bool) -> &'static str {
    match straight {
        true => " by straight chords (substeps unknown)",
        false => "",
    }
}

/// The periods of these degrees of freedom.
fn periods(dofs: &[usize]) -> String {
    match dofs {
        [] => "a period".to_owned(),
        dofs => format!("the period of {}", degrees_of_freedom(dofs)),
    }
}
