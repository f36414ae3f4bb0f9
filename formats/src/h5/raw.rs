//! What the crate over libhdf5 has no safe function for.
#![allow(unsafe_code)] // FFI

use hdf5_sys::h5d::H5Dread_chunk;
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5o::{H5O_INFO_BASIC, H5O_info2_t, H5O_token_t, H5O_type_t, H5Oget_info_by_name3};
use hdf5_sys::h5p::H5P_DEFAULT;

unsafe extern "C" {
    // The crate has H5Dget_chunk_info_by_coord instead, which looks at every chunk of the dataset.
    fn H5Dget_chunk_storage_size(
        dataset: hid_t,
        first: *const u64,
        bytes: *mut u64,
    ) -> std::ffi::c_int;
    fn H5VLnative_token_to_addr(
        object: hid_t,
        token: H5O_token_t,
        address: *mut u64,
    ) -> std::ffi::c_int;
}

/// Bytes that the chunk which begins at `first` takes in the file; none if it was never written.
pub(super) fn chunk_bytes(
    dataset: &hdf5::Dataset,
    first: &[usize],
) -> Result<Option<u64>, hdf5::Error> {
    let first: Vec<u64> = first.iter().map(|&i| i as u64).collect();
    let mut bytes = 0u64;
    // SAFETY: `first` has an element for each axis of the dataset, which `done` makes sure of.
    let call =
        || unsafe { H5Dget_chunk_storage_size(dataset.id(), first.as_ptr(), &raw mut bytes) };
    done(dataset, &first, call)?;
    Ok((bytes > 0).then_some(bytes))
}

/// The chunk that begins at `first` and has that many `bytes` in the file, as it stands there, and a bit for
/// each filter that it did not go through.
pub(super) fn read_chunk(
    dataset: &hdf5::Dataset,
    first: &[usize],
    bytes: u64,
) -> Result<(Vec<u8>, u32), hdf5::Error> {
    let first: Vec<u64> = first.iter().map(|&i| i as u64).collect();
    let (mut chunk, mut left_out) = (vec![0u8; bytes as usize], 0u32);
    // SAFETY: `first` is as above, and `chunk` has the bytes that libhdf5 said the chunk has, which it copies.
    let call = || unsafe {
        H5Dread_chunk(
            dataset.id(),
            H5P_DEFAULT,
            first.as_ptr(),
            &raw mut left_out,
            chunk.as_mut_ptr().cast(),
        )
    };
    done(dataset, &first, call)?;
    Ok((chunk, left_out))
}

/// What a name stands for.
pub(super) struct Object {
    pub(super) is_group: bool,
    pub(super) is_dataset: bool,
    /// Where its header stands.
    pub(super) address: u64,
}

/// What a name in a group stands for, without opening it; "." is the group.
pub(super) fn object(group: &hdf5::Group, name: &str) -> Result<Object, hdf5::Error> {
    let name = std::ffi::CString::new(name).map_err(|error| error.to_string())?;
    let mut info = std::mem::MaybeUninit::<H5O_info2_t>::zeroed();
    // SAFETY: `name` ends with a zero, and `info`, which libhdf5 fills in, may be zero.
    locked(|| unsafe {
        let info = info.as_mut_ptr();
        H5Oget_info_by_name3(group.id(), name.as_ptr(), info, H5O_INFO_BASIC, H5P_DEFAULT)
    })?;
    // SAFETY: as above.
    let info = unsafe { info.assume_init() };
    let mut address = 0u64;
    // SAFETY: the token is that of an object in the file of the group.
    locked(|| unsafe { H5VLnative_token_to_addr(group.id(), info.token, &raw mut address) })?;
    Ok(Object {
        is_group: info.type_ == H5O_type_t::H5O_TYPE_GROUP,
        is_dataset: info.type_ == H5O_type_t::H5O_TYPE_DATASET,
        address,
    })
}

/// A call about a chunk of a dataset.
fn done(
    dataset: &hdf5::Dataset,
    first: &[u64],
    call: impl FnOnce() -> std::ffi::c_int,
) -> Result<(), hdf5::Error> {
    if dataset.ndim() != first.len() {
        return Err("a chunk has as many axes as its dataset".into());
    }
    locked(call)
}

/// Calls libhdf5 under the lock of its crate.
fn locked(call: impl FnOnce() -> std::ffi::c_int) -> Result<(), hdf5::Error> {
    hdf5::sync::sync(|| match call() {
        0.. => Ok(()),
        _ => Err(hdf5::Error::query().unwrap_or_else(|_| "libhdf5 does not say why".into())),
    })
}
