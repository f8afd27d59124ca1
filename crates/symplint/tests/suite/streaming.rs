//! The streaming rule against closed forms, the stencil written out, and the pseudospectral rule.

use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use symplint::error::StateLocation;
use symplint::map::Capabilities;
use symplint::rules::Streaming;
use symplint::{
    Block, Circle, Coordinates, Ensemble, Error, FourierLoop, Loop, LoopIntegral, PerSample, Rule,
    StepFailure, TimeAdvance,
};

/// A loop from functions of s, the same in every degree of freedom but for its size.
struct Curve<Q, P> {
    dof: usize,
    q: Q,
    p: P,
}

impl<Q: Fn(f64) -> f64 + Send + Sync, P: Fn(f64) -> f64 + Send + Sync> Loop for Curve<Q, P> {
    fn dof(&self) -> usize {
        self.dof
    }
    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for i in 0..self.dof {
            for (k, &s) in s.iter().enumerate() {
                block.q.row_mut(i)[k] = (i + 1) as f64 * (self.q)(s);
                block.p.row_mut(i)[k] = (self.p)(s);
            }
        }
    }
}

fn curve(q: impl Fn(f64) -> f64 + Send + Sync, p: impl Fn(f64) -> f64 + Send + Sync) -> impl Loop {
    Curve { dof: 1, q, p }
}

fn streaming(phase_loop: &dyn Loop, samples: usize) -> LoopIntegral {
    let plain = Coordinates::plain(phase_loop.dof());
    let rule = Streaming::default();
    rule.initial(phase_loop, &plain, samples).unwrap()
}

fn pseudospectral(phase_loop: &dyn Loop, samples: usize) -> LoopIntegral {
    let ensemble = Ensemble::sample(phase_loop, samples).unwrap();
    LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap()
}

/// c_1 … c_m by their definition (m!)² / (j (m−j)! (m+j)!).
fn coefficients(m: usize) -> Vec<f64> {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    (1..=m)
        .map(|j| {
            let sign = if j % 2 == 1 { 1.0 } else { -1.0 };
            sign * factorial(m).powi(2) / (j as f64 * factorial(m - j) * factorial(m + j))
        })
        .collect()
}

/// Σ_k p_k Σ_j c_j (q_{k+j} − q_{k−j}) with the whole loop in memory.
fn stencil_written_out(m: usize, q: &[f64], p: &[f64]) -> f64 {
    let n = q.len();
    let (q0, p0) = (q[0], p[0]);
    let mut sum = 0.0;
    for (c, j) in coefficients(m).iter().zip(1..) {
        for k in 0..n {
            sum += c * (p[k] - p0) * ((q[(k + j) % n] - q0) - (q[(k + n - j) % n] - q0));
        }
    }
    sum
}

fn error_and_claim(value: &LoopIntegral, exact: f64) -> (f64, f64) {
    let claim = value.quadrature_error.unwrap() + 2.0 * value.roundoff;
    ((value.value - exact).abs(), claim)
}

#[test]
fn it_is_the_stencil_written_out_at_every_length() {
    // Rough data: nothing is resolved, so every mode counts.
    let rough = curve(
        |s| (37.0 * s).sin() + (s - 0.4).abs(),
        |s| (91.0 * s * s).cos() + if s > 0.7 { 1.0 } else { 0.0 },
    );
    for m in [8, 11, 16] {
        for n in (2 * m + 1..70).chain([101, 128, 4095, 4096, 4111, 4112, 5000]) {
            let ensemble = Ensemble::sample(&rough, n).unwrap();
            let expected = stencil_written_out(m, ensemble.q().row(0), ensemble.p().row(0));
            let rule = Streaming { half_width: m };
            let value = rule.initial(&rough, &Coordinates::plain(1), n).unwrap();
            let error = (value.value - expected).abs();
            assert!(
                error < 1e-13 * value.scale,
                "m = {m}, N = {n}: off by {error:e}"
            );
        }
    }
}

