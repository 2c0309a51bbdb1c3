//! Has the picture changed? Then [`PICTURE_VERSION`] must have been raised, or references and frames made before would
//! be taken for ones of now.
//!
//! Small pictures, of every kind of material, integrator, sampler and start of a frame, are hashed bit by bit and
//! compared with `tests/picture_version.txt`. When this fails on purpose:
//!
//! 1. raise `PICTURE_VERSION` in `src/shell/frame/version.rs`, unless it is higher already than in the text file;
//! 2. record the new hashes: `PMCIP_RECORD=1 cargo test --test picture_version`.
//!
//! Recording refuses changed bits under an unchanged number, so that neither step can be left out. A picture that is new
//! in the list needs the second only.
//!
//! Bits are those of x86-64 Linux: the loader's spheres and textures go through the system's sine and power. Elsewhere
//! nothing is compared, and the test says so.

use pmcip::animation::startup::Predictor;
use pmcip::frame::render::{Frame, render, render_next};
use pmcip::frame::settings::{Integrator, Method, Settings, Startup};
use pmcip::frame::version::PICTURE_VERSION;
use pmcip::scene::load;
use pmcip_core::sampler::estimate::Estimator;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Recorded hashes by picture.
type Hashes = BTreeMap<String, String>;

const SIDE: u32 = 24;

/// A mirror, a ball of glass, glossy metal and a wall with a texture under a lamp.
const KINDS: &str = "[camera]\nfrom = [0, 0, 6]\nat = [0, 0, 0]\nfov = 40\n[[meshes]]\nfile = \"wall.obj\"\n\
    [[spheres]]\ncenter = [-1.2, -0.5, 0]\nradius = 0.6\nsubdivisions = 2\nmaterial = \"mirror\"\n\
    [[spheres]]\ncenter = [0, 0.3, 1]\nradius = 0.6\nsubdivisions = 2\nmaterial = \"glass\"\n\
    [[spheres]]\ncenter = [1.2, -0.5, 0]\nradius = 0.6\nsubdivisions = 2\nmaterial = \"metal\"\n\
    [[lights]]\ncenter = [0, 3, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 8, 7]\n\
    [materials.mirror]\nkind = \"mirror\"\n[materials.glass]\nkind = \"glass\"\nior = 1.5\n\
    [materials.metal]\ndiffuse = [0.1, 0.1, 0.1]\nspecular = [0.8, 0.6, 0.3]\nroughness = 0.3\n";
const WALL: &str = "mtllib wall.mtl\nv -3 -2 -1\nv 3 -2 -1\nv 3 2 -1\nv -3 2 -1\nvt 0 0\nvt 3 0\nvt 3 2\nvt 0 2\n\
    usemtl wall\nf 1/1 2/2 3/3 4/4\n";

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

/// A scene of every kind of material, in `folder`.
fn kinds(folder: &Path) -> PathBuf {
    fs::write(folder.join("wall.obj"), WALL).unwrap();
    fs::write(folder.join("wall.mtl"), "newmtl wall\nKd 1 1 1\nmap_Kd wall.png\n").unwrap();
    let texture = image::RgbImage::from_fn(4, 4, |x, y| image::Rgb([40 * x as u8, 60 * y as u8, 120]));
    texture.save(folder.join("wall.png")).unwrap();
    fs::write(folder.join("kinds.toml"), KINDS).unwrap();
    folder.join("kinds.toml")
}

/// The same under sun and sky, through a lens.
fn outside(folder: &Path) -> PathBuf {
    let lens = KINDS.replace(
        "fov = 40",
        "fov = 40\naperture = 0.2\n[sky]\nsun = [1, 2, 3]\nrotate = [0, 20, 0]\nscale = 0.01",
    );
    fs::write(folder.join("outside.toml"), lens).unwrap();
    folder.join("outside.toml")
}

/// Hash of the bits of a frame's planes, and of what it was predicted to be.
fn hash(frame: &Frame, predictor: &Predictor) -> String {
    let beliefs = predictor.prediction().map_or(&[][..], |prediction| &prediction.beliefs);
    let beliefs = beliefs.iter().flat_map(|b| [b.variance, b.light, b.freedom]);
    let floats = frame.rgb.as_flattened().iter().chain(&frame.variance).copied().chain(beliefs);
    let mut hash = blake3::Hasher::new();
    floats.map(f32::to_bits).chain(frame.count.iter().copied()).for_each(|word| {
        hash.update(&word.to_le_bytes());
    });
    hash.finalize().to_hex()[..32].to_owned()
}

