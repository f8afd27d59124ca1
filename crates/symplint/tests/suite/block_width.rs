//! A map says how many samples it is given at once.

use std::sync::Mutex;

use symplint::map::Capabilities;
use symplint::{Block, Circle, Ensemble, StepFailure, TimeAdvance};

/// A kick and a drift that take note of how many samples they are given.
struct Noted {
    width: Option<usize>,
    lengths: Mutex<Vec<usize>>,
}

impl TimeAdvance for Noted {
    fn dof(&self) -> usize {
        2
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.lengths.lock().unwrap().push(block.len());
        for k in 0..block.len() {
            for i in 0..2 {
                let kick = h * block.q.row(1 - i)[k].sin();
                block.p.row_mut(i)[k] -= kick;
            }
            for i in 0..2 {
                let drift = h * block.p.row(i)[k];
                block.q.row_mut(i)[k] += drift;
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            block_width: self
                .width
                .unwrap_or_else(|| Ensemble::block_width(self.dof())),
            ..Capabilities::plain(self.dof())
        }
    }
}

#[test]
fn blocks_are_as_wide_as_the_map_says_and_states_do_not_depend_on_it() {
    const SAMPLES: usize = 3000;
    let circle = Circle::new(vec![0.3, 1.0], vec![0.5, 0.0], 1.0).unwrap();
    let initial = Ensemble::sample(&circle, SAMPLES).unwrap();
    let advanced = |width| {
        let map = Noted {
            width,
            lengths: Mutex::default(),
        };
        let mut states = initial.clone();
        states.advance(&map, 0.25).unwrap();
        let mut lengths = map.lengths.into_inner().unwrap();
        lengths.sort_unstable();
        (states, lengths)
    };
    let (by_default, lengths) = advanced(None);
    assert_eq!(lengths, [952, 1024, 1024]);
    for (width, expected) in [(usize::MAX, vec![3000]), (2000, vec![1000, 2000])] {
        let (states, lengths) = advanced(Some(width));
        assert_eq!(lengths, expected);
        for i in 0..2 {
            assert_eq!(states.q().row(i), by_default.q().row(i));
            assert_eq!(states.p().row(i), by_default.p().row(i));
        }
    }
    // No width at all is one sample.
    assert_eq!(advanced(Some(0)).1.len(), SAMPLES);
}
