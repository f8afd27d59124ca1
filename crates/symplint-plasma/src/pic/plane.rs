//! The force in a plane: particles to runs of nodes on both axes, charge to potential, and back.

use multiversion::multiversion;
use symplint::state::{Rows, RowsMut, scratch};

use super::by_functions::for_functions;
use super::field::FieldSolver;
use super::mesh::Mesh;
use super::place::{Locator, Places};
use super::portions::Portions;
use super::runs::{RunFunctions, Runs};

/// The parts that a plasma in a plane needs for its force, apart from the field solver.
///
/// Its table has a row of nodes and ghosts for each node and ghost of the first axis.
#[derive(Clone, Debug)]
pub(super) struct PlaneForce {
    locator: Locator,
    runs: Runs,
    nodes: usize,
    /// The table without a particle.
    background: Vec<f64>,
    portions: Portions,
}

impl PlaneForce {
    pub(super) fn new<const D: usize>(mesh: &Mesh<D>, weights: &[f64]) -> Self {
        let runs = Runs::new(mesh);
        let of_cell = mesh.background_of_cell(weights.iter().sum());
        // One row for each node of a cell along the first axis, then those of all cells.
        let rows: Vec<Vec<f64>> = (of_cell.chunks_exact(runs.step()))
            .map(|of_row| runs.in_all_cells(of_row))
            .collect();
        let mut background = rows.concat().repeat(runs.cells());
        background.resize(runs.len() * runs.len(), 0.0);
        PlaneForce {
            locator: Locator::new(*mesh.grid()),
            nodes: mesh.nodes(),
            portions: Portions::new(background.len()),
            background,
            runs,
        }
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
            self.runs.functions(),
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
        let (functions, len) = (self.runs.of::<N>(), self.runs.len());
        let particles = 0..weights.len();
        scratch::with_buffer(self.background.len() + self.nodes, |buffer| {
            let (table, nodes) = buffer.split_at_mut(self.background.len());
            for sample in 0..q.len() {
                (self.portions).sum(particles.clone(), table, &|portion, table| {
                    if portion.start == 0 {
                        table.copy_from_slice(&self.background);
                    } else {
                        table.fill(0.0);
                    }
                    let rows = 2 * portion.start..2 * portion.end;
                    (self.locator).each_run(q, sample, rows, |row, places| {
                        deposit(functions, len, places, &weights[row / 2..], table);
                    });
                });
                self.solve(table, nodes, solver);
                let table = &*table;
                (self.portions).each::<2>(particles.clone(), p.reborrow(), &|portion, mut p| {
                    let rows = 2 * portion.start..2 * portion.end;
                    let gather = |row: usize, places: Places<'_, 1>| {
                        let at = [row - 2 * portion.start, sample];
                        gather(functions, len, places, table, tau, at, &mut p);
                    };
                    self.locator.each_run(q, sample, rows, gather);
                });
            }
        });
    }

    /// Turns a table of charges into one of potentials.
    fn solve(&self, table: &mut [f64], nodes: &mut [f64], solver: &FieldSolver) {
        let (cells, step, len) = (self.runs.cells(), self.runs.step(), self.runs.len());
        for row in table.chunks_exact_mut(len) {
            self.runs.fold(row, 1);
        }
        self.runs.fold(table, len);
        // A mesh has one component after the other, the last axis running fastest.
        let places = |row: usize| {
            let (cell, first) = (row / step, row % step);
            (0..step).map(move |last| ((first * step + last) * cells + cell) * cells)
        };
        let rows = table.chunks_exact_mut(len).take(self.runs.nodes());
        for (i, row) in rows.enumerate() {
            for (last, place) in places(i).enumerate() {
                let values = row[last..].iter().step_by(step);
                for (node, value) in nodes[place..][..cells].iter_mut().zip(values) {
                    *node = *value;
                }
            }
        }
        solver.solve(nodes);
        let rows = table.chunks_exact_mut(len).take(self.runs.nodes());
        for (i, row) in rows.enumerate() {
            for (last, place) in places(i).enumerate() {
                let values = row[last..].iter_mut().step_by(step);
                for (node, value) in nodes[place..][..cells].iter().zip(values) {
                    *value = *node;
                }
            }
            self.runs.unfold(row, 1);
        }
        self.runs.unfold(table, len);
    }
}

