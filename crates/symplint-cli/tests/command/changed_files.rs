//! Files of the program that change, before a run goes on or meanwhile.

use std::fs;
use std::process::Command;

use super::resume::{calls, report};
use super::{in_one_line, said};
#[cfg(unix)]
#[test]
fn a_program_of_path_that_was_changed_is_named() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("bin")).unwrap();
    let program = path("bin").join("some-step");
    let text = "[system]\nname = \"command\"\ncommand = [\"some-step\", \"{before}\", \"{after}\"]\n\
                q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n";
    fs::write(path("run.toml"), text).unwrap();
    let check = |comment: &str| {
        fs::write(
            &program,
            format!("#!/bin/sh\ncp \"$1\" \"$2\" # {comment}\n"),
        )
        .unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let places = format!(
            "{}:{}",
            path("bin").display(),
            std::env::var("PATH").unwrap()
        );
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command.arg("check").arg(path("run.toml")).arg("--quiet");
        command.arg("--out").arg(path("run")).env("PATH", places);
        command.output().unwrap()
    };
    assert_eq!(check("as it was").status.code(), Some(3));
    assert_eq!(check("as it was").status.code(), Some(3));
    let output = check("as it is");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        in_one_line(&output).contains("program.some-step"),
        "{}",
        said(&output)
    );
}

#[test]
fn a_program_that_was_changed_is_named() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let script = |comment: &str| {
        fs::write(path("step.sh"), format!("cp \"$1\" \"$2\" # {comment}\n")).unwrap();
    };
    let text = "[system]\nname = \"command\"\ncommand = [\"sh\", \"step.sh\", \"{before}\", \"{after}\"]\n\
                q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n";
    fs::write(path("run.toml"), text).unwrap();
    let check = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command
            .arg("check")
            .arg(path("run.toml"))
            .arg("--quiet")
            .arg("--out")
            .arg(path("run"));
        command.args(arguments).output().unwrap()
    };
    script("as it was");
    // It moves nothing.
    assert_eq!(check(&[]).status.code(), Some(3));
    script("and as it is");
    let output = check(&[]);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("program.\"step.sh\""), "{text}");
    assert_eq!(check(&["--force"]).status.code(), Some(3));
}

#[test]
fn a_changed_file_after_the_step_size_in_the_command_is_named() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let text = "[system]\nname = \"command\"\n\
                command = [\"sh\", \"step.sh\", \"{h}\", \"params.txt\", \"{before}\", \"{after}\", \"notes.txt\"]\n\
                q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n";
    fs::write(path("run.toml"), text).unwrap();
    fs::write(path("step.sh"), "cp \"$3\" \"$4\"\n").unwrap();
    let check = |file: &str, text: &str| {
        fs::write(path(file), text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command.arg("check").arg(path("run.toml")).arg("--quiet");
        command.arg("--out").arg(path("run")).output().unwrap()
    };
    // It moves nothing.
    assert_eq!(check("params.txt", "1").status.code(), Some(3));
    let output = check("params.txt", "2");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let text = in_one_line(&output);
    assert!(text.contains("program.\"params.txt\""), "{text}");
    assert_eq!(check("params.txt", "1").status.code(), Some(3));
    // Files that are named after {before} may be those that calls write.
    assert_eq!(check("notes.txt", "3").status.code(), Some(3));
}

#[cfg(unix)]
#[test]
fn changed_files_in_options_and_scripts_are_named() {
    for (k, command) in [
        "[\"sh\", \"step.sh\", \"--k=params.txt\", \"{before}\", \"{after}\"]",
        "[\"sh\", \"-c\", \"sh step.sh --k=params.txt {before} {after}\"]",
        "[\"sh\", \"-c\", 'read k <params.txt; cp \"$0\" \"$1\"', \"{before}\", \"{after}\"]",
    ]
    .into_iter()
    .enumerate()
    {
        let folder = tempfile::TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        let text = format!(
            "[system]\nname = \"command\"\ncommand = {command}\n\
             q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n"
        );
        fs::write(path("run.toml"), text).unwrap();
        fs::write(path("step.sh"), "cp \"$2\" \"$3\"\n").unwrap();
        let check = |parameter: &str| {
            fs::write(path("params.txt"), parameter).unwrap();
            let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
            command.arg("check").arg(path("run.toml")).arg("--quiet");
            command.arg("--out").arg(path("run")).output().unwrap()
        };
        // It moves nothing.
        let output = check("1\n");
        assert_eq!(output.status.code(), Some(3), "{k}: {}", said(&output));
        let output = check("2\n");
        let text = in_one_line(&output);
        assert_eq!(output.status.code(), Some(2), "{k}: {text}");
        assert!(text.contains("program.\"params.txt\""), "{k}: {text}");
    }
}

