//! Maps and loops with features that a few pieces, or a few samples, step over: numbers must come with an
//! error that covers them, and verdicts must not be wrong.

mod steep;
mod strips;
mod under_resolved;

use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

use symplint::error::StateLocation;
use symplint::map::{Capabilities, Parts, Substeps};
use symplint::rules::Piecewise;
use symplint::{
    Block, Circle, Coordinates, Diagnostic, Error, Loop, LoopIntegral, PerSample, StepFailure,
    TimeAdvance, VerdictKind,
};

fn circle(q0: f64, p0: f64) -> Circle {
    Circle::new(vec![q0], vec![p0], 1.0).unwrap()
}

/// A kick by any force of q alone and a drift: symplectic, if the force is continuous.
fn kick_drift(force: impl Fn(f64) -> f64 + Send + Sync) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * force(q[0]);
        q[0] += h * p[0];
    })
}

fn assert_covered(found: &LoopIntegral, exact: f64) {
    let (off, error) = (
        (found.value - exact).abs(),
        found.quadrature_error.unwrap_or(f64::INFINITY) + found.roundoff,
    );
    assert!(off <= error, "off by {off:e}, estimate {error:e}");
}

#[test]
fn a_narrow_force_is_not_called_not_symplectic() {
    // The loop crosses each of them twice; samples may meet the one crossing and miss the other.
    for width in [1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6] {
        let gauss = kick_drift(move |q| (-((q - 0.3) / width).powi(2)).exp());
        let tent = kick_drift(move |q| (1.0 - ((q - 0.3) / width).abs()).max(0.0));
        for (name, map) in [
            ("gauss", &gauss as &dyn TimeAdvance),
            ("tent", &tent as &dyn TimeAdvance),
        ] {
            let found = Diagnostic::default().run(map, &circle(0.1, 0.2)).unwrap();
            assert_ne!(
                found.verdict.kind,
                VerdictKind::NotSymplectic,
                "{name} of {width}: {}",
                found.verdict
            );
        }
    }
}

/// A circle with a narrow bump in p.
struct Bumped;

impl Loop for Bumped {
    fn dof(&self) -> usize {
        1
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for (k, &s) in s.iter().enumerate() {
            let bump = 0.5 * (-((s.rem_euclid(1.0) - 0.195) / 0.0012).powi(2)).exp();
            block.q.row_mut(0)[k] = 0.2 + (TAU * s).sin();
            block.p.row_mut(0)[k] = 0.3 + (TAU * s).cos() + bump;
        }
    }
}

#[test]
fn a_narrow_feature_of_the_loop_counts_before_the_step_as_after_it() {
    let kinked = Diagnostic::default()
        .run(&kick_drift(f64::abs), &Bumped)
        .unwrap();
    assert_ne!(kinked.verdict.kind, VerdictKind::NotSymplectic);
    let broken = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        q[0] += h * p[0];
        p[0] -= h * if q[0] < 0.0 { -1.0 } else { 1.0 };
    });
    let found = Diagnostic::default().run(&broken, &Bumped).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::BrokenLoops);
    assert!(!found.verdict.summary().contains("change even with"));
}

#[test]
fn a_stretch_too_short_to_resolve_is_covered_by_the_error() {
    // q jumps between two jumps of p, 3e-12 of the loop apart, far from p = 0.
    let map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        let s = (q[0].atan2(p[0] - 100.0) / TAU).rem_euclid(1.0);
        p[0] += f64::from(s >= 0.1) + f64::from(s >= 0.1 + 6e-12);
        q[0] += 0.3 * f64::from(s >= 0.1 + 3e-12);
    });
    let found = Piecewise::default()
        .integrate(&map, &circle(0.0, 100.0), 1.0)
        .unwrap();
    assert_covered(&found.continuous, PI - 2.0 * (TAU * 0.1).sin());
}

/// A circle that is run through this number of times.
struct Turns(f64);

impl Loop for Turns {
    fn dof(&self) -> usize {
        1
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for (k, &s) in s.iter().enumerate() {
            let (sin, cos) = (TAU * self.0 * s).sin_cos();
            (block.q.row_mut(0)[k], block.p.row_mut(0)[k]) = (sin, cos);
        }
    }
}

