//! Whether a loop is closed.

use super::Loop;
use crate::error::Error;
use crate::signal::{Extent, nearest, parameters};
use crate::state::{Coordinates, Ensemble, coordinate, period};

/// A part of the loop on which it hardly moves: around its end, a loop of a few modes moves by 1e-8 of its size.
const END_STEP: f64 = 1.0 / (1 << 30) as f64;

/// Steps of this length on either side of the end.
const END_STEPS: usize = 3;

/// From its last point to its first a loop moves as it does on one of the two sides, or between them at a corner. It has a
/// gap if it moves otherwise, by this many times the difference between the steps of one side.
const MIN_GAP_OVER_STEPS: f64 = 64.0;

/// Rounding of the loop's own arithmetic, in units in the last place. Jumps of less are no breaks either.
const MAX_ROUNDINGS: f64 = 1024.0;

/// Checks that the same parameters give the same states, in any order.
fn check_repeats(phase_loop: &dyn Loop, coordinates: &Coordinates) -> Result<(), Error> {
    let dof = phase_loop.dof();
    let parameters = parameters(3);
    let [first, again] = [false, true].map(|reversed| {
        let mut s = parameters.clone();
        if reversed {
            s.reverse();
        }
        let mut states = Ensemble::zeros(dof, s.len());
        phase_loop.sample(&s, &mut states.block());
        states
    });
    let last = parameters.len() - 1;
    for c in 0..2 * dof {
        let (first, again) = (coordinate(&first, c), coordinate(&again, c));
        let rounding = f64::from(f32::EPSILON) * Extent::of(first).magnitude();
        for (k, &s) in parameters.iter().enumerate() {
            let difference = nearest(again[last - k] - first[k], period(coordinates, c)).abs();
            if difference > MAX_ROUNDINGS * rounding {
                return Err(Error::RandomLoop {
                    s,
                    coordinate: if c < dof { 'q' } else { 'p' },
                    dof: c % dof,
                    difference,
                });
            }
        }
    }
    Ok(())
}

