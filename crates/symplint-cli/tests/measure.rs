//! `symplint loop` and `symplint measure`: loops that go to another code and come back.

use std::f64::consts::TAU;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::process::Output;
use std::time::Duration;

use assert_cmd::Command;
use serde_json::Value;
use symplint_files::LoopFile;
use symplint_models::discrete::StandardMap;
use tempfile::TempDir;

fn symplint(folder: &Path, arguments: &[&str]) -> Output {
    Command::cargo_bin("symplint")
        .unwrap()
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn status(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = symplint(folder, &[&["measure"], arguments, &["--json"]].concat());
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("nothing but JSON on standard output")
}

/// Runs `measure`, which must refuse: what it says.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = symplint(folder, &[&["measure"], arguments].concat());
    assert_eq!(
        status(&output),
        2,
        "{arguments:?}: {}",
        text(&output.stdout)
    );
    // Without the line breaks that fit it to a terminal.
    let said = text(&output.stderr).replace('│', " ");
    said.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn example(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    root.join(name).to_str().unwrap().to_owned()
}

/// The other code: one state of the pendulum of examples/pendulum.toml.
type Step = fn(f64, f64, f64) -> (f64, f64);

fn leapfrog(h: f64, q: f64, p: f64) -> (f64, f64) {
    let half = q + 0.5 * h * p;
    let kicked = p + h * half.sin();
    (half + 0.5 * h * kicked, kicked)
}

fn midpoint(h: f64, q: f64, p: f64) -> (f64, f64) {
    let (q_half, p_half) = (q + 0.5 * h * p, p + 0.5 * h * q.sin());
    (q + h * p_half, p + h * q_half.sin())
}

/// Bytes of an array as numpy.save writes it.
fn npy(descr: &str, fortran: bool, shape: &str, values: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values);
    bytes
}

fn doubles(values: &[f64]) -> Vec<u8> {
    let shape = format!("({}, 1)", values.len());
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    npy("<f8", false, &shape, &bytes)
}

fn npz(path: &Path, deflated: bool, arrays: &[(&str, Vec<u8>)]) {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let method = if deflated {
        zip::CompressionMethod::Deflated
    } else {
        zip::CompressionMethod::Stored
    };
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(bytes).unwrap();
    }
    fs::write(path, archive.finish().unwrap().into_inner()).unwrap();
}

/// The columns q and p of a table that `symplint loop` wrote.
fn columns(path: &Path) -> (Vec<f64>, Vec<f64>) {
    let table = fs::read_to_string(path).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("q_0,p_0"));
    lines
        .map(|line| {
            let (q, p) = line.split_once(',').unwrap();
            (q.parse::<f64>().unwrap(), p.parse::<f64>().unwrap())
        })
        .unzip()
}

/// A folder with `before.csv`, `before.npz`, and what the other code makes of it.
struct Exchange {
    folder: TempDir,
    q: Vec<f64>,
    p: Vec<f64>,
}

