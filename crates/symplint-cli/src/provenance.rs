//! The origin of the reports of this program.

use symplint_report::provenance::Provenance;
pub use symplint_report::provenance::Run;

/// A run that starts now.
pub fn start() -> Run {
    // The build script looks for the commit.
    Run::start(env!("CARGO_PKG_VERSION"), option_env!("SYMPLINT_COMMIT"))
}

/// The provenance of the results of a run so far, with the seeds of its configuration.
pub fn of(run: &Run, config: &toml::Table) -> Provenance {
    let mut provenance = run.provenance(rayon::current_num_threads());
    for (section, keys) in config {
        let seed = keys.get("seed").and_then(toml::Value::as_integer);
        if let Some(seed) = seed.and_then(|seed| u64::try_from(seed).ok()) {
            provenance.seeds.insert(format!("{section}.seed"), seed);
        }
    }
    provenance
}
