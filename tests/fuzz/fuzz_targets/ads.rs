#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = coaxle_tests::hostile::target("ads").examine(data);
});