impl Exchange {
    fn new(samples: &str) -> Self {
        let folder = TempDir::new().unwrap();
        for output in ["before.csv", "before.npz", "before.npy"] {
            let arguments = [
                "loop",
                &example("pendulum.toml"),
                "--samples",
                samples,
                "--output",
                output,
            ];
            assert_eq!(status(&symplint(folder.path(), &arguments)), 0);
        }
        let (q, p) = columns(&folder.path().join("before.csv"));
        Exchange { folder, q, p }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn advanced(&self, step: Step, h: f64) -> (Vec<f64>, Vec<f64>) {
        self.q
            .iter()
            .zip(&self.p)
            .map(|(&q, &p)| step(h, q, p))
            .unzip()
    }

    /// Writes the advanced loop with its step size.
    fn write_npz(&self, name: &str, step: Step, h: f64) {
        let (q, p) = self.advanced(step, h);
        let of_step = npy("<f8", false, "()", &h.to_le_bytes());
        let arrays = [("q", doubles(&q)), ("p", doubles(&p)), ("h", of_step)];
        npz(&self.path().join(name), false, &arrays);
    }
}

#[test]
fn a_round_trip_gives_the_verdict_of_check() {
    let exchange = Exchange::new("256");
    let names = ["1.npz", "2.npz", "3.npz", "4.npz", "5.npz"];
    for (integrator, step, expected) in [("strang", leapfrog as Step, 0), ("rk2", midpoint, 1)] {
        for (m, name) in (1..).zip(names) {
            exchange.write_npz(name, step, 0.5f64.powi(m));
        }
        let arguments = [&["before.npz"][..], &names].concat();
        let measured = symplint(exchange.path(), &[&["measure"], &arguments[..]].concat());
        assert_eq!(status(&measured), expected, "{}", text(&measured.stderr));
        let measured = report(exchange.path(), &arguments);
        let set = format!("integrator.name={integrator}");
        let checked = symplint(
            exchange.path(),
            &["check", &example("pendulum.toml"), "--set", &set, "--json"],
        );
        let checked: Value = serde_json::from_slice(&checked.stdout).unwrap();
        for field in ["kind", "order"] {
            assert_eq!(
                measured["verdict"][field], checked["verdict"][field],
                "{integrator}"
            );
        }
        // The same loop, the same steps: the same defects, beyond what the samples leave open.
        let defect = |report: &Value| report["points"][0]["signed_defect"].as_f64().unwrap();
        assert!((defect(&measured) - defect(&checked)).abs() < 1e-14);
        assert_eq!(measured["schema"], "symplint/report/3");
        assert_eq!(measured["config"]["measure"]["before"], "before.npz");
        assert_eq!(measured["points"][2]["step_size"], 0.125);
    }
}

#[test]
fn every_format_gives_the_same_numbers() {
    let exchange = Exchange::new("64");
    let (q, p) = exchange.advanced(midpoint, 0.5);
    let folder = exchange.path();
    fs::write(folder.join("after_q.npy"), doubles(&q)).unwrap();
    fs::write(folder.join("after_p.npy"), doubles(&p)).unwrap();
    let swapped: Vec<String> = q
        .iter()
        .zip(&p)
        .map(|(q, p)| format!("{p:?}, {q:?}\n"))
        .collect();
    fs::write(
        folder.join("after.csv"),
        format!("# one step\np_0, q_0\n{}", swapped.concat()),
    )
    .unwrap();
    let big = |values: &[f64]| -> Vec<u8> { values.iter().flat_map(|v| v.to_be_bytes()).collect() };
    let arrays = [
        ("q", npy(">f8", true, "(64, 1)", &big(&q))),
        ("p", npy(">f8", false, "(64,)", &big(&p))),
        ("h", npy("<i8", false, "(1,)", &1i64.to_le_bytes())),
    ];
    let flat = [
        ("q", npy(">f8", true, "(64,)", &big(&q))),
        arrays[1].clone(),
    ];
    npz(&folder.join("after.npz"), true, &flat);
    let point = |arguments: &[&str]| report(folder, arguments)["points"][0].clone();
    let expected = point(&["before.npz", "after.npz", "--h", "2^-1"]);
    assert!((expected["signed_defect"].as_f64().unwrap() - 1.686e-2).abs() < 1e-5);
    for arguments in [
        &["before.csv", "after.csv", "--h", "0.5"][..],
        &["before.npy", "after.npy", "--h", "0.5"],
        &[
            "before_q.npy",
            "before_p.npy",
            "after_q.npy",
            "after_p.npy",
            "--h=0.5",
        ],
        &["before.npz", "after_p.npy", "--h", "1/2"],
    ] {
        assert_eq!(point(arguments), expected, "{arguments:?}");
    }
    // An integer is a fine step size, and the command line goes before the file.
    npz(
        &folder.join("whole.npz"),
        true,
        &[flat[0].clone(), flat[1].clone(), arrays[2].clone()],
    );
    assert_eq!(point(&["before.npz", "whole.npz"])["step_size"], 1.0);
    assert_eq!(point(&["before.npz", "whole.npz", "--h", "0.5"]), expected);
    // Without a step size there is a verdict, and null in its place.
    let unknown = report(folder, &["before.npz", "after.npz"]);
    assert_eq!(unknown["points"][0]["step_size"], Value::Null);
    assert_eq!(unknown["verdict"]["kind"], "not-symplectic");
    // As an empty field in the table of points.
    let arguments = ["measure", "before.npz", "after.npz", "--out", "unknown"];
    assert_eq!(status(&symplint(folder, &arguments)), 1);
    let points = fs::read_to_string(folder.join("unknown/points.csv")).unwrap();
    let first = points.lines().nth(1).unwrap();
    assert!(first.starts_with("step-size,0,,64,"), "{points}");
}

/// Snapshots of a trace are loops of it, with their parameter, too.
#[test]
fn snapshots_of_a_trace_can_be_measured() {
    let folder = TempDir::new().unwrap();
    let arguments = [
        "trace",
        &example("pendulum.toml"),
        "--set=trace.steps=1",
        "--set=trace.step_size=0.5",
        "--set=trace.samples=256",
        "--set=trace.snapshots=[0, 1]",
        "--out=run",
    ];
    assert_eq!(status(&symplint(folder.path(), &arguments)), 0);
    let files = ["run/loop_0.csv", "run/loop_1.csv"];
    let table = fs::read_to_string(folder.path().join(files[1])).unwrap();
    assert!(table.starts_with("s,q_0,p_0\n"), "{table}");
    let new = report(folder.path(), &files);
    assert_eq!(new["verdict"]["kind"], "symplectic");
    // As they were named before.
    let before = table.replacen("s,q_0,p_0", "s,q0,p0", 1);
    fs::write(folder.path().join(files[1]), before).unwrap();
    assert_eq!(report(folder.path(), &files)["points"], new["points"]);
}

#[test]
fn arrays_in_column_order_are_read_in_theirs() {
    // Two degrees of freedom, stored column by column as numpy.asfortranarray does.
    let folder = TempDir::new().unwrap();
    let config = "[system]\nname = \"henon-heiles\"\n";
    fs::write(folder.path().join("run.toml"), config).unwrap();
    let made = symplint(
        folder.path(),
        &[
            "loop",
            "run.toml",
            "--output",
            "loop.csv",
            "--samples",
            "64",
        ],
    );
    assert_eq!(status(&made), 0, "{}", text(&made.stderr));
    let table = fs::read_to_string(folder.path().join("loop.csv")).unwrap();
    let rows: Vec<Vec<f64>> = (table.lines().skip(1))
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().unwrap())
                .collect()
        })
        .collect();
    // A shear of the second degree of freedom by the first.
    let after = |column: usize| -> Vec<f64> {
        (rows.iter())
            .map(|row| match column {
                2 => row[2] - 0.5 * row[1],
                3 => row[3] - 0.5 * row[0],
                other => row[other],
            })
            .collect()
    };
    let stored = |columns: [usize; 2]| {
        let values = columns.map(after).concat();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        npy("<f8", true, "(64, 2)", &bytes)
    };
    npz(
        &folder.path().join("after.npz"),
        true,
        &[("q", stored([0, 1])), ("p", stored([2, 3]))],
    );
    let report = report(folder.path(), &["loop.csv", "after.npz"]);
    assert_eq!(report["verdict"]["kind"], "symplectic", "{report}");
}

