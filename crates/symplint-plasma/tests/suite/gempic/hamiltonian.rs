//! The Hamiltonian, its gradient and the flows of its parts, against H written down once more.

use std::sync::Arc;

use num_dual::Dual64;
use symplint::TimeAdvance;
use symplint::state::{Rows, RowsMut};
use symplint_models::integrators::{RungeKutta, catalogue, tableaus};
use symplint_models::{Hamiltonian, Model, SplitHamiltonian};
use symplint_plasma::gempic::Gempic;

use crate::common::{State, distance, stepped};
use crate::gempic::flows::with_block;
use crate::gempic::reference::{Plasma, config, random_state, shifted};

fn one_sample(values: &[f64]) -> Rows<'_> {
    Rows::new(values, values.len(), 1, 1)
}

/// Velocities and forces against differences of fourth order of the energy. Momenta of particles are canonical over
/// the weight.
#[test]
fn forces_are_gradients() {
    const STEP: f64 = 1e-3;
    const TAU: f64 = 0.5;
    for degree in 1..=5 {
        for cells in [1, 3, 8] {
            let gempic = Gempic::new(config(degree, cells, 3)).unwrap();
            let dof = gempic.dof();
            let coordinates = gempic.coordinates();
            let (q, p) = gempic.state(&random_state(&gempic, 5)).unwrap();
            let energy = |q: &[f64], p: &[f64]| {
                let mut out = [0.0];
                gempic.energy(one_sample(q), one_sample(p), &mut out);
                out[0]
            };
            let difference = |i: usize, of_position: bool| {
                let at = |k: f64| match of_position {
                    true => energy(&shifted(&q, i, k * STEP), &p),
                    false => energy(&q, &shifted(&p, i, k * STEP)),
                };
                (at(-2.0) - 8.0 * at(-1.0) + 8.0 * at(1.0) - at(2.0)) / (12.0 * STEP)
            };
            let (mut velocity, mut force) = (vec![1.0; dof], vec![1.0; dof]);
            let (q_rows, p_rows) = (one_sample(&q), one_sample(&p));
            gempic.add_velocity(
                TAU,
                q_rows,
                p_rows,
                &mut RowsMut::new(&mut velocity, dof, 1, 1),
            );
            gempic.add_force(
                TAU,
                q_rows,
                p_rows,
                &mut RowsMut::new(&mut force, dof, 1, 1),
            );
            for i in 0..dof {
                let weight = coordinates.weight(i);
                for (got, expected) in [
                    (velocity[i], 1.0 + TAU * difference(i, false) / weight),
                    (force[i], 1.0 - TAU * difference(i, true) / weight),
                ] {
                    assert!(
                        (got - expected).abs() < 1e-9,
                        "degree {degree}, {cells} cells, row {i}: {got} for {expected}"
                    );
                }
            }
        }
    }
}

/// One part of H by its definition in canonical variables, and its gradient by dual numbers.
struct Part<'a> {
    plasma: &'a Plasma,
    part: usize,
}

impl Part<'_> {
    /// Λ_j(x) of `degree` in units of cells, by the recursion of Cox and de Boor on the knots themselves.
    fn function(&self, degree: usize, j: usize, x: Dual64) -> Dual64 {
        fn spline(degree: usize, x: Dual64) -> Dual64 {
            if degree == 0 {
                return Dual64::from(f64::from(u8::from((0.0..1.0).contains(&x.re))));
            }
            let n = degree as f64;
            let (rising, falling) = (spline(degree - 1, x), spline(degree - 1, x - 1.0));
            x / n * rising + (-x + (n + 1.0)) / n * falling
        }
        let cells = self.plasma.config.cells as f64;
        let x = x - (x.re / cells).floor() * cells;
        let images = [x - j as f64, x - j as f64 + cells];
        images
            .into_iter()
            .fold(Dual64::from(0.0), |sum, x| sum + spline(degree, x))
    }

    fn energy_of(&self, q: &[Dual64], p: &[Dual64]) -> Dual64 {
        let config = &self.plasma.config;
        let (n, particles) = (config.cells, self.plasma.weights.len());
        let (a1, a2) = q[2 * particles..].split_at(n);
        let (one, zero) = p[2 * particles..].split_at(n);
        let mut sum = Dual64::from(0.0);
        match self.part {
            0 => {
                for i in 0..n {
                    for j in 0..n {
                        sum += one[i] * one[j] * (0.5 * self.plasma.inverse1[(i, j)]);
                        sum += zero[i] * zero[j] * (0.5 * self.plasma.inverse0[(i, j)]);
                    }
                }
            }
            1 => {
                let b = |j: usize| a2[j] - a2[(j + n - 1) % n];
                for i in 0..n {
                    for j in 0..n {
                        sum += b(i) * b(j) * (0.5 * self.plasma.m1[(i, j)]);
                    }
                }
            }
            part => {
                for (a, &weight) in self.plasma.weights.iter().enumerate() {
                    let x = q[a] / self.plasma.width();
                    let (mut potential, mut momentum) = (Dual64::from(0.0), p[a]);
                    for j in 0..n {
                        potential += if part == 2 {
                            a1[j] * self.function(config.degree - 1, j, x) / self.plasma.width()
                        } else {
                            a2[j] * self.function(config.degree, j, x)
                        };
                    }
                    if part == 3 {
                        momentum = p[particles + a];
                    }
                    let kinetic = momentum - potential * config.charge;
                    sum += kinetic * kinetic * (0.5 * weight / config.mass);
                }
            }
        }
        sum
    }

    /// The derivative of the energy by every coordinate, times a factor for each row.
    fn add_gradient(
        &self,
        q: Rows<'_>,
        p: Rows<'_>,
        by_position: bool,
        tau: f64,
        out: &mut RowsMut<'_>,
    ) {
        let dual = |rows: Rows<'_>| -> Vec<Dual64> {
            (0..rows.count())
                .map(|i| Dual64::from(rows.row(i)[0]))
                .collect()
        };
        let (mut q, mut p) = (dual(q), dual(p));
        for i in 0..q.len() {
            let particles = self.plasma.weights.len();
            let weight = match i {
                i if i < 2 * particles => self.plasma.weights[i % particles],
                _ => 1.0,
            };
            let seed = |variable: &mut Dual64, eps: f64| variable.eps = eps;
            seed(if by_position { &mut q[i] } else { &mut p[i] }, 1.0);
            let slope = self.energy_of(&q, &p).eps;
            seed(if by_position { &mut q[i] } else { &mut p[i] }, 0.0);
            out.row_mut(i)[0] += tau * slope / weight;
        }
    }
}

