//! The problem of one island: its bodies, contacts, joints and grabs.

use super::backing::find_backed;
use super::{IslandOrder, Rows, SolveContext, SolverContact};
use crate::body::{BodyState, BodyTable, Velocity};
use crate::revision::Revision;
use crate::settings::Method;
use crate::solver::{Body, Both, GrabConstraint, JointConstraint, SolveReport};
use bevy_platform::collections::HashMap;

/// The data from which islands are gathered.
pub(crate) struct GatherContext<'a> {
    pub table: &'a BodyTable,
    /// By slot: the index of the body in its island.
    pub local: &'a [u32],
    pub context: &'a SolveContext<'a>,
}

impl GatherContext<'_> {
    /// The index of a body in its island, or `None` if it is not solved. The world has no slot.
    pub(super) fn local(&self, slot: u32) -> Option<u32> {
        let local = self.local.get(slot as usize).copied();
        local.filter(|&local| local != u32::MAX)
    }

    /// Whether each body of a contact [dominates](crate::body::Dominance) the other.
    pub(super) fn dominates(&self, contact: &SolverContact) -> [bool; 2] {
        let both = self.table.both(contact.pair.slots);
        both.map_or([false; 2], |[a, b]| [a.dominates(b), b.dominates(a)])
    }
}

/// The problem of one island.
#[derive(Default)]
pub(crate) struct Island {
    /// The awake dynamic bodies, followed by copies of the static and kinematic bodies that they touch, and of dynamic bodies that
    /// [dominate](crate::body::Dominance) others.
    pub bodies: Vec<Body>,
    /// Indices of the two bodies of each contact.
    ends: Vec<[u32; 2]>,
    /// Slots of the copied bodies. Impulses cannot change them, so several islands may have copies.
    copies: Vec<u32>,
    /// The indices of those bodies in the problem, by slot.
    copy_indices: HashMap<u32, u32>,
    /// Whether the ends of contacts and joints are known.
    has_ends: bool,
    /// Whether one of its bodies dominated another when they were found.
    has_dominance: bool,
    /// By contact: whether one body would dominate the other, but what it pushes is [backed](super::backing). Empty if no body dominates
    /// another.
    backed: Vec<bool>,
    /// The grabs that hold some of the bodies.
    pub grabs: Vec<GrabConstraint>,
    /// The joints between the bodies.
    pub joints: Vec<JointConstraint>,
    /// Slots of the bodies of each joint.
    pub joint_slots: Vec<[u32; 2]>,
    pub rows: Rows,
    pub report: SolveReport,
    /// The largest [`SolverEffort`](crate::body::SolverEffort) of its dynamic bodies.
    pub effort: f32,
    /// Whether one of its dynamic bodies has just broken off another one.
    pub broke: bool,
    /// Whether the solve diverged and was undone.
    pub diverged: bool,
    /// Identity of the island, if it has one.
    pub id: Option<u32>,
    /// [Revision](crate::revision) of the order of the island.
    derived_from: Option<Revision>,
    /// Number of its dynamic bodies.
    dynamic: usize,
    /// Number of its contacts in the [`Order`](super::Order).
    pub in_order: usize,
}

impl Island {
    pub fn points(&self) -> usize {
        self.rows.points()
    }

    pub fn contacts(&self) -> usize {
        self.ends.len()
    }

    /// Returns true if some of its bodies touch something, are joined or are held.
    pub fn is_solved(&self) -> bool {
        !self.ends.is_empty() || !self.grabs.is_empty() || !self.joints.is_empty()
    }

    /// The sum of the normal impulses that a contact starts from, N·s.
    pub fn start_impulse(&self, contact: usize) -> f32 {
        self.rows.start_impulse(contact)
    }

    /// Begins a step with the order of an island, or only those of its contacts that still exist. Data of the last step is kept if the
    /// order is the same.
    pub fn begin(&mut self, id: u32, order: &IslandOrder, complete: bool, method: Method) {
        let derived_from = complete.then_some(order.revision);
        if !complete || self.derived_from != derived_from {
            self.reset();
        }
        self.rows.suit(method);
        self.id = Some(id);
        self.derived_from = derived_from;
        self.in_order = order.contacts();
        self.bodies.clear();
        self.grabs.clear();
        self.joints.clear();
        self.joint_slots.clear();
        self.diverged = false;
        self.effort = 1.0;
        self.broke = false;
        self.dynamic = 0;
    }

    /// Drops the data of the last step.
    fn reset(&mut self) {
        self.ends.clear();
        self.copies.clear();
        self.copy_indices.clear();
        self.has_ends = false;
        self.rows.clear();
    }

    /// Adds the next dynamic body in the order.
    pub fn add(&mut self, body: &BodyState, velocity: &Velocity, level: u32, dt: f32) {
        self.dynamic += 1;
        self.effort = self.effort.max(body.properties.effort());
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
            motion_is_exact: false,
            still_below: body.still_below(dt),
            level,
        });
    }

    /// Takes the contacts, and copies of the bodies that they touch and cannot move.
    pub fn gather(&mut self, contacts: &[SolverContact], from: &GatherContext) {
        if self.has_dominance {
            self.keep_backed(contacts, from);
        }
        if !self.has_ends {
            self.find_ends(contacts, from);
        }
        self.place_joints(from.local);
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
        let copies = self.copies.iter().copied();
        copies.zip(self.bodies.iter_mut().skip(self.dynamic))
    }

    /// Finds the contacts in which dominance is suspended. If they are others than in the last step, the rows are between other bodies.
    fn keep_backed(&mut self, contacts: &[SolverContact], from: &GatherContext) {
        let backed = find_backed(contacts, from);
        if backed != self.backed {
            self.reset();
            self.backed = backed;
        }
    }

    fn find_ends(&mut self, contacts: &[SolverContact], from: &GatherContext) {
        self.has_ends = true;
        let mut has_dominance = false;
        let dynamic = self.bodies.len() as u32;
        let (copies, known) = (&mut self.copies, &mut self.copy_indices);
        let mut end = |slot: u32, dominates: bool| {
            from.local(slot).filter(|_| !dominates).unwrap_or_else(|| {
                *known.entry(slot).or_insert_with(|| {
                    copies.push(slot);
                    dynamic + copies.len() as u32 - 1
                })
            })
        };
        let backed = &self.backed;
        let ends = contacts.iter().enumerate().map(|(i, contact)| {
            let [a, b] = contact.pair.slots;
            let mut dominates = from.dominates(contact);
            if dominates != [false; 2] {
                has_dominance = true;
                // Static bodies dominate all.
                let is_backed = backed.get(i).copied().unwrap_or(false);
                dominates = dominates.both(|dominates| dominates && !is_backed);
            }
            [end(a, dominates[0]), end(b, dominates[1])]
        });
        self.ends.extend(ends);
        for slot in self.joint_slots.as_flattened() {
            end(*slot, false);
        }
        let is_first = has_dominance && !self.has_dominance;
        self.has_dominance = has_dominance;
        if is_first {
            self.keep_backed(contacts, from);
            if !self.has_ends {
                self.find_ends(contacts, from);
            }
        }
    }

    /// Sets the indices of the bodies of joints.
    fn place_joints(&mut self, local: &[u32]) {
        for (joint, slots) in self.joints.iter_mut().zip(&self.joint_slots) {
            joint.bodies = slots.both(|slot| match local.get(slot as usize) {
                Some(&local) if local != u32::MAX => local,
                _ => self.copy_indices[&slot],
            });
        }
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