#[test]
fn no_number_of_turns_hides_between_the_first_states() {
    let rest = PerSample::new(1, |_, _: &mut [f64], _: &mut [f64]| {});
    for turns in [1.0, 4.0, 12.0, 24.0, 48.0, 192.0] {
        let found = Piecewise::default().integrate(&rest, &Turns(turns), 0.5);
        assert_covered(&found.unwrap().continuous, turns * PI);
    }
}

/// Half kicks by a force that jumps at q = 1/4, and drifts.
struct Kicks(&'static [char]);

impl TimeAdvance for Kicks {
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

impl Substeps for Kicks {
    fn substeps(&self) -> usize {
        self.0.len()
    }

    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            match self.0[k] {
                'T' => *q += h * *p,
                _ => *p -= 0.5 * h * if *q < 0.25 { -1.0 } else { 1.0 },
            }
        }
        Ok(())
    }
}

#[test]
fn segments_between_neighbouring_doubles_do_not_turn_back() {
    // The second of two kicks in a row meets the segment that the first one opened.
    let map = Kicks(&['V', 'T', 'V', 'V', 'T', 'V']);
    let found = Piecewise::default()
        .integrate(&map, &circle(0.0, 0.0), 0.5)
        .unwrap();
    assert!(found.evaluations < 10_000, "{}", found.evaluations);
    assert!((found.closed().value - PI).abs() < 1e-12);
}

#[test]
fn a_break_at_the_start_of_the_loop_costs_no_more_than_another() {
    // q = 0 at s = 0 belongs to the lower side.
    let map = kick_drift(|q| if q > 0.0 { 1.0 } else { -1.0 });
    let found = Piecewise::default()
        .integrate(&map, &circle(0.0, 0.0), 0.5)
        .unwrap();
    assert!(found.evaluations <= 400, "{}", found.evaluations);
    assert_eq!(found.breaks.len(), 2);
}

/// Kick by a staircase of `k` stairs a unit, and drift; ∮ p dq of the pieces of the circle round (0.13, 0.2),
/// and the number of breaks.
fn staircase(k: f64, h: f64) -> (impl TimeAdvance, f64, usize) {
    let half_square = |x: f64| 0.5 * x * x;
    let (mut exact, mut breaks) = (PI, 0);
    for stair in (-0.87 * k).ceil() as i64..=(1.13 * k).floor() as i64 {
        let distance = stair as f64 / k - 0.13;
        if distance.abs() >= 1.0 {
            continue;
        }
        let r = (1.0 - distance * distance).sqrt();
        let [above, below] = [stair, stair - 1].map(|stair| -h * stair as f64 / k);
        exact -= h
            * (half_square(0.2 + r + above) - half_square(0.2 + r + below)
                + half_square(0.2 - r + below)
                - half_square(0.2 - r + above));
        breaks += 2;
    }
    (kick_drift(move |q| (k * q).floor() / k), exact, breaks)
}

#[test]
fn dense_breaks_are_no_noise() {
    for k in [10.0, 150.0, 300.0, 600.0, 1000.0, 1500.0] {
        let (map, exact, breaks) = staircase(k, 0.5);
        let found = Piecewise::default()
            .integrate(&map, &circle(0.13, 0.2), 0.5)
            .unwrap();
        assert_covered(&found.continuous, exact);
        assert_eq!(found.breaks.len(), breaks, "{k} stairs");
    }
}

#[test]
fn a_state_that_fails_between_the_samples_is_named_by_its_place_on_the_loop() {
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        let x = q[0] - 0.3;
        p[0] += if x.abs() < 1e-7 {
            f64::NAN
        } else {
            h * x.signum()
        };
        q[0] += h * p[0];
    });
    let error = Diagnostic::default()
        .run(&map, &circle(0.0, 0.0))
        .unwrap_err();
    let (Error::NotFinite { at, .. } | Error::StepFailed { at, .. }) = &error else {
        panic!("{error}");
    };
    let StateLocation::Loop(s) = *at else {
        panic!("{error}");
    };
    let expected = 0.3f64.asin() / TAU;
    let off = (s - expected).abs().min((s - 0.5 + expected).abs());
    assert!(off < 1e-7, "{error}");
    // The sample is one of a batch of the rule: the message has s alone.
    let text = error.to_string();
    assert!(!text.contains("at sample"), "{text}");
    assert!(text.contains(&format!("s = {s:?} of the loop")), "{text}");
    // And that s shows it again.
    assert!(((TAU * s).sin() - 0.3).abs() < 1e-7, "{text}");
}

