//! Writing the files of a figure.

use std::fs;
use std::path::Path;

use super::font::Typeface;
use super::{Figure, FigureError, draw, pdf, png, svg};
use symplint_files::write_whole;

impl Figure {
    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    ///
    /// [`FigureError`] if the figure has no panels.
    pub fn to_svg(&self) -> Result<String, FigureError> {
        let path = Path::new("figure.svg");
        if self.panels.is_empty() {
            return Err(FigureError::NoPanels { path: path.into() });
        }
        let face = Typeface::load().map_err(|cause| FigureError::Font {
            path: path.into(),
            cause,
        })?;
        Ok(svg::paint(&draw::scene(self, &face)))
    }

    /// Writes `name.svg`, `name.pdf` and `name.png` into `folder`, making the folder if need be and
    /// replacing older files. The PNG has two pixels for each unit of the SVG: 1300 for the
    /// width of one panel, which PDF and PNG print 3.5 inches wide.
    ///
    /// # Errors
    ///
    /// [`FigureError`] if the figure has no panels, is too large for a picture, or a file
    /// cannot be written. Values that an axis cannot show are left out without an error.
    pub fn save(&self, folder: &Path, name: &str) -> Result<(), FigureError> {
        let base = folder.join(name);
        if self.panels.is_empty() {
            return Err(FigureError::NoPanels { path: base });
        }
        let face = Typeface::load().map_err(|cause| FigureError::Font {
            path: base.clone(),
            cause,
        })?;
        fs::create_dir_all(folder).map_err(|reason| FigureError::Folder {
            path: folder.to_path_buf(),
            reason,
        })?;
        let scene = draw::scene(self, &face);

        let path = folder.join(format!("{name}.svg"));
        write_whole(&path, svg::paint(&scene).as_bytes())
            .map_err(|reason| FigureError::Write { path, reason })?;

        let path = folder.join(format!("{name}.pdf"));
        pdf::paint(&scene, &face)
            .and_then(|file| write_whole(&path, &file))
            .map_err(|reason| FigureError::Write { path, reason })?;

        let path = folder.join(format!("{name}.png"));
        png::write(&scene, &face, &path, self.panels.len())
    }
}
