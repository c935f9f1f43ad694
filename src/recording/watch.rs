//! Finds what was changed from outside since the last step ended.
//!
//! Change ticks tell what was written: first those of whole columns (Bevy's summary ticks), then, in columns that have changed, those of
//! rows. Values that stages write are older than the tick at the end of the step, so they do not count. An observer notes entities that
//! lost a component, because nothing else tells of it. So a step before which nothing was changed costs a look at each column of each
//! table.

use super::edits::{Row, Touched};
use super::kinds;
use super::resources::{self, Resource};
use crate::body::{Pose, Quarantined, RigidBodyDisabled, SpawnOrder};
use crate::children::CompoundCollider;
use crate::snapshot::{SnapshotError, layout::Kinds};
use crate::solver::sort;
use crate::state;
use crate::stored::{Role, erased::Kind};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_ecs::storage::Table;
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

/// The changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    Nothing,
    /// It was appended to the bytes.
    Edits,
    /// More than components: the state was replaced by a snapshot, or a region was taken out or put back.
    Replaced,
}

/// An entity that lost a component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Removed {
    pub entity: Entity,
    /// Its number in the order of spawning, if it had that before the last step ended.
    pub order: Option<SpawnOrder>,
}

/// The columns of a table that are watched.
struct Columns {
    /// Those with a summary tick.
    summed: Vec<(usize, ComponentId)>,
    /// The others.
    others: Kinds,
    /// Whether its entities are drystone's.
    is_own: bool,
}

/// Whether users add and remove a component of drystone. Entities that have one are drystone's.
fn is_own(kind: Kind) -> bool {
    !matches!(kind.role, Role::Bevy | Role::Pair)
}

/// Watches a world.
pub(super) struct Watch {
    kinds: &'static [Kind],
    /// By kind.
    ids: Vec<ComponentId>,
    transform: ComponentId,
    /// Those that are not kept in tables.
    sparse: Kinds,
    resources: Vec<Resource>,
    resource_ids: Vec<ComponentId>,
    /// By table.
    tables: Vec<Columns>,
    /// All entities of the recording that may still exist.
    known: EntityHashSet,
    /// Those of them that are not drystone's: entities above others, and those that joints wait for.
    others: Vec<Entity>,
    pub removed: Vec<Removed>,
    /// The tick at which the last step ended.
    pub since: Tick,
    touched: Touched,
    /// The row of each entity in `touched`.
    rows: EntityHashMap<usize>,
}

impl Watch {
    pub fn new(world: &mut World) -> Self {
        let kinds = &state::list().components[..];
        let ids: Vec<ComponentId> = kinds.iter().map(|kind| kind.register(world)).collect();
        let resources = resources::all();
        let mut sparse = Kinds::default();
        for (number, kind) in kinds.iter().enumerate() {
            if kind.is_sparse() {
                sparse.insert(number);
            }
        }
        Self {
            ids,
            transform: world.register_component::<Transform>(),
            kinds,
            sparse,
            resource_ids: resources.iter().map(|of| of.kind.register(world)).collect(),
            resources,
            tables: Vec::new(),
            known: EntityHashSet::default(),
            others: Vec::new(),
            removed: Vec::new(),
            since: world.increment_change_tick(),
            touched: Touched::default(),
            rows: EntityHashMap::default(),
        }
    }

    /// The components whose removal is to be noted.
    pub fn removable(&self) -> impl Iterator<Item = ComponentId> {
        let kinds = self.kinds.iter().zip(&self.ids);
        let kinds = kinds.filter(|(kind, _)| !matches!(kind.role, Role::Pair | Role::Stages));
        kinds.map(|(_, &id)| id)
    }

    /// Existing entities that are not drystone's, to which components refer.
    pub fn referred(&self, world: &World) -> Vec<Entity> {
        let mut referred = self.others.clone();
        for &kind in self.kinds {
            kinds::find_referred(kind, world, &mut referred);
        }
        referred.retain(|&entity| world.get_entity(entity).is_ok_and(|it| !self.is_own(it)));
        referred.sort_unstable();
        referred.dedup();
        referred
    }

    /// Begins anew, with the entities of a snapshot.
    pub fn begin(&mut self, world: &World, entities: &[Entity]) {
        self.known = entities.iter().copied().collect();
        let others = entities.iter().copied();
        let others = others.filter(|&entity| {
            let entity = world.get_entity(entity);
            entity.is_ok_and(|entity| !self.is_own(entity) && !self.is_pair(entity))
        });
        self.others = others.collect();
        self.removed.clear();
    }

    /// A step has ended, or the recording begins: what is written from here on comes from outside.
    pub fn begin_outside(&mut self, world: &mut World) {
        for resource in &mut self.resources {
            resource.begin_outside(world);
        }
        self.since = world.increment_change_tick();
    }

