//! The floor of figures of the paper.

use super::sweep::Record;
use symplint_report::figure::{Series, Style};
use symplint_report::plot::series;

/// The floor of `records`, placed by the abscissa of `at`.
pub fn floor(records: &[Record], at: fn(&Record) -> (f64, f64)) -> Series {
    let points = records
        .iter()
        .map(|record| (at(record).0, record.floor()))
        .collect();
    series("floor of Strang", points, Style::Floor, 0)
}
