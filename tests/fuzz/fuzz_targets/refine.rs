//! Surfaces by chance, divided and balanced.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| isokit_tests::fuzz::refine(bytes));
