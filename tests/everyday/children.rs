//! Bodies with many children, and bodies below bodies.

use super::*;
use bevy_ecs::message::Messages;
use drystone::children::CompoundCollider;
use drystone::diagnosis::BodyProblem;
use std::time::Instant;

/// Seconds to spawn a body with so many parts, and to take a step.
fn spawn(parts: usize, nested: bool) -> [f64; 2] {
    let mut app = app();
    let world = app.world_mut();
    steps(world, 1);
    let start = Instant::now();
    let body = world.spawn((RigidBody::Dynamic, at(0.0, 5.0, 0.0))).id();
    let place = |i: usize| {
        at(
            0.2 * (i % 10) as f32,
            0.2 * (i / 10 % 10) as f32,
            0.2 * (i / 100) as f32,
        )
    };
    for i in 0..parts {
        let above = match nested {
            true => world.spawn((Transform::default(), ChildOf(body))).id(),
            false => body,
        };
        world.spawn((cube(0.2), Density(500.0), place(i), ChildOf(above)));
    }
    let spawned = start.elapsed().as_secs_f64();
    steps(world, 1);
    let all = start.elapsed().as_secs_f64();
    assert_eq!(
        world.get::<CompoundCollider>(body).unwrap().parts().count(),
        parts
    );
    let mass = world.get::<MassProperties>(body).unwrap().mass();
    let wanted = 4.0 * parts as f32;
    assert!((mass / wanted - 1.0).abs() < 1e-3, "{mass} {wanted}");
    [spawned, all - spawned]
}

#[test]
fn ten_times_as_many_children_cost_about_ten_times_as_much() {
    for nested in [false, true] {
        spawn(50, nested);
        let least = |parts: usize| {
            let times = (0..5).map(|_| spawn(parts, nested));
            times.fold([f64::MAX; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])])
        };
        let (few, many) = (least(200), least(2000));
        for (few, many) in few.into_iter().zip(many) {
            assert!(many < 50.0 * few, "{nested}: {few} s and {many} s");
        }
    }
}

#[test]
fn the_mass_of_few_children_is_known_at_once_and_of_many_after_a_step() {
    let mut app = app();
    let world = app.world_mut();
    for parts in [1, 3, 30, 100] {
        let body = world
            .spawn((
                RigidBody::Dynamic,
                GravityScale(0.0),
                at(0.0, 0.0, 9.0 * parts as f32),
            ))
            .id();
        for i in 0..parts {
            let place = at(0.3 * i as f32, 0.0, 0.0);
            world.spawn((cube(0.2), Mass(2.0), place, ChildOf(body)));
        }
        let mass = |world: &World| world.get::<MassProperties>(body).unwrap().mass();
        let wanted = 2.0 * parts as f32;
        if parts < 32 {
            assert!((mass(world) - wanted).abs() < 1e-3 * wanted);
        }
        drystone::refresh(world);
        assert!((mass(world) - wanted).abs() < 1e-3 * wanted);
        steps(world, 1);
        assert!((mass(world) - wanted).abs() < 1e-3 * wanted);
    }
}

/// A ship that is moved by its `Transform`, and the brick on it.
struct Ship {
    app: App,
    ship: Entity,
    brick: Entity,
    hz: f32,
}

/// How the brick hangs below the ship.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Below {
    /// A child.
    Child,
    /// With an entity that is no body between them.
    Node,
    /// Below a kinematic body that is a child of the ship.
    Deck,
    /// Below another brick, which lies elsewhere on the ship.
    Brick,
}

impl Ship {
    fn new(hz: f32, below: Below, origin: Transform) -> Self {
        let mut app = app();
        let world = app.world_mut();
        let ship = Collider::cuboid(20.0, 1.0, 20.0);
        let ship = world.spawn((RigidBody::Kinematic, ship, origin)).id();
        let block = || Collider::cuboid(1.0, 0.5, 0.5);
        let (parent, place) = match below {
            Below::Child => (ship, at(2.0, 0.75, 1.0)),
            Below::Node => {
                let node = at(1.0, 0.5, 0.0).with_rotation(Quat::from_rotation_y(0.7));
                let node = world.spawn((node, ChildOf(ship))).id();
                (node, at(1.0, 0.25, 0.5))
            }
            Below::Deck => {
                let deck = (RigidBody::Kinematic, Collider::cuboid(6.0, 1.0, 6.0));
                let deck = world.spawn((deck, at(2.0, 1.0, 0.0), ChildOf(ship))).id();
                (deck, at(0.5, 0.75, 1.0))
            }
            Below::Brick => {
                let other = (RigidBody::Dynamic, block(), at(-3.0, 0.75, 0.0));
                let other = world.spawn((other, ChildOf(ship))).id();
                (other, at(5.0, 0.0, 1.0))
            }
        };
        let brick = (RigidBody::Dynamic, block(), Friction::new(0.9), place);
        let brick = world.spawn((brick, ChildOf(parent))).id();
        let mut ship = Self {
            app,
            ship,
            brick,
            hz,
        };
        ship.run(1.0, |_, _| ());
        ship
    }

