//! The shape and mass of a body that consists of several colliders, or whose collider is scaled or a sensor.

use super::in_table::{BodyPart, BodyParts, Zone};
use super::{Part, gather};
use crate::body::collider::{Collider, CollisionLayers, Moments};
use crate::body::{
    AngularInertia, BodyProperties, CenterOfMass, Density, Mass, MassProperties, RigidBody, limits,
};
use crate::diagnosis::{BodyProblem, PartProblem};
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::Vec3;
use parry3d::math::Pose as ParryPose;
use std::sync::Arc;

/// The shape of a body with colliders on child entities, or with a scale. This component is computed; bodies whose shape is simply their
/// own [`Collider`] do not have it.
#[derive(Component, Clone, Debug)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(opaque))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_remove = crate::body::lost_description, map_entities, clone_behavior = Ignore, summary_tick)]
pub struct CompoundCollider {
    /// The parts that it was made from.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::shared_list"))]
    pub(crate) sources: Arc<[Part]>,
    pub(crate) kind: RigidBody,
    /// The scale of the body in the world.
    pub(crate) scale: Vec3,
    shape: Option<Collider>,
    /// By piece of the shape: 0 for the body's own collider, otherwise the number of the part, from 1 on.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::shared_list"))]
    owners: Arc<[u16]>,
    /// Index in `sources` of each part, by its number less 1.
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::shared_list"))]
    solids: Arc<[u32]>,
    #[cfg_attr(feature = "serde", serde(with = "crate::stored::written::shared_list"))]
    zones: Arc<[Zone]>,
    masses: Masses,
    problem: Option<BodyProblem>,
    /// Whether it was copied into a preview, where the parts do not exist.
    pub(crate) is_copy: bool,
}

/// Everything else follows from these fields.
impl PartialEq for CompoundCollider {
    fn eq(&self, other: &Self) -> bool {
        (self.kind, self.scale, self.is_copy) == (other.kind, other.scale, other.is_copy)
            && self.sources == other.sources
    }
}

/// The moments of the parts that have a density of their own, and of those that have that of the body, the latter at 1 kg/m³.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Masses {
    own: Moments,
    shared: Moments,
}

impl MapEntities for CompoundCollider {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let mapped = self.sources.iter().map(|part| Part {
            entity: mapper.get_mapped(part.entity),
            ..part.clone()
        });
        self.sources = mapped.collect();
        self.zones = self.zones.iter().map(|zone| zone.mapped(mapper)).collect();
    }
}

type Pieces = Vec<(ParryPose, Collider)>;

/// A valid part.
struct ValidPart {
    /// Its convex pieces, in the frame of the body.
    pieces: Pieces,
    /// Its moments at 1 kg/m³.
    unit: Moments,
    /// Its density if it is not that of the body, kg/m³.
    density: Option<f64>,
}

/// Checks a part and transforms its shape into the frame of the body.
fn check(part: &Part) -> Result<ValidPart, PartProblem> {
    let (axes, position) = (part.map.matrix3, Vec3::from(part.map.translation));
    let positive = |x: f32| x.is_finite() && x > 0.0;
    if !part.map.is_finite() || !limits::within(position, limits::LARGEST) {
        return Err(PartProblem::InvalidTransform);
    }
    if part.collider.is_degenerate() {
        return Err(PartProblem::DegenerateShape);
    }
    if part.density.is_some_and(|density| !positive(density.0))
        || part.mass.is_some_and(|mass| !positive(mass.0))
    {
        return Err(PartProblem::InvalidMass);
    }
    if part.friction.is_some_and(|x| !x.is_valid())
        || part.restitution.is_some_and(|x| !x.is_valid())
        || part.rolling.is_some_and(|x| !x.is_valid())
    {
        return Err(PartProblem::InvalidMaterial);
    }
    let pieces = part.collider.pieces(axes.into(), position);
    let pieces = pieces.map_err(|_| PartProblem::DegenerateShape)?;
    if pieces.iter().any(|(_, piece)| piece.is_degenerate()) {
        return Err(PartProblem::DegenerateShape);
    }
    let unit = moments(&pieces);
    let density = match (part.mass, part.density) {
        (Some(mass), _) if unit.volume > 0.0 => Some(f64::from(mass.0) / unit.volume),
        (_, density) => density.map(|density| f64::from(density.0)),
    };
    if density.is_some_and(|density| density * unit.volume > f64::from(limits::HEAVIEST)) {
        return Err(PartProblem::InvalidMass);
    }
    Ok(ValidPart {
        pieces,
        unit,
        density,
    })
}

