//! The sensors of all bodies with what is inside them, and the tree of their boxes.
//!
//! Invariants:
//! - A zone is a sensor of a body in the [`BodyTable`]. It is identified by its entity, and by the body with its spawn order.
//! - `inside` lists the zones of which a body is a part of the contents, by its slot.
//! - No result depends on the order of zones or on the shape of the tree, which depend on their history.

use crate::body::collider::Collider;
use crate::body::{BodyState, BodyTable, Pose, SpawnOrder, parts::Zone};
use crate::revision::Revision;
use bevy_ecs::entity::{EntityHashMap, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose as ParryPose;
use parry3d::partitioning::{Bvh, BvhWorkspace};
use smallvec::SmallVec;

/// The tree is refitted and optimized after one in this many of its boxes was changed.
const REFIT_SHARE: usize = 16;

/// A collider inside a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Content {
    pub spawn_order: SpawnOrder,
    /// Number of the part; 0 for the body's own collider.
    pub part: u16,
    pub slot: u32,
    pub body: Entity,
    pub collider: Entity,
}

impl Content {
    /// Its place in the order.
    pub fn rank(&self) -> (SpawnOrder, u64, u64) {
        let piece = u64::from(self.part) << 32 | u64::from(self.slot);
        (self.spawn_order, piece, self.collider.to_bits())
    }

    /// The identity of the zone, which stays the same if the body gets another slot or the part another number.
    pub fn identity(&self) -> (Entity, SpawnOrder, Entity) {
        (self.body, self.spawn_order, self.collider)
    }

    /// Whether the body is still in the table, with this part.
    fn lives(&self, table: &BodyTable) -> bool {
        table
            .get(self.slot)
            .is_some_and(|body| (body.entity, body.spawn_order) == (self.body, self.spawn_order))
    }
}

/// A sensor, and what is inside.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Tracked {
    pub entity: Entity,
    pub body: Entity,
    pub spawn_order: SpawnOrder,
    pub slot: u32,
    /// Its number among the sensors of the body when it was last compared.
    pub number: u32,
    /// The pose of its body when it was last compared.
    pub pose: Pose,
    /// In order.
    pub contents: Vec<Content>,
}

impl Tracked {
    /// Its body and its shape, if they are still the same ones.
    pub fn of<'a>(&self, table: &'a BodyTable) -> Option<(&'a BodyState, &'a Zone)> {
        let body = table.get(self.slot)?;
        let is_same = (body.entity, body.spawn_order) == (self.body, self.spawn_order);
        let mut zones = body.parts.as_ref()?.zones().iter();
        let zone = zones.find(|zone| zone.entity == self.entity)?;
        is_same.then_some((body, zone))
    }

    /// The order in which sensors report.
    pub fn rank(&self) -> (SpawnOrder, u32) {
        (self.spawn_order, self.number)
    }
}

/// A zone where its body was in the last step.
pub(crate) struct PlacedZone<'a> {
    pub number: u32,
    /// Its place in the order in which sensors report.
    pub rank: (SpawnOrder, u32),
    /// Its place in the world.
    pub place: ParryPose,
    pub shape: &'a Collider,
}

/// The sensors of all bodies, and what is inside them.
#[derive(Resource, Clone, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(clone_behavior = Ignore, map_entities)]
#[doc(hidden)]
pub struct Sensors {
    /// Index is the leaf in the tree.
    pub(super) zones: Vec<Option<Tracked>>,
    free: Vec<u32>,
    /// By the entity of the sensor.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    known: EntityHashMap<u32>,
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::tree"))]
    tree: Bvh,
    #[cfg_attr(feature = "serde", serde(skip))]
    workspace: BvhWorkspace,
    changed_boxes: usize,
    /// Zones without a box: half-spaces.
    unbounded: Vec<u32>,
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted")
    )]
    inside: HashMap<u32, SmallVec<[u32; 2]>>,
    /// Slots of bodies that joined the simulation at rest since the stage ran last: no query of active bodies has them.
    pub(super) arrived: Vec<u32>,
    /// The revision of the removal of bodies that the contents follow.
    pub(super) departures: Option<Revision>,
}

impl std::fmt::Debug for Sensors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sensors")
            .field("zones", &self.zones)
            .finish_non_exhaustive()
    }
}

impl MapEntities for Sensors {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for zone in self.zones.iter_mut().flatten() {
            zone.entity.map_entities(mapper);
            zone.body.map_entities(mapper);
            for content in &mut zone.contents {
                content.body.map_entities(mapper);
                content.collider.map_entities(mapper);
            }
        }
        let zones = (0..).zip(&self.zones);
        let zones = zones.filter_map(|(number, zone)| Some((zone.as_ref()?.entity, number)));
        self.known = zones.collect();
    }
}

impl Sensors {
    /// Whether there are no sensors.
    pub(super) fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// The zone of a sensor, if it is known.
    pub(super) fn find(&self, sensor: Entity) -> Option<u32> {
        self.known.get(&sensor).copied()
    }

    pub(super) fn get(&self, zone: u32) -> Option<&Tracked> {
        self.zones.get(zone as usize)?.as_ref()
    }

