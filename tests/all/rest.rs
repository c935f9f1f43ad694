//! Bodies at rest are in no list that a stage iterates over. Only the time of a step must differ.

use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::Sleeping;
use drystone::body::{
    BodyIndex, Damping, ExternalForce, ExternalImpulse, GravityScale, Inactive, Mass, Pose,
    RigidBody, Velocity,
};
use drystone::collider::{Collider, CollisionLayers, Friction};
use drystone::contact::ContactPair;
use drystone::grab::Grab;
use drystone::graph::ConstraintGraph;
use drystone::settings::{SleepSettings, Waking};
use glam::{Quat, Vec3};
use support::*;

/// Three stacks of three cubes that sleep, far from each other, on one slab each; and a frame with a static child beside the first.
struct Yard {
    lab: Lab,
    stacks: [[Entity; 3]; 3],
    slabs: [Entity; 3],
    frame: Entity,
    child: Entity,
}

impl Yard {
    /// With the default settings.
    fn new() -> Self {
        Self::waking(SleepSettings::default().waking)
    }

    fn waking(waking: Waking) -> Self {
        let mut lab = Lab::new();
        lab.world.resource_mut::<SleepSettings>().waking = waking;
        // Another's observers of a removal must not hide it from drystone.
        lab.world.add_observer(|_: On<Remove<Friction>>| ());
        lab.world.add_observer(|_: On<Remove<ChildOf>>| ());
        let at = [0.0, 10.0, 20.0].map(|x| Vec3::X * x);
        let slabs = at.map(|at| {
            lab.spawn((
                RigidBody::Static,
                Collider::cuboid(4.0, 1.0, 4.0),
                Friction::new(0.5),
                Transform::from_translation(at - Vec3::Y * 0.5),
            ))
        });
        let stacks = at.map(|at| [0.5, 1.5, 2.5].map(|y| lab.cube(at + Vec3::Y * y)));
        let frame = lab.world.spawn(Transform::from_xyz(0.0, 0.0, 1.0)).id();
        let child = lab.spawn((
            RigidBody::Static,
            Collider::cuboid(0.5, 0.5, 0.5),
            Transform::from_xyz(0.0, 0.25, 0.0),
            ChildOf(frame),
        ));
        lab.run(3.0);
        let yard = Self {
            lab,
            stacks,
            slabs,
            frame,
            child,
        };
        assert!(yard.stacks.as_flattened().iter().all(|&c| yard.sleeps(c)));
        yard
    }

    fn sleeps(&self, body: Entity) -> bool {
        self.lab.world.get::<Sleeping>(body).unwrap().asleep
    }

    /// Bodies and pairs that do not rest.
    fn active(&mut self) -> (Vec<Entity>, usize) {
        let world = &mut self.lab.world;
        let mut bodies = world.query_filtered::<Entity, (With<RigidBody>, Without<Inactive>)>();
        let bodies = bodies.iter(world).collect();
        let pairs = world.resource::<ConstraintGraph>().active_pairs().len();
        (bodies, pairs)
    }

    /// Marks all bodies as written, so that all must be checked.
    fn touch(&mut self) {
        let mut bodies = self.lab.world.query::<&mut BodyIndex>();
        for mut index in bodies.iter_mut(&mut self.lab.world) {
            index.set_changed();
        }
    }
}

#[test]
fn sleeping_bodies_are_in_no_list_and_one_island_wakes_alone() {
    let mut yard = Yard::new();
    assert_eq!(yard.active(), (vec![], 0));
    // In spawn order: first the slabs, then the stacks.
    let others = |yard: &Yard| {
        let mut bits = yard.lab.bits();
        bits.drain(3..6);
        bits
    };
    let before = others(&yard);
    let top = yard.stacks[0][2];
    yard.lab
        .world
        .get_mut::<ExternalImpulse>(top)
        .unwrap()
        .linear = Vec3::X * 100.0;
    yard.lab.step();
    let (mut active, pairs) = yard.active();
    active.sort_unstable();
    let mut stack = yard.stacks[0].to_vec();
    stack.sort_unstable();
    assert_eq!(active, stack);
    // On the slab, between the cubes, and with the static cube beside the lowest.
    assert!((3..=5).contains(&pairs), "{pairs} pairs");
    assert!(yard.stacks[0].iter().all(|&cube| !yard.sleeps(cube)));
    yard.lab.run(4.0);
    assert_eq!(yard.active(), (vec![], 0));
    assert_eq!(others(&yard), before);
}