    /// Changes the ship's `Transform` before each step; `change` gets the time since the beginning, s.
    fn run(&mut self, seconds: f32, change: impl Fn(f32, &mut Transform)) {
        for i in 0..(seconds * self.hz) as usize {
            let world = self.app.world_mut();
            let mut place = world.get_mut::<Transform>(self.ship).unwrap();
            change((i + 1) as f32 / self.hz, &mut place);
            drystone::step(world, 1.0 / self.hz).unwrap();
        }
    }

    /// Where the brick is on the ship, m, and how high its middle is above it.
    fn on_deck(&self) -> Vec3 {
        let world = self.app.world();
        let [ship, brick] = [self.ship, self.brick].map(|body| *world.get::<Pose>(body).unwrap());
        ship.rotation.inverse() * (brick.position - ship.position)
    }
}

/// Every way to hang a brick below a ship, near and far, at 10, 60 and 240 Hz.
fn each_ship(act: impl Fn(Ship, String)) {
    let far = at(700.0, 300.0, -640.0).with_rotation(Quat::from_rotation_y(1.1));
    for below in [Below::Child, Below::Node, Below::Deck, Below::Brick] {
        for (hz, origin) in [(60.0, at(0.0, 0.0, 0.0)), (10.0, far), (240.0, far)] {
            act(
                Ship::new(hz, below, origin),
                format!("{below:?} at {hz} Hz, {}", origin.translation),
            );
        }
    }
}

/// The ship speeds up by 1 m/s², which friction bears, and the brick stays where it lies.
#[test]
fn a_brick_below_a_ship_that_sails_lies_where_it_lay() {
    each_ship(|mut ship, what| {
        let (before, start) = (ship.on_deck(), position(ship.app.world(), ship.ship));
        ship.run(3.0, |t, place| {
            place.translation = start + Vec3::X * (0.5 * t * t)
        });
        let after = ship.on_deck();
        assert!((after - before).length() < 0.02, "{what}: {before} {after}");
    });
}

#[test]
fn a_brick_below_a_ship_that_turns_lies_where_it_lay() {
    each_ship(|mut ship, what| {
        let before = ship.on_deck();
        let start = ship
            .app
            .world()
            .get::<Transform>(ship.ship)
            .unwrap()
            .rotation;
        ship.run(4.0, |t, place| {
            place.rotation = Quat::from_rotation_y(0.05 * t * t) * start
        });
        let after = ship.on_deck();
        assert!((after - before).length() < 0.02, "{what}: {before} {after}");
    });
}

/// The friction of a ship that starts at once takes the brick along after it has slipped.
#[test]
fn a_ship_that_starts_at_once_takes_its_brick_along() {
    each_ship(|mut ship, what| {
        let (before, start) = (ship.on_deck(), position(ship.app.world(), ship.ship));
        ship.run(2.0, |t, place| place.translation = start + Vec3::X * t);
        let after = ship.on_deck();
        assert!((after - before).length() < 0.15, "{what}: {before} {after}");
    });
}

/// On ice nothing takes it along.
#[test]
fn a_ship_slides_away_below_a_brick_on_ice() {
    for below in [Below::Child, Below::Node, Below::Brick] {
        let mut ship = Ship::new(60.0, below, at(0.0, 0.0, 0.0));
        let (brick, deck) = (ship.brick, ship.ship);
        let world = ship.app.world_mut();
        world.entity_mut(brick).insert(ice());
        let before = world.get::<Pose>(brick).unwrap().position;
        let start = position(world, deck);
        ship.run(2.0, |t, place| place.translation = start + Vec3::X * t);
        let after = ship.app.world().get::<Pose>(brick).unwrap().position;
        assert!(
            (after - before).length() < 1e-3,
            "{below:?}: {before} {after}"
        );
    }
}

