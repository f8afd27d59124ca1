//! An expression that a user types: checked here, so that an error names its place, and evaluated by `exmex`.

use exmex::{Express, FlatEx};

/// Functions of one number.
pub const FUNCTIONS: [&str; 19] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "ln", "log10",
    "sqrt", "cbrt", "abs", "signum", "floor", "ceil", "round",
];

/// π, as users type it and as `exmex` reads it.
const PI: [&str; 2] = ["pi", "PI"];

/// An error and its place in the text, in characters from 0.
#[derive(Debug, PartialEq)]
pub struct Misprint {
    pub at: usize,
    pub message: String,
}

/// The kind of the last token.
#[derive(Clone, Copy, PartialEq)]
enum TokenKind {
    /// Nothing, or an opening parenthesis.
    Start,
    Operator(char),
    Function,
    Operand,
}

/// An expression of some of the names that are known.
#[derive(Debug)]
pub struct Expression {
    of: FlatEx<f64>,
    /// The place of each variable of `of` among the names.
    places: Vec<usize>,
}

impl Expression {
    /// Reads an expression of these names.
    ///
    /// # Errors
    /// The first misprint.
    pub fn parse(text: &str, names: &[String]) -> Result<Self, Misprint> {
        let normal = normal_form(text, names)?;
        let failed = |message: String| Misprint { at: 0, message };
        let of = FlatEx::<f64>::parse(&normal).map_err(|error| failed(error.to_string()))?;
        let place = |name: &String| names.iter().position(|known| known == name);
        let places: Option<Vec<usize>> = of.var_names().iter().map(place).collect();
        let places = places.ok_or_else(|| failed("a name is unknown".into()))?;
        Ok(Expression { of, places })
    }

    /// The value for these values of the names; not a number if it cannot be computed.
    pub fn value(&self, values: &[f64]) -> f64 {
        let of_variables: Vec<f64> = self.places.iter().map(|&place| values[place]).collect();
        self.of.eval(&of_variables).unwrap_or(f64::NAN)
    }
}

/// The expression as `exmex` reads it. There `-q^2` is `(-q)^2`, and parentheses may be missing: neither is accepted.
fn normal_form(text: &str, names: &[String]) -> Result<String, Misprint> {
    let letters: Vec<char> = text.chars().collect();
    let error = |at: usize, message: String| Err(Misprint { at, message });
    let mut normal = String::new();
    let mut last = TokenKind::Start;
    let mut open = Vec::new();
    // Whether the operand under way is an exponent.
    let mut is_exponent = vec![false];
    let mut at = 0;
    while let Some(&letter) = letters.get(at) {
        let begin = at;
        at += 1;
        let expects_operand = last != TokenKind::Operand;
        match letter {
            ' ' | '\t' => continue,
            _ if last == TokenKind::Function && letter != '(' => {
                return error(begin, "a function needs parentheses, such as sin(q)".into());
            }
            '0'..='9' | '.' => {
                at = end_of_number(&letters, begin);
                let number: String = letters[begin..at].iter().collect();
                let Ok(value) = number.parse::<f64>() else {
                    return error(begin, format!("{number} is not a number"));
                };
                if !expects_operand {
                    return error(begin, format!("an operator is missing before {number}"));
                }
                normal += &format!("{value}");
                last = TokenKind::Operand;
            }
            _ if letter.is_alphabetic() || letter == '_' => {
                let is_of_name = |letter: &&char| letter.is_alphanumeric() || **letter == '_';
                at += letters[at..].iter().take_while(is_of_name).count();
                let name: String = letters[begin..at].iter().collect();
                if !expects_operand {
                    let remedy = format!("an operator is missing before {name}: write *{name}");
                    return error(begin, remedy);
                }
                match of_name(&name, names) {
                    Ok((found, kind)) => {
                        normal += found;
                        last = kind;
                    }
                    Err(message) => return error(begin, message),
                }
            }
            '(' if !expects_operand => {
                return error(begin, "an operator is missing before (: write *(".into());
            }
            '(' => {
                normal.push('(');
                open.push(begin);
                is_exponent.push(false);
                last = TokenKind::Start;
            }
            ')' => {
                if open.pop().is_none() {
                    return error(begin, "there is no ( for this ): remove it".into());
                }
                if expects_operand {
                    return error(begin, "a number or a name is missing before )".into());
                }
                is_exponent.pop();
                normal.push(')');
                last = TokenKind::Operand;
            }
            '-' if last == TokenKind::Start || last == TokenKind::Operator('+') => {
                normal += "0-";
                last = TokenKind::Operator('-');
            }
            '+' | '-' | '*' | '/' | '^' => {
                let is_power = letter == '^' || letters.get(at) == Some(&'*') && letter == '*';
                at += usize::from(is_power && letter == '*');
                if expects_operand {
                    let message = match letter {
                        '-' => "put the negative number in parentheses: (-1)".to_owned(),
                        _ => format!("a number or a name is missing before {letter}"),
                    };
                    return error(begin, message);
                }
                let exponent = is_exponent.last_mut().expect("one for each parenthesis");
                if is_power && *exponent {
                    return error(begin, "two powers need parentheses, such as (q^2)^3".into());
                }
                *exponent = is_power;
                let operator = if is_power { '^' } else { letter };
                normal.push(operator);
                last = TokenKind::Operator(operator);
            }
            _ => {
                return error(
                    begin,
                    format!("{letter} is not part of an expression: use + - * / ^ ( ) and names"),
                );
            }
        }
    }
    check_end(last, &open, letters.len())?;
    Ok(normal)
}

