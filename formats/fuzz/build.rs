//! Has libhdf5 of the target `uvh5` ask us, and not itself, for checksums.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-link-arg-bin=uvh5=-Wl,--wrap=H5F_get_checksums");
}
