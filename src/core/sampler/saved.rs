//! A sampler without its memory, for those who own both; and films as bytes.
//!
//! [`Sampler::state`] is what a sampler knows beyond the memory it was lent; [`Sampler::resume`] puts both together again, in
//! the middle of an iteration, too. So an object can own the memory and a [`State`] where Rust does not let it own a
//! `Sampler` of its own memory.
//!
//! [`Sampler::save`] writes a film as bytes, also in the middle of an iteration, [`Saved`] reads them: a header of eight
//! letters, the version of the format and a check sum, then settings, progress and planes. All words are little endian on
//! every machine. What goes on after that has the same bits as if it had never been interrupted.

use super::allocate::{MAX_SAMPLES, Mixture};
use super::fair::Fair;
use super::film::{Layout, Planes, WORDS};
use super::kernel::{Criterion, Window};
use super::state::State;
use super::{Error, Estimator, Memory, Mode, Sampler, Sequence, Settings};

impl<'a> Sampler<'a> {
    /// What the sampler knows beyond its memory.
    pub fn state(&self) -> State {
        self.state
    }

    /// The sampler that had this state and this memory. With other memory it has other pixels, but does no harm.
    ///
    /// # Errors
    /// If memory is short.
    pub fn resume(state: State, memory: Memory<'a>) -> Result<Self, Error> {
        let layout = state.settings.check()?;
        let required = state.required();
        let floats = memory.floats.get_mut(..required.floats).ok_or(Error::Memory)?;
        let words = memory.words.get_mut(..required.words).ok_or(Error::Memory)?;
        let planes = Planes::new(floats, words, layout.pixels()).ok_or(Error::Memory)?;
        Ok(Sampler { state, layout, planes })
    }

    /// Bytes of the saved film.
    pub fn saved_len(&self) -> usize {
        let planes = PLANES + usize::from(!self.planes.label.is_empty());
        HEADER + 4 * (FIELDS + planes * self.layout.pixels())
    }

    /// Writes the film as bytes, [`saved_len`](Self::saved_len) of them.
    ///
    /// # Errors
    /// If `out` has another length.
    pub fn save(&self, out: &mut [u8]) -> Result<(), Error> {
        if out.len() != self.saved_len() {
            return Err(Error::Output);
        }
        let (header, body) = out.split_at_mut(HEADER);
        let (fields, planes) = body.split_at_mut(4 * FIELDS);
        let put = |to: &mut [u8], words: &mut dyn Iterator<Item = u32>| {
            to.chunks_exact_mut(4).zip(words).for_each(|(to, word)| to.copy_from_slice(&word.to_le_bytes()));
        };
        put(fields, &mut self.state.fields().into_iter());
        let p = &self.planes;
        let floats = p.mean.iter().chain([&p.m2]).chain(&p.fair).chain([&p.target]);
        let words = p.count.iter().chain(p.drawn.iter()).chain(p.planned.iter()).copied();
        let floats = floats.flat_map(|plane| plane.iter().map(|v| v.to_bits()));
        put(planes, &mut words.chain(floats).chain(p.label.iter().copied()));
        let sum = check_sum(body);
        header[..8].copy_from_slice(MAGIC);
        header[8..12].copy_from_slice(&VERSION.to_le_bytes());
        header[12..].copy_from_slice(&sum.to_le_bytes());
        Ok(())
    }
}

const MAGIC: &[u8; 8] = b"pmcip fl";
/// Version of the format.
const VERSION: u32 = 2;
/// Bytes before the words.
const HEADER: usize = 16;
/// Words before the planes.
const FIELDS: usize = 30;
/// Planes that are saved, but for labels.
const PLANES: usize = 11;

/// Of bytes, whose number is a multiple of four (FNV-1a over words, both halves).
fn check_sum(bytes: &[u8]) -> u32 {
    let (words, _) = bytes.as_chunks();
    let sum = words.iter().fold(0xcbf2_9ce4_8422_2325u64, |sum, word| {
        (sum ^ u64::from(u32::from_le_bytes(*word))).wrapping_mul(0x0100_0000_01b3)
    });
    (sum ^ sum >> 32) as u32
}

const MODES: [Mode; 2] = [Mode::Adaptive, Mode::Uniform];
const ESTIMATORS: [Estimator; 5] =
    [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced, Estimator::Guided];
