//! Names the shared library as it is installed.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let on =
        |variable: &str, value: &str| std::env::var(variable).is_ok_and(|found| found == value);
    if on("CARGO_CFG_TARGET_OS", "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libsymplint.so.0");
    } else if on("CARGO_CFG_TARGET_OS", "macos") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libsymplint.0.dylib");
    }
}