    /// The zone of a sensor as it was in the last step, if it is known.
    pub(crate) fn zone<'a>(&self, sensor: Entity, table: &'a BodyTable) -> Option<PlacedZone<'a>> {
        let number = self.find(sensor)?;
        let tracked = self.get(number)?;
        let (_, zone) = tracked.of(table)?;
        Some(PlacedZone {
            number,
            rank: tracked.rank(),
            place: placed(zone, tracked.pose),
            shape: &zone.shape,
        })
    }

    /// The zones that the body in a slot is inside.
    pub(crate) fn zones_of(&self, slot: u32) -> &[u32] {
        self.inside.get(&slot).map_or(&[], SmallVec::as_slice)
    }

    /// Whether a part of a body is inside a zone.
    pub(crate) fn contains(&self, zone: u32, (slot, body): (u32, &BodyState), part: u16) -> bool {
        let wanted = (body.spawn_order, part, slot);
        let place = |content: &Content| (content.spawn_order, content.part, content.slot);
        self.get(zone)
            .is_some_and(|zone| zone.contents.binary_search_by_key(&wanted, place).is_ok())
    }

    /// What a sensor knows of a collider that is inside.
    pub(super) fn content(&self, sensor: Entity, collider: Entity) -> Option<&Content> {
        let contents = &self.get(self.find(sensor)?)?.contents;
        contents.iter().find(|content| content.collider == collider)
    }

    /// Adds a zone that has not been compared with anything.
    pub(super) fn add(&mut self, body: &BodyState, slot: u32, entity: Entity) -> u32 {
        let zone = self.free.pop().unwrap_or_else(|| {
            self.zones.push(None);
            self.zones.len() as u32 - 1
        });
        self.known.insert(entity, zone);
        self.zones[zone as usize] = Some(Tracked {
            entity,
            body: body.entity,
            spawn_order: body.spawn_order,
            slot,
            number: 0,
            pose: body.pose,
            contents: Vec::new(),
        });
        zone
    }

    /// Has the stage compare bodies that join the simulation at rest, by their slots.
    pub(crate) fn note_arrived(&mut self, slots: impl IntoIterator<Item = u32>) {
        self.arrived.extend(slots);
    }

    /// Removes a zone, and returns it.
    pub(super) fn remove(&mut self, zone: u32) -> Option<Tracked> {
        self.replace(zone, Vec::new());
        let tracked = self.zones[zone as usize].take()?;
        self.known.remove(&tracked.entity);
        self.tree.remove(zone);
        self.unbounded.retain(|other| *other != zone);
        self.free.push(zone);
        Some(tracked)
    }

    /// Sets number, pose and box of a zone; the box is `None` if it has no end.
    pub(super) fn place(&mut self, zone: u32, number: u32, pose: Pose, aabb: Option<Aabb>) {
        if let Some(tracked) = &mut self.zones[zone as usize] {
            tracked.number = number;
            tracked.pose = pose;
        }
        self.unbounded.retain(|other| *other != zone);
        match aabb {
            Some(aabb) => self.tree.insert(aabb, zone),
            None => {
                self.tree.remove(zone);
                self.unbounded.push(zone);
            }
        }
        self.changed_boxes += 1;
    }

    /// Keeps the tree in shape.
    pub(super) fn tidy(&mut self) {
        if self.changed_boxes * REFIT_SHARE > self.tree.leaf_count() as usize {
            self.changed_boxes = 0;
            self.tree.refit(&mut self.workspace);
            self.tree.optimize_incremental(&mut self.workspace);
        }
    }

    /// The zones that a body in a slot is inside, or that its box intersects; `None` is an unbounded box.
    pub(super) fn near(&self, slot: u32, aabb: Option<&Aabb>) -> Vec<u32> {
        let inside = self.inside.get(&slot).into_iter().flatten().copied();
        let mut near: Vec<u32> = inside.chain(self.unbounded.iter().copied()).collect();
        match aabb {
            Some(aabb) => near.extend(self.tree.intersect_aabb(aabb)),
            None => near.extend(self.known.values().copied()),
        }
        near.sort_unstable();
        near.dedup();
        near
    }

    /// The slots of contents that are no bodies any more, each with its zone.
    pub(super) fn gone(&self, table: &BodyTable) -> Vec<(u32, u32)> {
        let zones = (0..).zip(&self.zones);
        let zones = zones.filter_map(|(number, zone)| Some((number, zone.as_ref()?)));
        let gone = zones.flat_map(|(number, zone)| {
            let gone = zone.contents.iter().filter(|known| !known.lives(table));
            gone.map(move |known| (number, known.slot))
        });
        gone.collect()
    }

    /// Replaces the contents of a zone, and returns the old ones.
    pub(super) fn replace(&mut self, zone: u32, contents: Vec<Content>) -> Vec<Content> {
        let Some(tracked) = &mut self.zones[zone as usize] else {
            return Vec::new();
        };
        for content in &contents {
            let zones = self.inside.entry(content.slot).or_default();
            if !zones.contains(&zone) {
                zones.push(zone);
            }
        }
        let old = std::mem::replace(&mut tracked.contents, contents);
        for content in &old {
            if tracked.contents.iter().any(|new| new.slot == content.slot) {
                continue;
            }
            if let Some(zones) = self.inside.get_mut(&content.slot) {
                zones.retain(|other| *other != zone);
                if zones.is_empty() {
                    self.inside.remove(&content.slot);
                }
            }
        }
        old
    }
}

/// The pose of a zone in the world.
pub(super) fn placed(zone: &Zone, pose: Pose) -> ParryPose {
    pose.to_parry() * zone.at
}

/// The box of a zone; `None` if it has no end.
pub(super) fn box_of(zone: &Zone, pose: Pose) -> Option<Aabb> {
    let shape = zone.shape.shape();
    let bounded = shape.as_halfspace().is_none();
    bounded.then(|| shape.compute_aabb(&placed(zone, pose)))
}
