//! Why loops break, from both sides of a break.

use std::f64::consts::{PI, TAU};

use super::{Cause, CauseKind, Clues};
use crate::breaks::Break;
use crate::evidence::{BreakSides, CoordinateAtBreak, Evidence, PositionAtBreak};
use crate::signal::nearest;
use crate::text::{loop_name, short, significant, two_digits};
use crate::verdict::findings::listed;
use crate::verdict::thresholds::MIN_FLICKERING_PART;

/// Values that should be equal may differ by this part of what they are compared with. Conventional: far above rounding and the
/// distance of states from a break, and far below what chance makes equal.
const MAX_DIFFERENCE: f64 = 1e-6;

/// Exponents of a jump against the step size may be off by this much: the largest jumps at two step sizes need not be at one
/// place. Conventional: less than half of the distance of whole exponents.
const MAX_EXPONENT_ERROR: f64 = 0.4;

/// One side of a break that lies on the trajectory of the other is met to this part of the jump. Conventional: a step along the flow
/// is made in four parts, and the direction of a jump is random otherwise.
const MAX_MISS: f64 = 0.02;

/// A force that jumps moves a position by at most the change of its momentum times h over the mass, and by up to this many times as much if
/// a method has kicks outside its step, as those of order 4 have. Conventional.
const MAX_MOTION_OVER_KICK: f64 = 4.0;

/// How the jumps of a loop depend on the step size: the exponents of h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::verdict) struct JumpLaw {
    /// Of the jump of the position; infinite if it does not jump.
    pub q: f64,
    /// Of the jump of the momentum; infinite if it does not jump.
    pub p: f64,
}

impl JumpLaw {
    /// From the jumps at the largest and at the smallest step size of the loop whose break was examined, in degrees of freedom that
    /// jump there.
    pub fn of(evidence: &Evidence) -> Option<Self> {
        let sides = evidence.break_sides.as_ref()?;
        let jumps = |dof: usize| {
            let mut all = sides.coordinates.iter();
            all.any(|of| of.dof == dof && of.jumps)
        };
        let found = (evidence.loops.iter()).find(|found| found.index == sides.loop_index)?;
        let sizes = found.steps.iter().filter_map(|step| {
            let jump = step.jump.filter(|found| jumps(found.dof))?;
            Some((step.step_size?.abs(), jump.jump_q.abs(), jump.jump_p.abs()))
        });
        let mut sizes: Vec<(f64, f64, f64)> = sizes.collect();
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (small, large) = (sizes.first()?, sizes.last()?);
        if large.0 < 2.0 * small.0 {
            return None;
        }
        let exponent = |large_jump: f64, small_jump: f64| match small_jump > 0.0 {
            true => (large_jump / small_jump).ln() / (large.0 / small.0).ln(),
            false => f64::INFINITY,
        };
        Some(JumpLaw {
            q: exponent(large.1, small.1),
            p: exponent(large.2, small.2),
        })
    }
}

fn is_about(exponent: f64, whole: f64) -> bool {
    (exponent - whole).abs() <= MAX_EXPONENT_ERROR
}