/// Still pictures by every integrator and sampler, and filtered.
fn stills(hashes: &mut Hashes) {
    let folder = tempfile::tempdir().unwrap();
    let scenes = [
        ("cornell", repository().join("scenes/cornell.toml")),
        ("caustic", repository().join("scenes/caustic.toml")),
        ("kinds", kinds(folder.path())),
        ("outside", outside(folder.path())),
    ];
    let integrators = [
        Integrator::Path,
        Integrator::Direct { light_samples: 2, bsdf_samples: 1 },
        Integrator::Gather { photons: 2_000, photon_seed: 5 },
    ];
    for (name, file) in scenes {
        let scene = load(&file).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        for integrator in integrators {
            for method in [Method::Uniform, Method::Pmc, Method::Paper] {
                let mut settings = Settings::new(&scene, method, Some(6), Some((SIDE, SIDE)));
                (settings.integrator, settings.sampler.seed) = (integrator, 3);
                let frame = render(&scene, &settings, Some(1), &|_| ()).unwrap();
                hashes.insert(
                    format!("{name} {} {method}", integrator.name()),
                    hash(&frame, &Predictor::default()),
                );
            }
        }
        let mut settings = Settings::new(&scene, Method::Pmc, Some(6), Some((SIDE, SIDE)));
        settings.set_estimator(Estimator::Guided);
        let frame = render(&scene, &settings, Some(1), &|_| ()).unwrap();
        hashes.insert(format!("{name} guided"), hash(&frame, &Predictor::default()));
    }
}

/// The third frame of a moving camera, by every start.
fn frames(hashes: &mut Hashes) {
    let mut scene = load(&repository().join("scenes/cornell.toml")).unwrap();
    let from = scene.view.from;
    for startup in [Startup::Uniform, Startup::Motion, Startup::Homography] {
        let mut predictor = Predictor::default();
        for number in 0..3 {
            scene.view.from[0] = from[0] + 4.0 * number as f32;
            let mut settings = Settings::new(&scene, Method::Pmc, Some(16), Some((2 * SIDE, 2 * SIDE)));
            (settings.startup, settings.sampler.frame) = (startup, number);
            let frame = render_next(&scene, &settings, Some(1), &|_| (), &mut predictor).unwrap();
            hashes.insert(
                format!("cornell moving, start {startup:?}").to_lowercase(),
                hash(&frame, &predictor),
            );
        }
    }
}

/// The version and the hashes of a record.
fn parse(text: &str) -> (u32, Hashes) {
    let mut lines = text.lines();
    let version = lines.next().and_then(|line| line.strip_prefix("PICTURE_VERSION ")?.parse().ok());
    let hash = |line: &str| line.split_once(": ").map(|(name, hash)| (name.to_owned(), hash.to_owned()));
    (version.unwrap_or(0), lines.filter_map(hash).collect())
}

fn format(hashes: &Hashes) -> String {
    let lines = hashes.iter().map(|(name, hash)| format!("{name}: {hash}\n"));
    format!("PICTURE_VERSION {PICTURE_VERSION}\n{}", lines.collect::<String>())
}

/// What is to be done about pictures of now.
#[derive(Debug, PartialEq)]
enum Demand {
    Nothing,
    /// Their bits are to be recorded.
    Record,
    /// The number is to be raised first, since these pictures have changed.
    Raise(Vec<String>),
}

fn demand(recorded: &(u32, Hashes), version: u32, now: &Hashes) -> Demand {
    let (before, hashes) = recorded;
    let changed = now.iter().filter(|(name, hash)| hashes.get(*name).is_some_and(|before| before != *hash));
    let changed: Vec<String> = changed.map(|(name, _)| name.clone()).collect();
    match (version == *before && hashes == now, changed.is_empty()) {
        (true, _) => Demand::Nothing,
        (_, false) if version <= *before => Demand::Raise(changed),
        _ => Demand::Record,
    }
}

#[test]
fn changed_pictures_have_another_version() {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        println!("skipped: the recorded bits are those of x86-64 Linux");
        return;
    }
    let mut now = Hashes::new();
    stills(&mut now);
    frames(&mut now);
    let file = repository().join("tests/picture_version.txt");
    let recorded = parse(&fs::read_to_string(&file).unwrap_or_default());
    let record = "record by `PMCIP_RECORD=1 cargo test --test picture_version`";
    match demand(&recorded, PICTURE_VERSION, &now) {
        Demand::Nothing => {}
        Demand::Record if std::env::var_os("PMCIP_RECORD").is_some() => {
            fs::write(&file, format(&now)).unwrap();
        }
        Demand::Record => panic!("new pictures or a new number: {record}; they are\n{}", format(&now)),
        Demand::Raise(changed) => panic!(
            "the picture changed: raise PICTURE_VERSION in src/shell/frame/version.rs above {} and {record}; changed are {}",
            recorded.0,
            changed.join(", ")
        ),
    }
}

/// The reminder itself: which changes it lets pass, and which not.
#[test]
fn a_changed_picture_is_refused_until_the_number_is_raised_and_recorded() {
    let hashes = |list: &[(&str, &str)]| -> Hashes {
        list.iter().map(|(name, hash)| ((*name).to_owned(), (*hash).to_owned())).collect()
    };
    let recorded = (4, hashes(&[("a", "1"), ("b", "2")]));
    let same = recorded.1.clone();
    assert_eq!(demand(&recorded, 4, &same), Demand::Nothing);
    let changed = hashes(&[("a", "1"), ("b", "3")]);
    for version in [3, 4] {
        assert_eq!(demand(&recorded, version, &changed), Demand::Raise(vec!["b".into()]));
    }
    for (version, now) in [(5, changed), (5, same), (4, hashes(&[("a", "1"), ("b", "2"), ("c", "3")]))] {
        assert_eq!(demand(&recorded, version, &now), Demand::Record);
    }
    assert_eq!(parse(&format(&recorded.1)), (PICTURE_VERSION, recorded.1));
}
