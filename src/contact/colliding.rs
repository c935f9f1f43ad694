//! Which bodies a body touches, as a component.

use crate::body::{BodyIndex, BodyTable};
use crate::graph::ConstraintGraph;
use crate::pair::PairsRef;
use crate::settings::StepTime;
use bevy_ecs::entity::{EntityHashSet, EntityMapper, MapEntities};
use bevy_ecs::prelude::*;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};

/// The bodies that touch this one, kept up to date by the stage *contact events* on bodies that have this component. It changes when
/// [`ContactStarted`](super::ContactStarted) and [`ContactEnded`](super::ContactEnded) are sent, and holds for sleeping bodies too.
///
/// ```
/// use bevy_transform::components::Transform;
/// use drystone::prelude::*;
///
/// # let mut app = bevy_app::App::new();
/// # app.add_plugins(DrystonePlugins::default());
/// # let world = app.world_mut();
/// let plate = world
///     .spawn((RigidBody::Static, Collider::cuboid(1.0, 0.1, 1.0), CollidingEntities::default()))
///     .id();
/// let at = Transform::from_xyz(0.0, 0.3, 0.0);
/// let ball = world.spawn((RigidBody::Dynamic, Collider::ball(0.25), at)).id();
/// for _ in 0..30 {
///     drystone::step(world, 1.0 / 60.0).unwrap();
/// }
/// assert!(world.get::<CollidingEntities>(plate).unwrap().contains(&ball));
/// ```
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities)]
pub struct CollidingEntities(
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "crate::stored::written::sorted_set")
    )]
    pub EntityHashSet,
);

impl std::ops::Deref for CollidingEntities {
    type Target = EntityHashSet;

    fn deref(&self) -> &EntityHashSet {
        &self.0
    }
}

impl MapEntities for CollidingEntities {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let mapped = self.0.drain().map(|body| mapper.get_mapped(body));
        self.0 = mapped.collect();
    }
}

/// Part of the stage *contact events*: updates all [`CollidingEntities`]. Those of disabled bodies are empty.
pub fn colliding_entities(
    (table, graph, time): (Res<BodyTable>, Res<ConstraintGraph>, Res<StepTime>),
    mut bodies: Query<(Entity, &BodyIndex, &mut CollidingEntities)>,
    pairs: PairsRef,
) {
    if !time.is_last() {
        return;
    }
    for (entity, index, mut colliding) in &mut bodies {
        let slot = Some(index.0).filter(|_| table.holds(entity, *index));
        let edges = slot.into_iter().flat_map(|slot| graph.edges_of(slot));
        let touching = edges.filter_map(|pair| {
            let (_, (pair, ..)) = pairs.get(pair).ok()?;
            let others = Some(pair.bodies).filter(|_| pair.announced())?;
            others.into_iter().find(|&other| other != entity)
        });
        let touching: EntityHashSet = touching.collect();
        colliding.set_if_neq(CollidingEntities(touching));
    }
}