#[test]
fn errors_fall_with_order_2m() {
    // ∮ p dq of mode k: the stencil is off by θ^{2m} (m!)²/(2m+1)! to leading order, θ = 2πk/N.
    for m in [8usize, 10] {
        let rule = Streaming { half_width: m };
        let leading: f64 = (1..=2 * m + 1)
            .map(|k| 1.0 / k as f64)
            .chain((1..=m).map(|k| (k * k) as f64))
            .product();
        let mode = 4.0;
        let phase_loop = curve(|s| (mode * TAU * s).sin(), |s| (mode * TAU * s).cos());
        let off = |n: usize| {
            let value = rule
                .initial(&phase_loop, &Coordinates::plain(1), n)
                .unwrap();
            1.0 - value.value / (mode * PI)
        };
        for n in [48, 56, 64] {
            let theta = mode * TAU / n as f64;
            let expected = leading * theta.powi(2 * m as i32);
            let ratio = off(n) / expected;
            assert!((0.75..1.0).contains(&ratio), "m = {m}, N = {n}: {ratio}");
        }
        let order = (off(48) / off(64)).log2() / (64.0f64 / 48.0).log2();
        assert!((order - 2.0 * m as f64).abs() < 0.7, "m = {m}: {order}");
    }
}

#[test]
fn circles_far_away_and_badly_scaled_are_exact() {
    for (centre, stretch) in [
        (0.0, 1.0),
        (1e3, 1.0),
        (-1e6, 1.0),
        (0.0, 1e8),
        (0.0, 1e-8),
        (10.0, 1e4),
    ] {
        for n in [512, 1000, 4097, 16384] {
            let circle = curve(
                |s| centre + stretch * (TAU * s).sin(),
                |s| centre + (TAU * s).cos(),
            );
            let integral = streaming(&circle, n);
            let error = (integral.value / (PI * stretch) - 1.0).abs();
            let claimed = integral.roundoff / integral.value.abs();
            assert!(
                error < 4.0 * claimed + 1e-15,
                "centre {centre}, {stretch}, N = {n}: {error:e}, claimed {claimed:e}"
            );
            let other = pseudospectral(&circle, n);
            let ratio = integral.roundoff / other.roundoff;
            assert!(
                (0.3..3.0).contains(&ratio),
                "round-off differs {ratio}-fold"
            );
        }
    }
}

#[test]
fn smooth_loops_need_a_few_hundred_samples() {
    let circle = Circle::new(vec![3.0], vec![0.5], 1.0).unwrap();
    for n in [400, 512, 1024] {
        let value = streaming(&circle, n);
        assert!(value.quadrature_error.unwrap() < 1e-15 * PI);
    }
    let ones = [1.0; 3];
    let random = FourierLoop::random(vec![5.0; 3], vec![-1.0; 3], &ones, &ones, 11).unwrap();
    let value = streaming(&random, 512);
    assert!(value.quadrature_error.unwrap() < 1e-14 * value.value);
    let exact = pseudospectral(&random, 512);
    assert!((value.value - exact.value).abs() < 1e-14 * value.value);
    for (a, b) in value.contributions.iter().zip(&exact.contributions) {
        assert!((a - b).abs() < 1e-14);
    }
}

#[test]
fn kinked_loops_stay_within_their_estimate() {
    // q has a kink at a: its part |s − a| closes with another one at a + ½.
    for n in [64, 97, 128, 500, 512, 2048, 5000, 16384] {
        for a in [0.3, 0.25, 0.123_456_7] {
            let tent = move |s: f64| {
                let x = (s - a).rem_euclid(1.0);
                (x - 0.5).abs()
            };
            // ∮ p dq with p = sin 2πs and q a tent of slopes ∓1: by hand, q' = −1 on (a, a + ½), +1
            // on the other half.
            let exact = -(2.0 / PI) * (TAU * a).cos();
            let one = streaming(&curve(tent, |s| (TAU * s).sin()), n);
            let (error, claim) = error_and_claim(&one, exact);
            assert!(error < claim, "N = {n}, a = {a}: {error:e} > {claim:e}");
            assert!(claim < 20.0 / (n * n) as f64, "N = {n}: {claim:e}");
            // The same with the roles of q and p changed: the area changes its sign.
            let other = streaming(&curve(|s| (TAU * s).sin(), tent), n);
            let (error, claim) = error_and_claim(&other, -exact);
            assert!(error < claim, "N = {n}, a = {a}: {error:e} > {claim:e}");
            // Kinks in both, at other places.
            let shifted = move |s: f64| tent(s + 0.1);
            let both = streaming(&curve(tent, shifted), n);
            // p = |…| on q' = ∓1: ∫ over the halves, by hand: 2 (x0 − 2 x0²) with x0 = 0.1 of a tent.
            let of_p = |from: f64| {
                // ∫ of the tent over [from, from + ½] with from in [0, ½).
                let primitive = |x: f64| {
                    if x < 0.5 {
                        0.5 * x - 0.5 * x * x
                    } else {
                        0.125 + 0.5 * (x - 0.5).powi(2)
                    }
                };
                primitive(from + 0.5) - primitive(from)
            };
            let exact = 0.25 - 2.0 * of_p(0.1);
            let (error, claim) = error_and_claim(&both, exact);
            assert!(error < claim, "N = {n}, a = {a}: {error:e} > {claim:e}");
        }
    }
}

