//! Numbers, whatever their width and byte order in the file: libhdf5 converts them.

use super::dataset::{Dataset, Kind};
use crate::ReadError;

impl Dataset {
    /// The one value, real or whole.
    pub(crate) fn real(&self) -> Result<f64, ReadError> {
        self.only(&self.reals()?)
    }

    /// The one value, whole.
    pub(crate) fn whole(&self) -> Result<i64, ReadError> {
        self.only(&self.wholes()?)
    }

    /// The one value, a count of something.
    pub(crate) fn count(&self) -> Result<usize, ReadError> {
        let value = self.whole()?;
        usize::try_from(value)
            .map_err(|_| self.malformed(format!("is {value}, must not be negative")))
    }

    /// All values, real or whole.
    pub(crate) fn reals(&self) -> Result<Vec<f64>, ReadError> {
        self.check_real()?;
        self.read_all()
    }

    /// All values, whole.
    pub(crate) fn wholes(&self) -> Result<Vec<i64>, ReadError> {
        self.check_whole()?;
        self.read_all()
    }

    /// Elements must be numbers.
    pub(crate) fn check_real(&self) -> Result<(), ReadError> {
        match self.kind {
            Kind::Real | Kind::Whole => Ok(()),
            _ => Err(self.wrong_kind("numbers")),
        }
    }

    /// Elements must be whole numbers.
    pub(crate) fn check_whole(&self) -> Result<(), ReadError> {
        match self.kind {
            Kind::Whole => Ok(()),
            _ => Err(self.wrong_kind("whole numbers")),
        }
    }

    /// The dataset must have that shape.
    pub(crate) fn check_shape_is(&self, wanted: &[usize]) -> Result<(), ReadError> {
        if self.shape == wanted {
            return Ok(());
        }
        let what = format!("has shape {:?}, must have {wanted:?}", self.shape);
        Err(self.malformed(what))
    }

    /// The only element: a scalar, or an array of one as some writers have it.
    fn only<T: Copy>(&self, values: &[T]) -> Result<T, ReadError> {
        match values {
            [value] => Ok(*value),
            _ => Err(self.malformed(format!("has shape {:?}, must be one value", self.shape))),
        }
    }
}
