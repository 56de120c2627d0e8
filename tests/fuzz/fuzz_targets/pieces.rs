//! Surfaces by chance, from the whole volume and piece by piece.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| isokit_tests::fuzz::pieces(bytes));