const SEQUENCES: [Sequence; 2] = [Sequence::Continued, Sequence::Fresh];
const CRITERIA: [Criterion; 2] = [Criterion::Sample, Criterion::Mean];
const WINDOWS: [Window; 2] = [Window::Pixel, Window::Square3];

/// Place of a value among all.
fn number<T: PartialEq>(all: &[T], value: T) -> u32 {
    all.iter().position(|other| *other == value).unwrap_or(0) as u32
}

impl State {
    /// All of it, as words.
    fn fields(&self) -> [u32; FIELDS] {
        let s = &self.settings;
        let (fair, promised) = self.fair.parts();
        let halves = |v: u64| [v as u32, (v >> 32) as u32];
        let ([a, b], [c, d], [e, f]) = (halves(self.samples), halves(promised), halves(self.mixture.samples));
        let [g, h] = halves(self.running);
        [
            s.width,
            s.height,
            s.seed,
            s.frame,
            s.cd_per_unit.to_bits(),
            number(&MODES, s.mode),
            number(&ESTIMATORS, s.estimator),
            number(&SEQUENCES, s.sequence),
            number(&CRITERIA, s.criterion),
            number(&WINDOWS, s.window),
            s.gamma.to_bits(),
            s.epsilon.to_bits(),
            s.defensive.to_bits(),
            s.fair,
            s.balance_radius,
            u32::from(self.labelled),
            self.used as u32,
            self.open as u32,
            self.iteration,
            a,
            b,
            fair,
            c,
            d,
            e,
            f,
            self.mixture.floor.to_bits(),
            self.mixture.epsilon.to_bits(),
            g,
            h,
        ]
    }

    /// The state of these words, if they are within their ranges.
    fn of(fields: [u32; FIELDS]) -> Option<State> {
        let mut fields = fields.into_iter();
        let mut word = || fields.next().unwrap_or(0);
        let settings = Settings {
            width: word(),
            height: word(),
            seed: word(),
            frame: word(),
            cd_per_unit: f32::from_bits(word()),
            mode: *MODES.get(word() as usize)?,
            estimator: *ESTIMATORS.get(word() as usize)?,
            sequence: *SEQUENCES.get(word() as usize)?,
            criterion: *CRITERIA.get(word() as usize)?,
            window: *WINDOWS.get(word() as usize)?,
            gamma: f32::from_bits(word()),
            epsilon: f32::from_bits(word()),
            defensive: f32::from_bits(word()),
            fair: word(),
            balance_radius: word(),
        };
        let layout = settings.check().ok()?;
        let labelled = *[false, true].get(word() as usize)?;
        let (used, open, iteration) = (word() as usize, word() as usize, word());
        let fits = (1..=layout.pixels()).contains(&used) && (1..=used).contains(&open);
        let samples = u64::from(word()) | u64::from(word()) << 32;
        let fair = Fair::of(word(), u64::from(word()) | u64::from(word()) << 32);
        let mixture_samples = u64::from(word()) | u64::from(word()) << 32;
        let mixture = Mixture {
            samples: mixture_samples,
            floor: f32::from_bits(word()),
            epsilon: f32::from_bits(word()),
        };
        let running = u64::from(word()) | u64::from(word()) << 32;
        (fits && running <= MAX_SAMPLES).then_some(State {
            settings,
            labelled,
            used,
            open,
            iteration,
            samples,
            fair,
            mixture,
            running,
        })
    }
}

/// What a film knows of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    pub count: u32,
    pub drawn: u32,
    pub mean: [f32; 3],
    pub m2: f32,
    pub fair: [f32; 3],
}

/// A film as bytes, checked.
///
/// ```
/// # use pmcip_core::sampler::{Error, Memory, Sampler};
/// use pmcip_core::sampler::saved::Saved;
///
/// fn restored<'a>(bytes: &[u8], floats: &'a mut Vec<f32>, words: &'a mut Vec<u32>) -> Result<Sampler<'a>, Error> {
///     let saved = Saved::new(bytes)?;
///     floats.resize(saved.state().required().floats, 0.0);
///     words.resize(saved.state().required().words, 0);
///     saved.restore(Memory { floats, words })
/// }
/// # assert!(restored(b"none", &mut vec![], &mut vec![]).is_err());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Saved<'b> {
    state: State,
    planes: &'b [[u8; 4]],
}

