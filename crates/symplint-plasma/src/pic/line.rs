//! The force on a line: particles to nodes, charge to potential, and back; or pair by pair.

use bytemuck::cast_slice_mut;
use multiversion::multiversion;
use symplint::state::{Rows, RowsMut, scratch};

use super::by_functions::for_functions;
use super::carrier::{ByMoments, ByRuns, Carrier};
use super::field::FieldSolver;
use super::mesh::Mesh;
use super::pairs::PairTable;
use super::place::{Locator, Places, RUN};
use super::polynomials::CellPolynomials;
use super::portions::Portions;
use super::runs::Runs;

/// Samples whose particles are carried to their meshes together: rows are read this number of values at a
/// time, and sums into different meshes do not wait for each other.
pub(super) const GROUP: usize = 8;

/// Particles for each cell up to which it is faster to go without moments, at degrees 1 to 3.
const PARTICLES_PER_CELL: usize = 1;

/// If a group has no more places of particles than this, they are found once, for both ways, and stay in a cache. Far fewer than the
/// particles of a portion.
const MAX_PLACES: usize = 1 << 11;

/// Values of all tables of a group at most.
const MAX_VALUES: usize = 1 << 16;

/// The parts that a plasma on a line needs for its force, apart from the field solver.
#[derive(Clone, Debug)]
pub(super) struct LineForce {
    locator: Locator,
    cells: usize,
    polynomials: CellPolynomials,
    /// The nodes without a particle.
    background: Vec<f64>,
    portions: Portions,
    way: ForceMethod,
}

/// How the force comes about. It is chosen by the numbers of particles and cells, never by those of
/// samples: a sample has the same force to the last bit in every block.
#[derive(Clone, Debug)]
enum ForceMethod {
    Pairs(PairTable),
    /// With the background as the nodes run.
    Runs(Runs, Vec<f64>),
    Moments,
}

impl LineForce {
    pub(super) fn new<const D: usize>(
        mesh: &Mesh<D>,
        solver: &FieldSolver,
        weights: &[f64],
    ) -> Self {
        let polynomials = CellPolynomials::new(mesh);
        let mut force = LineForce {
            locator: Locator::new(*mesh.grid()),
            cells: mesh.cells(),
            portions: Portions::new(polynomials.table_len()),
            polynomials,
            background: mesh.background(weights.iter().sum()),
            way: ForceMethod::Moments,
        };
        let (particles, cells) = (weights.len(), mesh.cells());
        if particles <= PARTICLES_PER_CELL * cells {
            force.way = Self::by_runs(mesh, weights);
        }
        if PairTable::is_faster(particles, &force.polynomials, cells) {
            let backgrounds = [mesh.background(1.0), mesh.background(0.0)];
            let functions = force.polynomials.functions();
            for_functions!(functions, force.tabulate_pairs(&backgrounds, solver));
        }
        force
    }

    fn by_runs<const D: usize>(mesh: &Mesh<D>, weights: &[f64]) -> ForceMethod {
        let runs = Runs::new(mesh);
        let background = runs.in_all_cells(&mesh.background_of_cell(weights.iter().sum()));
        ForceMethod::Runs(runs, background)
    }

    fn tabulate_pairs<const N: usize>(
        &mut self,
        backgrounds: &[Vec<f64>; 2],
        solver: &FieldSolver,
    ) {
        let table = PairTable::new::<N>(self.cells, backgrounds, &self.polynomials, solver);
        self.way = ForceMethod::Pairs(table);
    }

    /// p −= τ × the gradient of the potential at the particles, for every sample.
    pub(super) fn kick(
        &self,
        solver: &FieldSolver,
        weights: &[f64],
        tau: f64,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        for_functions!(
            self.polynomials.functions(),
            self.kick_with(solver, weights, tau, q, p)
        );
    }

