//! The implicit midpoint rule, solved to a tolerance, or by one Newton iteration.
//!
//! If the number of fixed-point iterations changes, the loop breaks. For a fixed number the map is smooth: the truth
//! is the sum over the pieces on which the number is the same, from a dense scan and bisection.

use std::sync::Arc;

use symplint::Loop;

use crate::truth_set::control;
use crate::truth_set::member::{Expected, KnownBreak, Member, Step, Truth, halvings, map_of};
use crate::truth_set::random::Random;
use crate::truth_set::systems::{self, MAX_DOF, System};

pub const COUNT: usize = 240;

/// States of the scan.
const SCAN: usize = 1 << 13;

/// Narrower pieces are not asked for.
const NARROW: f64 = 1e-7;

/// Parts of a piece that are searched for a minimum of the change.
const LOOKS: usize = 64;

/// What sums over pieces may be off, relative to the integral of the loop.
const CONTROL: f64 = 1e-14;

/// A defect that the control knows to three digits.
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
        let (mut x, mut y, mut force) = ([0.0; MAX_DOF], [0.0; MAX_DOF], [0.0; MAX_DOF]);
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
        let counted = Counted {
            solver: self,
            on,
            h,
        };
        let pieces = counted.pieces();
        let sum: f64 = pieces.iter().map(|piece| counted.integral(piece)).sum();
        // Where two pieces meet, rounding may change the count to and fro: those stretches are no pieces to be found.
        let wide: Vec<(Piece, KnownBreak)> = (pieces.iter())
            .map(|piece| (*piece, counted.known(piece)))
            .filter(|(piece, known)| piece.to - piece.from > known.rounding.max(NARROW))
            .collect();
        let before = wide.iter().cycle().skip(wide.len().saturating_sub(1));
        let breaks = (wide.iter().zip(before))
            .filter(|((piece, _), (before, _))| piece.count != before.count)
            .map(|((_, known), _)| *known)
            .collect();
        let initial = self.system.on.integral();
        (breaks, (sum - initial) / initial)
    }
}

/// A stretch of the loop on which the number of iterations is the same.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    to: f64,
    count: usize,
}

/// Numbers of iterations along a loop.
struct Counted<'a> {
    solver: &'a Solver,
    on: &'a dyn Loop,
    h: f64,
}

impl Counted<'_> {
    fn count(&self, s: f64) -> usize {
        self.solver.after(self.on, self.h, s, None).count
    }

    /// What iteration `count` changes.
    fn change(&self, s: f64, count: usize) -> f64 {
        self.solver.after(self.on, self.h, s, Some(count)).change
    }

    fn integral(&self, piece: &Piece) -> f64 {
        let state = |s: f64| {
            self.solver
                .after(self.on, self.h, s, Some(piece.count))
                .state
        };
        control::integral(&state, piece.from, piece.to)
    }

    /// The break at which a piece begins, and how far a rounding of the last change moves it.
    fn known(&self, piece: &Piece) -> KnownBreak {
        let last = piece.count.min(self.count(piece.from - 4.0 * f64::EPSILON));
        let e = 1e-3 * (piece.to - piece.from);
        let slope = (self.change(piece.from + e, last) - self.change(piece.from, last)) / e;
        KnownBreak {
            s: piece.from.rem_euclid(1.0),
            rounding: 1e-15 / slope.abs() + 4.0 * f64::EPSILON,
        }
    }

    /// The first double after a break between `low`, where the count is `count`, and `high`, where it is another one.
    fn end(&self, mut low: f64, mut high: f64, count: usize) -> f64 {
        loop {
            let middle = 0.5 * (low + high);
            if !(low.min(high) < middle && middle < low.max(high)) {
                return high;
            }
            match self.count(middle) == count {
                true => low = middle,
                false => high = middle,
            }
        }
    }

    /// All pieces in their order, from the first break on.
    fn pieces(&self) -> Vec<Piece> {
        let counts: Vec<usize> = (0..SCAN)
            .map(|k| self.count(k as f64 / SCAN as f64))
            .collect();
        let Some(first) = (1..SCAN).find(|&k| counts[k] != counts[k - 1]) else {
            let whole = Piece {
                from: 0.0,
                to: 1.0,
                count: counts[0],
            };
            return self.nested(whole);
        };
        let at = |k: usize| k as f64 / SCAN as f64;
        let mut from = self.end(at(first - 1), at(first), counts[first - 1]);
        let last = from + 1.0;
        let mut pieces = Vec::new();
        for k in first..=first + SCAN {
            let (high, wanted) = match k == first + SCAN {
                true => (last, self.count(last)),
                false => (at(k), counts[k % SCAN]),
            };
            let mut count = self.count(from);
            while count != wanted {
                let to = self.end(high.min(at(k.max(1) - 1)).max(from), high, count);
                pieces.extend(self.nested(Piece { from, to, count }));
                (from, count) = (to, self.count(to));
            }
        }
        if from < last {
            let count = self.count(from);
            pieces.extend(self.nested(Piece {
                from,
                to: last,
                count,
            }));
        }
        pieces
    }

    /// A piece without the narrow ones inside it: where the change passes through zero, one iterate is exact by chance,
    /// and round that point fewer and fewer iterations are made.
    fn nested(&self, piece: Piece) -> Vec<Piece> {
        let Piece { from, to, count } = piece;
        if count < 2 || to - from < 1e-14 {
            return vec![piece];
        }
        let before = |s: f64| self.change(s, count - 1);
        let width = (to - from) / LOOKS as f64;
        let lowest = (1..LOOKS)
            .map(|k| from + k as f64 * width)
            .min_by(|a, b| before(*a).total_cmp(&before(*b)))
            .unwrap();
        let (mut low, mut high) = (lowest - width, lowest + width);
        // Thirds: the change has one minimum here.
        while high - low > 1e-15 {
            let third = (high - low) / 3.0;
            match before(low + third) < before(high - third) {
                true => high -= third,
                false => low += third,
            }
        }
        let middle = 0.5 * (low + high);
        if self.count(middle) == count {
            return vec![piece];
        }
        let left = self.end(from, middle, count);
        // The last double of the inner stretch.
        let right = self.end(to - 4.0 * f64::EPSILON, middle, count);
        let outer = |from, to| Piece { from, to, count };
        let mut pieces = vec![outer(from, left)];
        let inside = Piece {
            from: left,
            to: right,
            count: self.count(left),
        };
        pieces.extend(self.nested(inside));
        pieces.push(outer(right, to));
        pieces
    }
}

/// The result of a step.
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
    match index % 4 {
        3 => newton(random),
        _ => solved(random, 1e-12, 1e-5),
    }
}

/// Solved to a tolerance between these.
pub fn solved(random: &mut Random, tightest: f64, loosest: f64) -> Member {
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
        tolerance: random.log_between(tightest, loosest),
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
            defect: (change.abs() - CONTROL).max(0.0),
            breaks: breaks.len(),
            whole: dof == 1 && !solver.predicts,
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
