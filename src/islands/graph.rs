//! Which island each body is in: the parts of a graph that hang together.

/// Union–find over its nodes: slots of bodies, and behind them what else has a part in it.
#[derive(Clone, Default)]
pub(super) struct Graph {
    parent: Vec<u32>,
    island: Vec<u32>,
    pub count: usize,
}

impl Graph {
    /// The island of a node that is a member of one.
    pub fn of(&self, node: u32) -> Option<usize> {
        match self.island.get(node as usize) {
            Some(&u32::MAX) | None => None,
            Some(&island) => Some(island as usize),
        }
    }

    /// Groups `members` by `links`. Islands are numbered in the order of their first member.
    pub fn regroup(
        &mut self,
        nodes: usize,
        members: impl Iterator<Item = u32>,
        links: &[[u32; 2]],
    ) {
        self.parent.clear();
        self.parent.extend(0..nodes as u32);
        for [a, b] in links {
            let (a, b) = (self.root(*a), self.root(*b));
            // The smaller root wins, whatever the order of the links.
            self.parent[a.max(b) as usize] = a.min(b);
        }
        self.island.clear();
        self.island.resize(nodes, u32::MAX);
        self.count = 0;
        for member in members {
            let root = self.root(member) as usize;
            if self.island[root] == u32::MAX {
                self.island[root] = self.count as u32;
                self.count += 1;
            }
            self.island[member as usize] = self.island[root];
        }
    }

    fn root(&mut self, mut node: u32) -> u32 {
        while self.parent[node as usize] != node {
            let above = self.parent[self.parent[node as usize] as usize];
            self.parent[node as usize] = above;
            node = above;
        }
        node
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_join_and_the_rest_stand_alone() {
        let mut graph = Graph::default();
        let members = [0, 1, 2, 4, 5];
        graph.regroup(6, members.into_iter(), &[[4, 2], [5, 4]]);
        let of: Vec<_> = (0..6).map(|slot| graph.of(slot)).collect();
        assert_eq!(of, [Some(0), Some(1), Some(2), None, Some(2), Some(2)]);
        assert_eq!(graph.count, 3);
    }
}
