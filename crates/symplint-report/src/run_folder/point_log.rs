//! Points written as they are measured: a run that is killed, or fails, loses none.

use std::cell::{Cell, RefCell};
use std::path::PathBuf;

use symplint::diagnosis::Event;

use super::{RecordTable, RunFolder, WriteError, cannot_write};

/// The table of points in a run folder, complete on disk after each of them.
///
/// It takes the place of an earlier one only when there is something to measure: a run that is refused leaves the
/// folder as it was.
pub struct PointLog<'a> {
    folder: &'a RunFolder,
    config: &'a str,
    /// Or what went wrong with it: a diagnosis has no ear for that while it runs.
    table: RefCell<Result<Option<RecordTable>, WriteError>>,
    points: Cell<usize>,
}

impl<'a> PointLog<'a> {
    /// For a run of `config`, the text of `config.toml`.
    pub fn new(folder: &'a RunFolder, config: &'a str) -> Self {
        PointLog {
            folder,
            config,
            table: RefCell::new(Ok(None)),
            points: Cell::new(0),
        }
    }

    /// Follows a diagnosis.
    pub fn diagnosis(&self, event: Event<'_>) {
        let mut table = self.table.borrow_mut();
        let Ok(open) = &mut *table else {
            return;
        };
        if let Err(error) = self.follow(open, event) {
            *table = Err(error);
        }
    }

    fn follow(&self, table: &mut Option<RecordTable>, event: Event<'_>) -> Result<(), WriteError> {
        // A run that is refused before it plans anything leaves the folder alone.
        if matches!(event, Event::Started(_)) {
            return Ok(());
        }
        let table = match table {
            Some(table) => table,
            None => table.insert(self.folder.begin(self.config)?),
        };
        if let Event::Measured(point) = event {
            let added = table.push(point).and_then(|()| table.flush());
            added.map_err(|error| cannot_write(&self.folder.points(), &error))?;
            self.points.set(self.points.get() + 1);
        }
        Ok(())
    }

    /// The file of the points, if there are any.
    pub fn measured(&self) -> Option<PathBuf> {
        (self.points.get() > 0).then(|| self.folder.points())
    }

    /// Says what went wrong, if anything did.
    ///
    /// # Errors
    /// If a file of the folder could not be written.
    pub fn finish(self) -> Result<(), WriteError> {
        self.table.into_inner().map(|_| ())
    }
}