/// Kick by a force that jumps, drift, smooth kick and drift, on a cylinder of circumference 1.
struct OpensWide {
    jump: f64,
    kick: f64,
    drift: f64,
}

impl TimeAdvance for OpensWide {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.substeps()).try_for_each(|k| self.advance_substep(k, h, block))
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: Some(self),
            ..Capabilities::of_coordinates(Coordinates::plain(1).with_periods(vec![1.0]).unwrap())
        }
    }
}

impl Substeps for OpensWide {
    fn substeps(&self) -> usize {
        4
    }

    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            let sin = (TAU * *q).sin();
            match k {
                0 => *p += h * self.jump * if sin < 0.0 { -1.0 } else { 1.0 },
                1 => *q += 0.5 * h * *p,
                2 => *p += h * self.kick * sin,
                _ => *q += self.drift * h * *p,
            }
        }
        Ok(())
    }
}

#[test]
fn breaks_that_open_by_more_than_half_a_period_are_closed_all_the_same() {
    for (jump, kick) in [(0.2, 0.1), (0.35, 0.05), (0.5, 0.2)] {
        for (drift, p0) in [(0.5, 0.0), (0.7, 0.3), (1.0, 1.0)] {
            let map = OpensWide { jump, kick, drift };
            let circle = Circle::new(vec![0.1], vec![p0], 0.3).unwrap();
            let found = Piecewise::default().integrate(&map, &circle, 1.0).unwrap();
            assert_covered(&found.closed(), 0.09 * PI);
            assert!(found.closed().quadrature_error < Some(1e-9));
        }
    }
}

/// A kick by a force that jumps twice within `gap` at q = a, by `j` each time, and a drift of h = ½; ∮ p·dq
/// between the breaks of the unit circle.
fn two_jumps(j: f64, a: f64, gap: f64) -> (impl TimeAdvance, f64) {
    let map = kick_drift(move |q| j * (f64::from(q > a) + f64::from(q > a + gap) - 1.0));
    // The distance of the two jumps is lost in rounding.
    let half_square = |x: f64| 0.5 * x * x;
    let (p, j) = ((1.0 - a * a).sqrt(), 0.5 * j);
    let lost = half_square(p - j) - half_square(p + j) + half_square(-p + j) - half_square(-p - j);
    (map, PI - 0.5 * lost)
}

#[test]
fn two_jumps_next_to_each_other_are_no_noise() {
    let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
    for j in [1e-5, 9e-7, 1e-7, 1e-8, 1e-9] {
        for a in [0.0, 0.25, 0.3, 0.31, 0.5] {
            let (_, exact) = two_jumps(j, a, 0.0);
            // numpy's sign, 0 at 0.
            let map = kick_drift(move |q| j * sign(q - a));
            let found = Piecewise::default().integrate(&map, &circle(0.0, 0.0), 0.5);
            let found = found.unwrap();
            assert_covered(&found.continuous, exact);
            assert!(
                found.evaluations < 1_500,
                "{j:e} at {a}: {}",
                found.evaluations
            );
            for gap in [1e-15, 1e-14, 3e-14, 1e-13, 1e-12] {
                let (map, exact) = two_jumps(j, a, gap);
                let found = Piecewise::default().integrate(&map, &circle(0.0, 0.0), 0.5);
                assert_covered(&found.unwrap().continuous, exact);
            }
        }
    }
}

