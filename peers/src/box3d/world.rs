//! A world of Box3D's behind a safe face: all that is unsafe about it, and nothing else.
//!
//! Box3D checks what it is given by assertions, which a release build of it does not have. So what goes in is checked here, and
//! bodies are told by their index in the world that made them, never by Box3D's own handles, which would outlive it.

use super::data::{Field, Hull, Mesh};
use super::shape::Shape;
use crate::joint::{Joint, Kind, Motor};
use box3d_sys as b3;
use drystone::prelude::{CollisionLayers, Pose, Quat, RigidBody, Vec3, Velocity};
use std::sync::{Mutex, PoisonError};

/// Substeps of a step: what Box3D's own documentation recommends, and its samples have.
pub const SUBSTEPS: i32 = 4;

/// Box3D keeps its worlds in one table that nothing guards.
static WORLDS: Mutex<()> = Mutex::new(());

/// A world and the bodies in it.
pub struct World {
    id: b3::b3WorldId,
    bodies: Vec<b3::b3BodyId>,
    /// From the origin of a scene's body to that of Box3D's, in the body's frame, m.
    offsets: Vec<Vec3>,
    /// A body that does not move and has no shape: the world, for joints.
    rest: Option<b3::b3BodyId>,
    /// What shapes refer to. It is dropped after the world.
    meshes: Vec<Mesh>,
    fields: Vec<Field>,
    sleeping: bool,
}

/// A body before the first step.
#[derive(Clone, Copy)]
pub struct Description {
    pub kind: RigidBody,
    pub pose: Pose,
    /// m/s
    pub linear: Vec3,
    /// rad/s
    pub angular: Vec3,
    /// kg/m³
    pub density: f32,
    pub friction: f32,
    pub restitution: f32,
    pub layers: CollisionLayers,
}

impl World {
    /// An empty one, with sleeping on or off and everything else as it comes.
    ///
    /// # Errors
    /// If Box3D has no room for another world.
    pub fn new(gravity: Vec3, threads: u32, sleeping: bool) -> Result<Self, String> {
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the definition is Box3D's own with plain numbers changed, and no other code creates or destroys a world meanwhile.
        let id = unsafe {
            let mut definition = b3::b3DefaultWorldDef();
            definition.gravity = vec3(gravity);
            definition.enableSleep = sleeping;
            // More than one make Box3D start its own threads.
            definition.workerCount = threads;
            b3::b3CreateWorld(&definition)
        };
        match id.index1 {
            0 => Err("Box3D has no room for another world".into()),
            _ => Ok(Self {
                id,
                bodies: Vec::new(),
                offsets: Vec::new(),
                rest: None,
                meshes: Vec::new(),
                fields: Vec::new(),
                sleeping,
            }),
        }
    }

    /// Adds a body of one shape or several.
    ///
    /// # Errors
    /// If a number is not finite or a size is not positive, or Box3D cannot make a hull, mesh or field.
    pub fn add(&mut self, body: &Description, shapes: &[Shape]) -> Result<(), String> {
        if !(body.is_sound() && shapes.iter().all(Shape::is_sound)) {
            return Err("Box3D takes no body with a size or number that is no good".into());
        }
        let made: Vec<Made> = shapes.iter().map(Made::new).collect::<Result<_, _>>()?;
        let offset = shapes.iter().find_map(Shape::offset).unwrap_or_default();
        // SAFETY: the world lives as long as `self`, definitions are Box3D's own with plain numbers changed, and all of them are
        // sound. Box3D copies definitions and shapes, so that none need outlive the call, except meshes and fields, which are kept until
        // the world is dropped.
        unsafe {
            let mut definition = b3::b3DefaultBodyDef();
            definition.type_ = match body.kind {
                RigidBody::Dynamic => b3::b3BodyType_b3_dynamicBody,
                RigidBody::Static => b3::b3BodyType_b3_staticBody,
                RigidBody::Kinematic => b3::b3BodyType_b3_kinematicBody,
            };
            definition.position = vec3(body.pose.position + body.pose.rotation * offset);
            definition.rotation = quat(body.pose.rotation);
            definition.linearVelocity = vec3(body.linear);
            definition.angularVelocity = vec3(body.angular);
            definition.enableSleep = self.sleeping;
            let id = b3::b3CreateBody(self.id, &definition);
            self.bodies.push(id);
            self.offsets.push(offset);

            let mut surface = b3::b3DefaultShapeDef();
            surface.density = body.density;
            surface.baseMaterial.friction = body.friction;
            surface.baseMaterial.restitution = body.restitution;
            surface.filter.categoryBits = body.layers.memberships.into();
            surface.filter.maskBits = body.layers.filters.into();
            // Once, after the last shape.
            surface.updateBodyMass = false;
            for (shape, made) in shapes.iter().zip(&made) {
                attach(id, &surface, shape, made);
            }
            if body.kind == RigidBody::Dynamic {
                b3::b3Body_ApplyMassFromShapes(id);
            }
        }
        for made in made {
            match made {
                Made::Mesh(mesh) => self.meshes.push(mesh),
                Made::Field(field) => self.fields.push(field),
                Made::Plain | Made::Hull(_) => {}
            }
        }
        Ok(())
    }

