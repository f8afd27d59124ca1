//! Plans of Fourier transforms, made once for each length.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use symplint_fft::Fft;

/// The transform of a number of samples; nothing is normalised.
pub(super) type Transform = Arc<dyn Fft<f64>>;

/// Plans that are kept at most: those of long odd lengths take megabytes.
const MAX_PLANS: usize = 64;

/// Planning takes longer than a transform, and the same few lengths come again and again.
static PLANS: LazyLock<Mutex<HashMap<usize, Transform>>> = LazyLock::new(Mutex::default);

/// The transform of `samples` samples.
pub(super) fn transform(samples: usize) -> Transform {
    let mut plans = PLANS.lock().unwrap_or_else(PoisonError::into_inner);
    if plans.len() >= MAX_PLANS && !plans.contains_key(&samples) {
        plans.clear();
    }
    let plan = || symplint_fft::forward(samples);
    Arc::clone(plans.entry(samples).or_insert_with(plan))
}

#[cfg(test)]
mod tests {
    use symplint_fft::Complex64;

    use super::*;

    fn modes(transform: &Transform) -> Vec<Complex64> {
        let mut row: Vec<Complex64> = (0..transform.len())
            .map(|k| Complex64::new((k as f64).sin(), (1.3 * (k * k) as f64).cos()))
            .collect();
        transform.process(&mut row);
        row
    }

    #[test]
    fn what_was_planned_before_changes_no_bit() {
        for samples in (2..400).chain([1024, 2310, 4096, 6000]) {
            for other in 2..samples.min(100) {
                transform(other);
            }
            let alone = symplint_fft::forward(samples);
            assert_eq!(modes(&transform(samples)), modes(&alone), "{samples}");
        }
    }

    #[test]
    fn plans_of_few_lengths_are_kept() {
        for samples in 3000..3000 + 3 * MAX_PLANS {
            assert_eq!(transform(samples).len(), samples);
            assert!(PLANS.lock().unwrap().len() <= MAX_PLANS);
        }
    }
}