#[test]
fn breaks_where_the_loop_only_grazes_a_threshold_are_covered() {
    let half_square = |x: f64| 0.5 * x * x;
    for depth in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-15] {
        let a: f64 = 1.0 - depth;
        let p = ((1.0 - a) * (1.0 + a)).sqrt();
        let lost = half_square(p - 0.5) - half_square(p + 0.5) + half_square(0.5 - p)
            - half_square(-p - 0.5);
        // The force at the threshold is that below it, that above it, or none.
        for at_threshold in [-1.0, 1.0, 0.0] {
            let force = move |q: f64| match q {
                q if q == a => at_threshold,
                q => (q - a).signum(),
            };
            let whole = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
                p[0] -= 0.5 * force(q[0]);
                q[0] += 0.5 * p[0];
            });
            // The same between drifts, there and back: the loop itself is far from its turning point.
            let within = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
                q[0] -= 0.7 * p[0];
                p[0] -= 0.5 * force(q[0]);
                q[0] += 0.5 * p[0];
            });
            let unit = circle(0.0, 0.0);
            for (name, map, phase_loop) in [
                ("whole", &whole as &dyn TimeAdvance, &unit as &dyn Loop),
                ("within", &within, &Sheared),
            ] {
                let found = Piecewise::default()
                    .integrate(map, phase_loop, 0.5)
                    .unwrap();
                assert_covered(&found.continuous, PI - 0.5 * lost);
                // If the rounding of a difference decides whether there is a force, no double is like the
                // next, and that stretch is not resolved.
                if name == "within" && at_threshold == 0.0 {
                    continue;
                }
                // They say nothing of the closed integral, and little where nothing is grazed.
                let closed = found.closed();
                assert!((closed.value - PI).abs() < 1e-12, "{name} at {depth:e}");
                assert!(closed.quadrature_error < Some(1e-10), "{name} at {depth:e}");
                if depth > 1e-3 {
                    assert!(found.continuous.quadrature_error < Some(1e-10));
                }
            }
        }
    }
}

/// The circle that a drift by 0.7 has passed.
struct Sheared;

impl Loop for Sheared {
    fn dof(&self) -> usize {
        1
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for (k, &s) in s.iter().enumerate() {
            let (sin, cos) = (TAU * s).sin_cos();
            block.q.row_mut(0)[k] = sin + 0.7 * cos;
            block.p.row_mut(0)[k] = cos;
        }
    }
}

/// Noise below `size` that depends on every bit of q, for q in a range.
fn noise_of(q: f64, size: f64, range: std::ops::Range<f64>) -> f64 {
    let bits = q.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let unit = (bits ^ (bits >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
    let centred = unit as f64 / (1u64 << 53) as f64 - 0.5;
    if range.contains(&q) {
        size * centred
    } else {
        0.0
    }
}

#[test]
fn noise_on_a_part_of_the_loop_is_learned_there() {
    for size in [1e-9, 1e-7, 1e-5] {
        for drift in [0.0, 0.5] {
            let map = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
                p[0] += noise_of(q[0], size, 0.6..0.65);
                q[0] += drift * p[0];
            });
            let found = Piecewise::default()
                .integrate(&map, &circle(0.0, 0.0), 1.0)
                .unwrap();
            assert!(found.evaluations < 20_000, "{}", found.evaluations);
            assert_covered(&found.continuous, PI);
            assert!(found.continuous.quadrature_error < Some(100.0 * size));
        }
    }
    // Of a kick that is smooth elsewhere, the verdict is good to that noise.
    let map = kick_drift(|q| q.abs() + noise_of(q, 1e-9, 0.6..0.65));
    let verdict = Diagnostic::halving(-1, -5)
        .run(&map, &circle(0.1, 0.2))
        .unwrap()
        .verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict}");
    assert!(verdict.digits > Some(8.5), "{verdict}");
}

#[test]
fn a_map_that_rounds_to_a_grid_is_noisy() {
    // Equispaced places on equispaced grids can look smooth, and every step of a grid is a jump.
    for drift in [0.0, 0.3, 0.5] {
        let map = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
            p[0] += f64::from((q[0] as f32).abs());
            q[0] += drift * p[0];
        });
        let found = Piecewise::default()
            .integrate(&map, &circle(0.0, 0.0), 1.0)
            .unwrap();
        assert!(found.evaluations < 50_000, "{}", found.evaluations);
        assert_covered(&found.continuous, PI);
        assert!(found.continuous.quadrature_error < Some(1e-6));
        assert!(found.breaks.is_empty(), "{:?}", found.breaks);
    }
}

