//! What stands on what: how many contacts a body is away from what stands still.
//!
//! Loads travel from body to body with a sweep, and a sweep from the ground up carries them through a whole structure; from the top
//! down everything falls. So contacts are swept by the level of support of their bodies, and within a level by age. That follows from
//! how things stand, not from how they were spawned, and it keeps bodies that touch near each other in the order (Cuthill and
//! McKee 1969 number the unknowns of a sparse matrix so for the same reason).

/// By slot: 0 for what stands still and carries something, [`Levels::NONE`] for what nothing carries.
#[derive(Clone, Default)]
pub(super) struct Levels {
    levels: Vec<u32>,
    /// Where the neighbours of each slot begin in `neighbours`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    queue: Vec<u32>,
}

impl Levels {
    /// Of a body that nothing carries.
    pub const NONE: u32 = u32::MAX;

    pub fn of(&self, slot: u32) -> u32 {
        self.levels
            .get(slot as usize)
            .copied()
            .unwrap_or(Self::NONE)
    }

    /// Breadth first along links from all slots that stand still.
    pub fn find(&mut self, slots: usize, links: &[[u32; 2]], stands_still: impl Fn(u32) -> bool) {
        let Self {
            levels,
            first,
            neighbours,
            queue,
        } = self;
        first.clear();
        first.resize(slots + 1, 0);
        for slot in links.as_flattened() {
            first[*slot as usize + 1] += 1;
        }
        for i in 0..slots {
            first[i + 1] += first[i];
        }
        neighbours.clear();
        neighbours.resize(2 * links.len(), 0);
        levels.clear();
        levels.resize(slots, 0);
        // `levels` counts what has been filled in, for the moment.
        for [a, b] in links {
            for (slot, other) in [(*a, *b), (*b, *a)] {
                neighbours[(first[slot as usize] + levels[slot as usize]) as usize] = other;
                levels[slot as usize] += 1;
            }
        }
        levels.fill(Self::NONE);
        queue.clear();
        for &slot in links.as_flattened() {
            if levels[slot as usize] == Self::NONE && stands_still(slot) {
                levels[slot as usize] = 0;
                queue.push(slot);
            }
        }
        let mut next = 0;
        while let Some(&slot) = queue.get(next) {
            next += 1;
            let range = first[slot as usize] as usize..first[slot as usize + 1] as usize;
            for &neighbour in &neighbours[range] {
                if levels[neighbour as usize] == Self::NONE {
                    levels[neighbour as usize] = levels[slot as usize] + 1;
                    queue.push(neighbour);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_is_one_above_the_lowest_that_it_touches() {
        let mut levels = Levels::default();
        // 3 stands still; 0 on 3, 1 on 0, 2 on 1 and 0, 4 beside 5 on nothing.
        let links = [[0, 3], [1, 0], [2, 1], [2, 0], [4, 5]];
        levels.find(6, &links, |slot| slot == 3);
        let found: Vec<_> = (0..6).map(|slot| levels.of(slot)).collect();
        assert_eq!(found, [1, 2, 2, 0, Levels::NONE, Levels::NONE]);
    }
}
