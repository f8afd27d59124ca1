//! A step that a user types, one assignment on each line: `p = p - h*sin(q)`.

use serde::Deserialize;
use symplint::{Circle, Diagnostic, PerSample};

use crate::expression::{Expression, FUNCTIONS, Misprint};

/// Degrees of freedom of a typed step, at most.
const MAX_DOF: usize = 4;

/// Lines, and characters of a line, at most.
const MAX_LINES: usize = 60;
const MAX_LETTERS: usize = 500;

/// Evaluations of the diagnosis, as for the systems of the page.
const BUDGET: usize = 200_000;

/// The request of the page: `step` and the loop.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TypedRun {
    step: String,
    q0: Vec<f64>,
    p0: Vec<f64>,
    radius: f64,
    step_sizes: Vec<f64>,
}

/// A line of the step: the place of the name, and its new value.
struct Assignment {
    place: usize,
    value: Expression,
}

/// A step of assignments, carried out one after the other.
pub struct TypedStep {
    dof: usize,
    /// Positions, momenta, h, and names of the user.
    names: usize,
    assignments: Vec<Assignment>,
}

impl TypedStep {
    /// Reads a step.
    ///
    /// # Errors
    /// The line, the column and the remedy of the first misprint.
    pub fn parse(text: &str) -> Result<Self, String> {
        let lines = || {
            text.lines().enumerate().filter_map(|(number, line)| {
                let code = line.split('#').next().unwrap_or_default();
                (!code.trim().is_empty()).then_some((number + 1, code))
            })
        };
        if lines().count() == 0 {
            return Err("the step is empty: type lines such as q = q + h*p".into());
        }
        if lines().count() > MAX_LINES || lines().any(|(_, code)| code.len() > MAX_LETTERS) {
            return Err(format!(
                "the step is too long: at most {MAX_LINES} lines of {MAX_LETTERS} characters"
            ));
        }
        let dof = dof_of(text)?;
        let mut names = coordinates(dof);
        names.push("h".into());
        let mut assignments = Vec::new();
        for (number, code) in lines() {
            let place = |column: usize| format!("line {number}, column {}", column + 1);
            let Some((left, right)) = code.split_once('=') else {
                return Err(format!(
                    "{}: there is no =: write a line such as q = q + h*p",
                    place(0)
                ));
            };
            let begin = left
                .chars()
                .take_while(|letter| letter.is_whitespace())
                .count();
            let name = left.trim();
            check_name(name).map_err(|message| format!("{}: {message}", place(begin)))?;
            let value = Expression::parse(right, &names);
            let value = value.map_err(|Misprint { at, message }| {
                format!("{}: {message}", place(left.chars().count() + 1 + at))
            })?;
            let place = match names.iter().position(|known| known == name) {
                Some(place) => place,
                None => {
                    names.push(name.into());
                    names.len() - 1
                }
            };
            assignments.push(Assignment { place, value });
        }
        if assignments.iter().all(|of| of.place >= 2 * dof) {
            return Err("no line changes q or p: type lines such as q = q + h*p".into());
        }
        Ok(TypedStep {
            dof,
            names: names.len(),
            assignments,
        })
    }

    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Advances one state.
    pub fn advance(&self, h: f64, q: &mut [f64], p: &mut [f64]) {
        let mut values = vec![f64::NAN; self.names];
        let dof = self.dof;
        values[..dof].copy_from_slice(q);
        values[dof..2 * dof].copy_from_slice(p);
        values[2 * dof] = h;
        for Assignment { place, value } in &self.assignments {
            values[*place] = value.value(&values);
        }
        q.copy_from_slice(&values[..dof]);
        p.copy_from_slice(&values[dof..2 * dof]);
    }
}

impl TypedRun {
    /// The map, the loop and the diagnosis.
    ///
    /// # Errors
    /// A misprint, or states that do not fit the step.
    pub fn prepare(
        &self,
    ) -> Result<(impl symplint::TimeAdvance + use<>, Circle, Diagnostic), String> {
        let step = TypedStep::parse(&self.step)?;
        let dof = step.dof();
        if self.q0.len() != dof || self.p0.len() != dof {
            return Err(format!(
                "the step has {dof} position{}, and the loop has {} and {} momenta: give as many of each",
                if dof == 1 { "" } else { "s" },
                self.q0.len(),
                self.p0.len()
            ));
        }
        let circle = Circle::new(self.q0.clone(), self.p0.clone(), self.radius)
            .map_err(|error| error.to_string())?;
        let map = PerSample::new(dof, move |h: f64, q: &mut [f64], p: &mut [f64]| {
            step.advance(h, q, p)
        });
        let diagnostic = Diagnostic {
            step_sizes: self.step_sizes.clone(),
            budget: Some(BUDGET),
            ..Diagnostic::default()
        };
        Ok((map, circle, diagnostic))
    }
}