impl Clues<'_> {
    /// All breaks that are known, with their step sizes.
    fn jumps(&self) -> impl Iterator<Item = (Option<f64>, Break)> {
        let of_steps = || {
            let steps = self.evidence.loops.iter().flat_map(|found| &found.steps);
            steps.filter_map(|step| Some((step.step_size, step.jump?)))
        };
        let breaks = self.evidence.breaks.iter();
        let breaks = breaks.map(|at| (at.step_size, at.found));
        of_steps().chain(breaks.filter(move |of| of_steps().all(|other| other != *of)))
    }

    fn sides(&self) -> Option<&BreakSides> {
        self.evidence.break_sides.as_ref()
    }

    /// Rounding decides on which side of many breaks a state is.
    ///
    /// A force that jumps does so at a position, which is known to its rounding, as s is; what a solver compares is as small as its
    /// tolerance, and rounding decides about it in a wide stretch.
    pub(super) fn solver_tolerance(&self) -> Option<Cause> {
        let (mut flickering, mut breaks, mut largest) = (0, 0, 0.0f64);
        for step in self.evidence.loops.iter().flat_map(|found| &found.steps) {
            let (Some(jump), Some(closing)) = (step.jump, step.closing) else {
                continue;
            };
            flickering += step.flickering;
            breaks += closing.breaks;
            largest = largest.max(jump.jump_q.abs()).max(jump.jump_p.abs());
        }
        let many = flickering > 1 && flickering as f64 >= MIN_FLICKERING_PART * breaks as f64;
        many.then(|| {
            Cause::new(
                CauseKind::SolverTolerance,
                format!(
                    "At {flickering} of {breaks} breaks (all loops and steps), rounding errors decide on which side of the jump a state \
                     falls, as in a solver that stops at a tolerance."
                ),
                format!(
                    "Tighten the tolerance of the solver until the jumps are gone. Until then, results have errors of about {}, the size \
                     of the largest jump.",
                    short(largest)
                ),
            )
        })
    }

    /// A coordinate is constant on one side.
    pub(super) fn clipped(&self) -> Option<Cause> {
        let sides = self.sides()?;
        let of = (sides.coordinates.iter()).find(|of| of.constant[0] != of.constant[1])?;
        let side = usize::from(of.constant[1]);
        let states = format!(
            "{}, {} = {} after the step at all states",
            place(sides, side),
            name(of),
            significant(of.after[side])
        );
        Some(Cause::clipped(&states, of.coordinate, of.dof))
    }

    /// One coordinate jumps, by the same length everywhere.
    pub(super) fn period(&self) -> Option<Cause> {
        let sides = self.sides()?;
        let of = sides.coordinates.first().filter(|of| of.jumps)?;
        let length = of.jump().abs();
        let of_q = of.coordinate == 'q';
        // The other coordinate of the pair may be wrapped, too, and jump at other places.
        let jumps: Vec<_> = (self.jumps())
            .filter(|(_, jump)| jump.dof == of.dof)
            .map(|(size, jump)| match of_q {
                true => (size, jump.jump_q, jump.jump_p),
                false => (size, jump.jump_p, jump.jump_q),
            })
            .filter(|(_, jump, other)| jump.abs() > MAX_DIFFERENCE * other.abs())
            .collect();
        let elsewhere: Vec<f64> = (jumps.iter())
            .map(|(_, jump, _)| *jump)
            .chain(sides.places.iter().filter(|_| of_q).map(|at| at.jump_q))
            .map(f64::abs)
            .collect();
        let same = |other: &f64| (other - length).abs() <= MAX_DIFFERENCE * length;
        // Wrapped, a coordinate lies in one period.
        let is_wrapped = of.range <= (1.0 + MAX_DIFFERENCE) * length;
        if sides.jumping != 1 || elsewhere.len() < 2 || !elsewhere.iter().all(same) || !is_wrapped {
            return None;
        }
        // Steps of one size do not tell a period from a force that jumps, unless the loop fits into the period.
        let sizes = jumps.iter().map(|(size, ..)| *size);
        if sizes.clone().all(|size| Some(size) == sizes.clone().next()) && length < of.radius {
            return None;
        }
        let dofs: Vec<usize> = (0..sides.dof)
            .filter(|&dof| dof == of.dof || self.jumps_by(of.coordinate, dof, length))
            .collect();
        let length = plainest(length, of.after);
        let setting = setting_of(of.coordinate, &dofs, sides.dof, length);
        let others = match dofs.len() == sides.dof {
            true => "",
            false => " Also state the periods of the other coordinates.",
        };
        let names = listed(dofs.iter().map(|dof| format!("{}[{dof}]", of.coordinate)));
        let value = significant(length);
        let (jump, it_is) = match dofs.len() {
            1 => ("alone jumps", "it is"),
            _ => ("jump one by one", "they are"),
        };
        let what = match (of_q, dofs.len()) {
            (true, 1) => "is an angle or a position in a periodic box of this length",
            (true, _) => "are angles or positions in a periodic box of this length",
            (false, 1) => "has this period",
            (false, _) => "have this period",
        };
        let mut cause = Cause::new(
            CauseKind::Period,
            format!("{names} {jump}, by {value} at every break: {it_is} wrapped into a period."),
            format!("If {names} {what}, state it: {setting}.{others}"),
        );
        cause.setting = Some(setting);
        Some(cause)
    }

    /// Whether this coordinate alone jumps by this length at a break of a loop.
    fn jumps_by(&self, coordinate: char, dof: usize, length: f64) -> bool {
        self.jumps().any(|(_, found)| {
            let (jump, other) = match coordinate {
                'q' => (found.jump_q, found.jump_p),
                _ => (found.jump_p, found.jump_q),
            };
            let is_alone = other.abs() <= MAX_DIFFERENCE * length;
            found.dof == dof && is_alone && (jump.abs() - length).abs() <= MAX_DIFFERENCE * length
        })
    }

    /// A momentum changes its sign where its position does not jump.
    pub(super) fn wall(&self) -> Option<Cause> {
        let sides = self.sides()?;
        let p = (sides.coordinates.iter()).find(|of| of.jumps && of.coordinate == 'p')?;
        let q = sides.coordinate('q', p.dof)?;
        let [low, high] = p.after;
        let is_reflected = match self.law {
            // Reflected within a step, a particle has moved by h·p to one side or the other, and forces have changed its momentum.
            Some(law) => {
                low * high < 0.0
                    && is_about(law.p, 0.0)
                    && (!q.jumps || law.q > 1.0 - MAX_EXPONENT_ERROR)
            }
            None => (low + high).abs() < MAX_DIFFERENCE * (high - low).abs(),
        };
        if !is_reflected || sides.jumping > 2 {
            return None;
        }
        let at = match q.jumps {
            true => String::new(),
            false => format!(
                " at {} = {} after the step",
                name(q),
                not_below(q.middle(), MAX_DIFFERENCE * q.radius)
            ),
        };
        Some(Cause::new(
            CauseKind::Wall,
            format!(
                "{} changes its sign, from {} to {}{at}, as at a wall that reflects particles.",
                name(p),
                significant(low),
                significant(high)
            ),
            format!(
                "Move the loop away from the wall, until no state reaches it in the largest step: change the centre of {}. A loop \
                 across the wall breaks with any integrator. Its integral is conserved with the breaks closed if the reflection \
                 is right.",
                name(q)
            ),
        ))
    }

    /// Both sides of the break lie on one trajectory.
    pub(super) fn chosen_step_length(&self) -> Option<Cause> {
        let sides = self.sides()?;
        let flow = sides.along_flow.filter(|flow| flow.distance <= MAX_MISS)?;
        if sides.jumping < 2 {
            return None;
        }
        Some(Cause::new(
            CauseKind::ChosenStepLength,
            format!(
                "Both sides of the break at s = {} of {} lie on one trajectory: {} of a step leads from one to the other. The step \
                 chooses its own length, which differs from state to state.",
                significant(sides.s),
                loop_name(sides.loop_index),
                significant(flow.part)
            ),
            "Ask the code to integrate to exactly t + h: a fixed step size, or a last step that ends there.",
        ))
    }

    /// Momenta jump in proportion to h.
    pub(super) fn force_jump(&self) -> Option<Cause> {
        let sides = self.sides()?;
        let kicked: Vec<&CoordinateAtBreak> = (sides.coordinates.iter())
            .filter(|of| of.jumps && of.coordinate == 'p')
            .collect();
        let first = kicked.first()?;
        let q_jumps = (sides.coordinates.iter()).any(|of| of.jumps && of.coordinate == 'q');
        let is_kick = match self.law {
            Some(law) => is_about(law.p, 1.0) && (!q_jumps || law.q > 2.0 - MAX_EXPONENT_ERROR),
            None => !q_jumps,
        };
        if !is_kick {
            return None;
        }
        let law = if self.law.is_some() {
            " in proportion to h"
        } else {
            ""
        };
        let follows = if q_jumps { " (q follows)" } else { "" };
        let (text, remedy) = match opposite_pairs(&kicked, sides) {
            Some(pairs) => {
                let names: Vec<String> = (pairs.iter())
                    .map(|(a, b)| format!("{} and {}", name(a), name(b)))
                    .collect();
                (
                    format!(
                        "{} jump by opposite amounts{law}, here ±{}{}: a force between them jumps there, as at a cut-off, in a \
                         neighbour list or in a table.",
                        names.join(", "),
                        significant(first.jump().abs()),
                        distance(sides, &pairs)
                    ),
                    "Let the pair force go to zero continuously at the cut-off (a shifted or switched potential), and keep all pairs \
                     within it in the list.",
                )
            }
            None => {
                let others = match sides.jumping_p {
                    0 | 1 if q_jumps => "jumps".to_owned(),
                    0 | 1 => "alone jumps".to_owned(),
                    2 => "and another momentum jump".to_owned(),
                    count => format!("and {} other momenta jump", count - 1),
                };
                (
                    format!(
                        "{} {others}{law}{follows}, here by {}{}: a force jumps there, as between cells, at a cut-off or at a switch.",
                        name(first),
                        significant(first.jump()),
                        where_it_jumps(sides)
                    ),
                    "Use a force that is continuous there: interpolation of higher order, a smooth switch.",
                )
            }
        };
        Some(Cause::new(CauseKind::ForceJump, text, remedy))
    }

    /// All coordinates jump, the less the smaller the step, or in ratios that no force makes.
    pub(super) fn choice_inside(&self) -> Option<Cause> {
        let sides = self.sides()?;
        let exponent = self.law.map(|law| law.q.min(law.p));
        let is_error = exponent
            .is_some_and(|exponent| exponent >= 1.0 + MAX_EXPONENT_ERROR && exponent.is_finite());
        let how = match exponent {
            _ if sides.jumping < 2 => return None,
            Some(exponent) if is_error => format!(
                "q and p jump together, like h^{exponent:.1}: less than a step moves them, as an error of the method does"
            ),
            _ => {
                let [ratio, of_motion] = self.ratios()?;
                if ratio <= MAX_MOTION_OVER_KICK * of_motion {
                    return None;
                }
                format!(
                    "q and p jump together, with Δq/Δp up to {} at one step size. A force that jumps reaches about {} there",
                    two_digits(ratio),
                    two_digits(of_motion)
                )
            }
        };
        Some(Cause::new(
            CauseKind::ChoiceInside,
            format!(
                "{how}. Something inside the step differs from state to state, such as the number of substeps or of iterations."
            ),
            "Fix the number of substeps, the order and the number of iterations. If a solver stops at a tolerance, tighten it until the \
             jumps are gone.",
        ))
    }

    /// The largest |Δq/Δp| of breaks of one degree of freedom at the step size of the break that was examined, and the largest change of
    /// its position over its momentum: h over the mass.
    fn ratios(&self) -> Option<[f64; 2]> {
        let sides = self.sides()?;
        let dof = sides.of_break;
        let [q, p] = ['q', 'p'].map(|of| {
            sides
                .coordinate(of, dof)
                .map(|of| MAX_DIFFERENCE * of.radius)
        });
        let (least_q, least_p) = (q?, p?);
        let ratios = (self.jumps())
            .filter(|(size, of)| *size == sides.step_size && of.dof == dof)
            .map(|(_, of)| of)
            .filter(|of| of.jump_q.abs() > least_q && of.jump_p.abs() > least_p)
            .map(|of| (of.jump_q / of.jump_p).abs());
        let of_motion =
            (sides.places.iter()).map(|at| ((at.after - at.before) / at.velocity).abs());
        Some([ratios.reduce(f64::max)?, of_motion.reduce(f64::max)?])
    }
}

