//! `[integrator]`: the time-advance map.

use std::sync::Arc;

use symplint::TimeAdvance;
use symplint_models::integrators::aliases::{self, ALIASES};
use symplint_models::integrators::catalogue::IntegratorInfo;
use symplint_models::integrators::{Solver, StageSolver, Stop};
use symplint_models::maps::{DampedMap, SinglePrecision};
use symplint_models::{Model, ModelError};
use symplint_plasma::CATALOGUE;

use super::document::Node;
use super::error::ConfigError;
use super::section::{Key, NumberRange, Section, suggestion};
use super::system::NOTHING;

/// The keys of the stage solver, which only implicit methods accept.
const OF_SOLVER: [&str; 4] = ["solver", "tolerance", "max_iterations", "iterations"];

/// The keys of `[integrator]`; `default` is the default integrator of the system, as TOML.
pub fn keys(default: &'static str) -> [Key; 8] {
    [
        Key::new("name", default, "see `symplint list integrators`"),
        Key::optional(
            "variant",
            "\"position-first\"",
            "\"position-first\" or \"momentum-first\"; for rk2 \"midpoint\" or \"heun\"; for crank-nicolson \"midpoint\", \
             \"sub-stepped\" or \"orbit-averaged\"; for boris-pic \"synchronised\", \"staggered\", \"nodal\" or \
             \"direct\"; for partitioned-rk \"strang-position-first\" or \"strang-momentum-first\"",
        ),
        Key::optional(
            "solver",
            "\"newton\"",
            "solver of implicit methods; by default \"fixed-point\"",
        ),
        Key::optional(
            "tolerance",
            "1e-8",
            "tolerance of the solver of implicit methods; by default rounding error",
        ),
        Key::optional(
            "max_iterations",
            "50",
            "iterations after which the solver fails; by default 1000",
        ),
        Key::optional(
            "iterations",
            "2",
            "a fixed number of iterations, converged or not, instead of a tolerance",
        ),
        Key::optional(
            "damping",
            "0.01",
            "a deliberate fault: multiplies momenta by exp(-damping h) after the step",
        ),
        Key::optional(
            "precision",
            "\"single\"",
            "a deliberate fault: rounds states to single precision before and after the step",
        ),
    ]
}

/// Reads `[integrator]` and builds its step for `model`.
pub fn read(
    node: Option<&Node>,
    default: &'static str,
    model: &Model,
) -> Result<(String, Box<dyn TimeAdvance>, Section), ConfigError> {
    let section = Section::new("integrator", node, keys(default).to_vec())?;
    let name = section.text("name")?;
    let (mut full_name, map) = match model {
        Model::Map(map) => given(&section, &name, map)?,
        _ => integrated(&section, &name, model)?,
    };
    let map = with_faults(&section, &mut full_name, map)?;
    Ok((full_name, map, section))
}

/// A system that is a map: no integrator applies to it.
fn given(
    section: &Section,
    name: &str,
    map: &Arc<dyn TimeAdvance>,
) -> Result<(String, Box<dyn TimeAdvance>), ConfigError> {
    let of_integrators = ["variant"].iter().chain(&OF_SOLVER);
    let written = of_integrators
        .copied()
        .find(|key| section.written_place(key).is_some());
    let refused = if name == NOTHING {
        written
    } else {
        Some("name")
    };
    match refused {
        None => Ok((NOTHING.to_owned(), Box::new(Arc::clone(map)))),
        Some(key) => Err(section.error(
            key,
            "the system is a map and does not accept an integrator",
            format!("leave the key out, or write name = \"{NOTHING}\""),
        )),
    }
}

fn integrated(
    section: &Section,
    name: &str,
    model: &Model,
) -> Result<(String, Box<dyn TimeAdvance>), ConfigError> {
    let variant = if variant_of_another(section, name) {
        None
    } else {
        section.optional_text("variant")?
    };
    let refused = |error| refusal(section, name, &error);
    let (info, variant) = (CATALOGUE.resolve(name, variant.as_deref())).map_err(refused)?;
    // The resolved configuration has the name in the catalogue, not an alias.
    section.record("name", info.name);
    if let Some(variant) = variant {
        section.record("variant", variant);
    }
    let solver = solver(section, info)?;
    let map = CATALOGUE.build(solver, info.name, variant, model.clone());
    let map = map.map_err(refused)?;
    let full_name = match variant {
        Some(variant) => format!("{}, {variant}", info.name),
        None => info.name.to_owned(),
    };
    Ok((full_name, map))
}

