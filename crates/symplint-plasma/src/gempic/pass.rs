//! The flows that move particles, H_p1 and H_p2, any number of them in one pass over the particles.
//!
//! Neither flow changes the potentials, and what particles do to the fields is not felt before the pass is over.

use std::ops::Range;

use multiversion::multiversion;
use symplint::Block;
use symplint::state::RowsMut;
use symplint::state::scratch::with_buffer;

use super::part::{ACROSS, ALONG};
use super::particles::Particles;
use super::polynomials::{add_moments, slope, value, value_of_one};
use symplint_models::PartFlow;

/// Samples that are taken through a pass side by side: their coordinates share cache lines.
const GROUP: usize = 8;

/// One pass over the particles of a group of samples.
struct Pass<'a> {
    h: f64,
    sequence: &'a [PartFlow],
    layout: Layout,
    group: Range<usize>,
}

/// The start of the tables of one sample, in polynomials: first A1 and A2 on the cells, then moments of the charge
/// before and after every flow along x, then moments of the current of every flow across, then displacements.
#[derive(Clone, Copy)]
struct Layout {
    cells: usize,
    charges: usize,
    currents: usize,
    len: usize,
}

impl Layout {
    fn new(cells: usize, sequence: &[PartFlow]) -> Self {
        let along = sequence.iter().filter(|flow| flow.part == ALONG).count();
        // Without a flow along x no charge moves.
        let positions = if along > 0 { along + 1 } else { 0 };
        let charges = 2 * cells;
        let currents = charges + positions * cells;
        Layout {
            cells,
            charges,
            currents,
            len: currents + (sequence.len() - along) * cells,
        }
    }

    /// Whether there is a flow along x.
    fn follows_charge(&self) -> bool {
        self.currents > self.charges
    }
}

impl<const N: usize> Particles<N> {
    /// The flows `sequence` of a step of size `h`, each of them H_p1 or H_p2.
    pub(super) fn pass(&self, h: f64, sequence: &[PartFlow], block: &mut Block<'_>) {
        let layout = Layout::new(self.grid.cells(), sequence);
        let samples = block.len();
        for first in (0..samples).step_by(GROUP) {
            let pass = Pass {
                h,
                sequence,
                layout,
                group: first..(first + GROUP).min(samples),
            };
            let tables = pass.group.len() * layout.len;
            let displacements = pass.group.len() * sequence.len();
            with_buffer(tables * N + displacements + 2 * layout.cells, |buffer| {
                let (tables, rest) = buffer.split_at_mut(tables * N);
                let (displacements, work) = rest.split_at_mut(displacements);
                let tables = tables.as_chunks_mut().0;
                self.tabulate(&pass, block, tables, work);
                displacements.fill(0.0);
                push(self, &pass, block, tables, displacements);
                self.settle(&pass, block, tables, displacements, work);
            });
        }
    }

    /// Writes the polynomials of A1 and A2 of every sample, and empties its moments.
    fn tabulate(
        &self,
        pass: &Pass<'_>,
        block: &Block<'_>,
        tables: &mut [[f64; N]],
        work: &mut [f64],
    ) {
        let layout = pass.layout;
        let (cells, particles) = (layout.cells, self.weights.len());
        let coefficients = &mut work[..cells];
        for (sample, table) in pass.group.clone().zip(tables.chunks_exact_mut(layout.len)) {
            let (potentials, moments) = table.split_at_mut(2 * cells);
            let (along, across) = potentials.split_at_mut(cells);
            for (space, first, table) in [
                (&self.one, 2 * particles, along),
                (&self.zero, 2 * particles + cells, across),
            ] {
                for (j, coefficient) in coefficients.iter_mut().enumerate() {
                    *coefficient = block.q.row(first + j)[sample];
                }
                space.expand(coefficients, table);
            }
            moments.fill([0.0; N]);
        }
    }

    /// Moves one particle of one sample: its x, its y and its momentum along x.
    #[inline(always)]
    fn push_one(
        &self,
        pass: &Pass<'_>,
        weight: f64,
        [x, y, p1]: [&mut f64; 3],
        p2: f64,
        table: &mut [[f64; N]],
        displacements: &mut [f64],
    ) {
        let layout = pass.layout;
        let (mut cell, mut fraction) = self.grid.locate(*x);
        let (mut charges, mut currents) = (layout.charges, layout.currents);
        // q A1 where the particle is; what is not used is not computed.
        let mut potential = 0.0;
        if layout.follows_charge() {
            potential = self.charge * value_of_one(&table[cell], fraction);
            add_moments(&mut table[charges + cell], weight, fraction);
        }
        for (flow, displacement) in pass.sequence.iter().zip(displacements) {
            let tau = flow.fraction * pass.h;
            if flow.part == ALONG {
                let shift = tau * self.inverse_mass * (*p1 - potential);
                *x += shift;
                *displacement += weight * shift;
                (cell, fraction) = self.grid.locate(*x);
                // The velocity is the same at both ends.
                let before = potential;
                potential = self.charge * value_of_one(&table[cell], fraction);
                *p1 += potential - before;
                charges += layout.cells;
                add_moments(&mut table[charges + cell], weight, fraction);
            } else {
                debug_assert_eq!(flow.part, ACROSS);
                let polynomial = &table[layout.cells + cell];
                let velocity = self.inverse_mass * (p2 - self.charge * value(polynomial, fraction));
                let field = self.grid.cells_per_length() * slope(polynomial, fraction);
                *y += tau * velocity;
                *p1 += tau * self.charge * velocity * field;
                add_moments(&mut table[currents + cell], weight * velocity, fraction);
                currents += layout.cells;
            }
        }
    }