#[test]
fn a_program_that_changes_while_a_run_goes_on_ends_it() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let text = "[system]\nname = \"command\"\n\
                command = [\"sh\", \"step.sh\", \"{before}\", \"{after}\"]\nworkers = 1\nbatch = 4\n\
                q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n";
    fs::write(path("run.toml"), text).unwrap();
    // While the second call is made, another program is put in its place.
    let script = "cp \"$1\" \"$2\"\necho call >>calls\n\
                  if [ $(wc -l <calls) = 2 ]; then echo 'exit 1' >new; mv new step.sh; fi\n";
    fs::write(path("step.sh"), script).unwrap();
    let symplint = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command
            .current_dir(folder.path())
            .args(words)
            .arg("--quiet");
        command.output().unwrap()
    };
    let ends = |words: &[&str]| {
        let output = symplint(words);
        let text = in_one_line(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(
            text.contains("step.sh changed while the run went on"),
            "{text}"
        );
    };
    ends(&["check", "run.toml", "--out", "run"]);
    assert_eq!(calls(&path("calls")), 2);
    let output = symplint(&["resume", "run"]);
    assert!(
        in_one_line(&output).contains("program.\"step.sh\""),
        "{}",
        said(&output)
    );
    fs::write(path("step.sh"), script).unwrap();
    let output = symplint(&["resume", "run"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    // The second call was not noted, and the first was.
    let made = calls(&path("calls"));
    let output = symplint(&["check", "run.toml", "--out", "whole"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert_eq!(calls(&path("calls")) - made, made - 1);
    assert_eq!(report(&path("run")), report(&path("whole")));

    // Likewise a job.
    let planned = symplint(&["plan", "run.toml", "--out", "jobs"]);
    assert_eq!(planned.status.code(), Some(4), "{}", said(&planned));
    fs::write(path("calls"), "call\n").unwrap();
    ends(&["advance", "jobs", "--part", "1/1"]);
    fs::write(path("step.sh"), script).unwrap();
    let collected = symplint(&["collect", "jobs"]);
    assert_eq!(collected.status.code(), Some(4), "{}", said(&collected));
    assert!(!path("jobs").join("failed.json").exists());
}

#[test]
fn a_file_that_the_first_call_makes_ends_the_run_before_anything_is_noted() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    let check = |files: &str, out: &str| {
        let text = format!(
            "[system]\nname = \"command\"\ncommand = [\"sh\", \"step.sh\", {files}]\nworkers = 1\n\
             q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n"
        );
        fs::write(path("run.toml"), text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
        command.arg("check").arg(path("run.toml")).arg("--quiet");
        command.arg("--out").arg(path(out)).output().unwrap()
    };
    fs::write(path("step.sh"), "cp \"$2\" \"$3\"\necho call >>\"$1\"\n").unwrap();
    let output = check("\"run.log\", \"{before}\", \"{after}\"", "run");
    let text = in_one_line(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("run.log changed while the run went on (or was made"),
        "{text}"
    );
    assert!(text.contains("are named after {before}"), "{text}");
    assert_eq!(calls(&path("run.log")), 1);
    // As the message says.
    fs::remove_file(path("run.log")).unwrap();
    fs::write(path("step.sh"), "cp \"$1\" \"$2\"\necho call >>\"$3\"\n").unwrap();
    for attempt in 0..2 {
        let output = check("\"{before}\", \"{after}\", \"run.log\"", "other");
        assert_eq!(
            output.status.code(),
            Some(3),
            "{attempt}: {}",
            said(&output)
        );
    }
}

/// Runs `sh step.sh` with these words, its errors into a file.
#[cfg(unix)]
fn check_script(folder: &std::path::Path, words: &str, out: &str) -> (Option<i32>, String) {
    let text = format!(
        "[system]\nname = \"command\"\ncommand = [\"sh\", \"step.sh\", {words}]\nworkers = 1\n\
         q0 = [1.0]\np0 = [0.5]\n[diagnostic]\nstep_sizes = [0.5]\nbudget = 200\n"
    );
    fs::write(folder.join("run.toml"), text).unwrap();
    let log = fs::File::options()
        .create(true)
        .append(true)
        .open(folder.join("log"))
        .unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_symplint"));
    command.arg("check").arg(folder.join("run.toml"));
    command.args(["--quiet", "--out"]).arg(folder.join(out));
    let status = command.stderr(log).status().unwrap();
    let text = fs::read_to_string(folder.join("log")).unwrap();
    (status.code(), text)
}

#[cfg(target_os = "linux")]
#[test]
fn streams_of_this_process_are_no_files_of_the_program() {
    let folder = tempfile::TempDir::new().unwrap();
    fs::write(folder.path().join("step.sh"), "cp \"$2\" \"$3\"\n").unwrap();
    for _ in 0..2 {
        let words = "\"/dev/stderr\", \"{before}\", \"{after}\"";
        let (status, text) = check_script(folder.path(), words, "run");
        assert_eq!(status, Some(3), "{text}");
        let mut log = fs::File::options()
            .append(true)
            .open(folder.path().join("log"))
            .unwrap();
        std::io::Write::write_all(&mut log, b"more of a job\n").unwrap();
    }
}

#[cfg(unix)]
#[test]
fn after_a_file_that_the_first_call_made_the_same_command_goes_on() {
    let folder = tempfile::TempDir::new().unwrap();
    let script = "touch \"$1\"\ncp \"$2\" \"$3\"\n";
    fs::write(folder.path().join("step.sh"), script).unwrap();
    let words = "\"lock\", \"{before}\", \"{after}\"";
    let check = || check_script(folder.path(), words, "run");
    let (status, text) = check();
    assert_eq!(status, Some(2), "{text}");
    assert!(text.contains("was made"), "{text}");
    let (status, text) = check();
    assert_eq!(status, Some(3), "{text}");
}
