//! The order in which a Cholesky factorization eliminates bodies, and the layout of its factor.
//!
//! It depends only on which bodies touch, so that it is found once for all rounds. The next body is always one with the fewest neighbours left
//! (minimum degree), which keeps the factor sparse.

use fixedbitset::FixedBitSet;
use std::ops::Range;

/// An order and its fronts, each of which comes before its parent.
pub(super) struct Plan {
    /// Where each body comes in the order.
    pub places: Vec<usize>,
    pub fronts: Vec<Front>,
    /// The front of each place.
    front_of: Vec<usize>,
}

/// Bodies that are eliminated together, as the first rows of a dense matrix.
pub(super) struct Front {
    /// Their places.
    pub own: Range<usize>,
    /// The places of later bodies that they are tied to, rising: the other rows.
    pub rest: Vec<usize>,
    /// The fronts that contribute to this one.
    pub children: Vec<usize>,
    /// Where its strips begin: rows of blocks, each as wide as its own bodies.
    start: usize,
}

/// Where the block of two bodies stands.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    /// Its first column among all strips.
    pub start: usize,
    /// True where it is the transposed block that is stored.
    pub turned: bool,
}

impl Front {
    /// Columns of a strip.
    pub fn width(&self) -> usize {
        6 * self.own.len()
    }

    /// Where its strips stand among all.
    pub fn strips(&self) -> Range<usize> {
        let rows = self.own.len() + self.rest.len();
        self.start..self.start + rows * self.width()
    }

    /// The row of a place.
    pub fn row(&self, place: usize) -> usize {
        if place < self.own.end {
            return place - self.own.start;
        }
        let found = self.rest.binary_search(&place);
        self.own.len() + found.expect("a front has all that its bodies are tied to")
    }
}

impl Plan {
    /// For so many bodies, of which these pairs are tied.
    pub fn new(count: usize, ties: impl Iterator<Item = [usize; 2]>) -> Self {
        let (order, tied) = least_degree(count, ties);
        let order = children_first(&order, &tied);
        let mut places = vec![0; count];
        for (place, &body) in order.iter().enumerate() {
            places[body] = place;
        }
        let rests = order.iter().map(|&body| {
            let mut rest: Vec<usize> = tied[body].iter().map(|&other| places[other]).collect();
            rest.sort_unstable();
            rest
        });
        let (fronts, front_of) = fronts(rests);
        Self {
            places,
            fronts,
            front_of,
        }
    }

    /// Where the block of two bodies stands, which are the same or tied.
    pub fn spot(&self, row: usize, column: usize) -> Spot {
        let [row, column] = [self.places[row], self.places[column]];
        let [early, late] = [row.min(column), row.max(column)];
        let front = &self.fronts[self.front_of[early]];
        Spot {
            start: front.start + front.row(late) * front.width() + 6 * front.row(early),
            turned: row < column,
        }
    }
}

/// Bodies in the order of elimination, and for each the bodies that it is tied to when it is eliminated.
fn least_degree(
    count: usize,
    ties: impl Iterator<Item = [usize; 2]>,
) -> (Vec<usize>, Vec<Vec<usize>>) {
    let mut tied = vec![FixedBitSet::with_capacity(count); count];
    for [one, other] in ties {
        tied[one].insert(other);
        tied[other].insert(one);
    }
    let mut degrees: Vec<usize> = tied.iter().map(|tied| tied.count_ones(..)).collect();
    let mut left: Vec<usize> = (0..count).collect();
    let mut order = Vec::with_capacity(count);
    let mut rests = vec![Vec::new(); count];
    while let Some(next) = (0..left.len()).min_by_key(|&i| degrees[left[i]]) {
        let body = left.swap_remove(next);
        let rest = std::mem::take(&mut tied[body]);
        // The neighbours of a body become neighbours of each other when it goes.
        for other in rest.ones() {
            tied[other].union_with(&rest);
            tied[other].remove(body);
            tied[other].remove(other);
            degrees[other] = tied[other].count_ones(..);
        }
        rests[body] = rest.ones().collect();
        order.push(body);
    }
    (order, rests)
}

/// Another order with the same factor. The parent of a body is the first that is eliminated of those that it is tied to; here all that go into a
/// body stand right before it, the one with the most ties last.
fn children_first(order: &[usize], tied: &[Vec<usize>]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, &body) in order.iter().enumerate() {
        places[body] = place;
    }
    let mut children = vec![Vec::new(); order.len()];
    let mut open = Vec::new();
    for &body in order {
        match tied[body].iter().min_by_key(|&&other| places[other]) {
            Some(&parent) => children[parent].push(body),
            None => open.push(body),
        }
    }
    let mut turned = Vec::with_capacity(order.len());
    while let Some(body) = open.pop() {
        turned.push(body);
        children[body].sort_by_key(|&child| tied[child].len());
        open.append(&mut children[body]);
    }
    turned.reverse();
    turned
}

/// The fronts, and the front of each place. A body joins the front of the one before it where both are tied to the same later ones.
fn fronts(rests: impl Iterator<Item = Vec<usize>>) -> (Vec<Front>, Vec<usize>) {
    let mut fronts: Vec<Front> = Vec::new();
    let mut front_of = Vec::new();
    for (place, rest) in rests.enumerate() {
        match fronts.last_mut() {
            Some(last) if last.rest.first() == Some(&place) && last.rest[1..] == rest => {
                last.own.end += 1;
                last.rest = rest;
            }
            _ => fronts.push(Front {
                own: place..place + 1,
                rest,
                children: Vec::new(),
                start: 0,
            }),
        }
        front_of.push(fronts.len() - 1);
    }
    let mut start = 0;
    for number in 0..fronts.len() {
        fronts[number].start = start;
        start = fronts[number].strips().end;
        if let Some(&next) = fronts[number].rest.first() {
            fronts[front_of[next]].children.push(number);
        }
    }
    (fronts, front_of)
}
