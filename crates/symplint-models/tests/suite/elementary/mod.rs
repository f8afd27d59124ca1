//! Vector sines and cosines against high precision: a table made with mpmath over the whole range of
//! doubles (`table.txt`, by `make_table.py`), and double-double sums where arguments are reduced.

// The kernel itself, so that both kinds of arithmetic are tested on every processor.
#[allow(dead_code, reason = "the library takes more of it than the tests")]
#[path = "../../../src/elementary/kernel.rs"]
mod kernel;
mod reference;

use kernel::{Arithmetic, FusedArithmetic, LANES, MAX_REDUCED, SeparateArithmetic};
use reference::sin_cos;
use symplint_models::elementary::{add_cos, add_sin, cos_into, sin_into};

/// Errors must stay below this many units in the last place.
const BOUND: f64 = 0.85;

type Rows = fn(&[f64], &mut [f64]);

/// Sines and cosines by one way of computing them.
struct Way {
    name: &'static str,
    sin: Rows,
    cos: Rows,
}

fn by_kernel(function: impl Fn([f64; LANES]) -> [f64; LANES], x: &[f64], out: &mut [f64]) {
    for (x, out) in x.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let mut lanes = [1.0; LANES];
        lanes[..x.len()].copy_from_slice(x);
        out.copy_from_slice(&function(lanes)[..x.len()]);
    }
}

fn kernel_sin<M: Arithmetic>(x: &[f64], out: &mut [f64]) {
    by_kernel(kernel::sin::<M>, x, out);
}

fn kernel_cos<M: Arithmetic>(x: &[f64], out: &mut [f64]) {
    by_kernel(kernel::cos::<M>, x, out);
}

const WAYS: [Way; 3] = [
    Way {
        name: "dispatched",
        sin: sin_into,
        cos: cos_into,
    },
    Way {
        name: "fused",
        sin: kernel_sin::<FusedArithmetic>,
        cos: kernel_cos::<FusedArithmetic>,
    },
    Way {
        name: "separate",
        sin: kernel_sin::<SeparateArithmetic>,
        cos: kernel_cos::<SeparateArithmetic>,
    },
];

fn row(function: Rows, x: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    function(x, &mut out);
    out
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// A value of the table: the nearest double, and how far above it the true value is, in ulp.
struct Exact {
    nearest: f64,
    rest: f64,
}

impl Exact {
    fn ulps_to(&self, value: f64) -> f64 {
        let nearest = reference::Double {
            high: self.nearest,
            low: 0.0,
        };
        nearest.ulps_to(value) - self.rest
    }
}

/// x, sin x, cos x.
fn table() -> Vec<(f64, Exact, Exact)> {
    let double = |field: &str| f64::from_bits(u64::from_str_radix(field, 16).unwrap());
    let exact = |fields: &[&str]| Exact {
        nearest: double(fields[0]),
        rest: fields[1].parse().unwrap(),
    };
    let entry = |line: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        (double(fields[0]), exact(&fields[1..]), exact(&fields[3..]))
    };
    include_str!("table.txt").lines().map(entry).collect()
}

/// The largest error of a row of results, with its argument.
fn worst(x: &[f64], errors: impl Iterator<Item = f64>) -> (f64, f64) {
    let errors = errors.map(f64::abs).zip(x.iter().copied());
    errors.fold((0.0, 0.0), |most, error| {
        // Not a number is the worst.
        if error.0 <= most.0 { most } else { error }
    })
}

#[test]
fn errors_are_below_one_ulp_over_the_whole_range() {
    let table = table();
    assert!(table.len() > 700);
    let x: Vec<f64> = table.iter().map(|entry| entry.0).collect();
    for way in &WAYS {
        let (sin, cos) = (row(way.sin, &x), row(way.cos, &x));
        let pairs = || sin.iter().zip(&cos).zip(&table);
        let sin = worst(
            &x,
            pairs().map(|((sin, _), (_, exact, _))| exact.ulps_to(*sin)),
        );
        let cos = worst(
            &x,
            pairs().map(|((_, cos), (_, _, exact))| exact.ulps_to(*cos)),
        );
        println!("{}: sin {sin:?}, cos {cos:?}", way.name);
        assert!(
            sin.0 < BOUND && cos.0 < BOUND,
            "{}: {sin:?}, {cos:?}",
            way.name
        );
    }
}

/// The reference of the other tests against the table.
#[test]
fn the_reference_is_that_of_the_table() {
    let small = table()
        .into_iter()
        .filter(|entry| entry.0 <= 2.0 * MAX_REDUCED);
    for (x, sin, cos) in small.filter(|entry| entry.0 > 1e-290) {
        let got = sin_cos(x);
        for (exact, got) in [(sin, got.0), (cos, got.1)] {
            let error = exact.ulps_to(got.high) - got.ulps_to(got.high);
            assert!(error.abs() < 2e-6, "{x}: {error}");
        }
    }
}

fn assert_accurate(x: &[f64]) {
    let exact: Vec<_> = x.iter().map(|x| sin_cos(*x)).collect();
    for way in &WAYS {
        let (sin, cos) = (row(way.sin, x), row(way.cos, x));
        let sin = worst(
            x,
            exact
                .iter()
                .zip(&sin)
                .map(|(exact, sin)| exact.0.ulps_to(*sin)),
        );
        let cos = worst(
            x,
            exact
                .iter()
                .zip(&cos)
                .map(|(exact, cos)| exact.1.ulps_to(*cos)),
        );
        println!("{}: sin {sin:?}, cos {cos:?}", way.name);
        assert!(
            sin.0 < BOUND && cos.0 < BOUND,
            "{}: {sin:?}, {cos:?}",
            way.name
        );
    }
}

