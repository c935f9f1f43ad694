//! Revisions: the one way to say that something has changed.
//!
//! - A *source* has a [`Revision`]: a number that it shares with no other state. Whoever changes the source gives it a new one.
//! - Data that is *derived* from a source keeps the revision that it was derived from, as an `Option<Revision>`; `None` means that it must
//!   be derived anew in any case. It is valid while that revision equals the revision of its source.
//!
//! A revision says only *whether* a source is the same as before. Revisions have no order, and no result depends on their values. Every
//! number is used once in a process.
//!
//! Solvers find by revisions which patches have changed since they stored their state: see [`Memory`](crate::Memory).

use std::num::NonZeroU64;
use std::sync::atomic::{AtomicU64, Ordering};

/// Identifies one state of something that other data is derived from. See the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Revision(NonZeroU64);

impl Revision {
    /// A revision that has not been used before in this process.
    pub fn next() -> Self {
        static LAST: AtomicU64 = AtomicU64::new(0);
        let last = LAST.fetch_add(1, Ordering::Relaxed);
        Self(NonZeroU64::MIN.saturating_add(last))
    }
}

/// A revision that has not been used before, for a source that was just made.
impl Default for Revision {
    fn default() -> Self {
        Self::next()
    }
}

/// A revision is written as nothing, and read as a new one.
#[cfg(feature = "serde")]
impl serde::Serialize for Revision {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_unit()
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Revision {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        <()>::deserialize(from).map(|()| Self::next())
    }
}

/// An absent revision takes no memory of its own.
const _: () = assert!(size_of::<Option<Revision>>() == 8);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_revision_is_used_twice() {
        let one = Revision::next();
        assert_eq!(one, one);
        assert_ne!(one, Revision::next());
        assert_ne!(Revision::default(), Revision::default());
    }
}