    fn kick_with<const N: usize>(
        &self,
        solver: &FieldSolver,
        weights: &[f64],
        tau: f64,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        match &self.way {
            ForceMethod::Pairs(pairs) => pairs.kick::<N>(&self.locator, weights, tau, q, p),
            ForceMethod::Runs(runs, background) => {
                let by = ByRuns {
                    runs,
                    background,
                    functions: runs.of::<N>(),
                };
                self.kick_by(by, solver, weights, tau, q, p);
            }
            ForceMethod::Moments => {
                let by = ByMoments::<N> {
                    cells: self.cells,
                    background: &self.background,
                    polynomials: &self.polynomials,
                };
                self.kick_by(by, solver, weights, tau, q, p);
            }
        }
    }

    /// Kicks all samples by tables.
    fn kick_by(
        &self,
        carrier: impl Carrier,
        solver: &FieldSolver,
        weights: &[f64],
        tau: f64,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        // Tables of a whole group must fit into a cache, and with many cells into memory.
        let grouped = GROUP * self.polynomials.table_len() <= MAX_VALUES;
        let whole = if grouped { q.len() / GROUP * GROUP } else { 0 };
        for first in (0..whole).step_by(GROUP) {
            self.kick_group::<GROUP>(carrier, solver, weights, tau, first, q, p);
        }
        for first in whole..q.len() {
            self.kick_group::<1>(carrier, solver, weights, tau, first, q, p);
        }
    }

    /// Kicks `W` neighbouring samples, from sample `first` on.
    #[allow(
        clippy::too_many_arguments,
        reason = "what a kick has, and where it is"
    )]
    fn kick_group<const W: usize>(
        &self,
        carrier: impl Carrier,
        solver: &FieldSolver,
        weights: &[f64],
        tau: f64,
        first: usize,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        let len = carrier.table_len();
        let all = 0..weights.len();
        let wanted = W * all.len();
        let kept = if wanted <= MAX_PLACES { wanted } else { 0 };
        let size = W * len + carrier.work_len() + kept + kept.div_ceil(2);
        scratch::with_buffer(size, |buffer| {
            let (tables, work) = buffer.split_at_mut(W * len);
            let (work, kept_places) = work.split_at_mut(carrier.work_len());
            let (fractions, cells) = kept_places.split_at_mut(kept);
            let places = (kept > 0).then(|| {
                let cells = cast_slice_mut(cells);
                (self.locator).places::<W>(q, first, all.clone(), cells, fractions)
            });
            (self.portions).sum(all.clone(), tables, &|portion, tables| {
                for table in tables.chunks_exact_mut(len) {
                    carrier.clear(table, portion.start == 0);
                }
                match places {
                    Some(places) => {
                        debug_assert_eq!(portion.len(), weights.len());
                        deposit(carrier, places, weights, tables);
                    }
                    None => self.locator.each_run(q, first, portion, |a, places| {
                        deposit::<_, W>(carrier, places, &weights[a..], tables);
                    }),
                }
            });
            for table in tables.chunks_exact_mut(len) {
                carrier.solve(table, work, |nodes| solver.solve(nodes));
            }
            let tables = &*tables;
            (self.portions).each::<1>(all, p.reborrow(), &|portion, mut p| {
                let (start, mut gradients) = (portion.start, [0.0; RUN]);
                let mut gather = |a: usize, places: Places<'_, W>| {
                    let at = [a - start, first];
                    gather(carrier, places, tables, tau, &mut gradients, at, &mut p);
                };
                match places {
                    Some(places) => places.runs().for_each(|(a, places)| gather(a, places)),
                    None => self.locator.each_run(q, first, portion, gather),
                }
            });
        });
    }
}

/// Adds particles to the tables of their samples, which lie one after the other.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn deposit<C: Carrier, const W: usize>(
    carrier: C,
    places: Places<'_, W>,
    weights: &[f64],
    tables: &mut [f64],
) {
    let len = carrier.table_len();
    for ((cells, fractions), &weight) in places.iter().zip(weights) {
        for sample in 0..W {
            let table = &mut tables[sample * len..][..len];
            carrier.add(table, cells[sample], weight, fractions[sample]);
        }
    }
}

