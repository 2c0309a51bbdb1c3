//! Files with bytes changed to anything, a short run of what the fuzz targets do for long.

mod mutant;

use mutant::{MTL, OBJ, Place};

/// Bits by a linear congruence, the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }

    /// A file with a few bytes replaced, doubled or taken away.
    fn mutant(&mut self, file: &[u8]) -> Vec<u8> {
        const WORDS: [&[u8]; 10] =
            [b"nan", b"-1", b"1e39", b"0", b"/", b"\n", b"\\\n", b"4294967296", b"\xff", b" "];
        let mut file = file.to_vec();
        for _ in 0..1 + self.below(4) {
            let (start, length) = (self.below(file.len() + 1), self.below(5));
            let end = (start + length).min(file.len());
            let word = WORDS[self.below(WORDS.len())].to_vec();
            file.splice(start..end, if self.below(3) == 0 { Vec::new() } else { word });
        }
        file
    }
}

#[test]
fn no_file_does_harm() {
    let (place, mut random) = (Place::new(), Random(1));
    place.load(OBJ, MTL, &place.picture);
    for _ in 0..400 {
        place.load(&random.mutant(OBJ), MTL, &place.picture);
        place.load(OBJ, &random.mutant(MTL), &place.picture);
        place.load(OBJ, MTL, &random.mutant(&place.picture));
    }
}