/// The names of all coordinates: `q`, `p`, or `q1`, `q2`, `p1`, `p2`.
fn coordinates(dof: usize) -> Vec<String> {
    let all = |letter: &'static str| {
        (1..=dof).map(move |i| match dof {
            1 => letter.to_owned(),
            _ => format!("{letter}{i}"),
        })
    };
    all("q").chain(all("p")).collect()
}

/// The degrees of freedom, from the names in a step.
fn dof_of(text: &str) -> Result<usize, String> {
    let code = text
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default());
    let words: Vec<&str> = code
        .flat_map(|line| line.split(|letter: char| !letter.is_alphanumeric() && letter != '_'))
        .collect();
    let has_plain = words.iter().any(|word| matches!(*word, "q" | "p"));
    let number = |word: &&str| word.strip_prefix(['q', 'p'])?.parse::<usize>().ok();
    match words.iter().filter_map(number).max() {
        None => Ok(1),
        Some(_) if has_plain => {
            Err("the names are q and p, or q1, p1, q2, p2 and so on: use one kind".into())
        }
        Some(dof @ 2..=MAX_DOF) => Ok(dof),
        Some(1) => Err("one position and its momentum are q and p: write q instead of q1".into()),
        Some(dof) => Err(format!(
            "the step has {dof} degrees of freedom: the page takes up to {MAX_DOF}"
        )),
    }
}

/// Checks the name on the left of a line.
fn check_name(name: &str) -> Result<(), String> {
    let is_name = name.starts_with(char::is_alphabetic)
        && name
            .chars()
            .all(|letter| letter.is_alphanumeric() || letter == '_');
    if !is_name {
        return Err(format!(
            "{name:?} is not a name: write one name before the ="
        ));
    }
    let is_taken = name == "h" || name == "pi" || FUNCTIONS.contains(&name);
    // Constants of exmex.
    match is_taken || ["PI", "π", "E", "e", "TAU", "τ"].contains(&name) {
        true => Err(format!("{name} has a value already: choose another name")),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn advanced(text: &str, q: f64, p: f64) -> (f64, f64) {
        let (mut q, mut p) = ([q], [p]);
        TypedStep::parse(text).unwrap().advance(0.1, &mut q, &mut p);
        (q[0], p[0])
    }

    #[test]
    fn lines_are_carried_out_in_their_order() {
        let (q, p) = advanced("# kick\np = p - h*sin(q)\n\nq = q + h*p  # drift", 1.0, 0.5);
        let kicked = 0.5 - 0.1 * f64::sin(1.0);
        assert_eq!((q, p), (1.0 + 0.1 * kicked, kicked));
        let (q, p) = advanced("F = -sin(q)\nq = q + h*p\np = p + h*F", 1.0, 0.5);
        assert_eq!((q, p), (1.0 + 0.1 * 0.5, 0.5 - 0.1 * f64::sin(1.0)));
        let step = TypedStep::parse("p1 = p1 - h*q2\nq2 = q2 + h*p2").unwrap();
        assert_eq!(step.dof(), 2);
        let (mut q, mut p) = ([1.0, 2.0], [3.0, 4.0]);
        step.advance(0.5, &mut q, &mut p);
        assert_eq!((q, p), ([1.0, 4.0], [2.0, 4.0]));
    }

    #[test]
    fn errors_name_line_column_and_remedy() {
        for (text, message) in [
            (
                "q = q + h*p\np = p - h*sni(q)",
                "line 2, column 11: sni is unknown",
            ),
            (
                "q + h*p",
                "line 1, column 1: there is no =: write a line such as",
            ),
            ("h = 1\nq = 2", "line 1, column 1: h has a value already"),
            ("  2 = q", "line 1, column 3: \"2\" is not a name"),
            (
                "q = q + h*",
                "line 1, column 11: a number or a name is missing at the end",
            ),
            ("q = F\nF = 1", "line 1, column 5: F is unknown"),
            ("F = 1", "no line changes q or p"),
            ("# nothing", "the step is empty"),
            ("q1 = q1 + h*p", "use one kind"),
            ("q1 = q1 + h*p1", "write q instead of q1"),
            ("q9 = 1", "up to 4"),
        ] {
            let found = TypedStep::parse(text).err().expect(text);
            assert!(found.contains(message), "{text}: {found}");
        }
    }
}
