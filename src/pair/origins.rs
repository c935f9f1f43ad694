//! Origins: the index in the last step of each entry of a list. The narrowphase reorders the lists of a pair by them.

use smallvec::SmallVec;

/// For each new point the index of the old one, if there is one.
pub(crate) type Origins = SmallVec<[Option<u16>; 8]>;

/// Reorders a list with an entry for each point. New points get the default. Usually no entry moves.
pub(crate) fn inherit<T: Copy + Default, Kept: AsRef<[T]> + FromIterator<T>>(
    origins: &Origins,
    kept: &mut Kept,
) {
    let is_same = |(i, origin): (usize, &Option<u16>)| *origin == Some(i as u16);
    if kept.as_ref().len() == origins.len() && origins.iter().enumerate().all(is_same) {
        return;
    }
    let before = |i: u16| kept.as_ref().get(i as usize).copied();
    let inherited = origins.iter().map(|origin| origin.and_then(before));
    *kept = inherited.map(Option::unwrap_or_default).collect();
}