/// Numbers in [0, 1) that fill it evenly.
fn even(count: u32) -> impl Iterator<Item = f64> {
    (1..=count).map(|k| (f64::from(k) * 0.618_033_988_749_894_9).fract())
}

#[test]
fn errors_are_below_one_ulp_at_many_arguments() {
    let largest: [f64; 5] = [0.8, 4.0, 100.0, 1e4, MAX_REDUCED];
    for largest in largest {
        println!("up to {largest}");
        let x: Vec<f64> = even(100_000).map(|u| largest * (2.0 * u - 1.0)).collect();
        assert_accurate(&x);
    }
    // Of all sizes down to 1e-280.
    let x: Vec<f64> = even(50_000).map(|u| 10.0_f64.powf(-280.0 * u)).collect();
    assert_accurate(&x);
}

/// Every third multiple of π/4 up to the largest, and the doubles next to it: reduced arguments of every
/// small size, and both sides of the turn from one quadrant to the next.
#[test]
fn errors_are_below_one_ulp_next_to_multiples_of_an_eighth_turn() {
    let last = (MAX_REDUCED / std::f64::consts::FRAC_PI_4) as u32;
    let x: Vec<f64> = (1..=last)
        .step_by(3)
        .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4)
        .flat_map(|x| [x.next_down(), x, x.next_up()])
        .collect();
    assert_accurate(&x);
}

/// On both sides of where the other function takes over.
#[test]
fn errors_are_below_one_ulp_next_to_the_largest_reduced_argument() {
    let offsets = even(10_000).map(|u| 200.0 * (u - 0.5));
    let x: Vec<f64> = offsets.map(|offset| MAX_REDUCED + offset).collect();
    assert_accurate(&x);
    let (below, above) = (MAX_REDUCED, MAX_REDUCED.next_up());
    assert_accurate(&[below, above, -below, -above]);
}

#[test]
fn special_arguments() {
    for way in &WAYS {
        let x = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        assert!(
            row(way.sin, &x).iter().all(|sin| sin.is_nan()),
            "{}",
            way.name
        );
        assert!(
            row(way.cos, &x).iter().all(|cos| cos.is_nan()),
            "{}",
            way.name
        );
        // So small that they are their own sines.
        let tiny = [
            0.0,
            -0.0,
            5e-324,
            -5e-324,
            1e-310,
            f64::MIN_POSITIVE,
            -1e-200,
            1e-9,
        ];
        assert_eq!(bits(&row(way.sin, &tiny)), bits(&tiny), "{}", way.name);
        assert_eq!(row(way.cos, &tiny), [1.0; 8], "{}", way.name);
    }
}

#[test]
fn sines_are_odd_and_cosines_even_to_the_last_bit() {
    let x: Vec<f64> = even(10_000)
        .map(|u| 10.0_f64.powf(16.0 * u - 8.0))
        .collect();
    let negative: Vec<f64> = x.iter().map(|x| -x).collect();
    let negated: Vec<f64> = row(sin_into, &x).iter().map(|sin| -sin).collect();
    assert_eq!(bits(&row(sin_into, &negative)), bits(&negated));
    assert_eq!(bits(&row(cos_into, &negative)), bits(&row(cos_into, &x)));
}

/// The processor's version is one of the two that are tested everywhere.
#[test]
fn the_version_chosen_is_fused_where_the_processor_is() {
    #[cfg(target_arch = "x86_64")]
    let fused = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let fused = cfg!(target_arch = "aarch64");
    let same = &WAYS[if fused { 1 } else { 2 }];
    let x: Vec<f64> = even(100_000).map(|u| 1e5 * (u - 0.5)).collect();
    assert_eq!(bits(&row(sin_into, &x)), bits(&row(same.sin, &x)));
    assert_eq!(bits(&row(cos_into, &x)), bits(&row(same.cos, &x)));
}

/// What becomes of a number depends neither on its place nor on its neighbours, be they large or none.
#[test]
fn numbers_do_not_see_each_other() {
    let mut x: Vec<f64> = even(64).map(|u| 20.0 * (u - 0.5)).collect();
    x[11] = 1e300;
    x[29] = f64::NAN;
    for function in [sin_into as Rows, cos_into] {
        let alone: Vec<f64> = x.iter().map(|x| row(function, &[*x])[0]).collect();
        for first in 0..LANES {
            for last in first..x.len() {
                let part = row(function, &x[first..last]);
                assert_eq!(bits(&part), bits(&alone[first..last]), "{first}..{last}");
            }
        }
    }
}

#[test]
fn what_is_added_is_the_factor_times_the_function() {
    let x: Vec<f64> = even(37).map(|u| 50.0 * (u - 0.5)).collect();
    for (add, function) in [
        (add_sin as fn(f64, &[f64], &mut [f64]), sin_into as Rows),
        (add_cos, cos_into),
    ] {
        let mut out: Vec<f64> = even(37).map(|u| 3.0 - u).collect();
        let expected: Vec<f64> = (out.iter().zip(row(function, &x)))
            .map(|(out, value)| out + -0.3 * value)
            .collect();
        add(-0.3, &x, &mut out);
        assert_eq!(bits(&out), bits(&expected));
    }
}

#[test]
#[should_panic(expected = "rows of one length")]
fn rows_of_different_lengths_are_refused() {
    sin_into(&[1.0, 2.0], &mut [0.0]);
}
