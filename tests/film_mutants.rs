//! A short run of what the fuzz target `film` does for long.

mod films;

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

#[test]
fn no_film_does_harm() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let (films, mut taken) = (films::sound(), 0);
    for film in &films {
        assert!(films::probe(film, &films[1], &[]));
    }
    for round in 0..4000 {
        let film = &films[round % films.len()];
        // What the fields are by place, and anything anywhere.
        let place = |bits: u64| if bits & 1 == 0 { (bits >> 8) as u16 % 30 } else { (bits >> 8) as u16 };
        let word = |bits: u64| match bits % 5 {
            0 => 0,
            1 => u32::MAX,
            2 => (bits >> 40) as u32 % 64,
            _ => (bits >> 32) as u32,
        };
        let count = 1 + random.next_u64() % 3;
        let changes: Vec<(u16, u32)> =
            (0..count).map(|_| (place(random.next_u64()), word(random.next_u64()))).collect();
        taken += u32::from(films::probe(film, &films[1], &changes));
    }
    // Most words are numbers of pixels, which may be anything.
    assert!(taken > 1000, "{taken}");
}
