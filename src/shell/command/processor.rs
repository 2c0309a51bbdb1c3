//! Says clearly that a processor is too old, where an unknown instruction would end the program without a word.

/// What this program was compiled for and the processor lacks, in one line.
pub fn missing() -> Option<String> {
    sentence(&required())
}

/// One line about the names whose flag is not set.
fn sentence(instructions: &[(&str, bool)]) -> Option<String> {
    let missing: Vec<&str> =
        instructions.iter().filter(|(_, present)| !present).map(|(name, _)| *name).collect();
    (!missing.is_empty()).then(|| {
        format!(
            "this program was built for processors with {}: build it anew with RUSTFLAGS=\"-C target-cpu=native\"",
            missing.join(", ")
        )
    })
}

/// The instruction sets that the compiler was allowed to use, and whether the processor has each.
fn required() -> Vec<(&'static str, bool)> {
    let mut list: Vec<(&'static str, bool)> = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        macro_rules! check {
            ($($name:tt)*) => {
                $(if cfg!(target_feature = $name) {
                    list.push(($name, std::arch::is_x86_feature_detected!($name)));
                })*
            };
        }
        check!("sse3" "ssse3" "sse4.1" "sse4.2" "popcnt" "avx" "avx2" "fma" "f16c" "bmi1" "bmi2" "lzcnt" "movbe");
    }
    list
}

#[cfg(test)]
mod tests {
    use super::{missing, sentence};

    #[test]
    fn the_processor_of_this_test_has_what_it_needs() {
        assert_eq!(missing(), None);
    }

    #[test]
    fn every_missing_instruction_set_is_named_in_one_line() {
        let line = sentence(&[("avx", true), ("avx2", false), ("fma", false)]).unwrap();
        assert!(line.contains("with avx2, fma:") && !line.contains('\n'), "{line}");
    }
}
