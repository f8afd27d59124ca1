//! Archives of named arrays, as numpy.savez writes them.

use std::fs::{self, File};
use std::io::{self, Cursor, Read, Write};
use std::path::{Path, PathBuf};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::array::{Array, NumberKind};
use super::{LoopFile, LoopFileError};

/// An array may unpack to this number of bytes, whatever its size in the archive: 16 MiB are two million numbers.
const UNPACKED: u64 = 1 << 24;

/// Larger ones may unpack to this multiple of their size in the archive. Samples of a loop hardly shrink: what is forged
/// to fill the memory reaches a factor of 1000.
const MAX_COMPRESSION: u64 = 100;

struct Archive<'a> {
    path: &'a Path,
    /// Its size, which no entry can exceed: headers can claim anything.
    bytes: u64,
    zip: ZipArchive<File>,
}

impl Archive<'_> {
    fn names(&self) -> Vec<String> {
        // A name that cannot be decoded cannot be typed either.
        let mut names: Vec<String> = (self.zip.file_names().flatten())
            .filter_map(|name| name.strip_suffix(".npy").map(str::to_owned))
            .collect();
        names.sort();
        names
    }

    fn optional(
        &mut self,
        name: &'static str,
        kind: NumberKind,
    ) -> Result<Option<Array>, LoopFileError> {
        let file = format!("{name}.npy");
        if !self.zip.file_names().flatten().any(|other| other == file) {
            return Ok(None);
        }
        let broken = |reason: String| LoopFileError::Broken {
            path: self.path.to_owned(),
            array: name.to_owned(),
            reason,
        };
        let entry = self
            .zip
            .by_name(&file)
            .map_err(|error| broken(error.to_string()))?;
        let packed = entry.compressed_size().min(self.bytes);
        let most = UNPACKED.max(packed.saturating_mul(MAX_COMPRESSION));
        let mut bytes = Vec::new();
        let read = entry.take(most + 1).read_to_end(&mut bytes);
        read.map_err(|error| broken(error.to_string()))?;
        if bytes.len() as u64 > most {
            return Err(LoopFileError::TooCompressed {
                path: self.path.to_owned(),
                array: name,
                packed,
                most,
            });
        }
        Array::decode(&bytes, kind, self.path, name).map(Some)
    }

    fn required(&mut self, name: &'static str) -> Result<Array, LoopFileError> {
        let found = self.optional(name, NumberKind::Floats)?;
        found.ok_or_else(|| LoopFileError::Missing {
            path: self.path.to_owned(),
            array: name,
            found: self.names(),
        })
    }

    /// A step size, period or weight: one number, or one for each of `dof` degrees of freedom.
    fn setting(
        &mut self,
        name: &'static str,
        dof: usize,
    ) -> Result<Option<Vec<f64>>, LoopFileError> {
        let Some(array) = self.optional(name, NumberKind::Numbers)? else {
            return Ok(None);
        };
        let got = array.values.len();
        if got == 1 || (got == dof && name != "h") {
            return Ok(Some(array.values));
        }
        Err(LoopFileError::Count {
            path: self.path.to_owned(),
            array: name,
            got,
            expected: match name {
                "h" => "one step size",
                _ => "one number, or one for each degree of freedom",
            },
        })
    }
}

pub fn read(path: &Path, fewest: usize) -> Result<LoopFile, LoopFileError> {
    let unreadable = |reason: String| LoopFileError::Read {
        path: path.to_owned(),
        reason,
    };
    let file = File::open(path).map_err(|error| unreadable(error.to_string()))?;
    let bytes = file
        .metadata()
        .map_err(|error| unreadable(error.to_string()))?;
    let bytes = bytes.len();
    let zip = ZipArchive::new(file).map_err(|error| {
        unreadable(match bytes {
            0 => "the file is empty".to_owned(),
            _ => format!("it is cut off, or is not an npz file ({error})"),
        })
    })?;
    let mut archive = Archive { path, bytes, zip };
    // ∮ ϑ·dz of non-canonical coordinates is ∮ p·dq with q = z and p = ϑ.
    let (q, p) = match archive.optional("theta", NumberKind::Floats)? {
        Some(theta) => (archive.required("z")?, theta),
        None => (archive.required("q")?, archive.required("p")?),
    };
    let mut loaded = LoopFile::from_arrays(path, &q, &p, fewest)?;
    let dof = loaded.states.dof();
    loaded.step_size = archive.setting("h", dof)?.map(|h| h[0]);
    loaded.period = archive.setting("period", dof)?;
    loaded.momentum_period = archive.setting("momentum_period", dof)?;
    loaded.weight = archive.setting("weight", dof)?;
    Ok(loaded)
}

pub fn write(file: &LoopFile) -> Result<Vec<PathBuf>, LoopFileError> {
    // In memory: of a file that cannot be written, the archive would speak for itself on standard error.
    let pack = || -> io::Result<Vec<u8>> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let mut add = |name: &str, array: &Array| -> io::Result<()> {
            let bytes = array.encode();
            let options = SimpleFileOptions::default()
                .compression_method(CompressionMethod::Stored)
                .large_file(bytes.len() > u32::MAX as usize);
            zip.start_file(format!("{name}.npy"), options)?;
            zip.write_all(&bytes)
        };
        add("q", &file.array(false))?;
        add("p", &file.array(true))?;
        let of_step = file.step_size.map(|h| vec![h]);
        for (name, values) in [
            ("h", &of_step),
            ("period", &file.period),
            ("momentum_period", &file.momentum_period),
            ("weight", &file.weight),
        ] {
            if let Some(values) = values {
                let shape = if name == "h" {
                    vec![]
                } else {
                    vec![values.len()]
                };
                add(
                    name,
                    &Array {
                        shape,
                        values: values.clone(),
                        single: false,
                    },
                )?;
            }
        }
        Ok(zip.finish()?.into_inner())
    };
    let written = pack().and_then(|bytes| fs::write(&file.path, bytes));
    written.map_err(|error| LoopFileError::Write {
        path: file.path.clone(),
        reason: error.to_string(),
    })?;
    Ok(vec![file.path.clone()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An archive with q and p of zeros, compressed.
    fn archive_of_zeros(path: &Path, samples: usize) {
        let mut zip = ZipWriter::new(File::create(path).unwrap());
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        let array = Array {
            shape: vec![samples, 1],
            values: vec![0.0; samples],
            single: false,
        };
        for name in ["q.npy", "p.npy"] {
            zip.start_file(name, options).unwrap();
            zip.write_all(&array.encode()).unwrap();
        }
        zip.finish().unwrap();
    }

    #[test]
    fn what_unpacks_to_much_more_than_it_takes_is_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("loop.npz");
        archive_of_zeros(&path, 1 << 20);
        assert_eq!(read(&path, 3).unwrap().states.samples(), 1 << 20);
        archive_of_zeros(&path, 1 << 21);
        let error = read(&path, 3).err().unwrap();
        assert!(matches!(error, LoopFileError::TooCompressed { most, .. } if most == UNPACKED));
        assert!(
            error.to_string().contains("more than 16777216 bytes"),
            "{error}"
        );
        assert!(error.remedy().contains("numpy.savez"));
    }
}