#[test]
fn single_precision_and_few_digits_have_their_floor() {
    let exchange = Exchange::new("256");
    let folder = exchange.path();
    let (q, p) = exchange.advanced(leapfrog, 0.5);
    let single = |values: &[f64]| {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|&v| (v as f32).to_le_bytes())
            .collect();
        npy("<f4", false, "(256, 1)", &bytes)
    };
    npz(
        &folder.join("single.npz"),
        false,
        &[("q", single(&q)), ("p", single(&p))],
    );
    let lines: Vec<String> = q
        .iter()
        .zip(&p)
        .map(|(q, p)| format!("{q:.6},{p:.6}\n"))
        .collect();
    fs::write(folder.join("digits.csv"), lines.concat()).unwrap();
    let of_single = report(folder, &["before.npz", "single.npz"]);
    assert_eq!(of_single["verdict"]["kind"], "symplectic");
    let digits = of_single["verdict"]["digits"].as_f64().unwrap();
    assert!((6.0..8.0).contains(&digits), "{digits}");
    assert!(of_single["points"][0]["roundoff"].as_f64().unwrap() > 1e-9);
    let of_digits = report(folder, &["before.npz", "digits.csv"]);
    assert_ne!(of_digits["verdict"]["kind"], "not-symplectic");
    assert!(of_digits["points"][0]["roundoff"].as_f64().unwrap() > 1e-8);
}

