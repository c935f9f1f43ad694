//! The system of the stage *sensors*.

use super::detect::Detector;
use super::events::{SensorEntered, SensorExited, UntriggeredSensorEvents};
use super::zones::{Content, Sensors, Tracked, box_of};
use crate::body::{
    BodyIndex, BodyState, BodyTable, PlacedActive, PlacedBodies, Pose, RigidBody, SensorOverlap,
    SensorOverlaps, parts::CompoundCollider,
};
use crate::broadphase::Broadphase;
use crate::restored::Restored;
use crate::solver::{Both, sort};
use bevy_ecs::prelude::*;
use parry3d::bounding_volume::BoundingVolume;

type WithSensors<'w, 's> =
    Query<'w, 's, &'static BodyIndex, (With<RigidBody>, With<CompoundCollider>)>;

/// Compares sensors with bodies, where one of the two has moved or changed.
pub fn sensors(
    mut sensors: ResMut<Sensors>,
    (table, broadphase): (Res<BodyTable>, Res<Broadphase>),
    owners: WithSensors,
    (active, poses): (PlacedActive, PlacedBodies),
    mut overlaps: Query<&mut SensorOverlaps>,
    mut restored: ResMut<Restored>,
    mut reports: Reports,
) {
    let mut arrived = std::mem::take(&mut sensors.arrived);
    if sensors.is_empty() && owners.is_empty() {
        return;
    }
    arrived.sort_unstable();
    let mut changes = Vec::new();
    let moved = find_moved_zones(&mut sensors, &table, &owners, &poses, &mut changes);
    if !sensors.is_empty() || !changes.is_empty() {
        let mut stage = Stage {
            sensors: &mut sensors,
            table: &table,
            broadphase: &broadphase,
            poses: &poses,
            changes,
        };
        stage.forget_removed();
        for &zone in &moved {
            stage.compare_zone(zone);
        }
        for slot in arrived {
            if let Some(body) = table.get(slot)
                && let Some(pose) = pose_of(&poses, body)
            {
                stage.compare_body(slot, body, pose, &moved);
            }
        }
        for ((_, _, index, pose, _), _) in &active {
            let body = table.get(index.0);
            if let Some(body) = body.filter(|body| has_changed(body, pose)) {
                stage.compare_body(index.0, body, *pose, &moved);
            }
        }
        changes = stage.changes;
    }
    if restored.has_inside() {
        let inside = restored.take_inside();
        for change in &mut changes {
            let saved = inside.get(&change.sensor).map_or(&[][..], Vec::as_slice);
            change.entered.retain(|content| {
                let mut saved = saved.iter();
                saved.all(|known| (known.body, known.collider) != (content.body, content.collider))
            });
        }
    }
    // Several bodies may have changed the same zone.
    sort::by_key(&mut changes, |change| change.rank);
    for change in changes.chunk_by(|one, other| one.rank == other.rank) {
        let sensor = change[0].sensor;
        let of = [sensor, change[0].body];
        // A body that was taken out and put back between two steps has neither left nor come in.
        let exited = missing_in_any(change, |change| &change.entered, |change| &change.exited);
        let entered = missing_in_any(change, |change| &change.exited, |change| &change.entered);
        reports.exits(of, &exited);
        reports.enters(of, &entered);
        if let Ok(mut inside) = overlaps.get_mut(sensor) {
            let zone = change[0].zone.and_then(|zone| sensors.get(zone));
            let contents = zone.map_or(&[][..], |zone| &zone.contents);
            let contents = contents.iter().map(|content| SensorOverlap {
                body: content.body,
                collider: content.collider,
            });
            inside.0 = contents.collect();
        }
    }
}

/// The changes of a sensor since the last step.
struct Change {
    /// `None` if the sensor was removed.
    zone: Option<u32>,
    rank: (crate::body::SpawnOrder, u32),
    sensor: Entity,
    body: Entity,
    exited: Vec<Content>,
    entered: Vec<Content>,
}

impl Change {
    fn of(tracked: &Tracked, zone: Option<u32>) -> Self {
        Self {
            zone,
            rank: tracked.rank(),
            sensor: tracked.entity,
            body: tracked.body,
            exited: Vec::new(),
            entered: Vec::new(),
        }
    }
}

