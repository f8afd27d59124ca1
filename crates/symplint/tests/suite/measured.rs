//! Loops measured from samples, with answers known from theory.

use std::f64::consts::{PI, TAU};

use symplint::verdict::CauseKind;
use symplint::{
    Circle, Coordinates, Diagnosis, Ensemble, Error, FourierLoop, Loop, PerSample, Snapshot,
    TimeAdvance, VerdictKind, measure,
};

type Step = fn(f64, &mut [f64], &mut [f64]);

fn leapfrog(h: f64, q: &mut [f64], p: &mut [f64]) {
    q[0] += 0.5 * h * p[0];
    p[0] -= h * q[0].sin();
    q[0] += 0.5 * h * p[0];
}

fn midpoint(h: f64, q: &mut [f64], p: &mut [f64]) {
    let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0].sin());
    q[0] += h * p_half;
    p[0] -= h * q_half.sin();
}

/// Momentum-first and position-first Strang splitting on H = p²/2 + |q|.
fn position_first(h: f64, q: &mut [f64], p: &mut [f64]) {
    q[0] += 0.5 * h * p[0];
    p[0] -= h * if q[0] < 0.0 { -1.0 } else { 1.0 };
    q[0] += 0.5 * h * p[0];
}

fn circle(q0: f64, p0: f64) -> Circle {
    Circle::new(vec![q0], vec![p0], 1.0).unwrap()
}

/// One ensemble, changed state by state.
fn changed(ensemble: &Ensemble, change: impl Fn(&mut f64, &mut f64)) -> Ensemble {
    let mut ensemble = ensemble.clone();
    let mut block = ensemble.block();
    for i in 0..block.dof() {
        let rows = block
            .q
            .row_mut(i)
            .iter_mut()
            .zip(block.p.row_mut(i).iter_mut());
        rows.for_each(|(q, p)| change(q, p));
    }
    ensemble
}

/// The loop and its images after steps of these sizes, each changed as a file might change it.
fn snapshots(
    step: Step,
    phase_loop: &dyn Loop,
    samples: usize,
    sizes: &[f64],
    change: impl Fn(&mut f64, &mut f64),
) -> (Snapshot, Vec<Snapshot>) {
    let map = PerSample::new(1, step);
    let before = Ensemble::sample(phase_loop, samples).unwrap();
    let after = sizes.iter().map(|&h| {
        let mut after = before.clone();
        after.advance(&map as &dyn TimeAdvance, h).unwrap();
        Snapshot::new(changed(&after, &change)).after_step(h)
    });
    let after = after.collect();
    (Snapshot::new(changed(&before, &change)), after)
}

fn plain(step: Step, phase_loop: &dyn Loop, samples: usize, sizes: &[f64]) -> Diagnosis {
    let (before, after) = snapshots(step, phase_loop, samples, sizes, |_, _| {});
    measure(&before, &after, &Coordinates::plain(1)).unwrap()
}

const HALVING: [f64; 6] = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625];

#[test]
fn smooth_maps_are_told_apart() {
    for samples in [64, 100, 256, 1024, 4096] {
        let good = plain(leapfrog, &circle(1.0, 0.5), samples, &HALVING).verdict;
        assert_eq!(good.kind, VerdictKind::Symplectic, "{samples}: {good:?}");
        assert!(good.digits.unwrap() > 12.0, "{samples}: {good:?}");
        let bad = plain(midpoint, &circle(1.0, 0.5), samples, &HALVING).verdict;
        assert_eq!(bad.kind, VerdictKind::NotSymplectic, "{samples}: {bad:?}");
        assert_eq!(bad.order, Some(3.0), "{samples}");
    }
}

#[test]
fn without_step_sizes_there_is_a_verdict_but_no_order() {
    let (before, mut after) = snapshots(midpoint, &circle(1.0, 0.5), 256, &HALVING, |_, _| {});
    after
        .iter_mut()
        .for_each(|snapshot| snapshot.step_size = None);
    let diagnosis = measure(&before, &after, &Coordinates::plain(1)).unwrap();
    assert_eq!(diagnosis.verdict.kind, VerdictKind::NotSymplectic);
    assert_eq!(diagnosis.verdict.order, None);
    assert!(
        diagnosis
            .points()
            .iter()
            .all(|point| point.step_size.is_nan())
    );
    assert!(
        diagnosis
            .verdict
            .advice()
            .iter()
            .any(|text| text.contains("step sizes"))
    );
    assert!(!diagnosis.verdict.to_string().contains("NaN"));
}

