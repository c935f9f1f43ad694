//! Components of a body that a game may put on, take off, or write.

use crate::dice::Dice;
use crate::shape::Shape;
use bevy_ecs::change_detection::DetectChangesMut;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::world::EntityWorldMut;
use drystone::body::Sleeping;
use drystone::body::{
    AngularInertia, CenterOfMass, Damping, Density, ExternalForce, ExternalImpulse, GravityScale,
    Mass, RigidBody, SpawnOrder, Teleport, Velocity,
};
use drystone::collider::{
    Collider, CollisionLayers, CombineRule, Friction, Restitution, RollingFriction,
};
use drystone::contact::ContactEvents;
use drystone::grab::Grab;
use glam::{BVec3, Quat, Vec3};

macro_rules! parts {
    ($($name:ident($value:ty => $component:ty)),+ $(,)?) => {
        #[derive(Clone, Debug)]
        pub enum Part { $($name($value)),+ }

        impl Part {
            pub fn insert(&self, body: &mut EntityWorldMut) {
                match self {
                    $(Self::$name(value) => { body.insert(<$component>::from(value.clone())); })+
                }
            }

            pub fn remove(&self, body: &mut EntityWorldMut) {
                match self {
                    $(Self::$name(_) => { body.remove::<$component>(); })+
                }
            }

            /// Written without change.
            pub fn touch(&self, body: &mut EntityWorldMut) {
                match self {
                    $(Self::$name(_) => if let Some(mut component) = body.get_mut::<$component>() {
                        component.set_changed();
                    })+
                }
            }
        }
    };
}

parts!(
    Kind(RigidBody => RigidBody),
    Shape(Shape => Collider),
    Mass(Mass => Mass),
    Density(Density => Density),
    Inertia(AngularInertia => AngularInertia),
    Center(CenterOfMass => CenterOfMass),
    Friction(Friction => Friction),
    Restitution(Restitution => Restitution),
    Rolling(RollingFriction => RollingFriction),
    Layers(CollisionLayers => CollisionLayers),
    Scale(GravityScale => GravityScale),
    Damping(Damping => Damping),
    Events(ContactEvents => ContactEvents),
    Force(ExternalForce => ExternalForce),
    Impulse(ExternalImpulse => ExternalImpulse),
    Velocity(Velocity => Velocity),
    Sleeping(Sleeping => Sleeping),
    Grab(Grab => Grab),
    Disabled(Disabled => Disabled),
    SpawnOrder(SpawnOrder => SpawnOrder),
    Teleport(Teleport => Teleport),
);

/// The bit of the layer that guests are never in.
pub const INNOCENT: u32 = 1 << 31;

pub const KINDS: [RigidBody; 5] = [
    RigidBody::Dynamic,
    RigidBody::Dynamic,
    RigidBody::Dynamic,
    RigidBody::Static,
    RigidBody::Kinematic,
];

impl Part {
    pub fn roll(dice: &mut Dice) -> Self {
        match dice.index(21) {
            0 => Self::Kind(dice.pick(&KINDS)),
            1 => Self::Shape(Shape::convex(dice)),
            2 => Self::Mass(Mass(dice.number(1.0, 3000.0))),
            3 => Self::Density(Density(dice.number(50.0, 3000.0))),
            4 => Self::Inertia(AngularInertia {
                principal: Vec3::new(
                    dice.number(50.0, 100.0),
                    dice.number(50.0, 100.0),
                    dice.number(50.0, 100.0),
                ),
                local_frame: dice.turn(),
            }),
            5 => Self::Center(CenterOfMass(dice.vector(0.3))),
            6 => Self::Friction(Friction {
                coefficient: dice.number(0.0, 1.5),
                rule: rule(dice),
            }),
            7 => Self::Restitution(Restitution {
                coefficient: dice.number(0.0, 1.0),
                rule: rule(dice),
            }),
            8 => Self::Layers(CollisionLayers {
                memberships: dice.pick(&[1, 2, 3, !INNOCENT]),
                filters: dice.pick(&[1, 2, 3, !INNOCENT, 0]),
            }),
            9 => Self::Scale(GravityScale(dice.number(-0.5, 2.0))),
            10 => Self::Damping(Damping {
                linear: dice.number(0.0, 5.0),
                angular: dice.number(0.0, 5.0),
            }),
            11 => Self::Events(ContactEvents),
            12 => Self::Force(ExternalForce {
                force: dice.vector(300.0),
                torque: dice.vector(100.0),
                ..Default::default()
            }),
            13 => Self::Impulse(ExternalImpulse {
                linear: dice.vector(100.0),
                angular: dice.vector(30.0),
            }),
            14 => Self::Velocity(Velocity {
                linear: dice.vector(10.0),
                angular: dice.vector(10.0),
            }),
            15 => Self::Sleeping(Sleeping {
                asleep: dice.chance(0.7),
                still_for: dice.number(0.0, 1.0),
                allowed: dice.chance(0.8),
            }),
            16 => Self::Grab(Grab {
                target: dice.vector(3.0),
                local_point: dice.vector(0.3),
                rotation: dice
                    .chance(0.5)
                    .then(|| Quat::from_scaled_axis(dice.vector(3.0))),
                response: dice.number(0.0, 1.0),
                max_speed: dice.number(0.0, 20.0),
                max_force: dice.number(0.0, 1e5),
                max_torque: dice.number(0.0, 1e4),
                axes: BVec3::from_array([(); 3].map(|()| dice.chance(0.9))),
                turn_axes: BVec3::from_array([(); 3].map(|()| dice.chance(0.9))),
            }),
            17 => Self::SpawnOrder(SpawnOrder(dice.pick(&[0, 1, 2, 1000, u64::MAX]))),
            18 => Self::Teleport(Teleport),
            19 => Self::Rolling(RollingFriction {
                coefficient: dice.number(0.0, 0.1),
                rule: rule(dice),
            }),
            _ => Self::Disabled(Disabled),
        }
    }
}

fn rule(dice: &mut Dice) -> CombineRule {
    dice.pick(&[
        CombineRule::Average,
        CombineRule::GeometricMean,
        CombineRule::Min,
        CombineRule::Multiply,
        CombineRule::Max,
    ])
}
