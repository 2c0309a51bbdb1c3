//! Mesh, material and picture files of any bytes: loading them must end, without a panic, in an error of one line or in a
//! scene that the core accepts. Shared with the fuzz targets `obj`, `mtl`, `texture`, `gltf` and `toml`.

use pmcip::scene::{Animation, LightChoice, Options};
use pmcip_core::tracer::scene::Scene;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Statements of all kinds.
pub const OBJ: &[u8] =
    b"mtllib s.mtl\nv 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0.5\nv 0 1 0\nv .4 .5 0\nvt 0 0\nvt 1 .5\nvn 0 0 1\n\
    usemtl m # one\nf 1/1/1 2/2 3//1 4 \\\n 5\nusemtl n\nf -1 -2 -3\nl 1 2\n#MRGB ff00ff00\nf 2 4 5\n";
/// Statements of all kinds.
pub const MTL: &[u8] = b"newmtl m\nKd .5 .5 .5\nKs .1\nNs 20\nd .5\nTr .5\nTf 1 1 1\nNi 1.5\nillum 4\nmap_Kd -s 2 2 2 -clamp on t.png\n\
    map_d t.png -bm 1\nmap_Bump b.png\nnewmtl n\nKe 1 2 3\nmap_Ke -o 1 t.png\nPr .5\nPm 1\n";

/// Tables of all kinds.
pub const TOML: &[u8] = b"[film]\nwidth = 8\nheight = 6\nexposure = 1\n[render]\nspp = 4\n[frames]\nfirst = 1\nlast = 9\n\
    [camera]\nfrom = [0, 0, 6]\nat = [0, 0, 0]\nfov = 40\naperture = 0.1\n\
    keys = [{ frame = 1, from = [0, 1, 6], at = [0, 0, 0] }, { frame = 9, from = [1, 0, 5], at = [0, 0, 1] }]\n\
    [sky]\ncolor = [1, 2, 3]\nscale = 0.01\nrotate = [0, 20, 0]\n[[meshes]]\nfile = \"s.obj\"\nscale = 2\n\
    [[spheres]]\ncenter = [0, 0, 1]\nradius = 0.5\nsubdivisions = 1\nmaterial = \"m\"\n\
    [[lights]]\ncenter = [0, 3, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 8, 7]\n\
    [materials.m]\nkind = \"glass\"\nior = 1.5\n[materials.n]\ndiffuse = [0.1, 0.2, 0.3]\nroughness = 0.3\n";

/// Nodes, meshes, materials, lights, animations of all kinds, the buffer within.
pub const GLTF: &[u8] = include_bytes!("scene.gltf");

/// The same as binary glTF, the buffer still within its JSON.
pub fn glb(text: &[u8]) -> Vec<u8> {
    let word = |n: usize| (n as u32).to_le_bytes();
    [b"glTF".as_slice(), &word(2), &word(20 + text.len()), &word(text.len()), b"JSON", text].concat()
}

/// Where files stand while they are loaded.
pub struct Place {
    folder: TempDir,
    /// The bytes of a picture with alpha.
    pub picture: Vec<u8>,
}

impl Place {
    /// A folder of its own.
    pub fn new() -> Place {
        Place { folder: tempfile::tempdir().expect("there is a temporary folder"), picture: picture() }
    }

    /// Loads these files in both ways.
    pub fn load(&self, obj: &[u8], mtl: &[u8], picture: &[u8]) {
        let files = [("s.obj", obj), ("s.mtl", mtl), ("t.png", picture)];
        load(self.folder.path(), &files, |_| ());
    }

    /// Loads a glTF file in both ways, and goes through frames of it.
    pub fn load_gltf(&self, bytes: &[u8]) {
        load(self.folder.path(), &[("s.gltf", bytes)], seek);
    }

    /// Loads a scene file in both ways, and goes through frames of it.
    pub fn load_toml(&self, bytes: &[u8]) {
        let files = [("s.toml", bytes), ("s.obj", OBJ), ("s.mtl", MTL), ("t.png", &self.picture)];
        load(self.folder.path(), &files, seek);
    }
}

/// Goes through frames.
fn seek(animation: &mut Animation) {
    for frame in [0, 7, 1 << 20] {
        match animation.seek(frame) {
            Ok(_) => assert_eq!(Scene::new(animation.scene().data()).err(), None),
            Err(error) => return assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
}

fn picture() -> Vec<u8> {
    let pixels =
        image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([80 * x as u8, 200 * y as u8, 90, 127 * x as u8]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::DynamicImage::ImageRgba8(pixels)
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("memory takes it");
    bytes.into_inner()
}

fn load(folder: &Path, files: &[(&str, &[u8])], go_on: impl Fn(&mut Animation)) {
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).expect("the folder can be written");
    }
    for (strict, light) in [(false, LightChoice::Auto), (true, LightChoice::Own)] {
        let options = Options { strict, light, ..Options::default() };
        match Animation::open(&folder.join(files[0].0), &options) {
            Ok(mut animation) => {
                assert_eq!(Scene::new(animation.scene().data()).err(), None);
                go_on(&mut animation);
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
}
