//! How time and memory grow with degrees of freedom, particles and samples.
//!
//! `cargo bench -p symplint-paper --bench scaling [-- FOLDER]` prints the slopes and writes `scaling.csv`,
//! `scaling.svg` and `scaling.png`. It is a bench and no item of `reproduce` because its numbers are
//! those of a machine, and `reproduce` says the same everywhere; it lies in this crate for the figure.

use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;
use symplint::state::{Rows, RowsMut};
use symplint::{Circle, Ensemble, FourierLoop, LoopIntegral, Rule};
use symplint_models::Separable;
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_models::systems::PendulumArray;
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig, TwoStream};
use symplint_report::figure::{Axis, Figure, Panel, Scale, Series, Style};

/// What grows, and what one run does.
struct Case {
    name: &'static str,
    label: &'static str,
    sizes: &'static [usize],
    /// Processor time of one run of this size.
    time: fn(usize) -> Duration,
    /// The quantity that the time should be proportional to.
    cost: fn(f64) -> f64,
}

const CASES: [Case; 3] = [
    Case {
        name: "dof",
        label: "d: step and integral of 64 samples of a pendulum array",
        sizes: &[64, 256, 1024, 4096, 16_384, 65_536],
        time: pendulum_array,
        cost: |d| d,
    },
    Case {
        name: "particles",
        label: "Nₚ: one PIC force, cubic splines, 16 samples",
        sizes: &[100, 316, 1000, 3162, 10_000, 31_623, 100_000],
        time: pic_force,
        cost: |particles| particles,
    },
    Case {
        name: "samples",
        label: "Nₛ: pseudospectral integral, 4 degrees of freedom",
        sizes: &[64, 256, 1024, 4096, 16_384, 65_536, 262_144],
        time: loop_integral,
        cost: |samples| samples * samples.log2(),
    },
];

fn main() {
    let arguments: Vec<String> = (std::env::args().skip(1))
        .filter(|argument| argument != "--bench")
        .collect();
    match &arguments[..] {
        [point, name, size] if point == "point" => measure_here(name, size.parse().unwrap()),
        [] => measure_all(Path::new(env!("CARGO_TARGET_TMPDIR"))),
        [folder] => measure_all(Path::new(folder)),
        _ => panic!("give a folder, or nothing"),
    }
}

/// Prints nanoseconds and the peak of this process's memory in bytes.
fn measure_here(name: &str, size: usize) {
    let before = peak_bytes();
    let case = CASES.iter().find(|case| case.name == name).unwrap();
    let time = (case.time)(size);
    println!("{} {}", time.as_nanos(), peak_bytes() - before);
}

/// The largest resident size so far, if the system tells.
fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().nth(1));
    kibibytes
        .and_then(|number| number.parse().ok())
        .unwrap_or(0)
        * 1024
}

struct Point {
    size: usize,
    nanoseconds: f64,
    bytes: f64,
}

/// One process for each point, on one thread, so that peaks of memory are its own.
fn measure_all(folder: &Path) {
    let mut table = String::from("case,size,nanoseconds,peak_bytes\n");
    let mut cases = Vec::new();
    for case in &CASES {
        let points: Vec<Point> = case.sizes.iter().map(|&size| measure(case, size)).collect();
        println!("{}", case.label);
        for point in &points {
            let Point {
                size,
                nanoseconds,
                bytes,
            } = point;
            println!(
                "{size:>9}{:>14.1} µs{:>12.0} KiB",
                nanoseconds / 1e3,
                bytes / 1024.0
            );
            table += &format!("{},{size},{nanoseconds},{bytes}\n", case.name);
        }
        let time = |point: &Point| (point.size as f64, point.nanoseconds);
        println!(
            "time grows as the power{:>10.2}\nover the last two decades{:>9.2}\nmemory for each{:>19.0} bytes\n",
            slope(points.iter().map(time)),
            slope(last_decades(&points).map(time)),
            bytes_each(&points),
        );
        cases.push((case, points));
    }
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("scaling.csv"), table).unwrap();
    draw(&cases).save(folder, "scaling").unwrap();
    eprintln!(
        "scaling.csv, scaling.svg and scaling.png are in {}",
        folder.display()
    );
}

fn measure(case: &Case, size: usize) -> Point {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["point", case.name, &size.to_string()])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let mut numbers = text
        .split_whitespace()
        .map(|number| number.parse::<f64>().unwrap());
    Point {
        size,
        nanoseconds: numbers.next().expect("a time"),
        bytes: numbers.next().expect("a size"),
    }
}

/// The extra time of the largest size over the one before it, for each extra unit.
fn bytes_each(points: &[Point]) -> f64 {
    match points {
        [.., before, last] => (last.bytes - before.bytes) / (last.size - before.size) as f64,
        _ => f64::NAN,
    }
}

