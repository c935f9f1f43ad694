//! A list of items sorted by the body to which they belong.

use crate::Both;

/// Items sorted by body; those of a body keep their order.
#[derive(Debug)]
pub(super) struct ByBody<T> {
    /// By body: the start of its items; then the end of the list.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for ByBody<T> {
    fn default() -> Self {
        Self {
            starts: vec![0],
            items: Vec::new(),
        }
    }
}

impl<T: Clone + Default> ByBody<T> {
    /// Sorts the items of `bodies` bodies. The iterator runs twice.
    pub fn fill(&mut self, bodies: usize, items: impl Iterator<Item = (u32, T)> + Clone) {
        let Self {
            starts,
            items: sorted,
        } = self;
        starts.clear();
        starts.resize(bodies + 1, 0);
        let mut count = 0;
        for (body, _) in items.clone() {
            starts[body as usize + 1] += 1;
            count += 1;
        }
        for body in 0..bodies {
            starts[body + 1] += starts[body];
        }
        sorted.clear();
        sorted.resize(count, T::default());
        // Each start serves as the place for the next item of its body, and ends at the start of the next body.
        for (body, item) in items {
            let next = &mut starts[body as usize];
            sorted[*next as usize] = item;
            *next += 1;
        }
        starts.rotate_right(1);
        starts[0] = 0;
    }

    /// The items of a body.
    pub fn of(&self, body: u32) -> &[T] {
        let [first, end] = [0, 1].both(|next| self.starts[body as usize + next] as usize);
        &self.items[first..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_body_has_its_items_in_their_order() {
        let mut by_body = ByBody::default();
        by_body.fill(
            4,
            [(3, 'a'), (0, 'b'), (3, 'c'), (1, 'd'), (0, 'e')].into_iter(),
        );
        let of: Vec<String> = (0..4)
            .map(|body| by_body.of(body).iter().collect())
            .collect();
        assert_eq!(of, ["be", "d", "", "ac"]);
        by_body.fill(1, [(0, 'f')].into_iter());
        assert_eq!(by_body.of(0), ['f']);
    }
}