/// Messages, and events for observers.
#[derive(bevy_ecs::system::SystemParam)]
pub struct Reports<'w> {
    entered: MessageWriter<'w, SensorEntered>,
    exited: MessageWriter<'w, SensorExited>,
    untriggered: ResMut<'w, UntriggeredSensorEvents>,
}

impl std::fmt::Debug for Reports<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Reports").finish_non_exhaustive()
    }
}

impl Reports<'_> {
    fn exits(&mut self, [sensor, sensor_body]: [Entity; 2], contents: &[Content]) {
        for content in contents {
            let event = SensorExited {
                sensor,
                sensor_body,
                body: content.body,
                collider: content.collider,
            };
            self.exited.write(event);
            self.untriggered.exited.push(event);
        }
    }

    fn enters(&mut self, [sensor, sensor_body]: [Entity; 2], contents: &[Content]) {
        for content in contents {
            let event = SensorEntered {
                sensor,
                sensor_body,
                body: content.body,
                collider: content.collider,
            };
            self.entered.write(event);
            self.untriggered.entered.push(event);
        }
    }
}

/// The pose of a body at the end of the step.
fn pose_of(poses: &PlacedBodies, body: &BodyState) -> Option<Pose> {
    let ((_, _, _, &pose, _), _) = poses.get(body.entity).ok()?;
    Some(pose)
}

/// Brings the list of zones up to date. Returns those that are new, have moved or were changed, in order.
fn find_moved_zones(
    sensors: &mut Sensors,
    table: &BodyTable,
    owners: &WithSensors,
    poses: &PlacedBodies,
    changes: &mut Vec<Change>,
) -> Vec<u32> {
    let is_gone = |zone: &Tracked| zone.of(table).is_none();
    let gone = (0..).zip(&sensors.zones);
    let gone = gone.filter(|(_, zone)| zone.as_ref().is_some_and(is_gone));
    let gone: Vec<u32> = gone.map(|(zone, _)| zone).collect();
    for zone in gone {
        let contents = sensors.get(zone).map(|zone| zone.contents.clone());
        if let (Some(exited), Some(removed)) = (contents, sensors.remove(zone)) {
            changes.push(Change {
                exited,
                ..Change::of(&removed, None)
            });
        }
    }
    let mut moved = Vec::new();
    for index in owners {
        let Some(body) = table.get(index.0) else {
            continue;
        };
        let zones = body.parts.as_ref().map_or(&[][..], |parts| parts.zones());
        if zones.is_empty() {
            continue;
        }
        let Some(pose) = pose_of(poses, body) else {
            continue;
        };
        for (number, zone) in (0..).zip(zones) {
            let known = sensors.find(zone.entity);
            let stays = known.and_then(|known| sensors.get(known));
            if !body.renewed && stays.is_some_and(|stays| stays.pose == pose) {
                continue;
            }
            let known = known.unwrap_or_else(|| sensors.add(body, index.0, zone.entity));
            sensors.place(known, number, pose, box_of(zone, pose));
            moved.push(known);
        }
    }
    sensors.tidy();
    moved.sort_unstable();
    moved
}

struct Stage<'a, 'w, 's> {
    sensors: &'a mut Sensors,
    table: &'a BodyTable,
    broadphase: &'a Broadphase,
    poses: &'a PlacedBodies<'w, 's>,
    changes: Vec<Change>,
}

