//! Settings of an item: what can be set, within which bounds, and what was set.

/// One setting of an item.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// The accepted values, with the default.
    pub kind: Kind,
    /// Its description in one line.
    pub help: &'static str,
}

/// The values that a setting accepts.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A finite number.
    Number {
        /// Unless it is set.
        default: f64,
    },
    /// A number above 0.
    Positive {
        /// Unless it is set.
        default: f64,
    },
    /// A whole number.
    Whole {
        /// Unless it is set.
        default: u64,
        /// The smallest.
        least: u64,
        /// The largest.
        most: u64,
    },
    /// One of some words, the first unless it is set.
    Choice {
        /// The words.
        words: &'static [&'static str],
    },
}

/// Doubles represent every whole number up to 2^53, and round some beyond.
const MAX_WHOLE: u64 = 9_000_000_000_000_000;

impl Key {
    /// A setting that takes a finite number.
    pub const fn number(name: &'static str, default: f64, help: &'static str) -> Self {
        let kind = Kind::Number { default };
        Key { name, kind, help }
    }

    /// A setting that takes a number above 0.
    pub const fn positive(name: &'static str, default: f64, help: &'static str) -> Self {
        let kind = Kind::Positive { default };
        Key { name, kind, help }
    }

    /// A setting that takes a whole number of at least `least`.
    pub const fn whole(name: &'static str, default: u64, least: u64, help: &'static str) -> Self {
        Key::whole_between(name, default, (least, MAX_WHOLE), help)
    }

    /// A setting that takes a whole number from `least` to `most`.
    pub const fn whole_between(
        name: &'static str,
        default: u64,
        (least, most): (u64, u64),
        help: &'static str,
    ) -> Self {
        let kind = Kind::Whole {
            default,
            least,
            most,
        };
        Key { name, kind, help }
    }

    /// A setting that takes one of some words, the first by default.
    pub const fn choice(
        name: &'static str,
        words: &'static [&'static str],
        help: &'static str,
    ) -> Self {
        let kind = Kind::Choice { words };
        Key { name, kind, help }
    }

    fn default(&self) -> Value {
        match self.kind {
            Kind::Number { default } | Kind::Positive { default } => Value::Number(default),
            Kind::Whole { default, .. } => Value::Number(default as f64),
            Kind::Choice { words } => Value::Word(words[0].to_owned()),
        }
    }

    /// Checks a value.
    fn check(&self, value: &Value) -> Result<(), SettingError> {
        let expected = match (self.kind, value) {
            (Kind::Choice { words }, Value::Word(word)) => {
                return match words.contains(&word.as_str()) {
                    true => Ok(()),
                    false => Err(SettingError::Word {
                        key: self.name,
                        given: word.clone(),
                        words,
                    }),
                };
            }
            (Kind::Choice { .. }, Value::Number(_)) => "a word".to_owned(),
            (_, Value::Word(_)) => "a number".to_owned(),
            (Kind::Number { .. }, Value::Number(number)) if number.is_finite() => return Ok(()),
            (Kind::Number { .. }, _) => "a finite number".to_owned(),
            (Kind::Positive { .. }, Value::Number(number))
                if number.is_finite() && *number > 0.0 =>
            {
                return Ok(());
            }
            (Kind::Positive { .. }, _) => "a number above 0".to_owned(),
            (Kind::Whole { least, most, .. }, Value::Number(number)) => {
                if number.fract() != 0.0 || *number < least as f64 {
                    format!("a whole number of at least {least}")
                } else if *number > most as f64 {
                    return Err(SettingError::TooMany {
                        key: self.name,
                        value: *number,
                        most,
                    });
                } else {
                    return Ok(());
                }
            }
        };
        Err(SettingError::Value {
            key: self.name,
            value: value.to_string(),
            expected,
        })
    }
}

/// The value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number, whole or not.
    Number(f64),
    /// A word.
    Word(String),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            // Not hundreds of zeros.
            Value::Number(number) if number.abs() > MAX_WHOLE as f64 => write!(f, "{number:e}"),
            Value::Number(number) => write!(f, "{number}"),
            Value::Word(word) => write!(f, "\"{word}\""),
        }
    }
}

/// Why a setting is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// The item has no such setting.
    #[error("{key} is not a setting")]
    Unknown {
        /// The given value.
        key: String,
        /// The settings that there are.
        known: Vec<&'static str>,
    },
    /// A value of another kind, or out of range.
    #[error("{key} is {value}")]
    Value {
        /// The setting.
        key: &'static str,
        /// The given value.
        value: String,
        /// The accepted values.
        expected: String,
    },
    /// A number that would take too much time or memory.
    #[error("{key}: {} is too many", Value::Number(*value))]
    TooMany {
        /// The setting.
        key: &'static str,
        /// The given value.
        value: f64,
        /// The largest that it takes.
        most: u64,
    },
    /// A word that is not one of those that the setting takes.
    #[error("{key}: there is no \"{given}\"")]
    Word {
        /// The setting.
        key: &'static str,
        /// The given value.
        given: String,
        /// The accepted values.
        words: &'static [&'static str],
    },
    /// Settings that together would not end, or hardly begin.
    #[error("{key}: {steps:.1e} steps of {step_size:e} are too many or too few")]
    Steps {
        /// The setting to change.
        key: &'static str,
        /// The number of steps.
        steps: f64,
        /// Their size.
        step_size: f64,
        /// What to do.
        remedy: String,
    },
}