/// A mark while the body is among the inactive ones would have all of them searched in the next step.
#[test]
fn waking_marks_sleeping_as_changed_and_not_in_the_table_of_inactive_bodies() {
    let mut yard = Yard::new();
    let top = yard.stacks[0][2];
    let below = yard.stacks[0][0];
    yard.lab.step();
    let mut inactive = yard
        .lab
        .world
        .query_filtered::<Ref<Sleeping>, With<Inactive>>();
    // What is written from here on counts as changed.
    yard.lab.world.clear_trackers();
    let last = yard.lab.world.last_change_tick();
    let mut impulse = yard.lab.world.get_mut::<ExternalImpulse>(top).unwrap();
    impulse.linear = Vec3::X * 100.0;
    yard.lab.step();
    let this = yard.lab.world.change_tick();
    for body in [top, below] {
        let ticks = yard.lab.world.entity(body).get_change_ticks::<Sleeping>();
        assert!(ticks.unwrap().is_changed(last, this), "{body}");
    }
    let world = &mut yard.lab.world;
    let columns = inactive.query(world);
    let mut tables = 0;
    for column in columns.contiguous_iter().unwrap() {
        let (_, ticks) = ContiguousRef::split(column);
        assert_eq!(ticks.summary_tick_is_changed(), Some(false));
        tables += 1;
    }
    assert!(tables > 0);
}

/// As `bevy_transform_interpolation` does it in every frame.
#[test]
fn interpolated_bodies_at_rest_stay_at_rest() {
    let mut yard = Yard::new();
    let draw = |yard: &mut Yard, aside: Vec3| {
        let mut drawn = yard.lab.world.query::<&mut Transform>();
        for mut at in drawn.iter_mut(&mut yard.lab.world) {
            at.translation += aside;
        }
    };
    let before = yard.lab.bits();
    for _ in 0..3 {
        draw(&mut yard, Vec3::ZERO);
        yard.lab.step();
        assert_eq!(yard.active(), (vec![], 0));
    }
    assert_eq!(yard.lab.bits(), before);
    draw(&mut yard, Vec3::X);
    yard.lab.step();
    assert!(yard.active().0.len() >= 9);
}

/// What a user does to a world.
type Deed = fn(&mut Yard);

fn at<T: Component<Mutability = bevy_ecs::component::Mutable>>(
    yard: &mut Yard,
    body: Entity,
) -> Mut<'_, T> {
    yard.lab.world.get_mut::<T>(body).unwrap()
}

fn insert(yard: &mut Yard, body: Entity, bundle: impl Bundle) {
    yard.lab.world.entity_mut(body).insert(bundle);
}

/// Edits of bodies that move: what it is, whether bodies wake, and the edit.
fn edits_of_cubes() -> Vec<(&'static str, bool, Deed)> {
    vec![
        ("nothing", false, |_| ()),
        ("a cube is put elsewhere", true, |y| {
            at::<Transform>(y, y.stacks[0][1]).translation.x += 0.3;
        }),
        ("a cube's pose is written", true, |y| {
            at::<Pose>(y, y.stacks[0][2]).position.y += 0.3;
        }),
        ("a cube gets a velocity", true, |y| {
            at::<Velocity>(y, y.stacks[0][2]).linear.x = 1.0;
        }),
        ("a cube is turned", true, |y| {
            at::<Transform>(y, y.stacks[0][2]).rotation = Quat::from_rotation_y(0.4);
        }),
        ("a force", true, |y| {
            let force = ExternalForce {
                force: Vec3::X * 3000.0,
                ..Default::default()
            };
            insert(y, y.stacks[0][2], force);
        }),
        ("an impulse", true, |y| {
            at::<ExternalImpulse>(y, y.stacks[0][0]).linear.x = 3000.0;
        }),
        ("no weight", true, |y| {
            insert(y, y.stacks[0][2], GravityScale(-0.5));
        }),
        ("its factor on gravity is removed", false, |y| {
            insert(y, y.stacks[0][2], GravityScale::default());
            y.lab.step();
            let mut cube = y.lab.world.entity_mut(y.stacks[0][2]);
            assert!(cube.take::<GravityScale>().is_some());
        }),
        ("damping", false, |y| {
            let damping = Damping {
                linear: 1.0,
                ..Default::default()
            };
            insert(y, y.stacks[0][2], damping);
        }),
        ("a hand", true, |y| {
            insert(
                y,
                y.stacks[0][2],
                Grab::gentle(1000.0, Vec3::ZERO, Vec3::Y * 5.0),
            );
        }),
        ("it is woken", true, |y| {
            at::<Sleeping>(y, y.stacks[0][1]).wake()
        }),
        ("a mass", true, |y| insert(y, y.stacks[0][2], Mass(10.0))),
        ("another shape", true, |y| {
            insert(y, y.stacks[0][1], Collider::cuboid(1.0, 0.5, 1.0));
        }),
        ("no shape", true, |y| {
            y.lab.world.entity_mut(y.stacks[0][0]).remove::<Collider>();
        }),
        ("other layers", true, |y| {
            let layers = CollisionLayers {
                memberships: 2,
                filters: 2,
            };
            insert(y, y.stacks[0][0], layers);
        }),
    ]
}