#[test]
fn periods_and_weights_come_from_files_or_options() {
    let exchange = Exchange::new("256");
    let folder = exchange.path();
    let wrap = |q: &[f64]| -> Vec<f64> { q.iter().map(|q| q.rem_euclid(2.5)).collect() };
    let (q, p) = exchange.advanced(leapfrog, 0.5);
    let period = npy("<f8", false, "(1,)", &2.5f64.to_le_bytes());
    let before = [
        ("q", doubles(&wrap(&exchange.q))),
        ("p", doubles(&exchange.p)),
    ];
    let after = [("q", doubles(&wrap(&q))), ("p", doubles(&p))];
    npz(&folder.join("b.npz"), false, &before);
    npz(&folder.join("a.npz"), false, &after);
    npz(
        &folder.join("stated.npz"),
        false,
        &[&after[..], &[("period", period)]].concat(),
    );
    let verdict = |arguments: &[&str]| report(folder, arguments)["verdict"].clone();
    assert_eq!(
        verdict(&["b.npz", "a.npz", "--period", "2.5"])["kind"],
        "symplectic"
    );
    assert_eq!(verdict(&["b.npz", "stated.npz"])["kind"], "symplectic");
    let without = verdict(&["b.npz", "a.npz"]);
    assert_eq!(without["kind"], "undecided");
    assert!(
        without["advice"][0]
            .as_str()
            .unwrap()
            .contains("State the period"),
        "{without}"
    );
    // A weight scales the integral and nothing else.
    let weighted = report(
        folder,
        &["b.npz", "a.npz", "--period=2.5", "--weight", "-3"],
    );
    let initial = weighted["points"][0]["initial"].as_f64().unwrap();
    assert!((initial + 3.0 * std::f64::consts::PI).abs() < 1e-12);
    // The loop command says what the system's coordinates mean.
    let made = symplint(
        folder,
        &["loop", &example("pic-1d.toml"), "--json", "--samples", "32"],
    );
    let made: Value = serde_json::from_slice(&made.stdout).unwrap();
    assert_eq!(made["weight"][0], made["weight"][1]);
    assert!(made["weight"][0].as_f64().unwrap() > 1.0);
    let said = refused(folder, &["loop.npz", "loop.npz", "--weight", "1,2,3"]);
    assert!(
        said.contains("3 numbers for 2 degrees of freedom"),
        "{said}"
    );
}

#[test]
fn a_run_folder_holds_everything() {
    let exchange = Exchange::new("128");
    exchange.write_npz("after.npz", leapfrog, 0.5);
    let arguments = [
        "measure",
        "before.npz",
        "after.npz",
        "--out",
        "run",
        "--quiet",
    ];
    let output = symplint(exchange.path(), &arguments);
    assert_eq!(status(&output), 0);
    assert!(text(&output.stdout).starts_with("SYMPLECTIC to 14."));
    for name in [
        "report.json",
        "points.csv",
        "config.toml",
        "figures/step_sizes.svg",
        "figures/loop.png",
    ] {
        let data = fs::metadata(exchange.path().join("run").join(name));
        assert!(data.is_ok_and(|data| data.len() > 50), "{name}");
    }
    let made = symplint(
        exchange.path(),
        &["loop", &example("pendulum.toml"), "--out", "made/here"],
    );
    assert_eq!(status(&made), 0);
    assert!(exchange.path().join("made/here/loop.npz").exists());
    // There is nothing to draw.
    assert!(!exchange.path().join("made/here/figures").exists());
}

