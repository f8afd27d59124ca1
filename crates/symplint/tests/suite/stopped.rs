//! A map that asks to end the diagnosis.

use std::sync::atomic::{AtomicUsize, Ordering};

use symplint::map::Capabilities;
use symplint::{Block, Circle, Diagnostic, Error, StepFailure, TimeAdvance};

/// Symplectic Euler of the pendulum, which asks to stop once it was evaluated so often.
struct Stopping {
    after: usize,
    evaluated: AtomicUsize,
}

impl TimeAdvance for Stopping {
    fn dof(&self) -> usize {
        1
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.evaluated.fetch_add(block.len(), Ordering::Relaxed);
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            *p -= h * q.sin();
            *q += h * *p;
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            is_stopped: Some(Box::new(|| {
                self.evaluated.load(Ordering::Relaxed) >= self.after
            })),
            ..Capabilities::plain(self.dof())
        }
    }
}

fn stopping_after(after: usize) -> Stopping {
    Stopping {
        after,
        evaluated: AtomicUsize::new(0),
    }
}

#[test]
fn the_diagnosis_ends_before_the_next_evaluation() -> Result<(), Error> {
    let circle = Circle::new(vec![1.0], vec![0.5], 1.0)?;
    let diagnostic = Diagnostic::default();
    let whole = stopping_after(usize::MAX);
    let diagnosis = diagnostic.run(&whole, &circle)?;
    let made = diagnosis.evidence.evaluations.made;
    assert_eq!(whole.evaluated.into_inner(), made);

    // On the given loop, on random ones, in the Jacobian, which tolerate steps that fail.
    for part in 0..100 {
        let map = stopping_after(made * part / 100);
        assert_eq!(diagnostic.run(&map, &circle), Err(Error::Stopped));
        let evaluated = map.evaluated.into_inner();
        let most_at_once = 1 << 12;
        assert!(
            evaluated <= map.after + most_at_once,
            "{evaluated} evaluations, asked to stop after {}",
            map.after
        );
    }
    Ok(())
}
