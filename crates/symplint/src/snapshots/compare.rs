//! One advanced loop against the loop before the step.

use super::Snapshot;
use super::arc_length::{ArcLength, Integrals, best};
use super::increments::Increments;
use super::pieces::{Curve, Pieces, stored_roundoff};
use crate::breaks::{Break, Jump, Roughness, find_jumps};
use crate::error::Error;
use crate::evidence::{MIN_SAMPLES_OF_SHAPE, Motion, Wrap};
use crate::map::{Grain, SamplesBefore};
use crate::rules::Defect;
use crate::rules::{LoopIntegral, OmittedCell, Rule, RuleKind};
use crate::signal::{CompensatedSum, Extent, NEGLIGIBLE, UNIT_ROUNDOFF};
use crate::state::{Coordinates, Ensemble, coordinate, in_parallel};
use crate::survey::motion;

/// A jump of this part of a coordinate's whole range is a wrap in a periodic box: samples leave a gap of up to one
/// increment at either end of it.
const MIN_WRAP: f64 = 0.98;

/// Rows count as unequally spaced if that leaves an integral with an error this many times smaller. Conventional: two digits, so that
/// noise and kinks do not choose the rule.
const MIN_GAIN: f64 = 100.0;

/// A gap with a larger error, relative to the integral, is taken for an open loop. Conventional: two digits.
const MAX_RELATIVE_ERROR: f64 = 0.01;

/// Below this error, relative to the integral, equal spacing is not questioned. Conventional: three digits less than the weakest bound.
const MAX_SPACING_ERROR: f64 = 1e-9;

/// A jump between unequally spaced rows exceeds every increment around it, each as steep as the steepest and as wide as the widest, by
/// this factor. Conventional.
const MIN_JUMP_OVER_SPACING: f64 = 4.0;

/// Cells on each side of a jump that its confirmation uses.
const CELLS_BESIDE_JUMP: usize = 10;

/// The loop before the step.
pub(super) struct InitialLoop<'a> {
    snapshot: &'a Snapshot,
    coordinates: &'a Coordinates,
    pub integral: LoopIntegral,
    /// A jump of the loop before any step: it is not a closed loop, or not unwrapped.
    pub broken: Option<Break>,
    pub wrapped: Option<Wrap>,
    windings: Vec<f64>,
    /// If the rows are not equally spaced: their arc lengths, and the integral by polynomials of each order.
    arcs: Option<(ArcLength, Integrals)>,
}

/// The effect of the jumps of one loop on its integral.
#[derive(Clone, Copy, Debug)]
pub(super) struct JumpEffect {
    /// Jumps that stay under refinement.
    pub confirmed: usize,
    /// Cells that jump.
    pub cells: usize,
    /// Contribution of the chords.
    pub chord: f64,
    /// Defect of the integral with its chords.
    pub closed_defect: Defect,
}

/// An advanced loop.
pub(super) struct LoopComparison {
    pub step_size: Option<f64>,
    pub rule: RuleKind,
    /// The integral before the step, by the same rule.
    pub initial: f64,
    pub integral: LoopIntegral,
    pub defect: Defect,
    /// If there are jumps.
    pub broken: Option<JumpEffect>,
    /// Confirmed jumps.
    pub breaks: Vec<Break>,
    /// The largest of them, as a part of the range of its coordinate.
    pub largest_jump: f64,
    pub wrapped: Option<Wrap>,
    /// How the step moves the loop.
    pub motion: Option<Motion>,
}

/// One degree of freedom as the samples show it.
struct Row {
    increments: [Increments; 2],
    roughness: [Roughness; 2],
    /// max |q|, max |p|.
    largest: [f64; 2],
    /// Rounding errors of the stored values.
    rounding: [f64; 2],
    /// What rounding makes of the integral, if it leaves few values.
    unresolved: f64,
}

impl Row {
    fn flagged(&self, samples: usize) -> Vec<bool> {
        let mut flagged = vec![false; samples];
        for jump in self.roughness.iter().flat_map(|rough| &rough.jumps) {
            flagged[jump.cell] = true;
        }
        flagged
    }

