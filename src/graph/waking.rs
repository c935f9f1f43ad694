//! Waking, and the choice of bodies that become inactive: parts of the stage *islands*.

use super::ConstraintGraph;
use super::islands::Islands;
use crate::body::{BodyState, BodyTable, Sleeping, Velocity};
use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

impl Islands {
    /// Finds the islands that are awake. An island sleeps and wakes as a whole: it is awake if any of its bodies is awake, was disturbed by
    /// the user, touches a static or kinematic body that moves, or has parted from a body that supported it or held it down.
    pub(super) fn find_awake(&mut self, graph: &ConstraintGraph, table: &BodyTable) -> FixedBitSet {
        let mut awake = std::mem::take(&mut self.awake);
        awake.clear();
        awake.grow(self.partition.ids());
        let mut wake = |slot: u32| {
            if let Some(island) = self.partition.id(slot) {
                awake.insert(island as usize);
            }
        };
        for (slot, body) in table.active() {
            if body.is_dynamic() {
                if !body.asleep || body.disturbed {
                    wake(slot);
                }
                continue;
            }
            let is_new = body.moved || body.renewed;
            let moves = body.velocity != Velocity::default();
            if !is_new && !moves {
                continue;
            }
            for carried in graph.neighbours(slot) {
                // A body that is added together with its ground may stay asleep on it.
                let together = |above: &BodyState| body.arrived && above.arrived;
                if moves || !table.get(carried).is_some_and(together) {
                    wake(carried);
                }
            }
        }
        self.parted.as_flattened().iter().copied().for_each(wake);
        awake
    }

    /// Wakes all bodies of awake islands. Inactive ones are marked, and become active next.
    pub(super) fn wake(
        &mut self,
        table: &mut BodyTable,
        awake: &FixedBitSet,
        sleepers: &mut Query<&mut Sleeping>,
    ) {
        let is_awake = |slot: u32| {
            let island = self.partition.id(slot);
            island.is_some_and(|island| awake.contains(island as usize))
        };
        let asleep = table.active().filter(|(_, body)| body.asleep);
        let asleep = asleep.map(|(slot, _)| slot);
        let mut rising: Vec<u32> = asleep.filter(|&slot| is_awake(slot)).collect();
        for island in awake.ones() {
            for slot in self.resting_members(table, island as u32) {
                table.mark_dirty(slot);
                rising.push(slot);
            }
        }
        self.woke = !rising.is_empty();
        for slot in rising {
            let body = table.get_mut(slot).expect("it was just seen");
            body.asleep = false;
            if let Ok(mut sleeping) = sleepers.get_mut(body.entity) {
                sleeping.wake();
            }
        }
    }

    /// The inactive members of an island.
    fn resting_members(&self, table: &BodyTable, island: u32) -> Vec<u32> {
        if !self.partition.has_resting(island) {
            return Vec::new();
        }
        let members = self.partition.members(island).iter().copied();
        members.filter(|&slot| table.is_inactive(slot)).collect()
    }

    /// Finds sleeping islands that bodies were added to in this step.
    pub(super) fn find_arriving(&mut self, table: &BodyTable) {
        self.arriving.clear();
        let comes = |body: &BodyState| body.arrived && body.asleep;
        if !table.active().any(|(_, body)| comes(body)) {
            return;
        }
        self.arriving.resize(self.count(), false);
        let mut awake = vec![false; self.count()];
        for (slot, body) in table.active() {
            if let Some(island) = self.of(slot) {
                self.arriving[island] |= comes(body);
                awake[island] |= body.is_awake();
            }
        }
        for (arriving, awake) in self.arriving.iter_mut().zip(awake) {
            *arriving &= !awake;
        }
    }

    /// Activates the inactive members of islands that bodies were added to, because the whole island shares the new load and is solved in this
    /// step. The island stays asleep.
    pub(super) fn activate_arriving(&mut self, table: &mut BodyTable) {
        for (number, &island) in self.partition.numbered().iter().enumerate() {
            if self.arrives(number) {
                for slot in self.resting_members(table, island) {
                    table.mark_dirty(slot);
                }
            }
        }
    }

    /// Finds the bodies that may become inactive: those of sleeping islands, and static and kinematic bodies that do not move.
    pub(super) fn find_deactivation(&mut self, table: &BodyTable, awake: &FixedBitSet) {
        let mut restless = std::mem::take(&mut self.restless);
        restless.clear();
        restless.union_with(awake);
        for (slot, body) in table.active() {
            let may_rest = body.may_rest();
            match self.partition.id(slot) {
                Some(island) if !may_rest => restless.insert(island as usize),
                None if may_rest => self.deactivation.bodies.push((slot, body.entity)),
                _ => (),
            }
        }
        for (slot, body) in table.active() {
            let island = self.partition.id(slot);
            if island.is_some_and(|island| !restless.contains(island as usize)) {
                self.deactivation.bodies.push((slot, body.entity));
            }
        }
        self.restless = restless;
    }
}

impl BodyState {
    /// Returns true if the body sleeps or stands still, did so in the step before, and was not disturbed.
    pub(super) fn may_rest(&self) -> bool {
        let still = match self.is_dynamic() {
            true => self.asleep && !self.disturbed,
            false => self.velocity == Velocity::default() && self.target.is_none(),
        };
        let put = self.moved || self.put_from.is_some();
        still && !put && !self.renewed && !self.arrived
    }
}
