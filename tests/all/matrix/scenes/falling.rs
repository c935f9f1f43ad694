//! Bodies that fall, bounce and slide.

use super::*;
use drystone::body::BodyState;
use std::array;

pub fn heap_that_falls() -> Scene {
    Scene {
        start: |world| {
            build(world, "heap:60");
            steps(world, 40);
            Vec::new()
        },
        shows: |shown| assert!(count(shown, "started") > 20),
        ..Scene::default()
    }
}

pub fn heap_of_200() -> Scene {
    Scene {
        start: |world| {
            world.resource_mut::<SleepSettings>().enabled = false;
            build_off(world, "heap:200")
        },
        steps: 90,
        ..Scene::default()
    }
}

pub fn balls_that_bounce() -> Scene {
    Scene {
        start: |world| {
            floor(world);
            let balls: [Entity; 5] = array::from_fn(|i| {
                let i = i as f32;
                let bounce = (Restitution::new(0.9), RollingFriction::new(0.02));
                let velocity = Velocity::linear(Vec3::X * (0.3 * i));
                body(
                    world,
                    Collider::ball(0.4),
                    at(1.5 * i, 2.0 + i),
                    (bounce, velocity),
                )
            });
            steps(world, 50);
            balls.to_vec()
        },
        steps: 120,
        shows: |shown| assert!(count(shown, "started") > 2),
        ..Scene::default()
    }
}

pub fn dominoes_in_the_middle_of_their_fall() -> Scene {
    Scene {
        start: |world| {
            build(world, "dominoes:12");
            steps(world, 60);
            Vec::new()
        },
        ..Scene::default()
    }
}

/// Compounds, balls and rounded cuboids that fall on a static body.
fn compounds(world: &mut World, ground: Collider) -> Vec<Entity> {
    world.spawn((RigidBody::Static, ground));
    let cube = Collider::cuboid(0.5, 0.5, 0.5);
    let part = |x: f32, y: f32| (Vec3::new(x, y, 0.0), Quat::IDENTITY, cube.clone());
    let angle = Collider::compound(vec![part(0.0, 0.0), part(0.5, 0.0), part(0.0, 0.5)]).unwrap();
    for i in 0..3 {
        let x = 1.5 * i as f32;
        body(world, angle.clone(), at(x - 2.0, 1.5), ());
        body(world, Collider::ball(0.3), at(x - 1.3, 1.5), ());
        body(
            world,
            Collider::round_cuboid(0.6, 0.4, 0.6, 0.05),
            at(x - 1.6, 2.6),
            (),
        );
    }
    steps(world, 20);
    Vec::new()
}

/// Parry keeps which parts touch, and the axes between them, so the middle is in several places of their fall.
const FALL: &[usize] = &[0, 15, 30, 70];

pub fn compounds_on_a_half_space() -> Scene {
    Scene {
        start: |world| compounds(world, Collider::half_space(Vec3::Y)),
        middles: FALL,
        ..Scene::default()
    }
}

/// Two triangles that are not in one plane.
pub fn compounds_on_triangles() -> Scene {
    Scene {
        start: |world| {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let corners = corners.map(|(x, z)| Vec3::new(6.0 * x, 0.3 * x * z, 6.0 * z));
            let mesh = Collider::trimesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]);
            compounds(world, mesh.unwrap())
        },
        middles: FALL,
        ..Scene::default()
    }
}

pub fn compounds_on_a_height_field() -> Scene {
    Scene {
        start: |world| {
            let heights = [[0.0, 0.2, 0.0], [0.3, 0.0, 0.1], [0.0, 0.1, 0.4]];
            let field = Collider::height_field(&heights.map(Vec::from), Vec3::new(12.0, 1.0, 12.0));
            compounds(world, field.unwrap())
        },
        middles: FALL,
        ..Scene::default()
    }
}

