//! The first difference of two runs.

use serde_json::{Map, Value};

/// The first difference of two descriptions, in words.
pub fn difference(path: &str, there: &Value, here: &Value) -> Option<String> {
    let join = |key: &str| match (path.is_empty(), is_bare(key)) {
        (true, _) => key.to_owned(),
        (false, true) => format!("{path}.{key}"),
        (false, false) => format!("{path}.{key:?}"),
    };
    match (there, here) {
        (Value::Object(of_there), Value::Object(of_here)) => {
            let lacks = |object: &Map<String, Value>, key: &String| !object.contains_key(key);
            let of_both = of_there.keys().chain(of_here.keys());
            of_both.into_iter().find_map(|key| match join(key) {
                path if lacks(of_here, key) => {
                    Some(format!("it has {path}, and this run does not"))
                }
                path if lacks(of_there, key) => {
                    Some(format!("this run has {path}, and it does not"))
                }
                path => difference(&path, &of_there[key], &of_here[key]),
            })
        }
        _ if same(there, here) => None,
        _ => Some(format!(
            "{path} is {} there and {} here",
            short(there),
            short(here)
        )),
    }
}

/// Whether two values are the same, numbers by their bits: 0 is 0.0, and -0.0 is another number.
fn same(there: &Value, here: &Value) -> bool {
    let bits = |value: &Value| value.as_f64().map(f64::to_bits);
    match (there, here) {
        (Value::Number(_), Value::Number(_)) => bits(there) == bits(here),
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(a, b)| same(a, b))
        }
        _ => there == here,
    }
}

/// Whether a key stands without quotation marks in TOML.
fn is_bare(key: &str) -> bool {
    let is_bare = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
    !key.is_empty() && key.bytes().all(is_bare)
}

/// A value in a few characters.
fn short(value: &Value) -> String {
    const MAX_LENGTH: usize = 60;
    let text = value.to_string();
    match text.char_indices().nth(MAX_LENGTH) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_first_difference_is_named() {
        let there = json!({"a": 1, "b": {"c": [1, 2], "d": "x"}});
        for (here, found) in [
            (json!({"a": 1.0, "b": {"c": [1, 2], "d": "x"}}), None),
            (
                json!({"a": 1, "b": {"c": [1, 3], "d": "x"}}),
                Some("b.c is [1,2] there and [1,3] here"),
            ),
            (
                json!({"a": 1, "b": {"c": [1, 2], "d": "x"}, "e": 2}),
                Some("this run has e, and it does not"),
            ),
            (json!({"a": 1}), Some("it has b, and this run does not")),
        ] {
            assert_eq!(difference("", &there, &here).as_deref(), found);
        }
        assert!(difference("", &json!(0.0), &json!(-0.0)).is_some());
        let [there, here] = [1, 2].map(|hash| json!({"program": {"./step.sh": hash}}));
        assert_eq!(
            difference("", &there, &here).unwrap(),
            "program.\"./step.sh\" is 1 there and 2 here"
        );
    }
}
