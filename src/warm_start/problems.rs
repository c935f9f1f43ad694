//! The resource with the problems of the awake islands.

use super::{Island, JointOrder, Member, Order};
use crate::body::Velocity;
use crate::settings::ContactSolver;
use bevy_ecs::prelude::*;
use std::fmt;

/// The problems of the awake islands, between the stages *warm start* and *solve*. At any other time it appears empty.
///
/// An island has a problem if some of its bodies touch something, are joined or are held.
#[derive(Resource, Default)]
pub struct IslandProblems {
    pub(crate) set: ProblemSet,
    /// The solver that they are prepared for; `None` if there is nothing to solve.
    pub(crate) prepared: Option<ContactSolver>,
}

impl fmt::Debug for IslandProblems {
    /// Lists the problem of each island.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// The problems of the islands. Their memory and unchanged parts are kept from step to step.
#[derive(Default)]
pub(crate) struct ProblemSet {
    pub order: Order,
    pub islands: Vec<Island>,
    pub joints: JointOrder,
    /// Scratch of *solve*: slots and velocities of the bodies that are in no problem.
    pub outside: Vec<(u32, Velocity)>,
    /// The bodies that are held, in the order of islands and of their grabs.
    pub held: Vec<GrabbedBody>,
}

/// A body that a grab holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GrabbedBody {
    pub island: usize,
    /// Its index in the island.
    pub local: u32,
    pub entity: Entity,
}

impl IslandProblems {
    /// Number of islands that have a problem.
    pub fn len(&self) -> usize {
        self.iter().count()
    }

    /// Returns true if no island has a problem.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The problem of each island, in the order of [`Islands`](crate::graph::Islands).
    pub fn iter(&self) -> impl Iterator<Item = IslandProblem<'_>> {
        let is_prepared = self.prepared.is_some();
        self.set.iter().filter(move |_| is_prepared)
    }
}

impl ProblemSet {
    /// Moves the problem of each island to the island's number. Numbers without a problem get an empty one, or one of an island that is
    /// gone.
    pub fn arrange(&mut self) {
        let Self { order, islands, .. } = self;
        let numbered = order.numbered();
        let ids = islands.iter().map(|island| island.id);
        if ids.eq(numbered.iter().map(|&id| Some(id))) {
            return;
        }
        let count = islands.len().max(numbered.len());
        islands.resize_with(count, Island::default);
        let known = |island: &Island| order.number(island.id?);
        let mut places: Vec<u32> = islands
            .iter()
            .map(|island| known(island).unwrap_or(u32::MAX))
            .collect();
        let mut is_free = vec![true; count];
        for &place in places.iter().filter(|&&place| place != u32::MAX) {
            is_free[place as usize] = false;
        }
        let mut free = (0..)
            .zip(is_free)
            .filter_map(|(at, free)| free.then_some(at));
        for place in places.iter_mut().filter(|place| **place == u32::MAX) {
            *place = free.next().expect("there is a place for every island");
        }
        put_in_place(islands, &mut places);
        islands.truncate(numbered.len());
    }

    fn iter(&self) -> impl Iterator<Item = IslandProblem<'_>> {
        let of_contacts = |island: &&Island| island.is_solved();
        let islands = self.islands.iter().enumerate();
        let islands = islands.filter(move |(_, island)| of_contacts(island));
        islands.map(|(number, island)| {
            let order = self.order.of(number);
            let impulses = (0..island.contacts()).map(|contact| island.start_impulse(contact));
            IslandProblem {
                bodies: &order.bodies,
                contacts: order.pairs().zip(impulses).collect(),
                points: island.points(),
                grabs: island.grabs.len(),
                joints: island.joints.len(),
            }
        })
    }
}

/// The problem of one island, as read through [`IslandProblems`].
#[derive(Debug)]
pub struct IslandProblem<'a> {
    bodies: &'a [Member],
    contacts: Vec<(Entity, f32)>,
    points: usize,
    grabs: usize,
    joints: usize,
}

impl IslandProblem<'_> {
    /// Its dynamic bodies, in the order in which they are solved: from the ground up, and then in spawn order.
    pub fn bodies(&self) -> impl Iterator<Item = Entity> {
        self.bodies.iter().map(|member| member.entity)
    }

    /// The touching pairs in the order in which they are solved, each with the sum of the normal impulses that it starts from, N·s. A
    /// solver applies the share of it that its [warm start](crate::solver::PointSolver::warm_start) says.
    pub fn contacts(&self) -> impl Iterator<Item = (Entity, f32)> {
        self.contacts.iter().copied()
    }

    /// Number of its contact points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Number of its bodies that are held by a grab.
    pub fn grabs(&self) -> usize {
        self.grabs
    }

    /// Number of its joints.
    pub fn joints(&self) -> usize {
        self.joints
    }
}

/// Moves each item to its place.
fn put_in_place<T>(items: &mut [T], places: &mut [u32]) {
    for i in 0..items.len() {
        while places[i] as usize != i {
            let place = places[i] as usize;
            items.swap(i, place);
            places.swap(i, place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_move_to_their_places() {
        let mut places = [3, 0, 2, 4, 1];
        let mut items = places;
        put_in_place(&mut items, &mut places);
        assert_eq!(items, [0, 1, 2, 3, 4]);
    }
}
