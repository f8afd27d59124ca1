//! The origin of a report: the program, the machine's processor, when the run was, its seeds and files.
//!
//! None of it is a result. Reports keep it apart from what was measured, which is the same to the last bit
//! in every run.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

pub use symplint_files::HashedFile;

/// A run of a program, from its start on.
#[derive(Clone, Debug)]
pub struct Run {
    version: String,
    commit: Option<String>,
    date: SystemTime,
    clock: Instant,
}

impl Run {
    /// A run that starts now, of a program of this version and, if that is known, this commit.
    pub fn start(version: &str, commit: Option<&str>) -> Self {
        Run {
            version: version.to_owned(),
            commit: commit.map(str::to_owned),
            date: SystemTime::now(),
            clock: Instant::now(),
        }
    }

    /// The provenance of what this run, on `threads` threads, has found so far.
    pub fn provenance(&self, threads: usize) -> Provenance {
        let since = self.date.duration_since(UNIX_EPOCH).unwrap_or_default();
        Provenance {
            version: self.version.clone(),
            commit: self.commit.clone(),
            date: utc(since.as_secs()),
            seconds: self.clock.elapsed().as_secs_f64(),
            threads,
            processor: processor(),
            seeds: BTreeMap::new(),
            files: Vec::new(),
            replayed: 0,
            workers: 0,
        }
    }
}

/// The origin of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// Its commit, if it was built from a repository.
    pub commit: Option<String>,
    /// When the run started, in universal time.
    pub date: String,
    /// How long it took.
    pub seconds: f64,
    /// Threads.
    pub threads: usize,
    /// The processor, as it calls itself if the system says that, and its architecture.
    pub processor: String,
    /// Seeds of random numbers, by the names of the settings.
    pub seeds: BTreeMap<String, u64>,
    /// The files that were read and measured.
    pub files: Vec<HashedFile>,
    /// Evaluations that an earlier run had made: they were read from its journal.
    #[serde(default)]
    pub replayed: usize,
    /// Processes that took the steps, where workers did.
    #[serde(default)]
    pub workers: usize,
}

impl Provenance {
    /// A table in Markdown.
    pub fn markdown(&self) -> String {
        let mut text = "| | |\n|---|---|\n".to_owned();
        let mut row = |name: &str, value: &str| {
            let _ = writeln!(text, "| {name} | {} |", value.replace('|', "\\|"));
        };
        row("version", &self.version);
        row("commit", self.commit.as_deref().unwrap_or("not known"));
        row("date", &self.date);
        row("time taken", &format!("{:.1} s", self.seconds));
        row("threads", &self.threads.to_string());
        row("processor", &self.processor);
        for (name, seed) in &self.seeds {
            row(name, &seed.to_string());
        }
        for file in &self.files {
            row(&file.name, &format!("SHA-256 {}", file.sha256));
        }
        text
    }
}

/// The name of the processor, if the system reports it, with the architecture that the program was built for.
fn processor() -> String {
    let architecture = std::env::consts::ARCH;
    // Linux.
    let described = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    match model_name(&described) {
        Some(name) => format!("{name} ({architecture})"),
        None => architecture.to_owned(),
    }
}

fn model_name(described: &str) -> Option<&str> {
    let line = described
        .lines()
        .find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim()).filter(|name| !name.is_empty())
}

/// The date and time this number of seconds after the beginning of 1970, in universal time: `2026-03-01T12:00:00Z`.
fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // H. Hinnant, "chrono-compatible low-level date algorithms": years begin in March, so that the day that leap
    // years have more is their last.
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    let year = 400 * era + year + next;
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_the_calendar() {
        // By `date -u -d @SECONDS`.
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_709_164_800, "2024-02-29T00:00:00Z"),
            (1_767_225_599, "2025-12-31T23:59:59Z"),
            (1_767_225_600, "2026-01-01T00:00:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(utc(seconds), date);
        }
    }

    #[test]
    fn processors_as_linux_describes_them() {
        let text = "processor\t: 0\nmodel name\t: Some CPU @ 2.00GHz\nmodel name\t: another\n";
        assert_eq!(model_name(text), Some("Some CPU @ 2.00GHz"));
        assert_eq!(model_name("Processor: ARM"), None);
    }

    #[test]
    fn a_run_knows_its_version_and_when_it_was() {
        let run = Run::start("1.2.3", Some("abcdef"));
        let mut found = run.provenance(2);
        found.seeds.insert("loop.seed".into(), 7);
        assert!(found.seconds >= 0.0 && found.date.starts_with("20"));
        let table = found.markdown();
        for row in [
            "| version | 1.2.3 |",
            "| commit | abcdef |",
            "| threads | 2 |",
            "| loop.seed | 7 |",
        ] {
            assert!(table.contains(row), "{row}: {table}");
        }
    }
}