/// p −= τ × the gradients at particles, a run at most, by the tables of their samples. The first particle and sample are this row of `p` and
/// this place of it. All gradients are stored before they are subtracted: a processor waits if it loads a vector whose numbers it
/// has just stored one by one.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn gather<C: Carrier, const W: usize>(
    carrier: C,
    places: Places<'_, W>,
    tables: &[f64],
    tau: f64,
    gradients: &mut [f64; RUN],
    [first_row, first_sample]: [usize; 2],
    p: &mut RowsMut<'_>,
) {
    let len = carrier.table_len();
    let (gradients, _) = gradients.as_chunks_mut::<W>();
    for ((cells, fractions), gradients) in places.iter().zip(&mut *gradients) {
        for sample in 0..W {
            let table = &tables[sample * len..][..len];
            gradients[sample] = carrier.gradient(table, cells[sample], fractions[sample]);
        }
    }
    for (i, (_, gradients)) in places.iter().zip(gradients).enumerate() {
        let row = &mut p.row_mut(first_row + i)[first_sample..][..W];
        for (v, gradient) in row.iter_mut().zip(gradients) {
            *v -= tau * *gradient;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pairs::LARGE_GROUP;
    use super::super::shape::{Shape, ShapeFamily};
    use super::*;

    fn shapes() -> impl Iterator<Item = Shape> {
        [ShapeFamily::BSpline, ShapeFamily::Lagrange]
            .into_iter()
            .flat_map(|family| {
                (1..=family.highest_degree()).map(move |p| Shape::new(family, p).unwrap())
            })
    }

    /// A plasma by all ways.
    struct Line {
        mesh: Mesh<1>,
        solver: FieldSolver,
        weights: Vec<f64>,
        by_moments: LineForce,
        by_runs: LineForce,
        by_pairs: LineForce,
    }

    impl Line {
        fn new(shape: Shape, cells: usize, passes: u32, weights: &[f64]) -> Self {
            let mesh = Mesh::new(shape, cells, 0.7 * cells as f64).unwrap();
            let solver = FieldSolver::new(&mesh, passes);
            let by_moments = LineForce {
                way: ForceMethod::Moments,
                ..LineForce::new(&mesh, &solver, weights)
            };
            let by_runs = LineForce {
                way: LineForce::by_runs(&mesh, weights),
                ..by_moments.clone()
            };
            let mut by_pairs = by_moments.clone();
            let functions = shape.degree() + 1;
            let backgrounds = [mesh.background(1.0), mesh.background(0.0)];
            for_functions!(functions, by_pairs.tabulate_pairs(&backgrounds, &solver));
            Line {
                weights: weights.to_vec(),
                by_pairs,
                by_runs,
                by_moments,
                solver,
                mesh,
            }
        }

        /// Gradients at the particles of every sample, as `q`: a row of `samples` for each.
        fn kicked(&self, force: &LineForce, q: &[f64], samples: usize) -> Vec<f64> {
            let particles = self.weights.len();
            let mut p = vec![0.0; q.len()];
            force.kick(
                &self.solver,
                &self.weights,
                -1.0,
                Rows::new(q, particles, samples, samples),
                &mut RowsMut::new(&mut p, particles, samples, samples),
            );
            p
        }

        /// The same for one sample, particle by particle and node by node.
        fn slow(&self, x: &[f64]) -> Vec<f64> {
            let mut nodes = self.mesh.background(self.weights.iter().sum());
            for (&x, &weight) in x.iter().zip(&self.weights) {
                self.mesh.deposit(weight, [x], &mut nodes);
            }
            self.solver.solve(&mut nodes);
            x.iter()
                .map(|&x| self.mesh.gradient(&nodes, [x])[0])
                .collect()
        }
    }

    /// Positions in a box of `length`, at its ends and cell boundaries, and far outside.
    fn positions(cells: usize, length: f64) -> Vec<f64> {
        let width = length / cells as f64;
        let mut x = vec![
            0.0,
            -0.0,
            length,
            -length,
            -1e-300,
            -1e-17,
            length.next_down(),
        ];
        x.extend([1e9 * length, -1e9 * length + 0.3 * width, 1e16 * length]);
        x.extend((0..6).map(|i| f64::from(i) * width));
        x.extend((0..8).map(|i| (f64::from(i) * 0.618 * length + 0.1 * width) % length));
        x
    }

    #[test]
    fn all_ways_are_the_slow_one() {
        for shape in shapes() {
            for passes in [0, 3] {
                for cells in [1, 2, 3, 5, 8, 128] {
                    let length = 0.7 * cells as f64;
                    let x = positions(cells, length);
                    let weights: Vec<f64> =
                        (0..x.len()).map(|a| 1.0 - 0.1 * (a % 13) as f64).collect();
                    let line = Line::new(shape, cells, passes, &weights);
                    let slow = line.slow(&x);
                    // Fields are differences of potentials, which grow with the charge and the box.
                    let scale = x.len() as f64 * length.max(1.0);
                    for force in [&line.by_moments, &line.by_runs, &line.by_pairs] {
                        let kicked = line.kicked(force, &x, 1);
                        for ((x, got), expected) in x.iter().zip(&kicked).zip(&slow) {
                            assert!(
                                (got - expected).abs() < 1e-14 * scale,
                                "{shape:?}, {cells} cells, {passes} passes, x = {x:e}: \
                                 {got} for {expected}, {:?}",
                                force.way
                            );
                        }
                    }
                }
            }
        }
    }

    /// A sample gets the same bits alone, in a group and in what groups leave over.
    #[test]
    fn a_sample_does_not_know_its_block() {
        let spline = Shape::new(ShapeFamily::BSpline, 2).unwrap();
        // Groups or single samples by pairs, and places that are kept or not.
        let numbers =
            [1, 2, 3, 8, 9, 129, 256, 257, 2048, 2049].map(|particles| (spline, particles));
        for (shape, particles) in shapes().map(|shape| (shape, 40)).chain(numbers) {
            const SAMPLES: usize = LARGE_GROUP + 2 * GROUP + 3;
            let line = Line::new(shape, 16, 0, &vec![0.3; particles]);
            let q: Vec<f64> = (0..particles * SAMPLES)
                .map(|i| ((i * i) as f64 * 0.618).rem_euclid(33.6) - 11.2)
                .collect();
            let forces = [&line.by_moments, &line.by_runs, &line.by_pairs];
            // Pairs are for few particles.
            let count = if particles <= 40 { 3 } else { 2 };
            for force in &forces[..count] {
                let together = line.kicked(force, &q, SAMPLES);
                for sample in 0..SAMPLES {
                    let of_sample = |table: &[f64]| -> Vec<f64> {
                        table[sample..].iter().step_by(SAMPLES).copied().collect()
                    };
                    let alone = line.kicked(force, &of_sample(&q), 1);
                    assert_eq!(
                        of_sample(&together),
                        alone,
                        "{shape:?}, {particles}, sample {sample}"
                    );
                }
            }
        }
    }

    /// Portions of the particles are summed on any threads, and the sums are not another.
    #[test]
    fn portions_are_the_whole_on_any_number_of_threads() {
        const CELLS: usize = 16;
        let shape = Shape::new(ShapeFamily::BSpline, 3).unwrap();
        let particles = 5 * (1 << 14) + 77;
        let line = Line::new(shape, CELLS, 0, &vec![1e-3; particles]);
        let q: Vec<f64> = (0..particles)
            .map(|i| ((i * i) as f64 * 0.618).rem_euclid(33.6) - 11.2)
            .collect();
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let kicked = || line.kicked(&line.by_moments, &q, 1);
            pool.build().unwrap().install(kicked)
        };
        let alone = on(1);
        let charge = 1e-3 * particles as f64;
        for (got, expected) in alone.iter().zip(line.slow(&q)) {
            assert!((got - expected).abs() < 1e-14 * charge * line.mesh.length());
        }
        for threads in [2, 3] {
            assert!(on(threads) == alone, "on {threads} threads");
        }
        let twice: Vec<f64> = q.iter().flat_map(|&x| [x; 2 * GROUP]).collect();
        let together = line.kicked(&line.by_moments, &twice, 2 * GROUP);
        let expected = alone.iter().flat_map(|&v| [v; 2 * GROUP]);
        assert!(together.into_iter().eq(expected), "in a block");
    }
}
