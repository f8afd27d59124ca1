//! The memory of a diagnosis by the streaming rule, counted by the allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use symplint::diagnosis::SampleCount;
use symplint::{Block, Circle, Diagnostic, StepFailure, TimeAdvance, VerdictKind};

/// The system's allocator, with a count of what is in use and of the most that ever was.
struct Counting;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let in_use = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(in_use, Ordering::Relaxed);
        // SAFETY: the caller keeps to the contract of `GlobalAlloc`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Springs between neighbours, by symplectic Euler: in place, without separate memory.
struct Springs(usize);

impl TimeAdvance for Springs {
    fn dof(&self) -> usize {
        self.0
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for i in 0..self.0 {
            let next = block.q.row((i + 1) % self.0);
            let pairs = block.q.row(i).iter().zip(next);
            for (p, (q, next)) in block.p.row_mut(i).iter_mut().zip(pairs) {
                *p -= h * (q + 0.1 * (q - next));
            }
            if i > 0 {
                let last = block.q.row(i - 1);
                let pairs = block.q.row(i).iter().zip(last);
                for (p, (q, last)) in block.p.row_mut(i).iter_mut().zip(pairs) {
                    *p -= h * 0.1 * (q - last);
                }
            } else {
                let last = block.q.row(self.0 - 1);
                let pairs = block.q.row(0).iter().zip(last);
                for (p, (q, last)) in block.p.row_mut(0).iter_mut().zip(pairs) {
                    *p -= h * 0.1 * (q - last);
                }
            }
        }
        for i in 0..self.0 {
            for (q, p) in block.q.row_mut(i).iter_mut().zip(block.p.row(i)) {
                *q += h * p;
            }
        }
        Ok(())
    }
}

#[test]
fn a_diagnosis_takes_a_few_dozen_states() {
    // With this number of degrees of freedom, the other rules refuse even their smallest ensembles.
    const DOF: usize = 530_000;
    const STATE: usize = 16 * DOF;
    let map = Springs(DOF);
    let circle = Circle::new(vec![0.0; DOF], vec![0.5; DOF], 1.0).unwrap();
    let diagnostic = Diagnostic {
        samples: SampleCount::Fixed(64),
        loops: 2,
        ..Diagnostic::halving(-1, -1)
    };
    PEAK.store(IN_USE.load(Ordering::Relaxed), Ordering::Relaxed);
    let diagnosis = diagnostic.run(&map, &circle).unwrap();
    let states = PEAK.load(Ordering::Relaxed) as f64 / STATE as f64;
    println!("two loops take {states:.1} states");
    // A dozen of them are the amplitudes of the random loop.
    assert!(states < 50.0, "two loops take {states:.1} states");
    assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
    let points = diagnosis.points();
    assert!(points.iter().all(|point| point.rule.name() == "streaming"));
    assert!(diagnosis.evidence.jacobian.is_none());
    let said = diagnosis.verdict.sentences().join(" ");
    assert!(said.contains("Jacobian was left out"), "{said}");
}