    /// Adds the currents to the momenta of the fields, flow by flow.
    fn settle(
        &self,
        pass: &Pass<'_>,
        block: &mut Block<'_>,
        tables: &mut [[f64; N]],
        displacements: &[f64],
        work: &mut [f64],
    ) {
        let (sequence, layout) = (pass.sequence, pass.layout);
        let (cells, particles) = (layout.cells, self.weights.len());
        let (_, fields) = block.p.reborrow().split_at_row(2 * particles);
        let (mut along, mut across) = fields.split_at_row(cells);
        let add = |rows: &mut RowsMut<'_>, sample: usize, values: &[f64], factor: f64| {
            for (j, value) in values.iter().enumerate() {
                rows.row_mut(j)[sample] += factor * value;
            }
        };
        let sums = &mut work[..cells];
        for ((sample, table), displacements) in
            (pass.group.clone().zip(tables.chunks_exact_mut(layout.len)))
                .zip(displacements.chunks_exact(sequence.len()))
        {
            let (mut charges, mut currents) = (layout.charges, layout.currents);
            for (flow, displacement) in sequence.iter().zip(displacements) {
                if flow.part == ALONG {
                    let (before, after) = table[charges..].split_at_mut(cells);
                    for (before, after) in before.iter_mut().zip(&*after) {
                        for (before, after) in before.iter_mut().zip(after) {
                            *before = after - *before;
                        }
                    }
                    self.zero.collect(before, sums);
                    path_integrals(sums, displacement / self.grid.length());
                    add(&mut along, sample, sums, self.charge);
                    charges += cells;
                } else {
                    self.zero.collect(&table[currents..][..cells], sums);
                    add(
                        &mut across,
                        sample,
                        sums,
                        flow.fraction * pass.h * self.charge,
                    );
                    currents += cells;
                }
            }
        }
    }
}

/// Moves all particles, and sums what the fields get of them.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn push<const N: usize>(
    all: &Particles<N>,
    pass: &Pass<'_>,
    block: &mut Block<'_>,
    tables: &mut [[f64; N]],
    displacements: &mut [f64],
) {
    let particles = all.weights.len();
    let (mut xs, rest) = block.q.reborrow().split_at_row(particles);
    let (mut ys, _) = rest.split_at_row(particles);
    let (mut along, rest) = block.p.reborrow().split_at_row(particles);
    let (across, _) = rest.split_at_row(particles);
    let slices = (
        xs.as_mut_slice(),
        ys.as_mut_slice(),
        along.as_mut_slice(),
        across.as_rows().as_slice(),
    );
    // A row has one value where there is one sample: they are taken all at once.
    if let (1, (Some(xs), Some(ys), Some(along), Some(across))) = (pass.group.len(), slices)
        && xs.len() == particles
    {
        let coordinates = (xs.iter_mut().zip(ys)).zip(along.iter_mut().zip(across));
        for (((x, y), (p1, p2)), &weight) in coordinates.zip(&all.weights) {
            all.push_one(pass, weight, [x, y, p1], *p2, tables, displacements);
        }
        return;
    }
    for (a, &weight) in all.weights.iter().enumerate() {
        let (xs, ys) = (
            &mut xs.row_mut(a)[pass.group.clone()],
            &mut ys.row_mut(a)[pass.group.clone()],
        );
        let along = &mut along.row_mut(a)[pass.group.clone()];
        let across = &across.row(a)[pass.group.clone()];
        let samples = (xs.iter_mut().zip(ys)).zip(along.iter_mut().zip(across));
        let sums = (tables.chunks_exact_mut(pass.layout.len))
            .zip(displacements.chunks_exact_mut(pass.sequence.len()));
        for (((x, y), (p1, p2)), (table, displacements)) in samples.zip(sums) {
            all.push_one(pass, weight, [x, y, p1], *p2, table, displacements);
        }
    }
}

/// Turns Σ w (Λ⁰_j(x') − Λ⁰_j(x)) into D_j = Σ w ∫_x^x' Λ¹_j, whose mean is given.
///
/// Λ⁰_j' = Λ¹_j − Λ¹_j+1, so D_j − D_j+1 is what the charge changes by: Gauss' law holds by construction, whatever the
/// number of cells on the way.
fn path_integrals(changes: &mut [f64], mean: f64) {
    let (mut integral, mut sum) = (0.0, 0.0);
    for change in &mut *changes {
        let next = integral - *change;
        *change = integral;
        sum += integral;
        integral = next;
    }
    let shift = mean - sum / changes.len() as f64;
    for integral in changes {
        *integral += shift;
    }
}
