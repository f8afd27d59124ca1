//! Why a file of a loop cannot be used, and what to do.

use std::path::PathBuf;

/// A problem of a file of a loop.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LoopFileError {
    /// The name does not end in that of a format.
    #[error("{} must be .npz, .npy, .csv, .raw or .txt", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A FIFO, a device or a folder, which may have no end.
    #[error("{} is not a regular file", path.display())]
    NotRegular {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// An archive without the array.
    #[error("{} has no array `{array}`; it has {}", path.display(), list(.found))]
    Missing {
        /// The file.
        path: PathBuf,
        /// The array.
        array: &'static str,
        /// What there is.
        found: Vec<String>,
    },
    /// An array that cannot be read.
    #[error("{} holds no array that can be read{}: {reason}", path.display(), in_array(.array))]
    Broken {
        /// The file.
        path: PathBuf,
        /// Name of the array in an archive, or empty.
        array: String,
        /// Why.
        reason: String,
    },
    /// An array of an archive that unpacks to far more than it takes there.
    #[error("{} has {packed} bytes that unpack to more than {most} bytes in `{array}`", path.display())]
    TooCompressed {
        /// The file.
        path: PathBuf,
        /// The array.
        array: &'static str,
        /// Bytes that it takes in the archive.
        packed: u64,
        /// Bytes that it may unpack to.
        most: u64,
    },
    /// The header promises more than there is.
    #[error(
        "{} is cut short{}: its header promises {promised} bytes and the file has {there}",
        path.display(), in_array(.array)
    )]
    CutShort {
        /// The file.
        path: PathBuf,
        /// Name of the array in an archive, or empty.
        array: String,
        /// Bytes that the header promises.
        promised: u128,
        /// Bytes there are.
        there: usize,
    },
    /// Values that are not floating-point numbers.
    #[error("{} holds {descr} values{}", path.display(), in_array(.array))]
    Type {
        /// The file.
        path: PathBuf,
        /// Name of the array in an archive, or empty.
        array: String,
        /// Their type, as NumPy writes it.
        descr: String,
    },
    /// An array of another shape.
    #[error("{} has arrays of shape {shape:?}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// The shape.
        shape: Vec<usize>,
    },
    /// Positions and momenta of different shapes.
    #[error("{} has q of shape {q:?} and p of shape {p:?}", path.display())]
    ShapesDiffer {
        /// The file.
        path: PathBuf,
        /// Shape of q.
        q: Vec<usize>,
        /// Shape of p.
        p: Vec<usize>,
    },
    /// Loops of which one cannot be the other after a step.
    #[error(
        "{} has {} samples of {} degrees of freedom where {} has {} of {}",
        path.display(), .shape.0, .shape.1, before.display(), .shape_before.0, .shape_before.1
    )]
    OtherLoop {
        /// The file after the step.
        path: PathBuf,
        /// Its samples and degrees of freedom.
        shape: (usize, usize),
        /// The file before the step.
        before: PathBuf,
        /// Its samples and degrees of freedom.
        shape_before: (usize, usize),
    },
    /// Too few samples for a loop.
    #[error("{} has {samples} samples of {dof} degrees of freedom, too few for a loop", path.display())]
    TooSmall {
        /// The file.
        path: PathBuf,
        /// Samples.
        samples: usize,
        /// Degrees of freedom.
        dof: usize,
    },
    /// A step size, period or weight of another length.
    #[error("{} has {got} values in `{array}`", path.display())]
    Count {
        /// The file.
        path: PathBuf,
        /// The array.
        array: &'static str,
        /// Values there are.
        got: usize,
        /// The expected shape.
        expected: &'static str,
    },
    /// A state that is not finite.
    #[error("{} has {coordinate}[{dof}] = {value} in sample {sample}", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// `q` or `p`.
        coordinate: &'static str,
        /// Degree of freedom.
        dof: usize,
        /// Sample.
        sample: usize,
        /// NaN or an infinity.
        value: f64,
    },
    /// A `.raw` or `.txt` file with another first line.
    #[error("{} does not begin with a line `symplint h dof samples`", path.display())]
    Header {
        /// The file.
        path: PathBuf,
    },
    /// A word that is not a number.
    #[error("{} has `{word}`, which is not a number", path.display())]
    Number {
        /// The file.
        path: PathBuf,
        /// The word, or its beginning.
        word: String,
    },
    /// More or fewer numbers than the first line promises.
    #[error(
        "{} has {there} numbers, and its first line promises {promised}: q and p of {dof} degrees of freedom at {samples} samples",
        path.display()
    )]
    Numbers {
        /// The file.
        path: PathBuf,
        /// Degrees of freedom.
        dof: usize,
        /// Samples.
        samples: usize,
        /// Numbers that the first line promises.
        promised: usize,
        /// Numbers there are.
        there: usize,
    },
    /// A table that does not describe a loop.
    #[error("{}, line {line}: {message}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// The problem.
        message: String,
    },
}

impl LoopFileError {
    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            LoopFileError::Format { .. } => "name a file that ends in one of them",
            LoopFileError::Read { .. } => "check that the file is there and complete",
            LoopFileError::NotRegular { .. } => "write the loop to a file, and give that",
            LoopFileError::Write { .. } => "name a file in a folder that can be written",
            LoopFileError::Missing { .. } => {
                "write it by numpy.savez(file, q=q, p=p) with arrays of shape (samples, dof)"
            }
            LoopFileError::Broken { .. } => "write it again by numpy, as an array of numbers",
            LoopFileError::TooCompressed { .. } => {
                "if it is not damaged, write it by numpy.savez, without compression"
            }
            LoopFileError::CutShort { .. } => "write it again",
            LoopFileError::Type { .. } => {
                "store double or single precision numbers: array.astype(float)"
            }
            LoopFileError::Shape { .. } => {
                "give shape (samples, dof); row k is the state of sample k"
            }
            LoopFileError::ShapesDiffer { .. } => "give both the shape (samples, dof)",
            LoopFileError::OtherLoop { .. } => {
                "give the same samples before and after the step, each row advanced by one step"
            }
            LoopFileError::TooSmall { .. } => {
                "give 64 samples or more of one degree of freedom or more, one row for each sample"
            }
            LoopFileError::Count { expected, .. } => return format!("give {expected}"),
            LoopFileError::NotFinite { .. } => {
                "look at the step there (samples and degrees of freedom are counted from 0)"
            }
            LoopFileError::Header { .. } => {
                "write this line first, such as `symplint 0.5 2 256` for 256 samples of 2 degrees of freedom after a step of 0.5 (nan if \
                 there was no step)"
            }
            LoopFileError::Number { .. } => "write decimals such as -1.5e-3 between blanks",
            LoopFileError::Numbers { .. } => {
                "write all samples of q_0, then of q_1 and so on, then of p_0 and so on: as doubles of 8 bytes (.raw) or as decimals \
                 (.txt)"
            }
            LoopFileError::Table { .. } => {
                "give columns q_0, q_1, …, p_0, p_1, … of numbers, separated by commas"
            }
        }
        .to_owned()
    }
}

fn in_array(array: &str) -> String {
    if array.is_empty() {
        String::new()
    } else {
        format!(" in `{array}`")
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() {
        "none".into()
    } else {
        names.join(", ")
    }
}