impl Hamiltonian for Part<'_> {
    fn dof(&self) -> usize {
        2 * (self.plasma.weights.len() + self.plasma.config.cells)
    }

    fn energy(&self, _: Rows<'_>, _: Rows<'_>, _: &mut [f64]) {
        unreachable!("integrators have no use for it");
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        self.add_gradient(q, p, false, tau, out);
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        self.add_gradient(q, p, true, -tau, out);
    }
}

/// Every flow against the method of Dormand and Prince of order 8, while particles stay in their cells, where H is
/// analytic. Crossings are in `flows`.
#[test]
fn each_flow_is_that_of_its_part() {
    const H: f64 = 0.15;
    for degree in 1..=5 {
        let gempic = Gempic::new(config(degree, 7, 3)).unwrap();
        let plasma = Plasma::new(config(degree, 7, 3));
        let mut physical = random_state(&gempic, 4);
        for (a, x) in physical.x.iter_mut().enumerate() {
            *x = plasma.width() * (2.0 * a as f64 + 0.5);
        }
        let state = gempic.state(&physical).unwrap();
        for part in 0..4 {
            let of_part = Part {
                plasma: &plasma,
                part,
            };
            let step = RungeKutta::new(tableaus::dop853(), of_part).unwrap();
            let integrate = |steps: usize| -> State {
                (0..steps).fold(state.clone(), |state, _| {
                    stepped(&step, H / steps as f64, &state)
                })
            };
            // Halved steps give the same: the integrator is exact to rounding errors.
            let expected = integrate(8);
            assert!(distance(&integrate(4), &expected) < 2e-13);
            let (mut q, mut p) = state.clone();
            with_block(&mut q, &mut p, |block| gempic.flow(part, H, block));
            let name = gempic.part_name(part);
            let moved = distance(&state, &expected);
            assert!(moved > 1e-2, "{name} does nothing: {moved}");
            let found = distance(&(q, p), &expected);
            assert!(found < 1e-12, "{name}, degree {degree}: {found:e}");
        }
    }
}

/// Splitting methods of two parts keep their order with four.
#[test]
fn compositions_have_their_orders() {
    const TIME: f64 = 0.5;
    let gempic = Arc::new(Gempic::new(config(5, 8, 3)).unwrap());
    let start = gempic.state(&random_state(&gempic, 8)).unwrap();
    let at_time = |map: &dyn TimeAdvance, steps: u32| -> State {
        let h = TIME / f64::from(steps);
        (0..steps).fold(start.clone(), |state, _| stepped(map, h, &state))
    };
    let build = |name, variant| {
        let model = Model::Split(Arc::clone(&gempic) as Arc<dyn SplitHamiltonian>);
        catalogue::build(name, variant, model).unwrap()
    };
    let exact = at_time(&*build("dop853", None), 2000);
    let by_gauss = at_time(&*build("gauss6", None), 1000);
    assert!(
        distance(&exact, &by_gauss) < 1e-11,
        "{:e}",
        distance(&exact, &by_gauss)
    );
    for (name, order, steps) in [
        ("lie-trotter", 1, 200),
        ("strang", 2, 50),
        ("mclachlan4", 4, 20),
        ("yoshida4", 4, 40),
        ("rk4", 4, 40),
    ] {
        let variants: &[_] = match name {
            "rk4" => &[None],
            _ => &[Some("position-first"), Some("momentum-first")],
        };
        for &variant in variants {
            let map = build(name, variant);
            let error = |steps| distance(&at_time(&*map, steps), &exact);
            let measured = (error(steps) / error(2 * steps)).log2();
            assert!(
                (measured - f64::from(order)).abs() < 0.2,
                "{name}, {variant:?}: order {measured}, error {:e}",
                error(steps)
            );
        }
    }
}
