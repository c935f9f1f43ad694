//! The values of a snapshot as a stream of bytes, each as its difference from a value of an earlier snapshot.
//!
//! A value is written as a number n and the bytes that follow. If it is equal to the earlier one, n is 0. Otherwise n − 1 bytes follow: the
//! value in postcard's format, combined with the earlier one by exclusive or. So numbers that change little are mostly zeros, which
//! compression removes.

use super::super::error::SnapshotError;
use super::checksum::Checksum;
use super::value::{read, write};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Appends a value to bytes, or the earlier one if it is told so.
pub(super) type Append<'a> = &'a mut dyn FnMut(bool, &mut Vec<u8>) -> Result<(), SnapshotError>;

/// Writes values.
#[derive(Default)]
pub(in super::super) struct Writer {
    out: Vec<u8>,
    /// Of the values themselves, so that a reader with another earlier snapshot notices.
    sum: Checksum,
    now: Vec<u8>,
    earlier: Vec<u8>,
}

impl Writer {
    /// Writes a value. `name` is that of its type, for errors.
    pub fn put<T: Serialize + ?Sized>(
        &mut self,
        value: &T,
        earlier: Option<&T>,
        name: &'static str,
    ) -> Result<(), SnapshotError> {
        self.put_with(&mut |is_earlier, out| match (is_earlier, earlier) {
            (false, _) => write(value, name, out),
            (true, Some(earlier)) => write(earlier, name, out),
            (true, None) => Ok(()),
        })
    }

    /// Writes what a function appends: first the value, and then, if it is told so, the earlier one.
    pub fn put_with(&mut self, append: Append) -> Result<(), SnapshotError> {
        self.now.clear();
        self.earlier.clear();
        append(false, &mut self.now)?;
        append(true, &mut self.earlier)?;
        self.sum.add(&self.now);
        if self.now == self.earlier {
            self.put_length(0);
            return Ok(());
        }
        self.put_length(self.now.len() + 1);
        let earlier = self.earlier.iter().copied().chain(std::iter::repeat(0));
        let bytes = self.now.iter().zip(earlier);
        self.out.extend(bytes.map(|(now, earlier)| now ^ earlier));
        Ok(())
    }

    fn put_length(&mut self, mut length: usize) {
        while length >= 0x80 {
            self.out.push(length as u8 | 0x80);
            length >>= 7;
        }
        self.out.push(length as u8);
    }

    /// The bytes, and the checksum of the values.
    pub fn finish(self) -> (Vec<u8>, Checksum) {
        (self.out, self.sum)
    }
}

/// Reads what a [`Writer`] wrote.
pub(in super::super) struct Reader<'a> {
    from: &'a [u8],
    sum: Checksum,
    value: Vec<u8>,
}

impl<'a> Reader<'a> {
    pub fn new(from: &'a [u8]) -> Self {
        Self {
            from,
            sum: Checksum::default(),
            value: Vec::new(),
        }
    }

    /// Reads a value, given the same earlier one.
    pub fn take<T: Serialize + DeserializeOwned>(
        &mut self,
        earlier: Option<&T>,
        name: &'static str,
    ) -> Result<T, SnapshotError> {
        let mut value = None;
        let append = &mut |out: &mut Vec<u8>| match earlier {
            Some(earlier) => write(earlier, name, out),
            None => Ok(()),
        };
        self.take_with(append, &mut |from| {
            value = Some(read(from)?);
            Ok(())
        })?;
        value.ok_or(SnapshotError::Damaged)
    }

    /// Has a function read a value. The other one appends the same earlier value.
    pub fn take_with(
        &mut self,
        append: &mut dyn FnMut(&mut Vec<u8>) -> Result<(), SnapshotError>,
        read: &mut dyn FnMut(&mut &[u8]) -> Result<(), SnapshotError>,
    ) -> Result<(), SnapshotError> {
        self.value.clear();
        append(&mut self.value)?;
        if let Some(length) = self.take_length()?.checked_sub(1) {
            let parts = self.from.split_at_checked(length);
            let (bytes, rest) = parts.ok_or(SnapshotError::Damaged)?;
            self.from = rest;
            self.value.resize(length, 0);
            for (value, byte) in self.value.iter_mut().zip(bytes) {
                *value ^= byte;
            }
        }
        self.sum.add(&self.value);
        let mut bytes = self.value.as_slice();
        read(&mut bytes)?;
        match bytes.is_empty() {
            true => Ok(()),
            false => Err(SnapshotError::Damaged),
        }
    }

    fn take_length(&mut self) -> Result<usize, SnapshotError> {
        let mut length = 0;
        for shift in (0..usize::BITS).step_by(7) {
            let (&byte, rest) = self.from.split_first().ok_or(SnapshotError::Damaged)?;
            self.from = rest;
            length |= usize::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(length);
            }
        }
        Err(SnapshotError::Damaged)
    }

    /// The checksum of the values. Nothing may be left.
    pub fn finish(self) -> Result<Checksum, SnapshotError> {
        match self.from.is_empty() {
            true => Ok(self.sum),
            false => Err(SnapshotError::Damaged),
        }
    }
}