#[test]
fn a_loop_that_did_not_move_is_undecided() {
    let exchange = Exchange::new("64");
    let output = symplint(exchange.path(), &["measure", "before.npz", "before.csv"]);
    assert_eq!(status(&output), 3);
    assert!(text(&output.stdout).contains("moved no state"));
}

#[test]
fn bad_files_are_refused_by_name() {
    let exchange = Exchange::new("64");
    let folder = exchange.path();
    let (q, p) = (doubles(&exchange.q), doubles(&exchange.p));
    let broken = |name: &str, arrays: &[(&str, Vec<u8>)], says: &[&str]| {
        npz(&folder.join(name), false, arrays);
        let said = refused(folder, &["before.npz", name]);
        assert!(said.contains(name), "{said}");
        for words in says {
            assert!(said.contains(words), "{words} is not in: {said}");
        }
    };
    broken(
        "empty.npz",
        &[],
        &["no array `q`; it has none", "numpy.savez"],
    );
    broken(
        "half.npz",
        &[("q", q.clone()), ("x", p.clone())],
        &["no array `p`; it has q, x"],
    );
    let whole = npy("<i8", false, "(64, 1)", &[0; 512]);
    broken(
        "integers.npz",
        &[("q", q.clone()), ("p", whole)],
        &["<i8", "`p`", "astype(float)"],
    );
    let text_array = npy("<U8", false, "(64, 1)", &[0; 2048]);
    broken(
        "texts.npz",
        &[("q", q.clone()), ("p", text_array)],
        &["<U8", "astype(float)"],
    );
    let short = npy("<f8", false, "(63, 1)", &[0; 504]);
    broken(
        "shapes.npz",
        &[("q", q.clone()), ("p", short.clone())],
        &["[64, 1]", "[63, 1]"],
    );
    broken(
        "other.npz",
        &[("q", short.clone()), ("p", short)],
        &["63 samples of 1", "before.npz has 64 of 1"],
    );
    let deep = npy("<f8", false, "(4, 4, 4)", &[0; 512]);
    broken(
        "deep.npz",
        &[("q", deep.clone()), ("p", deep)],
        &["[4, 4, 4]", "(samples, dof)"],
    );
    let two = npy("<f8", false, "(2,)", &[0; 16]);
    let with_two = [("q", q.clone()), ("p", p.clone()), ("h", two)];
    broken(
        "steps.npz",
        &with_two,
        &["2 values in `h`", "one step size"],
    );
    let still = npy("<f8", false, "()", &0.0_f64.to_le_bytes());
    let with_none = [("q", q.clone()), ("p", p.clone()), ("h", still)];
    broken("still.npz", &with_none, &["still.npz: the step size is 0"]);
    let mut values = exchange.p.clone();
    values[17] = f64::NAN;
    let with_nan = [("q", q.clone()), ("p", doubles(&values))];
    broken("nan.npz", &with_nan, &["p[0] = NaN in sample 17"]);
    // Headers that claim what no memory holds, for the values and for themselves.
    let huge = npy("<f8", false, "(4611686018427387904, 9)", &[0; 64]);
    broken(
        "huge.npz",
        &[("q", huge), ("p", p.clone())],
        &["cut short in `q`"],
    );
    // Nothing in rows without end, and by columns, as if they were to be put in order.
    let endless = npy("<f8", true, "(1152921504606846976, 0)", &[]);
    npz(
        &folder.join("endless.npz"),
        false,
        &[("q", endless.clone()), ("p", endless)],
    );
    let mut command = Command::cargo_bin("symplint").unwrap();
    command.current_dir(folder).timeout(Duration::from_secs(20));
    let output = command
        .args(["measure", "before.npz", "endless.npz"])
        .output();
    let output = output.expect("it comes to an end");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("0 degrees of freedom"));
    let mut long = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
    long.extend([b' '; 100]);
    broken(
        "long.npz",
        &[("q", q.clone()), ("p", long)],
        &["cut short in `p`", "4294967307"],
    );
    broken(
        "noise.npz",
        &[("q", q), ("p", vec![7; 300])],
        &["no array that can be read"],
    );

    let archive = fs::read(folder.join("before.npz")).unwrap();
    for length in [0, 10, 700, archive.len() - 30] {
        fs::write(folder.join("cut.npz"), &archive[..length]).unwrap();
        assert!(refused(folder, &["before.npz", "cut.npz"]).contains("cut.npz"));
    }
    for at in (0..archive.len()).step_by(37) {
        // One byte wrong anywhere: an answer or a refusal, never a crash.
        let mut damaged = archive.clone();
        damaged[at] ^= 0x41;
        fs::write(folder.join("damaged.npz"), damaged).unwrap();
        let code = status(&symplint(
            folder,
            &["measure", "before.npz", "damaged.npz", "--quiet"],
        ));
        assert!((0..=3).contains(&code), "byte {at}: {code}");
    }
}

