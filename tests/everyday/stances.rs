//! Characters that crouch, and platforms that they pass from below.

use super::*;

const SHAPES: [fn() -> Collider; 3] = [
    || Collider::capsule(0.3, 1.0),
    || Collider::cylinder(0.3, 1.6),
    || Collider::cuboid(0.5, 1.6, 0.5),
];

fn hero(world: &mut World, shape: Collider, place: Vec3) -> Entity {
    let place = Transform::from_translation(place);
    let hero = world.spawn((Character::default(), shape, place)).id();
    steps(world, 3);
    hero
}

fn wish(world: &mut World, hero: Entity, change: impl FnOnce(&mut Character)) {
    change(&mut world.get_mut::<Character>(hero).unwrap());
}

fn place(world: &World, hero: Entity) -> Vec3 {
    world.get::<Transform>(hero).unwrap().translation
}

fn state(world: &World, hero: Entity) -> CharacterState {
    *world.get::<CharacterState>(hero).unwrap()
}

/// Lowest and highest point of its collider, m.
fn extent(world: &World, hero: Entity) -> [f32; 2] {
    let half = world.get::<Collider>(hero).unwrap().half_extents().y;
    let middle = place(world, hero).y;
    [middle - half, middle + half]
}

fn fixed(world: &mut World, size: Vec3, at: Vec3) -> Entity {
    let collider = Collider::cuboid(size.x, size.y, size.z);
    let place = Transform::from_translation(at);
    world.spawn((RigidBody::Static, collider, place)).id()
}

#[test]
fn a_character_crouches_under_a_beam_and_gets_up_behind_it() {
    for shape in SHAPES {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        // From x = 2 to 4, 1.2 m above the ground.
        fixed(world, Vec3::new(2.0, 0.2, 4.0), Vec3::new(3.0, 1.3, 0.0));
        let hero = hero(world, shape(), Vec3::Y * 0.81);
        let [feet, head] = extent(world, hero);
        assert!(feet.abs() < 0.02 && (head - 1.6).abs() < 0.03);
        wish(world, hero, |hero| hero.walk = Vec3::X * 2.0);
        steps(world, 120);
        assert!(place(world, hero).x < 2.0, "the beam stops it");
        wish(world, hero, |hero| hero.crouches = true);
        let before = extent(world, hero)[0];
        steps(world, 2);
        let [feet, head] = extent(world, hero);
        assert!(
            (feet - before).abs() < 1e-4,
            "its feet stay: {feet} {before}"
        );
        assert!((head - 1.0).abs() < 0.03, "{head}");
        assert!(state(world, hero).stands() && state(world, hero).crouches());
        steps(world, 40);
        assert!((2.0..4.0).contains(&place(world, hero).x));
        // It wants to get up, and has no room.
        wish(world, hero, |hero| hero.crouches = false);
        steps(world, 5);
        assert!(state(world, hero).crouches());
        steps(world, 120);
        assert!(place(world, hero).x > 4.3);
        let [feet, head] = extent(world, hero);
        assert!(!state(world, hero).crouches() && state(world, hero).stands());
        assert!((feet - before).abs() < 1e-3 && (head - 1.6).abs() < 0.03);
    }
}

/// A character of another kind of shape does not crouch, and one that crouches is not pushed about.
#[test]
fn crouching_moves_nothing_else() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let ball = hero(world, Collider::ball(0.4), Vec3::new(5.0, 0.41, 0.0));
    let hero = hero(world, SHAPES[0](), Vec3::Y * 0.81);
    let from = place(world, hero);
    for crouches in [true, false, true, false] {
        for of in [ball, hero] {
            wish(world, of, |of| of.crouches = crouches);
        }
        steps(world, 30);
    }
    assert!((place(world, hero) - from).length() < 1e-4);
    assert!(!state(world, ball).crouches());
}

#[test]
fn a_character_jumps_through_a_platform_stands_on_it_and_drops() {
    for thick in [0.05, 0.3, 1.0] {
        let mut app = app();
        let world = app.world_mut();
        world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
        let platform = fixed(
            world,
            Vec3::new(4.0, thick, 4.0),
            Vec3::Y * (3.0 - 0.5 * thick),
        );
        let layers = CollisionLayers::new(LayerMask(2), LayerMask::ALL);
        world.entity_mut(platform).insert(layers);
        let hero = hero(world, SHAPES[0](), Vec3::Y * 0.81);
        wish(world, hero, |hero| hero.jump = 8.5);
        steps(world, 120);
        let stands = place(world, hero).y;
        assert!(
            stands < 1.0,
            "{thick}: it is no one-way platform yet: {stands}"
        );
        wish(world, hero, |hero| {
            hero.one_way = LayerMask(2);
            hero.jump = 8.5;
        });
        steps(world, 120);
        let feet = extent(world, hero)[0];
        assert!((feet - 3.0).abs() < 0.03, "{thick}: {feet}");
        assert!(state(world, hero).stands());
        // It walks about on it, and down through it.
        wish(world, hero, |hero| hero.walk = Vec3::X);
        steps(world, 60);
        wish(world, hero, |hero| hero.walk = Vec3::ZERO);
        assert!(state(world, hero).stands());
        assert!((extent(world, hero)[0] - feet).abs() < 1e-3);
        wish(world, hero, |hero| hero.drops = true);
        steps(world, 90);
        let feet = extent(world, hero)[0];
        assert!(
            feet < 0.03 && state(world, hero).stands(),
            "{thick}: {feet}"
        );
    }
}

/// It walks through the side of a low platform, and steps up a stair of ordinary bodies as before.
#[test]
fn the_sides_of_one_way_platforms_are_open() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, Collider::half_space(Vec3::Y)));
    let platform = fixed(world, Vec3::new(2.0, 0.2, 4.0), Vec3::new(2.0, 1.0, 0.0));
    let layers = CollisionLayers::new(LayerMask(2), LayerMask::ALL);
    world.entity_mut(platform).insert(layers);
    fixed(world, Vec3::new(2.0, 0.4, 4.0), Vec3::new(6.0, 0.0, 0.0));
    let hero = hero(world, SHAPES[0](), Vec3::Y * 0.81);
    wish(world, hero, |hero| {
        hero.one_way = LayerMask(2);
        hero.walk = Vec3::X * 2.0;
    });
    for _ in 0..180 {
        steps(world, 1);
        assert!(state(world, hero).stands());
    }
    assert!((place(world, hero).x - 6.0).abs() < 0.1);
    assert!((extent(world, hero)[0] - 0.2).abs() < 0.03);
}
