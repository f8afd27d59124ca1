//! Whether steps back undo a step, time reversibility and symmetry, and whether a step conserves the energy.

use super::{GivenLoop, Runner, failed, if_possible};
use crate::diagnosis::limits::{
    DIVISOR_OF_STRUCTURE, STATES_OF_RETURN, STATES_OF_ROUNDING, STEP_SIZES_OF_ENERGY,
};
use crate::diagnosis::plan::fits;
use crate::error::Error;
use crate::evidence::{
    Check, EnergyAtStep, EnergyChange, OmissionReason, ReturnDefect, StructureEvidence,
};
use crate::loops::FEW_SAMPLES;
use crate::map::{self, Evaluator};
use crate::rules::Subject;
use crate::signal::noise::SAFETY;
use crate::signal::{SIGNIFICANT, nearest, parameters};
use crate::state::{Ensemble, coordinate, coordinate_mut, period};
use crate::trace::Observable;

impl Runner<'_> {
    /// Tests at states of the given loop and inside it whether ρ Φ_h ρ Φ_h and, if asked for, Φ_−h Φ_h return them.
    pub(super) fn structure(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let (evaluator, diagnostic) = (subject.evaluator, self.diagnostic);
        if !diagnostic.properties {
            return Ok(());
        }
        let on_manifold = evaluator.constraint().is_some();
        let mut structure = StructureEvidence {
            dof: evaluator.dof(),
            steps: 1,
            on_manifold,
            given_reversal: diagnostic.reversal.is_some() || evaluator.reversal().is_some(),
            // A map without a step size takes no step back.
            asked_for_symmetry: diagnostic.symmetric && diagnostic.has_step_size,
            ..StructureEvidence::default()
        };
        self.evidence.structure = Some(structure);
        // Momenta that a constraint or a one-form defines cannot change their signs alone.
        let reversal = match (&diagnostic.reversal, evaluator.reversal()) {
            (Some(signs), _) => Some(ReversalMap::Signs(signs.clone())),
            (None, Some(function)) => Some(ReversalMap::Function(function)),
            (None, None) => {
                (!on_manifold).then(|| ReversalMap::Signs(flipped_momenta(evaluator.dof())))
            }
        };
        let energy = evaluator.energy();
        if reversal.is_none() && !structure.asked_for_symmetry && energy.is_none() {
            return Ok(());
        }
        let few = self.plan.is_tight() || !fits(evaluator.dof(), FEW_SAMPLES);
        let is_asked_for =
            structure.asked_for_symmetry || structure.given_reversal || energy.is_some();
        let states = STATES_OF_RETURN[usize::from(!few)] + STATES_OF_ROUNDING[usize::from(!few)];
        if !is_asked_for && 2 * states > self.count.budget() / DIVISOR_OF_STRUCTURE {
            return Ok(());
        }
        let returns = ReturnTest::new(subject, few);
        let h = self.largest;
        let after = advanced(evaluator, &returns.before, h)?;
        structure.states = returns.s.len();
        if let Some(energy) = energy {
            structure.energy = returns.energy_change(&energy, &after);
            if structure.energy.is_none() {
                let reason = "the energy of a state on the loop or after a step is not finite";
                self.omit(
                    Check::Structure,
                    OmissionReason::Failed {
                        step_size: None,
                        reason: reason.into(),
                    },
                );
            }
        }
        let radius = &given.size.radius;
        let test = |reversal: &ReversalMap<'_>, h: f64| -> Result<ReturnDefect, Error> {
            let back = advanced(evaluator, &reversal.of(&after)?, h)?;
            let back = reversal.of(&back)?;
            Ok(returns.largest_defect(evaluator, [&after, &back], radius))
        };
        let symmetric = structure.asked_for_symmetry;
        let symmetric = symmetric.then(|| test(&ReversalMap::Identity, -h));
        let reversible = reversal.map(|reversal| {
            returns.check_reversal(evaluator, &reversal, radius)?;
            test(&reversal, h)
        });
        for (found, tested) in [
            (&mut structure.reversible, reversible),
            (&mut structure.symmetric, symmetric),
        ] {
            match tested.transpose() {
                Err(error) if error.is_of_map() => self.omit(Check::Structure, failed(&error)),
                Err(Error::BudgetSpent { .. }) => {
                    self.omit(Check::Structure, OmissionReason::BUDGET)
                }
                tested => *found = tested?,
            }
        }
        // The leading term may vanish at a few states.
        if let (Some(energy), Some(known), false) = (energy, structure.energy, few) {
            let smaller = smaller_sizes(self.sizes(), h);
            let found = returns.by_step_size(evaluator, &known, (&energy, h, &smaller));
            structure.energy = Some(EnergyChange {
                by_step_size: if_possible(found)?,
                ..known
            });
        }
        self.evidence.structure = Some(structure);
        Ok(())
    }
}

