//! The input of all engines: the bodies of a drystone scene before the first step.
//!
//! Drystone builds the scene, and every other engine is given what is read from that world, so that no engine has a scene of
//! its own that could differ.

use crate::body::Body;
use crate::joint::{self, Joint};
use bevy_ecs::entity::Entity;
use bevy_transform::components::Transform;
use drystone::prelude::{
    Collider, CollisionLayers, Density, Friction, Gravity, Mass, Pose, Restitution, RigidBody,
    Vec3, Velocity,
};
use drystone::settings::{PhysicsThreads, Preset};
use drystone_lab::experiment::{Experiment, Run};
use drystone_lab::scenes::{Ground, Scene};

/// Half the edges of the slab, m, that stands for a half-space where an engine has none, or none that it likes. Thin, because depths
/// are found in its frame: in single precision and 1 km from its middle they would come in steps of 0.06 mm.
pub const SLAB: Vec3 = Vec3::new(500.0, 1.0, 500.0);

/// How all engines are run.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Length of a step, s.
    pub dt: f32,
    /// Threads of each engine.
    pub threads: usize,
    /// The ground of the scene.
    pub ground: Ground,
    /// Whether bodies may sleep. In comparisons of scenes at rest they may not: a sleeping body costs nothing and does not creep, so a body
    /// that sleeps in only one engine would decide both.
    pub sleeping: bool,
}

/// A scene as drystone built it, for all.
pub struct Start<'a> {
    pub bodies: &'a [Body],
    pub joints: &'a [Joint],
    /// m/s²
    pub gravity: Vec3,
    pub conditions: Conditions,
}

impl<'a> Start<'a> {
    /// The scene of a run that has not begun.
    pub fn of(run: &Run, bodies: &'a [Body], joints: &'a [Joint], conditions: Conditions) -> Self {
        Self {
            bodies,
            joints,
            gravity: run.world.resource::<Gravity>().0,
            conditions,
        }
    }
}

/// Builds a scene in drystone, with its default settings.
///
/// # Errors
/// If a hand moves the scene, or the operating system gives no threads.
pub fn build(
    scene: Scene,
    seed: u64,
    conditions: Conditions,
) -> Result<(Run, Vec<Body>, Vec<Joint>), String> {
    let threads = conditions.threads;
    let mut experiment = Experiment::new(scene, Preset::Default).with_seed(seed);
    experiment.dt = conditions.dt;
    experiment.options.ground = conditions.ground;
    experiment.sleeping.enabled = conditions.sleeping;
    experiment.threads =
        PhysicsThreads::new(threads).map_err(|e| format!("--threads {threads}: {e}"))?;
    let mut run = experiment.start();
    if run.hand().is_some() {
        return Err(format!(
            "--scene {scene}: a hand moves it through drystone's components, and other engines have none"
        ));
    }
    let bodies = read(&mut run);
    let joints =
        joint::read(&mut run.world, &bodies).map_err(|why| format!("--scene {scene}: {why}"))?;
    Ok((run, bodies, joints))
}

/// The ground first, then what stands on it in the order in which it was placed: the order decides in which order a
/// Gauss–Seidel solver sweeps.
pub fn read(run: &mut Run) -> Vec<Body> {
    let mut all = run.world.query::<(
        Entity,
        &RigidBody,
        &Collider,
        // Drystone's own pose is written by the first step.
        &Transform,
        &Velocity,
        (Option<&Density>, Option<&Mass>),
        (Option<&Friction>, Option<&Restitution>),
        Option<&CollisionLayers>,
    )>();
    let mut bodies: Vec<Body> = all
        .iter(&run.world)
        .map(
            |(
                entity,
                kind,
                collider,
                transform,
                velocity,
                mass,
                (friction, restitution),
                layers,
            )| Body {
                entity,
                kind: *kind,
                collider: collider.clone(),
                pose: Pose {
                    position: transform.translation,
                    rotation: transform.rotation,
                },
                velocity: *velocity,
                density: density(collider, mass),
                friction: friction.copied().unwrap_or_default(),
                restitution: restitution.copied().unwrap_or_default(),
                layers: layers.copied().unwrap_or_default(),
            },
        )
        .collect();
    bodies.sort_by_cached_key(|body| run.bodies.iter().position(|&b| b == body.entity));
    bodies
}

/// The density that gives a body its mass, kg/m³: a mass of its own counts before a density.
fn density(collider: &Collider, (density, mass): (Option<&Density>, Option<&Mass>)) -> f32 {
    match mass {
        Some(mass) => mass.0 / collider.shape().mass_properties(1.0).mass(),
        None => density.map_or(Density::DEFAULT, |density| density.0),
    }
}
