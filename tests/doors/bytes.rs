//! An input's bytes, read as values, and random changes of them.

use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use wide::f32x8;

/// Values from bytes, from the front; zeros when there are no more.
#[derive(Clone, Copy)]
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        Bytes(data)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_at(N.min(self.0.len()));
        let mut bytes = [0; N];
        bytes[..head.len()].copy_from_slice(head);
        self.0 = rest;
        bytes
    }

    pub fn byte(&mut self) -> u8 {
        self.array::<1>()[0]
    }

    pub fn half(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.array())
    }

    pub fn long(&mut self) -> u64 {
        u64::from_le_bytes(self.array())
    }

    /// A number below `end`, from one byte.
    pub fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end
    }

    pub fn bit(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    /// A tame number: 1/256ths from -128 to 128.
    pub fn level(&mut self) -> f32 {
        f32::from(i16::from_le_bytes(self.array())) / 256.0
    }

    /// Tame, or of any bits.
    pub fn float(&mut self, tame: bool) -> f32 {
        if tame { self.level() } else { f32::from_bits(self.word()) }
    }

    /// Numbers over and over, from the next `bytes` bytes or what is left: tame or of any bits.
    pub fn cycle(&mut self, bytes: usize, tame: bool) -> Cycle {
        let (mut head, rest) = self.0.split_at(bytes.min(self.0.len()));
        self.0 = rest;
        let mut values = Vec::new();
        while !head.is_empty() {
            let mut bytes = Bytes(head);
            values.push(bytes.float(tame));
            head = bytes.0;
        }
        Cycle { values, next: 0 }
    }
}

/// Numbers in turn from a list, 1 if it is empty.
#[derive(Clone)]
pub struct Cycle {
    values: Vec<f32>,
    next: usize,
}

impl Cycle {
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    pub fn one(&mut self) -> f32 {
        self.next += 1;
        self.values.get(self.next % self.values.len().max(1)).copied().unwrap_or(1.0)
    }

    pub fn rgb(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.one())
    }

    pub fn list(&mut self, length: usize) -> Vec<f32> {
        (0..length).map(|_| self.one()).collect()
    }

    pub fn eight(&mut self) -> f32x8 {
        f32x8::from(std::array::from_fn(|_| self.one()))
    }
}

impl Integrand for Cycle {
    fn radiance(&mut self, _: &Batch8) -> Rgb8 {
        Rgb8 { r: self.eight(), g: self.eight(), b: self.eight() }
    }
}

/// Bits by a linear congruence, the same in every run.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }

    pub fn bytes(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.below(256) as u8).collect()
    }

    /// The input with a few bytes replaced, added or taken away.
    pub fn mutant(&mut self, input: &[u8]) -> Vec<u8> {
        const WORDS: [&[u8]; 8] = [
            &[0],
            &[0xff],
            &[0, 0, 0xc0, 0x7f],
            &[0, 0, 0x80, 0x7f],
            &[0xff, 0xff, 0x7f, 0x7f],
            &[1, 0, 0, 0],
            &[0xff, 0xff, 0xff, 0xff],
            &[0, 0, 0, 0x80],
        ];
        let mut input = input.to_vec();
        for _ in 0..1 + self.below(4) {
            let (start, length) = (self.below(input.len() + 1), self.below(9));
            let end = (start + length).min(input.len());
            let new = match self.below(4) {
                0 => WORDS[self.below(WORDS.len())].to_vec(),
                1 => self.bytes(length),
                2 => self.bytes(end - start),
                _ => Vec::new(),
            };
            input.splice(start..end, new);
        }
        input
    }
}
