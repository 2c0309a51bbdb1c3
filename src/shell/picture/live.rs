//! A picture on its way, shown by a viewer: tev (<https://github.com/Tom94/tev>) and what speaks its protocol.
//!
//! A message over TCP begins with its length and its kind, all numbers little endian: kind 4 makes an image of named channels,
//! kind 6 replaces a rectangle of it, channels interleaved or not by offsets and strides into the floats that follow.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// How long a viewer may take to answer or to take in a picture.
const PATIENCE: Duration = Duration::from_secs(5);
/// Pictures are sent no faster than one after another in this time.
const PACE: Duration = Duration::from_millis(250);
/// Rows of a rectangle.
const ROWS: usize = 64;
const CHANNELS: [&str; 3] = ["R", "G", "B"];
const CREATE: u8 = 4;
const UPDATE: u8 = 6;

/// A viewer that shows an image.
#[derive(Debug)]
pub struct Live {
    stream: TcpStream,
    name: String,
    width: usize,
    last: Option<Instant>,
}

impl Live {
    /// Makes a black image of this name in the viewer that listens at `address`, a host and a port.
    ///
    /// # Errors
    /// If nobody listens there, or does not take the image.
    pub fn begin(address: &str, name: &str, (width, height): (u32, u32)) -> io::Result<Live> {
        let mut refused = io::Error::new(io::ErrorKind::NotFound, "no such host");
        for address in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(PATIENCE))?;
                    let (width, height) = (width as usize, height as usize);
                    let mut live = Live { stream, name: name.to_owned(), width, last: None };
                    let create = Message::new(CREATE).byte(1).text(name).int(width).int(height).channels();
                    live.send(create)?;
                    return Ok(live);
                }
                Err(reason) => refused = reason,
            }
        }
        Err(refused)
    }

    /// Whether it is time for the next picture.
    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() >= PACE)
    }

    /// Shows the picture, rows from the top.
    ///
    /// # Errors
    /// If the viewer does not take it.
    pub fn show(&mut self, rgb: &[[f32; 3]]) -> io::Result<()> {
        for (band, rows) in rgb.chunks(ROWS * self.width).enumerate() {
            let (y, height) = (band * ROWS, rows.len() / self.width);
            let message = Message::new(UPDATE).byte(0).text(&self.name).channels();
            let mut message = message.int(0).int(y).int(self.width).int(height);
            for offset in [0, 1, 2] {
                message = message.long(offset);
            }
            for stride in [3, 3, 3] {
                message = message.long(stride);
            }
            self.send(message.floats(rows.as_flattened()))?;
        }
        self.last = Some(Instant::now());
        Ok(())
    }

    fn send(&mut self, message: Message) -> io::Result<()> {
        self.stream.write_all(&message.finished())
    }
}

/// A message being written.
struct Message(Vec<u8>);

impl Message {
    fn new(kind: u8) -> Message {
        Message(vec![0, 0, 0, 0, kind])
    }

    fn byte(mut self, byte: u8) -> Message {
        self.0.push(byte);
        self
    }

    fn text(mut self, text: &str) -> Message {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.byte(0)
    }

    fn int(mut self, number: usize) -> Message {
        self.0.extend((number as i32).to_le_bytes());
        self
    }

    fn long(mut self, number: i64) -> Message {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn channels(self) -> Message {
        CHANNELS.iter().fold(self.int(CHANNELS.len()), |message, name| message.text(name))
    }

    fn floats(mut self, values: &[f32]) -> Message {
        self.0.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        self
    }

    fn finished(mut self) -> Vec<u8> {
        let length = (self.0.len() as u32).to_le_bytes();
        self.0[..4].copy_from_slice(&length);
        self.0
    }
}