#[test]
fn broken_loops_tend_to_the_integral_with_their_breaks_closed_and_say_how_far_off() {
    // q jumps by 1 at a and back at b, p = cos 2πs: chords contribute p(a) − p(b).
    for n in [64, 128, 500, 4096, 16384] {
        for (a, b) in [(0.3, 0.8), (0.1234, 0.4567)] {
            let q = move |s: f64| (TAU * s).sin() + f64::from(s >= a && s < b);
            let exact = PI + (TAU * a).cos() - (TAU * b).cos();
            let value = streaming(&curve(q, |s| (TAU * s).cos()), n);
            let (error, claim) = error_and_claim(&value, exact);
            assert!(error < claim, "N = {n}: {error:e} > {claim:e}");
            assert!(claim < 40.0 / n as f64, "N = {n}: {claim:e}");
            // p jumps, too: what a chord contributes depends on how it is drawn.
            let p = move |s: f64| (TAU * s).cos() + f64::from(s >= a && s < b);
            let value = streaming(&curve(q, p), n);
            assert!(value.quadrature_error.unwrap() > 0.1);
        }
    }
}

#[test]
fn a_winding_loop_has_the_area_under_it() {
    // q runs twice round the period 3 with a wobble, p = 0.7 + 0.2 sin 2πs.
    let (period, turns) = (3.0, 2.0);
    let q = move |s: f64| 0.4 + turns * period * s + 0.1 * (TAU * s).cos();
    let p = |s: f64| 0.7 + 0.2 * (TAU * s).sin();
    let exact = 0.7 * turns * period - 0.02 * PI;
    let coordinates = Coordinates::plain(1).with_periods(vec![period]).unwrap();
    let kinked = move |s: f64| 0.7 + (s - 0.5).abs();
    for n in [256, 333, 512, 5000] {
        let rule = Streaming::default();
        for wrapped in [false, true] {
            let place = move |s: f64| match wrapped {
                true => q(s).rem_euclid(period),
                false => q(s.fract()),
            };
            let value = rule.initial(&curve(place, p), &coordinates, n).unwrap();
            let (error, claim) = error_and_claim(&value, exact);
            assert!(
                error < claim && claim < 1e-13,
                "N = {n}: {error:e} > {claim:e}"
            );
            // A kink in p: ∮ p dq = (0.7 + ¼) 6 + 0.1 ∫ |s − ½| d cos 2πs, which is −2/π² · π ….
            let value = rule
                .initial(&curve(place, kinked), &coordinates, n)
                .unwrap();
            let ensemble = Ensemble::sample(&curve(q, kinked), 1 << 16).unwrap();
            let fine = LoopIntegral::in_coordinates(&ensemble, &Rule::Pseudospectral, &coordinates)
                .unwrap();
            let (error, claim) = error_and_claim(&value, fine.value);
            assert!(error < claim + 1e-9, "N = {n}: {error:e} > {claim:e}");
        }
    }
}

#[test]
fn weights_make_momenta_canonical() {
    let circle = Circle::new(vec![0.0; 3], vec![0.0; 3], 1.0).unwrap();
    // Samples of all degrees of freedom are the same, and so are the sums of their sizes.
    let circle = circle.with_phases(symplint::Phases::Equal);
    let weights = Coordinates::plain(3)
        .with_weights(vec![1.0, -2.0, 0.5])
        .unwrap();
    let weighted = Streaming::default()
        .initial(&circle, &weights, 512)
        .unwrap();
    let plain = streaming(&circle, 512);
    assert_eq!(weighted.contributions[1], -2.0 * plain.contributions[1]);
    assert!((weighted.value + 0.5 * plain.contributions[0]).abs() < 1e-14);
    assert!((weighted.scale / plain.scale - 3.5 / 3.0).abs() < 1e-14);
}