impl<'b> Saved<'b> {
    /// Checks bytes that [`Sampler::save`] wrote.
    ///
    /// # Errors
    /// [`Error::Saved`] if they are not a film of this version, whole and unchanged.
    pub fn new(bytes: &'b [u8]) -> Result<Self, Error> {
        let (header, body) = bytes.split_at_checked(HEADER).ok_or(Error::Saved)?;
        let right = header[..8] == *MAGIC && header[8..12] == VERSION.to_le_bytes();
        if !right || header[12..] != check_sum(body).to_le_bytes() {
            return Err(Error::Saved);
        }
        let (words, []) = body.as_chunks::<4>() else { return Err(Error::Saved) };
        let (fields, planes) = words.split_first_chunk::<FIELDS>().ok_or(Error::Saved)?;
        let state = State::of(fields.map(u32::from_le_bytes)).ok_or(Error::Saved)?;
        let layout = state.settings.check()?;
        if planes.len() != (PLANES + usize::from(state.labelled)) * layout.pixels() {
            return Err(Error::Saved);
        }
        Saved { state, planes }.consistent(&layout)
    }

    /// Itself, if labels and what is planned are such and agree with what else is said of them.
    fn consistent(self, layout: &Layout) -> Result<Self, Error> {
        let pixels = layout.pixels();
        let (mut used, planned) = (pixels, self.words(2, pixels));
        if planned.clone().map(u64::from).sum::<u64>() > self.state.running {
            return Err(Error::Saved);
        }
        if self.state.labelled {
            let (drawn, labels) = (self.words(1, pixels), self.words(PLANES, pixels));
            let unused = |(d, p): (u32, u32)| d == u32::MAX && p == 0;
            if !labels.clone().zip(drawn.zip(planned)).all(|(l, of)| l < 1 << 16 && (l != 0 || unused(of))) {
                return Err(Error::Saved);
            }
            used = labels.filter(|label| *label != 0).count();
        }
        if used == self.state.used { Ok(self) } else { Err(Error::Saved) }
    }

    fn words(&self, plane: usize, pixels: usize) -> impl Iterator<Item = u32> + Clone + 'b {
        self.planes[plane * pixels..(plane + 1) * pixels].iter().map(|word| u32::from_le_bytes(*word))
    }

    /// Whether its labels are these.
    pub(super) fn has_labels(&self, labels: &[u32]) -> bool {
        !self.state.labelled || self.words(PLANES, labels.len()).eq(labels.iter().copied())
    }

    /// What it knows of pixel `i`, in storage order.
    pub(super) fn pixel(&self, i: usize) -> Pixel {
        let pixels = self.planes.len() / (PLANES + usize::from(self.state.labelled));
        let word = |plane: usize| u32::from_le_bytes(self.planes[plane * pixels + i]);
        let float = |plane: usize| f32::from_bits(word(WORDS + plane));
        Pixel {
            count: word(0),
            drawn: word(1),
            mean: [float(0), float(1), float(2)],
            m2: float(3),
            fair: [float(4), float(5), float(6)],
        }
    }

    /// Settings of the film, and how much memory it needs.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The film, on lent memory.
    ///
    /// # Errors
    /// If memory is short.
    pub fn restore<'a>(&self, memory: Memory<'a>) -> Result<Sampler<'a>, Error> {
        let required = self.state.required();
        let pixels = required.floats / super::film::FLOATS;
        let Memory { floats, words } = memory;
        let some = floats.get_mut(..required.floats).zip(words.get_mut(..required.words));
        let (f, w) = some.ok_or(Error::Memory)?;
        let (count, rest) = w.split_at_mut(pixels);
        let (drawn, rest) = rest.split_at_mut(pixels);
        let (planned, label) = rest.split_at_mut(pixels);
        let planes = [(count, 0), (drawn, 1), (planned, 2), (label, PLANES)];
        for (to, plane) in planes.into_iter().filter(|(to, _)| !to.is_empty()) {
            to.iter_mut().zip(self.words(plane, pixels)).for_each(|(to, word)| *to = word);
        }
        for (k, to) in f.chunks_exact_mut(pixels).enumerate() {
            to.iter_mut()
                .zip(self.words(WORDS + k, pixels))
                .for_each(|(to, word)| *to = f32::from_bits(word));
        }
        Sampler::resume(self.state, Memory { floats: f, words: w })
    }
}