    /// Cells that only look like jumps, if rows may be missing.
    fn gaps(&self, samples: usize, may_miss: bool) -> Vec<bool> {
        let mut gaps = vec![false; samples];
        let jumps = self.roughness.iter().flat_map(|rough| &rough.jumps);
        for jump in jumps.filter(|jump| may_miss && !jump.confirmed) {
            gaps[jump.cell] = true;
        }
        gaps
    }

    fn jumps(&self) -> bool {
        self.roughness.iter().any(|rough| !rough.jumps.is_empty())
    }

    /// What an unnoticed jump would add.
    fn hidden(&self) -> f64 {
        let [q, p] = [self.roughness[0].hidden, self.roughness[1].hidden];
        self.largest[1] * q + 0.5 * q * p
    }

    fn roundoff(&self) -> f64 {
        self.unresolved + stored_roundoff(&self.increments, self.rounding)
    }

    /// Whether the values have fewer digits than double precision.
    fn is_coarse(&self) -> bool {
        let rounded = |(rounding, largest): (&f64, &f64)| *rounding > Snapshot::DOUBLE * largest;
        self.rounding.iter().zip(&self.largest).any(rounded)
    }

    /// Whether q jumps by its range where p does not jump.
    fn wrap(&self, dof: usize, row: &[f64]) -> Option<Wrap> {
        let [q, p] = &self.roughness;
        let range = Extent::of(row).length();
        let is_wrap = |jump: &&Jump| {
            jump.size.abs() >= MIN_WRAP * range
                && p.jumps.iter().all(|other| other.cell != jump.cell)
        };
        q.jumps.iter().find(is_wrap).map(|jump| Wrap {
            dof,
            period: jump.size.abs(),
        })
    }
}

/// What samples show of each degree of freedom, those `before` the step being known where they come after it.
fn rows(snapshot: &Snapshot, coordinates: &Coordinates, before: Option<&Ensemble>) -> Vec<Row> {
    let states = &snapshot.states;
    let dof = states.dof();
    // They may be decimals, or single precision, that someone stored as doubles; and the code may have read such ones.
    let value = |c: usize, k: usize| coordinate(states, c)[k];
    let before = |_| {
        before.map_or(SamplesBefore::Unknown, |before| {
            SamplesBefore::Written(before.clone())
        })
    };
    let grain = Grain::of(states.samples(), coordinates, None, value, before);
    let of_grain = |c: usize| {
        grain
            .as_ref()
            .map_or(0.0, |grain| 0.5 * grain.of_coordinate(c))
    };
    let of_row = |i: usize| {
        let largest = [i, dof + i].map(|c| Extent::of(coordinate(states, c)).magnitude());
        let stored = snapshot.unit_roundoff.max(Snapshot::DOUBLE);
        let rounding = [
            of_grain(i).max(stored * largest[0]),
            of_grain(dof + i).max(stored * largest[1]),
        ];
        let periods = [coordinates.period(i), coordinates.momentum_period(i)];
        let increments = Increments::of(states, i, periods, rounding);
        let roughness = increments
            .each_ref()
            .map(|x| find_jumps(&x.values, x.floor));
        Row {
            largest,
            rounding,
            unresolved: (grain.as_ref()).map_or(0.0, |grain| grain.of_unresolved(i)),
            increments,
            roughness,
        }
    };
    in_parallel(0..dof, 2 * states.samples(), of_row)
}

fn breaks(rows: &[Row], samples: usize, wanted: impl Fn(&Jump) -> bool) -> Vec<Break> {
    let mut found = Vec::new();
    for (dof, row) in rows.iter().enumerate() {
        let [q, p] = &row.roughness;
        let size = |jumps: &[Jump], cell: usize| {
            let here = jumps.iter().find(|jump| jump.cell == cell);
            here.map_or(0.0, |jump| jump.size)
        };
        let mut cells: Vec<usize> = (q.jumps.iter().chain(&p.jumps))
            .filter(|jump| wanted(jump))
            .map(|jump| jump.cell)
            .collect();
        cells.sort_unstable();
        cells.dedup();
        found.extend(cells.into_iter().map(|cell| Break {
            s: (cell as f64 + 0.5) / samples as f64,
            uncertainty: 0.5 / samples as f64,
            dof,
            jump_q: size(&q.jumps, cell),
            jump_p: size(&p.jumps, cell),
            substep: None,
        }));
    }
    found
}