/// Hulls and meshes are told apart by their place in memory.
pub fn hulls_that_share_a_shape() -> Scene {
    Scene {
        start: |world| {
            let corners = [(-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)];
            let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
            let mesh = Collider::trimesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]);
            world.spawn((RigidBody::Static, mesh.unwrap()));
            let base = [(0.3, -0.3), (0.3, 0.3), (-0.3, -0.3), (-0.3, 0.3)];
            let mut points: Vec<Vec3> = base.iter().map(|&(x, z)| Vec3::new(x, -0.2, z)).collect();
            points.push(Vec3::Y * 0.4);
            let hull = Collider::convex_hull(&points).unwrap();
            for i in 0..12 {
                let place = at(0.9 * (i % 4) as f32, 0.5 + 0.7 * (i / 4) as f32);
                body(world, hull.clone(), place, ());
            }
            let cube = Collider::cuboid(0.5, 0.5, 0.5);
            let parent = body(world, cube.clone(), at(-2.0, 0.3), ());
            world.spawn((cube, at(0.5, 0.0), ChildOf(parent)));
            steps(world, 30);
            Vec::new()
        },
        ..Scene::default()
    }
}

/// There are so many bricks in one place that only the deepest pairs have contacts.
pub fn crowd() -> Scene {
    Scene {
        start: |world| {
            floor(world);
            for i in 0..40 {
                brick(world, 0.01 * i as f32, 0.5 + 0.01 * (i % 7) as f32);
            }
            steps(world, 3);
            Vec::new()
        },
        steps: 120,
        ..Scene::default()
    }
}

/// Sixteen towers that lean, and balls that fly about and join them.
fn towers(world: &mut World) -> Vec<Entity> {
    world.resource_mut::<SleepSettings>().enabled = false;
    floor(world);
    let mut bodies = Vec::new();
    for i in 0..16 {
        let place = Vec3::new((i % 4) as f32, 0.0, (i / 4) as f32) * 4.0;
        for course in 0..5 {
            let offset = Vec3::new(0.12 * course as f32, 0.5 + course as f32, 0.0);
            bodies.push(cube(world, Transform::from_translation(place + offset)));
        }
        let velocity = Velocity {
            linear: Vec3::new(3.0, 1.0, 0.1 * i as f32),
            angular: Vec3::X,
        };
        let place = Transform::from_translation(place + Vec3::new(-1.5, 3.0, 0.2));
        bodies.push(body(world, Collider::ball(0.3), place, velocity));
    }
    bodies
}

pub fn islands_that_meet() -> Scene {
    Scene {
        start: towers,
        steps: 120,
        ..Scene::default()
    }
}

/// Lets some balls through, and makes others slide.
struct Picky;

impl ContactHook for Picky {
    fn filter_pair(&self, bodies: [&BodyState; 2]) -> bool {
        let number = bodies.iter().map(|body| body.properties.hooks.user_data);
        number.sum::<u64>() % 11 != 3
    }

    fn modify_contacts(&self, contacts: &mut ContactModification) {
        contacts.friction *= 0.5;
        contacts.surface_velocity = Vec3::X * 0.3;
        contacts.retain(|point| point.distance < 0.002);
    }
}

pub fn bodies_with_hooks() -> Scene {
    Scene {
        code: |world| world.insert_resource(ContactHooks::new(Picky)),
        start: |world| {
            let bodies = towers(world);
            for (number, &body) in bodies.iter().enumerate() {
                let hooks = ActiveContactHooks::ALL.with_user_data(number as u64 + 1);
                world.entity_mut(body).insert(hooks);
            }
            steps(world, 10);
            bodies
        },
        ..Scene::default()
    }
}

/// Stacks that slide about on a plate that is far heavier than each of them.
pub fn stacks_on_a_heavy_plate() -> Scene {
    Scene {
        start: |world| {
            world.resource_mut::<SleepSettings>().enabled = false;
            floor(world);
            body(world, Collider::cuboid(20.0, 1.0, 20.0), at(0.0, 0.5), ());
            for i in 0..81 {
                let place = Vec3::new(2.0 * (i % 9) as f32 - 8.0, 1.5, 2.0 * (i / 9) as f32 - 8.0);
                let lower = cube(world, Transform::from_translation(place));
                let velocity = Velocity::linear(Vec3::new(0.02 * i as f32, 0.0, 1.0));
                world.entity_mut(lower).insert(velocity);
                if i % 3 == 0 {
                    cube(world, Transform::from_translation(place + Vec3::Y));
                }
            }
            Vec::new()
        },
        steps: 30,
        ..Scene::default()
    }
}