#[test]
fn the_absolute_value_breaks_loops_as_its_closed_forms_say() {
    for samples in [64, 256, 1024, 8192] {
        for h in [1.9, 0.5, 0.1] {
            let diagnosis = plain(position_first, &circle(0.0, 0.0), samples, &[h]);
            let point = &diagnosis.points()[0];
            let expected = 4.0 * h * h / (h * h + 4.0).sqrt() / PI;
            let off = (point.signed_defect - expected).abs();
            let what = format!("{samples} samples, h = {h}: {point:?}");
            assert!(off <= point.quadrature_error.unwrap(), "{what}");
            assert!(
                point.quadrature_error.unwrap() < 40.0 / samples as f64,
                "{what}"
            );
            // Symplectic pieces: closed by chords, nothing is lost.
            assert!(
                point.closed_defect.unwrap() < 20.0 / samples as f64,
                "{what}"
            );
            assert_eq!(diagnosis.verdict.kind, VerdictKind::BrokenLoops, "{what}");
            assert_eq!(point.jumps, Some(2), "{what}");
        }
    }
}

#[test]
fn a_shift_of_the_origin_changes_nothing() {
    for step in [midpoint as Step, position_first] {
        let here = plain(step, &circle(0.2, 0.5), 1024, &[0.5]);
        let (before, after) = snapshots(step, &circle(0.2, 0.5), 1024, &[0.5], |q, _| *q += 1e3);
        let there = measure(&before, &after, &Coordinates::plain(1)).unwrap();
        assert_eq!(here.verdict.kind, there.verdict.kind);
        let (a, b) = (&here.points()[0], &there.points()[0]);
        assert_eq!(
            (a.rule, a.jumps, a.omitted_cells),
            (b.rule, b.jumps, b.omitted_cells)
        );
        assert!((a.signed_defect - b.signed_defect).abs() < 1e-11);
    }
}

#[test]
fn single_precision_has_the_floor_that_belongs_to_it() {
    let single = |x: &mut f64| *x = f64::from(*x as f32);
    for samples in [64, 256, 4096, 65536] {
        let round = |q: &mut f64, p: &mut f64| {
            single(q);
            single(p);
        };
        let (before, after) = snapshots(leapfrog, &circle(1.0, 0.5), samples, &HALVING, round);
        let known = |snapshot: Snapshot| snapshot.with_unit_roundoff(Snapshot::SINGLE);
        let after: Vec<Snapshot> = after.into_iter().map(known).collect();
        let verdict = measure(&known(before), &after, &Coordinates::plain(1))
            .unwrap()
            .verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::Symplectic,
            "{samples}: {verdict:?}"
        );
        assert!(
            (6.0..9.0).contains(&verdict.digits.unwrap()),
            "{samples}: {verdict:?}"
        );
    }
}

#[test]
fn a_step_in_single_precision_is_not_called_wrong() {
    fn in_single(h: f64, q: &mut [f64], p: &mut [f64]) {
        let (h, mut x, mut v) = (h as f32, q[0] as f32, p[0] as f32);
        x += 0.5 * h * v;
        v -= h * x.sin();
        x += 0.5 * h * v;
        (q[0], p[0]) = (f64::from(x), f64::from(v));
    }
    fn force_in_single(h: f64, q: &mut [f64], p: &mut [f64]) {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * f64::from((q[0] as f32).sin());
        q[0] += 0.5 * h * p[0];
    }
    // Whether or not the files state it.
    for (step, samples) in [64, 256, 1024, 4096, 32768]
        .into_iter()
        .flat_map(|samples| [(in_single as Step, samples), (force_in_single, samples)])
    {
        for (q0, p0) in [(1.0, 0.5), (0.0, 0.0), (3.0, -0.2), (20.0, 5.0)] {
            let (before, after) = snapshots(step, &circle(q0, p0), samples, &HALVING, |_, _| {});
            for unit in [Snapshot::SINGLE, Snapshot::DOUBLE] {
                let known = |snapshot: &Snapshot| snapshot.clone().with_unit_roundoff(unit);
                let after: Vec<Snapshot> = after.iter().map(known).collect();
                let verdict = measure(&known(&before), &after, &Coordinates::plain(1))
                    .unwrap()
                    .verdict;
                let fine =
                    [VerdictKind::Symplectic, VerdictKind::Undecided].contains(&verdict.kind);
                assert!(fine, "{samples} round ({q0}, {p0}), {unit:e}: {verdict:?}");
            }
        }
    }
}

