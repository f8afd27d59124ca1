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

/// Fixed-point iterations of the implicit midpoint rule until the momentum changes by less than `tolerance`, or so
/// many as `forced` says: their number, and the last change.
fn midpoint(
    system: &System,
    h: f64,
    q: &mut [f64],
    p: &mut [f64],
    tolerance: f64,
    forced: Option<usize>,
) -> (usize, f64) {
    let dof = q.len();
    let (mut x, mut y) = ([0.0; MOST], [0.0; MOST]);
    y[..dof].copy_from_slice(p);
    let (mut count, mut change) = (0, f64::INFINITY);
    while count < 200 && forced.map_or(change >= tolerance, |wanted| count < wanted) {
        for i in 0..dof {
            x[i] = q[i] + 0.5 * h * y[i] / system.masses[i];
        }
        let mut force = [0.0; MOST];
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
        x[i] = q[i] + 0.5 * h * y[i] / system.masses[i];
        (q[i], p[i]) = (2.0 * x[i] - q[i], 2.0 * y[i] - p[i]);
    }
    (count, change)
}

/// One Newton iteration for the midpoint momentum of one degree of freedom, from the momentum before.
fn one_newton(system: &System) -> Step {
    let force = system.force.clone();
    Arc::new(move |h, q, p| {
        let of = |x: f64| {
            let mut f = [0.0];
            force(&[x], &mut f);
            f[0]
        };
        let residual = |y: f64| y - p[0] - 0.5 * h * of(q[0] + 0.5 * h * y);
        let e = 1e-3;
        let slope = (residual(p[0] + e) - residual(p[0] - e)) / (2.0 * e);
        let y = p[0] - residual(p[0]) / slope;
        (q[0], p[0]) = (q[0] + h * y, 2.0 * y - p[0]);
    })
}

/// Breaks, and the change of the integral between them.
fn scanned(system: &System, tolerance: f64, h: f64) -> (Vec<KnownBreak>, f64) {
    let on = system.on.circle();
    let solved = |s: f64, forced: Option<usize>| {
        let (mut q, mut p) = control::state(&on, s);
        let (count, change) = midpoint(system, h, &mut q, &mut p, tolerance, forced);
        (count, change, (q, p))
    };
    let count = |s: f64| solved(s, None).0;
    let counts: Vec<usize> = (0..SCAN).map(|k| count(k as f64 / SCAN as f64)).collect();
    let mut breaks = Vec::new();
    for k in 0..SCAN {
        let (mut low, mut high) = (k as f64 / SCAN as f64, (k + 1) as f64 / SCAN as f64);
        let before = counts[k];
        if before == counts[(k + 1) % SCAN] {
            continue;
        }
        while high - low > 1e-16 && low < 0.5 * (low + high) && 0.5 * (low + high) < high {
            let middle = 0.5 * (low + high);
            if count(middle) == before {
                low = middle
            } else {
                high = middle
            }
        }
        // What a rounding of the last change moves the break by.
        let n = before.min(count(high));
        let slope = (solved(high + 1e-6, Some(n)).1 - solved(high - 1e-6, Some(n)).1) / 2e-6;
        let rounding = 1e-15 / slope.abs() + 2.0 * f64::EPSILON;
        breaks.push(KnownBreak { s: high, rounding });
    }
    let initial = system.on.integral();
    let mut sum = 0.0;
    for (k, at) in breaks.iter().enumerate() {
        let to = breaks.get(k + 1).map_or(breaks[0].s + 1.0, |next| next.s);
        let n = count((0.5 * (at.s + to)).rem_euclid(1.0));
        sum += control::integral(&|s| solved(s.rem_euclid(1.0), Some(n)).2, at.s, to);
    }
    if breaks.is_empty() {
        let n = counts[0];
        sum = control::integral(&|s| solved(s, Some(n)).2, 0.0, 1.0);
    }
    (breaks, (sum - initial) / initial)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(3, index);
    let newton = index % 4 == 3;
    let system = match newton || random.chance(0.5) {
        true => systems::pendulum(random),
        false => {
            let dof = random.whole(1, 2);
            systems::chain(random, dof)
        }
    };
    let h = random.between(0.3, 0.8) / system.omega;
    let on = system.on.circle();
    let name = format!("{} d = {}", system.name, system.dof());
    if newton {
        let step = one_newton(&system);
        let shared: Arc<dyn Loop> = Arc::new(on.clone());
        let defect = control::change(&step, &shared, h).abs();
        let truth = Truth::of(Expected::SmallDefect(defect));
        let label = format!("{name}, one Newton iteration, defect {defect:.1e}");
        return Member::new(label, map_of(1, step), on, halvings(h, 8), truth);
    }
    let tolerance = random.log_between(1e-12, 1e-5);
    let (breaks, change) = scanned(&system, tolerance, h);
    let mut truth = Truth::of(Expected::Tolerance {
        defect: change.abs(),
        breaks: breaks.len(),
    });
    truth.initial = Some(system.on.integral());
    // Only at the largest step.
    truth.change = Some(Arc::new(move |at| if at == h { change } else { f64::NAN }));
    let label = format!(
        "{name}, tolerance {tolerance:.0e}, {} breaks, change {change:.1e}",
        breaks.len()
    );
    truth.breaks = Some(breaks);
    let dof = system.dof();
    let step: Step = Arc::new(move |h, q, p| {
        midpoint(&system, h, q, p, tolerance, None);
    });
    Member::new(label, map_of(dof, step), on, halvings(h, 6), truth)
}