/// Checks that an expression of this length ends with an operand, and that no parenthesis is `open`.
///
/// # Errors
/// If it does not, or the last one is.
fn check_end(last: TokenKind, open: &[usize], length: usize) -> Result<(), Misprint> {
    let (at, message) = match open.last() {
        _ if last != TokenKind::Operand => (length, "a number or a name is missing at the end"),
        Some(&at) => (at, "this ( is not closed: add )"),
        None => return Ok(()),
    };
    let message = message.into();
    Err(Misprint { at, message })
}

/// How `exmex` names what is called `name`, and whether it is an operand or a function.
///
/// # Errors
/// If nothing has this name: the names that are known.
fn of_name<'n>(name: &'n str, names: &[String]) -> Result<(&'n str, TokenKind), String> {
    if names.iter().any(|known| known == name) {
        Ok((name, TokenKind::Operand))
    } else if name == PI[0] {
        Ok((PI[1], TokenKind::Operand))
    } else if FUNCTIONS.contains(&name) {
        Ok((name, TokenKind::Function))
    } else {
        Err(format!(
            "{name} is unknown: the names are {}, pi, and the functions {}",
            names.join(", "),
            FUNCTIONS.join(", ")
        ))
    }
}

/// The end of a number such as `1.5e-3`.
fn end_of_number(letters: &[char], begin: usize) -> usize {
    let digits = |from: usize| {
        let is_of_number = |letter: &&char| letter.is_ascii_digit() || **letter == '.';
        from + letters[from..].iter().take_while(is_of_number).count()
    };
    let end = digits(begin);
    if !matches!(letters.get(end), Some('e' | 'E')) {
        return end;
    }
    let sign = usize::from(matches!(letters.get(end + 1), Some('+' | '-')));
    match letters.get(end + 1 + sign) {
        Some(digit) if digit.is_ascii_digit() => digits(end + 1 + sign),
        _ => end,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Vec<String> {
        ["q", "p", "h"].map(String::from).to_vec()
    }

    #[test]
    fn values_are_those_of_mathematics() {
        let (q, p, h) = (0.7, -1.3, 0.25);
        for (text, value) in [
            ("p - h*sin(q)", p - h * f64::sin(q)),
            ("-q^2", -q * q),
            ("2 + -q^2", 2.0 - q * q),
            ("(-q)^2", q * q),
            ("1.5e-3*q**3 / 2", 1.5e-3 * q * q * q / 2.0),
            ("q/p/h", q / p / h),
            ("q - p - h", q - p - h),
            (
                "exp(-h*(q^2 + p^2)/2)",
                f64::exp(-h * (q * q + p * p) / 2.0),
            ),
            ("cos(2*pi*q)", (2.0 * std::f64::consts::PI * q).cos()),
            ("-(q + 1e3)", -(q + 1e3)),
            ("2^(-1)", 0.5),
        ] {
            let found = Expression::parse(text, &names()).unwrap();
            let found = found.value(&[q, p, h]);
            assert!(
                (found - value).abs() < 1e-14 * value.abs(),
                "{text}: {found} and {value}"
            );
        }
    }

    #[test]
    fn misprints_have_a_place_and_a_remedy() {
        for (text, at, words) in [
            ("p - h*sni(q)", 6, "sni is unknown"),
            ("2q", 1, "write *q"),
            ("sin q", 4, "parentheses, such as sin(q)"),
            ("(q + 1", 0, "is not closed: add )"),
            ("q + 1)", 5, "remove it"),
            ("q + ", 4, "missing at the end"),
            ("q * / p", 4, "missing before /"),
            ("q * -p", 4, "in parentheses"),
            ("q^2^3", 3, "two powers need parentheses"),
            ("q = p", 2, "= is not part of an expression"),
            ("1.2.3", 0, "is not a number"),
            ("", 0, "missing at the end"),
            ("()", 1, "missing before )"),
            ("q(p)", 1, "write *("),
            ("3 4", 2, "an operator is missing before 4"),
        ] {
            let found = Expression::parse(text, &names()).unwrap_err();
            assert_eq!(found.at, at, "{text}: {}", found.message);
            assert!(found.message.contains(words), "{text}: {}", found.message);
        }
    }
}
