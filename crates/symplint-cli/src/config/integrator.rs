//! `[integrator]`: the time-advance map.

use std::sync::Arc;

use symplint::TimeAdvance;
use symplint_models::integrators::catalogue::{CATALOGUE, IntegratorInfo, build_solved_by};
use symplint_models::integrators::{Solver, StageSolver, Stop};
use symplint_models::maps::{Damped, SinglePrecision};
use symplint_models::{Model, ModelError};

use super::document::{Node, SETTING};
use super::error::ConfigError;
use super::section::{Accept, Key, Section, suggestion};
use super::system::NOTHING;

/// The keys of the stage solver, which only implicit methods have.
const OF_SOLVER: [&str; 4] = ["solver", "tolerance", "max_iterations", "iterations"];

/// The keys of `[integrator]`; `default` is the integrator of the system, as TOML.
pub fn keys(default: &'static str) -> [Key; 8] {
    [
        Key::new("name", default, "see `symplint list integrators`"),
        Key::optional(
            "variant",
            "\"position-first\"",
            "\"position-first\" or \"momentum-first\"; for rk2 \"midpoint\" or \"heun\"",
        ),
        Key::optional(
            "solver",
            "\"newton\"",
            "of implicit methods; \"fixed-point\" if left out",
        ),
        Key::optional(
            "tolerance",
            "1e-8",
            "to which implicit stages are solved; round-off if left out",
        ),
        Key::optional(
            "max_iterations",
            "50",
            "after which implicit stages fail; 200 if left out",
        ),
        Key::optional(
            "iterations",
            "2",
            "exactly so many for implicit stages, solved or not, in place of a tolerance",
        ),
        Key::optional(
            "damping",
            "0.01",
            "a fault to try: momenta are multiplied by exp(-damping h) after the step",
        ),
        Key::optional(
            "precision",
            "\"single\"",
            "a fault to try: states are rounded to 24 bits before and after the step",
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

/// A system that is a map: nothing but its own name fits.
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
            "the system is a map, with nothing to integrate",
            format!("leave the key out, or write name = \"{NOTHING}\""),
        )),
    }
}

fn integrated(
    section: &Section,
    name: &str,
    model: &Model,
) -> Result<(String, Box<dyn TimeAdvance>), ConfigError> {
    let info = CATALOGUE.iter().find(|info| info.name == name);
    let variant = if variant_of_another(section, info) {
        None
    } else {
        section.optional_text("variant")?
    };
    let solver = solver(section, info)?;
    let built = build_solved_by(solver, name, variant.as_deref(), model.clone());
    let map = built.map_err(|error| refusal(section, name, &error))?;
    let full_name = variant.map_or(name.to_owned(), |variant| format!("{name}, {variant}"));
    Ok((full_name, map))
}

/// What the catalogue has against it, at the key that caused it.
fn refusal(section: &Section, name: &str, error: &ModelError) -> ConfigError {
    match error {
        ModelError::UnknownIntegrator { .. } => section.error(
            "name",
            format!("there is no integrator \"{name}\""),
            suggestion(name, CATALOGUE.iter().map(|info| info.name)),
        ),
        ModelError::UnknownVariant { known, variant, .. } => section.error(
            "variant",
            format!("\"{name}\" has no variant \"{variant}\""),
            match known {
                [] => "it has none: leave the key out".to_owned(),
                known => suggestion(variant, known.iter().copied()),
            },
        ),
        ModelError::NotForThis {
            needs, kind, known, ..
        } => section.error(
            "name",
            format!("\"{name}\" is for {needs}, and this system is {kind}"),
            format!("there are: {}", known.join(", ")),
        ),
        ModelError::TooManyUnknowns { unknowns, limit } => section.error(
            "solver",
            format!("{unknowns} equations for each sample, and {limit} are the most for newton"),
            "use \"fixed-point\"",
        ),
        other => section.error("name", other.to_string(), "choose another integrator"),
    }
}

/// How stages are solved; the keys are refused where there are none to solve.
fn solver(section: &Section, info: Option<&IntegratorInfo>) -> Result<StageSolver, ConfigError> {
    let mut solver = StageSolver::default();
    let Some(info) = info else {
        return Ok(solver);
    };
    if !info.is_implicit() {
        let written = |key: &&str| section.written_place(key).is_some();
        return match OF_SOLVER.into_iter().find(written) {
            Some(key) if !of_another(section, key) => Err(section.error(
                key,
                format!("\"{}\" has no stages to be solved", info.name),
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

/// When the iteration for the stages ends.
fn stop(section: &Section) -> Result<Stop, ConfigError> {
    const MOST: u64 = 1_000_000;
    let tolerance = section.optional_number("tolerance", Accept::NotNegative)?;
    let whole = |key| match section.written_place(key) {
        Some(_) => section.whole_between(key, 1, MOST).map(Some),
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
            "given besides tolerance or max_iterations",
            "leave out either iterations or the others",
        )),
    }
}

/// The map with the faults that were asked for.
fn with_faults(
    section: &Section,
    full_name: &mut String,
    mut map: Box<dyn TimeAdvance>,
) -> Result<Box<dyn TimeAdvance>, ConfigError> {
    if let Some(rate) = section.optional_number("damping", Accept::Finite)? {
        let damped = Damped::new(map, rate)
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

/// Whether `--set` named another integrator than the file did, for which the file's variant
/// means nothing.
fn variant_of_another(section: &Section, info: Option<&IntegratorInfo>) -> bool {
    let written = section.written_text("variant");
    of_another(section, "variant")
        && written
            .zip(info)
            .is_some_and(|(variant, info)| !info.variants.contains(&variant))
}

/// Whether `key` is the file's and the name of the integrator is not, but from `--set`.
fn of_another(section: &Section, key: &str) -> bool {
    let set = |key| {
        section
            .written_place(key)
            .is_some_and(|place| place.source.name() == SETTING)
    };
    set("name") && !set(key)
}