/// Adds the particles of a run to a table, whose rows have this length.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn deposit<const N: usize>(
    functions: RunFunctions<'_, N>,
    len: usize,
    places: Places<'_, 1>,
    weights: &[f64],
    table: &mut [f64],
) {
    for ((&cells, &fractions), &weight) in places.chunks().zip(weights) {
        Patch::new(functions, len, cells, fractions).deposit(weight, table);
    }
}

/// p −= τ × the gradients at the particles of a run. The first particle and the sample are this row of `p` and this place of it.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn gather<const N: usize>(
    functions: RunFunctions<'_, N>,
    len: usize,
    places: Places<'_, 1>,
    table: &[f64],
    tau: f64,
    [first_row, sample]: [usize; 2],
    p: &mut RowsMut<'_>,
) {
    for (row, (&cells, &fractions)) in (first_row..).step_by(2).zip(places.chunks()) {
        let gradient = Patch::new(functions, len, cells, fractions).gradient(table);
        p.row_mut(row)[sample] -= tau * gradient[0];
        p.row_mut(row + 1)[sample] -= tau * gradient[1];
    }
}

/// The nodes that a particle touches, a run of each of `N` rows, and where it is among them.
struct Patch<'a, const N: usize> {
    functions: RunFunctions<'a, N>,
    /// Of a row.
    len: usize,
    start: usize,
    fractions: [f64; 2],
}

impl<'a, const N: usize> Patch<'a, N> {
    #[inline(always)]
    fn new(
        functions: RunFunctions<'a, N>,
        len: usize,
        cells: [u32; 2],
        fractions: [f64; 2],
    ) -> Self {
        let [row, place] = cells.map(|cell| functions.start(cell));
        Patch {
            functions,
            len,
            start: row * len + place,
            fractions,
        }
    }

    #[inline(always)]
    fn deposit(&self, charge: f64, table: &mut [f64]) {
        let [first, last] = self.fractions.map(|x| self.functions.values(x));
        let rows = &mut table[self.start..][..(N - 1) * self.len + N];
        for (i, value) in first.iter().enumerate() {
            let charge = charge * value;
            for (node, value) in rows[i * self.len..][..N].iter_mut().zip(&last) {
                *node += charge * value;
            }
        }
    }

