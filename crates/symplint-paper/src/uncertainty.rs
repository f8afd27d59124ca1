//! The uncertainty in figures of the paper.

use symplint_report::figure::Series;
use symplint_report::plot;

use super::sweep::Record;

/// The uncertainty of the curves of a panel, placed by the abscissa of `at`.
pub fn uncertainty<'a>(
    records: impl IntoIterator<Item = &'a Record>,
    at: fn(&Record) -> (f64, f64),
) -> Series {
    let records = records.into_iter();
    plot::uncertainty(records.map(|record| (at(record).0, record.uncertainty())))
}
