//! Lists that get as much room as they need and a little more, such as those that are indexed by slot or by the number of an edge.

/// A full list gets room for all entries and for one sixteenth of their number more.
const SPARE_SHARE: usize = 16;

/// Makes room in a list for so many entries, and for some more if it is full. Otherwise the next body would double the list, which copies
/// it: in a large world that takes longer than the rest of the step, and half of the room stays empty. This is called when many bodies
/// arrive, in a step that takes long anyway.
pub(crate) fn make_room<T>(list: &mut Vec<T>, entries: usize) {
    if list.capacity() < entries {
        list.reserve_exact(entries + entries / SPARE_SHARE - list.len());
    }
}

/// Makes a list long enough for so many slots, with [room](make_room) for more.
pub(crate) fn cover<T: Clone>(list: &mut Vec<T>, slots: usize, empty: T) {
    if list.len() < slots {
        make_room(list, slots);
        list.resize(slots, empty);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_list_gets_room_for_more_and_none_is_shortened() {
        let mut list = Vec::new();
        cover(&mut list, 1_600, 7);
        assert_eq!((list.len(), list[1_599]), (1_600, 7));
        assert!(list.capacity() >= 1_700);
        let place = list.as_ptr();
        cover(&mut list, 1_700, 8);
        assert_eq!((list.as_ptr(), list[1_600]), (place, 8));
        cover(&mut list, 10, 9);
        assert_eq!(list.len(), 1_700);
    }
}
