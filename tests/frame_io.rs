//! Pictures survive the disk, other programs' files can be read, and a failed write leaves nothing behind.

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, Vec2, WritableImage, f16,
};
use pmcip::picture::frame_io::{Picture, read_exr, write_exr, write_png};
use std::fs;
use std::path::Path;

fn picture() -> Picture {
    let (width, height) = (37, 19);
    let pixels = width * height;
    let plane = |scale: f32| (0..pixels).map(|i| i as f32 * scale).collect::<Vec<f32>>();
    let names = ["variance", "count", "kernel.weight"];
    let settings = ["seed", "spp", "estimator", "gamma", "scene", "cd_per_unit", "max_depth"];
    Picture {
        width,
        height,
        rgb: (0..pixels).map(|i| [i as f32, 1e-30 * i as f32, -0.5]).collect(),
        planes: names.iter().enumerate().map(|(i, name)| ((*name).into(), plane(i as f32 + 0.1))).collect(),
        attributes: settings.iter().map(|name| ((*name).into(), format!("{name} of a «scene»"))).collect(),
    }
}

#[test]
fn exr_gives_back_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_exr(&path, &picture()).unwrap();
    assert_eq!(read_exr(&path).unwrap(), picture());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn the_same_picture_makes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<Vec<u8>> = (0..8)
        .map(|i| {
            let path = folder.path().join(format!("{i}.exr"));
            write_exr(&path, &picture()).unwrap();
            fs::read(path).unwrap()
        })
        .collect();
    assert!(files.windows(2).all(|pair| pair[0] == pair[1]));
}

fn foreign(path: &Path, names: [&str; 3], blocks: Blocks) {
    let plane =
        |value: f32| FlatSamples::F16((0..70 * 40).map(|i| f16::from_f32(value + (i % 70) as f32)).collect());
    let channels = names.into_iter().zip([1.0, 100.0, 200.0]);
    let channels = channels.map(|(name, value)| AnyChannel::new(name, plane(value)));
    let depth = AnyChannel::new("Z", FlatSamples::F32(vec![1.0; 70 * 40]));
    let channels = AnyChannels::sort(channels.chain([depth]).collect());
    let encoding = Encoding { compression: Compression::PIZ, blocks, line_order: LineOrder::Increasing };
    let layer = Layer::new((70, 40), LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

#[test]
fn half_floats_tiles_and_prefixed_names_of_other_programs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("foreign.exr");
    for (names, blocks) in [
        (["R", "G", "B"], Blocks::ScanLines),
        (["R", "G", "B"], Blocks::Tiles(Vec2(16, 16))),
        (["View.R", "View.G", "View.B"], Blocks::ScanLines),
    ] {
        foreign(&path, names, blocks);
        let read = read_exr(&path).unwrap();
        assert_eq!((read.width, read.height), (70, 40));
        assert_eq!(read.rgb[70 * 3 + 5], [6.0, 105.0, 205.0]);
        assert!(read.attributes.is_empty());
        assert_eq!(read.planes["Z"][0], 1.0);
    }
}

#[test]
fn unreadable_files_are_named_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.exr");
    let message = |path: &Path| read_exr(path).unwrap_err().to_string();
    assert!(message(&path).ends_with("bad.exr: no such file or folder"));
    write_exr(&path, &picture()).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in [0, 3, 100, whole.len() / 2] {
        fs::write(&path, &whole[..length]).unwrap();
        let message = message(&path);
        assert!(message.contains("bad.exr: ") && !message.contains('\n'), "{length}: {message}");
    }
    foreign(&path, ["X", "Y", "Q"], Blocks::ScanLines);
    assert!(message(&path).ends_with("bad.exr: it has no channels R, G and B"));
}

#[test]
fn damaged_files_give_a_picture_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.exr");
    write_exr(&path, &picture()).unwrap();
    let whole = fs::read(&path).unwrap();
    for at in 0..600 {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x55;
        fs::write(&path, damaged).unwrap();
        if let Err(error) = read_exr(&path) {
            assert!(!error.to_string().contains('\n'));
        }
    }
}

#[test]
fn a_failed_write_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("taken.exr");
    fs::create_dir(&taken).unwrap();
    assert!(write_exr(&taken, &picture()).unwrap_err().to_string().contains("taken.exr"));
    assert!(write_png(&folder.path().join("none/a.png"), &picture(), 0.0).is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn png_is_exposed_srgb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let rgb = vec![[0.0, 0.001, 0.25], [1.0, 7.0, f32::NAN], [-1.0, 0.5, f32::INFINITY]];
    let picture = Picture { width: 3, height: 1, rgb, ..Picture::default() };
    let pixels = |exposure| {
        write_png(&path, &picture, exposure).unwrap();
        image::open(&path).unwrap().into_rgb8().into_raw()
    };
    assert_eq!(pixels(0.0), [0, 3, 137, 255, 255, 0, 0, 188, 255]);
    assert_eq!(pixels(1.0), [0, 7, 188, 255, 255, 0, 0, 255, 255]);
}
