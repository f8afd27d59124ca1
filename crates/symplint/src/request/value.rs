//! Values of settings, and what a setting accepts.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::number;

/// The value of a setting, as a configuration, an argument or a JSON text has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// True or false.
    Flag(bool),
    /// A whole number that is not negative.
    Whole(u64),
    /// Any other number.
    Number(f64),
    /// A string.
    Text(String),
    /// A list.
    List(Vec<Value>),
    /// A table.
    Table(BTreeMap<String, Value>),
}

/// Numbers that a setting accepts.
#[derive(Clone, Copy, Debug)]
pub enum NumberRange {
    /// Every finite number.
    Finite,
    /// Finite numbers above 0.
    Positive,
    /// Finite numbers from 0.
    NotNegative,
    /// Finite numbers other than 0.
    NotZero,
}

impl NumberRange {
    fn expected(self) -> &'static str {
        match self {
            NumberRange::Finite => "a finite number",
            NumberRange::Positive => "a number above 0",
            NumberRange::NotNegative => "a number that is not negative",
            NumberRange::NotZero => "a finite number other than 0",
        }
    }

    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                NumberRange::Finite => true,
                NumberRange::Positive => value > 0.0,
                NumberRange::NotNegative => value >= 0.0,
                NumberRange::NotZero => value != 0.0,
            }
    }
}

/// Why a value is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The problem, to follow the name of the setting: "is 0".
    pub message: String,
    /// What to do: "give a whole number of at least 1".
    pub remedy: String,
    /// The expected kind, if the value has another one: "a number".
    pub expected: Option<String>,
    /// The item of a list, or the key of a table, that is refused.
    pub part: Option<ValuePart>,
}

/// A part of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum ValuePart {
    /// An item of a list.
    Item(usize),
    /// The value of a key.
    Key(String),
}

/// What follows the name of the setting.
impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.part {
            Some(ValuePart::Item(k)) => write!(f, "[{k}]")?,
            Some(ValuePart::Key(name)) => write!(f, ".{name}")?,
            None => {}
        }
        write!(f, " {}; {}", self.message, self.remedy)
    }
}

impl Refusal {
    /// A value that may have this type but not this value.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Refusal {
            message: message.into(),
            remedy: remedy.into(),
            expected: None,
            part: None,
        }
    }

    fn beside(value: &Value, expected: &str, remedy: &str) -> Self {
        Refusal {
            expected: Some(expected.to_owned()),
            ..Refusal::new(format!("is {}, not {expected}", value.kind()), remedy)
        }
    }

    fn outside(value: impl std::fmt::Display, expected: String) -> Self {
        Refusal {
            expected: Some(expected.clone()),
            ..Refusal::new(format!("is {value}"), format!("give {expected}"))
        }
    }

    fn of(mut self, part: ValuePart) -> Self {
        self.part = Some(part);
        self
    }
}

/// The largest whole number: doubles represent every one up to 2^53, and round some beyond.
pub const MAX_WHOLE_NUMBER: u64 = 9_000_000_000_000_000;

