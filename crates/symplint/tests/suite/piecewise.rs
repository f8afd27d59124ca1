//! The piecewise rule against closed forms.

use std::f64::consts::{PI, TAU};

use symplint::map::{Capabilities, Substeps};
use symplint::rules::{Closure, Piecewise, PiecewiseIntegral};
use symplint::{
    Block, Circle, Coordinates, Diagnostic, Ensemble, Error, FourierLoop, LoopIntegral, PerSample,
    Rule, StepFailure, TimeAdvance, VerdictKind,
};

fn unit_circle() -> Circle {
    Circle::new(vec![0.0], vec![0.0], 1.0).unwrap()
}

/// A kick by `force`, then a drift.
fn kick_drift(force: impl Fn(f64) -> f64 + Send + Sync) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] += h * force(q[0]);
        q[0] += h * p[0];
    })
}

fn integrate(map: &dyn TimeAdvance, h: f64) -> PiecewiseIntegral {
    Piecewise::default()
        .integrate(map, &unit_circle(), h)
        .unwrap()
}

/// Drifts and kicks on H = p²/2 + |q|, one after the other.
struct Wedge(&'static [(char, f64)]);

impl TimeAdvance for Wedge {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.substeps()).try_for_each(|k| self.advance_substep(k, h, block))
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            ..Capabilities::plain(self.dof())
        }
    }
}

impl Substeps for Wedge {
    fn substeps(&self) -> usize {
        self.0.len()
    }

    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let (flow, fraction) = self.0[k];
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            match flow {
                'T' => *q += fraction * h * *p,
                _ => *p -= fraction * h * if *q < 0.0 { -1.0 } else { 1.0 },
            }
        }
        Ok(())
    }
}

const LIE_TROTTER_Q: Wedge = Wedge(&[('T', 1.0), ('V', 1.0)]);
const LIE_TROTTER_P: Wedge = Wedge(&[('V', 1.0), ('T', 1.0)]);
const STRANG_Q: Wedge = Wedge(&[('T', 0.5), ('V', 1.0), ('T', 0.5)]);
const STRANG_P: Wedge = Wedge(&[('V', 0.5), ('T', 1.0), ('V', 0.5)]);

/// The maps with the closed forms of Barham & Burby, section 4.2, and how often they break the loop:
/// momentum-first Strang kicks twice.
type ClosedForm = fn(f64) -> f64;
const CLOSED_FORMS: [(&Wedge, ClosedForm, usize); 4] = [
    (&LIE_TROTTER_Q, |_| PI, 2),
    (&LIE_TROTTER_P, |h| PI + 4.0 * h * h, 2),
    (&STRANG_Q, |h| PI + 4.0 * h * h / (h * h + 4.0).sqrt(), 2),
    (&STRANG_P, |h| PI + 2.0 * h * h - h.powi(3), 4),
];

#[test]
fn the_closed_forms_of_the_wedge() {
    for h in [1.9, 0.5, 0.1, 0.01] {
        for (map, expected, breaks) in CLOSED_FORMS {
            let found = integrate(map, h);
            let error = found.continuous.value - expected(h);
            assert!(error.abs() < 1e-12, "h = {h}: {error:e}");
            let closed = found.closed().value - PI;
            assert!(closed.abs() < 1e-13, "h = {h}: {closed:e}");
            assert_eq!(found.breaks.len(), breaks, "h = {h}");
            assert!(
                found.evaluations <= 200 + 100 * breaks,
                "{}",
                found.evaluations
            );
            assert!(found.unresolved.is_empty());
            let estimate = found.continuous.quadrature_error.unwrap() + found.continuous.roundoff;
            assert!(
                error.abs() <= estimate && estimate < 1e-9,
                "{error:e} {estimate:e}"
            );
        }
    }
}

#[test]
fn breaks_are_where_the_force_jumps() {
    // Position-first: where q + h p = 0.
    let h: f64 = 0.5;
    for found in integrate(&LIE_TROTTER_Q, h).breaks {
        let (sin, cos) = (TAU * found.s).sin_cos();
        assert!((sin + h * cos).abs() < 2e-15, "{found:?}");
        assert!((found.jump_p.abs() - 2.0 * h).abs() < 1e-14);
        assert!(found.jump_q.abs() < 1e-14);
    }
}

#[test]
fn a_chord_is_not_enough_where_the_closing_segment_breaks_again() {
    // The second kick breaks the segment that closes the break of the first.
    const TWICE: Wedge = Wedge(&[('V', 1.0), ('T', 3.0), ('V', 1.0), ('T', 1.0)]);
    let closed = |closure| {
        let rule = Piecewise {
            closure,
            ..Piecewise::default()
        };
        let found = rule.integrate(&TWICE, &unit_circle(), 1.5).unwrap();
        found.closed().value - PI
    };
    assert!(closed(Closure::Substeps).abs() < 1e-13);
    assert!(closed(Closure::Chords).abs() > 1e-2);
}