fn largest_jump(rows: &[Row], states: &Ensemble) -> f64 {
    let of = |rough: &Roughness, row: &[f64]| {
        let range = Extent::of(row).length();
        let confirmed = rough.jumps.iter().filter(|jump| jump.confirmed);
        confirmed.fold(0.0, |m: f64, jump| m.max(jump.size.abs() / range))
    };
    let each = rows.iter().enumerate().map(|(dof, row)| {
        let [q, p] = &row.roughness;
        of(q, states.q().row(dof)).max(of(p, states.p().row(dof)))
    });
    each.fold(0.0, f64::max)
}

fn wrap(rows: &[Row], states: &Ensemble, coordinates: &Coordinates) -> Option<Wrap> {
    (0..rows.len())
        .filter(|&dof| coordinates.period(dof) == 0.0)
        .find_map(|dof| rows[dof].wrap(dof, states.q().row(dof)))
}

/// The pseudospectral integral with the error that belongs to stored values.
fn smooth(
    snapshot: &Snapshot,
    rows: &[Row],
    coordinates: &Coordinates,
) -> Result<LoopIntegral, Error> {
    let states = &snapshot.states;
    let mut integral = LoopIntegral::in_coordinates(states, &Rule::Pseudospectral, coordinates)?;
    let weighted = |of: &dyn Fn(&Row) -> f64| -> f64 {
        let terms = rows.iter().enumerate();
        terms
            .map(|(dof, row)| coordinates.weight(dof).abs() * of(row))
            .sum()
    };
    if rows.iter().any(Row::is_coarse) {
        integral.roundoff += weighted(&Row::roundoff);
    }
    let unresolved = (rows.iter().flat_map(|row| &row.roughness)).any(|rough| rough.unresolved);
    integral.quadrature_error = (integral.quadrature_error)
        .filter(|_| !unresolved && states.samples() >= MIN_SAMPLES_OF_SHAPE)
        .map(|error| error + weighted(&Row::hidden));
    Ok(integral)
}

impl<'a> InitialLoop<'a> {
    pub fn new(snapshot: &'a Snapshot, coordinates: &'a Coordinates) -> Result<Self, Error> {
        let rows = rows(snapshot, coordinates, None);
        let integral = smooth(snapshot, &rows, coordinates)?;
        let found = breaks(&rows, snapshot.states.samples(), |_| true);
        let mut initial = InitialLoop {
            snapshot,
            coordinates,
            integral,
            broken: found.first().copied(),
            wrapped: wrap(&rows, &snapshot.states, coordinates),
            windings: rows.iter().map(|row| row.increments[0].gain).collect(),
            arcs: None,
        };
        initial.look_at_spacing(&rows)?;
        if initial.broken.is_some() {
            // The integral of a loop that is not closed has no known error.
            initial.integral.quadrature_error = None;
        }
        Ok(initial)
    }

    /// Interpolates the loop in its arc length if its rows are not equally spaced: it is closed then.
    fn look_at_spacing(&mut self, rows: &[Row]) -> Result<(), Error> {
        let states = &self.snapshot.states;
        let error = self.integral.quadrature_error.unwrap_or(f64::INFINITY);
        let is_exact =
            self.broken.is_none() && error <= MAX_SPACING_ERROR * self.integral.value.abs();
        if is_exact || states.samples() < MIN_SAMPLES_OF_SHAPE {
            return Ok(());
        }
        let Some(arcs) = ArcLength::of(states, self.coordinates) else {
            return Ok(());
        };
        let found = self.interpolated(&arcs, states, rows)?;
        let Some((integral, _)) = best(&found, &found) else {
            return Ok(());
        };
        let smaller = integral.quadrature_error.unwrap_or(f64::INFINITY);
        // Of a loop that jumps, equal spacing is out of the question.
        let gain = if self.broken.is_some() { 1.0 } else { MIN_GAIN };
        if gain * smaller < error && smaller < MAX_RELATIVE_ERROR * integral.value.abs() {
            (self.broken, self.wrapped) = (None, None);
            self.arcs = Some((arcs, found));
            self.integral = integral;
        }
        Ok(())
    }

