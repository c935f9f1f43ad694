//! Waking, and the choice of bodies that become inactive: parts of the stage *islands*.
//!
//! These sleeping bodies wake:
//! - A body that the user has moved, pushed or changed, and the two bodies of a contact that ended or was removed.
//! - All bodies that are connected with a static or kinematic body that moves or was changed, or whose [hook](crate::contact::ContactHooks)
//!   was replaced, or with a body that was one.
//! - Bodies that are joined to an awake body, and bodies that are joined to those.
//! - Bodies that awake bodies touch: under [`Waking::Islands`] all that are connected with them, under [`Waking::ByNeed`] those that
//!   [need](need) it.

mod account;
mod need;
mod rising;
mod why;

pub(in crate::graph) use account::Accounts;
pub(in crate::graph) use need::{Need, Sleepers};
pub(in crate::graph) use rising::Rising;
pub use why::{Wake, WakeReason, Wakes};

use crate::body::{BodyState, BodyTable, Velocity};
use crate::graph::islands::{Islands, is_among};
use crate::graph::{ConstraintGraph, edges::EdgeKind, sleeping::Drift};
use crate::pair::Wrench;
use crate::settings::Waking;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use why::Cause;

impl Islands {
    /// Finds the sleeping bodies that wake in this step, and keeps the accounts of those that go on sleeping beside awake bodies.
    pub(in crate::graph) fn find_rising(&mut self, need: &Need, waking: Waking) -> Rising {
        let mut rising = Rising::default();
        if self.sleepers == 0 {
            return rising;
        }
        let &Need { graph, table, .. } = need;
        let world = (graph, table);
        let parted: FixedBitSet = self.parted.iter().map(|&slot| slot as usize).collect();
        for (slot, _) in table.active().filter(|(_, body)| body.disturbed) {
            // A body beside one that was removed is disturbed too.
            let reason = match parted.contains(slot as usize) {
                true => WakeReason::LostContact,
                false => WakeReason::Edited,
            };
            rising.cause = Cause::new(reason, None);
            rising.add(table, slot);
        }
        rising.cause = Cause::new(WakeReason::LostContact, None);
        for &slot in &self.parted {
            rising.add(table, slot);
        }
        let own = rising.slots.len();
        self.find_carried(world, &mut rising);
        self.find_boundary(world);
        match waking {
            Waking::Islands => {
                for &slot in &self.boundary {
                    let awake = |&other: &u32| table.get(other).is_some_and(BodyState::is_awake);
                    let by = graph.neighbours(slot).find(awake);
                    rising.cause = Cause::new(WakeReason::Touched, by);
                    rising.add(table, slot);
                }
                rising.flood(world, 0, |_| true);
            }
            Waking::ByNeed { share } => {
                for i in 0..own {
                    rising.cause = rising.causes[i];
                    need.wake_pushed(rising.slots[i], &mut rising);
                }
                for &slot in &self.parted {
                    rising.cause = Cause::new(WakeReason::LostContact, slot);
                    need.wake_bereft(slot, share, &self.accounts, &mut rising);
                }
                need.wake_touched(&self.boundary, share, &mut self.accounts, &mut rising);
                // From the first touch on, so that copies of the bodies do the same at another time.
                self.unfollowed = match self.boundary.is_empty() {
                    true => 0.0,
                    false => self.unfollowed + need.dt,
                };
                if self.unfollowed >= need.interval && !self.boundary.is_empty() {
                    self.unfollowed = 0.0;
                    rising.cause = Cause::new(WakeReason::LoadChanged, None);
                    need.wake_unsteady(&self.boundary, &self.accounts, share, &mut rising);
                }
                rising.flood(world, 0, |link| link.kind == EdgeKind::Joint);
                need.open(&rising, &mut self.accounts);
            }
        }
        rising
    }

