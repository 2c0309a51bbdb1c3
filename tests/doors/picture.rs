//! A file of any bytes as a picture of `error`, or as the denoised one of `guide --with`: an error of one line, or a picture
//! that is what it says.

use pmcip::frame::restore::{Source, restore};
use pmcip::picture::frame_io::{Picture, read_attributes, read_exr, write_exr, write_png};
use pmcip::picture::metrics::measure;
use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;
use tempfile::TempDir;

const SIZE: (u32, u32) = (5, 4);

/// Where files stand, and a frame.
struct Place {
    folder: TempDir,
    frame: Picture,
}

static PLACE: LazyLock<Place> = LazyLock::new(|| Place {
    folder: tempfile::tempdir().expect("there is a temporary folder"),
    frame: frame(),
});

impl Place {
    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// A frame with what `guide` asks for.
fn frame() -> Picture {
    let pixels = (SIZE.0 * SIZE.1) as usize;
    let plane = |scale: f32| (0..pixels).map(|i| scale * (i % 7) as f32).collect::<Vec<f32>>();
    let names = ["unbiased.R", "unbiased.G", "unbiased.B", "variance", "count"];
    Picture {
        width: SIZE.0,
        height: SIZE.1,
        rgb: plane(0.3).into_iter().map(|v| [v, 0.5 * v, 1.0]).collect(),
        planes: names.iter().zip(1..).map(|(name, i)| ((*name).to_owned(), plane(i as f32))).collect(),
        attributes: [("balance_radius", "96"), ("cd_per_unit", "100")]
            .map(|(k, v)| (k.into(), v.into()))
            .into(),
    }
}

/// The bytes of the file.
pub fn check(data: &[u8]) {
    let path = PLACE.file("any.exr");
    fs::write(&path, data).expect("the folder can be written");
    let attributes = read_attributes(&path);
    let picture = match read_exr(&path) {
        Ok(picture) => picture,
        Err(error) => return assert!(!error.to_string().contains('\n'), "{error}"),
    };
    attributes.expect("its head can be read");
    let pixels = picture.width as usize * picture.height as usize;
    assert_eq!(picture.rgb.len(), pixels);
    assert!(picture.planes.values().all(|plane| plane.len() == pixels));
    let one_line = |error: String| assert!(!error.contains('\n'), "{error}");
    match measure(&picture, &picture, 100.0) {
        Ok(metrics) => assert!([metrics.err, metrics.mse, metrics.rel_mse].iter().all(|v| *v == 0.0)),
        Err(error) => {
            assert!(picture.broken_pixels() > 0 || pixels == 0, "{error}");
            one_line(error.to_string());
        }
    }
    for (one, other) in [(&picture, &PLACE.frame), (&PLACE.frame, &picture)] {
        _ = measure(one, other, 100.0).map_err(|error| one_line(error.to_string()));
        let source = |picture| Source { path: &path, picture };
        match restore(source(one), source(other)) {
            Ok(restored) => assert_eq!(restored.rgb.len(), pixels),
            Err(error) => one_line(error.to_string()),
        }
    }
}

/// The frame as EXR and as PNG, and EXR files of every compression that is read, of halves, tiles and layers.
pub fn seeds() -> Vec<Vec<u8>> {
    use exr::prelude::*;
    let (exr_file, png_file) = (PLACE.file("frame.exr"), PLACE.file("frame.png"));
    write_exr(&exr_file, &PLACE.frame).expect("the folder can be written");
    write_png(&png_file, &PLACE.frame, 0.0).expect("the folder can be written");
    let mut seeds = [exr_file, png_file].map(|path| fs::read(path).expect("it was written")).to_vec();
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
    ];
    for (i, compression) in compressions.into_iter().enumerate() {
        let encoding = Encoding {
            compression,
            blocks: if i % 2 == 0 { Blocks::ScanLines } else { Blocks::Tiles(Vec2(4, 3)) },
            line_order: LineOrder::Increasing,
        };
        let value = move |Vec2(x, y): Vec2<usize>| {
            let v = (x * 3 + y) as f32 * 0.1;
            (f16::from_f32(v), f16::from_f32(2.0 * v), f16::from_f32(1.0))
        };
        let channels = SpecificChannels::rgb(value);
        let layer = Layer::new((7, 5), LayerAttributes::named("a"), encoding, channels);
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("memory takes it");
        seeds.push(bytes.into_inner());
    }
    seeds
}