/// An error of the catalogue, at the key that caused it.
fn refusal(section: &Section, name: &str, error: &ModelError) -> ConfigError {
    match error {
        ModelError::UnknownIntegrator { .. } => section.error(
            "name",
            format!("unknown integrator \"{name}\""),
            suggestion(
                name,
                (CATALOGUE.iter().map(|info| info.name))
                    .chain(ALIASES.iter().map(|alias| alias.name)),
            ),
        ),
        ModelError::UnknownVariant { known, variant, .. } => match aliases::find(name) {
            Some(alias) if !alias.variants.is_empty() => section.error(
                "variant",
                format!(
                    "\"{name}\" is another name for \"{}\" with variant = \"{}\"",
                    alias.integrator, alias.variants[0]
                ),
                format!(
                    "leave variant out, or write name = \"{}\"",
                    alias.integrator
                ),
            ),
            _ => section.error(
                "variant",
                format!("\"{name}\" has no variant \"{variant}\""),
                match known {
                    [] => "it has no variants: leave the key out".to_owned(),
                    known => suggestion(variant, known.iter().copied()),
                },
            ),
        },
        ModelError::NotForThis {
            needs, kind, known, ..
        } => section.error(
            "name",
            format!("\"{name}\" is for {needs}, but this system is {kind}"),
            format!("available: {}", known.join(", ")),
        ),
        ModelError::TooManyUnknowns { unknowns, limit } => section.error(
            "solver",
            format!(
                "\"newton\" would solve {unknowns} equations for each sample, and accepts at most {limit}"
            ),
            "use \"fixed-point\"",
        ),
        ModelError::NoNewton { integrator } => section.error(
            "solver",
            format!("\"{integrator}\" is solved by fixed-point iteration alone"),
            "leave the key out",
        ),
        other => section.error("name", other.to_string(), "choose another integrator"),
    }
}

/// The solver of implicit stages; its keys are refused for explicit methods.
fn solver(section: &Section, info: &IntegratorInfo) -> Result<StageSolver, ConfigError> {
    let mut solver = StageSolver::default();
    if !info.is_implicit() {
        let written = |key: &&str| section.written_place(key).is_some();
        return match OF_SOLVER.into_iter().find(written) {
            Some(key) if !section.is_overruled(key, "name") => Err(section.error(
                key,
                format!("\"{}\" is explicit and does not accept this key", info.name),
                "leave the key out",
            )),
            _ => Ok(solver),
        };
    }
    if section.optional_text("solver")?.is_some() {
        solver.solver = match section.choice("solver", &["fixed-point", "newton"])? {
            "newton" => Solver::Newton,
            _ => Solver::FixedPoint,
        };
    }
    solver.stop = stop(section)?;
    Ok(solver)
}

/// When the iteration for the stages stops.
fn stop(section: &Section) -> Result<Stop, ConfigError> {
    const MAX_ITERATIONS: u64 = 1_000_000;
    let tolerance = section.optional_number("tolerance", NumberRange::NotNegative)?;
    let whole = |key| match section.written_place(key) {
        Some(_) => section.whole_between(key, 1, MAX_ITERATIONS).map(Some),
        None => Ok(None),
    };
    let (most, exactly) = (whole("max_iterations")?, whole("iterations")?);
    match (exactly, tolerance, most) {
        (Some(iterations), None, None) => Ok(Stop::Iterations(iterations as usize)),
        (None, tolerance, most) => Ok(Stop::Converged {
            tolerance: tolerance.unwrap_or(StageSolver::ROUNDOFF),
            max_iterations: most.map_or(StageSolver::MAX_ITERATIONS, |most| most as usize),
        }),
        _ => Err(section.error(
            "iterations",
            "cannot be combined with tolerance or max_iterations",
            "leave out either iterations or the other two",
        )),
    }
}

/// The map with deliberate faults, if the keys ask for them.
fn with_faults(
    section: &Section,
    full_name: &mut String,
    mut map: Box<dyn TimeAdvance>,
) -> Result<Box<dyn TimeAdvance>, ConfigError> {
    if let Some(rate) = section.optional_number("damping", NumberRange::Finite)? {
        let damped = DampedMap::new(map, rate)
            .map_err(|error| section.error("damping", error.to_string(), "give a number"))?;
        map = Box::new(damped);
        *full_name += &format!(", damping {rate}");
    }
    if section.optional_text("precision")?.is_some()
        && section.choice("precision", &["single", "double"])? == "single"
    {
        map = Box::new(SinglePrecision(map));
        *full_name += ", single precision";
    }
    Ok(map)
}

/// Whether the variant in the file belongs to the integrator in the file, and `--set` names another one
/// that does not have it.
fn variant_of_another(section: &Section, name: &str) -> bool {
    let written = section.written_text("variant");
    section.is_overruled("variant", "name")
        && written.is_some_and(|variant| CATALOGUE.resolve(name, Some(variant)).is_err())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_names_every_variant() {
        let keys = keys("\"strang\"");
        let help = keys.iter().find(|key| key.name == "variant").unwrap().help;
        for info in CATALOGUE.iter() {
            for variant in info.variants {
                let named = help.contains(&format!("\"{variant}\""));
                assert!(named, "{variant} of {} is not in: {help}", info.name);
            }
        }
    }
}