/// Returns true if a part cannot be in the same compound as the body's own collider.
pub(crate) fn is_separate(part: &Part, body: Entity, own: Option<&Part>) -> bool {
    let solid = |part: &Part| part.is_sensor || part.collider.has_volume();
    part.entity != body && !part.is_sensor && !(solid(part) && own.is_none_or(solid))
}

/// The volume, centre and inertia of pieces.
fn moments(pieces: &Pieces) -> Moments {
    let placed = pieces.iter().map(|(at, piece)| {
        let moments = piece.moments();
        moments.placed(at.translation.as_dvec3(), at.rotation.as_dquat())
    });
    sum(&placed.collect::<Vec<_>>())
}

/// The sum of moments, or zero if there is no volume.
fn sum(moments: &[Moments]) -> Moments {
    let solid = moments.iter().filter(|moments| moments.volume != 0.0);
    let solid: Vec<Moments> = solid.copied().collect();
    match &solid[..] {
        [] => Moments::default(),
        [only] => *only,
        all => Moments::sum(all),
    }
}

/// The moments of the parts of a body, collected one by one.
#[derive(Default)]
struct Scale {
    own: Vec<Moments>,
    shared: Vec<Moments>,
    sensors: Vec<Moments>,
}

impl Scale {
    fn add(&mut self, is_sensor: bool, part: &ValidPart) {
        match part.density {
            _ if is_sensor => self.sensors.push(part.unit),
            Some(density) => self.own.push(part.unit.times(density)),
            None => self.shared.push(part.unit),
        }
    }

    /// The masses. Sensors count only if there is nothing else.
    fn read(self) -> Masses {
        let is_ghost = self.own.is_empty() && self.shared.is_empty();
        Masses {
            own: sum(&self.own),
            shared: sum(if is_ghost {
                &self.sensors
            } else {
                &self.shared
            }),
        }
    }
}

/// The solid shape of a body in its frame.
pub(crate) fn shape_of(world: &World, body: Entity) -> Option<&Collider> {
    match world.get::<CompoundCollider>(body) {
        Some(compound) => compound.shape(),
        None => world.get(body),
    }
}

/// The mass properties of a body as the hierarchy has it now. `None` if its shape is its own collider, or if no part is valid.
pub(crate) fn compound_mass(world: &World, body: Entity) -> Option<CompoundCollider> {
    let parts = gather(world, body)?;
    let kind = *world.get::<RigidBody>(body)?;
    Some(CompoundCollider::weighed(body, kind, parts))
}

impl CompoundCollider {
    /// The scale of the body in the world with which it was made.
    pub(crate) fn scale(&self) -> Vec3 {
        self.scale
    }

    /// The colliders of the body: its own, and those below it in the hierarchy.
    pub fn parts(&self) -> impl Iterator<Item = Entity> {
        self.sources.iter().map(|part| part.entity)
    }

    /// The shape in the frame of the body. `None` if all of its colliders are sensors, or invalid.
    pub fn shape(&self) -> Option<&Collider> {
        self.shape.as_ref()
    }

    /// Why the body cannot be simulated.
    pub(crate) fn problem(&self) -> Option<BodyProblem> {
        self.problem.clone()
    }

    /// Makes the compound of a body. Parts with invalid input are left out, and returned.
    pub(crate) fn build(
        body: Entity,
        kind: RigidBody,
        sources: Vec<Part>,
    ) -> (Self, Vec<(Entity, PartProblem)>) {
        let mut made = Self::empty(kind);
        let mut problems = Vec::new();
        let own = sources.iter().find(|part| part.entity == body);
        let (mut solids, mut owners) = (Vec::new(), Vec::new());
        let (mut all, mut zones) = (Pieces::new(), Vec::new());
        let mut scale = Scale::default();
        for (index, part) in sources.iter().enumerate() {
            let is_own = part.entity == body;
            if is_separate(part, body, own) {
                if kind == RigidBody::Dynamic {
                    problems.push((part.entity, PartProblem::Surface));
                }
                continue;
            }
            let found = match check(part) {
                Ok(_)
                    if solids.len() >= usize::from(BodyParts::MAX)
                        && !is_own
                        && !part.is_sensor =>
                {
                    Err(PartProblem::TooMany)
                }
                found => found,
            };
            let valid = match found {
                Ok(valid) => valid,
                Err(_) if is_own => {
                    // A shape that is degenerate without a scale is reported as such.
                    made.problem = Some(BodyProblem::InvalidScale);
                    continue;
                }
                Err(problem) => {
                    problems.push((part.entity, problem));
                    continue;
                }
            };
            scale.add(part.is_sensor, &valid);
            let pieces = valid.pieces;
            if part.is_sensor {
                zones.push(Zone::new(part.entity, part.layers, pieces));
                continue;
            }
            if !is_own {
                solids.push(index as u32);
            }
            let number = if is_own { 0 } else { solids.len() as u16 };
            owners.extend(pieces.iter().map(|_| number));
            all.extend(pieces);
        }
        made.masses = scale.read();
        made.shape = match (&all[..], own) {
            ([], _) => None,
            (_, Some(own)) if solids.is_empty() && own.map == glam::Affine3A::IDENTITY => {
                Some(own.collider.clone())
            }
            _ => Some(Collider::of_pieces(all)),
        };
        if !solids.is_empty() {
            made.owners = owners.into();
            made.solids = solids.into();
        }
        made.zones = zones.into();
        made.sources = sources.into();
        (made, problems)
    }

