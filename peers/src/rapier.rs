//! The mirror: the same bodies in Rapier, at Rapier's default settings.
//!
//! Drystone and Rapier take their shapes from the same version of parry, so that a shape goes over as it is and mass, centre
//! and inertia follow from the same code.

use crate::body::Body;
use crate::engine::{Effort, Engine};
use crate::joint::{Joint, Kind};
use crate::scene::{SLAB, Start};
use drystone::prelude::{CombineRule, Friction, Pose, Quat, RigidBody, Vec3, Velocity};
use drystone_lab::metrics;
use drystone_lab::play::{BRICK, Ball, FRICTION, Game};
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, GenericJoint, GenericJointBuilder, Group,
    InteractionGroups, InteractionTestMode, JointAxesMask, JointAxis, PhysicsWorld,
    RigidBodyBuilder, RigidBodyHandle, RigidBodyType, SharedShape,
};

/// How a half-space is handed over. Its bounding box is the whole world, so that Rapier's broadphase pairs it with every body
/// however high it is: with a slab Rapier takes a tenth less time, and walls and stacks end up alike.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ground {
    /// As it is.
    HalfSpace,
    /// As a slab with its upper face where the surface was.
    Slab,
}

/// Settings of Rapier that differ from its defaults.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// `num_solver_iterations`, each of which is a substep of solving and moving.
    pub iterations: Option<usize>,
    pub ground: Ground,
}

/// A scene in Rapier.
pub struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
}

impl Rapier {
    /// # Errors
    /// If Rapier gets no threads.
    pub fn new(start: &Start, options: Options) -> Result<Self, String> {
        let mut world = PhysicsWorld::new();
        world.gravity = start.gravity;
        world.integration_parameters.dt = start.conditions.dt;
        if let Some(iterations) = options.iterations {
            world.integration_parameters.num_solver_iterations = iterations;
        }
        set_threads(&mut world, start.conditions.threads)?;
        let place = |body: &Body| {
            world
                .insert(
                    rigid_body(body).can_sleep(start.conditions.sleeping),
                    collider(body, options.ground),
                )
                .0
        };
        let bodies: Vec<_> = start.bodies.iter().map(place).collect();
        if !start.joints.is_empty() {
            let rest = world.insert_body(RigidBodyBuilder::fixed());
            for joint in start.joints {
                let [a, b] = joint
                    .bodies
                    .map(|body| body.map_or(rest, |body| bodies[body]));
                world.insert_impulse_joint(a, b, generic_joint(joint));
            }
        }
        Ok(Self { world, bodies })
    }

    #[cfg(test)]
    pub fn bodies(&self) -> impl Iterator<Item = &rapier3d::prelude::RigidBody> {
        self.bodies.iter().map(|&handle| &self.world.bodies[handle])
    }

    #[cfg(test)]
    pub fn lose(&mut self, body: usize) {
        self.world.bodies[self.bodies[body]].set_linvel(drystone::prelude::Vec3::NAN, true);
    }
}

#[cfg(feature = "parallel")]
fn set_threads(world: &mut PhysicsWorld, threads: usize) -> Result<(), String> {
    world
        .configure_thread_pool(threads)
        .map_err(|e| format!("--threads {threads}: {e}"))
}

#[cfg(not(feature = "parallel"))]
fn set_threads(_: &mut PhysicsWorld, threads: usize) -> Result<(), String> {
    match threads {
        1 => Ok(()),
        _ => Err(format!(
            "--threads {threads}: Rapier has more than one with --features parallel only"
        )),
    }
}

fn rigid_body(body: &Body) -> RigidBodyBuilder {
    let kind = match body.kind {
        RigidBody::Dynamic => RigidBodyType::Dynamic,
        RigidBody::Static => RigidBodyType::Fixed,
        RigidBody::Kinematic => RigidBodyType::KinematicVelocityBased,
    };
    RigidBodyBuilder::new(kind)
        .pose(pose(&body.pose))
        .linvel(body.velocity.linear)
        .angvel(body.velocity.angular)
        .linear_damping(0.0)
        .angular_damping(0.0)
}

fn collider(body: &Body, ground: Ground) -> ColliderBuilder {
    let shape = body.collider.shape();
    let builder = match shape.as_halfspace() {
        Some(half_space) if ground == Ground::Slab => {
            let up = half_space.normal;
            let pose = rapier3d::math::Pose::from_parts(
                -SLAB.y * up,
                Quat::from_rotation_arc(Vec3::Y, up),
            );
            ColliderBuilder::new(SharedShape::cuboid(SLAB.x, SLAB.y, SLAB.z)).position(pose)
        }
        _ => ColliderBuilder::new(shape.clone()),
    };
    let (friction, restitution) = (body.friction, body.restitution);
    let groups = InteractionGroups::new(
        Group::from_bits_retain(body.layers.memberships),
        Group::from_bits_retain(body.layers.filters),
        InteractionTestMode::And,
    );
    builder
        .collision_groups(groups)
        .density(body.density)
        .friction(friction.coefficient)
        .friction_combine_rule(rule(friction.rule))
        .restitution(restitution.coefficient)
        .restitution_combine_rule(rule(restitution.rule))
}