/// The step sizes below `largest`, the largest first, at which the order of the change of the energy is measured: few, as the change
/// falls below rounding.
fn smaller_sizes(sizes: impl Iterator<Item = f64>, largest: f64) -> Vec<f64> {
    let mut smaller: Vec<f64> = sizes.filter(|h| h.abs() < largest.abs()).collect();
    smaller.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    smaller.truncate(STEP_SIZES_OF_ENERGY);
    smaller
}

/// The signs of a reversal that flips all momenta.
fn flipped_momenta(dof: usize) -> Vec<f64> {
    [vec![1.0; dof], vec![-1.0; dof]].concat()
}

/// A map of states that reverses time.
enum ReversalMap<'a> {
    /// Time runs backwards by itself.
    Identity,
    /// The signs of all coordinates.
    Signs(Vec<f64>),
    /// A function of the user.
    Function(&'a map::Reversal<'a>),
}

impl ReversalMap<'_> {
    /// The reversed states.
    fn of(&self, states: &Ensemble) -> Result<Ensemble, Error> {
        match self {
            ReversalMap::Identity => Ok(states.clone()),
            ReversalMap::Signs(signs) => Ok(with_signs(states, signs)),
            ReversalMap::Function(function) => {
                let mut states = states.clone();
                function(&mut states.block());
                states.check_finite(None)?;
                Ok(states)
            }
        }
    }
}

/// All states with these signs of their coordinates.
fn with_signs(states: &Ensemble, signs: &[f64]) -> Ensemble {
    let mut states = states.clone();
    let mut block = states.block();
    for (c, sign) in signs.iter().enumerate() {
        let row = coordinate_mut(&mut block, c);
        row.iter_mut().for_each(|x| *x *= sign);
    }
    states
}

fn advanced(evaluator: &Evaluator<'_>, states: &Ensemble, h: f64) -> Result<Ensemble, Error> {
    let mut states = states.clone();
    evaluator.advance(&mut states, h)?;
    Ok(states)
}

/// States on the loop and inside it. The first few stand once more at the end, each moved by a rounding.
struct ReturnTest {
    s: Vec<f64>,
    before: Ensemble,
}

impl ReturnTest {
    fn new(subject: Subject<'_>, few: bool) -> Self {
        let (evaluator, dof) = (subject.evaluator, subject.dof());
        let s = parameters(STATES_OF_RETURN[usize::from(!few)]);
        let moved = STATES_OF_ROUNDING[usize::from(!few)];
        let mut on_loop = Ensemble::zeros(dof, s.len());
        subject.phase_loop.sample(&s, &mut on_loop.block());
        let mut before = Ensemble::zeros(dof, s.len() + moved);
        let mut block = before.block();
        for c in 0..2 * dof {
            let grain = rounding(evaluator, c);
            let row = coordinate(&on_loop, c);
            let middle = row.iter().sum::<f64>() / row.len() as f64;
            let inwards = |k: usize| match evaluator.constraint() {
                // The inside of the loop need not lie on the manifold.
                Some(_) => 0.0,
                None => 0.75 * k as f64 / row.len() as f64,
            };
            for (k, value) in coordinate_mut(&mut block, c).iter_mut().enumerate() {
                let of = k % row.len();
                *value = row[of] + inwards(of) * (middle - row[of]);
                if k >= row.len() {
                    let sign = if (k + c).is_multiple_of(2) { 1.0 } else { -1.0 };
                    *value += sign * (2.0 * f64::EPSILON * value.abs()).max(grain);
                }
            }
        }
        ReturnTest { s, before }
    }

