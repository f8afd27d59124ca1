//! The diagnosis of a configuration for the page docs/demo.md: a text in, JSON out. It needs no files, clocks or threads.
//!
//! The page calls the functions of `memory`, which the build for `wasm32-unknown-unknown` exports.

mod answer;
mod expression;
#[cfg(target_arch = "wasm32")]
mod memory;
mod typed;

pub use answer::answer;
