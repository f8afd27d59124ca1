//! The implicit midpoint rule, solved to a tolerance, or by one Newton iteration.
//!
//! Where the number of fixed-point iterations changes, the loop breaks. For a fixed number the map is smooth: the truth
//! is the sum over the pieces on which the number is the same, from a dense scan and bisection.

use std::sync::Arc;

use symplint::Loop;

use crate::control;
use crate::member::{Expected, KnownBreak, Member, Step, Truth, halvings, map_of};
use crate::random::Random;
use crate::systems::{self, MOST, System};

pub const COUNT: usize = 240;

/// States of the scan.
const SCAN: usize = 1 << 13;

/// A defect that the control, which is good to 1e-14, knows to three digits.
const CLEAR: f64 = 1e-11;

/// The implicit midpoint rule by fixed-point iterations that stop.
#[derive(Clone)]
struct Solver {
    system: System,
    /// The change of the momenta at which they stop.
    tolerance: f64,
    /// Whether they begin with an Euler step. If not, every iterate is p plus a function of q + h p/2m, and in one degree
    /// of freedom any number of iterations is symplectic.
    predicts: bool,
}

impl Solver {
    /// One step with as many iterations as it takes, or as `forced` says: their number, and the last change.
    fn step(&self, h: f64, q: &mut [f64], p: &mut [f64], forced: Option<usize>) -> (usize, f64) {
        let (dof, system) = (q.len(), &self.system);
        let (mut x, mut y, mut force) = ([0.0; MOST], [0.0; MOST], [0.0; MOST]);
        y[..dof].copy_from_slice(p);
        if self.predicts {
            (system.force)(q, &mut force[..dof]);
            (0..dof).for_each(|i| y[i] += 0.5 * h * force[i]);
        }
        let (mut count, mut change) = (0, f64::INFINITY);
        while count < 200 && forced.map_or(change >= self.tolerance, |wanted| count < wanted) {
            for i in 0..dof {
                x[i] = q[i] + 0.5 * h * y[i] / system.masses[i];
            }
            (system.force)(&x[..dof], &mut force[..dof]);
            change = 0.0;
            for i in 0..dof {
                let next = p[i] + 0.5 * h * force[i];
                change = change.max((next - y[i]).abs());
                y[i] = next;
            }
            count += 1;
        }
        for i in 0..dof {
            q[i] += h * y[i] / system.masses[i];
            p[i] = 2.0 * y[i] - p[i];
        }
        (count, change)
    }

    /// The same as a step of a map.
    fn into_step(self) -> Step {
        Arc::new(move |h, q, p| {
            self.step(h, q, p, None);
        })
    }

    /// The state after a step from parameter s of the loop.
    fn after(&self, on: &dyn Loop, h: f64, s: f64, forced: Option<usize>) -> After {
        let (mut q, mut p) = control::state(on, s.rem_euclid(1.0));
        let (count, change) = self.step(h, &mut q, &mut p, forced);
        After {
            count,
            change,
            state: (q, p),
        }
    }

