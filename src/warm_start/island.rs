//! The problem of one island: its bodies, contacts and grabs.

use super::{SolveContext, SolverContact};
use crate::body::{BodyState, BodyTable, Velocity};
use crate::solver::{Body, GrabConstraint, SolveReport};
use bevy_platform::collections::HashMap;
use std::ops::Range;

/// The contacts of an island in the form that a kind of solver needs: points or patches.
pub(crate) trait Rows: Default + Send + Sync {
    fn clear(&mut self);

    /// Number of contact points.
    fn points(&self) -> usize;

    /// Takes the contacts of an island, between bodies at `ends`. Impulses are still forces, N. If the rows hold those of the last step, which
    /// were of the same pairs between the same bodies, unchanged rows may be kept.
    fn refresh(
        &mut self,
        contacts: &[SolverContact],
        ends: &[[u32; 2]],
        bodies: &[Body],
        context: &SolveContext,
    );

    /// Sets the impulses that contacts start from.
    fn warm_start(&mut self, contacts: &[SolverContact], context: &SolveContext);

    /// The sum of the normal impulses that a contact starts from, N·s.
    fn start_impulse(&self, contact: usize) -> f32;
}

/// The data from which islands are gathered.
pub(crate) struct GatherContext<'a> {
    pub table: &'a BodyTable,
    /// By slot: the index of the body in its island.
    pub local: &'a [u32],
    pub context: &'a SolveContext<'a>,
}

/// The problem of one island.
#[derive(Default)]
pub(crate) struct Island<R> {
    /// The awake dynamic bodies, followed by copies of the static and kinematic bodies that they touch, and of dynamic bodies that
    /// [dominate](crate::body::Dominance) others.
    pub bodies: Vec<Body>,
    /// Indices of the two bodies of each contact.
    ends: Vec<[u32; 2]>,
    /// Slots of the copied bodies. Impulses cannot change them, so several islands may have copies.
    copies: Vec<u32>,
    /// The grabs that hold some of the bodies.
    pub grabs: Vec<GrabConstraint>,
    pub rows: R,
    pub report: SolveReport,
    /// Whether the solve diverged and was undone.
    pub diverged: bool,
    /// Range of its dynamic bodies in the [`Order`](super::Order).
    members: Range<u32>,
    /// Index of its first contact in the order.
    pub first_contact: u32,
}

impl<R: Rows> Island<R> {
    pub fn points(&self) -> usize {
        self.rows.points()
    }

    pub fn contacts(&self) -> usize {
        self.ends.len()
    }

    /// Returns true if some of its bodies touch something or are held.
    pub fn is_solved(&self) -> bool {
        !self.ends.is_empty() || !self.grabs.is_empty()
    }

    pub fn members(&self) -> Range<usize> {
        self.members.start as usize..self.members.end as usize
    }

    /// The sum of the normal impulses that a contact starts from, N·s.
    pub fn start_impulse(&self, contact: usize) -> f32 {
        self.rows.start_impulse(contact)
    }

    /// Empties the problem, except for the data of the last step that is kept while no contact begins or ends.
    pub fn begin(&mut self, kept: bool) {
        self.bodies.clear();
        self.grabs.clear();
        self.diverged = false;
        self.members = 0..0;
        if !kept {
            self.ends.clear();
            self.copies.clear();
            self.rows.clear();
        }
    }

    /// Adds a dynamic body with index `number` in the order.
    pub fn add(&mut self, number: u32, body: &BodyState, velocity: &Velocity, level: u32) {
        if self.bodies.is_empty() {
            self.members.start = number;
        }
        self.members.end = number + 1;
        let mut start = body.velocity;
        body.properties.locked_axes.stop(&mut start);
        self.bodies.push(Body {
            linear: velocity.linear,
            inverse_mass: body.mass.inverse_mass,
            free_axes: body.properties.locked_axes.free_translations(),
            angular: velocity.angular,
            inverse_inertia: body.world_inverse_inertia(),
            start: [start.linear, start.angular],
            motion: None,
            level,
        });
    }

    /// Takes the contacts, and copies of the bodies that they touch and cannot move.
    pub fn gather(&mut self, contacts: &[SolverContact], from: &GatherContext) {
        if self.ends.is_empty() {
            self.find_ends(contacts, from);
        }
        self.add_copies(from.table);
        self.rows
            .refresh(contacts, &self.ends, &self.bodies, from.context);
    }

    /// Sets the impulses that contacts start from.
    pub fn warm_start(&mut self, contacts: &[SolverContact], context: &SolveContext) {
        self.rows.warm_start(contacts, context);
    }

    /// The copied bodies, by slot.
    pub fn copies(&mut self) -> impl Iterator<Item = (u32, &mut Body)> {
        let dynamic = self.members().len();
        let copies = self.copies.iter().copied();
        copies.zip(self.bodies.iter_mut().skip(dynamic))
    }

    fn find_ends(&mut self, contacts: &[SolverContact], from: &GatherContext) {
        let mut known: HashMap<u32, u32> = HashMap::default();
        let dynamic = self.bodies.len() as u32;
        let copies = &mut self.copies;
        let mut end = |slot: u32, dominates: bool| match from.local[slot as usize] {
            local if local != u32::MAX && !dominates => local,
            _ => *known.entry(slot).or_insert_with(|| {
                copies.push(slot);
                dynamic + copies.len() as u32 - 1
            }),
        };
        let ends = contacts.iter().map(|contact| {
            let [a, b] = contact.pair.slots;
            let dominates = from.table.both([a, b]);
            let dominates = dominates.map_or([false; 2], |[a, b]| [a.dominates(b), b.dominates(a)]);
            [end(a, dominates[0]), end(b, dominates[1])]
        });
        self.ends.extend(ends);
    }

    fn add_copies(&mut self, table: &BodyTable) {
        let copies = self.copies.iter().map(|&slot| {
            // Inactive bodies do not move.
            let body = table.get(slot).filter(|_| !table.is_inactive(slot));
            let Velocity { linear, angular } = body.map(|body| body.velocity).unwrap_or_default();
            Body {
                linear,
                angular,
                start: [linear, angular],
                ..Default::default()
            }
        });
        self.bodies.extend(copies);
    }
}