impl Stage<'_, '_, '_> {
    /// Takes bodies out of zones that are not in the table any more.
    fn forget_removed(&mut self) {
        let departures = self.table.departures();
        if self.sensors.departures.replace(departures) == Some(departures) {
            return;
        }
        let mut gone = self.sensors.gone(self.table);
        gone.dedup();
        for (zone, slot) in gone {
            self.update(zone, slot, Vec::new());
        }
    }

    /// Compares a zone with all bodies near it.
    fn compare_zone(&mut self, zone: u32) {
        let Some(tracked) = self.sensors.get(zone) else {
            return;
        };
        let Some((body, shape)) = tracked.of(self.table) else {
            return;
        };
        let detector = Detector {
            body,
            zone: shape,
            pose: tracked.pose,
        };
        let boxes = [body.pose, tracked.pose].both(|pose| box_of(shape, pose));
        let whole = boxes[0].zip(boxes[1]).map(|(a, b)| a.merged(&b));
        let mut slots: Vec<u32> = match whole {
            Some(aabb) => {
                let near = self.broadphase.tree().intersect_aabb(&aabb);
                near.chain(self.broadphase.outside()).collect()
            }
            None => self.table.iter().map(|(slot, _)| slot).collect(),
        };
        slots.sort_unstable();
        slots.dedup();
        let mut found = Vec::new();
        for slot in slots {
            if let Some(body) = self.table.get(slot)
                && let Some(pose) = pose_of(self.poses, body)
            {
                detector.detect(body, slot, pose, &mut found);
            }
        }
        sort::by_key(&mut found, Content::rank);
        self.set(zone, found);
    }

    /// Compares a body that has arrived, moved or changed with the zones near it.
    fn compare_body(&mut self, slot: u32, body: &BodyState, pose: Pose, compared: &[u32]) {
        let aabb = match body.shape() {
            Some(shape) if body.radius.is_finite() => {
                let [from, to] =
                    [body.pose, pose].both(|pose| shape.compute_aabb(&pose.to_parry()));
                Some(from.merged(&to))
            }
            _ => None,
        };
        for zone in self.sensors.near(slot, aabb.as_ref()) {
            if compared.binary_search(&zone).is_ok() {
                continue;
            }
            let Some(tracked) = self.sensors.get(zone) else {
                continue;
            };
            let Some((owner, shape)) = tracked.of(self.table) else {
                continue;
            };
            let detector = Detector {
                body: owner,
                zone: shape,
                pose: tracked.pose,
            };
            let mut found = Vec::new();
            detector.detect(body, slot, pose, &mut found);
            self.update(zone, slot, found);
        }
    }

    /// Sets which colliders of the body in a slot are inside a zone.
    fn update(&mut self, zone: u32, slot: u32, found: Vec<Content>) {
        let Some(tracked) = self.sensors.get(zone) else {
            return;
        };
        let known = tracked.contents.iter().filter(|known| known.slot == slot);
        if known.eq(&found) {
            return;
        }
        let mut contents = tracked.contents.clone();
        contents.retain(|known| known.slot != slot);
        contents.extend(found);
        sort::by_key(&mut contents, Content::rank);
        self.set(zone, contents);
    }

    fn set(&mut self, zone: u32, contents: Vec<Content>) {
        let Some(tracked) = self.sensors.get(zone) else {
            return;
        };
        if tracked.contents == contents {
            return;
        }
        let mut change = Change::of(tracked, Some(zone));
        change.entered = missing_in(&tracked.contents, &contents);
        change.exited = missing_in(&contents, &tracked.contents);
        self.changes.push(change);
        self.sensors.replace(zone, contents);
    }
}

/// The colliders in one list of some changes that are in none of the other.
fn missing_in_any(
    changes: &[Change],
    these: fn(&Change) -> &[Content],
    those: fn(&Change) -> &[Content],
) -> Vec<Content> {
    let those = changes.iter().flat_map(those);
    let is_missing = |content: &&Content| {
        let mut these = changes.iter().flat_map(these);
        these.all(|other| other.identity() != content.identity())
    };
    those.filter(is_missing).copied().collect()
}

/// The colliders that are in `those` and not in `these`. The number of a part may have changed.
fn missing_in(these: &[Content], those: &[Content]) -> Vec<Content> {
    let is_missing = |content: &&Content| {
        let mut others = these.iter();
        these.binary_search(content).is_err()
            && others.all(|other| other.identity() != content.identity())
    };
    those.iter().filter(is_missing).copied().collect()
}

/// Whether a body has moved or changed since the end of the last step.
fn has_changed(body: &BodyState, pose: &Pose) -> bool {
    body.pose != *pose || body.moved || body.renewed || body.arrived || body.put_from.is_some()
}