/// Edits of what they stand on, of their places in the hierarchy and of their contacts: what it is, whether bodies wake, and the edit.
fn edits_below_cubes() -> Vec<(&'static str, bool, Deed)> {
    vec![
        ("no friction below", true, |y| {
            insert(y, y.slabs[0], Friction::new(0.0));
        }),
        ("its friction is taken off", true, |y| {
            y.lab.world.entity_mut(y.slabs[0]).remove::<Friction>();
            insert(
                y,
                y.slabs[0],
                Transform::from_rotation(Quat::from_rotation_z(0.3)),
            );
        }),
        ("the slab sinks", true, |y| {
            at::<Transform>(y, y.slabs[0]).translation.y -= 0.02;
        }),
        ("the slab becomes a belt", true, |y| {
            at::<Velocity>(y, y.slabs[0]).linear.x = 1.0;
        }),
        ("the slab falls too", true, |y| {
            insert(y, y.slabs[0], RigidBody::Dynamic);
        }),
        ("the slab is gone", true, |y| {
            y.lab.world.despawn(y.slabs[0]);
        }),
        ("a cube in the middle is gone", true, |y| {
            y.lab.world.despawn(y.stacks[0][1]);
        }),
        ("the slab is disabled", true, |y| {
            insert(y, y.slabs[0], Disabled)
        }),
        ("one is disabled while another is spawned", true, |y| {
            insert(y, y.stacks[0][1], Disabled);
            y.lab.cube(Vec3::new(10.0, 5.0, 0.0));
        }),
        ("the frame of a static child moves", true, |y| {
            at::<Transform>(y, y.frame).translation.z -= 0.4;
        }),
        ("the frame is left", true, |y| {
            y.lab.world.entity_mut(y.child).remove::<ChildOf>();
        }),
        ("the marker is taken off", false, |y| {
            y.lab.world.entity_mut(y.stacks[0][1]).remove::<Inactive>();
        }),
        ("the pairs are taken away", true, |y| {
            let mut pairs = y.lab.world.query_filtered::<Entity, With<ContactPair>>();
            let pairs: Vec<Entity> = pairs.iter(&y.lab.world).collect();
            for pair in pairs {
                y.lab.world.despawn(pair);
            }
        }),
    ]
}

/// Edits of a user, each in a world at rest and in a world in which all bodies are checked in every step.
#[test]
fn operations_on_inactive_bodies_give_what_they_give_on_active_ones() {
    let deeds = [edits_of_cubes(), edits_below_cubes()].concat();
    let need = SleepSettings::default().waking;
    let cases = deeds
        .iter()
        .flat_map(|deed| [(need, deed), (Waking::Islands, deed)]);
    for (waking, &(what, wakes, deed)) in cases {
        let mut yards = [Yard::waking(waking), Yard::waking(waking)];
        for yard in &mut yards {
            deed(yard);
        }
        let mut woke = false;
        for step in 0..30 {
            yards[1].touch();
            for yard in &mut yards {
                yard.lab.step();
            }
            let [one, other] = [&yards[0], &yards[1]].map(|yard| yard.lab.bits());
            assert_eq!(one, other, "{what}, step {step}");
            woke |= !yards[0].sleeps(yards[0].stacks[0][2]);
        }
        // By need, a cube below or above need not wake the others.
        assert!(
            woke == wakes || waking == need && !woke,
            "{what}, {waking:?}"
        );
        assert!(
            yards[0].sleeps(yards[0].stacks[1][0]) || what.contains("pairs"),
            "{what}"
        );
    }
}

