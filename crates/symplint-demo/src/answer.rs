//! The verdict, figures and animation of a configuration.

use serde::Serialize;
use symplint::{Diagnostic, Ensemble, Loop, TimeAdvance};
use symplint_config::{Config, ConfigError};
use symplint_report::figures::figures;
use symplint_report::report::to_json;
use symplint_report::text::{DisplayOptions, diagnosis_text, headline};

use crate::typed::TypedRun;

/// Characters of a line of the report.
const WIDTH: usize = 80;

/// Steps of the animation.
const STEPS: usize = 60;

/// States of the loop in the animation.
const SAMPLES: usize = 256;

/// The answer to a configuration.
#[derive(Serialize)]
struct Answer {
    /// `symplectic` and so on.
    kind: String,
    /// What `symplint check` prints.
    text: String,
    /// The figures of the run folder, by name, as SVG.
    figures: Vec<Drawing>,
    /// The loop before the first step and after each step.
    frames: Vec<Frame>,
}

#[derive(Serialize)]
struct Drawing {
    name: &'static str,
    svg: String,
}

/// Positions and momenta of the first degree of freedom.
#[derive(Serialize)]
struct Frame {
    q: Vec<f64>,
    p: Vec<f64>,
}

/// The reason why an answer is missing.
#[derive(Serialize)]
struct Refusal {
    error: String,
}

/// The verdict on a configuration in TOML, or on a typed step in JSON, its figures and the loop in time, or `error`, as JSON.
pub fn answer(question: &str) -> String {
    let found = match question.trim_start().starts_with('{') {
        true => typed(question),
        false => configured(question),
    };
    match found {
        Ok(answer) => to_json(&answer),
        Err(error) => to_json(&Refusal { error }),
    }
}

fn configured(configuration: &str) -> Result<Answer, String> {
    let config = Config::parse("configuration", configuration).map_err(|error| errors(&error))?;
    let titles = [config.title(), config.heading()];
    diagnose(
        titles,
        &*config.map,
        &*config.phase_loop,
        &config.diagnostic,
    )
}

fn typed(question: &str) -> Result<Answer, String> {
    let run: TypedRun = serde_json::from_str(question).map_err(|error| error.to_string())?;
    let (map, circle, diagnostic) = run.prepare()?;
    let title = "your step".to_owned();
    diagnose([title.clone(), title], &map, &circle, &diagnostic)
}

fn diagnose(
    [title, heading]: [String; 2],
    map: &dyn TimeAdvance,
    phase_loop: &dyn Loop,
    diagnostic: &Diagnostic,
) -> Result<Answer, String> {
    let diagnosis = (diagnostic.run(map, phase_loop)).map_err(|error| error.to_string())?;
    let (answer, rest) = headline(&diagnosis.verdict);
    let shown = DisplayOptions {
        width: Some(WIDTH),
        all: false,
    };
    let text = diagnosis_text(&heading, &diagnosis, shown);
    let picture = diagnosis.picture.as_ref();
    let h = picture.and_then(|picture| picture.step_size).unwrap_or(1.0);
    let figures = figures(&title, &diagnosis)
        .into_iter()
        .filter_map(|(name, figure)| {
            let svg = figure.to_svg().ok()?;
            Some(Drawing { name, svg })
        });
    Ok(Answer {
        kind: diagnosis.verdict.kind.to_string(),
        text: format!("{answer}{rest}\n{text}"),
        figures: figures.collect(),
        frames: frames(map, phase_loop, h),
    })
}

/// The loop in time, until the map fails.
fn frames(map: &dyn TimeAdvance, phase_loop: &dyn Loop, h: f64) -> Vec<Frame> {
    let Ok(mut states) = Ensemble::sample(phase_loop, SAMPLES) else {
        return Vec::new();
    };
    let frame = |states: &Ensemble| Frame {
        q: states.q().row(0).to_vec(),
        p: states.p().row(0).to_vec(),
    };
    let mut frames = vec![frame(&states)];
    while frames.len() <= STEPS && states.advance(map, h).is_ok() {
        frames.push(frame(&states));
    }
    frames
}

/// All errors of a configuration, one on each line.
fn errors(first: &ConfigError) -> String {
    let all = std::iter::once(first).chain(&first.others);
    let lines: Vec<String> = all
        .map(|error| match &error.remedy {
            Some(remedy) => format!("{}: {remedy}", error.message),
            None => error.message.clone(),
        })
        .collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    fn answered(text: &str) -> Value {
        serde_json::from_str(&answer(text)).unwrap()
    }

    #[test]
    fn a_configuration_has_a_verdict_figures_and_frames() {
        let answer = answered(
            "system.name = \"pendulum\"\nintegrator.name = \"rk2\"\ndiagnostic.budget = 20000",
        );
        assert_eq!(answer["kind"], "not-symplectic");
        let text = answer["text"].as_str().unwrap();
        assert!(text.starts_with("NOT SYMPLECTIC"), "{text}");
        assert!(text.contains("pendulum · rk2 · 1 degree of freedom"));
        let figures = answer["figures"].as_array().unwrap();
        let names: Vec<&Value> = figures.iter().map(|figure| &figure["name"]).collect();
        assert_eq!(names, ["step_sizes", "loop"]);
        let frames = answer["frames"].as_array().unwrap();
        assert_eq!(frames.len(), STEPS + 1);
        assert_eq!(frames[STEPS]["q"].as_array().unwrap().len(), SAMPLES);
    }

    fn question(step: &str) -> String {
        serde_json::json!({"step": step, "q0": [1.0], "p0": [0.5], "radius": 0.5, "step_sizes": [0.5, 0.25, 0.125, 0.0625]})
            .to_string()
    }

    #[test]
    fn typed_steps_have_the_verdict_of_theory() {
        let leapfrog = "p = p - h/2*sin(q)\nq = q + h*p\np = p - h/2*sin(q)";
        assert_eq!(answered(&question(leapfrog))["kind"], "symplectic");
        let euler = "F = -sin(q)\nq = q + h*p\np = p + h*F";
        let found = answered(&question(euler));
        assert_eq!(found["kind"], "not-symplectic", "{found}");
        let damped = "p = (p - h*sin(q))*exp(-0.1*h)\nq = q + h*p";
        let found = answered(&question(damped));
        assert!(
            found["text"].as_str().unwrap().contains("uniform friction"),
            "{found}"
        );
        let error = answered(&question("p = p - h*sni(q)"));
        let error = error["error"].as_str().unwrap();
        assert!(
            error.starts_with("line 1, column 11: sni is unknown"),
            "{error}"
        );
    }

    #[test]
    fn errors_are_answers() {
        let answer = answered("system.name = \"pendulm\"\ndiagnostic.budget = 1");
        let error = answer["error"].as_str().unwrap();
        assert_eq!(error.lines().count(), 2, "{error}");
        assert!(error.contains("did you mean \"pendulum\""), "{error}");
    }
}
