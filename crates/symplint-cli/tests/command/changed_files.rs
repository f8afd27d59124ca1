//! Files of the program that change, before a run resumes or meanwhile.

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use tempfile::TempDir;

use super::resume::{calls, report};
use super::{ends, refused, symplint};

/// A folder with a configuration.
struct Folder(TempDir);

impl Folder {
    fn new(keys: &str) -> Self {
        let folder = Folder(TempDir::new().unwrap());
        let text = format!(
            "[system]\nname = \"command\"\n{keys}\nq0 = [1.0]\np0 = [0.5]\n\
             [diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n"
        );
        fs::write(folder.path("run.toml"), text).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn symplint(&self, words: &[&str]) -> Output {
        let mut command = symplint(words);
        let places = std::env::var("PATH").unwrap();
        command.env("PATH", format!("{}:{places}", self.0.path().display()));
        let command = command.current_dir(self.0.path()).arg("--quiet");
        command.output().unwrap()
    }
}

#[cfg(unix)]
#[test]
fn a_program_of_path_that_was_changed_is_named() {
    use std::os::unix::fs::PermissionsExt;

    let folder = Folder::new("command = [\"some-step\", \"{before}\", \"{after}\"]");
    let program = folder.path("some-step");
    let check = |comment: &str| {
        let text = format!("#!/bin/sh\ncp \"$1\" \"$2\" # {comment}\n");
        fs::write(&program, text).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        folder.symplint(&["check", "run.toml", "--out", "run"])
    };
    // It moves nothing.
    ends(3, &check("as it was"));
    ends(3, &check("as it was"));
    refused(&check("as it is"), "program.some-step");
}

#[test]
fn a_changed_file_that_identifies_the_program_is_named() {
    let command = "command = [\"sh\", \"step.sh\", \"{before}\", \"{after}\"]";
    let folder = Folder::new(&format!("{command}\nfiles = [\"step.sh\"]"));
    let check = |comment: &str, arguments: &[&str]| {
        let text = format!("cp \"$1\" \"$2\" # {comment}\n");
        fs::write(folder.path("step.sh"), text).unwrap();
        folder.symplint(&[&["check", "run.toml", "--out", "run"], arguments].concat())
    };
    ends(3, &check("as it was", &[]));
    refused(&check("as it is", &[]), "program.\"step.sh\"");
    ends(3, &check("as it was", &[]));
    ends(3, &check("as it is", &["--force"]));
    let other = check("", &["--set", "system.files=[\"table\"]", "--force"]);
    refused(&other, "system.files identify a run");
}

#[test]
fn a_program_that_changes_while_a_run_is_under_way_ends_it() {
    let command = "command = [\"sh\", \"step.sh\", \"{before}\", \"{after}\"]";
    let keys = "files = [\"step.sh\"]\nworkers = 1\nbatch = 4";
    let folder = Folder::new(&format!("{command}\n{keys}"));
    // While the second call is made, another program is put in its place.
    let script = "cp \"$1\" \"$2\"\necho call >>calls\n\
                  if [ $(wc -l <calls) = 2 ]; then echo 'exit 1' >new; mv new step.sh; fi\n";
    let restore = || fs::write(folder.path("step.sh"), script).unwrap();
    let changed = "step.sh changed while the run was under way";
    restore();
    refused(
        &folder.symplint(&["check", "run.toml", "--out", "run"]),
        changed,
    );
    assert_eq!(calls(&folder.path("calls")), 2);
    let resume = || folder.symplint(&["resume", "run"]);
    refused(&resume(), "program.\"step.sh\"");
    restore();
    ends(3, &resume());
    // The second call was not noted, and the first was.
    let made = calls(&folder.path("calls"));
    ends(
        3,
        &folder.symplint(&["check", "run.toml", "--out", "whole"]),
    );
    assert_eq!(calls(&folder.path("calls")) - made, made - 1);
    assert_eq!(report(&folder.path("run")), report(&folder.path("whole")));

    // Likewise a job.
    ends(4, &folder.symplint(&["plan", "run.toml", "--out", "jobs"]));
    fs::write(folder.path("calls"), "call\n").unwrap();
    let advanced = folder.symplint(&["advance", "jobs", "--part", "1/1"]);
    refused(&advanced, changed);
    restore();
    ends(4, &folder.symplint(&["collect", "jobs"]));
    assert!(!folder.path("jobs").join("failed.json").exists());
}