impl Value {
    /// The type of the value, for messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Value::Text(_) => "a string",
            Value::Whole(_) => "a whole number",
            Value::Number(_) => "a number",
            Value::Flag(_) => "true or false",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }

    /// A number, also one written as a string such as "2^-1" or "pi/2".
    ///
    /// # Errors
    /// If it is something else, or is not accepted.
    pub fn number(&self, range: NumberRange) -> Result<f64, Refusal> {
        let value = match self {
            Value::Whole(number) => Some(*number as f64),
            Value::Number(number) => Some(*number),
            Value::Text(text) => number::parse(text),
            _ => None,
        };
        let Some(value) = value else {
            let remedy = "write a number, \"2^-3\" or \"pi/2\"";
            return Err(Refusal::beside(self, "a number", remedy));
        };
        match range.holds(value) {
            true => Ok(value),
            false => Err(Refusal::outside(value, range.expected().to_owned())),
        }
    }

    /// A whole number from `least` to `most`, also one written as a string such as "2^15".
    ///
    /// # Errors
    /// If it is something else.
    pub fn whole(&self, least: u64, most: u64) -> Result<u64, Refusal> {
        let value = match self {
            Value::Whole(value) => *value as f64,
            _ => self.number(NumberRange::Finite)?,
        };
        if value > most as f64 {
            Err(Refusal::outside(value, format!("at most {most}")))
        } else if value.fract() != 0.0 || value < least as f64 {
            let expected = format!("a whole number of at least {least}");
            Err(Refusal::outside(value, expected))
        } else {
            // Without rounding, if it is above 2^53.
            Ok(match self {
                Value::Whole(value) => *value,
                _ => value as u64,
            })
        }
    }

    /// A whole number from `least` to `most`, or `None` for "auto".
    ///
    /// # Errors
    /// If it is something else.
    pub fn whole_or_auto(&self, least: u64, most: u64) -> Result<Option<u64>, Refusal> {
        match self {
            Value::Text(text) if text == "auto" => Ok(None),
            Value::Text(text) if number::parse(text).is_none() => Err(Refusal::new(
                format!("is \"{text}\""),
                format!("write \"auto\" or a whole number of at least {least}"),
            )),
            _ => self.whole(least, most).map(Some),
        }
    }

    /// True or false.
    ///
    /// # Errors
    /// If it is something else.
    pub fn flag(&self) -> Result<bool, Refusal> {
        match self {
            Value::Flag(flag) => Ok(*flag),
            _ => {
                let remedy = "write true or false, without quotes";
                Err(Refusal::beside(self, "true or false", remedy))
            }
        }
    }

    /// A string.
    ///
    /// # Errors
    /// If it is something else.
    pub fn text(&self) -> Result<&str, Refusal> {
        match self {
            Value::Text(text) => Ok(text),
            _ => Err(Refusal::beside(self, "a string", "put it in quotes")),
        }
    }

    /// What `read` makes of each item of a list.
    ///
    /// # Errors
    /// If it is something else, or an item is refused.
    pub fn list<'a, T>(
        &'a self,
        read: impl Fn(&'a Value) -> Result<T, Refusal>,
    ) -> Result<Vec<T>, Refusal> {
        let Value::List(list) = self else {
            return Err(Refusal::beside(self, "a list", "write [1.0, 2.0]"));
        };
        (list.iter().enumerate())
            .map(|(k, item)| read(item).map_err(|refused| refused.of(ValuePart::Item(k))))
            .collect()
    }

    /// What `read` makes of the value of a key of a table; `None` if it is left out.
    ///
    /// # Errors
    /// If this is not a table, or the value is refused.
    pub fn key<T>(
        &self,
        name: &str,
        read: impl Fn(&Value) -> Result<T, Refusal>,
    ) -> Result<Option<T>, Refusal> {
        let Value::Table(table) = self else {
            return Err(Refusal::beside(self, "a table", "write { name = value }"));
        };
        (table.get(name))
            .map(|value| read(value).map_err(|refused| refused.of(ValuePart::Key(name.to_owned()))))
            .transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_read_from_json() {
        let text = r#"{"a": true, "b": 3, "c": -0.5, "d": "2^-3", "e": [1, 2.5]}"#;
        let value: Value = serde_json::from_str(text).unwrap();
        assert_eq!(value.key("a", Value::flag), Ok(Some(true)));
        assert_eq!(value.key("b", |of| of.whole(0, 9)), Ok(Some(3)));
        let number = |of: &Value| of.number(NumberRange::Finite);
        assert_eq!(value.key("c", number), Ok(Some(-0.5)));
        assert_eq!(value.key("d", number), Ok(Some(0.125)));
        assert_eq!(
            value.key("e", |of| of.list(number)),
            Ok(Some(vec![1.0, 2.5]))
        );
        assert_eq!(value.key("f", number), Ok(None));
    }

    #[test]
    fn what_is_refused_says_what_is_expected() {
        let refused = Value::Whole(0).whole(1, 9).unwrap_err();
        assert_eq!(refused.message, "is 0");
        assert_eq!(refused.remedy, "give a whole number of at least 1");
        let refused = Value::Whole(10).whole(1, 9).unwrap_err();
        assert_eq!(refused.remedy, "give at most 9");
        let refused = Value::Text("yes".into()).flag().unwrap_err();
        assert_eq!(refused.message, "is a string, not true or false");
        let list = Value::List(vec![Value::Number(1.0), Value::Number(f64::NAN)]);
        let refused = list
            .list(|item| item.number(NumberRange::Positive))
            .unwrap_err();
        assert_eq!(refused.message, "is NaN");
        assert_eq!(refused.part, Some(ValuePart::Item(1)));
    }

    #[test]
    fn large_seeds_are_not_rounded() {
        let seed = u64::MAX - 1;
        assert_eq!(Value::Whole(seed).whole(0, u64::MAX), Ok(seed));
    }
}