    /// Breaks of the loop, and the relative change of the integral between them.
    fn scan(&self, on: &dyn Loop, h: f64) -> (Vec<KnownBreak>, f64) {
        let count = |s: f64| self.after(on, h, s, None).count;
        let counts: Vec<usize> = (0..SCAN).map(|k| count(k as f64 / SCAN as f64)).collect();
        let mut breaks = Vec::new();
        for (k, &before) in counts.iter().enumerate() {
            if before == counts[(k + 1) % SCAN] {
                continue;
            }
            let (mut low, mut high) = (k as f64 / SCAN as f64, (k + 1) as f64 / SCAN as f64);
            loop {
                let middle = 0.5 * (low + high);
                if !(low < middle && middle < high) {
                    break;
                }
                match count(middle) == before {
                    true => low = middle,
                    false => high = middle,
                }
            }
            // How far a rounding of the last change moves the break.
            let last = Some(before.min(count(high)));
            let change = |s: f64| self.after(on, h, s, last).change;
            let slope = (change(high + 1e-6) - change(high - 1e-6)) / 2e-6;
            breaks.push(KnownBreak {
                s: high,
                rounding: 1e-15 / slope.abs() + 2.0 * f64::EPSILON,
            });
        }
        let piece = |from: f64, to: f64| {
            let last = Some(count(0.5 * (from + to)));
            control::integral(&|s| self.after(on, h, s, last).state, from, to)
        };
        let ends = breaks.iter().skip(1).map(|at| at.s);
        let ends = ends.chain(breaks.first().map(|at| at.s + 1.0));
        let sum: f64 = match breaks.is_empty() {
            true => piece(0.0, 1.0),
            false => breaks
                .iter()
                .zip(ends)
                .map(|(at, end)| piece(at.s, end))
                .sum(),
        };
        let initial = self.system.on.integral();
        (breaks, (sum - initial) / initial)
    }
}

/// What a step gives.
struct After {
    count: usize,
    change: f64,
    state: (Vec<f64>, Vec<f64>),
}

/// One Newton iteration for the midpoint momentum of one degree of freedom, after an Euler step.
fn one_newton(system: &System) -> Step {
    let force = system.force.clone();
    Arc::new(move |h, q, p| {
        let of = |x: f64| {
            let mut f = [0.0];
            force(&[x], &mut f);
            f[0]
        };
        let residual = |y: f64| y - p[0] - 0.5 * h * of(q[0] + 0.5 * h * y);
        let (from, e) = (p[0] + 0.5 * h * of(q[0]), 1e-3);
        let slope = (residual(from + e) - residual(from - e)) / (2.0 * e);
        let y = from - residual(from) / slope;
        (q[0], p[0]) = (q[0] + h * y, 2.0 * y - p[0]);
    })
}

fn newton(random: &mut Random) -> Member {
    let system = systems::pendulum(random);
    let step = one_newton(&system);
    let on: Arc<dyn Loop> = Arc::new(system.on.circle());
    let mut h = random.between(0.3, 0.8) / system.omega;
    let mut defect = control::change(&step, &on, h).abs();
    while defect < CLEAR {
        h *= 1.2;
        defect = control::change(&step, &on, h).abs();
    }
    let truth = Truth::of(Expected::SmallDefect(defect));
    let label = format!("pendulum, one Newton iteration, defect {defect:.1e}");
    Member::new(label, map_of(1, step), on, halvings(h, 8), truth)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(3, index);
    if index % 4 == 3 {
        return newton(random);
    }
    let system = match random.chance(0.3) {
        true => systems::pendulum(random),
        false => {
            let dof = random.whole(1, 3);
            systems::chain(random, dof)
        }
    };
    let (dof, name, initial) = (system.dof(), system.name, system.on.integral());
    let h = random.between(0.3, 0.8) / system.omega;
    let on = system.on.circle();
    let solver = Solver {
        system,
        tolerance: random.log_between(1e-12, 1e-5),
        predicts: random.chance(0.5),
    };
    let (breaks, change) = solver.scan(&on, h);
    let label = format!(
        "{name} d = {dof}, tolerance {:.0e}, {} breaks, change {change:.1e}",
        solver.tolerance,
        breaks.len()
    );
    let truth = Truth {
        initial: Some(initial),
        // Only at the largest step.
        change: Some(Arc::new(move |at| if at == h { change } else { f64::NAN })),
        ..Truth::of(Expected::Tolerance {
            defect: change.abs(),
            breaks: breaks.len(),
        })
    };
    let truth = Truth {
        breaks: Some(breaks),
        ..truth
    };
    let converged = Solver {
        tolerance: 1e-16,
        ..solver.clone()
    };
    Member::new(
        label,
        map_of(dof, solver.into_step()),
        on,
        halvings(h, 6),
        truth,
    )
    .in_full_precision(map_of(dof, converged.into_step()))
}
