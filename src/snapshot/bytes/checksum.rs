//! A checksum of bytes.

/// A hash of 64 bits that tells bytes that were damaged. It takes eight bytes at a time, because a snapshot has megabytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Checksum(u64);

impl Checksum {
    pub fn of(bytes: &[u8]) -> Self {
        let mut sum = Self::default();
        sum.add(bytes);
        sum
    }

    pub fn add(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        let words = words.iter().map(|word| u64::from_le_bytes(*word));
        let rest = rest.iter().copied().map(u64::from);
        let start = self.0.wrapping_add(bytes.len() as u64);
        self.0 = words
            .chain(rest)
            .fold(start, |sum, word| mix(sum, word).rotate_left(23));
    }

    pub fn to_bytes(self) -> [u8; 8] {
        self.0.to_le_bytes()
    }
}

/// Adds a number to a hash.
#[inline]
pub(crate) fn mix(hash: u64, number: u64) -> u64 {
    /// Odd, with about as many ones as zeros.
    const FACTOR: u128 = 0x9e37_79b9_7f4a_7c15;
    let product = u128::from(hash ^ number) * FACTOR;
    product as u64 ^ (product >> 64) as u64
}
