//! Files with bytes changed to anything, a short run of what the fuzz targets do for long.

mod films;
mod mutant;

use mutant::{GLTF, MTL, OBJ, Place, glb};

/// Bits by a linear congruence, the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }

    /// A word of a film, one of its fields as often as any, and what becomes of it.
    fn change(&mut self) -> (u16, u32) {
        let at = if self.below(2) == 0 { self.below(30) } else { self.below(1 << 16) };
        let word = match self.below(5) {
            0 => 0,
            1 => u32::MAX,
            2 => self.below(64) as u32,
            _ => (self.below(1 << 31) << 1) as u32,
        };
        (at as u16, word)
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

#[test]
fn no_gltf_file_does_harm() {
    let (place, mut random) = (Place::new(), Random(2));
    let binary = glb(GLTF);
    place.load_gltf(GLTF);
    place.load_gltf(&binary);
    for _ in 0..200 {
        place.load_gltf(&random.mutant(GLTF));
        place.load_gltf(&random.mutant(&binary));
    }
}

/// Every number of a glTF file, changed to one that is hardly meant; all ten have been tried once.
#[test]
fn no_number_of_a_gltf_file_does_harm() {
    const NUMBERS: [&str; 10] =
        ["0", "1", "3", "255", "5120", "4294967295", "18446744073709551615", "1e38", "-1", "1e400"];
    let (place, mut random) = (Place::new(), Random(3));
    let text = std::str::from_utf8(GLTF).unwrap();
    let mut start = 0;
    while let Some(at) = text[start..].find(|c: char| c.is_ascii_digit()).map(|at| start + at) {
        let is_digit = |c: char| c.is_ascii_digit() || c == '.';
        let end = text[at..].find(|c| !is_digit(c)).map_or(text.len(), |length| at + length);
        start = end;
        // Numbers in names and in the buffer are none.
        if text[..at].ends_with([':', ',', ' ', '\n', '-']) {
            let number = NUMBERS[random.below(NUMBERS.len())];
            place.load_gltf([&text[..at], number, &text[end..]].concat().as_bytes());
        }
    }
}

#[test]
fn no_film_does_harm() {
    let (films, mut random, mut taken) = (films::sound(), Random(1), 0);
    for film in &films {
        assert!(films::probe(film, &films[1], &[]));
    }
    for round in 0..4000 {
        let film = &films[round % films.len()];
        let changes: Vec<(u16, u32)> = (0..1 + random.below(3)).map(|_| random.change()).collect();
        taken += u32::from(films::probe(film, &films[1], &changes));
    }
    // Most words are numbers of pixels, which may be anything.
    assert!(taken > 1000, "{taken}");
}
