//! Items that are joined to parts.

/// Items by index, each of which belongs to a part: a union-find structure. A part is named by its first item.
pub(crate) struct Parts {
    /// An earlier item of the same part; the item itself if there is none.
    before: Vec<u32>,
}

impl Parts {
    /// Each item is a part.
    pub fn new(count: usize) -> Self {
        Self {
            before: (0..count as u32).collect(),
        }
    }

    /// The first item of a part.
    pub fn first(&mut self, mut item: u32) -> u32 {
        while self.before[item as usize] != item {
            let before = self.before[item as usize];
            self.before[item as usize] = self.before[before as usize];
            item = before;
        }
        item
    }

    /// Joins the parts of two items.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.before[a.max(b) as usize] = a.min(b);
    }

    /// The items of each part, in order.
    pub fn members(mut self) -> Vec<Vec<u32>> {
        let mut parts: Vec<Vec<u32>> = Vec::new();
        let mut numbers = vec![u32::MAX; self.before.len()];
        for item in 0..self.before.len() as u32 {
            let first = self.first(item);
            if first == item {
                numbers[item as usize] = parts.len() as u32;
                parts.push(Vec::new());
            }
            parts[numbers[first as usize] as usize].push(item);
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_items_are_one_part() {
        let mut parts = Parts::new(7);
        for (a, b) in [(5, 1), (6, 2), (2, 5), (4, 3), (3, 4)] {
            parts.join(a, b);
        }
        assert_eq!(parts.first(6), 1);
        assert_eq!(
            parts.members(),
            [vec![0], vec![1, 2, 5, 6], vec![3, 4]].to_vec()
        );
    }
}
