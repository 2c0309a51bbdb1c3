//! Numbers of 64 bits that wait in the first words of a plane's part until that is written.

/// Keeps a number in the first two words; what is kept in one has to fit into it.
pub(crate) fn keep(words: &mut [u32], number: u64) {
    let halves = [number as u32, (number >> u32::BITS) as u32];
    words.iter_mut().zip(halves).for_each(|(word, half)| *word = half);
}

/// The number that was kept.
pub(crate) fn kept(words: &[u32]) -> u64 {
    words.iter().take(2).rev().fold(0, |number, word| number << u32::BITS | u64::from(*word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_found() {
        for (length, number) in [(1, 7), (2, u64::MAX), (5, 1 << 40 | 3), (2, 0), (1, u64::from(u32::MAX))] {
            let mut words = [9; 5];
            keep(&mut words[..length], number);
            assert_eq!(kept(&words[..length]), number);
            assert!(words[length.max(2)..].iter().all(|word| *word == 9));
        }
    }
}
