//! The order in which a Cholesky factorization eliminates bodies, and the layout of its factor.
//!
//! The order depends only on which bodies touch, so it is computed once for all rounds. The next body is always one with the fewest
//! remaining neighbours (minimum degree), which keeps the factor sparse.

use crate::solver::sort;
use fixedbitset::FixedBitSet;
use std::ops::Range;

/// An order of elimination and its fronts. Each front comes before its parent.
pub(super) struct Plan {
    /// The position of each body in the order.
    pub places: Vec<usize>,
    pub fronts: Vec<Front>,
    /// The front of each position.
    front_of: Vec<usize>,
}

/// Bodies that are eliminated together, as the first rows of a dense matrix.
pub(super) struct Front {
    /// Their positions.
    pub own: Range<usize>,
    /// The positions of later bodies that are their neighbours, in ascending order: the other rows.
    pub rest: Vec<usize>,
    /// The fronts that contribute to this one.
    pub children: Vec<usize>,
    /// The index of its first strip. A strip is a row of blocks, one for each of its own bodies.
    start: usize,
}

/// The location of the block of two bodies.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    /// The index of its first column among all strips.
    pub start: usize,
    /// Whether the transposed block is stored.
    pub transposed: bool,
}

impl Front {
    /// Number of columns of a strip.
    pub fn width(&self) -> usize {
        6 * self.own.len()
    }

    /// The range of its strips among all.
    pub fn strips(&self) -> Range<usize> {
        let rows = self.own.len() + self.rest.len();
        self.start..self.start + rows * self.width()
    }

    /// The row of a position.
    pub fn row(&self, place: usize) -> usize {
        if place < self.own.end {
            return place - self.own.start;
        }
        let found = self.rest.binary_search(&place);
        self.own.len() + found.expect("a front contains all neighbours of its bodies")
    }
}

impl Plan {
    /// Computes the order for `count` bodies, of which these pairs touch.
    pub fn new(count: usize, ties: impl Iterator<Item = [usize; 2]>) -> Self {
        let (order, tied) = least_degree(count, ties);
        let order = children_first(&order, &tied);
        let mut places = vec![0; count];
        for (place, &body) in order.iter().enumerate() {
            places[body] = place;
        }
        let rests = order.iter().map(|&body| {
            let mut rest: Vec<usize> = tied[body].iter().map(|&other| places[other]).collect();
            sort::values(&mut rest);
            rest
        });
        let (fronts, front_of) = fronts(rests);
        Self {
            places,
            fronts,
            front_of,
        }
    }

    /// The location of the block of a body with itself, or of two bodies that touch.
    pub fn spot(&self, row: usize, column: usize) -> Spot {
        let [row, column] = [self.places[row], self.places[column]];
        let [early, late] = [row.min(column), row.max(column)];
        let front = &self.fronts[self.front_of[early]];
        Spot {
            start: front.start + front.row(late) * front.width() + 6 * front.row(early),
            transposed: row < column,
        }
    }
}

/// Returns the bodies in an order of elimination, and the neighbours of each when it is eliminated.
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

/// Returns an equivalent order, in which all children of a body come directly before it, the one with the most neighbours last. The parent
/// of a body is the first of its remaining neighbours to be eliminated.
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
    let mut reversed = Vec::with_capacity(order.len());
    while let Some(body) = open.pop() {
        reversed.push(body);
        sort::by_key(&mut children[body], |&child| tied[child].len());
        open.append(&mut children[body]);
    }
    reversed.reverse();
    reversed
}

/// Returns the fronts, and the front of each position. A body joins the front of the previous body if both have the same later neighbours.
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
