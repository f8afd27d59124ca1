#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| symplint_fuzz::evidence::evidence(data));