#[test]
fn bad_tables_are_refused_with_their_line() {
    let exchange = Exchange::new("64");
    let folder = exchange.path();
    for (table, says) in [
        ("1,2\n3,4\n5,x\n", "line 3: \"x\" is not a number"),
        ("1,2,3\n", "line 1: 3 columns"),
        (
            "q_0,p_0\n1,2\n1,2,3\n",
            "line 3: 3 columns where there were 2",
        ),
        ("q_0,q_1,p_0\n", "q_0, q_1, p_0"),
        ("q_1,p_1\n", "q_1, p_1 are not q and p"),
        ("q_0,energy\n", "unknown column \"energy\""),
        ("q_0,p_0\n1,2\n", "1 samples"),
        ("", "0 samples"),
    ] {
        fs::write(folder.join("t.csv"), table).unwrap();
        let said = refused(folder, &["before.csv", "t.csv"]);
        assert!(said.contains(says), "{table:?}: {said}");
    }
    let said = refused(folder, &["before.csv", "t.dat"]);
    assert!(
        said.contains("must be .npz, .npy, .csv, .raw or .txt"),
        "{said}"
    );
}

#[test]
fn bad_options_are_refused() {
    let exchange = Exchange::new("64");
    exchange.write_npz("a.npz", leapfrog, 0.5);
    exchange.write_npz("b.npz", leapfrog, 0.25);
    let folder = exchange.path();
    for (arguments, says) in [
        (
            &["before.npz", "a.npz", "b.npz", "--h", "0.5"][..],
            "1 step size for 2 files",
        ),
        (
            &["before.npz", "a.npz", "b.npz", "--h", "0.5,0.5"],
            "a.npz and b.npz have the same step size",
        ),
        (&["before.npz", "a.npz", "--h", "0"], "step size is 0"),
        (
            &["before.npz", "a.npz", "--h", "large"],
            "invalid value 'large' for '--h <H>'",
        ),
        (&["before.npz", "a.npz", "--period=-1"], "period[0] is -1"),
        (&["before.npz", "a.npz", "--weight", "0"], "weight[0] is 0"),
        (
            &["before.npz", "a.npz", "--set", "loop.radius=2"],
            "unexpected argument '--set'",
        ),
        (&["before_q.npy", "before_p.npy"], "none after it"),
        (&["before.npz", "missing.npz"], "cannot read missing.npz"),
    ] {
        let said = refused(folder, arguments);
        assert!(said.contains(says), "{arguments:?}: {said}");
    }
    let output = symplint(
        folder,
        &["loop", &example("pendulum.toml"), "--samples", "2"],
    );
    assert_eq!(status(&output), 2);
    let output = symplint(
        folder,
        &[
            "loop",
            &example("pendulum.toml"),
            "--output",
            "no/such/loop.npz",
        ],
    );
    assert_eq!(status(&output), 2);
    assert!(text(&output.stderr).contains("cannot write no/such/loop.npz"));
}

