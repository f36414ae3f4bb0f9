//! Arrays: where the dishes stand and how noisy they are.

mod builtin;
mod table;

use std::path::Path;

pub use builtin::BUILTIN_NAMES;

use super::SimulateError;

/// An array of dishes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Array {
    /// Telescope name, as it goes into the file.
    pub name: String,
    /// Dishes, in the order of their numbers.
    pub dishes: Vec<Dish>,
}

/// One dish.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dish {
    /// Name or station.
    pub name: String,
    /// Geocentric ITRF position [m].
    pub itrf_m: [f64; 3],
    /// Diameter [m], where known.
    pub diameter_m: Option<f64>,
    /// System equivalent flux density of one hand [Jy], where known.
    pub sefd_jy: Option<f64>,
}

impl Array {
    /// The built-in array called `name_or_path`, or else the one in the CSV file of that path.
    ///
    /// Names are compared without regard to case; see [`BUILTIN_NAMES`]. A CSV file has a header
    /// line with `name`, `x_m`, `y_m`, `z_m` (geocentric ITRF) and, where known, `diameter_m` and
    /// `sefd_jy`, in any order; other columns and lines that begin with `#` are passed over.
    ///
    /// # Errors
    /// There is neither such an array nor such a file, or the file is damaged: the error names
    /// line and column.
    pub fn find(name_or_path: &str) -> Result<Self, SimulateError> {
        if let Some(array) = builtin::builtin(name_or_path) {
            return array;
        }
        let path = Path::new(name_or_path);
        let is_csv = path
            .extension()
            .is_some_and(|ext| ext.eq_ignore_ascii_case("csv"));
        if !is_csv && !path.exists() {
            return Err(SimulateError::parameter(format!(
                "no array is called \"{name_or_path}\" and no file either; known are {}, or a CSV file",
                BUILTIN_NAMES.join(", ")
            )));
        }
        Self::read_csv(path)
    }

    /// The array in the CSV file at `path`, called as the file; the format is that of [`Array::find`].
    ///
    /// # Errors
    /// The file cannot be read or is damaged: the error names line and column.
    pub fn read_csv(path: &Path) -> Result<Self, SimulateError> {
        let bytes = std::fs::read(path).map_err(|source| SimulateError::Io {
            path: path.to_owned(),
            source,
        })?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: name.into_owned(),
            dishes: table::read(&bytes, path, |_| true)?,
        })
    }

    /// The mean of the positions [m]: the array reference position.
    pub fn centre_m(&self) -> [f64; 3] {
        let scale = 1.0 / self.dishes.len().max(1) as f64;
        let mut centre_m = [0.0; 3];
        for dish in &self.dishes {
            for (sum, x) in centre_m.iter_mut().zip(dish.itrf_m) {
                *sum += x * scale;
            }
        }
        centre_m
    }

    /// Every pair of dishes (i, j), i < j, first dish slowest.
    pub fn baselines(&self) -> Vec<(u32, u32)> {
        let n = self.dishes.len() as u32;
        (0..n)
            .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
            .collect()
    }
}