#[test]
fn short_waves_far_from_the_origin_are_no_single_precision() {
    // A unit of single precision is longer than a radian there.
    let found = |step: Step| {
        let map = symplint::PerSample::new(1, step);
        let diagnostic = symplint::Diagnostic::halving(-1, -4);
        diagnostic.run(&map, &circle(1e7, 0.5)).unwrap()
    };
    let double = found(position_first);
    assert!(!double.evidence.survey.single_inside);
    assert_eq!(double.verdict.kind, VerdictKind::Symplectic);
    let single = found(|h, q, p| {
        position_first(h, q, p);
        (q[0], p[0]) = (f64::from(q[0] as f32), f64::from(p[0] as f32));
    });
    assert_eq!(single.verdict.kind, VerdictKind::Undecided);
}

#[test]
fn wrapped_positions_need_their_period_and_get_it() {
    // Round q = 0 of a box of 2π: half the loop is stored at the other end.
    let wrap = |q: &mut f64, _: &mut f64| *q = q.rem_euclid(TAU);
    let (before, after) = snapshots(leapfrog, &circle(0.1, 0.3), 256, &[0.5], wrap);
    let stated = Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
    let verdict = measure(&before, &after, &stated).unwrap().verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
    let verdict = measure(&before, &after, &Coordinates::plain(1))
        .unwrap()
        .verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided);
    assert!(verdict.summary().contains("periodic box"), "{verdict:?}");
    assert!(verdict.summary().contains("6.28"), "{verdict:?}");
}

#[test]
fn a_loop_may_wind() {
    // Once round the cylinder; the standard map conserves its integral, friction does not.
    struct Winding;
    impl Loop for Winding {
        fn dof(&self) -> usize {
            1
        }
        fn sample(&self, s: &[f64], block: &mut symplint::Block<'_>) {
            for (k, s) in s.iter().enumerate() {
                block.q.row_mut(0)[k] = TAU * s;
                block.p.row_mut(0)[k] = 1.0 + 0.3 * (TAU * s).sin();
            }
        }
    }
    fn standard(h: f64, q: &mut [f64], p: &mut [f64]) {
        p[0] += h * q[0].sin();
        q[0] = (q[0] + p[0]).rem_euclid(TAU);
    }
    fn with_friction(h: f64, q: &mut [f64], p: &mut [f64]) {
        p[0] *= 1.0 - 0.1 * h;
        standard(h, q, p);
    }
    let stated = Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
    let (before, after) = snapshots(standard, &Winding, 256, &[0.5], |_, _| {});
    let diagnosis = measure(&before, &after, &stated).unwrap();
    assert_eq!(
        diagnosis.verdict.kind,
        VerdictKind::Symplectic,
        "{:?}",
        diagnosis.verdict
    );
    assert!((diagnosis.points()[0].initial - TAU).abs() < 1e-13);
    let (before, after) = snapshots(with_friction, &Winding, 256, &[0.5], |_, _| {});
    let diagnosis = measure(&before, &after, &stated).unwrap();
    assert_eq!(diagnosis.verdict.kind, VerdictKind::NotSymplectic);
    // The mean momentum loses 5 %.
    assert!((diagnosis.points()[0].signed_defect + 0.05).abs() < 1e-12);
}

#[test]
fn weights_make_momenta_canonical() {
    // Two coupled masses 1 and 5 that carry velocities.
    let coupled = PerSample::new(2, |h, q: &mut [f64], v: &mut [f64]| {
        q.iter_mut()
            .zip(v.iter())
            .for_each(|(q, v)| *q += 0.5 * h * v);
        let force = -(q[0] - q[1]).sin();
        v[0] += h * force;
        v[1] -= h * force / 5.0;
        q.iter_mut()
            .zip(v.iter())
            .for_each(|(q, v)| *q += 0.5 * h * v);
    });
    let phase_loop = Circle::new(vec![0.5, 0.0], vec![0.0, 0.3], 0.8)
        .unwrap()
        .with_phases(symplint::Phases::Random { seed: 4 });
    let before = Ensemble::sample(&phase_loop, 256).unwrap();
    let mut after = before.clone();
    after.advance(&coupled, 0.5).unwrap();
    let (before, after) = (
        Snapshot::new(before),
        [Snapshot::new(after).after_step(0.5)],
    );
    let kind = |coordinates| measure(&before, &after, &coordinates).unwrap().verdict.kind;
    assert_eq!(kind(Coordinates::plain(2)), VerdictKind::NotSymplectic);
    let weighted = Coordinates::plain(2).with_weights(vec![1.0, 5.0]).unwrap();
    assert_eq!(kind(weighted), VerdictKind::Symplectic);
}