/// Refuses a run of fewer or more steps than these: the setting `key`, which is `time`, or the step size has to be changed.
pub fn check_steps(
    (key, time): (&'static str, f64),
    step_size: f64,
    [fewest, most]: [f64; 2],
) -> Result<(), SettingError> {
    let steps = time / step_size;
    let remedy = match (steps < fewest, steps <= most) {
        (false, true) => return Ok(()),
        (true, _) => format!("give {key} = {:.4e} or more", fewest * step_size),
        (_, false) => format!("give {key} = {:.4e} or less", most * step_size),
    };
    Err(SettingError::Steps {
        key,
        steps,
        step_size,
        remedy,
    })
}

impl SettingError {
    /// The setting.
    pub fn key(&self) -> &str {
        match self {
            SettingError::Unknown { key, .. } => key,
            SettingError::Value { key, .. }
            | SettingError::TooMany { key, .. }
            | SettingError::Word { key, .. }
            | SettingError::Steps { key, .. } => key,
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            SettingError::Unknown { known, .. } => format!("there are: {}", known.join(", ")),
            SettingError::Value { expected, .. } => format!("give {expected}"),
            SettingError::TooMany { most, .. } => format!("give at most {most}"),
            SettingError::Word { words, .. } => format!("there are: {}", words.join(", ")),
            SettingError::Steps { remedy, .. } => remedy.clone(),
        }
    }
}

/// The settings of one item: its defaults, and what was set.
#[derive(Clone, Debug)]
pub struct Settings {
    keys: &'static [Key],
    values: Vec<Value>,
}

impl Settings {
    /// The defaults of `keys`.
    pub fn new(keys: &'static [Key]) -> Self {
        Settings {
            keys,
            values: keys.iter().map(Key::default).collect(),
        }
    }

    /// Sets one of them.
    ///
    /// # Errors
    /// If no setting has this name, or it does not take that value.
    pub fn set(&mut self, key: &str, value: Value) -> Result<(), SettingError> {
        let Some(index) = self.keys.iter().position(|known| known.name == key) else {
            return Err(SettingError::Unknown {
                key: key.to_owned(),
                known: self.keys.iter().map(|key| key.name).collect(),
            });
        };
        self.keys[index].check(&value)?;
        self.values[index] = value;
        Ok(())
    }

    /// All settings with their values.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        let names = self.keys.iter().map(|key| key.name);
        names.zip(&self.values)
    }

    fn value(&self, key: &str) -> &Value {
        let index = (self.keys.iter().position(|known| known.name == key))
            .unwrap_or_else(|| panic!("the item reads the unlisted setting {key}"));
        &self.values[index]
    }

    /// A number.
    pub(crate) fn number(&self, key: &str) -> f64 {
        match self.value(key) {
            Value::Number(number) => *number,
            Value::Word(_) => panic!("the setting {key} takes a word"),
        }
    }

    /// A whole number.
    pub(crate) fn whole(&self, key: &str) -> u64 {
        self.number(key) as u64
    }

    /// A whole number that counts something.
    pub(crate) fn count(&self, key: &str) -> usize {
        self.number(key) as usize
    }

    /// One of some words.
    pub(crate) fn choice(&self, key: &str) -> &str {
        match self.value(key) {
            Value::Word(word) => word,
            Value::Number(_) => panic!("the setting {key} takes a number"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: &[Key] = &[
        Key::number("p0", 0.0, "centre"),
        Key::positive("step_size", 0.1, "h"),
        Key::whole_between("halvings", 10, (2, 40), "step sizes"),
        Key::choice("rk2", &["heun", "midpoint"], "variant"),
    ];

    #[test]
    fn defaults_and_what_is_set() {
        let mut settings = Settings::new(KEYS);
        assert_eq!(settings.number("step_size"), 0.1);
        assert_eq!(settings.count("halvings"), 10);
        assert_eq!(settings.choice("rk2"), "heun");
        settings.set("p0", Value::Number(-1.5)).unwrap();
        settings.set("halvings", Value::Number(40.0)).unwrap();
        settings.set("rk2", Value::Word("midpoint".into())).unwrap();
        assert_eq!(settings.number("p0"), -1.5);
        assert_eq!(settings.count("halvings"), 40);
        assert_eq!(settings.choice("rk2"), "midpoint");
    }

    #[test]
    fn refused_values_say_what_would_do() {
        let number = Value::Number;
        let word = |word: &str| Value::Word(word.into());
        for (key, value, said, remedy) in [
            ("p0", number(f64::NAN), "p0 is NaN", "a finite number"),
            ("step_size", number(0.0), "step_size is 0", "above 0"),
            ("halvings", number(2.5), "halvings is 2.5", "at least 2"),
            ("halvings", number(1.0), "halvings is 1", "at least 2"),
            ("halvings", number(41.0), "41 is too many", "at most 40"),
            ("halvings", number(1e300), "1e300 is too many", "at most 40"),
            ("halvings", word("ten"), "halvings is \"ten\"", "a number"),
            ("rk2", word("ralston"), "no \"ralston\"", "heun, midpoint"),
            ("rk2", number(2.0), "rk2 is 2", "a word"),
            ("steps", number(2.0), "steps is not a setting", "rk2"),
        ] {
            let error = Settings::new(KEYS).set(key, value).unwrap_err();
            assert_eq!(error.key(), key);
            assert!(error.to_string().contains(said), "{error}");
            assert!(error.remedy().contains(remedy), "{}", error.remedy());
        }
    }
}