fn last_decades(points: &[Point]) -> impl Iterator<Item = &Point> {
    let largest = points.last().map_or(0, |point| point.size);
    points
        .iter()
        .filter(move |point| point.size * 100 >= largest)
}

/// Slope of the least-squares line through the logarithms.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let logs: Vec<(f64, f64)> = points.map(|(x, y)| (x.ln(), y.ln())).collect();
    let n = logs.len() as f64;
    let mean = |part: fn(&(f64, f64)) -> f64| logs.iter().map(part).sum::<f64>() / n;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    covariance / logs.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

fn draw(cases: &[(&Case, Vec<Point>)]) -> Figure {
    let axis = |label: &str| Axis {
        label: label.into(),
        scale: Scale::Log10,
        range: None,
    };
    let panel = |title: &str, label: &str, value: fn(&Point) -> f64, expected: bool| {
        let mut series = Vec::new();
        for (color, (case, points)) in cases.iter().enumerate() {
            let line = |label: &str, points, style| Series {
                label: label.into(),
                points,
                style,
                color,
            };
            let measured = points.iter().map(|point| (point.size as f64, value(point)));
            let short = case.label.split(':').next().unwrap_or_default();
            series.push(line(short, measured.collect(), Style::LineAndPoints));
            if let (true, Some(last)) = (expected, points.last()) {
                let factor = value(last) / (case.cost)(last.size as f64);
                let line_points = points.iter().map(|point| {
                    let size = point.size as f64;
                    (size, factor * (case.cost)(size))
                });
                series.push(line("", line_points.collect(), Style::Dashed));
            }
        }
        Panel {
            title: title.into(),
            x: axis("d, Nₚ or Nₛ"),
            y: axis(label),
            series,
            equal_aspect: false,
        }
    };
    Figure::new(
        vec![
            panel(
                "time; broken lines: N, N log N",
                "time / s",
                |point| point.nanoseconds * 1e-9,
                true,
            ),
            panel(
                "memory",
                "peak / MiB",
                |point| point.bytes / 1_048_576.0,
                false,
            ),
        ],
        2,
    )
}

/// Processor time of one run, on one thread: what else runs on the machine does not count.
fn measure_runs(mut run: impl FnMut() + Send) -> Duration {
    const ATTEMPTS: u32 = 3;
    const AT_LEAST: Duration = Duration::from_millis(300);
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        // The first makes buffers and plans.
        run();
        // The clock is a file, and takes microseconds to read.
        let first = Instant::now();
        run();
        let batch =
            (Duration::from_millis(1).as_nanos() / first.elapsed().as_nanos().max(1)) as u32 + 1;
        let start = processor_time();
        let mut runs = 0;
        loop {
            (0..batch).for_each(|_| run());
            runs += batch;
            let spent = processor_time() - start;
            if runs >= ATTEMPTS && spent >= AT_LEAST {
                return spent / runs;
            }
        }
    })
}

/// Of this thread; of the wall where the system does not tell.
fn processor_time() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|number| number.parse().ok());
    nanoseconds.map_or_else(|| START.elapsed(), Duration::from_nanos)
}

fn pendulum_array(dof: usize) -> Duration {
    let array = PendulumArray::new(dof, 1.0, 1.0).unwrap();
    let (q, p) = array.uniform_state(1);
    let circle = Circle::new(q, p, 1.0).unwrap();
    let step = Splitting::new(splitting_methods::strang(Variant::PositionFirst), array);
    let mut ensemble = Ensemble::sample(&circle, 64).unwrap();
    measure_runs(|| {
        ensemble.advance(&step, 1e-6).unwrap();
        black_box(LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap());
    })
}

fn pic_force(particles: usize) -> Duration {
    const SAMPLES: usize = 16;
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        cells: 128,
        length: 50.0,
        degree: 3,
        ..PicConfig::default()
    })
    .unwrap();
    let (x, _) = TwoStream::default().sample(&pic, 1).unwrap();
    let q: Vec<f64> = (x.iter())
        .flat_map(|x| (0..SAMPLES).map(move |sample| x + 0.01 * sample as f64))
        .collect();
    let mut p = vec![0.0; q.len()];
    measure_runs(|| {
        let q = Rows::new(black_box(&q), particles, SAMPLES, SAMPLES);
        pic.kick(
            1e-9,
            q,
            &mut RowsMut::new(&mut p, particles, SAMPLES, SAMPLES),
        );
    })
}

fn loop_integral(samples: usize) -> Duration {
    let radii = [1.0; 4];
    let phase_loop = FourierLoop::random(vec![0.0; 4], vec![0.0; 4], &radii, &radii, 1).unwrap();
    let ensemble = Ensemble::sample(&phase_loop, samples).unwrap();
    measure_runs(|| {
        black_box(LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap());
    })
}