    fn is_own(&self, entity: EntityRef) -> bool {
        let mut kinds = self.kinds.iter().zip(&self.ids);
        kinds.any(|(&kind, &id)| is_own(kind) && entity.contains_id(id))
    }

    fn is_pair(&self, entity: EntityRef) -> bool {
        let mut kinds = self.kinds.iter().zip(&self.ids);
        kinds.any(|(&kind, &id)| kind.role == Role::Pair && entity.contains_id(id))
    }

    /// Finds what was changed since the last step ended, and appends it to bytes.
    pub fn find(&mut self, world: &World, out: &mut Vec<u8>) -> Result<Found, SnapshotError> {
        let mut written = self.written_resources(world);
        if written
            .iter()
            .any(|&at| self.resources[at].kind.role == Role::Stages)
        {
            return Ok(Found::Replaced);
        }
        self.touched.gone.clear();
        self.touched.found.clear();
        self.touched.rows.clear();
        self.rows.clear();
        self.find_written(world);
        self.find_others(world);
        self.find_removed(world);
        if self.touched.is_empty() && written.is_empty() {
            return Ok(Found::Nothing);
        }
        if !self.touched.is_empty() {
            let noted = self.resources.iter().enumerate();
            let noted = noted.filter(|(_, resource)| resource.kind.role == Role::Hooks);
            written.extend(noted.map(|(number, _)| number));
            written.sort_unstable();
            written.dedup();
        }
        let mut values = Vec::new();
        // The written values refer to entities that may have to be recorded themselves.
        while self.write_values(world, &mut values)? {}
        self.touched.write(&written, out)?;
        out.append(&mut values);
        for number in written {
            self.resources[number].write(world, out)?;
        }
        Ok(Found::Edits)
    }

    fn written_resources(&self, world: &World) -> Vec<usize> {
        let all = self.resource_ids.iter().enumerate();
        let now = world.read_change_tick();
        let written = all.filter(|&(_, &id)| {
            let ticks = world.get_resource_change_ticks_by_id(id);
            ticks.is_some_and(|ticks| ticks.is_changed(self.since, now))
        });
        written.map(|(number, _)| number).collect()
    }

    /// Finds entities whose components were inserted or written.
    fn find_written(&mut self, world: &World) {
        let tables = &world.storages().tables;
        for table in tables.iter().skip(self.tables.len()) {
            let columns = self.columns_of(table);
            self.tables.push(columns);
        }
        let now = world.read_change_tick();
        let mut written = Kinds::default();
        for (table, columns) in tables.iter().zip(&self.tables) {
            if !columns.is_own || table.is_empty() {
                continue;
            }
            written.extend(columns.others);
            for &(kind, id) in &columns.summed {
                let tick = table.get_summary_tick(id);
                if tick.is_none_or(|tick| tick.get().is_newer_than(self.since, now)) {
                    written.insert(kind);
                }
            }
        }
        let own = &self.tables;
        let is_own = |entity: Entity| {
            let place = world.entities().get(entity).ok().flatten();
            let table = place.and_then(|place| own.get(place.table_id.as_usize()));
            table.is_some_and(|table| table.is_own)
        };
        let (mut found, mut all) = (Vec::new(), Vec::new());
        for (number, &kind) in self.kinds.iter().enumerate() {
            if written.contains(number) {
                kinds::find_written(kind, world, self.since, &is_own, &mut found);
                all.extend(found.drain(..).map(|entity| (number, entity)));
            }
        }
        for (kind, entity) in all {
            let is_transform = self.ids[kind] == self.transform;
            if !(is_transform && self.is_put_back(world, entity)) {
                self.touch(world, entity, Some(kind));
            }
        }
    }

    /// Whether the `Transform` of a body is where the last step left it. Interpolation writes the transforms of all bodies in every frame,
    /// and puts them back before the next step.
    fn is_put_back(&self, world: &World, entity: Entity) -> bool {
        let Ok(body) = world.get_entity(entity) else {
            return false;
        };
        let (Some(pose), Some(drawn)) = (body.get_ref::<Pose>(), body.get::<Transform>()) else {
            return false;
        };
        let bits = |position: Vec3, rotation: Quat| {
            (
                position.to_array().map(f32::to_bits),
                rotation.to_array().map(f32::to_bits),
            )
        };
        let is_excepted = body.contains::<Quarantined>()
            || body.contains::<RigidBodyDisabled>()
            || body.contains::<Disabled>()
            || body.contains::<ChildOf>();
        bits(pose.position, pose.rotation) == bits(drawn.translation, drawn.rotation)
            && drawn.scale == body.get().map_or(Vec3::ONE, CompoundCollider::scale)
            && self.known.contains(&entity)
            && !is_excepted
            && !pose
                .last_changed()
                .is_newer_than(self.since, world.read_change_tick())
    }

