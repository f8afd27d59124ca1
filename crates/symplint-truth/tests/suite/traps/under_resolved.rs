//! Features narrower than the distance of samples: of two alike, one may be found and the other missed.

use std::f64::consts::TAU;

use rayon::prelude::*;
use symplint::rules::Piecewise;
use symplint::{Block, Circle, Diagnosis, Diagnostic, Loop, PerSample, TimeAdvance, VerdictKind};

/// The circle round (0.1, 0.2) that begins at another place.
struct BegunAt(f64);

impl Loop for BegunAt {
    fn dof(&self) -> usize {
        1
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for (k, &s) in s.iter().enumerate() {
            let (sin, cos) = (TAU * (s + self.0)).sin_cos();
            block.q.row_mut(0)[k] = 0.1 + sin;
            block.p.row_mut(0)[k] = 0.2 + cos;
        }
    }
}

/// What one step does, in which order.
#[derive(Clone, Copy, Debug)]
enum Order {
    KickDrift,
    DriftKick,
    DriftKickDrift,
}

/// A step in a force with a kink at q = 0 and a narrow bump, and damped momenta.
fn kink_and_bump(order: Order, at: f64, width: f64, damping: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let (before, after) = match order {
            Order::KickDrift => (0.0, h),
            Order::DriftKick => (h, 0.0),
            Order::DriftKickDrift => (0.5 * h, 0.5 * h),
        };
        q[0] += before * p[0];
        p[0] -= h * (q[0].abs() + (-((q[0] - at) / width).powi(2)).exp());
        q[0] += after * p[0];
        p[0] *= 1.0 - damping * h;
    })
}

fn diagnose(map: &dyn TimeAdvance, phase_loop: &dyn Loop) -> Diagnosis {
    let diagnostic = Diagnostic {
        piecewise: Piecewise {
            most_evaluations: 300_000,
            ..Piecewise::default()
        },
        loops: 4,
        ..Diagnostic::halving(-1, -5)
    };
    diagnostic.run(map, phase_loop).unwrap()
}

const WIDTHS: [f64; 5] = [1e-3, 3e-4, 1e-4, 3e-5, 1e-5];

#[test]
fn a_bump_beside_a_kink_whose_recurrence_samples_miss_is_not_called_not_symplectic() {
    let all = [Order::KickDrift, Order::DriftKick, Order::DriftKickDrift]
        .into_iter()
        .flat_map(|order| WIDTHS.map(|width| (order, width)))
        .flat_map(|(order, width)| [0.3, -0.412, 0.05].map(|at| (order, width, at)))
        .flat_map(|(order, width, at)| [0.0, 0.71].map(|start| (order, width, at, start)));
    let all: Vec<_> = all.collect();
    let is_conserved = |&(order, width, at, start): &(Order, f64, f64, f64)| {
        let map = kink_and_bump(order, at, width, 0.0);
        let found = diagnose(&map, &BegunAt(start));
        let what = format!("{order:?}, {width:e} at {at} from {start}");
        let kind = found.verdict.kind;
        assert!(
            matches!(kind, VerdictKind::Symplectic | VerdictKind::Undecided),
            "{what}: {}",
            found.verdict
        );
        // The step changes no loop integral. What equispaced samples say of spikes is an estimate alone.
        let pieces = |point: &&symplint::evidence::Point| point.rule.name() == "piecewise";
        for point in found.points().iter().filter(pieces) {
            let (off, error) = (point.defect, point.quadrature_error);
            let error = error.unwrap_or(f64::INFINITY) + point.roundoff;
            assert!(off <= error, "{what}: {off:e}, estimate {error:e}");
        }
        kind == VerdictKind::Symplectic
    };
    let conserved = all.par_iter().filter(|&one| is_conserved(one)).count();
    // Undecided is not an answer, except where samples meet nothing but spikes.
    assert!(conserved > 45, "{conserved} of 90");
}

#[test]
fn friction_beside_such_a_bump_is_not_called_symplectic() {
    for width in WIDTHS {
        for start in [0.0, 0.123, 0.71] {
            let map = kink_and_bump(Order::KickDrift, 0.3, width, 1e-2);
            let found = diagnose(&map, &BegunAt(start)).verdict;
            // It is far larger than what the bump may hide, but for samples that meet it as noise.
            assert_ne!(found.kind, VerdictKind::Symplectic, "{width:e}: {found}");
            if width > 2e-4 {
                assert_eq!(found.kind, VerdictKind::NotSymplectic, "{width:e}: {found}");
            }
        }
    }
}

#[test]
fn recurrences_that_no_single_coordinate_leads_to_widen_the_error_estimate() {
    // The bump is in the distance of two particles.
    for width in WIDTHS {
        for at in [0.3, 0.9] {
            let map = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
                let force = (-((q[0] - q[1] - at) / width).powi(2)).exp();
                p[0] -= h * (q[0].abs() + force);
                p[1] -= h * (q[1] - force);
                q[0] += h * p[0];
                q[1] += h * p[1];
            });
            let circle = Circle::new(vec![0.1, -0.2], vec![0.2, 0.3], 1.0).unwrap();
            let found = diagnose(&map, &circle).verdict;
            assert_ne!(
                found.kind,
                VerdictKind::NotSymplectic,
                "{width:e} at {at}: {found}"
            );
        }
    }
}

#[test]
fn breaks_whose_recurrences_samples_miss_do_not_open_the_closed_loop() {
    // The force jumps up and down again. With the breaks closed the loop is conserved.
    for width in WIDTHS {
        for start in [0.0, 0.123, 0.377, 0.71] {
            let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
                p[0] -= h * (q[0].abs() + f64::from((q[0] - 0.3).abs() < width));
                q[0] += h * p[0];
            });
            let found = diagnose(&map, &BegunAt(start)).verdict;
            assert_ne!(found.kind, VerdictKind::NotSymplectic, "{width:e}: {found}");
            let opened = found.summary().contains("change even with");
            assert!(!opened, "{width:e} from {start}: {found}");
        }
    }
}
