//! `render --live`: the bytes that a viewer gets.

mod program;

use pmcip::picture::frame_io::read_exr;
use program::{failure, pmcip};
use std::fs;
use std::io::Read;
use std::net::TcpListener;

const ROOM: &str = "[film]\nwidth = 37\nheight = 70\n[camera]\nfrom = [0, 0, 5]\nat = [0, 0, 0]\nfov = 40\n\
    [[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 2\nmaterial = \"m\"\n\
    [[lights]]\ncenter = [0, 4, 2]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\nradiance = [9, 9, 9]\n[materials.m]\n";

/// A message, taken apart from the front.
struct Message<'a>(&'a [u8]);

impl Message<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (front, rest) = self.0.split_first_chunk().unwrap();
        self.0 = rest;
        *front
    }

    fn int(&mut self) -> i32 {
        i32::from_le_bytes(self.take())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap();
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }

    fn channels(&mut self) -> Vec<String> {
        (0..self.int()).map(|_| self.text()).collect()
    }
}

/// The protocol as tev's `include/tev/Ipc.h` has it; the last picture shown is the one that is written.
#[test]
fn a_viewer_gets_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("room.toml"), ROOM).unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        bytes
    });
    let done = pmcip(folder.path(), &format!("render room.toml --spp 32 --live {address} --quiet"));
    assert!(done.status.success() && done.stderr.is_empty());
    let bytes = viewer.join().unwrap();
    let (mut rest, mut picture, mut updates) = (&bytes[..], vec![[-1.0f32; 3]; 37 * 70], 0);
    while !rest.is_empty() {
        let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
        let mut message = Message(&rest[5..length]);
        let kind = rest[4];
        rest = &rest[length..];
        message.take::<1>();
        assert_eq!(message.text(), "room.exr");
        if kind == 4 {
            assert_eq!((message.int(), message.int()), (37, 70));
            assert_eq!(message.channels(), ["R", "G", "B"]);
            assert!(message.0.is_empty() && updates == 0);
            continue;
        }
        assert_eq!(kind, 6);
        updates += 1;
        assert_eq!(message.channels(), ["R", "G", "B"]);
        let [x, y, width, height] = [message.int(), message.int(), message.int(), message.int()];
        let mut longs = || [0; 3].map(|_| i64::from_le_bytes(message.take()));
        assert_eq!((x, width, longs(), longs()), (0, 37, [0, 1, 2], [3, 3, 3]));
        assert_eq!(message.0.len(), (12 * width * height) as usize);
        for pixel in &mut picture[(y * width) as usize..][..(width * height) as usize] {
            *pixel = [0; 3].map(|_| f32::from_le_bytes(message.take()));
        }
    }
    assert!(updates >= 2 && updates % 2 == 0, "{updates} rectangles");
    assert!(picture == read_exr(&folder.path().join("room.exr")).unwrap().rgb);
}

#[test]
fn a_viewer_that_is_not_there_is_an_error_and_one_that_leaves_is_not() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("room.toml"), ROOM).unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = std::thread::spawn(move || drop(listener.accept().unwrap()));
    let more = "--spp 2000 --iterations 400";
    let done = pmcip(folder.path(), &format!("render room.toml {more} --live {address} --quiet"));
    assert!(done.status.success());
    viewer.join().unwrap();
    // Nobody listens there any more.
    failure(folder.path(), &format!("render room.toml --live {address}"), 2, "--live 127.0.0.1:");
    failure(folder.path(), "render room.toml --live nowhere", 2, "--live nowhere: ");
}