    fn columns_of(&self, table: &Table) -> Columns {
        let mut columns = Columns {
            summed: Vec::new(),
            others: Kinds::default(),
            is_own: false,
        };
        for (number, (&kind, &id)) in self.kinds.iter().zip(&self.ids).enumerate() {
            if kind.role != Role::Pair && table.has_column(id) {
                columns.is_own |= is_own(kind);
                match table.get_summary_tick(id) {
                    Some(_) => columns.summed.push((number, id)),
                    None => columns.others.insert(number),
                }
            }
        }
        // It is not kept in tables, so any entity may have it.
        columns.others.extend(self.sparse);
        columns
    }

    /// Looks at entities that are not drystone's.
    fn find_others(&mut self, world: &World) {
        let now = world.read_change_tick();
        for entity in std::mem::take(&mut self.others) {
            let Ok(known) = world.get_entity(entity) else {
                self.lose(entity);
                continue;
            };
            self.others.push(entity);
            for number in 0..self.kinds.len() {
                if self.kinds[number].role == Role::Bevy
                    && let Some(ticks) = known.get_change_ticks_by_id(self.ids[number])
                    && ticks.is_changed(self.since, now)
                {
                    self.touch(world, entity, Some(number));
                }
            }
        }
    }

    fn find_removed(&mut self, world: &World) {
        let mut removed = std::mem::take(&mut self.removed);
        sort::by_key(&mut removed, |removed| removed.entity.to_bits());
        removed.dedup_by_key(|removed| removed.entity);
        for Removed { entity, order } in removed {
            if world.get_entity(entity).is_ok() {
                if self.known.contains(&entity) {
                    self.touch(world, entity, None);
                }
            } else if self.known.contains(&entity) {
                self.lose(entity);
            } else if let Some(order) = order {
                // A stage had spawned it.
                self.touched.found.push((entity, order.0));
                self.touched.gone.push(entity);
            }
        }
    }

    /// An entity was despawned.
    fn lose(&mut self, entity: Entity) {
        if self.known.remove(&entity) {
            self.touched.gone.push(entity);
        }
    }

    /// An entity was written, or has lost components (`None`). One that the recording does not know is recorded as a whole.
    fn touch(&mut self, world: &World, entity: Entity, written: Option<usize>) {
        let mut is_new = false;
        if self.known.insert(entity) {
            match self.order_of_old(world, entity) {
                Some(order) => self.touched.found.push((entity, order.0)),
                None => is_new = true,
            }
        }
        let count = self.touched.rows.len();
        let row = *self.rows.entry(entity).or_insert(count);
        if row == count {
            self.touched.rows.push(Row {
                entity,
                has: None,
                written: Kinds::default(),
            });
        }
        let row = &mut self.touched.rows[row];
        if let Some(written) = written {
            row.written.insert(written);
        }
        if (is_new || written.is_none()) && row.has.is_none() {
            let Ok(known) = world.get_entity(entity) else {
                return;
            };
            let now = world.read_change_tick();
            let mut has = Kinds::default();
            for (number, &id) in self.ids.iter().enumerate() {
                if let Some(ticks) = known.get_change_ticks_by_id(id) {
                    has.insert(number);
                    if is_new || ticks.is_changed(self.since, now) {
                        row.written.insert(number);
                    }
                }
            }
            row.has = Some(has);
            if !self.is_own(known) && !self.others.contains(&entity) {
                self.others.push(entity);
            }
        }
    }

    /// The number of an entity that a stage has spawned.
    fn order_of_old(&self, world: &World, entity: Entity) -> Option<SpawnOrder> {
        let order = world.get_entity(entity).ok()?.get_ref::<SpawnOrder>()?;
        let is_new = order
            .added()
            .is_newer_than(self.since, world.read_change_tick());
        (!is_new).then_some(*order)
    }

    /// Writes the values of all rows. Returns true if there are more rows by now, because values refer to them.
    fn write_values(&mut self, world: &World, out: &mut Vec<u8>) -> Result<bool, SnapshotError> {
        out.clear();
        let mut referred = Vec::new();
        for (number, &kind) in self.kinds.iter().enumerate() {
            for row in &self.touched.rows {
                if row.recorded().contains(number) {
                    kinds::write(kind, world, row.entity, &mut referred, out)?;
                }
            }
        }
        let count = self.touched.rows.len();
        for entity in referred {
            // An entity that does not exist is none for the replay either.
            if !self.known.contains(&entity)
                && let Ok(known) = world.get_entity(entity)
                && !self.is_pair(known)
            {
                self.touch(world, entity, None);
            }
        }
        Ok(self.touched.rows.len() > count)
    }
}