#[test]
fn what_proves_nothing_is_undecided() {
    let undecided = |before: &Snapshot, after: &[Snapshot], why: &str| {
        let verdict = measure(before, after, &Coordinates::plain(1))
            .unwrap()
            .verdict;
        assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict:?}");
        assert!(verdict.summary().contains(why), "{verdict:?}");
        assert!(!verdict.advice.is_empty());
    };
    let (before, after) = snapshots(leapfrog, &circle(1.0, 0.5), 256, &[1e-3], |_, _| {});
    undecided(&before, std::slice::from_ref(&before), "moved no state");
    undecided(&before, &after, "rotates a loop by only");
    let (few, after) = snapshots(leapfrog, &circle(1.0, 0.5), 16, &[0.5], |_, _| {});
    undecided(&few, &after, "16 samples are too few");
    // A half circle is not a loop.
    let half = |ensemble: &Ensemble| {
        let mut half = Ensemble::zeros(1, ensemble.samples() / 2);
        let n = half.samples();
        half.block()
            .q
            .row_mut(0)
            .copy_from_slice(&ensemble.q().row(0)[..n]);
        half.block()
            .p
            .row_mut(0)
            .copy_from_slice(&ensemble.p().row(0)[..n]);
        Snapshot::new(half)
    };
    let (before, after) = snapshots(leapfrog, &circle(1.0, 0.5), 512, &[0.5], |_, _| {});
    undecided(
        &half(&before.states),
        &[half(&after[0].states)],
        "no closed loop",
    );
}

#[test]
fn a_steep_map_is_undecided_until_the_samples_resolve_it() {
    fn steep(h: f64, q: &mut [f64], p: &mut [f64]) {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * q[0] / q[0].hypot(0.02);
        q[0] += 0.5 * h * p[0];
    }
    let mut kinds = Vec::new();
    for exponent in 6..=15 {
        let diagnosis = plain(steep, &circle(0.0, 0.0), 1 << exponent, &[0.5]);
        let kind = diagnosis.verdict.kind;
        assert!(
            kind != VerdictKind::NotSymplectic,
            "2^{exponent}: {:?}",
            diagnosis.verdict
        );
        kinds.push(kind);
    }
    // Flanks are wider than the samples are apart from 2^8 on: no longer a jump.
    assert!(
        kinds[2..]
            .iter()
            .all(|&kind| kind != VerdictKind::BrokenLoops),
        "{kinds:?}"
    );
    assert_eq!(kinds.last(), Some(&VerdictKind::Symplectic), "{kinds:?}");
}

#[test]
fn bad_input_is_an_error() {
    let (before, after) = snapshots(leapfrog, &circle(1.0, 0.5), 64, &[0.5], |_, _| {});
    let fails = |before: &Snapshot, after: &[Snapshot]| {
        measure(before, after, &Coordinates::plain(1)).unwrap_err()
    };
    let (other, _) = snapshots(leapfrog, &circle(1.0, 0.5), 65, &[0.5], |_, _| {});
    assert_eq!(
        fails(&before, &[other]),
        Error::ShapesDiffer {
            index: 0,
            before: (64, 1),
            after: (65, 1)
        }
    );
    let twice = [after[0].clone(), after[0].clone()];
    assert_eq!(
        fails(&before, &twice),
        Error::RepeatedStep { step_size: 0.5 }
    );
    assert!(matches!(fails(&before, &[]), Error::OutOfRange { .. }));
    for h in [0.0, f64::NAN] {
        let wrong = [after[0].clone().after_step(h)];
        assert!(matches!(
            fails(&before, &wrong),
            Error::OutOfRange {
                what: "step size",
                ..
            }
        ));
    }
    let broken = Snapshot::new(changed(&after[0].states, |q, _| {
        if *q > 1.5 {
            *q = f64::NAN;
        }
    }));
    assert!(matches!(
        fails(&before, &[broken]),
        Error::NotFinite {
            coordinate: "q",
            ..
        }
    ));
    let rough = before.clone().with_unit_roundoff(f64::NAN);
    assert!(matches!(fails(&rough, &after), Error::OutOfRange { .. }));
    let flat = Snapshot::new(changed(&before.states, |_, p| *p = 0.0));
    assert!(matches!(fails(&flat, &after), Error::NoArea { .. }));
}