    /// The widest gap between neighbouring rows as a part of the loop, if they are not equally spaced.
    pub fn widest_gap(&self) -> Option<f64> {
        self.arcs.as_ref().map(|(arcs, _)| arcs.widest())
    }

    /// The integral of a loop in arc length, with the errors that belong to stored values.
    fn interpolated(
        &self,
        arcs: &ArcLength,
        states: &Ensemble,
        rows: &[Row],
    ) -> Result<Integrals, Error> {
        let mut integrals = arcs.integrals(states, self.coordinates)?;
        for integral in integrals.iter_mut().flatten() {
            for (dof, row) in rows.iter().enumerate() {
                integral.roundoff += self.coordinates.weight(dof).abs() * row.roundoff();
            }
        }
        Ok(integrals)
    }

    /// Leaves of the jumps those that lost rows do not explain.
    fn confirm_jumps(&self, arcs: &ArcLength, rows: &mut [Row]) {
        let around = |cell: usize, n: usize| {
            (0..=2 * CELLS_BESIDE_JUMP)
                .map(move |j| (cell + n * CELLS_BESIDE_JUMP + j - CELLS_BESIDE_JUMP) % n)
        };
        for row in rows {
            for (increments, roughness) in row.increments.iter().zip(&mut row.roughness) {
                let values = &increments.values;
                for jump in &mut roughness.jumps {
                    let widest = around(jump.cell, values.len())
                        .map(|k| arcs.width(k))
                        .fold(0.0, f64::max);
                    let steepest = around(jump.cell, values.len())
                        .filter(|&k| k != jump.cell)
                        .map(|k| values[k].abs() / arcs.width(k))
                        .fold(0.0, f64::max);
                    jump.confirmed &= jump.size.abs() > MIN_JUMP_OVER_SPACING * steepest * widest;
                }
            }
        }
    }

    /// Integrates an advanced loop and takes its defect.
    pub fn compare(&self, after: &Snapshot) -> Result<LoopComparison, Error> {
        let mut rows = rows(after, self.coordinates, Some(&self.snapshot.states));
        if let Some((arcs, _)) = &self.arcs {
            self.confirm_jumps(arcs, &mut rows);
        }
        let confirmed = |row: &Row| {
            let jumps = row.roughness.iter().flat_map(|rough| &rough.jumps);
            jumps.clone().any(|jump| jump.confirmed)
        };
        let mut compared = match &self.arcs {
            Some((arcs, before)) if !rows.iter().any(confirmed) => {
                let found = self.interpolated(arcs, &after.states, &rows)?;
                match best(before, &found) {
                    Some((initial, integral)) => {
                        self.without_jumps(after, RuleKind::Piecewise, &initial, integral)?
                    }
                    None => {
                        let mut integral = smooth(after, &rows, self.coordinates)?;
                        integral.quadrature_error = None;
                        let rule = RuleKind::Pseudospectral;
                        self.without_jumps(after, rule, &self.integral, integral)?
                    }
                }
            }
            None if !rows.iter().any(Row::jumps) => {
                let integral = smooth(after, &rows, self.coordinates)?;
                self.without_jumps(after, RuleKind::Pseudospectral, &self.integral, integral)?
            }
            _ => self.across_jumps(after, &rows)?,
        };
        // No continuous map changes how often a loop winds. Gains are whole numbers of periods, to round-off.
        let winds = |(row, before): (&Row, &f64)| {
            let change = (row.increments[0].gain - before).abs();
            change > NEGLIGIBLE * before.abs().max(row.increments[0].gain.abs())
        };
        if rows.iter().zip(&self.windings).any(winds) {
            compared.integral.quadrature_error = None;
            compared.defect = Defect::between(&self.integral, &compared.integral)?;
        }
        Ok(compared)
    }

