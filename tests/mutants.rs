//! Files with bytes changed to anything, a short run of what the fuzz targets do for long.
//!
//! `PMCIP_MUTANTS=N` makes N times as many mutants, others for every N; `--nocapture` shows how many each test tried.

mod doors;
mod mutant;

use doors::bytes::Random;
use doors::films;
use mutant::{GLTF, MTL, OBJ, Place, TOML, glb};
use std::env;
use std::fs;
use std::panic::catch_unwind;
use std::path::Path;

/// A word of a film, one of its fields as often as any, and what becomes of it.
fn change(random: &mut Random) -> (u16, u32) {
    let at = if random.below(2) == 0 { random.below(30) } else { random.below(1 << 16) };
    let word = match random.below(5) {
        0 => 0,
        1 => u32::MAX,
        2 => random.below(64) as u32,
        _ => (random.below(1 << 31) << 1) as u32,
    };
    (at as u16, word)
}

/// A file with a few bytes replaced, doubled or taken away.
fn mutant(random: &mut Random, file: &[u8]) -> Vec<u8> {
    const WORDS: [&[u8]; 10] =
        [b"nan", b"-1", b"1e39", b"0", b"/", b"\n", b"\\\n", b"4294967296", b"\xff", b" "];
    let mut file = file.to_vec();
    for _ in 0..1 + random.below(4) {
        let (start, length) = (random.below(file.len() + 1), random.below(5));
        let end = (start + length).min(file.len());
        let word = WORDS[random.below(WORDS.len())].to_vec();
        file.splice(start..end, if random.below(3) == 0 { Vec::new() } else { word });
    }
    file
}

/// How many times as many mutants are tried as in CI.
fn times() -> usize {
    env::var("PMCIP_MUTANTS").map_or(1, |times| times.parse().expect("PMCIP_MUTANTS is a whole number"))
}

/// Mutants of something by their number, other ones the more of them there are, and said how many they were.
fn try_mutants(name: &str, runs: usize, seed: u64, mut try_one: impl FnMut(usize, &mut Random)) {
    let (runs, mut random) = (runs * times(), Random(seed + times() as u64 - 1));
    (0..runs).for_each(|i| try_one(i, &mut random));
    println!("{name}: {runs} mutants tried");
}

/// Seeds of a door, inputs that were found once, and so many mutants of seeds.
fn try_door(name: &str, runs: usize) {
    let door = doors::ALL.iter().find(|door| door.name == name).expect("a door");
    let try_input = |input: &[u8]| {
        if catch_unwind(|| (door.check)(input)).is_err() {
            panic!("door {name}, input {input:02x?}");
        }
    };
    let seeds = (door.seeds)();
    seeds.iter().for_each(|seed| try_input(seed));
    doors::FOUND.iter().filter(|(of, _)| *of == name).for_each(|(_, input)| try_input(input));
    try_mutants(name, runs, 1, |i, random| {
        let once = random.mutant(&seeds[i % seeds.len()]);
        try_input(&if i % 3 == 0 { random.mutant(&once) } else { once });
    });
}

#[test]
fn no_file_does_harm() {
    let place = Place::new();
    place.load(OBJ, MTL, &place.picture);
    try_mutants("obj, mtl, texture", 1200, 1, |i, random| match i % 3 {
        0 => place.load(&mutant(random, OBJ), MTL, &place.picture),
        1 => place.load(OBJ, &mutant(random, MTL), &place.picture),
        _ => place.load(OBJ, MTL, &mutant(random, &place.picture)),
    });
}

#[test]
fn no_scene_file_does_harm() {
    let place = Place::new();
    place.load_toml(TOML);
    try_mutants("toml", 400, 4, |_, random| place.load_toml(&mutant(random, TOML)));
}

/// A file that never ends is not read.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused() {
    let mesh = String::from_utf8_lossy(TOML).replace("s.obj", "/dev/zero");
    let sky = "[sky]\nfile = \"zero.exr\"\n";
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.exr")).unwrap();
    for text in [mesh.as_str(), sky] {
        let file = folder.path().join("s.toml");
        fs::write(&file, text).unwrap();
        let message = pmcip::scene::load(&file).unwrap_err().to_string();
        assert!(message.ends_with("no regular file"), "{message}");
    }
}

#[test]
fn no_gltf_file_does_harm() {
    let (place, binary) = (Place::new(), glb(GLTF));
    place.load_gltf(GLTF);
    place.load_gltf(&binary);
    try_mutants("gltf", 400, 2, |i, random| {
        place.load_gltf(&mutant(random, if i % 2 == 0 { GLTF } else { &binary }));
    });
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
    let (films, mut taken) = (films::sound(), 0);
    for film in &films {
        assert!(films::probe(film, &films[1], &[]));
    }
    try_mutants("words of films", 4000, 1, |i, random| {
        let changes: Vec<(u16, u32)> = (0..1 + random.below(3)).map(|_| change(random)).collect();
        taken += usize::from(films::probe(&films[i % films.len()], &films[1], &changes));
    });
    // Most words are numbers of pixels, which may be anything.
    assert!(taken > 1000 * times(), "{taken}");
}

#[test]
fn nothing_comes_through_door_allocate() {
    try_door("allocate", 100_000);
}

#[test]
fn nothing_comes_through_door_weights() {
    try_door("weights", 3_000);
}

#[test]
fn nothing_comes_through_door_merge() {
    try_door("merge", 10_000);
}

#[test]
fn nothing_comes_through_door_estimate() {
    try_door("estimate", 4_000);
}

#[test]
fn nothing_comes_through_door_guide() {
    try_door("guide", 100);
}

#[test]
fn nothing_comes_through_door_homography() {
    try_door("homography", 40_000);
}

#[test]
fn nothing_comes_through_door_features() {
    try_door("features", 6_000);
}

#[test]
fn nothing_comes_through_door_predict() {
    try_door("predict", 4_000);
}

#[test]
fn nothing_comes_through_door_hierarchy() {
    try_door("hierarchy", 100_000);
}

#[test]
fn nothing_comes_through_door_scene() {
    try_door("scene", 10_000);
}

#[test]
fn nothing_comes_through_door_film() {
    try_door("film", 10_000);
}

#[test]
fn nothing_comes_through_door_capi() {
    try_door("capi", 8_000);
}

#[test]
fn nothing_comes_through_door_picture() {
    try_door("picture", 2_000);
}

/// Writes inputs to begin with for all fuzz targets to where `cargo fuzz run` looks for them: see CONTRIBUTING.md.
#[test]
#[ignore = "writes to fuzz/corpus"]
fn seeds_become_files() {
    let place = Place::new();
    let files = [
        ("obj", OBJ),
        ("mtl", MTL),
        ("texture", &place.picture),
        ("gltf", GLTF),
        ("gltf", &glb(GLTF)),
        ("toml", TOML),
    ];
    let files = files.map(|(name, file)| (name, file.to_vec()));
    let doors = doors::ALL.iter().flat_map(|door| (door.seeds)().into_iter().map(|seed| (door.name, seed)));
    let found = doors::FOUND.iter().map(|(name, input)| (*name, input.to_vec()));
    for (number, (name, input)) in files.into_iter().chain(doors).chain(found).enumerate() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(name);
        fs::create_dir_all(&folder).expect("the folder can be made");
        fs::write(folder.join(format!("seed-{number}")), input).expect("it can be written");
    }
}