    fn empty(kind: RigidBody) -> Self {
        Self {
            sources: [].into(),
            kind,
            scale: Vec3::ONE,
            shape: None,
            owners: [].into(),
            solids: [].into(),
            zones: [].into(),
            masses: Masses::default(),
            problem: None,
            is_copy: false,
        }
    }

    /// Only the masses, for a body whose parts have just been inserted.
    pub(crate) fn weighed(body: Entity, kind: RigidBody, sources: Vec<Part>) -> Self {
        let own = sources.iter().find(|part| part.entity == body);
        let mut scale = Scale::default();
        for part in &sources {
            if !is_separate(part, body, own)
                && let Ok(valid) = check(part)
            {
                scale.add(part.is_sensor, &valid);
            }
        }
        let mut made = Self::empty(kind);
        made.masses = scale.read();
        made
    }

    /// Whether some of its parts have a density or mass of their own.
    pub(crate) fn has_own_masses(&self) -> bool {
        self.masses.own.volume != 0.0
    }

    /// Marks the compound as a copy in a world in which its parts do not exist.
    pub(crate) fn detach(&mut self) {
        self.is_copy = true;
    }

    /// The mass properties, with those that are set by hand on the body.
    pub(crate) fn mass_properties(
        &self,
        density: Option<&Density>,
        mass: Option<&Mass>,
        inertia: Option<&AngularInertia>,
        center: Option<&CenterOfMass>,
    ) -> MassProperties {
        let Masses { own, shared } = self.masses;
        let shared_density = density.map_or(Density::DEFAULT, |density| density.0);
        let all = match shared.volume == 0.0 {
            true => own,
            false => sum(&[own, shared.times(f64::from(shared_density))]),
        };
        if all.volume == 0.0 {
            return MassProperties::new(None, density, mass, inertia, center);
        }
        let one = Density(1.0);
        MassProperties::of(all.rounded(), Some(&one), mass, inertia, center)
    }

    /// The parts for the table, and the layers of the body as a whole; `own` are the properties of the body's own components.
    pub(crate) fn resolve(
        &self,
        own: &BodyProperties,
    ) -> (Option<Arc<BodyParts>>, CollisionLayers) {
        if self.owners.is_empty() && self.zones.is_empty() {
            return (None, own.layers);
        }
        let solids = self.solids.iter().map(|&i| &self.sources[i as usize]);
        let parts = solids.map(|part| BodyPart {
            entity: part.entity,
            friction: part.friction.unwrap_or(own.friction),
            restitution: part.restitution.unwrap_or(own.restitution),
            rolling: part.rolling.unwrap_or(own.rolling),
            layers: part.layers.unwrap_or(own.layers),
        });
        let parts: Vec<BodyPart> = parts.collect();
        let first = self.owners.contains(&0).then_some(own.layers);
        let layers = first
            .into_iter()
            .chain(parts.iter().map(|part| part.layers));
        let layers = layers.reduce(|a, b| CollisionLayers {
            memberships: a.memberships | b.memberships,
            filters: a.filters | b.filters,
        });
        let zones = self.zones.iter().map(|zone| zone.resolved(own.layers));
        let parts = BodyParts::new(self.owners.clone(), own.layers, parts, zones.collect());
        (Some(Arc::new(parts)), layers.unwrap_or(own.layers))
    }
}

impl Moments {
    /// The same at another density.
    fn times(self, density: f64) -> Self {
        Self {
            volume: self.volume * density,
            inertia: self.inertia * density,
            ..self
        }
    }
}