#[test]
fn a_ship_that_is_teleported_takes_all_along() {
    for fast in [false, true] {
        for below in [Below::Child, Below::Node, Below::Brick] {
            let mut ship = Ship::new(60.0, below, at(0.0, 0.0, 0.0));
            let before = ship.on_deck();
            let (deck, speed) = (ship.ship, if fast { 1e5 } else { 1.0 });
            let world = ship.app.world_mut();
            let mut place = world.get_mut::<Transform>(deck).unwrap();
            place.translation.x += speed * DT;
            if !fast {
                world.entity_mut(deck).insert(Teleport);
            }
            steps(world, 2);
            let after = ship.on_deck();
            assert!(
                (after - before).length() < 5e-3,
                "{fast}, {below:?}: {before} {after}"
            );
        }
    }
}

/// A user may move a brick on a ship while that sails.
#[test]
fn a_brick_is_put_elsewhere_on_a_ship_that_sails() {
    for below in [Below::Child, Below::Node] {
        let mut ship = Ship::new(60.0, below, at(0.0, 0.0, 0.0));
        let (brick, start) = (ship.brick, position(ship.app.world(), ship.ship));
        ship.run(1.0, |t, place| {
            place.translation = start + Vec3::X * (0.5 * t * t)
        });
        let before = ship.on_deck();
        let turn = match below {
            Below::Node => Quat::from_rotation_y(0.7),
            _ => Quat::IDENTITY,
        };
        let way = turn.inverse() * Vec3::new(-1.0, 0.0, 0.5);
        ship.app
            .world_mut()
            .get_mut::<Transform>(brick)
            .unwrap()
            .translation += way;
        ship.run(1.0, |t, place| {
            place.translation = start + Vec3::X * (0.5 + t)
        });
        let way = ship.on_deck() - before;
        assert!(
            (way - Vec3::new(-1.0, 0.0, 0.5)).length() < 0.1,
            "{below:?}: {way}"
        );
    }
}

#[test]
fn a_scale_of_zero_is_named_as_the_cause() {
    for scale in [
        Vec3::ZERO,
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::new(f32::NAN, 1.0, 1.0),
        Vec3::splat(1e-20),
    ] {
        for below in [false, true] {
            // A pose below such an entity is not finite either.
            if below && scale.is_nan() {
                continue;
            }
            let mut app = app();
            let world = app.world_mut();
            let place = at(0.0, 1.0, 0.0).with_scale(scale);
            let body = world
                .spawn((RigidBody::Dynamic, cube(1.0), at(0.0, 1.0, 0.0)))
                .id();
            if below {
                let above = world.spawn(place).id();
                world.entity_mut(body).insert(ChildOf(above));
            } else {
                world.entity_mut(body).insert(place);
            }
            let mut errors: Vec<BodyError> = Vec::new();
            for _ in 0..5 {
                steps(world, 1);
                errors.extend(world.resource_mut::<Messages<BodyError>>().drain());
            }
            assert_eq!(errors.len(), 1, "{scale}: {errors:?}");
            assert_eq!(errors[0].problem, BodyProblem::InvalidScale, "{scale}");
            assert!(errors[0].to_string().contains("scale"));
            // It comes back.
            let mended = if below {
                world.get::<ChildOf>(body).unwrap().parent()
            } else {
                body
            };
            world.get_mut::<Transform>(mended).unwrap().scale = Vec3::ONE;
            steps(world, 3);
            assert!(world.get::<Quarantined>(body).is_none(), "{scale}, {below}");
        }
    }
}

/// A negative scale mirrors a shape, and is named where the shape cannot be mirrored.
#[test]
fn a_negative_scale_mirrors_or_is_named() {
    let mut app = app();
    let world = app.world_mut();
    let points = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y, Vec3::Z];
    let hull = Collider::convex_hull(&points).unwrap();
    let body = world
        .spawn((
            RigidBody::Dynamic,
            hull,
            at(0.0, 5.0, 0.0).with_scale(Vec3::splat(-1.0)),
        ))
        .id();
    let field = Collider::height_field(&[vec![0.0; 2], vec![0.0; 2]], Vec3::ONE).unwrap();
    let field = world
        .spawn((
            RigidBody::Static,
            field,
            at(0.0, 0.0, 0.0).with_scale(Vec3::splat(-1.0)),
        ))
        .id();
    steps(world, 1);
    let mut errors = world.resource_mut::<Messages<BodyError>>();
    let errors: Vec<_> = errors
        .drain()
        .map(|error| (error.entity, error.problem))
        .collect();
    assert_eq!(errors, [(field, BodyProblem::InvalidScale)]);
    let center = world.get::<MassProperties>(body).unwrap().local_center;
    assert!(
        (center - Vec3::new(-0.5, -0.25, -0.25)).length() < 1e-5,
        "{center}"
    );
}
