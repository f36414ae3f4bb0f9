//! One cell: a number or an array of them.

use num_complex::Complex;
use rubbl_casatables::{CasaDataType, CasaScalarData, GlueDataType, TableError, UninitedCasaData};

/// Most values of a cell: a thousand times what correlators of today write.
const MAX_VALUES: u64 = 1 << 24;

/// What cells are made of.
pub(crate) trait Value: CasaScalarData + Copy + Default {}

impl Value for bool {}
impl Value for i32 {}
impl Value for f32 {}
impl Value for f64 {}
impl Value for Complex<f32> {}

/// The values of a cell, last axis fastest; no axes where the column is not one of arrays.
///
/// `rubbl_casatables` reads scalars without a look at whether the column is one of arrays, whose
/// cells are then written over the end of the scalar. So every cell is read as one of these, which
/// see the shape before there is memory for it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cell<T> {
    pub(super) shape: Vec<u64>,
    pub(super) values: Vec<T>,
}

impl<T: Value> CasaDataType for Cell<T> {
    const DATA_TYPE: GlueDataType = T::DATA_TYPE;

    type MaybeUninit = Self;

    fn casatables_alloc(shape: &[u64]) -> Result<Self, TableError> {
        let count = (shape.iter()).try_fold(1u64, |count, &len| count.checked_mul(len));
        let count = count.filter(|&count| count <= MAX_VALUES).ok_or_else(|| {
            TableError::UserMessage(format!(
                "a cell has shape {shape:?}, more than {MAX_VALUES} values are not read"
            ))
        })?;
        Ok(Self {
            shape: shape.to_vec(),
            values: vec![T::default(); count as usize],
        })
    }

    // Nothing in it is unsafe: the values are there from the start.
    #[allow(unsafe_code)]
    unsafe fn casatables_assume_init(cell: Self) -> Self {
        cell
    }
}

impl<T: Value> UninitedCasaData for Cell<T> {
    fn casatables_uninit_as_mut_ptr(&mut self) -> *mut () {
        self.values.as_mut_ptr().cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cell_is_larger_than_any_array_could_be() {
        assert_eq!(Cell::<f32>::casatables_alloc(&[]).unwrap().values, [0.0]);
        let cell = Cell::<bool>::casatables_alloc(&[64, 4]).unwrap();
        assert_eq!((cell.shape, cell.values.len()), (vec![64, 4], 256));
        assert!(Cell::<f64>::casatables_alloc(&[1 << 40]).is_err());
        assert!(Cell::<f64>::casatables_alloc(&[1 << 32, 1 << 32]).is_err());
    }
}
