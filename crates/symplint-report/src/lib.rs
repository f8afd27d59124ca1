//! What [`symplint`] found, as tables, JSON, figures and run folders.
//!
//! Programs and bindings share this crate. It knows nothing of terminals: a table takes its width as an
//! argument, and texts are not coloured. It knows nothing of configuration files: a report takes whatever
//! value [`serde`] can write.
//!
//! | module | holds |
//! | --- | --- |
//! | [`figure`] | figures as data, and their files: SVG and PNG |
//! | [`page`] | a report as one page of HTML |
//! | [`plot`] | parts of figures: axes, series, reference slopes, phase portraits |
//! | [`figures`] | the figures of a diagnosis, of a trace and of loops from files |
//! | [`text`] | a diagnosis as text on one screen |
//! | [`table`] | tables of the steps of a trace and of names |
//! | [`report`] | reports as JSON |
//! | [`provenance`] | where a report comes from: program, processor, date, seeds, files |
//! | [`run_folder`] | the folder of a run: reports, points and samples as files |
//! | [`number`] | powers of two and counts in figures and texts |
//! | [`wrap`] | paragraphs wrapped to a width |

pub mod figure;
pub mod figures;
pub mod number;
pub mod page;
pub mod plot;
pub mod progress;
pub mod provenance;
pub mod report;
pub mod run_folder;
pub mod table;
pub mod text;
pub mod wrap;
