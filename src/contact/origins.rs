//! Which entry of the last step each entry of a list is: what the narrowphase reorders the lists of a pair by.

use smallvec::SmallVec;

/// For each new point the index of the old one.
pub(crate) type Origins = SmallVec<[Option<u16>; 8]>;

/// Reorders what is kept for each point; new points start from the default. Most often all stay where they are.
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