    /// Finds the sleeping bodies that are connected with a static or kinematic body that moves or was changed, or with a body whose kind
    /// has changed.
    fn find_carried(&self, world: (&ConstraintGraph, &BodyTable), rising: &mut Rising) {
        let (graph, table) = world;
        let first = rising.slots.len();
        let mut carried = FixedBitSet::new();
        for (slot, body) in table.active().filter(|(_, body)| !body.is_dynamic()) {
            // A body that does not move is disturbed if the hook of its contacts was replaced.
            let is_hooked = body.disturbed && body.properties.hooks.asks();
            let is_new = body.moved || body.renewed || is_hooked;
            let moves = body.velocity != Velocity::default();
            if !is_new && !moves {
                continue;
            }
            // A new hook may let bodies touch that overlapped before.
            let edges = graph.edges_at(slot);
            let edges = edges.filter(|(_, links)| *links || is_hooked);
            rising.cause = Cause::new(WakeReason::GroundChanged, slot);
            for (link, _) in edges {
                let above = link.other(slot);
                // A body that is added together with its ground may stay asleep on it.
                let together = |above: &BodyState| body.arrived && above.arrived;
                if moves || !table.get(above).is_some_and(together) {
                    rising.add(table, above);
                    if let Some(island) = self.partition.id(above) {
                        carried.grow(self.partition.ids());
                        carried.insert(island as usize);
                    }
                }
            }
        }
        rising.cause = Cause::new(WakeReason::GroundChanged, None);
        let changed = self.changed_kind.iter();
        let beside = changed.flat_map(|&slot| graph.neighbours(slot));
        beside.for_each(|slot| rising.add(table, slot));
        let islands = carried.ones();
        let members = islands.flat_map(|island| self.partition.members(island as u32));
        let beside = members.flat_map(|&slot| graph.neighbours(slot));
        beside.for_each(|slot| rising.add(table, slot));
        rising.flood(world, first, |_| true);
        rising.cause = Cause::default();
    }

    /// The sleeping bodies that awake ones touched at the beginning of the step, by slot, in no defined order.
    pub(crate) fn boundary(&self) -> &[u32] {
        &self.boundary
    }

    /// Returns true if awake bodies have touched a sleeping body since it fell asleep. It wakes when the forces on it have changed
    /// [by a share](Waking::ByNeed) since then.
    pub fn has_open_account(&self, slot: u32) -> bool {
        self.accounts.get(slot).is_some()
    }

    /// The forces with which a sleeping body fell asleep, if an awake body has touched it since.
    pub(crate) fn account(&self, slot: u32) -> Option<Wrench> {
        self.accounts.get(slot)
    }

    /// Opens the account of a sleeping body that is the copy of another.
    pub(crate) fn open_account(&mut self, slot: u32, forces: Wrench) {
        self.accounts.open(slot, forces);
    }

    /// The earlier velocities of a body that is still, if it is.
    pub(crate) fn drift(&self, slot: u32) -> Option<Drift> {
        self.drifts.get(slot)
    }

    /// Takes over what was seen of a body that is the original of another.
    pub(crate) fn set_drift(&mut self, slot: u32, drift: Drift) {
        self.drifts.set(slot, drift);
    }

    /// Opens the accounts of the sleeping bodies of a scene that was loaded in this step.
    pub(in crate::graph) fn restore_accounts(
        &mut self,
        table: &BodyTable,
        restored: &RestoredAccounts,
    ) {
        if restored.is_empty() {
            return;
        }
        for (slot, body) in table.active().filter(|(_, body)| arrives(body)) {
            if let Some(&Some(forces)) = restored.get(&body.entity) {
                self.accounts.open(slot, forces);
            }
        }
    }

    /// Finds the sleeping bodies that are linked to awake ones.
    fn find_boundary(&mut self, (graph, table): (&ConstraintGraph, &BodyTable)) {
        let mut boundary = Rising::default();
        for &island in self.partition.numbered() {
            for &slot in self.partition.members(island) {
                let beside = graph.neighbours(slot);
                beside.for_each(|other| boundary.add(table, other));
            }
        }
        self.boundary = boundary.slots;
    }

