//! The pieces of a recording in a file.
//!
//! | part | bytes |
//! |---|---|
//! | `DRYSTREC` | 8 |
//! | [`VERSION`] of the format | 4 |
//! | chunks, until the end | |
//!
//! A chunk:
//!
//! | part | bytes |
//! |---|---|
//! | [`Tag`] | 1 |
//! | length of the contents | 4 |
//! | checksum of the contents | 8 |
//! | checksum of the three parts before | 4 |
//! | contents | |
//!
//! A file is written from front to back, so that it is of use up to the last whole chunk if the game ends in the middle of one. The
//! checksum of the head tells a length that was damaged from a chunk that was cut off.

use crate::snapshot::bytes::Checksum;

/// The first bytes of every recording.
pub(super) const NAME: &[u8; 8] = b"DRYSTREC";

/// The version of the format.
pub(super) const VERSION: u32 = 8;

/// Length of the head of a chunk.
const HEAD_LENGTH: usize = 17;

/// The content of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Tag {
    /// The version of the crate, and the snapshot that the recording starts from.
    Start = 1,
    /// A step begins: its length, and what was changed before it.
    Begin = 2,
    /// A step has ended: the hashes of the bodies.
    End = 3,
    /// The recording was stopped.
    Stop = 4,
}

impl Tag {
    fn of(byte: u8) -> Option<Self> {
        let all = [Self::Start, Self::Begin, Self::End, Self::Stop];
        all.into_iter().find(|tag| *tag as u8 == byte)
    }
}

/// Appends a chunk, whose contents `fill` appends. If that fails nothing is appended.
pub(super) fn push<E>(
    out: &mut Vec<u8>,
    tag: Tag,
    fill: impl FnOnce(&mut Vec<u8>) -> Result<(), E>,
) -> Result<(), E> {
    let start = out.len();
    out.extend([0; HEAD_LENGTH]);
    if let Err(error) = fill(out) {
        out.truncate(start);
        return Err(error);
    }
    let (head, contents) = out[start..].split_at_mut(HEAD_LENGTH);
    head[0] = tag as u8;
    head[1..5].copy_from_slice(&(contents.len() as u32).to_le_bytes());
    head[5..13].copy_from_slice(&Checksum::of(contents).to_bytes());
    let sum = of_head(&head[..13]);
    head[13..].copy_from_slice(&sum);
    Ok(())
}

/// Why there is no further chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    /// The bytes end here.
    End,
    /// They end within a chunk.
    CutOff,
    /// They are not those that were written.
    Damaged,
}

/// Takes a chunk from the front.
pub(super) fn next<'a>(from: &mut &'a [u8]) -> Result<(Tag, &'a [u8]), Missing> {
    if from.is_empty() {
        return Err(Missing::End);
    }
    let (head, rest) = from
        .split_first_chunk::<HEAD_LENGTH>()
        .ok_or(Missing::CutOff)?;
    let [tag, l0, l1, l2, l3, ..] = *head;
    let (first, last) = (&head[..13], &head[13..]);
    if of_head(first) != *last {
        return Err(Missing::Damaged);
    }
    let tag = Tag::of(tag).ok_or(Missing::Damaged)?;
    let len = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
    let (contents, rest) = rest.split_at_checked(len).ok_or(Missing::CutOff)?;
    if Checksum::of(contents).to_bytes() != head[5..13] {
        return Err(Missing::Damaged);
    }
    *from = rest;
    Ok((tag, contents))
}

/// The checksum of the head of a chunk: half of the bytes are enough.
fn of_head(head: &[u8]) -> [u8; 4] {
    let [a, b, c, d, ..] = Checksum::of(head).to_bytes();
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunks() -> Vec<u8> {
        let mut out = Vec::new();
        for (tag, contents) in [
            (Tag::Start, "a snapshot"),
            (Tag::Begin, ""),
            (Tag::End, "!"),
        ] {
            push::<()>(&mut out, tag, |out| {
                out.extend(contents.as_bytes());
                Ok(())
            })
            .unwrap();
        }
        out
    }

    /// Number of chunks that are read, and why no more are.
    fn read(mut bytes: &[u8]) -> (usize, Missing) {
        let mut count = 0;
        loop {
            match next(&mut bytes) {
                Ok(_) => count += 1,
                Err(missing) => return (count, missing),
            }
        }
    }

    #[test]
    fn chunks_are_read_as_they_were_written() {
        let all = chunks();
        let mut rest = &all[..];
        assert_eq!(next(&mut rest), Ok((Tag::Start, &b"a snapshot"[..])));
        assert_eq!(next(&mut rest), Ok((Tag::Begin, &b""[..])));
        assert_eq!(next(&mut rest), Ok((Tag::End, &b"!"[..])));
        assert_eq!(next(&mut rest), Err(Missing::End));
    }

    #[test]
    fn a_chunk_that_is_cut_off_is_told_from_a_damaged_one() {
        let all = chunks();
        let ends = [
            0,
            HEAD_LENGTH + 10,
            2 * HEAD_LENGTH + 10,
            3 * HEAD_LENGTH + 11,
        ];
        for len in 0..=all.len() {
            let whole = ends.iter().filter(|&&end| end > 0 && end <= len).count();
            let missing = match ends.contains(&len) {
                true => Missing::End,
                false => Missing::CutOff,
            };
            assert_eq!(read(&all[..len]), (whole, missing), "{len}");
        }
        for at in 0..all.len() {
            for bit in 0..8 {
                let mut bytes = all.clone();
                bytes[at] ^= 1 << bit;
                assert_eq!(read(&bytes).1, Missing::Damaged, "bit {bit} of byte {at}");
            }
        }
    }

    #[test]
    fn a_chunk_that_fails_leaves_nothing() {
        let mut out = chunks();
        let failed = push(&mut out, Tag::End, |out| {
            out.push(1);
            Err("no")
        });
        assert_eq!(failed, Err("no"));
        assert_eq!(out, chunks());
    }
}
