//! What can go wrong when a figure is written.

use std::io;
use std::path::PathBuf;

/// Why a figure was not written.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// The figure has nothing to draw.
    #[error("figure {path}: it has no panels; add at least one")]
    NoPanels {
        /// The figure's path without extension.
        path: PathBuf,
    },
    /// The picture would not fit into memory.
    #[error(
        "figure {path}: {panels} panels make a picture of {width} × {height} pixels; \
         spread them over more columns or over several figures"
    )]
    TooLarge {
        /// The PNG file's path.
        path: PathBuf,
        /// Number of panels.
        panels: usize,
        /// Width in pixels.
        width: u64,
        /// Height in pixels.
        height: u64,
    },
    /// The folder for the figure could not be made.
    #[error("figure folder {path}: cannot create it: {reason}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The operating system's reason.
        reason: io::Error,
    },
    /// A file could not be written.
    #[error("figure {path}: cannot write it: {reason}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        reason: io::Error,
    },
    /// The drawing library refused.
    #[error("figure {path}: cannot draw it: {cause}")]
    Draw {
        /// The file.
        path: PathBuf,
        /// The library's reason.
        cause: String,
    },
    /// The font inside the program cannot be read: a fault of the build.
    #[error("figure {path}: the built-in font is unreadable: {cause}")]
    Font {
        /// The figure's path without extension.
        path: PathBuf,
        /// The font library's reason.
        cause: String,
    },
}
