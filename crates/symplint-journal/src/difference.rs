//! What two runs differ in.

use serde_json::Value;

/// The first difference of two descriptions, in words.
pub fn difference(path: &str, there: &Value, here: &Value) -> Option<String> {
    let join = |key: &str| match (path.is_empty(), is_bare(key)) {
        (true, _) => key.to_owned(),
        (false, true) => format!("{path}.{key}"),
        (false, false) => format!("{path}.{key:?}"),
    };
    match (there, here) {
        (Value::Object(of_there), Value::Object(of_here)) => {
            let of_both = of_there.keys().chain(of_here.keys());
            of_both.into_iter().find_map(|key| {
                let of = |object: &serde_json::Map<String, Value>| {
                    object.get(key).cloned().unwrap_or(Value::Null)
                };
                difference(&join(key), &of(of_there), &of(of_here))
            })
        }
        _ if there == here => None,
        _ => Some(format!(
            "{path} is {} there and {} here",
            short(there),
            short(here)
        )),
    }
}

/// Whether a key stands without quotation marks in TOML.
fn is_bare(key: &str) -> bool {
    let is_bare = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
    !key.is_empty() && key.bytes().all(is_bare)
}

/// A value in a few characters.
fn short(value: &Value) -> String {
    const LONGEST: usize = 60;
    let text = value.to_string();
    match text.char_indices().nth(LONGEST) {
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
        assert_eq!(difference("", &there, &there), None);
        let here = json!({"a": 1, "b": {"c": [1, 3], "d": "x"}});
        assert_eq!(
            difference("", &there, &here).unwrap(),
            "b.c is [1,2] there and [1,3] here"
        );
        let here = json!({"a": 1, "b": {"c": [1, 2], "d": "x"}, "e": 2});
        assert_eq!(
            difference("", &there, &here).unwrap(),
            "e is null there and 2 here"
        );
        let [there, here] = [1, 2].map(|hash| json!({"program": {"./step.sh": hash}}));
        assert_eq!(
            difference("", &there, &here).unwrap(),
            "program.\"./step.sh\" is 1 there and 2 here"
        );
    }
}
