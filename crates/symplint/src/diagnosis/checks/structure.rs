//! Whether steps back undo a step: time reversibility and symmetry.

use super::{GivenLoop, Runner, if_possible};
use crate::diagnosis::limits::{ROUNDINGS_OF_A_RETURN, STATES_OF_A_RETURN};
use crate::error::Error;
use crate::evidence::{ReturnDefect, StructureEvidence};
use crate::jacobian::parameters;
use crate::map::Evaluator;
use crate::rules::Subject;
use crate::signal::nearest;
use crate::state::{Ensemble, coordinate, coordinate_mut, period};

impl Runner<'_> {
    /// Tests at a few states of the given loop whether ρ Φ_h ρ Φ_h and, if asked for, Φ_−h Φ_h return them.
    pub(super) fn structure(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let (evaluator, diagnostic) = (subject.evaluator, self.diagnostic);
        // A constraint, or a one-form, says what momenta are: to change their signs may leave the manifold.
        let reversal = match (&diagnostic.reversal, evaluator.constraint()) {
            (Some(signs), _) => Some(signs.clone()),
            (None, None) => Some(flipped_momenta(evaluator.dof())),
            (None, Some(_)) => None,
        };
        if !diagnostic.properties || !diagnostic.symmetric && reversal.is_none() {
            return Ok(());
        }
        let states = Returns::new(subject, self.plan.is_tight());
        let h = self.largest;
        let Some(after) = if_possible(states.advanced(evaluator, &states.before, h).map(Some))?
        else {
            return Ok(());
        };
        let test = |signs: &[f64], h: f64| -> Result<Option<ReturnDefect>, Error> {
            let back = states.advanced(evaluator, &with_signs(&after, signs), h);
            let back = if_possible(back.map(Some))?;
            let back = back.map(|back| with_signs(&back, signs));
            Ok(back.map(|back| states.largest_defect(evaluator, &back, &given.size.radius)))
        };
        let reversible = match reversal {
            Some(signs) => test(&signs, h)?,
            None => None,
        };
        let symmetric = match diagnostic.symmetric {
            true => test(&vec![1.0; 2 * evaluator.dof()], -h)?,
            false => None,
        };
        self.evidence.structure = Some(StructureEvidence {
            reversible,
            symmetric,
        });
        Ok(())
    }
}

/// The signs of a reversal that flips all momenta.
fn flipped_momenta(dof: usize) -> Vec<f64> {
    [vec![1.0; dof], vec![-1.0; dof]].concat()
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

/// States of the loop, each followed by one that is moved by a rounding.
struct Returns {
    s: Vec<f64>,
    before: Ensemble,
}

impl Returns {
    fn new(subject: Subject<'_>, tight: bool) -> Self {
        let (evaluator, dof) = (subject.evaluator, subject.dof());
        let s = parameters(STATES_OF_A_RETURN[usize::from(!tight)]);
        let twice: Vec<f64> = s.iter().flat_map(|&s| [s, s]).collect();
        let mut before = Ensemble::zeros(dof, twice.len());
        subject.phase_loop.sample(&twice, &mut before.block());
        let mut block = before.block();
        for c in 0..2 * dof {
            let grain = rounding(evaluator, c);
            for (k, pair) in coordinate_mut(&mut block, c)
                .chunks_exact_mut(2)
                .enumerate()
            {
                let sign = if (k + c) % 2 == 0 { 1.0 } else { -1.0 };
                pair[1] += sign * (2.0 * f64::EPSILON * pair[1].abs()).max(grain);
            }
        }
        Returns { s, before }
    }

    fn advanced(
        &self,
        evaluator: &Evaluator<'_>,
        states: &Ensemble,
        h: f64,
    ) -> Result<Ensemble, Error> {
        let mut states = states.clone();
        evaluator.advance(&mut states, h)?;
        Ok(states)
    }

    /// The largest distance between states and those that came `back`, in units of `radius`, of the coordinates whose distance
    /// exceeds its uncertainty most.
    fn largest_defect(
        &self,
        evaluator: &Evaluator<'_>,
        back: &Ensemble,
        radius: &[Vec<f64>; 2],
    ) -> ReturnDefect {
        let dof = back.dof();
        let of_coordinate = |c: usize| {
            let period = period(evaluator.coordinates(), c);
            let size = radius[c / dof][c % dof];
            let (from, to) = (coordinate(&self.before, c), coordinate(back, c));
            let distance = |k: usize| nearest(to[k] - from[k], period);
            let states = 0..self.s.len();
            let scatter = |k: usize| (distance(2 * k) - distance(2 * k + 1)).abs();
            let magnitude = from.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let unit = (f64::EPSILON * magnitude).max(rounding(evaluator, c));
            let uncertainty =
                ROUNDINGS_OF_A_RETURN * states.clone().map(scatter).fold(unit, f64::max) / size;
            let largest =
                states.max_by(|&a, &b| (distance(2 * a).abs()).total_cmp(&distance(2 * b).abs()));
            let largest = largest.unwrap_or(0);
            ReturnDefect {
                s: self.s[largest],
                coordinate: if c < dof { 'q' } else { 'p' },
                dof: c % dof,
                defect: distance(2 * largest).abs() / size,
                uncertainty,
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