    /// Wakes bodies. Inactive ones are marked, and become active next.
    pub(in crate::graph) fn wake(
        &mut self,
        table: &mut BodyTable,
        rising: &Rising,
        sleepers: &mut Sleepers,
    ) {
        self.woke |= !rising.slots.is_empty();
        for &slot in &rising.slots {
            table.mark_dirty(slot);
            let body = table.get_mut(slot).expect("it was just seen");
            body.asleep = false;
            let entity = body.entity;
            if let Ok((mut sleeping, _)) = sleepers.get_mut(entity) {
                // Bevy would mark the column of all inactive bodies as changed, so all of it would be searched. `activate` marks the body
                // in its new table.
                match table.is_inactive(slot) {
                    true => sleeping.bypass_change_detection().wake(),
                    false => sleeping.wake(),
                }
            }
        }
    }

    /// Finds the bodies that were added asleep, with the sleeping bodies that are connected with them: these share the new load, and get
    /// static loads in this step without waking. If they touch awake bodies, those that were added wake instead; bodies of a saved scene
    /// have slept beside awake ones, and go on sleeping. Returns those that wake.
    pub(in crate::graph) fn find_loading(
        &mut self,
        graph: &ConstraintGraph,
        table: &mut BodyTable,
        restored: &RestoredAccounts,
    ) -> Rising {
        let mut rising = Rising::default();
        rising.cause = Cause::new(WakeReason::Added, None);
        let arriving = table.active().filter(|(_, body)| arrives(body));
        let arriving: Vec<u32> = arriving.map(|(slot, _)| slot).collect();
        let mut found = Rising::default();
        for slot in arriving {
            let first = found.slots.len();
            found.add(table, slot);
            found.flood((graph, table), first, |_| true);
            let connected = &found.slots[first..];
            let awake = |slot: u32| table.get(slot).is_some_and(BodyState::is_awake);
            let touches_awake = |&slot: &u32| graph.neighbours(slot).any(awake);
            let slots = connected.iter().copied();
            if connected.iter().any(touches_awake) {
                let is_new =
                    |body: &BodyState| arrives(body) && !restored.contains_key(&body.entity);
                let new = slots.filter(|&slot| table.get(slot).is_some_and(is_new));
                new.for_each(|slot| rising.add(table, slot));
            } else {
                self.loading.extend(slots);
            }
        }
        self.loading.sort_unstable();
        self.loading.dedup();
        for &slot in &self.loading {
            table.mark_dirty(slot);
        }
        rising
    }

    /// Finds the bodies that may become inactive: sleeping bodies, and static and kinematic bodies that do not move.
    pub(in crate::graph) fn find_deactivation(&mut self, table: &BodyTable) {
        let is_loaded = |slot: u32| is_among(&self.loading, slot);
        let rest = table.active();
        let rest = rest.filter(|&(slot, body)| body.may_rest() && !is_loaded(slot));
        let rest = rest.map(|(slot, body)| (slot, body.entity));
        self.deactivation.bodies.extend(rest);
    }
}

/// The entities of a scene that was loaded in this step, with the accounts of sleeping bodies.
pub(in crate::graph) type RestoredAccounts = EntityHashMap<Option<Wrench>>;

/// Returns true for a body that was added asleep in this step.
fn arrives(body: &BodyState) -> bool {
    body.arrived && body.asleep
}

impl BodyState {
    /// Returns true if the body sleeps or stands still, did so in the step before, and was not disturbed.
    pub(in crate::graph) fn may_rest(&self) -> bool {
        let still = match self.is_dynamic() {
            true => self.asleep && !self.disturbed,
            false => self.velocity == Velocity::default() && self.target.is_none(),
        };
        let put = self.moved || self.put_from.is_some();
        still && !put && !self.renewed && !self.arrived
    }
}
