//! The complex Fourier transform of a row of samples, by the faster of two libraries.
//!
//! For powers of two that is `tfhe-fft` where there are AVX2 (1.3 times as fast as `rustfft`) or AVX-512 (2
//! times and more). It leaves the modes in *classes*: mode k is in the class of k modulo their number, and the classes
//! stand in bit-reversed order, each with its modes in theirs. Sums over modes need no other order.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use dyn_stack::{PodBuffer, PodStack};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use tfhe_fft::ordered::FftAlgo;
use tfhe_fft::unordered::{Method, Plan};

/// The transform of a certain number of samples.
pub(super) enum Transform {
    /// Any number; modes in their order.
    InOrder(Arc<dyn Fft<f64>>),
    /// A power of two; modes in classes.
    InClasses(Plan),
}

/// What a transform needs besides its row.
pub(super) enum Scratch {
    /// Of [`Transform::InOrder`].
    Complex(Vec<Complex64>),
    /// Of [`Transform::InClasses`].
    Bytes(PodBuffer),
}

/// Plans that are kept at most: those of long odd lengths take megabytes.
const MOST_PLANS: usize = 64;

/// Plans are dear and the same few lengths come again and again.
static PLANS: LazyLock<Mutex<Plans>> = LazyLock::new(Mutex::default);

#[derive(Default)]
struct Plans {
    of_lengths: HashMap<usize, Arc<Transform>>,
    /// Lengths share what their factors need.
    planner: Option<FftPlanner<f64>>,
}

impl Transform {
    /// Modes of a class at most: a class stays in the innermost cache while it is made.
    const CLASS: usize = 1024;

    /// The transform of so many samples.
    pub fn of(samples: usize) -> Arc<Self> {
        let mut plans = PLANS.lock().unwrap_or_else(PoisonError::into_inner);
        if plans.of_lengths.len() >= MOST_PLANS && !plans.of_lengths.contains_key(&samples) {
            *plans = Plans::default();
        }
        let Plans {
            of_lengths,
            planner,
        } = &mut *plans;
        let plan = of_lengths.entry(samples).or_insert_with(|| {
            let planner = planner.get_or_insert_with(FftPlanner::new);
            Arc::new(Self::new(samples, has_vectors(), planner))
        });
        Arc::clone(plan)
    }

    fn new(samples: usize, has_vectors: bool, planner: &mut FftPlanner<f64>) -> Self {
        /// Below, a call costs more than the transform.
        const FEWEST: usize = 32;
        /// Plans hold 56 bytes for each sample.
        const MOST: usize = 1 << 18;
        if has_vectors && samples.is_power_of_two() && (FEWEST..=MOST).contains(&samples) {
            // Named, not measured: the same bits in every run.
            Transform::InClasses(Plan::new(
                samples,
                Method::UserProvided {
                    base_algo: FftAlgo::Dif4,
                    base_n: samples.min(Self::CLASS),
                },
            ))
        } else {
            Transform::InOrder(planner.plan_fft_forward(samples))
        }
    }

    /// The number of samples, and of modes.
    pub fn samples(&self) -> usize {
        match self {
            Transform::InOrder(plan) => plan.len(),
            Transform::InClasses(plan) => plan.fft_size(),
        }
    }

    /// The number of classes, a power of two; 1 means that modes come in their order.
    pub fn classes(&self) -> usize {
        match self {
            Transform::InOrder(_) => 1,
            Transform::InClasses(plan) => plan.fft_size() / plan.algo().1,
        }
    }

    /// Scratch space for one thread.
    pub fn scratch(&self) -> Scratch {
        match self {
            Transform::InOrder(plan) => {
                Scratch::Complex(vec![Complex64::ZERO; plan.get_inplace_scratch_len()])
            }
            Transform::InClasses(plan) => Scratch::Bytes(PodBuffer::new(plan.fft_scratch())),
        }
    }

    /// Turns a row of samples into its modes; nothing is normalised.
    ///
    /// # Panics
    /// If the row has another length, or the scratch space is that of another kind of transform.
    pub fn forward(&self, row: &mut [Complex64], scratch: &mut Scratch) {
        match (self, scratch) {
            (Transform::InOrder(plan), Scratch::Complex(scratch)) => {
                plan.process_with_scratch(row, scratch);
            }
            (Transform::InClasses(plan), Scratch::Bytes(scratch)) => {
                plan.fwd(row, PodStack::new(scratch));
            }
            _ => unreachable!("scratch space of another transform"),
        }
    }
}

/// Whether the processor has the vector instructions without which `rustfft` is the faster.
fn has_vectors() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::{Modes, Spectrum};
    use super::*;

    #[test]
    fn both_libraries_agree_on_every_mode() {
        let mut planner = FftPlanner::new();
        for samples in [32, 64, 512, 1024, 2048, 4096, 8192, 1 << 16] {
            let row: Vec<Complex64> = (0..samples)
                .map(|k| Complex64::new((k as f64).sin(), (1.3 * (k * k) as f64).cos()))
                .collect();
            let [mut slow, mut fast] = [row.clone(), row];
            for (row, has_vectors) in [(&mut slow, false), (&mut fast, true)] {
                let transform = Transform::new(samples, has_vectors, &mut planner);
                assert_eq!(transform.samples(), samples);
                assert!(has_vectors || transform.classes() == 1);
                transform.forward(row, &mut transform.scratch());
            }
            let classes = Transform::new(samples, true, &mut planner).classes();
            assert_eq!(classes, samples.div_ceil(1024));
            let (slow, fast) = (Spectrum::new(&slow, 1), Spectrum::new(&fast, classes));
            for k in 0..samples {
                let off = (slow.mode(k) - fast.mode(k)).norm();
                assert!(off < 1e-15 * samples as f64, "{samples}, mode {k}: {off:e}");
            }
        }
    }

    #[test]
    fn plans_of_few_lengths_are_kept() {
        let of_lengths = || PLANS.lock().unwrap().of_lengths.len();
        for samples in 3000..3000 + 3 * MOST_PLANS {
            let transform = Transform::of(samples);
            assert_eq!(transform.samples(), samples);
            assert!(of_lengths() <= MOST_PLANS);
        }
    }

    #[test]
    fn any_number_of_samples_has_a_transform() {
        for samples in (1..70).chain([1000, 1 << 19]) {
            let transform = Transform::of(samples);
            let mut row = vec![Complex64::ONE; samples];
            transform.forward(&mut row, &mut transform.scratch());
            assert!((row[0].re - samples as f64).abs() < 1e-9, "{samples}");
        }
    }
}