/// Momenta that jump, in pairs of opposite amounts, if all do.
fn opposite_pairs<'a>(
    kicked: &[&'a CoordinateAtBreak],
    sides: &BreakSides,
) -> Option<Vec<(&'a CoordinateAtBreak, &'a CoordinateAtBreak)>> {
    let mut left = kicked.to_vec();
    let mut pairs = Vec::new();
    while let Some(first) = left.pop() {
        let opposite = |of: &&CoordinateAtBreak| {
            (of.jump() + first.jump()).abs() <= MAX_DIFFERENCE * first.jump().abs()
        };
        let second = left.remove(left.iter().position(opposite)?);
        pairs.push((second, first));
    }
    pairs.reverse();
    (kicked.len() == sides.jumping_p && !pairs.is_empty()).then_some(pairs)
}

/// How far apart the particles are whose momenta jump: the degrees of freedom of each pair are taken for one direction of space.
fn distance(sides: &BreakSides, pairs: &[(&CoordinateAtBreak, &CoordinateAtBreak)]) -> String {
    let of = |of: &dyn Fn(&CoordinateAtBreak) -> f64| -> Option<f64> {
        let mut sum = 0.0;
        for (a, b) in pairs {
            let [a, b] = [a.dof, b.dof].map(|dof| sides.coordinate('q', dof).map(of));
            sum += (a? - b?).powi(2);
        }
        Some(sum.sqrt())
    };
    match (of(&|q| q.before), of(&|q| q.middle())) {
        (Some(before), Some(after)) => format!(
            " at a distance of {} before the step and {} after it",
            significant(before),
            significant(after)
        ),
        _ => String::new(),
    }
}