#[test]
fn rows_out_of_order_are_told_in_either_file() {
    let (before, after) = snapshots(leapfrog, &circle(1.0, 0.5), 256, &[0.5], |_, _| {});
    let shuffled = |snapshot: &Snapshot| {
        let from = &snapshot.states;
        let mut states = from.clone();
        let mut block = states.block();
        for k in 0..256 {
            // 97 is odd: every row once.
            let other = (97 * k + 13) % 256;
            block.q.row_mut(0)[k] = from.q().row(0)[other];
            block.p.row_mut(0)[k] = from.p().row(0)[other];
        }
        Snapshot::new(states)
    };
    let summary = |before: &Snapshot, after: &Snapshot| {
        let after = std::slice::from_ref(after);
        let found = measure(before, after, &Coordinates::plain(1)).unwrap();
        assert_eq!(found.verdict.kind, VerdictKind::Undecided);
        found.verdict.summary()
    };
    for (before, after) in [
        (&shuffled(&before), &after[0]),
        (&before, &shuffled(&after[0])),
    ] {
        let text = summary(before, after);
        assert!(text.contains("do not seem to be in order"), "{text}");
    }
}

#[test]
fn decimals_break_no_loop() {
    // Leapfrog of a pendulum, written with a fixed number of decimals, far from the origin and near it.
    let mut decided = 0;
    for seed in 0..160 {
        let part = |k: f64| (f64::from(seed) * k).sin().abs();
        let (q0, p0) = (12.0 * part(0.71), 3.0 * part(1.93));
        let (radius, h) = (0.2 + part(2.71), 0.2 + 0.3 * part(0.37));
        let decimals = 3 + seed % 7;
        let samples = 64 << (seed % 4);
        let unit = 10f64.powi(decimals);
        let print = |states: &mut Ensemble| {
            let mut block = states.block();
            for row in [block.q.row_mut(0), block.p.row_mut(0)] {
                row.iter_mut().for_each(|x| *x = (*x * unit).round() / unit);
            }
        };
        for first_written in [false, true] {
            // The code may have read the loop as it is written, or know it exactly.
            let on = Circle::new(vec![q0], vec![p0], radius).unwrap();
            let mut before = Ensemble::sample(&on, samples).unwrap();
            if first_written {
                print(&mut before);
            }
            let mut after = before.clone();
            after.advance(&PerSample::new(1, leapfrog), h).unwrap();
            print(&mut before);
            print(&mut after);
            let after = [Snapshot::new(after).after_step(h)];
            let verdict = measure(&Snapshot::new(before), &after, &Coordinates::plain(1));
            let verdict = verdict.unwrap().verdict;
            let title = format!("{seed}: {decimals} decimals, {samples} samples: {verdict}");
            let kinds = [VerdictKind::Symplectic, VerdictKind::Undecided];
            assert!(kinds.contains(&verdict.kind), "{title}");
            decided += u32::from(verdict.kind == VerdictKind::Symplectic);
        }
    }
    // Of the others a method of order 4 would not show its defect above the rounding either.
    assert!(decided > 140, "{decided} of 320");
}

/// The image of a circle with rows at these parameters.
fn at_rows(step: Step, circle: &Circle, s: &[f64], h: f64) -> Diagnosis {
    let mut before = Ensemble::zeros(1, s.len());
    circle.sample(s, &mut before.block());
    let mut after = before.clone();
    let map = PerSample::new(1, step);
    after.advance(&map as &dyn TimeAdvance, h).unwrap();
    let after = Snapshot::new(after).after_step(h);
    measure(&Snapshot::new(before), &[after], &Coordinates::plain(1)).unwrap()
}

