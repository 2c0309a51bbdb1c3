//! Memory for a scene, asked for before it is taken: a few words of a file can stand for more than any machine has.
//!
//! Shapes are made of numbers of triangles, a mesh may stand at many nodes or in a scene file many times, numbers and pictures
//! may be shared by what needs them anew each time. All of these ask here.

use crate::machine::{free_memory, giga};
use std::cell::Cell;
use std::rc::Rc;

/// What takes memory.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// Triangles of the scene.
    Triangles,
    /// Materials of the scene.
    Materials,
    /// Texels of a picture.
    Texels,
    /// Numbers of a mesh or an animation, as they are read.
    Numbers,
    /// Keys of an animation.
    Keys,
    /// Bytes of files.
    Bytes,
}

impl Kind {
    /// Bytes of one at the worst of times: a triangle takes 150 in the scene, and 340 while the hierarchy is built.
    fn size(self) -> u64 {
        match self {
            Kind::Triangles => 360,
            Kind::Materials => 256,
            Kind::Texels => 12,
            Kind::Numbers => 4,
            Kind::Keys => 104,
            Kind::Bytes => 1,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Triangles => "triangles",
            Kind::Materials => "materials",
            Kind::Texels => "texels",
            Kind::Numbers => "numbers of meshes",
            Kind::Keys => "keys",
            Kind::Bytes => "bytes of files",
        }
    }
}

/// How many of each kind there are.
type Counts = [u64; Kind::Bytes as usize + 1];

/// The memory that a scene may take while it is loaded; clones are the same room.
#[derive(Clone, Debug)]
pub(super) struct Room {
    most: u64,
    taken: Rc<Cell<Counts>>,
}

impl Room {
    /// Room for so many bytes; for as many as are free if nothing is said.
    pub fn new(most: Option<u64>) -> Room {
        let most = most.or_else(free_memory).unwrap_or(u64::MAX);
        Room { most, taken: Rc::default() }
    }

    /// Takes room for `count` more.
    ///
    /// # Errors
    /// If the scene would need more than there is, or more triangles than can be counted: how many and how much.
    pub fn take(&self, count: usize, kind: Kind) -> Result<(), String> {
        let mut taken = self.taken.get();
        let of_kind = &mut taken[kind as usize];
        *of_kind = of_kind.saturating_add(count as u64);
        let (count, name) = (*of_kind, kind.name());
        if matches!(kind, Kind::Triangles) && count > u64::from(u32::MAX) {
            return Err(format!("{count} triangles in all, a scene has at most {}", u32::MAX));
        }
        let needed = needed(&taken);
        if needed > self.most {
            return Err(format!(
                "not enough memory: with {count} {name} the scene takes {} to load, {} are free",
                giga(needed),
                giga(self.most)
            ));
        }
        self.taken.set(taken);
        Ok(())
    }
}

/// Bytes that all of these take.
fn needed(counts: &Counts) -> u64 {
    use Kind::{Bytes, Keys, Materials, Numbers, Texels, Triangles};
    let kinds = [Triangles, Materials, Texels, Numbers, Keys, Bytes];
    let bytes = kinds.map(|kind| counts[kind as usize].saturating_mul(kind.size()));
    bytes.into_iter().fold(0, u64::saturating_add)
}

/// Room that is given back when what it was for is gone.
#[derive(Debug)]
pub(super) struct Lease {
    room: Room,
    taken: Cell<Counts>,
}

impl Lease {
    /// Nothing yet, of this room.
    pub fn new(room: &Room) -> Lease {
        Lease { room: room.clone(), taken: Cell::default() }
    }

    /// Takes room for `count` more.
    ///
    /// # Errors
    /// As [`Room::take`].
    pub fn take(&self, count: usize, kind: Kind) -> Result<(), String> {
        self.room.take(count, kind)?;
        let mut taken = self.taken.get();
        taken[kind as usize] += count as u64;
        self.taken.set(taken);
        Ok(())
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let (mut all, own) = (self.room.taken.get(), self.taken.get());
        all.iter_mut().zip(own).for_each(|(all, own)| *all = all.saturating_sub(own));
        self.room.taken.set(all);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_and_takes_nothing() {
        let room = Room::new(Some(1_000_000_000));
        room.take(2_000_000, Kind::Triangles).unwrap();
        let refusal =
            room.clone().take(10_000_000, Kind::Texels).and_then(|()| room.take(1 << 20, Kind::Triangles));
        let expected =
            "not enough memory: with 3048576 triangles the scene takes 1.2 GB to load, 1.0 GB are free";
        assert_eq!(refusal.unwrap_err(), expected);
        room.take(1_000, Kind::Triangles).unwrap();
        let boundless = Room::new(Some(u64::MAX));
        let refusal = boundless.take(1 << 33, Kind::Triangles).unwrap_err();
        assert_eq!(refusal, "8589934592 triangles in all, a scene has at most 4294967295");
    }

    #[test]
    fn what_is_lent_is_given_back() {
        let room = Room::new(Some(100));
        for _ in 0..3 {
            let lease = Lease::new(&room);
            lease.take(60, Kind::Bytes).unwrap();
            assert!(lease.take(60, Kind::Bytes).is_err() && room.take(11, Kind::Numbers).is_err());
        }
        room.take(25, Kind::Numbers).unwrap();
    }
}
