//! Volumes and options by chance.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| isokit_tests::fuzz::extract(bytes));