#[test]
fn periods_of_momenta_go_with_the_file() {
    let folder = TempDir::new().unwrap();
    let config = example("standard-map.toml");
    let torus = ["--set", "system.torus=true", "--samples", "512"];
    let written = symplint(folder.path(), &[&["loop", &config][..], &torus].concat());
    assert_eq!(status(&written), 0, "{}", text(&written.stderr));
    let mut file = LoopFile::read(&folder.path().join("loop.npz")).unwrap();
    assert_eq!(file.momentum_period, Some(vec![TAU]));
    let map = StandardMap::new(0.9).unwrap().on_torus();
    file.states.advance(&map, 1.0).unwrap();
    for (name, period) in [("with.npz", Some(vec![TAU])), ("without.npz", None)] {
        file.path = folder.path().join(name);
        file.momentum_period = period;
        file.step_size = Some(1.0);
        file.write().unwrap();
        let agrees = symplint(folder.path(), &["measure", "loop.npz", name]);
        assert_eq!(status(&agrees), 0, "{}", text(&agrees.stdout));
        // Without the period the momentum jumps by 2π where it wraps.
        let none = ["measure", "loop.npz", name, "--momentum-period", "0"];
        let none = symplint(folder.path(), &none);
        assert_ne!(status(&none), 0, "{}", text(&none.stdout));
    }
}

#[test]
fn one_forms_stand_in_for_momenta() {
    // The circle in x and y of Lotka–Volterra, and u = ln x, v = −ln y, in which ω = dx∧dy/(xy) is canonical.
    let folder = TempDir::new().unwrap();
    let step = |[x, y]: [f64; 2]| {
        let x = x * (0.5 * (1.0 - y)).exp();
        [x, y * (0.4 * (x - 1.0)).exp() * (0.01 * y).exp()]
    };
    let before: Vec<[f64; 2]> = (0..64)
        .map(|k| (TAU * f64::from(k) / 64.0).sin_cos())
        .map(|(sin, cos)| [1.0 + 0.4 * sin, 1.5 + 0.4 * cos])
        .collect();
    let after: Vec<[f64; 2]> = before.iter().map(|&z| step(z)).collect();
    let rows = |states: &[[f64; 2]], of: &dyn Fn([f64; 2]) -> Vec<f64>| {
        let values: Vec<f64> = states.iter().flat_map(|&z| of(z)).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        npy(
            "<f8",
            false,
            &format!("(64, {})", values.len() / 64),
            &bytes,
        )
    };
    for (name, states) in [("before", &before), ("after", &after)] {
        let of_form = [
            ("z", rows(states, &|z| z.to_vec())),
            ("theta", rows(states, &|[x, y]| vec![-y.ln() / x, 0.0])),
        ];
        npz(
            &folder.path().join(format!("{name}_z.npz")),
            false,
            &of_form,
        );
        let of_logarithms = [
            ("q", rows(states, &|[x, _]| vec![x.ln()])),
            ("p", rows(states, &|[_, y]| vec![-y.ln()])),
        ];
        npz(
            &folder.path().join(format!("{name}.npz")),
            false,
            &of_logarithms,
        );
    }
    let point = |arguments: &[&str]| report(folder.path(), arguments)["points"][0].clone();
    let of_form = point(&["before_z.npz", "after_z.npz"]);
    let of_logarithms = point(&["before.npz", "after.npz"]);
    let defect = |point: &Value| point["signed_defect"].as_f64().unwrap();
    assert!(defect(&of_form).abs() > 1e-3);
    assert!((defect(&of_form) - defect(&of_logarithms)).abs() < 1e-13);
    // Without z there is nothing to integrate.
    let alone = [("theta", rows(&before, &|z| z.to_vec()))];
    npz(&folder.path().join("alone.npz"), false, &alone);
    let said = refused(folder.path(), &["alone.npz", "after.npz"]);
    assert!(said.contains("alone.npz") && said.contains('z'), "{said}");
}