    /// Joins two bodies. Box3D's axis of a hinge and of the twist is z.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn join(&mut self, joint: &Joint) -> Result<(), String> {
        let sound = joint
            .frames
            .iter()
            .all(|frame| frame.is_finite() && frame.rotation.is_normalized());
        if !sound {
            return Err("Box3D takes no joint with a number that is no good".into());
        }
        // SAFETY: the world and its bodies live as long as `self`, indices are checked, and definitions are Box3D's own with plain and
        // sound numbers changed. Box3D copies them.
        unsafe {
            let rest = *self
                .rest
                .get_or_insert_with(|| b3::b3CreateBody(self.id, &b3::b3DefaultBodyDef()));
            let [a, b] = joint
                .bodies
                .map(|body| body.map_or(rest, |body| self.bodies[body]));
            let turn = Quat::from_rotation_arc(Vec3::Z, Vec3::X);
            let [frame_a, frame_b] = joint.frames.map(|frame| b3::b3Transform {
                p: vec3(frame.position),
                q: quat(frame.rotation * turn),
            });
            let place = |base: &mut b3::b3JointDef| {
                (base.bodyIdA, base.bodyIdB) = (a, b);
                (base.localFrameA, base.localFrameB) = (frame_a, frame_b);
                base.collideConnected = joint.collision;
            };
            match joint.kind {
                Kind::Fixed => {
                    let mut definition = b3::b3DefaultWeldJointDef();
                    place(&mut definition.base);
                    b3::b3CreateWeldJoint(self.id, &definition);
                }
                Kind::Revolute {
                    angle,
                    friction,
                    motor,
                } => {
                    let mut definition = b3::b3DefaultRevoluteJointDef();
                    place(&mut definition.base);
                    if let Some(limits) = angle {
                        definition.enableLimit = true;
                        (definition.lowerAngle, definition.upperAngle) = (limits.min, limits.max);
                    }
                    // Dry friction is a motor at rest.
                    let motor = motor.unwrap_or(Motor {
                        speed: 0.0,
                        torque: friction,
                    });
                    definition.enableMotor = motor.torque > 0.0;
                    definition.motorSpeed = motor.speed;
                    definition.maxMotorTorque = motor.torque;
                    b3::b3CreateRevoluteJoint(self.id, &definition);
                }
                Kind::Spherical {
                    twist,
                    swing,
                    friction,
                } => {
                    let mut definition = b3::b3DefaultSphericalJointDef();
                    place(&mut definition.base);
                    if let Some(limits) = swing {
                        definition.enableConeLimit = true;
                        definition.coneAngle = limits.max;
                    }
                    if let Some(limits) = twist {
                        definition.enableTwistLimit = true;
                        definition.lowerTwistAngle = limits.min;
                        definition.upperTwistAngle = limits.max;
                    }
                    definition.enableMotor = friction > 0.0;
                    definition.maxMotorTorque = friction;
                    b3::b3CreateSphericalJoint(self.id, &definition);
                }
            }
        }
        Ok(())
    }

    /// A step of so many seconds.
    ///
    /// # Panics
    /// If it is not positive and finite.
    pub fn step(&mut self, dt: f32) {
        assert!(dt > 0.0 && dt.is_finite(), "a step of {dt} s");
        // SAFETY: the world lives as long as `self`, and no other code has it.
        unsafe { b3::b3World_Step(self.id, dt, SUBSTEPS) }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// The pose of the body's own origin.
    pub fn pose(&self, body: usize) -> Pose {
        let id = self.bodies[body];
        // SAFETY: the body lives as long as its world, and that as long as `self`.
        let (p, q) = unsafe { (b3::b3Body_GetPosition(id), b3::b3Body_GetRotation(id)) };
        let rotation = Quat::from_xyzw(q.v.x, q.v.y, q.v.z, q.s);
        Pose {
            position: Vec3::new(p.x, p.y, p.z) - rotation * self.offsets[body],
            rotation,
        }
    }

    /// The velocity of the body's centre of mass, and its angular velocity.
    pub fn velocity(&self, body: usize) -> Velocity {
        let id = self.bodies[body];
        // SAFETY: as in `pose`.
        let both = unsafe {
            [
                b3::b3Body_GetLinearVelocity(id),
                b3::b3Body_GetAngularVelocity(id),
            ]
        };
        let [linear, angular] = both.map(|v| Vec3::new(v.x, v.y, v.z));
        Velocity { linear, angular }
    }

    /// Mass, kg; centre in the body's frame, m; inertia about it in that frame, kg m², by columns.
    #[cfg(test)]
    pub fn mass(&self, body: usize) -> (f32, Vec3, [Vec3; 3]) {
        let id = self.bodies[body];
        // SAFETY: as in `pose`.
        let (mass, center, inertia) = unsafe {
            (
                b3::b3Body_GetMass(id),
                b3::b3Body_GetLocalCenter(id),
                b3::b3Body_GetLocalRotationalInertia(id),
            )
        };
        let columns = [inertia.cx, inertia.cy, inertia.cz];
        let glam = |v: b3::b3Vec3| Vec3::new(v.x, v.y, v.z);
        (mass, glam(center), columns.map(glam))
    }
}

