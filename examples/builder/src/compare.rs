//! The same scene twice, in two copies of the world: one takes steps of 60 Hz, the other of 10.

use crate::BuilderSystems;
use crate::camera::View;
use crate::clock::Clock;
use crate::look::{Materials, Meshes, Own};
use crate::pieces::{Piece, to_transform};
use bevy::prelude::*;
use drystone::prelude::*;

/// Shows the two copies, where they are asked for.
pub struct ComparePlugin;

impl Plugin for ComparePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Comparison>()
            .add_systems(Update, advance.in_set(BuilderSystems::Show));
    }
}

/// The two copies, while they are shown.
#[derive(Resource, Default)]
pub struct Comparison(Vec<Replica>);

/// A world that takes steps by itself.
struct Replica {
    world: World,
    hz: f32,
    /// Its displacement from the original, m.
    aside: Vec3,
    /// Time that no step has been taken for yet, s.
    left: f32,
    bodies: Vec<Twin>,
}

/// A body of a copy and the entity that shows it.
struct Twin {
    body: Entity,
    drawn: Entity,
    /// Before the last step.
    before: Pose,
}

/// Shows a body of a copy.
#[derive(Component)]
pub struct Drawn;

/// Steps that one frame makes up for, at most.
const MOST_STEPS: usize = 12;

/// Two take more room than one.
const FARTHER: f32 = 1.7;

impl Comparison {
    /// Whether the copies are shown.
    pub fn is_on(&self) -> bool {
        !self.0.is_empty()
    }

    /// Spawns a piece in both copies, aimed as if the original stood in the middle between them.
    ///
    /// # Errors
    /// If it has no size.
    pub fn spawn(
        &mut self,
        world: &mut World,
        piece: &Piece,
        pose: Pose,
        velocity: Velocity,
    ) -> Result {
        let look = look_of(world, piece);
        for copy in &mut self.0 {
            let body = copy.world.spawn((piece.bundle(pose)?, velocity)).id();
            let drawn = world
                .spawn((Drawn, look.clone(), Transform::default()))
                .id();
            copy.bodies.push(Twin {
                body,
                drawn,
                before: pose,
            });
        }
        Ok(())
    }
}

type Look = (Mesh3d, MeshMaterial3d<StandardMaterial>);

fn look_of(world: &mut World, piece: &Piece) -> Look {
    let tint = world.resource::<Materials>().tint(piece.finish, 0);
    let mesh = world.resource_scope(|world, mut assets: Mut<Assets<Mesh>>| {
        world.resource_mut::<Meshes>().of(&piece.shape, &mut assets)
    });
    (Mesh3d(mesh), MeshMaterial3d(tint))
}

/// Shows the copies, or the original again; the original waits for so long.
///
/// # Errors
/// If there is nothing to copy.
pub fn toggle(world: &mut World) -> Result {
    if world.resource::<Comparison>().is_on() {
        end(world);
        return Ok(());
    }
    let mut pieces = world.query::<(Entity, &Piece, &RigidBody, &Pose, &Mesh3d, &Own)>();
    let pieces: Vec<_> = pieces
        .iter(world)
        .map(|(entity, _, kind, pose, mesh, own)| {
            let look: Look = (mesh.clone(), MeshMaterial3d(own.0.clone()));
            (entity, *kind, *pose, look)
        })
        .collect();
    let dynamic = pieces.iter().filter(|piece| piece.1 == RigidBody::Dynamic);
    let dynamic: Vec<Entity> = dynamic.map(|piece| piece.0).collect();
    if dynamic.is_empty() {
        return Err("there is nothing to compare".into());
    }
    let reach = pieces.iter().map(|(_, _, pose, _)| pose.position.x.abs());
    let aside = 0.8 + reach.fold(0.5, f32::max);
    let mut copies = Vec::new();
    for (hz, aside) in [(60.0, -aside), (10.0, aside)] {
        let aside = Vec3::X * aside;
        let shadow = Shadow::around(world, &dynamic)?;
        let twins = pieces.iter().filter_map(|(original, _, pose, look)| {
            let body = shadow.copy_of(*original)?;
            Some((body, *pose, look.clone()))
        });
        let twins: Vec<_> = twins.collect();
        let bodies = twins.into_iter().map(|(body, before, look)| Twin {
            body,
            drawn: world.spawn((Drawn, look, Transform::default())).id(),
            before,
        });
        copies.push(Replica {
            bodies: bodies.collect(),
            world: shadow.into_world(),
            hz,
            aside,
            left: 0.0,
        });
    }
    for (piece, ..) in &pieces {
        world.entity_mut(*piece).insert(Visibility::Hidden);
    }
    world.resource_mut::<Clock>().paused = true;
    world.resource_mut::<View>().distance *= FARTHER;
    world.resource_mut::<Comparison>().0 = copies;
    Ok(())
}

/// Shows the original again.
pub fn end(world: &mut World) {
    if std::mem::take(&mut world.resource_mut::<Comparison>().0).is_empty() {
        return;
    }
    let mut drawn = world.query_filtered::<Entity, With<Drawn>>();
    let drawn: Vec<Entity> = drawn.iter(world).collect();
    for entity in drawn {
        world.despawn(entity);
    }
    let mut pieces = world.query_filtered::<&mut Visibility, With<Piece>>();
    for mut visibility in pieces.iter_mut(world) {
        *visibility = Visibility::Inherited;
    }
    world.resource_mut::<Clock>().paused = false;
    world.resource_mut::<View>().distance /= FARTHER;
}

/// Advances each world by the elapsed time, in steps of its own length. Between two steps, poses are interpolated.
fn advance(
    mut comparison: ResMut<Comparison>,
    time: Res<Time<Real>>,
    (clock, gravity): (Res<Clock>, Res<Gravity>),
    mut drawn: Query<&mut Transform, With<Drawn>>,
) {
    for copy in &mut comparison.0 {
        copy.world.insert_resource(*gravity);
        let dt = 1.0 / copy.hz;
        let most = MOST_STEPS as f32 / 60.0;
        copy.left += (clock.speed * time.delta_secs()).min(most);
        while copy.left >= dt {
            copy.left -= dt;
            for twin in &mut copy.bodies {
                if let Some(pose) = copy.world.get::<Pose>(twin.body) {
                    twin.before = *pose;
                }
            }
            if let Err(error) = drystone::step(&mut copy.world, dt) {
                error!("a copy took no step: {error}");
            }
        }
        let share = copy.left / dt;
        for twin in &copy.bodies {
            if let Some(pose) = copy.world.get::<Pose>(twin.body)
                && let Ok(mut at) = drawn.get_mut(twin.drawn)
            {
                let Pose { position, rotation } = twin.before;
                *at = to_transform(Pose {
                    position: position.lerp(pose.position, share) + copy.aside,
                    rotation: rotation.slerp(pose.rotation, share),
                });
            }
        }
    }
}
