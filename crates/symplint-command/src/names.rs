//! What a command may name files by.

use std::ffi::OsStr;
use std::path::Path;

/// Programs whose argument after `-c` is a script.
const SHELLS: [&str; 5] = ["sh", "bash", "dash", "ksh", "zsh"];

/// The arguments of a command before its first `{before}`, what they say after `=`, and the words of scripts of shells, but for those
/// that the script writes to by `>`. Those that are other ones in each call are left out.
pub fn names<'a>(command: &'a [String]) -> Vec<&'a str> {
    let mut words = Vec::new();
    for (place, word) in command.iter().enumerate().skip(1) {
        let (text, is_last) = match word.split_once("{before}") {
            Some((text, _)) => (text, true),
            None => (&**word, false),
        };
        if is_script(command, place) {
            let mut written = false;
            for word in text.split_whitespace() {
                if !written {
                    // Before `>` the number of a stream may stand.
                    let is_read = |c: char| !word.contains('>') || !c.is_ascii_digit();
                    let read = word.split('>').next().unwrap_or_default();
                    let read = read.trim_matches(|c| "\"'`;&|$()<".contains(c));
                    words.extend(read.contains(is_read).then_some(read));
                }
                written = word.ends_with('>') || word.ends_with(">|");
            }
        } else if !is_last {
            words.push(text);
        }
        if is_last {
            break;
        }
    }
    let value = |word: &'a str| Some(word.split_once('=')?.1);
    let names = (words.into_iter()).flat_map(|word| [Some(word), value(word)]);
    let varies = |name: &str| name.contains("{after}") || name.contains("{h}");
    names.flatten().filter(|name| !varies(name)).collect()
}

/// Whether an argument follows `-c`, `-ec` or the like of a shell, and no script in a file before.
fn is_script(command: &[String], place: usize) -> bool {
    let option = &command[place - 1];
    let is_shell = |word: &String| {
        let name = Path::new(word).file_name().and_then(OsStr::to_str);
        name.is_some_and(|name| SHELLS.contains(&name))
    };
    option.starts_with('-')
        && !option.starts_with("--")
        && option.ends_with('c')
        && (command[..place].iter().rev())
            .find(|word| !word.starts_with('-'))
            .is_some_and(is_shell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_by_words_values_of_options_and_words_of_scripts() {
        for (command, expected) in [
            (
                &["prog", "a", "--k=b", "{h}", "-i{before}", "c"][..],
                &["a", "--k=b", "b"][..],
            ),
            (
                &[
                    "/bin/sh",
                    "-ec",
                    "./a <'b' >c; d=e {after} 2> f $(cat g) {before} h",
                ],
                &["-ec", "./a", "b", "d=e", "e", "cat", "g"],
            ),
            (
                &["env", "bash", "-c", "a b", "{before}"],
                &["bash", "-c", "a", "b"],
            ),
            (&["python3", "-c", "a b", "{before}"], &["-c", "a b"]),
            (&["sh", "a", "-c", "b c"], &["a", "-c", "b c"]),
            (&["sh", "-c", "./a>b >| c"], &["-c", "./a"]),
            (&["prog", "--in={before}", "a"], &[]),
        ] {
            let command: Vec<String> = command.iter().map(|word| (*word).to_owned()).collect();
            assert_eq!(names(&command), expected, "{command:?}");
        }
    }
}