impl Drop for World {
    fn drop(&mut self) {
        let _guard = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: it was created with `self`, no handle of it is left, and no other code creates or destroys a world meanwhile.
        unsafe { b3::b3DestroyWorld(self.id) }
    }
}

impl Description {
    fn is_sound(&self) -> bool {
        let numbers = [self.density, self.friction, self.restitution];
        self.pose.is_finite()
            && self.pose.rotation.is_normalized()
            && self.linear.is_finite()
            && self.angular.is_finite()
            && numbers.iter().all(|x| x.is_finite() && *x >= 0.0)
    }
}

/// What Box3D makes of a shape before a body gets it.
enum Made {
    Plain,
    Hull(Hull),
    Mesh(Mesh),
    Field(Field),
}

impl Made {
    fn new(shape: &Shape) -> Result<Self, String> {
        Ok(match shape {
            Shape::Hull { corners } => Self::Hull(Hull::new(corners)?),
            Shape::Mesh { corners, triangles } => Self::Mesh(Mesh::new(corners, triangles)?),
            Shape::Field {
                heights,
                counts,
                scale,
            } => Self::Field(Field::new(heights, *counts, *scale)?),
            _ => Self::Plain,
        })
    }
}

/// Gives a body a shape.
///
/// # Safety
/// The body lives, the shape is sound, and a mesh or field outlives the body's world.
unsafe fn attach(id: b3::b3BodyId, surface: &b3::b3ShapeDef, shape: &Shape, made: &Made) {
    // SAFETY: the caller's.
    unsafe {
        match (shape, made) {
            (
                Shape::Box {
                    half,
                    center,
                    rotation,
                },
                _,
            ) => {
                let frame = b3::b3Transform {
                    p: vec3(*center),
                    q: quat(*rotation),
                };
                let hull = b3::b3MakeTransformedBoxHull(half.x, half.y, half.z, frame);
                // A box's hull begins with what all hulls begin with, and its offsets reach into the rest.
                b3::b3CreateHullShape(id, surface, (&raw const hull).cast());
            }
            (&Shape::Sphere { center, radius }, _) => {
                let center = vec3(center);
                let sphere = b3::b3Sphere { center, radius };
                b3::b3CreateSphereShape(id, surface, &sphere);
            }
            (&Shape::Capsule { ends, radius }, _) => {
                let [center1, center2] = ends.map(vec3);
                let capsule = b3::b3Capsule {
                    center1,
                    center2,
                    radius,
                };
                b3::b3CreateCapsuleShape(id, surface, &capsule);
            }
            (_, Made::Hull(hull)) => {
                b3::b3CreateHullShape(id, surface, hull.data());
            }
            (_, Made::Mesh(mesh)) => {
                b3::b3CreateMeshShape(id, surface, mesh.data(), vec3(Vec3::ONE));
            }
            (_, Made::Field(field)) => {
                b3::b3CreateHeightFieldShape(id, surface, field.data());
            }
            (_, Made::Plain) => unreachable!("hulls, meshes and fields were made"),
        }
    }
}

pub fn vec3(v: Vec3) -> b3::b3Vec3 {
    b3::b3Vec3 {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

fn quat(q: Quat) -> b3::b3Quat {
    b3::b3Quat {
        v: vec3(Vec3::new(q.x, q.y, q.z)),
        s: q.w,
    }
}
