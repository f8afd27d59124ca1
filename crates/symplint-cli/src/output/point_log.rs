//! Points written as they are measured: a run that is killed, or fails, loses none.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use symplint::{Event, Point};

use super::record_table::RecordTable;
use super::run_folder::cannot_write;
use crate::commands::Failure;

/// A table of points that is complete on disk after each of them.
pub struct PointLog {
    path: PathBuf,
    /// Or what went wrong with it: a diagnosis has no ear for that while it runs.
    state: RefCell<csv::Result<State>>,
}

struct State {
    table: RecordTable,
    points: usize,
}

impl PointLog {
    /// Makes the file, in place of what was there.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let table = RecordTable::create(path).map_err(|error| cannot_write(path, &error))?;
        Ok(PointLog {
            path: path.to_owned(),
            state: RefCell::new(Ok(State { table, points: 0 })),
        })
    }

    /// Follows a diagnosis.
    pub fn diagnosis(&self, event: Event<'_>) {
        if let Event::Measured(point) = event {
            self.add(point);
        }
    }

    fn add(&self, point: &Point) {
        let mut state = self.state.borrow_mut();
        let Ok(open) = &mut *state else {
            return;
        };
        let added = open.table.push(point).and_then(|()| open.table.flush());
        match added {
            Ok(()) => open.points += 1,
            Err(error) => *state = Err(error),
        }
    }

    /// Where the points are, if there are any.
    pub fn measured(&self) -> Option<&Path> {
        let any = (self.state.borrow().as_ref()).is_ok_and(|state| state.points > 0);
        any.then_some(self.path.as_path())
    }

    /// Says what went wrong, if anything did.
    pub fn finish(self) -> Result<(), Failure> {
        match self.state.into_inner() {
            Ok(_) => Ok(()),
            Err(error) => Err(cannot_write(&self.path, &error)),
        }
    }
}