/// Which rows a file has, and their parameters.
fn spacings(samples: usize) -> Vec<(&'static str, Vec<f64>)> {
    let n = samples as f64;
    let equal = || (0..samples).map(|k| k as f64 / n);
    let closed = || (0..samples).map(|k| k as f64 / (n - 1.0));
    let in_run = |s: &f64| (0.21..0.26).contains(s);
    vec![
        ("closed", closed().collect()),
        ("one lost", equal().filter(|s| *s != 5.0 / n).collect()),
        ("run lost", equal().filter(|s| !in_run(s)).collect()),
        (
            "closed, run lost",
            closed().filter(|s| !in_run(s)).collect(),
        ),
        (
            "uneven",
            (0..samples)
                .map(|k| (k as f64 + 0.7 * ((k * k) as f64).sin().abs()) / n)
                .collect(),
        ),
    ]
}

#[test]
fn rows_may_be_lost_repeated_or_uneven() {
    fn damped(h: f64, q: &mut [f64], p: &mut [f64]) {
        leapfrog(h, q, p);
        p[0] *= 0.99;
    }
    for samples in [64, 256, 1024, 4096] {
        for (name, s) in spacings(samples) {
            for (step, change, kind) in [
                (leapfrog as Step, 0.0, VerdictKind::Symplectic),
                (damped, -0.01, VerdictKind::NotSymplectic),
            ] {
                let found = at_rows(step, &circle(1.0, 0.5), &s, 0.5);
                let what = format!("{samples} {name}: {}", found.verdict);
                assert_eq!(found.verdict.kind, kind, "{what}");
                let defect = found.evidence.loops[0].steps[0].defect;
                let off = (defect.signed - change).abs();
                assert!(off <= defect.uncertainty(), "{what}");
                let given = &found.evidence.loops[0];
                let last = name.starts_with("closed").then_some(s.len() - 1);
                assert_eq!(given.repeated_row, last, "{what}");
                assert_eq!(given.widest_gap.is_some(), name != "closed", "{what}");
                if name == "run lost" {
                    assert!((given.widest_gap.unwrap() - 0.05).abs() < 1.5 / samples as f64);
                }
            }
        }
    }
}

#[test]
fn breaks_are_found_beside_lost_rows() {
    // The force jumps at s = 0.46 and 0.96.
    for (name, s) in spacings(1024) {
        let found = at_rows(position_first, &circle(0.0, 0.0), &s, 0.5);
        let kind = found.verdict.kind;
        let what = format!("{name}: {}", found.verdict);
        match name {
            "uneven" => assert_ne!(kind, VerdictKind::Symplectic, "{what}"),
            _ => assert_eq!(kind, VerdictKind::BrokenLoops, "{what}"),
        }
    }
}

#[test]
fn rows_that_few_digits_make_equal_are_kept() {
    // Three decimals on 8192 samples: many neighbours are the same.
    let round = |x: &mut f64| *x = (*x * 1e3).round() / 1e3;
    let (before, after) = snapshots(leapfrog, &circle(1.0, 0.5), 8192, &[0.5], |q, p| {
        round(q);
        round(p);
    });
    let found = measure(&before, &after, &Coordinates::plain(1)).unwrap();
    assert_eq!(found.evidence.loops[0].repeated_row, None);
    assert_eq!(found.evidence.loops[0].samples, 8192);
}

#[test]
fn q_and_p_that_are_exchanged_and_rows_in_the_opposite_order_are_named() {
    let swapped = |h: f64, q: &mut [f64], p: &mut [f64]| {
        leapfrog(h, q, p);
        std::mem::swap(&mut q[0], &mut p[0]);
    };
    let exchanged = plain(swapped, &circle(1.0, 0.5), 256, &[0.5, 0.25]).verdict;
    let backwards = FourierLoop::random(vec![1.0], vec![0.5], &[0.5], &[0.5], 1).unwrap();
    let before = Snapshot::new(Ensemble::sample(&backwards, 256).unwrap());
    let mut reversed = before.states.clone();
    let mut block = reversed.block();
    block.q.row_mut(0).reverse();
    block.p.row_mut(0).reverse();
    let after = [Snapshot::new(reversed).after_step(0.5)];
    let reversed = measure(&before, &after, &Coordinates::plain(1))
        .unwrap()
        .verdict;
    for verdict in [exchanged, reversed] {
        let cause = verdict.cause.as_ref().map(|cause| cause.kind);
        assert_eq!(cause, Some(CauseKind::Swapped), "{verdict}");
    }
}
