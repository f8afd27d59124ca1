//! Steps whose results depend on more than h and the state, and steps that ignore h.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use symplint::evidence::ScatterKind;
use symplint::verdict::{Advice, Finding, MapFinding};
use symplint::{
    Circle, Diagnosis, Diagnostic, Error, PerBlock, PerSample, TimeAdvance, VerdictKind,
};

fn leapfrog(h: f64, q: &mut f64, p: &mut f64) {
    *q += 0.5 * h * *p;
    *p -= h * q.sin();
    *q += 0.5 * h * *p;
}

fn run(map: &dyn TimeAdvance) -> Result<Diagnosis, Error> {
    let circle = Circle::new(vec![1.0], vec![0.5], 0.5).unwrap();
    Diagnostic::halving(-1, -8).run(map, &circle)
}

/// Leapfrog steps of all rows, and what `after` does to the momenta of the batch.
fn batches(after: impl Fn(&mut [f64], &mut [f64]) + Send + Sync) -> impl TimeAdvance {
    PerBlock::new(1, move |h, block| {
        let (q, p) = (block.q.row_mut(0), block.p.row_mut(0));
        (q.iter_mut().zip(&mut *p)).for_each(|(q, p)| leapfrog(h, q, p));
        after(q, p);
        Ok(())
    })
}

#[test]
fn steps_that_mix_rows_are_refused() {
    let sorted = batches(|q, p| {
        let mut rows: Vec<(f64, f64)> = q.iter().copied().zip(p.iter().copied()).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (k, row) in rows.into_iter().enumerate() {
            (q[k], p[k]) = row;
        }
    });
    let mean = |least: usize| {
        batches(move |_, p| {
            let mean = p.iter().sum::<f64>() / p.len() as f64;
            if p.len() > least {
                p.iter_mut().for_each(|p| *p -= 0.1 * mean);
            }
        })
    };
    let remainder = |width: usize| {
        batches(move |_, p| {
            let whole = p.len() - p.len() % width;
            p[whole..].iter_mut().for_each(|p| *p *= 0.99);
        })
    };
    let maps: [&dyn TimeAdvance; 6] = [
        &sorted,
        &mean(0),
        &mean(16),
        &mean(100),
        &remainder(32),
        &remainder(64),
    ];
    for (k, map) in maps.into_iter().enumerate() {
        let error = run(map).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{k}: {error}");
        let text = error.to_string();
        assert!(text.contains("the other rows of the batch"), "{k}: {text}");
    }
}

#[test]
fn steps_that_change_after_some_states_are_refused() {
    for after in [30, 300, 1000, 4000] {
        let count = AtomicUsize::new(0);
        let late = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            leapfrog(h, &mut q[0], &mut p[0]);
            if count.fetch_add(1, Ordering::Relaxed) > after {
                p[0] *= 0.999;
            }
        });
        let error = run(&late).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{after}: {error}");
        assert!(
            error.to_string().contains("earlier calls"),
            "{after}: {error}"
        );
    }
}

/// A number between −1 and 1 (splitmix64).
fn scrambled(count: u64) -> f64 {
    let mut x = count.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (x ^ (x >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

fn random(size: f64, same: bool) -> impl TimeAdvance {
    let calls = AtomicU64::new(0);
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        leapfrog(h, &mut q[0], &mut p[0]);
        let count = calls.fetch_add(1, Ordering::Relaxed);
        p[0] += size * h.sqrt() * scrambled(if same { 7 } else { count });
    })
}

#[test]
fn random_numbers_are_named_and_the_same_ones_for_all_decide() {
    for size in [1e-2, 1e-4, 1e-6] {
        let verdict = run(&random(size, false)).unwrap().verdict;
        assert_eq!(verdict.kind, VerdictKind::Undecided);
        assert_eq!(verdict.advice, [Advice::SameRandomNumbers]);
        assert!(verdict.summary().contains("draws random numbers"));
        let followed = run(&random(size, true)).unwrap().verdict;
        assert_eq!(followed.kind, VerdictKind::Symplectic, "{followed}");
    }
}

#[test]
fn rare_random_numbers_are_no_breaks() {
    // On one thread, so that the same rows are kicked in each run.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().unwrap();
    for one_in in [100, 300, 1000] {
        for seed in 1..=8 {
            let rows = AtomicU64::new(seed << 32);
            let map = batches(move |_, p| {
                for p in p {
                    let count = rows.fetch_add(1, Ordering::Relaxed);
                    if scrambled(count).abs() * f64::from(one_in) < 0.5 {
                        *p += 0.1;
                    }
                }
            });
            let verdict = pool.install(|| run(&map)).unwrap().verdict;
            assert_eq!(verdict.kind, VerdictKind::Undecided, "{seed}: {verdict}");
            assert_eq!(verdict.advice, [Advice::SameRandomNumbers], "{verdict}");
        }
    }
}

#[test]
fn breaks_of_steps_whose_rounding_depends_on_the_batch_are_breaks() {
    for first in [0.8, 0.93, 1.1, 1.25] {
        let map = batches(move |q, p| {
            let rounding = f64::EPSILON * (q.len() % 7) as f64;
            for (q, p) in q.iter_mut().zip(p) {
                *q *= 1.0 + rounding;
                *p -= 0.1 * (*q - first).signum();
            }
        });
        let verdict = run(&map).unwrap().verdict;
        assert_eq!(verdict.kind, VerdictKind::BrokenLoops, "{first}: {verdict}");
    }
}

#[test]
fn small_noise_limits_the_digits() {
    for size in [1e-8, 1e-10, 1e-12] {
        let found = run(&random(size, false)).unwrap();
        let scatter = found.evidence.survey.scatter.expect("noise");
        assert_eq!(scatter.kind, ScatterKind::Noise);
        assert_eq!(
            found.verdict.kind,
            VerdictKind::Symplectic,
            "{}",
            found.verdict
        );
        let digits = found.verdict.digits.unwrap();
        assert!(
            (-size.log10() - 2.0..-size.log10() + 1.0).contains(&digits),
            "{digits}"
        );
    }
}

#[test]
fn a_step_that_ignores_its_size_is_named() {
    let named = |map: &dyn TimeAdvance| {
        let verdict = run(map).unwrap().verdict;
        let named = Finding::Map(MapFinding::IgnoresStepSize);
        let is_named = verdict.findings.contains(&named);
        // The verdict names no step sizes then.
        assert!(
            !(is_named && verdict.summary().contains(" h ")),
            "{verdict}"
        );
        is_named
    };
    let of = |fixed: Option<f64>| {
        PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            leapfrog(fixed.unwrap_or(h), &mut q[0], &mut p[0]);
        })
    };
    assert!(named(&of(Some(0.3))));
    assert!(!named(&of(None)));
    // A step that returns what it gets is another fault.
    assert!(!named(&PerSample::new(
        1,
        |_, _: &mut [f64], _: &mut [f64]| {}
    )));
}
