//! Commands that a message asks the user to run.

use std::path::Path;

/// `symplint COMMAND FOLDER`, with quotation marks where a shell would take the name of the folder for something else.
pub fn go_on(command: &str, folder: &Path) -> String {
    let mut name = folder.display().to_string();
    if name.starts_with('-') {
        name.insert_str(0, "./");
    }
    let is_plain = |c: char| c.is_alphanumeric() || "_-./+,:@%=".contains(c);
    match !name.is_empty() && name.chars().all(is_plain) {
        true => format!("symplint {command} {name}"),
        false => format!("symplint {command} '{}'", name.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_one_word_of_a_shell() {
        assert_eq!(
            go_on("resume", Path::new("run/α-2.5")),
            "symplint resume run/α-2.5"
        );
        for (name, word) in [
            ("my run", "'my run'"),
            ("it's", r"'it'\''s'"),
            ("$HOME", "'$HOME'"),
            ("-j", "./-j"),
        ] {
            assert_eq!(
                go_on("resume", Path::new(name)),
                format!("symplint resume {word}")
            );
        }
    }
}