/// The place at which a force jumps, from the states at several breaks.
fn where_it_jumps(sides: &BreakSides) -> String {
    let (Some(first), Some(q)) = (sides.places.first(), sides.coordinate('q', sides.of_break))
    else {
        return String::new();
    };
    let name = name(q);
    let (of_p, h) = (
        format!("p[{}]", sides.of_break),
        sides.step_size.unwrap_or(0.0),
    );
    let drifted = |part: f64| move |at: &PositionAtBreak| at.before + part * h * at.velocity;
    let least = MAX_DIFFERENCE * q.radius;
    // The stages of a method jump at different positions: breaks of another stage move q, and this one does not, or the reverse.
    let of_this_stage =
        |at: &&PositionAtBreak| (at.jump_q.abs() > least) == (first.jump_q.abs() > least);
    // Where splittings and Runge–Kutta methods evaluate forces.
    let each = |of: &dyn Fn(&PositionAtBreak) -> f64| -> Vec<f64> {
        (sides.places.iter().filter(of_this_stage))
            .map(of)
            .collect()
    };
    let candidates = [
        (each(&|at| at.before), name.clone(), "before"),
        (each(&|at| at.after), name.clone(), "after"),
        (
            each(&drifted(0.5)),
            format!("{name} + h/2·{of_p}"),
            "before",
        ),
        (each(&drifted(1.0)), format!("{name} + h·{of_p}"), "before"),
    ];
    for (values, expression, when) in candidates {
        let Some(width) = spacing(&values, least) else {
            continue;
        };
        if width == 0.0 {
            let value = not_below(values[0], least);
            return format!(" at {expression} = {value} {when} the step");
        }
        let first = values[0].rem_euclid(width);
        let is_multiple = nearest(first, width).abs() <= least;
        let width = significant(width);
        return match is_multiple {
            true => format!(" at multiples of {width} in {expression} {when} the step"),
            false => {
                let first = significant(first);
                format!(" at {first} + k·{width} in {expression} {when} the step")
            }
        };
    }
    let [before, after] = [first.before, first.after].map(|value| not_below(value, least));
    format!(" at {name} = {before} before the step and {after} after it")
}

