#![no_main]

use ishigaki_fuzz::{Target, check};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    check(Target::Recording, data);
});
