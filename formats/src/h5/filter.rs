//! Filters: whether we can undo what chunks went through.

use hdf5::filters::Filter;
use hdf5::plist::DatasetCreate;

/// Numbers and names of filters that are seen in visibility files but are not part of HDF5 (The HDF
/// Group, "Registered Filter Plugins").
const KNOWN: [(i32, &str); 8] = [
    (307, "bzip2"),
    (32000, "LZF"),
    (32001, "Blosc"),
    (32004, "LZ4"),
    (32008, "bitshuffle"),
    (32013, "ZFP"),
    (32015, "Zstandard"),
    (32026, "Blosc2"),
];

/// The filters of a dataset, in the order in which they were applied.
pub(super) fn pipeline(plist: &DatasetCreate) -> Result<Vec<Filter>, String> {
    plist
        .get_filters()
        .map_err(|error| format!("its filters are not understood ({error})"))
}

/// Whether all of them can be undone; says what to do where not.
pub(super) fn check(filters: &[Filter]) -> Result<(), String> {
    for filter in filters {
        if !(filter.is_available() && filter.decode_enabled()) {
            return Err(not_there(filter.id()));
        }
    }
    Ok(())
}

fn not_there(id: i32) -> String {
    let name = (KNOWN.iter().find(|(number, _)| *number == id)).map_or_else(
        || format!("filter {id}"),
        |(_, name)| format!("{name} (filter {id})"),
    );
    format!(
        "is compressed with {name}, which is not built in; let HDF5_PLUGIN_PATH name a folder with \
         its plugin (as in the Python package hdf5plugin) or rewrite the file with h5repack -f GZIP=1"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_is_named_and_a_way_out_given() {
        let what = check(&[Filter::user(32008, &[0, 2])]).unwrap_err();
        assert!(what.starts_with("is compressed with bitshuffle (filter 32008), "));
        assert!(what.contains("HDF5_PLUGIN_PATH"));
        let what = check(&[Filter::user(31999, &[])]).unwrap_err();
        assert!(what.starts_with("is compressed with filter 31999, "));
    }

    #[test]
    fn what_is_built_in_can_be_undone() {
        let filters = [
            Filter::shuffle(),
            Filter::deflate(1),
            Filter::lzf(),
            Filter::fletcher32(),
        ];
        assert_eq!(check(&filters), Ok(()));
    }
}
