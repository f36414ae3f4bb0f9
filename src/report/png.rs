//! Figures as PNG files.
//!
//! The letters are those of DejaVu Sans, which is part of the program: no font of the system is looked
//! for, so that the same figure is the same file everywhere.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use vis2cat_formats::{PendingFile, WriteError};

use super::Figure;
use crate::chains::refuse_existing;

/// Pixels of the file for one of the figure.
const SCALE: f32 = 2.0;

/// Writes `NAME.png` of each figure into `folder`, which is made; none has its name before all are
/// whole.
///
/// # Errors
/// The folder is there, is not empty and `overwrite` is false, or cannot be written.
pub fn write(folder: &Path, overwrite: bool, figures: &[&Figure]) -> Result<(), WriteError> {
    refuse_existing(folder, overwrite)?;
    std::fs::create_dir_all(folder).map_err(|source| WriteError::Io {
        path: folder.into(),
        source,
    })?;
    let options = options();
    let mut pending = Vec::new();
    for figure in figures {
        let path: PathBuf = folder.join(format!("{}.png", figure.name));
        let png = encode(figure, &options).map_err(|what| WriteError::Parameter {
            path: path.clone(),
            what,
        })?;
        let mut file = PendingFile::create(&path, overwrite)?;
        file.append(&png)?;
        file.sync()?;
        pending.push(file);
    }
    pending.into_iter().try_for_each(PendingFile::commit)
}

fn options() -> Options<'static> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Options {
        fontdb: Arc::new(fonts),
        font_family: "DejaVu Sans".to_owned(),
        ..Options::default()
    }
}

/// The bytes of a PNG file.
fn encode(figure: &Figure, options: &Options) -> Result<Vec<u8>, String> {
    let tree = Tree::from_str(&figure.svg_file(), options).map_err(|e| e.to_string())?;
    let [width, height] = figure.size.map(|s| (s * f64::from(SCALE)).ceil() as u32);
    let mut pixels = Pixmap::new(width, height).ok_or("the figure has no size")?;
    resvg::render(
        &tree,
        Transform::from_scale(SCALE, SCALE),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().map_err(|e| e.to_string())
}