/// A random loop of one degree of freedom: amplitudes of modes 1, 2, … that fall as `decay` says.
fn fourier(amplitudes: &[[f64; 4]], decay: &dyn Fn(f64) -> f64) -> (impl Loop + use<>, f64) {
    let modes: Vec<[f64; 4]> = (amplitudes.iter().zip(1..))
        .map(|(a, k)| a.map(|a| a * decay(f64::from(k))))
        .collect();
    // ∮ p dq of modes a cos + b sin: π k (p_cos q_sin − p_sin q_cos).
    let exact = (modes.iter().zip(1..))
        .map(|(&[qc, qs, pc, ps], k)| PI * f64::from(k) * (pc * qs - ps * qc))
        .sum();
    let others = modes.clone();
    let at = |modes: &[[f64; 4]], first: usize, s: f64| {
        let terms = modes.iter().zip(1..).map(|(mode, k)| {
            let (sin, cos) = (TAU * (f64::from(k) * s).fract()).sin_cos();
            mode[first] * cos + mode[first + 1] * sin
        });
        terms.sum::<f64>()
    };
    let phase_loop = curve(move |s| at(&modes, 0, s), move |s| at(&others, 2, s));
    (phase_loop, exact)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Whatever the modes are, the true integral is within the estimate: resolved, half resolved, aliased.
    #[test]
    fn estimates_hold_on_random_loops(
        amplitudes in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 150),
        samples in 40usize..400,
        rate in 0.0f64..1.0,
        algebraic in any::<bool>(),
    ) {
        let (phase_loop, exact) = fourier(&amplitudes, &|k| match algebraic {
            true => k.powf(-1.2 - 4.0 * rate),
            false => (-k * (0.15 + rate)).exp(),
        });
        let value = streaming(&phase_loop, samples);
        let (error, claim) = error_and_claim(&value, exact);
        prop_assert!(
            error <= claim,
            "N = {samples}, rate {rate}, algebraic {algebraic}: {error:e} > {claim:e}"
        );
    }

    /// It agrees with the pseudospectral rule within both estimates.
    #[test]
    fn rules_agree_within_their_estimates(
        amplitudes in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 60),
        samples in 40usize..600,
        rate in 0.1f64..1.0,
    ) {
        let (phase_loop, _) = fourier(&amplitudes, &|k| (-k * rate).exp());
        let value = streaming(&phase_loop, samples);
        let other = pseudospectral(&phase_loop, samples);
        let (distance, claim) = error_and_claim(&value, other.value);
        let claims = claim + other.quadrature_error.unwrap() + 2.0 * other.roundoff;
        prop_assert!(distance <= claims, "N = {samples}, rate {rate}: {distance:e} > {claims:e}");
    }
}

/// A kick by a force, then a drift.
fn kick(force: impl Fn(f64) -> f64 + Send + Sync, dof: usize) -> impl TimeAdvance {
    PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
        for (q, p) in q.iter_mut().zip(p) {
            *p += h * force(*q);
            *q += h * *p;
        }
    })
}

#[test]
fn results_do_not_depend_on_threads_nor_on_the_other_degrees_of_freedom() {
    let map = kick(|q| -q.sin(), 700);
    let circle = |dof: usize| {
        let centres = (0..dof).map(|i| (i as f64).sin()).collect();
        Circle::new(centres, vec![0.5; dof], 1.0).unwrap()
    };
    // In 700 degrees of freedom a window has 1488 new samples, in one 4096.
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let rule = Streaming::default();
            rule.integrate(&map, &circle(700), 0.5, 2000)
                .unwrap()
                .integral
        })
    };
    let one = run(1);
    for threads in [2, 3] {
        let other = run(threads);
        assert_eq!(other.value.to_bits(), one.value.to_bits());
        assert_eq!(other.contributions, one.contributions);
        assert_eq!(other.quadrature_error, one.quadrature_error);
        assert_eq!(other.roundoff, one.roundoff);
    }
    let alone = Streaming::default()
        .integrate(&kick(|q| -q.sin(), 1), &circle(1), 0.5, 2000)
        .unwrap()
        .integral;
    assert_eq!(alone.value.to_bits(), one.contributions[0].to_bits());
}

