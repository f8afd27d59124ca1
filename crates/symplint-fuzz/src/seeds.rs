//! Small valid inputs, from which mutations begin.

use std::fs;
use std::path::Path;

use symplint::diagnosis::SampleSweep;
use symplint::{Circle, Coordinates, Diagnostic, Ensemble, Evidence, PerSample, Snapshot, measure};
use symplint_files::loop_file::{Array, LoopFile};

use crate::files::with_file;
use crate::verdicts::report_of;

/// The seeds of a target, by its name. Those of structured targets are random bytes, which the caller makes.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    match target {
        "configuration" => configurations(),
        "npy" => arrays(),
        "npz" => vec![loop_file("loop.npz")],
        "csv" => vec![
            loop_file("loop.csv"),
            b"# a loop\n1,2\n3,4\n5,7e-3\n".to_vec(),
        ],
        "journal" => vec![journal()],
        "report" => (evidence().iter())
            .map(|evidence| report_of(evidence).into_bytes())
            .collect(),
        _ => Vec::new(),
    }
}

/// The examples, and the templates of all systems.
fn configurations() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let files = fs::read_dir(folder)
        .expect("the examples are there")
        .flatten();
    let mut paths: Vec<_> = files.map(|file| file.path()).collect();
    paths.retain(|path| {
        path.extension()
            .is_some_and(|extension| extension == "toml")
    });
    paths.sort();
    let examples = (paths.iter()).map(|path| fs::read(path).expect("an example can be read"));
    let templates = (symplint_config::SYSTEMS.iter())
        .map(|info| symplint_config::template(info, true).into_bytes());
    let mut all: Vec<Vec<u8>> = examples.chain(templates).collect();
    all.push(b"[system]\nname = \"fput\"\n\0system.masses=2^3\0loop.radius=\"auto\"".to_vec());
    all
}

fn arrays() -> Vec<Vec<u8>> {
    let array = |shape: &[usize]| {
        let count: usize = shape.iter().product();
        let values = (0..count).map(|k| k as f64 - 1.5).collect();
        let array = Array {
            shape: shape.to_vec(),
            values,
            single: false,
        };
        array.encode()
    };
    let mut all = vec![array(&[]), array(&[4]), array(&[4, 2]), array(&[2, 3])];
    let fortran = String::from_utf8_lossy(&all[2]).replace("False", "True ");
    if fortran.len() == all[2].len() {
        all.push(fortran.into_bytes());
    }
    for kind in ["<f4", ">f8", "<i4", "<i8"] {
        let header = format!("{{'descr': '{kind}', 'fortran_order': True, 'shape': (3, 2), }}");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend([63; 48]);
        all.push(bytes);
    }
    all
}

fn loop_file(name: &str) -> Vec<u8> {
    let circle = Circle::new(vec![0.1, 0.2], vec![0.3, 0.4], 0.5).expect("a circle");
    with_file(name, &[], |path| {
        let file = LoopFile {
            path: path.to_owned(),
            states: Ensemble::sample(&circle, 5).expect("samples"),
            unit_roundoff: Snapshot::DOUBLE,
            step_size: Some(0.5),
            period: Some(vec![6.0, 0.0]),
            momentum_period: Some(vec![0.0]),
            weight: Some(vec![2.0]),
        };
        file.write().expect("a temporary file");
        fs::read(path).expect("it was written")
    })
}

fn journal() -> Vec<u8> {
    with_file("journal", &[], |path| {
        crate::journal::journal_at(path);
        fs::read(path).expect("it was written")
    })
}

/// Evidence of real maps: symplectic, of order 2, broken, failing, in groups, after many steps, and of samples alone.
pub fn evidence() -> Vec<Evidence> {
    let diagnostic = Diagnostic {
        budget: Some(20_000),
        loops: 3,
        ..Diagnostic::halving(-1, -3)
    };
    let circle = Circle::new(vec![0.1], vec![0.2], 1.0).expect("a circle");
    let euler = |force: fn(f64) -> f64| {
        PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * force(q[0]);
            q[0] += h * p[0];
        })
    };
    let explicit = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        let force = q[0].sin();
        q[0] += h * p[0];
        p[0] -= h * force;
    });
    let failing = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0];
        q[0] += h * p[0];
        match h > 0.3 {
            true => Err("the step is too large"),
            false => Ok(()),
        }
    });
    let two_sizes = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        for i in 0..2 {
            p[i] -= h * q[i].sin();
            q[i] += h * p[i];
        }
    });
    let of_two = Circle::with_radii(vec![0.1; 2], vec![0.2; 2], vec![1.0, 1e-6], vec![1.0, 1e-6]);
    let of_two = of_two.expect("a circle");
    let long = Diagnostic {
        long_time: 64,
        sample_sweep: Some(SampleSweep {
            counts: vec![32, 64],
            step_size: 0.25,
        }),
        ..diagnostic.clone()
    };
    let tight = Diagnostic {
        budget: Some(300),
        ..diagnostic.clone()
    };
    let of_maps = [
        diagnostic.run(&euler(f64::sin), &circle),
        long.run(&explicit, &circle),
        diagnostic.run(&euler(f64::signum), &circle),
        tight.run(&euler(f64::floor), &circle),
        diagnostic.run(&failing, &circle),
        diagnostic.run(&two_sizes, &of_two),
    ];
    let before = Snapshot::new(Ensemble::sample(&circle, 64).expect("samples"));
    let mut jumped = before.clone().after_step(0.5);
    jumped.states.block().q.row_mut(0)[20..]
        .iter_mut()
        .for_each(|q| *q += 3.0);
    let of_samples = measure(&before, &[jumped], &Coordinates::plain(1));
    (of_maps.into_iter().chain([of_samples]))
        .map(|diagnosis| diagnosis.expect("a diagnosis").evidence)
        .collect()
}