/// The distance of which those of all values are multiples, 0 if all are equal; `None` if the values have none, or there are too few to
/// tell.
fn spacing(values: &[f64], least: f64) -> Option<f64> {
    let from_first = || values.iter().map(|value| (value - values[0]).abs());
    if values.len() < 2 {
        return None;
    }
    if from_first().all(|distance| distance <= least) {
        return Some(0.0);
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let width = gaps
        .filter(|&gap| gap > least)
        .fold(f64::INFINITY, f64::min);
    let is_multiple = |distance: f64| {
        let cells = distance / width;
        (cells - cells.round()).abs() * width <= least
    };
    let distinct = 1 + sorted
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > least)
        .count();
    (distinct >= 3 && from_first().all(is_multiple)).then_some(width)
}

/// `q[1]`.
fn name(of: &CoordinateAtBreak) -> String {
    format!("{}[{}]", of.coordinate, of.dof)
}

/// A value, 0 if it is less than what can be told.
fn not_below(value: f64, least: f64) -> String {
    significant(if value.abs() <= least { 0.0 } else { value })
}

/// The part of a loop next to a break.
fn place(sides: &BreakSides, side: usize) -> String {
    let beside = ["below", "above"][side];
    let (s, found) = (significant(sides.s), loop_name(sides.loop_index));
    format!("On the side of the break {beside} s = {s} of {found}")
}

/// The number of fewest digits that a period can be, as it is the difference of these values.
fn plainest(length: f64, values: [f64; 2]) -> f64 {
    let rounding = 8.0 * f64::EPSILON * values[0].abs().max(values[1].abs());
    let rounded = format!("{length:.11e}").parse().unwrap_or(length);
    let mut plain = [rounded, TAU, PI].into_iter();
    plain
        .find(|value| (value - length).abs() <= rounding)
        .unwrap_or(length)
}

/// A setting of some degrees of freedom: `period = [0, 6.283185307179586]`.
fn setting_of(letter: char, of: &[usize], dofs: usize, value: f64) -> String {
    const MAX_LISTED: usize = 32;
    let key = match letter {
        'q' => "period",
        _ => "momentum_period",
    };
    if dofs > MAX_LISTED {
        return format!(
            "{key} = {value} for {}",
            listed(of.iter().map(|dof| format!("{letter}[{dof}]")))
        );
    }
    let values = (0..dofs).map(|i| {
        if of.contains(&i) {
            value.to_string()
        } else {
            "0".into()
        }
    });
    format!("{key} = [{}]", values.collect::<Vec<_>>().join(", "))
}