    fn without_jumps(
        &self,
        after: &Snapshot,
        rule: RuleKind,
        initial: &LoopIntegral,
        integral: LoopIntegral,
    ) -> Result<LoopComparison, Error> {
        Ok(LoopComparison {
            step_size: after.step_size,
            rule,
            initial: initial.value,
            defect: Defect::between(initial, &integral)?,
            integral,
            broken: None,
            breaks: Vec::new(),
            largest_jump: 0.0,
            wrapped: None,
            motion: motion(&self.snapshot.states, &after.states, self.coordinates),
        })
    }

    fn across_jumps(&self, after: &Snapshot, rows: &[Row]) -> Result<LoopComparison, Error> {
        let (states, _) = after.states.unwrap_momenta(self.coordinates);
        let samples = states.samples();
        let of_row = |(dof, row): (usize, &Row)| {
            let [q, p] = &row.increments;
            let curve = Curve {
                q,
                p,
                momenta: states.p().row(dof),
                flagged: &row.flagged(samples),
                gaps: &row.gaps(samples, self.arcs.is_some()),
            };
            curve.integrate()
        };
        let parts: Vec<Pieces> = in_parallel(rows.iter().enumerate(), 2 * samples, of_row);
        let found = breaks(rows, samples, |jump| jump.confirmed);
        let unresolved = (rows.iter().flat_map(|row| &row.roughness)).any(|rough| rough.unresolved);

        let (mut value, mut chord) = (CompensatedSum::default(), CompensatedSum::default());
        let (mut error, mut closed_error) = (0.0, 0.0);
        let (mut roundoff, mut scale) = (0.0, 0.0);
        let mut contributions = Vec::with_capacity(rows.len());
        for (dof, (part, row)) in parts.iter().zip(rows).enumerate() {
            let weight = self.coordinates.weight(dof);
            let size = weight.abs();
            contributions.push(weight * part.continuous);
            value.add(weight * part.continuous);
            chord.add(weight * part.chord);
            error += size * (part.error + row.hidden());
            closed_error += size * (part.closed_error + row.hidden());
            if found.is_empty() {
                // All may be steep flanks that belong to the integral.
                error += size * part.steep;
            }
            scale += size * part.scale;
            roundoff += size * (row.roundoff() + 2.0 * UNIT_ROUNDOFF * part.scale);
        }
        let total = value.total() + chord.total();
        if !(total.abs() + scale + error + roundoff).is_finite() {
            return Err(Error::Overflow {
                dof: contributions
                    .iter()
                    .position(|c| !c.is_finite())
                    .unwrap_or(0),
                value: total,
            });
        }
        let cells = |(dof, row): (usize, &Row)| {
            let flagged = row.flagged(samples);
            (0..samples)
                .filter(move |&cell| flagged[cell])
                .map(move |cell| OmittedCell { dof, cell })
        };
        let omitted: Vec<OmittedCell> = rows.iter().enumerate().flat_map(cells).collect();
        let known = !unresolved && samples >= MIN_SAMPLES_OF_SHAPE;
        let integral = LoopIntegral {
            value: value.total(),
            contributions,
            quadrature_error: known.then_some(error),
            roundoff,
            scale,
            omitted: Some(omitted),
            regularity: None,
        };
        let closed = LoopIntegral {
            value: total,
            quadrature_error: known.then_some(closed_error),
            ..integral.clone()
        };
        Ok(LoopComparison {
            step_size: after.step_size,
            rule: RuleKind::JumpDetecting,
            initial: self.integral.value,
            defect: Defect::between(&self.integral, &integral)?,
            broken: Some(JumpEffect {
                confirmed: found.len(),
                cells: integral.omitted.as_ref().map_or(0, Vec::len),
                chord: chord.total(),
                closed_defect: Defect::between(&self.integral, &closed)?,
            }),
            integral,
            largest_jump: largest_jump(rows, &states),
            breaks: found,
            wrapped: wrap(rows, &states, self.coordinates),
            motion: motion(&self.snapshot.states, &after.states, self.coordinates),
        })
    }
}
