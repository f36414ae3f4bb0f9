//! Compiles what we need of casacore beyond `rubbl_casatables`.

fn main() {
    println!("cargo:rerun-if-changed=src/casa/range.cc");
    #[cfg(feature = "ms")]
    casacore();
}

#[cfg(feature = "ms")]
fn casacore() {
    let headers = std::env::var_os("DEP_CASA_INCLUDE");
    cc::Build::new()
        .cpp(true)
        .flag_if_supported("-std=c++11")
        .flag_if_supported("-Wno-deprecated-declarations")
        // casacore's own headers warn of much.
        .warnings(false)
        // The name that the bundled casacore has for itself.
        .define("casacore", "rubbl_casacore")
        .define("USE_THREADS", "1")
        .include(headers.expect("rubbl_casatables_impl tells where its headers are"))
        .file("src/casa/range.cc")
        .compile("vis2cat_casacore");
    println!("cargo:rustc-link-lib=static=casatables_impl");
}