    #[inline(always)]
    fn gradient(&self, table: &[f64]) -> [f64; 2] {
        let [first, last] = self.fractions.map(|x| self.functions.values(x));
        let [first_slopes, last_slopes] = self.fractions.map(|x| self.functions.slopes(x));
        let rows = &table[self.start..][..(N - 1) * self.len + N];
        // Across the rows, what the run of the last axis sees.
        let (mut values, mut slopes) = ([0.0; N], [0.0; N]);
        for (i, (value, slope)) in first.iter().zip(first_slopes).enumerate() {
            let run = &rows[i * self.len..][..N];
            for (k, node) in run.iter().enumerate() {
                values[k] += value * node;
                slopes[k] += slope * node;
            }
        }
        let sum = |of_first: [f64; N], of_last: [f64; N]| -> f64 {
            of_first.iter().zip(of_last).map(|(a, b)| a * b).sum()
        };
        [sum(slopes, last), sum(values, last_slopes)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::{Shape, ShapeFamily};
    use super::*;

    struct Plane {
        mesh: Mesh<2>,
        solver: FieldSolver,
        weights: Vec<f64>,
        force: PlaneForce,
    }

    impl Plane {
        fn new(shape: Shape, cells: usize, passes: u32, weights: Vec<f64>) -> Self {
            let mesh = Mesh::new(shape, cells, 0.7 * cells as f64).unwrap();
            Plane {
                solver: FieldSolver::new(&mesh, passes),
                force: PlaneForce::new(&mesh, &weights),
                mesh,
                weights,
            }
        }

        /// Gradients at the particles of every sample, as `q`: two rows of `samples` for each.
        fn kicked(&self, q: &[f64], samples: usize) -> Vec<f64> {
            let rows = 2 * self.weights.len();
            let mut p = vec![0.0; q.len()];
            let q = Rows::new(q, rows, samples, samples);
            let p_rows = &mut RowsMut::new(&mut p, rows, samples, samples);
            (self.force).kick(&self.solver, &self.weights, -1.0, q, p_rows);
            p
        }

        /// The same for one sample, particle by particle and node by node.
        fn slow(&self, q: &[f64]) -> Vec<f64> {
            let particles = q.as_chunks::<2>().0;
            let mut nodes = self.mesh.background(self.weights.iter().sum());
            for (&x, &weight) in particles.iter().zip(&self.weights) {
                self.mesh.deposit(weight, x, &mut nodes);
            }
            self.solver.solve(&mut nodes);
            let gradients = particles.iter().map(|&x| self.mesh.gradient(&nodes, x));
            gradients.collect::<Vec<_>>().concat()
        }
    }

    /// Coordinates without a pattern, some of them outside the box, and a few on boundaries.
    fn coordinates(particles: usize, length: f64) -> Vec<f64> {
        let edges = [0.0, length, -length, -1e-17, length / 2.0, 1e9 * length];
        let others = (0..).map(|i| ((i * i) as f64 * 0.618).rem_euclid(3.0 * length) - length);
        edges
            .into_iter()
            .chain(others)
            .take(2 * particles)
            .collect()
    }

    #[test]
    fn it_is_the_slow_one() {
        for family in [ShapeFamily::BSpline, ShapeFamily::Lagrange] {
            for shape in (1..=family.highest_degree()).map(|p| Shape::new(family, p).unwrap()) {
                for (cells, passes) in [(1, 0), (2, 0), (3, 2), (4, 0), (7, 0), (16, 3)] {
                    let weights: Vec<f64> =
                        (0..150).map(|a| 1.0 - 0.1 * f64::from(a % 13)).collect();
                    let charge: f64 = weights.iter().map(|weight| weight.abs()).sum();
                    let plane = Plane::new(shape, cells, passes, weights);
                    // Rounding errors of charges go through the solve as charges do.
                    let mut impulse = vec![0.0; plane.mesh.nodes()];
                    impulse[0] = charge;
                    plane.solver.solve(&mut impulse);
                    let scale = impulse.iter().fold(charge, |scale, v| scale.max(v.abs()));
                    let q = coordinates(150, plane.mesh.length());
                    for (got, expected) in plane.kicked(&q, 1).iter().zip(plane.slow(&q)) {
                        assert!(
                            (got - expected).abs() < 1e-14 * scale,
                            "{shape:?}, {cells} cells: {got} for {expected}, {scale}"
                        );
                    }
                }
            }
        }
    }

    /// The same bits on any number of threads, alone and in a block.
    #[test]
    fn portions_are_the_whole_on_any_number_of_threads() {
        let shape = Shape::new(ShapeFamily::BSpline, 2).unwrap();
        let particles = 5 * (1 << 14) + 77;
        let plane = Plane::new(shape, 8, 0, vec![1e-3; particles]);
        let q = coordinates(particles, plane.mesh.length());
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| plane.kicked(&q, 1))
        };
        let alone = on(1);
        for (got, expected) in alone.iter().zip(plane.slow(&q)) {
            assert!((got - expected).abs() < 1e-14 * 1e-3 * particles as f64);
        }
        for threads in [2, 3] {
            assert!(on(threads) == alone, "on {threads} threads");
        }
        let twice: Vec<f64> = q.iter().flat_map(|&x| [x; 2]).collect();
        let together = plane.kicked(&twice, 2);
        assert!(together.into_iter().eq(alone.iter().flat_map(|&v| [v; 2])));
    }
}