#[test]
fn kinks_are_integrated_to_round_off_and_are_no_breaks() {
    for h in [1.0, 0.1, 0.01] {
        let kinked = integrate(&kick_drift(|q| -(q - 0.3).abs()), h);
        assert!(kinked.breaks.is_empty());
        assert!((kinked.continuous.value - PI).abs() < 1e-13, "{kinked:?}");
        assert!(kinked.evaluations < 1000, "{}", kinked.evaluations);
        let bent_twice = integrate(&kick_drift(|q| -(q - 0.3) * (q - 0.3).abs()), h);
        assert!(bent_twice.breaks.is_empty());
        assert!((bent_twice.continuous.value - PI).abs() < 1e-13);
    }
}

#[test]
fn steep_is_not_broken() {
    for width in [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
        let found = integrate(
            &kick_drift(move |q| -(q - 0.3) / (q - 0.3).hypot(width)),
            0.5,
        );
        assert!(found.breaks.is_empty(), "width {width}: {:?}", found.breaks);
        let error = (found.continuous.value - PI).abs();
        let estimate = found.continuous.quadrature_error.unwrap() + found.continuous.roundoff;
        assert!(
            error < 1e-11 && error <= estimate,
            "width {width}: {error:e} {estimate:e}"
        );
        assert!(
            found.evaluations < 10_000,
            "width {width}: {}",
            found.evaluations
        );
    }
}

#[test]
fn jumps_far_below_the_slope_are_found() {
    for size in [1e-3, 1e-6, 1e-9] {
        let found = integrate(
            &kick_drift(move |q| 3.0 * q - size * (q - 0.3).signum()),
            0.5,
        );
        assert_eq!(found.breaks.len(), 2, "size {size}");
        for found in &found.breaks {
            assert!((found.jump_p.abs() - size).abs() < 1e-14, "{found:?}");
        }
        assert!((found.closed().value - PI).abs() < 1e-13);
    }
}

#[test]
fn a_particle_that_only_grazes_a_boundary_breaks_the_loop() {
    // The force jumps at q = 1 − δ, and the loop is beyond it for a short stretch round s = 1/4.
    for graze in [1e-3, 1e-6, 1e-9, 1e-12] {
        let edge = 1.0 - graze;
        let found = integrate(&kick_drift(move |q| if q > edge { -1.0 } else { 1.0 }), 0.5);
        assert_eq!(found.breaks.len(), 2, "by {graze}");
        let width = found.breaks[1].s - found.breaks[0].s;
        let expected = (1.0 - graze).acos() / PI;
        assert!((width - expected).abs() < 1e-6 * expected.sqrt() + 1e-15 / graze.sqrt());
        assert!((found.closed().value - PI).abs() < 1e-13, "by {graze}");
    }
}

#[test]
fn smooth_loops_agree_with_the_pseudospectral_rule() {
    let map = kick_drift(|q| -q.sin());
    let random = FourierLoop::random(vec![1.0], vec![-0.5], &[1.0], &[0.7], 5).unwrap();
    let found = Piecewise::default().integrate(&map, &random, 0.8).unwrap();
    let mut ensemble = Ensemble::sample(&random, 512).unwrap();
    ensemble.advance(&map, 0.8).unwrap();
    let other = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
    assert!((found.continuous.value - other.value).abs() < 1e-12);
    assert!(found.breaks.is_empty() && found.unresolved.is_empty());
}

#[test]
fn loops_far_from_the_origin_lose_only_what_rounding_takes() {
    let centre = [1e3, -3e3];
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * (q[0] - centre[0]).signum();
        q[0] += h * (p[0] - centre[1]);
    });
    let circle = Circle::new(vec![centre[0]], vec![centre[1]], 1.0).unwrap();
    let found = Piecewise::default().integrate(&map, &circle, 0.5).unwrap();
    let error = found.closed().value - PI;
    assert!(
        error.abs() < 1e-11 && error.abs() < found.continuous.roundoff,
        "{error:e}"
    );
}

/// The standard map: a kick and a drift on the cylinder, positions stored wrapped, in units of their period.
struct Cylinder {
    force: fn(f64) -> f64,
    weight: f64,
}

impl TimeAdvance for Cylinder {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            *p += h * (self.force)(*q) / self.weight;
            *q = (*q + h * *p * self.weight).rem_euclid(1.0);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(
            Coordinates::plain(1)
                .with_periods(vec![1.0])
                .and_then(|plain| plain.with_weights(vec![self.weight]))
                .unwrap(),
        )
    }
}

#[test]
fn wraps_are_no_breaks_and_weights_count() {
    let smooth: fn(f64) -> f64 = |q| (TAU * q).sin();
    let sawtooth: fn(f64) -> f64 = |q| q - q.floor() - 0.5;
    for (force, breaks) in [(smooth, 0), (sawtooth, 4)] {
        let map = Cylinder { force, weight: 2.5 };
        let circle = Circle::new(vec![0.5], vec![0.25], 0.9).unwrap();
        let found = Piecewise::default().integrate(&map, &circle, 0.3).unwrap();
        assert_eq!(found.breaks.len(), breaks);
        let expected = 2.5 * PI * 0.81;
        assert!((found.closed().value - expected).abs() < 1e-12, "{found:?}");
    }
}

