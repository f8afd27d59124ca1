//! What the program prints and writes.

mod figures;
pub mod plot;
mod point_log;
mod power;
mod progress;
mod record_table;
mod report;
mod run_folder;
mod say;
mod table;

pub use figures::{check_figures, error_axis, measure_figures, step_axis, trace_figures};
pub use point_log::PointLog;
pub use power::{power_of_two, raised_power_of_two, short_power};
pub use progress::Progress;
pub use report::{Report, TraceReport, to_json};
pub use run_folder::RunFolder;
pub use say::say;
pub use table::{degrees_of_freedom, plain_table, points_table, trace_table, verdict_text};
