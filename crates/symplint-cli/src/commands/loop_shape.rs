//! The loop of `symplint loop` without a configuration.

use symplint::{Circle, Coordinates, FourierLoop, Loop, Phases};

use super::per_dof::per_dof;
use crate::cli::{self, LoopShape, Shape};
use crate::failure::Failure;

/// Degrees of freedom at most.
const MAX_DOF: usize = 1 << 24;

/// Refuses the options that describe a loop where there is a configuration.
///
/// # Errors
/// If one was given.
pub fn refuse_with_configuration(options: &LoopShape) -> Result<(), Failure> {
    let given = [
        ("--dof", options.dof.is_some(), ""),
        ("--q0", !options.q0.is_empty(), "system.q0"),
        ("--p0", !options.p0.is_empty(), "system.p0"),
        ("--center", !options.center.is_empty(), "system.q0"),
        ("--radius", options.radius.is_some(), "loop.radius"),
        ("--shape", options.shape.is_some(), "loop.shape"),
        ("--phases", options.phases.is_some(), "loop.phases"),
        ("--seed", options.seed.is_some(), "loop.seed"),
        ("--period", !options.period.is_empty(), ""),
        ("--weight", !options.weight.is_empty(), ""),
    ];
    let Some((option, _, key)) = given.into_iter().find(|(_, given, _)| *given) else {
        return Ok(());
    };
    Err(usage(
        format!("{option} is for a loop without a configuration"),
        match key {
            "" => format!("leave {option} out: the system of the configuration determines it"),
            _ => format!("change the configuration, for example by --set {key}=…"),
        },
    ))
}

/// The loop, and the meaning of its coordinates.
///
/// # Errors
/// If options are missing or contradict each other, or the loop or its coordinates are not valid.
pub fn build(options: &LoopShape) -> Result<(Box<dyn Loop>, Coordinates), Failure> {
    let dof = degrees_of_freedom(options)?;
    let (q0, p0) = centre(options, dof)?;
    let radius = options.radius.unwrap_or(1.0);
    let seed = options.seed.unwrap_or(1) as u64;
    let shape = options.shape.unwrap_or(Shape::Circle);
    let phase_loop: Box<dyn Loop> = match (shape, options.phases) {
        (Shape::Circle, chosen) => {
            let phases = match chosen {
                None | Some(cli::Phases::Staggered) => Phases::Staggered,
                Some(cli::Phases::Equal) => Phases::Equal,
                Some(cli::Phases::Random) => Phases::Random { seed },
            };
            let circle = Circle::new(q0, p0, radius).map_err(Failure::Option)?;
            Box::new(circle.with_phases(phases))
        }
        (Shape::Fourier, Some(_)) => {
            return Err(usage(
                "--phases applies to circles only",
                "leave --phases out: a fourier loop has random phases",
            ));
        }
        (Shape::Fourier, None) => {
            let radii = vec![radius; dof];
            let random = FourierLoop::random(q0, p0, &radii, &radii, seed);
            Box::new(random.map_err(Failure::Option)?)
        }
    };
    let mut coordinates = Coordinates::plain(dof);
    if let Some(period) = per_dof("--period", &options.period, dof)? {
        coordinates = coordinates.with_periods(period).map_err(Failure::Option)?;
    }
    if let Some(weight) = per_dof("--weight", &options.weight, dof)? {
        coordinates = coordinates.with_weights(weight).map_err(Failure::Option)?;
    }
    Ok((phase_loop, coordinates))
}

/// From --dof, or else the length of the longest list.
fn degrees_of_freedom(options: &LoopShape) -> Result<usize, Failure> {
    let dof = match (options.dof, &options.center[..]) {
        (Some(dof), _) => dof,
        (None, [_, _, ..]) => options.center.len() / 2,
        (None, _) => {
            let lists = [&options.q0, &options.p0, &options.period, &options.weight];
            lists.map(Vec::len).into_iter().max().unwrap_or(0)
        }
    };
    match dof {
        0 => Err(usage(
            "neither a configuration nor the number of degrees of freedom is given",
            "name a configuration, or give --dof: symplint loop --dof 3 --radius 0.5 -o before.npz",
        )),
        dof if dof > MAX_DOF => Err(usage(
            format!("--dof {dof} is too large"),
            format!("give at most {MAX_DOF}"),
        )),
        dof => Ok(dof),
    }
}

fn centre(options: &LoopShape, dof: usize) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    match &options.center[..] {
        [] => {
            let of = |option, values| {
                Ok::<_, Failure>(per_dof(option, values, dof)?.unwrap_or(vec![0.0; dof]))
            };
            Ok((of("--q0", &options.q0)?, of("--p0", &options.p0)?))
        }
        [one] => Ok((vec![*one; dof], vec![*one; dof])),
        both if both.len() == 2 * dof => Ok((both[..dof].to_vec(), both[dof..].to_vec())),
        other => Err(usage(
            format!(
                "--center has {} numbers for {dof} degrees of freedom",
                other.len()
            ),
            format!(
                "give one number for all, or {}: the positions and then the momenta",
                2 * dof
            ),
        )),
    }
}

fn usage(message: impl Into<String>, remedy: impl Into<String>) -> Failure {
    Failure::Usage {
        message: message.into(),
        remedy: remedy.into(),
    }
}