/// Tables of the ECS never shrink. If pairs moved to another table when they become inactive, they would take their memory twice.
#[test]
fn pairs_at_rest_stay_in_their_table() {
    let mut lab = Lab::new();
    lab.ground();
    let places = (0..8).flat_map(|x| (0..8).map(move |y| (x, y)));
    let bricks: Vec<Entity> = places
        .map(|(x, y)| {
            let shift = 0.5 * (y % 2) as f32;
            let at = Vec3::new(x as f32 + shift, 0.25 + 0.5 * y as f32, 0.0);
            lab.body(Collider::cuboid(1.0, 0.5, 0.5), at)
        })
        .collect();
    lab.run(3.0);
    let rests = |&brick: &Entity| lab.world.get::<Inactive>(brick).is_some();
    assert!(bricks.iter().all(rests));
    let graph = lab.world.resource::<ConstraintGraph>();
    assert_eq!(graph.active_pairs().len(), 0);
    let mut pairs = lab.world.query::<&ContactPair>();
    let count = pairs.iter(&lab.world).count();
    let id = lab.world.component_id::<ContactPair>().unwrap();
    let tables = lab.world.storages().tables.iter();
    let tables = tables.filter(|table| table.has_column(id));
    let room: usize = tables.map(|table| table.capacity()).sum();
    // Their room doubles when it is full.
    assert!(count > 100 && room < 2 * count, "{room} for {count}");
}

/// A body that is activated keeps no state from its rest.
#[test]
fn a_body_disabled_at_rest_comes_back_and_takes_part() {
    let mut yard = Yard::new();
    let cube = yard.stacks[1][2];
    yard.lab.world.entity_mut(cube).insert(Disabled);
    yard.lab.run(1.0);
    assert!(!yard.lab.world.entity(cube).contains::<Inactive>());
    yard.lab.world.entity_mut(cube).remove::<Disabled>();
    yard.lab
        .world
        .get_mut::<Transform>(cube)
        .unwrap()
        .translation
        .y += 1.0;
    yard.lab.run(3.0);
    assert_near(yard.lab.position(cube).y, 2.5, 1e-3, "height");
    assert_eq!(yard.active(), (vec![], 0));
}

#[test]
fn the_same_written_again_leaves_what_rests_at_rest() {
    let mut yard = Yard::new();
    let cube = yard.stacks[0][1];
    let bodies: Vec<Entity> = yard.stacks.as_flattened().to_vec();
    for body in bodies.into_iter().chain(yard.slabs) {
        let world = &mut yard.lab.world;
        let kind = *world.get::<RigidBody>(body).unwrap();
        let collider = world.get::<Collider>(body).unwrap().clone();
        let at = *world.get::<Transform>(body).unwrap();
        let sleeping = *world.get::<Sleeping>(body).unwrap();
        world.entity_mut(body).insert((
            kind,
            collider,
            at,
            sleeping,
            Friction::default(),
            CollisionLayers::default(),
            Velocity::default(),
            ExternalForce::default(),
            ExternalImpulse::default(),
            GravityScale::default(),
            Damping::default(),
        ));
    }
    yard.lab.step();
    assert_eq!(yard.active(), (vec![], 0));
    // A write of a different value wakes the body.
    yard.lab.world.entity_mut(cube).insert(Friction::new(0.1));
    yard.lab.step();
    assert!(!yard.sleeps(cube));
    yard.lab.run(3.0);
    assert!(yard.sleeps(cube));
    yard.lab.world.get_mut::<Sleeping>(cube).unwrap().wake();
    yard.lab.step();
    assert!(!yard.sleeps(cube) && yard.sleeps(yard.stacks[1][0]));
}
