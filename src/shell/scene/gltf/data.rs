//! Numbers of a glTF file: buffers, and accessors on them. Everything is checked against what is there before anything is
//! read or allocated.

use super::uri::{Place, resolve};
use crate::scene::error::Error;
use crate::scene::room::{Kind, Lease, Room};
use crate::scene::source;
use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::{Accessor, Document, buffer};
use std::path::Path;

/// The buffers of a file.
pub(super) struct Data {
    buffers: Vec<Vec<u8>>,
    /// Bytes in all of them.
    total: usize,
    /// Room for them and for what is read from them.
    pub lease: Lease,
}

impl Data {
    /// Reads all buffers of the file `path`.
    ///
    /// # Errors
    /// If one is not there, may not be read, or has fewer bytes than it says.
    pub fn read(
        path: &Path,
        document: &Document,
        mut binary: Option<Vec<u8>>,
        room: &Room,
    ) -> Result<Data, Error> {
        let (mut buffers, lease) = (Vec::new(), Lease::new(room));
        for (number, buffer) in document.as_json().buffers.iter().enumerate() {
            let blame = |message: String| Error::in_file(path, format!("buffer {number}: {message}"));
            let bytes = match &buffer.uri {
                Some(uri) => match resolve(path, uri).map_err(blame)? {
                    Place::Here(bytes) => bytes,
                    Place::File(file) => {
                        source::bytes(&file).map_err(|e| blame(format!("{}: {e}", file.display())))?
                    }
                },
                None if number == 0 => binary.take().ok_or_else(|| blame("it has no data".into()))?,
                None => return Err(blame("it has no data".into())),
            };
            let claimed = buffer.byte_length.0;
            if claimed > bytes.len() as u64 {
                return Err(blame(format!("{} of {claimed} bytes are there", bytes.len())));
            }
            lease.take(bytes.len(), Kind::Bytes).map_err(blame)?;
            buffers.push(bytes);
        }
        let total = buffers.iter().map(Vec::len).sum();
        Ok(Data { buffers, total, lease })
    }