    /// The change of the energy, known at the largest step size, at smaller ones: at the three smallest where it is significant.
    fn by_step_size(
        &self,
        evaluator: &Evaluator<'_>,
        known: &EnergyChange,
        (energy, largest, smaller): (Observable<'_>, f64, &[f64]),
    ) -> Result<Option<[EnergyAtStep; 3]>, Error> {
        let at = |step_size: f64, found: &EnergyChange| EnergyAtStep {
            step_size,
            change: found.change * found.range / known.range,
            uncertainty: found.uncertainty * found.range / known.range,
        };
        let is_significant = |of: &EnergyAtStep| of.change > SIGNIFICANT * of.uncertainty;
        let mut found = vec![at(largest, known)];
        let mut sizes = smaller.iter();
        while found.last().is_some_and(is_significant)
            && let Some(&h) = sizes.next()
        {
            let after = advanced(evaluator, &self.before, h)?;
            let Some(change) = self.energy_change(energy, &after) else {
                return Ok(None);
            };
            found.push(at(h, &change));
        }
        found.retain(is_significant);
        Ok(found.last_chunk().copied())
    }

    /// The largest change of the energy from the states to those after a step; `None` if an energy is not finite.
    fn energy_change(&self, energy: Observable<'_>, after: &Ensemble) -> Option<EnergyChange> {
        let of = |states: &Ensemble| {
            let mut energies = vec![f64::NAN; states.samples()];
            energy(states.q(), states.p(), &mut energies);
            energies
        };
        let (from, to) = (of(&self.before), of(after));
        let change = |k: usize| to[k] - from[k];
        let states = self.s.len();
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |a: f64, b| a.max(b.abs()));
        if from.iter().chain(&to).any(|energy| !energy.is_finite()) {
            return None;
        }
        let above = from.iter().map(|energy| energy - from[0]);
        let range = above.clone().fold(0.0, f64::max) - above.fold(0.0, f64::min);
        let rounding = f64::EPSILON * largest(&mut from.iter().chain(&to).copied());
        let mut moved = (states..from.len()).map(|k| change(k) - change(k - states));
        let scatter = largest(&mut moved);
        // All states of one energy: then its rounding is the scale.
        let range = range.max(rounding).max(f64::MIN_POSITIVE);
        Some(EnergyChange {
            change: largest(&mut (0..states).map(change)) / range,
            uncertainty: SAFETY * scatter.max(rounding) / range,
            range,
            by_step_size: None,
        })
    }

    /// Refuses a function that is not its own inverse.
    fn check_reversal(
        &self,
        evaluator: &Evaluator<'_>,
        reversal: &ReversalMap<'_>,
        radius: &[Vec<f64>; 2],
    ) -> Result<(), Error> {
        let ReversalMap::Function(_) = reversal else {
            return Ok(());
        };
        let once = reversal.of(&self.before)?;
        let found = self.largest_defect(evaluator, [&once, &reversal.of(&once)?], radius);
        if found.defect > SIGNIFICANT * found.uncertainty {
            return Err(Error::OutOfRange {
                what: "distance of a state, in radii of the loop, from the state that the reversal makes of it twice",
                value: found.defect,
                remedy: "give a reversal that is its own inverse",
            });
        }
        Ok(())
    }

    /// The largest distance between the states and those that came back, in units of `radius`, of the coordinates whose distance
    /// exceeds its uncertainty most. `images` are the states after the step, and those that came back.
    fn largest_defect(
        &self,
        evaluator: &Evaluator<'_>,
        images: [&Ensemble; 2],
        radius: &[Vec<f64>; 2],
    ) -> ReturnDefect {
        let (dof, states) = (self.before.dof(), self.s.len());
        let of_coordinate = |c: usize| {
            let period = period(evaluator.coordinates(), c);
            let size = radius[c / dof][c % dof];
            let (from, to) = (coordinate(&self.before, c), coordinate(images[1], c));
            let distance = |k: usize| nearest(to[k] - from[k], period);
            let moved = states..self.before.samples();
            let scatter = moved.map(|k| (distance(k) - distance(k - states)).abs());
            let on_the_way = [from, coordinate(images[0], c), to].concat();
            let magnitude = on_the_way.iter().fold(size, |most, x| most.max(x.abs()));
            let unit = (f64::EPSILON * magnitude).max(rounding(evaluator, c));
            let largest = (0..states)
                .max_by(|&a, &b| distance(a).abs().total_cmp(&distance(b).abs()))
                .unwrap_or(0);
            ReturnDefect {
                s: self.s[largest],
                coordinate: if c < dof { 'q' } else { 'p' },
                dof: c % dof,
                defect: distance(largest).abs() / size,
                uncertainty: SAFETY * scatter.fold(unit, f64::max) / size,
            }
        };
        let excess = |of: &ReturnDefect| of.defect / of.uncertainty;
        let all = (0..2 * dof).map(of_coordinate);
        all.reduce(|a, b| if excess(&b) > excess(&a) { b } else { a })
            .expect("a map has a degree of freedom")
    }
}

/// By how much rounding and noise of a map of few digits move a coordinate; 0 if it has all digits.
fn rounding(evaluator: &Evaluator<'_>, c: usize) -> f64 {
    let grain = evaluator
        .grain()
        .map_or(0.0, |grain| grain.of_coordinate(c));
    let inside = evaluator.rounding_inside().map_or(0.0, |units| units[c]);
    let noise = evaluator.noise().map_or(0.0, |deviations| deviations[c]);
    grain.max(inside).max(noise)
}