#[test]
fn breaks_are_found_where_they_are() {
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    let jumps = kick(|q| -(q - 0.3).signum(), 1);
    for samples in [48, 64, 257, 512, 5000] {
        let found = Streaming::default()
            .integrate(&jumps, &circle, 0.5, samples)
            .unwrap()
            .found
            .expect("the force jumps");
        let expected = 0.3f64.asin() / TAU;
        let distance = (found.s - expected)
            .abs()
            .min((found.s + expected - 0.5).abs());
        assert!(distance < 1e-13, "{samples} samples: s = {}", found.s);
        assert!((found.jump_p.abs() - 1.0).abs() < 1e-9);
    }
    let none: [fn(f64) -> f64; 4] = [
        |q| -q.sin(),
        |q| -(q - 0.3).abs(),
        |q| -(q - 0.3) / (q - 0.3).hypot(1e-5),
        |q| f64::from((q as f32).sin()),
    ];
    for force in none {
        for samples in [64, 512, 4096] {
            let value = Streaming::default()
                .integrate(&kick(force, 1), &circle, 0.5, samples)
                .unwrap();
            assert_eq!(value.found, None, "{samples} samples");
        }
    }
}

#[test]
fn the_grid_is_measured_in_cells() {
    struct Grid;
    impl TimeAdvance for Grid {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, _h: f64, _block: &mut Block<'_>) -> Result<(), StepFailure> {
            Ok(())
        }

        fn capabilities(&self) -> Capabilities<'_> {
            let periodic = Coordinates::plain(1).with_periods(vec![10.0]).unwrap();
            Capabilities::of_coordinates(periodic.with_grid_spacing(0.1).unwrap())
        }
    }
    // q runs ten times as far as it needs to go in half a turn.
    let circle = Circle::new(vec![9.5], vec![0.0], 1.0).unwrap();
    let found = Streaming::default()
        .integrate(&Grid, &circle, 1.0, 64)
        .unwrap();
    // The steepest cells lie next to s = 0 and ½: sin 2π/64.
    let expected = (TAU / 64.0).sin() / 0.1;
    assert!((found.cells_apart / expected - 1.0).abs() < 1e-12);
    assert_eq!(found.evaluations, 74);
}

#[test]
fn what_means_nothing_is_refused() {
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    let plain = Coordinates::plain(1);
    let rule = Streaming::default();
    for samples in [0, 1, 3, 20] {
        let error = rule.initial(&circle, &plain, samples).unwrap_err();
        let expected = Error::StencilTooWide {
            samples,
            half_width: 10,
        };
        assert_eq!(error, expected);
        assert!(error.to_string().contains("spans 21 samples"), "{error}");
    }
    assert!(rule.initial(&circle, &plain, 21).is_ok());
    for half_width in [0, 7, 17, usize::MAX] {
        let error = Streaming { half_width }.initial(&circle, &plain, 512);
        assert!(
            matches!(error, Err(Error::OutOfRange { .. })),
            "{half_width}"
        );
    }
    let error = rule.initial(&circle, &Coordinates::plain(2), 512);
    assert!(matches!(error, Err(Error::Length { .. })));
    let error = rule.integrate(&kick(|q| q, 2), &circle, 0.1, 512);
    assert!(matches!(error, Err(Error::DofMismatch { .. })));
    let huge = Circle::new(vec![0.0], vec![0.0], 1e160).unwrap();
    let error = rule.initial(&huge, &plain, 512);
    assert!(matches!(error, Err(Error::Overflow { dof: 0, .. })));
}

#[test]
fn states_that_are_not_finite_are_named_by_their_sample() {
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    for (samples, bad) in [(64, 3), (64, 60), (5000, 4321)] {
        let at = bad as f64 / samples as f64;
        let phase_loop = curve(
            move |s| if s == at { f64::NAN } else { (TAU * s).sin() },
            |s| (TAU * s).cos(),
        );
        let error = Streaming::default()
            .initial(&phase_loop, &Coordinates::plain(1), samples)
            .unwrap_err();
        assert!(
            matches!(error, Error::NotFinite { at: StateLocation::Sample(sample), step_size: None, .. } if sample == bad),
            "{error}"
        );
        let place = (TAU * at).sin();
        let map = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
            if (q[0] - place).abs() < 1e-12 {
                p[0] = f64::INFINITY;
            }
        });
        let error = Streaming::default()
            .integrate(&map, &circle, 0.25, samples)
            .unwrap_err();
        let Error::NotFinite {
            at: StateLocation::Sample(sample),
            step_size: Some(0.25),
            coordinate: "p",
            ..
        } = error
        else {
            panic!("{error}");
        };
        let s = sample as f64 / samples as f64;
        assert!(((TAU * s).sin() - place).abs() < 1e-9, "sample {sample}");
    }
}