    /// The bytes of a view.
    pub fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], String> {
        let bytes = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        let inside = end.and_then(|end| bytes.get(view.offset()..end));
        inside.ok_or_else(|| format!("bufferView {} ends beyond its buffer", view.index()))
    }

    /// Vectors of whole numbers or fractions, as fractions; whole ones are scaled where the file says so.
    ///
    /// # Errors
    /// If it is no accessor of such vectors, or says that there are more than the file holds.
    pub fn vectors<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>, String>
    where
        [f32; N]: Item,
        [u8; N]: Item,
        [i8; N]: Item,
        [u16; N]: Item,
        [i16; N]: Item,
    {
        let dimensions = [Dimensions::Vec2, Dimensions::Vec3, Dimensions::Vec4];
        if dimensions.get(N.wrapping_sub(2)) != Some(&accessor.dimensions()) {
            return Err(self.wrong(accessor, &format!("expected vectors of {N} numbers")));
        }
        let scale = |most: f32| if accessor.normalized() { most.recip() } else { 1.0 };
        // The least number of a signed kind stands for −1, too.
        let least = if accessor.normalized() { -1.0 } else { f32::NEG_INFINITY };
        let values = match accessor.data_type() {
            DataType::F32 => self.items::<[f32; N]>(accessor)?.collect(),
            DataType::U8 => {
                self.items::<[u8; N]>(accessor)?.map(|v| v.map(|v| f32::from(v) * scale(255.0))).collect()
            }
            DataType::U16 => {
                self.items::<[u16; N]>(accessor)?.map(|v| v.map(|v| f32::from(v) * scale(65_535.0))).collect()
            }
            DataType::I8 => self
                .items::<[i8; N]>(accessor)?
                .map(|v| v.map(|v| (f32::from(v) * scale(127.0)).max(least)))
                .collect(),
            DataType::I16 => self
                .items::<[i16; N]>(accessor)?
                .map(|v| v.map(|v| (f32::from(v) * scale(32_767.0)).max(least)))
                .collect(),
            DataType::U32 => return Err(self.wrong(accessor, "expected fractions or small whole numbers")),
        };
        Ok(values)
    }

    /// Single fractions.
    ///
    /// # Errors
    /// As [`vectors`](Self::vectors).
    pub fn fractions(&self, accessor: &Accessor<'_>) -> Result<Vec<f32>, String> {
        match (accessor.dimensions(), accessor.data_type()) {
            (Dimensions::Scalar, DataType::F32) => Ok(self.items::<f32>(accessor)?.collect()),
            _ => Err(self.wrong(accessor, "expected single fractions")),
        }
    }

    /// Indices.
    ///
    /// # Errors
    /// As [`vectors`](Self::vectors).
    pub fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, String> {
        match (accessor.dimensions(), accessor.data_type()) {
            (Dimensions::Scalar, DataType::U8) => Ok(self.items::<u8>(accessor)?.map(u32::from).collect()),
            (Dimensions::Scalar, DataType::U16) => Ok(self.items::<u16>(accessor)?.map(u32::from).collect()),
            (Dimensions::Scalar, DataType::U32) => Ok(self.items::<u32>(accessor)?.collect()),
            _ => Err(self.wrong(accessor, "expected single whole numbers")),
        }
    }

    fn wrong(&self, accessor: &Accessor<'_>, expected: &str) -> String {
        format!("accessor {}: {expected}", accessor.index())
    }

    /// What an accessor holds, which has been checked to be there.
    fn items<T: Item>(&self, accessor: &Accessor<'_>) -> Result<Iter<'_, T>, String> {
        let room = || self.lease.take(accessor.count() * accessor.dimensions().multiplicity(), Kind::Numbers);
        self.check(accessor).and_then(|()| room()).map_err(|message| self.wrong(accessor, &message))?;
        let buffer = |buffer: buffer::Buffer<'_>| self.buffers.get(buffer.index()).map(Vec::as_slice);
        Iter::new(accessor.clone(), buffer).ok_or_else(|| self.wrong(accessor, "it has no data"))
    }

    /// Checks that all items of an accessor are there.
    fn check(&self, accessor: &Accessor<'_>) -> Result<(), String> {
        let count = accessor.count();
        if count == 0 || count > u32::MAX as usize {
            return Err(format!("{count} items, expected 1 to {}", u32::MAX));
        }
        match accessor.view() {
            Some(view) => self.check_run(&view, accessor.offset(), count, accessor.size())?,
            // All zeros, so far as nothing else is said: no more than the file might hold.
            None if accessor.sparse().is_none() => return Err("it has no bufferView".into()),
            None if count > self.total => return Err(format!("{count} items, more than the file can mean")),
            None => {}
        }
        let Some(sparse) = accessor.sparse() else { return Ok(()) };
        let (some, indices, values) = (sparse.count(), sparse.indices(), sparse.values());
        if some == 0 || some > count {
            return Err(format!("{some} sparse items of {count}"));
        }
        self.check_run(&indices.view(), indices.offset(), some, indices.index_type().size())?;
        self.check_run(&values.view(), values.offset(), some, accessor.size())
    }

    /// Checks that a view holds so many items from `offset` on.
    fn check_run(
        &self,
        view: &buffer::View<'_>,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<(), String> {
        let bytes = self.view(view)?.len();
        let stride = view.stride().unwrap_or(size);
        let end = stride
            .checked_mul(count - 1)
            .and_then(|n| n.checked_add(size))
            .and_then(|n| n.checked_add(offset));
        if stride < size || end.is_none_or(|end| end > bytes) {
            return Err(format!("{count} items of {size} bytes are more than its bufferView holds"));
        }
        Ok(())
    }
}