#[test]
fn noise_is_told_from_structure() {
    let single = kick_drift(|q| f64::from((q as f32).sin()));
    let found = integrate(&single, 0.5);
    let error = (found.continuous.value - PI).abs();
    assert!(error < 1e-6, "{error:e}");
    assert!(error <= found.continuous.quadrature_error.unwrap());
    assert!(found.evaluations < 100_000, "{}", found.evaluations);
}

#[test]
fn what_is_not_resolved_is_reported() {
    let rule = Piecewise {
        most_evaluations: 100,
        ..Piecewise::default()
    };
    let found = rule.integrate(&STRANG_Q, &unit_circle(), 0.5).unwrap();
    assert!(!found.unresolved.is_empty());
    let expected = PI + 1.0 / 4.25f64.sqrt();
    let error = (found.continuous.value - expected).abs();
    assert!(error <= found.continuous.quadrature_error.unwrap());
}

#[test]
fn failures_say_where_on_the_loop_they_are() {
    let map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        p[0] = if q[0] > 0.9 { f64::NAN } else { p[0] };
    });
    let error = Piecewise::default()
        .integrate(&map, &unit_circle(), 0.5)
        .unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
    let rule = Piecewise {
        tolerance: 0.0,
        ..Piecewise::default()
    };
    let error = rule.integrate(&map, &unit_circle(), 0.5).unwrap_err();
    assert!(error.to_string().contains("tolerance"), "{error}");
}

/// H = (p − A(q))²/2 + q²/2 with a vector potential that jumps at q = 0.3: both parts take their exact flows.
struct JumpingPotential(f64);

impl TimeAdvance for JumpingPotential {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..2).try_for_each(|k| self.advance_substep(k, h, block))
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            ..Capabilities::plain(self.dof())
        }
    }
}

impl Substeps for JumpingPotential {
    fn substeps(&self) -> usize {
        2
    }

    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let a = |q: f64| if q < 0.3 { 0.0 } else { self.0 };
        for j in 0..block.len() {
            let (q, p) = (block.q.row(0)[j], block.p.row(0)[j]);
            if k == 0 {
                let velocity = p - a(q);
                block.q.row_mut(0)[j] = q + h * velocity;
                block.p.row_mut(0)[j] = velocity + a(q + h * velocity);
            } else {
                block.p.row_mut(0)[j] = p - h * q;
            }
        }
        Ok(())
    }
}

#[test]
fn segments_between_sides_that_differ_in_q_and_p_prove_nothing() {
    // Velocities between p and p − A turn round where they meet the jump: what closes the break is not a straight line.
    let circle = Circle::new(vec![0.3], vec![0.1], 0.5).unwrap();
    let (map, h) = (JumpingPotential(0.8), 0.5);
    let found = Piecewise::default().integrate(&map, &circle, h).unwrap();
    let before = PI * 0.25;
    let changed = (found.closed().value - before).abs();
    assert!(
        changed > 1e-3 && changed < found.bend,
        "{changed:e} {:e}",
        found.bend
    );
    let found = Diagnostic::halving(-1, -3).run(&map, &circle).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::BrokenLoops);
    assert_eq!(
        found.verdict.conserved_once_closed, None,
        "{}",
        found.verdict
    );
    // Momenta alone jump in the kicks of a force that jumps: every curve contributes the same.
    assert!(integrate(&LIE_TROTTER_Q, h).bend < 1e-14);
}

/// Says that it has one degree of freedom less than it has.
struct Miscounted;

impl TimeAdvance for Miscounted {
    fn dof(&self) -> usize {
        2
    }
    fn advance(&self, _: f64, _: &mut Block<'_>) -> Result<(), StepFailure> {
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(Coordinates::plain(1))
    }
}

#[test]
fn coordinates_of_another_number_of_degrees_of_freedom_are_refused() {
    let circle = Circle::new(vec![0.0; 2], vec![0.0; 2], 1.0).unwrap();
    let error = Piecewise::default().integrate(&Miscounted, &circle, 0.1);
    assert!(matches!(
        error,
        Err(Error::Length {
            expected: 2,
            got: 1,
            ..
        })
    ));
}

#[test]
fn a_coordinate_that_collapses_to_nothing_is_integrated() {
    // The position jumps, and the momentum becomes 0, or nearly so.
    for damping in [0.0, 1e-160] {
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            q[0] += h * q[0].signum();
            p[0] *= damping;
        });
        let circle = Circle::new(vec![0.1], vec![0.2], 1.0).unwrap();
        let found = Piecewise::default().integrate(&map, &circle, 0.5).unwrap();
        assert!(found.continuous.value.abs() < 1e-100, "{damping}");
        let estimate = found.continuous.quadrature_error;
        assert!(
            estimate.is_some_and(|error| error < 1e-100),
            "{damping}: {estimate:?}"
        );
    }
}