/// Damping of a motor, so that it reaches its velocity or its maximum torque.
const STIFF: f32 = 1e3;

/// Rapier limits the rotation of a ball about each of three axes. Dry friction is a motor at rest with a maximum torque.
fn generic_joint(joint: &Joint) -> GenericJoint {
    let turns = [JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ];
    let (locked, limits, friction) = match joint.kind {
        Kind::Fixed => (JointAxesMask::LOCKED_FIXED_AXES, [None; 3], 0.0),
        Kind::Revolute {
            angle, friction, ..
        } => {
            let locked = JointAxesMask::LOCKED_REVOLUTE_AXES;
            (locked, [angle, None, None], friction)
        }
        Kind::Spherical {
            twist,
            swing,
            friction,
        } => {
            let locked = JointAxesMask::LOCKED_SPHERICAL_AXES;
            (locked, [twist, swing, swing], friction)
        }
    };
    let mut builder = GenericJointBuilder::new(locked)
        .local_frame1(pose(&joint.frames[0]))
        .local_frame2(pose(&joint.frames[1]))
        .contacts_enabled(joint.collision);
    for (axis, limits) in turns.into_iter().zip(limits) {
        if let Some(limits) = limits {
            builder = builder.limits(axis, [limits.min, limits.max]);
        }
        if friction > 0.0 && !locked.contains(axis.into()) {
            builder = builder.motor_velocity(axis, 0.0, STIFF);
            builder = builder.motor_max_force(axis, friction);
        }
    }
    if let Kind::Revolute {
        motor: Some(motor), ..
    } = joint.kind
    {
        builder = builder.motor_velocity(JointAxis::AngX, motor.speed, STIFF);
        builder = builder.motor_max_force(JointAxis::AngX, motor.torque);
    }
    builder.build()
}

fn pose(pose: &Pose) -> rapier3d::math::Pose {
    rapier3d::math::Pose::from_parts(pose.position, pose.rotation)
}

/// Drystone and Rapier rank them differently where two bodies ask for different rules; no scene has two.
fn rule(rule: CombineRule) -> CoefficientCombineRule {
    match rule {
        CombineRule::Average => CoefficientCombineRule::Average,
        CombineRule::GeometricMean => CoefficientCombineRule::GeometricMean,
        CombineRule::Min => CoefficientCombineRule::Min,
        CombineRule::Multiply => CoefficientCombineRule::Multiply,
        CombineRule::Max => CoefficientCombineRule::Max,
    }
}

impl Rapier {
    /// Adds a dynamic body of 1 000 kg/m³.
    fn add(&mut self, shape: SharedShape, at: Vec3, velocity: Vec3) -> RigidBodyHandle {
        let friction = Friction::new(FRICTION);
        let body = RigidBodyBuilder::dynamic()
            .translation(at)
            .linvel(velocity)
            .linear_damping(0.0)
            .angular_damping(0.0);
        let collider = ColliderBuilder::new(shape)
            .density(1000.0)
            .friction(friction.coefficient)
            .friction_combine_rule(rule(friction.rule));
        self.world.insert(body, collider).0
    }
}

impl Game for Rapier {
    type Body = RigidBodyHandle;

    fn lay(&mut self, at: Vec3) -> RigidBodyHandle {
        let half = 0.5 * BRICK;
        self.add(SharedShape::cuboid(half.x, half.y, half.z), at, Vec3::ZERO)
    }

    fn throw(&mut self, ball: &Ball) {
        self.add(SharedShape::ball(ball.radius), ball.at, ball.velocity);
    }

    fn take(&mut self, body: RigidBodyHandle) {
        self.world.remove_body(body);
    }

    fn place(&self, body: RigidBodyHandle) -> Option<Vec3> {
        let body = self.world.bodies.get(body);
        body.map(|body| body.position().translation)
    }

    fn step(&mut self, dt: f32) {
        self.world.integration_parameters.dt = dt;
        self.world.step();
    }

    fn awake(&mut self) -> usize {
        let bodies = self.world.bodies.iter();
        bodies
            .filter(|(_, body)| body.is_dynamic() && !body.is_sleeping())
            .count()
    }
}

impl Engine for Rapier {
    fn name(&self) -> &'static str {
        "Rapier"
    }

    fn effort(&self) -> Option<Effort> {
        let iterations = self.world.integration_parameters.num_solver_iterations;
        Some(("iterations", iterations))
    }

    fn step(&mut self) {
        self.world.step();
    }

    fn poses(&self) -> Vec<Pose> {
        // Rapier too takes a body that is no number out of the simulation, and leaves it where it was.
        let pose = |&body: &RigidBodyHandle| match &self.world.bodies[body] {
            body if body.is_enabled() => Pose {
                position: body.position().translation,
                rotation: body.position().rotation,
            },
            _ => metrics::NOWHERE,
        };
        self.bodies.iter().map(pose).collect()
    }

    fn velocities(&self) -> Vec<Velocity> {
        self.bodies
            .iter()
            .map(|&body| &self.world.bodies[body])
            .filter(|body| body.is_dynamic())
            .map(|body| match body.is_enabled() {
                true => Velocity {
                    linear: body.linvel(),
                    angular: body.angvel(),
                },
                false => Velocity::linear(Vec3::NAN),
            })
            .collect()
    }
}
