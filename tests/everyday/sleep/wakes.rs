//! All that may change under a sleeping body, and whether it wakes.

use super::*;
use bevy_ecs::component::Mutable;
use bevy_ecs::entity_disabling::Disabled;
use drystone::state::{Role, Stored, Visitor};
use std::fmt::Debug;

/// Two cubes on a floor, and one that hangs from the world by a joint.
struct Site {
    floor: Entity,
    lower: Entity,
    upper: Entity,
    hanging: Entity,
}

type Change = fn(&mut World, &Site) -> Entity;

/// A change that wakes a sleeper: its name, what is done before the bodies fall asleep, and the change, which returns a body that must
/// wake.
struct Wakes(&'static str, fn(&mut World, &Site), Change);

fn nothing(_: &mut World, _: &Site) {}

/// Inserts a component into the lower cube.
fn put<T: Component>(world: &mut World, site: &Site, value: T) -> Entity {
    world.entity_mut(site.lower).insert(value);
    site.lower
}

/// Makes the floor one of cells.
fn lay_cells(world: &mut World, site: &Site) {
    let mut cells = Voxels::new(1.0);
    cells.set_box(IVec3::new(-10, -2, -10), IVec3::new(10, 0, 10), true);
    let mut floor = world.entity_mut(site.floor);
    floor.remove::<Collider>();
    floor.insert((cells, Transform::IDENTITY));
}

/// Fills the site with thick air.
fn fill(world: &mut World, _: &Site) {
    let air = Fluid {
        density: 10.0,
        ..Fluid::air(Vec3::ZERO)
    };
    world.spawn((Collider::cuboid(30.0, 30.0, 30.0), air, at(0.0, 0.0, 0.0)));
}

fn air(world: &mut World) -> Entity {
    let mut fluids = world.query_filtered::<Entity, With<Fluid>>();
    fluids.single(world).unwrap()
}

/// Gives the lower cube a wheel at its side.
fn mount_wheel(world: &mut World, site: &Site) {
    world.spawn((Wheel::default(), ChildOf(site.lower), at(0.8, 0.2, 0.0)));
}

fn wheel(world: &mut World) -> Entity {
    let mut wheels = world.query_filtered::<Entity, With<Wheel>>();
    wheels.single(world).unwrap()
}

/// Takes a component from the lower cube.
fn take<T: Component>(world: &mut World, site: &Site) -> Entity {
    world.entity_mut(site.lower).remove::<T>();
    site.lower
}

/// Hangs the third cube on a joint.
fn hang<T: Component>(world: &mut World, _: &Site, joint: T) {
    world.spawn((joint, BreakForce::new(1e6)));
}

fn joint(world: &mut World) -> Entity {
    let mut joints = world.query_filtered::<Entity, With<BreakForce>>();
    joints.single(world).unwrap()
}

/// Takes the component of the joint.
fn unhang<T: Component>(world: &mut World, site: &Site) -> Entity {
    let joint = joint(world);
    world.entity_mut(joint).remove::<T>();
    site.hanging
}

fn fix(world: &mut World, site: &Site) {
    hang(world, site, FixedJoint::new(None, site.hanging));
}

struct Ignore;

impl ContactHook for Ignore {
    fn filter_pair(&self, _: [&drystone::body::BodyState; 2]) -> bool {
        false
    }
}

struct Keep;

impl ContactHook for Keep {}

const FORCE: ExternalForce = ExternalForce {
    force: Vec3::X,
    torque: Vec3::ZERO,
    local_force: Vec3::ZERO,
    local_torque: Vec3::ZERO,
};
const DAMPING: Damping = Damping {
    linear: 1e4,
    angular: 1e4,
};

/// Changes that wake sleepers.
const WAKES: &[Wakes] = &[
    Wakes("RigidBody", nothing, |w, s| {
        put(w, s, RigidBody::Static);
        s.upper
    }),
    Wakes("Transform", nothing, |w, s| {
        w.get_mut::<Transform>(s.lower).unwrap().translation.x += 0.01;
        s.lower
    }),
    Wakes("Transform", nothing, |w, s| {
        w.get_mut::<Transform>(s.floor).unwrap().translation.x += 0.01;
        s.upper
    }),
    Wakes("Pose", nothing, |w, s| {
        w.get_mut::<Pose>(s.lower).unwrap().position.x += 0.01;
        s.lower
    }),
    Wakes("Voxels", lay_cells, |w, s| {
        let mut cells = w.get_mut::<Voxels>(s.floor).unwrap();
        assert_eq!(cells.set_ball(Vec3::ZERO, 1.0, false), 4);
        s.lower
    }),
    Wakes("Fluid", fill, |w, s| {
        let air = air(w);
        w.get_mut::<Fluid>(air).unwrap().flow = Vec3::X;
        s.lower
    }),
    Wakes("Fluid", fill, |w, s| {
        let air = air(w);
        w.entity_mut(air).remove::<Fluid>();
        s.upper
    }),
    Wakes("Wheel", mount_wheel, |w, s| {
        let wheel = wheel(w);
        w.get_mut::<Wheel>(wheel).unwrap().engine = 100.0;
        s.lower
    }),
    Wakes("Wheel", mount_wheel, |w, s| {
        let wheel = wheel(w);
        w.entity_mut(wheel).remove::<Wheel>();
        s.lower
    }),
    Wakes("Velocity", nothing, |w, s| {
        put(w, s, Velocity::linear(Vec3::X))
    }),
    Wakes("Velocity", nothing, |w, s| {
        w.entity_mut(s.floor)
            .insert((RigidBody::Kinematic, Velocity::linear(Vec3::X * 1e-3)));
        s.upper
    }),
    Wakes("Sleeping", nothing, |w, s| put(w, s, Sleeping::default())),
    Wakes("SpawnOrder", nothing, |w, s| put(w, s, SpawnOrder(1 << 40))),
    Wakes("ExternalImpulse", nothing, |w, s| {
        let linear = Vec3::X;
        put(
            w,
            s,
            ExternalImpulse {
                linear,
                ..Default::default()
            },
        )
    }),
    Wakes("ExternalForce", nothing, |w, s| put(w, s, FORCE)),
    Wakes(
        "ExternalForce",
        |w, s| _ = put(w, s, FORCE),
        take::<ExternalForce>,
    ),
    Wakes(
        "Damping",
        |w, s| _ = put(w, s, DAMPING),
        |w, s| put(w, s, Damping::default()),
    ),
    Wakes("Damping", |w, s| _ = put(w, s, DAMPING), take::<Damping>),
    Wakes("GravityScale", nothing, |w, s| put(w, s, GravityScale(0.5))),
    Wakes(
        "GravityScale",
        |w, s| _ = put(w, s, GravityScale(0.5)),
        take::<GravityScale>,
    ),
    Wakes("Grab", nothing, |w, s| {
        put(w, s, Grab::gentle(1.0, Vec3::ZERO, Vec3::Y))
    }),
    Wakes("Hand", nothing, |w, s| {
        let ray = Some(drystone::query::Ray3d::new(
            Vec3::new(0.0, 0.5, 5.0),
            Dir3::NEG_Z,
        ));
        w.spawn(Hand {
            ray,
            closed: true,
            ..Hand::new(1e3)
        });
        s.lower
    }),
    Wakes("Collider", nothing, |w, s| put(w, s, cube(0.9))),
    Wakes("Collider", nothing, |w, s| {
        w.entity_mut(s.floor)
            .insert(Collider::cuboid(20.0, 0.9, 20.0));
        s.upper
    }),
    Wakes("ColliderOf", nothing, |w, s| {
        w.spawn((cube(0.1), at(0.0, 0.0, 0.6), ChildOf(s.lower)));
        s.lower
    }),
    Wakes("CompoundCollider", nothing, |w, s| {
        w.spawn((cube(0.1), at(0.0, 0.0, 0.6), ChildOf(s.lower)));
        s.lower
    }),
    Wakes("ColliderDisabled", nothing, |w, s| {
        put(w, s, ColliderDisabled);
        s.upper
    }),
    Wakes("Density", nothing, |w, s| put(w, s, Density(500.0))),
    Wakes("Mass", nothing, |w, s| put(w, s, Mass(500.0))),
    Wakes("AngularInertia", nothing, |w, s| {
        let principal = Vec3::splat(200.0);
        put(
            w,
            s,
            AngularInertia {
                principal,
                local_frame: Quat::IDENTITY,
            },
        )
    }),
    Wakes("CenterOfMass", nothing, |w, s| {
        put(w, s, CenterOfMass(Vec3::Y * 0.1))
    }),
    Wakes("Friction", nothing, |w, s| put(w, s, Friction::new(0.1))),
    Wakes(
        "Friction",
        |w, s| _ = put(w, s, Friction::new(0.1)),
        take::<Friction>,
    ),
    Wakes("Restitution", nothing, |w, s| {
        put(w, s, Restitution::new(0.5))
    }),
    Wakes("RollingFriction", nothing, |w, s| {
        put(w, s, RollingFriction::new(0.1))
    }),
    Wakes("SurfaceVelocity", nothing, |w, s| {
        w.entity_mut(s.floor)
            .insert(SurfaceVelocity(Vec3::X * 0.01));
        s.lower
    }),
    Wakes("CollisionLayers", nothing, |w, s| {
        put(w, s, CollisionLayers::new(2, 2))
    }),
    Wakes("CollisionExceptions", nothing, |w, s| {
        put(w, s, CollisionExceptions([s.floor].into_iter().collect()))
    }),
    Wakes("LockedAxes", nothing, |w, s| {
        put(w, s, LockedAxes::ROTATION_LOCKED)
    }),
    Wakes("Dominance", nothing, |w, s| put(w, s, Dominance(1))),
    Wakes("MaxLinearSpeed", nothing, |w, s| {
        put(w, s, MaxLinearSpeed(1.0))
    }),
    Wakes("MaxAngularSpeed", nothing, |w, s| {
        put(w, s, MaxAngularSpeed(1.0))
    }),
    Wakes("SolverEffort", nothing, |w, s| put(w, s, SolverEffort(2.0))),
    Wakes("Sensor", nothing, |w, s| {
        put(w, s, Sensor);
        s.upper
    }),
    Wakes("RigidBodyDisabled", nothing, |w, s| {
        put(w, s, RigidBodyDisabled);
        s.upper
    }),
    Wakes("Disabled", nothing, |w, s| {
        put(w, s, Disabled);
        s.upper
    }),
    Wakes("ChildOf", nothing, |w, s| {
        let parent = w.spawn(at(0.01, 0.0, 0.0)).id();
        put(w, s, ChildOf(parent))
    }),
    Wakes("Quarantined", nothing, |w, s| {
        put(w, s, Mass(f32::NAN));
        s.upper
    }),
    Wakes(
        "ActiveContactHooks",
        |w, _| w.insert_resource(ContactHooks::new(Ignore)),
        |w, s| put(w, s, ActiveContactHooks::FILTER_PAIRS),
    ),
    Wakes(
        "ContactHooks",
        |w, s| _ = w.entity_mut(s.floor).insert(ActiveContactHooks::ALL),
        |w, s| {
            w.insert_resource(ContactHooks::new(Ignore));
            s.lower
        },
    ),
    Wakes(
        "ContactHooks",
        |w, s| {
            w.entity_mut(s.upper).insert(ActiveContactHooks::ALL);
            w.insert_resource(ContactHooks::new(Keep));
        },
        |w, s| {
            w.remove_resource::<ContactHooks>();
            s.upper
        },
    ),
    Wakes("FixedJoint", fix, unhang::<FixedJoint>),
    Wakes("FixedJoint", fix, |w, s| {
        let joint = joint(w);
        w.despawn(joint);
        s.hanging
    }),
    Wakes("FixedJoint", fix, |w, s| {
        w.spawn(FixedJoint::new(None, s.lower));
        s.lower
    }),
    Wakes(
        "RevoluteJoint",
        |w, s| hang(w, s, RevoluteJoint::new(None, s.hanging)),
        |w, s| {
            let joint = joint(w);
            let turning =
                RevoluteJoint::new(None, s.hanging).with_motor(JointMotor::velocity(1.0, 1e4));
            w.entity_mut(joint).insert(turning);
            s.hanging
        },
    ),
    Wakes(
        "PrismaticJoint",
        |w, s| hang(w, s, PrismaticJoint::new(None, s.hanging)),
        unhang::<PrismaticJoint>,
    ),
    Wakes(
        "SphericalJoint",
        |w, s| hang(w, s, SphericalJoint::new(None, s.hanging)),
        unhang::<SphericalJoint>,
    ),
    Wakes(
        "DistanceJoint",
        |w, s| {
            hang(
                w,
                s,
                DistanceJoint::new(None, s.hanging).with_local_anchor1(Vec3::new(5.0, 4.0, 0.0)),
            )
        },
        unhang::<DistanceJoint>,
    ),
    Wakes(
        "SpringJoint",
        |w, s| {
            hang(
                w,
                s,
                SpringJoint::new(None, s.hanging).with_local_anchor1(Vec3::new(5.0, 4.0, 0.0)),
            )
        },
        unhang::<SpringJoint>,
    ),
    Wakes(
        "CylindricalJoint",
        |w, s| hang(w, s, CylindricalJoint::new(None, s.hanging)),
        unhang::<CylindricalJoint>,
    ),
    Wakes(
        "GenericJoint",
        |w, s| hang(w, s, GenericJoint::new(None, s.hanging)),
        unhang::<GenericJoint>,
    ),
    Wakes("BreakForce", fix, |w, s| {
        let joint = joint(w);
        w.entity_mut(joint).insert(BreakForce::new(1.0));
        s.hanging
    }),
    Wakes("JointDisabled", fix, |w, s| {
        let joint = joint(w);
        w.entity_mut(joint).insert(JointDisabled);
        s.hanging
    }),
    Wakes(
        "Mortar",
        |w, s| _ = w.entity_mut(s.upper).insert(Mortar::default()),
        |w, s| {
            put(w, s, Mortar::default());
            s.lower
        },
    ),
    Wakes(
        "Studs",
        |w, s| _ = w.entity_mut(s.upper).insert(Studs::new(0.25, 10.0)),
        |w, s| put(w, s, Studs::new(0.25, 10.0)),
    ),
    Wakes(
        "MortarJoint",
        |w, s| {
            for brick in [s.lower, s.upper] {
                w.entity_mut(brick).insert(Mortar::default());
            }
        },
        |w, s| {
            let mut bonds = w.query_filtered::<Entity, With<MortarJoint>>();
            let bonds: Vec<Entity> = bonds.iter(w).collect();
            bonds.into_iter().for_each(|bond| _ = w.despawn(bond));
            s.upper
        },
    ),
    Wakes("Gravity", nothing, |w, s| {
        w.insert_resource(Gravity(Vec3::NEG_Y * 9.8));
        s.upper
    }),
    Wakes("SolverSettings", nothing, |w, s| {
        w.resource_mut::<SolverSettings>().outer_substeps = 2;
        s.upper
    }),
    Wakes("StabilizationSettings", nothing, |w, s| {
        w.resource_mut::<StabilizationSettings>().envelope *= 0.9;
        s.upper
    }),
    Wakes("NarrowphaseSettings", nothing, |w, s| {
        w.resource_mut::<NarrowphaseSettings>().match_radius *= 0.9;
        s.upper
    }),
    Wakes("SleepSettings", nothing, |w, s| {
        w.resource_mut::<SleepSettings>().delay = 1.0;
        s.upper
    }),
    Wakes("SpeedLimits", nothing, |w, s| {
        w.resource_mut::<SpeedLimits>().linear = 10.0;
        s.upper
    }),
];

/// Changes that wake nobody, and why.
const WAKES_NOBODY: &[(&str, &[&str])] = &[
    (
        "written by stages, or read by users only",
        &[
            "MassProperties",
            "Motion",
            "BodyIndex",
            "ImplicitBody",
            "CollidingEntities",
            "SensorOverlaps",
            "JointForces",
            "QuarantinedJoint",
            "GrabForce",
            "HandState",
            "FluidState",
            "WheelState",
            "HeldBy",
            "Load",
            "Stands",
            "StepTime",
            "VoxelChunk",
        ],
    ),
    (
        "tells something, and moves nothing",
        &[
            "ContactEvents",
            "ContactForceEvents",
            "Watch",
            "CollapseSettings",
            "Name",
        ],
    ),
    ("says how a change of `Transform` is meant", &["Teleport"]),
    (
        "says when a body breaks or goes, which wakes what it touches",
        &["Fracturable", "Debris"],
    ),
    (
        "of a character, which is kinematic and wakes what it touches when it moves",
        &["Character", "CharacterState"],
    ),
    ("how time runs, not what is in it", &["PhysicsTime"]),
];

#[test]
fn every_change_under_a_sleeper_that_may_move_it_wakes_it() {
    let kinds = [Waking::Islands, SleepSettings::default().waking];
    for Wakes(name, before, change) in WAKES {
        for waking in kinds {
            let mut app = app();
            app.add_plugins((HandPlugin,));
            let world = app.world_mut();
            world.resource_mut::<SleepSettings>().waking = waking;
            let dynamic = |y: f32| (RigidBody::Dynamic, cube(1.0), at(0.0, y, 0.0));
            let site = Site {
                floor: world
                    .spawn((
                        RigidBody::Static,
                        Collider::cuboid(20.0, 1.0, 20.0),
                        at(0.0, -0.5, 0.0),
                    ))
                    .id(),
                lower: world.spawn(dynamic(0.5)).id(),
                upper: world.spawn(dynamic(1.5)).id(),
                hanging: world
                    .spawn((RigidBody::Dynamic, cube(1.0), at(5.0, 3.0, 0.0)))
                    .id(),
            };
            if !name.ends_with("Joint") && *name != "BreakForce" && *name != "JointDisabled"
                || *name == "MortarJoint"
            {
                world.despawn(site.hanging);
            }
            before(world, &site);
            steps(world, 120);
            let asleep = [site.lower, site.upper].map(|body| is_asleep(world, body));
            assert_eq!(asleep, [true; 2], "{name}, {waking:?}");
            let sleeper = change(world, &site);
            let mut woke = false;
            for _ in 0..3 {
                steps(world, 1);
                woke |= world
                    .get::<Sleeping>(sleeper)
                    .is_none_or(|sleeping| !sleeping.asleep);
            }
            assert!(woke, "{name} wakes nobody, {waking:?}");
        }
    }
}

/// The public components and resources are those in the table of [`Sleeping`], and those that are known to wake nobody.
#[test]
fn the_table_of_what_wakes_names_every_component() {
    let page = include_str!("../../../src/body/sleeping.rs");
    let rows = page.lines().filter(|line| line.starts_with("/// | "));
    let mut told: Vec<&str> = rows
        .flat_map(|row| row.split('`').skip(1).step_by(2))
        .collect();
    let mut tried: Vec<&str> = WAKES.iter().map(|Wakes(name, ..)| *name).collect();
    for names in [&mut told, &mut tried] {
        names.sort_unstable();
        names.dedup();
    }
    assert_eq!(told, tried);
    let others: Vec<&str> = WAKES_NOBODY
        .iter()
        .flat_map(|(_, names)| *names)
        .copied()
        .collect();
    assert!(others.iter().all(|name| !tried.contains(name)));
    let mut on_the_list = Names::default();
    drystone::state::visit(&mut on_the_list);
    let public: Vec<&str> = on_the_list.0.iter().map(|name| &**name).collect();
    assert!(public.len() > 70, "{}", public.len());
    let listed: Vec<&str> = [&tried[..], &others].concat();
    let missing: Vec<_> = public
        .iter()
        .filter(|name| !listed.contains(name))
        .collect();
    assert!(
        missing.is_empty(),
        "neither known to wake sleepers nor not to: {missing:?}"
    );
    let unknown: Vec<_> = listed
        .iter()
        .filter(|name| !public.contains(name))
        .collect();
    assert!(unknown.is_empty(), "no such type: {unknown:?}");
}

/// The names of the components and resources on the list of the state that users may write.
#[derive(Default)]
struct Names(Vec<String>);

impl Names {
    fn add<T>(&mut self) {
        let path = std::any::type_name::<T>();
        let name = path.rsplit("::").next().unwrap_or(path);
        self.0.push(name.into());
    }
}

impl Visitor for Names {
    fn any_component<T: Component + Clone + Debug>(&mut self) {
        self.add::<T>();
    }

    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self, _: Role) {}

    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self, role: Role) {
        if matches!(role, Role::Setting | Role::Time) {
            self.add::<T>();
        }
    }

    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self, _: Role) {
        self.add::<T>();
    }
}
