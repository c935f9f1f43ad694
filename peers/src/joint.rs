//! The joints of a drystone scene before the first step, for all engines.

use crate::body::Body;
use bevy_ecs::entity::Entity;
use bevy_ecs::world::World;
use drystone::body::SpawnOrder;
use drystone::joint::{JointAnchor, JointBasis, JointFrame, JointLimits, JointMotor};
use drystone::prelude::{FixedJoint, Pose, Quat, RevoluteJoint, SphericalJoint, Vec3};

/// A joint before the first step.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// Indices of the bodies; `None` is the world.
    pub bodies: [Option<usize>; 2],
    /// Anchor (m) and axes of the joint on each body, in its frame. The x axis is that of the hinge, or of the twist.
    pub frames: [Pose; 2],
    pub kind: Kind,
    /// Whether the two bodies collide with each other.
    pub collision: bool,
}

/// What a joint lets free, rad and N·m.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    Fixed,
    Revolute {
        angle: Option<JointLimits>,
        friction: f32,
        motor: Option<Motor>,
    },
    Spherical {
        twist: Option<JointLimits>,
        swing: Option<JointLimits>,
        friction: f32,
    },
}

/// A motor that seeks an angular velocity.
#[derive(Clone, Copy, Debug)]
pub struct Motor {
    /// rad/s
    pub speed: f32,
    /// N·m
    pub torque: f32,
}

impl Motor {
    /// # Errors
    /// If it is a spring, or a damper of finite strength.
    fn read(motor: &JointMotor) -> Result<Self, String> {
        match motor.stiffness == 0.0 && motor.damping == f32::INFINITY {
            true => Ok(Self {
                speed: motor.target_velocity,
                torque: motor.max_force,
            }),
            false => Err("other engines get motors that seek a velocity only".into()),
        }
    }
}

/// The joints of a scene, in the order in which they were spawned.
///
/// # Errors
/// If there is one of another kind than fixed, revolute and spherical, or one with a spring.
pub fn read(world: &mut World, bodies: &[Body]) -> Result<Vec<Joint>, String> {
    let mut all = Vec::new();
    let mut joints = world.query::<(Entity, &SpawnOrder)>();
    let mut found: Vec<_> = joints.iter(world).collect();
    found.sort_by_key(|(_, order)| **order);
    for (entity, _) in found {
        let entity = world.entity(entity);
        let read = if let Some(joint) = entity.get::<FixedJoint>() {
            let ends = [joint.body1, joint.body2];
            let frames = [joint.frame1, joint.frame2];
            (ends, frames, Vec3::X, Kind::Fixed, joint.collision)
        } else if let Some(joint) = entity.get::<RevoluteJoint>() {
            let kind = Kind::Revolute {
                angle: joint.limits,
                friction: joint.friction,
                motor: joint.motor.as_ref().map(Motor::read).transpose()?,
            };
            let ends = [joint.body1, joint.body2];
            let frames = [joint.frame1, joint.frame2];
            (ends, frames, joint.hinge_axis, kind, joint.collision)
        } else if let Some(joint) = entity.get::<SphericalJoint>() {
            let kind = Kind::Spherical {
                twist: joint.twist_limits,
                swing: joint.swing_limits,
                friction: joint.friction,
            };
            let ends = [joint.body1, joint.body2];
            let frames = [joint.frame1, joint.frame2];
            (ends, frames, joint.twist_axis, kind, joint.collision)
        } else if entity.contains::<drystone::joint::JointForces>() {
            return Err("other engines get fixed, revolute and spherical joints only".into());
        } else {
            continue;
        };
        let (ends, frames, axis, kind, collision) = read;
        let index = |end: Entity| bodies.iter().position(|body| body.entity == end);
        let ends = ends.map(|end| end.and_then(index));
        let poses = ends.map(|end| end.map_or(Pose::default(), |end| bodies[end].pose));
        let turn = Quat::from_rotation_arc(Vec3::X, axis.normalize());
        let local = |side: usize| local(&frames[side], &poses[side], turn);
        all.push(Joint {
            bodies: ends,
            frames: [local(0)?, local(1)?],
            kind,
            collision,
        });
    }
    Ok(all)
}

/// A frame relative to its body. The axes that are not given are those of the world.
fn local(frame: &JointFrame, pose: &Pose, turn: Quat) -> Result<Pose, String> {
    let back = pose.rotation.inverse();
    let position = match frame.anchor {
        JointAnchor::Local(point) => point,
        JointAnchor::FromGlobal(point) => back * (point - pose.position),
        JointAnchor::Auto => return Err("other engines get joints with anchors only".into()),
    };
    let basis = match frame.basis {
        JointBasis::Local(basis) => basis,
        JointBasis::FromGlobal(basis) => back * basis,
        JointBasis::Auto => back,
    };
    let rotation = (basis * turn).normalize();
    Ok(Pose { position, rotation })
}

/// The largest distance of the two anchors of a joint, m; infinite where a body is lost.
pub fn stretch(joints: &[Joint], poses: &[Pose]) -> f32 {
    let distance = |joint: &Joint| {
        let [a, b] = [0, 1].map(|side| {
            let anchor = joint.frames[side].position;
            joint.bodies[side].map_or(anchor, |body| {
                poses[body].position + poses[body].rotation * anchor
            })
        });
        let distance = a.distance(b);
        if distance.is_nan() {
            f32::INFINITY
        } else {
            distance
        }
    };
    joints.iter().map(distance).fold(0.0, f32::max)
}