/// Checks that a loop is the same curve each time, and ends where it begins, but for whole periods.
///
/// # Errors
/// Names the coordinate that differs, or the one with the widest gap. Those of states that are not finite are left to the code that
/// samples the loop.
pub(crate) fn check_closed(phase_loop: &dyn Loop, coordinates: &Coordinates) -> Result<(), Error> {
    check_repeats(phase_loop, coordinates)?;
    let s: Vec<f64> = (1..=END_STEPS + 1)
        .rev()
        .map(|k| 1.0 - k as f64 * END_STEP)
        .chain((0..=END_STEPS).map(|k| k as f64 * END_STEP))
        .collect();
    let mut states = Ensemble::zeros(phase_loop.dof(), s.len());
    phase_loop.sample(&s, &mut states.block());
    let dof = phase_loop.dof();
    let open = |c: usize| {
        let row = coordinate(&states, c);
        let steps: Vec<f64> = (row.windows(2))
            .map(|pair| nearest(pair[1] - pair[0], period(coordinates, c)))
            .collect();
        let (before, gap, after) = (
            &steps[..END_STEPS],
            steps[END_STEPS],
            &steps[END_STEPS + 1..],
        );
        let [before, after] = [before, after].map(Extent::of);
        let magnitude = row.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        // In single precision it does not move on so short a part.
        let rounding = match before.magnitude() + after.magnitude() == 0.0 {
            true => f64::from(f32::EPSILON),
            false => f64::EPSILON,
        };
        let allowed = MIN_GAP_OVER_STEPS * before.length().max(after.length())
            + MAX_ROUNDINGS * rounding * magnitude;
        let mut beside = before;
        beside.include(after.middle() - 0.5 * after.length());
        beside.include(after.middle() + 0.5 * after.length());
        // Without the step that the loop makes on such a short part.
        let opening = (gap - beside.middle()).abs();
        let off = opening - 0.5 * beside.length();
        (off > allowed).then_some((c, opening))
    };
    let widest = (0..2 * dof)
        .filter_map(open)
        .max_by(|a, b| a.1.total_cmp(&b.1));
    match widest {
        None => Ok(()),
        Some((c, gap)) => Err(Error::OpenLoop {
            coordinate: if c < dof { 'q' } else { 'p' },
            dof: c % dof,
            gap,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::{Circle, FourierLoop};
    use crate::state::Block;

    /// A circle that is run round by an angle that need not be a full turn.
    struct Turn {
        centre: f64,
        angle: f64,
    }

    impl Loop for Turn {
        fn dof(&self) -> usize {
            1
        }
        fn sample(&self, s: &[f64], block: &mut Block<'_>) {
            for (k, s) in s.iter().enumerate() {
                let (sin, cos) = (self.angle * s).sin_cos();
                block.q.row_mut(0)[k] = self.centre + sin;
                block.p.row_mut(0)[k] = cos;
            }
        }
    }

    #[test]
    fn a_rounded_pi_leaves_a_gap() {
        let turn = |centre, angle| check_closed(&Turn { centre, angle }, &Coordinates::plain(1));
        for centre in [0.0, 1e3, 1e6] {
            assert_eq!(turn(centre, std::f64::consts::TAU), Ok(()));
            // 6.28, 6.283, 6.28318 and twice 3.141592.
            for missing in [3.2e-3, 1.9e-4, 5.3e-6, 1.3e-6] {
                let error = turn(centre, std::f64::consts::TAU - missing).unwrap_err();
                let Error::OpenLoop {
                    coordinate: 'q',
                    dof: 0,
                    gap,
                } = error
                else {
                    panic!("{error}");
                };
                assert!((gap / missing - 1.0).abs() < 1e-3, "{missing:e}: {gap:e}");
            }
        }
    }

    /// A circle with noise.
    struct Random(std::sync::atomic::AtomicU64, f64);

    impl Loop for Random {
        fn dof(&self) -> usize {
            1
        }
        fn sample(&self, s: &[f64], block: &mut Block<'_>) {
            for (k, s) in s.iter().enumerate() {
                let count = self.0.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                let (sin, cos) = (std::f64::consts::TAU * s).sin_cos();
                block.q.row_mut(0)[k] = sin;
                block.p.row_mut(0)[k] = cos + self.1 * (count as f64 * 1.7).sin();
            }
        }
    }

    #[test]
    fn a_random_loop_is_named() {
        for size in [1e-3, 1.0] {
            let random = Random(Default::default(), size);
            let error = check_closed(&random, &Coordinates::plain(1)).unwrap_err();
            assert!(
                matches!(
                    error,
                    Error::RandomLoop {
                        coordinate: 'p',
                        ..
                    }
                ),
                "{error}"
            );
        }
    }

    #[test]
    fn the_opening_of_an_error_is_not_the_motion_of_the_loop() {
        let missing = 6.3e-11;
        let turn = Turn {
            centre: 0.0,
            angle: std::f64::consts::TAU - missing,
        };
        let error = check_closed(&turn, &Coordinates::plain(1)).unwrap_err();
        assert!(error.to_string().contains("is 6.3"), "{error}");
        assert!(error.to_string().contains("e-11"), "{error}");
    }

    #[test]
    fn loops_of_the_library_are_closed_and_may_wind() {
        let plain = Coordinates::plain(2);
        let centre = || (vec![1e5, -3.0], vec![0.0, 2.0]);
        let (q0, p0) = centre();
        let circle = Circle::new(q0, p0, 1e-3)
            .unwrap()
            .with_phases(crate::loops::Phases::Random { seed: 3 });
        assert_eq!(check_closed(&circle, &plain), Ok(()));
        let (q0, p0) = centre();
        let random = FourierLoop::random(q0, p0, &[1.0; 2], &[1e-6; 2], 1).unwrap();
        assert_eq!(check_closed(&random, &plain), Ok(()));
        let winding = random.winding(1, 5.0).unwrap();
        assert!(check_closed(&winding, &plain).is_err());
        let periodic = plain.with_periods(vec![0.0, 5.0]).unwrap();
        assert_eq!(check_closed(&winding, &periodic), Ok(()));
    }
}