#[test]
fn no_more_states_are_advanced_than_may_be() {
    let oscillating = kick_drift(|q| (3000.0 * q).cos());
    let rounded = kick_drift(|q| f64::from((1e3 * q) as f32).floor() / 1e3);
    let (stairs, ..) = staircase(100.0, 0.5);
    let substeps = Kicks(&['V', 'T', 'V', 'V', 'T', 'V']);
    for (name, map) in [
        ("oscillating", &oscillating as &dyn TimeAdvance),
        ("rounded", &rounded),
        ("stairs", &stairs),
        ("substeps", &substeps),
    ] {
        for most_evaluations in [72, 100, 500, 2_000, 10_000, 50_000] {
            let advanced = AtomicUsize::new(0);
            let counted = Counted {
                map,
                advanced: &advanced,
            };
            let rule = Piecewise {
                most_evaluations,
                ..Piecewise::default()
            };
            let found = rule.integrate(&counted, &circle(0.13, 0.2), 0.5).unwrap();
            assert!(
                found.evaluations <= most_evaluations,
                "{name}: {} of {most_evaluations}",
                found.evaluations
            );
            // Starts of closing segments go through the rest of the step only.
            if Parts::of(map).count() == 1 {
                assert_eq!(found.evaluations, advanced.into_inner(), "{name}");
            }
            // And they are put to use.
            if !found.unresolved.is_empty() {
                let used = found.evaluations as f64 / most_evaluations as f64;
                assert!(most_evaluations < 500 || used > 0.7, "{name}: {used}");
            }
        }
    }
}

/// A map that counts the states that it advances.
struct Counted<'a> {
    map: &'a dyn TimeAdvance,
    advanced: &'a AtomicUsize,
}

impl TimeAdvance for Counted<'_> {
    fn dof(&self) -> usize {
        self.map.dof()
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.advanced.fetch_add(block.len(), Ordering::Relaxed);
        self.map.advance(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            substeps: (self.map.capabilities().substeps).map(|_| self as &dyn Substeps),
            ..Capabilities::plain(self.dof())
        }
    }
}

impl Substeps for Counted<'_> {
    fn substeps(&self) -> usize {
        Parts::of(self.map).count()
    }

    fn advance_substep(&self, k: usize, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        Parts::of(self.map).advance(k, h, block)
    }
}

#[test]
fn maps_that_do_not_round_are_not_reported_as_rounded() {
    // Exact on a loop of few digits: q of the first is of three decimals, and p of the second, at rest, becomes h q.
    let samples = 64;
    let mut printed = symplint::Ensemble::zeros(2, samples);
    let rounded = |x: f64| (x * 1e3).round() / 1e3;
    for k in 0..samples {
        let turn = TAU * k as f64 / samples as f64;
        printed.block().q.row_mut(0)[k] = rounded(turn.cos());
        printed.block().p.row_mut(0)[k] = rounded(turn.sin());
    }
    let springs = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        let stretch = q[1] - q[0];
        p[0] += h * stretch;
        p[1] -= h * stretch;
        q[0] += h * p[0];
        q[1] += h * p[1];
    });
    let printed = symplint::SampledLoop::new(printed, &Coordinates::plain(2)).unwrap();
    let found = Diagnostic::default().run(&springs, &printed);
    let evidence = found.unwrap().verdict.sentences().join(" ");
    assert!(!evidence.contains("rounds"), "{evidence}");
}

#[test]
fn a_state_that_fails_beside_the_samples_takes_no_verdict_back() {
    // Sample 15 of 64, which is not one of 33 samples.
    let hole = circle(0.1, 0.2);
    let at = symplint::Ensemble::sample(&hole, 64).unwrap();
    let hole_q = at.q().row(0)[15];
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= if q[0] == hole_q { f64::NAN } else { h * q[0] };
        q[0] += h * p[0];
    });
    let found = Diagnostic {
        samples: symplint::diagnosis::SampleCount::Fixed(33),
        loops: 1,
        jacobian: false,
        localise: false,
        ..Diagnostic::default()
    }
    .run(&map, &hole);
    assert_eq!(found.unwrap().verdict.kind, VerdictKind::Symplectic);
}
