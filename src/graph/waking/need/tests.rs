use super::*;
use crate::DrystonePlugins;
use crate::body::{RigidBody, collider::Collider};
use bevy_app::App;
use bevy_ecs::system::SystemState;
use bevy_transform::components::Transform;

/// A plank on five posts. The order of its links depends on which contact began first, and changes when one ends and begins again.
#[test]
fn supports_do_not_depend_on_the_order_of_links() {
    let mut app = App::new();
    app.add_plugins(DrystonePlugins::default());
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    for i in 0..5 {
        let at = Transform::from_xyz(i as f32, 0.25, 0.0);
        world.spawn((RigidBody::Dynamic, Collider::cuboid(0.5, 0.5, 0.5), at));
    }
    let at = Transform::from_xyz(2.0, 0.6, 0.0);
    let plank = (RigidBody::Dynamic, Collider::cuboid(4.5, 0.2, 0.5), at);
    let plank = world.spawn(plank).id();
    for _ in 0..120 {
        crate::step(world, 1.0 / 60.0).unwrap();
    }
    let mut state =
        SystemState::<(Res<BodyTable>, Forces, Sleepers, Query<&JointEdge>)>::new(world);
    let graph = world.resource::<ConstraintGraph>().clone();
    let (table, forces, sleepers, joints) = state.get_mut(world).unwrap();
    let found = table.iter().find(|(_, body)| body.entity == plank);
    let (slot, _) = found.unwrap();
    let supports = |graph: &ConstraintGraph| {
        let need = Need {
            graph,
            table: &table,
            forces: &forces,
            sleepers: &sleepers,
            joints: &joints,
            interval: 0.25,
            speed: 0.01,
            gravity: Vec3::NEG_Y,
            dt: 1.0 / 60.0,
        };
        let edges = graph.links_of(slot).map(|link| link.edge);
        (edges.collect::<Vec<_>>(), need.supports(slot, Vec3::Y))
    };
    let (edges, before) = supports(&graph);
    assert_eq!(before.len(), 5);
    let mut other = graph.clone();
    other.set_links(edges[1], false);
    other.set_links(edges[1], true);
    let (others, after) = supports(&other);
    assert_ne!(edges, others);
    assert_eq!(before, after);
}
