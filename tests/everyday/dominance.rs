//! Dominant bodies on and against others: static and kinematic bodies dominate all, so nothing is pressed through them.

use super::*;
use drystone::settings::PhysicsThreads;

/// Where a scene is, and which way is up in it.
#[derive(Clone, Copy, Debug)]
struct Site {
    turn: Quat,
    shift: Vec3,
    hz: f32,
}

const HERE: Site = Site {
    turn: Quat::IDENTITY,
    shift: Vec3::ZERO,
    hz: 60.0,
};

/// Sites of all kinds: steps of several lengths, turned gravity, 1 km from the origin.
fn sites() -> [Site; 5] {
    let turn = Quat::from_axis_angle(Vec3::new(0.3, 0.2, 0.9).normalize(), 0.7);
    let shift = Vec3::new(600.0, -500.0, 620.0);
    [
        HERE,
        Site { hz: 10.0, ..HERE },
        Site { hz: 240.0, ..HERE },
        Site { turn, ..HERE },
        Site { shift, ..HERE },
    ]
}

impl Site {
    /// A world without sleep.
    fn app(self) -> App {
        let mut app = app();
        let world = app.world_mut();
        world.resource_mut::<SleepSettings>().enabled = false;
        world.resource_mut::<Gravity>().0 = self.turn * Vec3::NEG_Y * 9.81;
        app
    }

    fn at(self, x: f32, y: f32, z: f32) -> Transform {
        Transform::from_translation(self.shift + self.turn * Vec3::new(x, y, z))
            .with_rotation(self.turn)
    }

    fn ground(self, world: &mut World) -> Entity {
        let plane = (Collider::half_space(Vec3::Y), self.at(0.0, 0.0, 0.0));
        world.spawn((RigidBody::Static, plane)).id()
    }

    /// A dynamic body.
    fn body(self, world: &mut World, of: impl Bundle, at: [f32; 3]) -> Entity {
        let body = (RigidBody::Dynamic, self.at(at[0], at[1], at[2]));
        world.spawn((body, of)).id()
    }

    fn place(self, world: &World, id: Entity) -> Vec3 {
        self.turn.inverse() * (position(world, id) - self.shift)
    }

    fn speed(self, world: &World, id: Entity) -> Vec3 {
        self.turn.inverse() * velocity(world, id).linear
    }

    fn run(self, world: &mut World, seconds: f32) {
        steps_of(world, (seconds * self.hz).round() as usize, 1.0 / self.hz);
    }
}

/// Runs for 10 s. Bodies must not have moved by more than 1 mm relative to the ground, and must be still on it at the end.
fn assert_still(site: Site, world: &mut World, ground: Entity, bodies: &[Entity], name: &str) {
    let place = |world: &World, body| site.place(world, body) - site.place(world, ground);
    let from: Vec<Vec3> = bodies.iter().map(|&body| place(world, body)).collect();
    for second in 1..=10 {
        site.run(world, 1.0);
        for (i, (&body, from)) in bodies.iter().zip(&from).enumerate() {
            let moved = place(world, body) - *from;
            assert!(
                moved.length() < 1e-3,
                "{name} {site:?}: body {i} moved by {moved} in {second} s"
            );
        }
    }
    for (i, &body) in bodies.iter().enumerate() {
        let speed = site.speed(world, body) - site.speed(world, ground);
        assert!(
            speed.length() < 1e-3,
            "{name} {site:?}: body {i} moves at {speed}"
        );
    }
}

#[test]
fn a_feather_on_a_ton_is_carried() {
    for site in sites() {
        for name in ["half-space", "box", "lift", "ramp"] {
            let site = match name {
                "ramp" => Site {
                    turn: site.turn * Quat::from_rotation_z(10_f32.to_radians()),
                    ..site
                },
                _ => site,
            };
            let mut app = site.app();
            let world = app.world_mut();
            let rough = Friction::new(0.6);
            if name == "ramp" {
                let up = site.turn * Quat::from_rotation_z(-10_f32.to_radians()) * Vec3::Y;
                world.resource_mut::<Gravity>().0 = -9.81 * up;
            }
            let slab = (
                Collider::cuboid(4.0, 1.0, 4.0),
                site.at(0.0, -0.5, 0.0),
                rough,
            );
            let rise = if name == "lift" { Vec3::Y } else { Vec3::ZERO };
            let lift = Velocity::linear(site.turn * rise);
            let ground = match name {
                "half-space" => site.ground(world),
                "lift" => world.spawn((RigidBody::Kinematic, slab, lift)).id(),
                _ => world.spawn((RigidBody::Static, slab)).id(),
            };
            let ton = site.body(world, (cube(1.0), Mass(1000.0), rough), [0.0, 0.5, 0.0]);
            let feather = (cube(1.0), Mass(0.01), Dominance(1), rough);
            let feather = site.body(world, feather, [0.0, 1.5, 0.0]);
            for body in [ton, feather] {
                world.entity_mut(body).insert(lift);
            }
            assert_still(site, world, ground, &[ton, feather], name);
        }
    }
}

#[test]
fn dominant_bodies_on_each_other_are_carried() {
    for site in sites() {
        let mut app = site.app();
        let world = app.world_mut();
        let ground = site.ground(world);
        let bodies = [0, 1, 2].map(|i| {
            let body = (cube(1.0), Mass(1.0), Dominance(i));
            site.body(world, body, [0.0, 0.5 + f32::from(i), 0.0])
        });
        assert_still(site, world, ground, &bodies, "2 on 1 on 0");
    }
}

/// A dominant body on a table moves as any other body does, to the bit.
#[test]
fn a_table_carries_a_dominant_body() {
    let stand = |site: Site, dominance: i8| {
        let mut app = site.app();
        let world = app.world_mut();
        site.ground(world);
        let mut bodies = Vec::new();
        for (x, z) in [(-0.4, -0.4), (0.4, -0.4), (-0.4, 0.4), (0.4, 0.4)] {
            let leg = (Collider::cuboid(0.1, 0.8, 0.1), Mass(2.0));
            bodies.push(site.body(world, leg, [x, 0.4, z]));
        }
        let top = (Collider::cuboid(1.0, 0.05, 1.0), Mass(8.0));
        bodies.push(site.body(world, top, [0.0, 0.825, 0.0]));
        let load = (cube(0.3), Mass(10.0), Dominance(dominance));
        bodies.push(site.body(world, load, [0.1, 1.0, 0.05]));
        site.run(world, 10.0);
        let places = bodies.iter().map(|&body| position(world, body));
        let load = site.place(world, bodies[5]);
        assert!(load.distance(Vec3::new(0.1, 1.0, 0.05)) < 1e-3, "{load}");
        places.collect::<Vec<Vec3>>()
    };
    for site in sites() {
        assert_eq!(stand(site, 0), stand(site, 1), "{site:?}");
    }
}

/// The voussoirs of an arch bear by joints that are much steeper than the push.
#[test]
fn an_arch_carries_a_dominant_body() {
    for site in sites() {
        let mut app = site.app();
        let world = app.world_mut();
        let ground = site.ground(world);
        let rough = Friction::new(0.6);
        let stones = 9;
        let angle = std::f32::consts::PI / stones as f32;
        let ring = |radius: f32, by: f32| Vec3::new(radius * by.sin(), radius * by.cos(), 0.0);
        let mut bodies = Vec::new();
        for i in 0..stones {
            let middle = (i as f32 - 0.5 * (stones - 1) as f32) * angle;
            let center = ring(1.75, middle);
            let corners = [0.0, 1.0].into_iter().flat_map(|end| {
                let by = middle + (end - 0.5) * angle;
                [1.5, 2.0].into_iter().flat_map(move |radius| {
                    [-0.3, 0.3].map(|z| ring(radius, by) - center + Vec3::Z * z)
                })
            });
            let corners: Vec<Vec3> = corners.collect();
            let stone = (Collider::convex_hull(&corners).unwrap(), rough);
            bodies.push(site.body(world, stone, center.to_array()));
        }
        let load = (cube(0.2), Mass(1.0), Dominance(1), rough);
        bodies.push(site.body(
            world,
            load,
            [0.0, 2.1 - 2.0 * (1.0 - (0.5 * angle).cos()), 0.0],
        ));
        site.run(world, 1.0);
        assert_still(site, world, ground, &bodies, "arch");
    }
}

#[test]
fn a_dominant_ball_stops_on_a_stack() {
    for site in sites() {
        let mut app = site.app();
        let world = app.world_mut();
        site.ground(world);
        let brick = || (Collider::cuboid(1.0, 0.5, 0.5), Mass(500.0));
        let bricks =
            [0, 1, 2, 3, 4].map(|i| site.body(world, brick(), [0.0, 0.25 + 0.5 * i as f32, 0.0]));
        let ball = (Collider::ball(0.1), Mass(0.01), Dominance(1));
        let ball = (ball, Velocity::linear(site.turn * Vec3::NEG_Y * 5.0));
        let ball = site.body(world, ball, [0.0, 3.1, 0.0]);
        for _ in 0..(2.0 * site.hz) as usize {
            site.run(world, 1.0 / site.hz);
            for (i, &brick) in bricks.iter().enumerate() {
                let y = site.place(world, brick).y - 0.25 - 0.5 * i as f32;
                assert!(y.abs() < 1e-3, "{site:?}: brick {i} moved by {y}");
            }
            assert!(site.place(world, ball).y > 2.58, "{site:?}");
        }
    }
}

#[test]
fn a_bulldozer_stops_at_a_wall() {
    for site in sites() {
        for count in [1, 3] {
            for motor in [false, true] {
                let mut app = site.app();
                let world = app.world_mut();
                site.ground(world);
                let wall = (Collider::cuboid(1.0, 2.0, 4.0), site.at(5.5, 1.0, 0.0));
                world.spawn((RigidBody::Static, wall));
                let blocks: Vec<Entity> = (0..count)
                    .map(|i| {
                        site.body(
                            world,
                            (cube(1.0), Mass(1000.0)),
                            [1.5 + 1.1 * i as f32, 0.5, 0.0],
                        )
                    })
                    .collect();
                let dozer = (cube(1.0), Mass(100.0), Dominance(1), GravityScale(0.0));
                let dozer = site.body(
                    world,
                    (dozer, Velocity::linear(site.turn * Vec3::X)),
                    [0.0, 0.5, 0.0],
                );
                if motor {
                    let force = ExternalForce {
                        force: site.turn * Vec3::X * 200.0,
                        ..Default::default()
                    };
                    world.entity_mut(dozer).insert(force);
                }
                let mut farthest = 0.0_f32;
                for step in 0..(8.0 * site.hz) as usize {
                    site.run(world, 1.0 / site.hz);
                    for (i, &block) in blocks.iter().enumerate() {
                        let x = site.place(world, block).x - (4.5 - (count - 1 - i) as f32);
                        farthest = farthest.max(x);
                        assert!(
                            x < 5e-3,
                            "{site:?}, {count}, {motor}, step {step}: block {i} passes by {x}"
                        );
                    }
                }
                let v = site.speed(world, dozer);
                assert!(v.length() < 1e-3 || !motor, "{site:?}, {count}: {v}");
                if motor {
                    let x = site.place(world, dozer).x - (4.5 - count as f32);
                    assert!(
                        x.abs() < 5e-3,
                        "{site:?}, {count}: it stands {x} from the blocks"
                    );
                }
            }
        }
    }
}

/// A dominant body pushes free bodies at its own speed, also over the floor and while they sleep.
#[test]
fn free_bodies_are_pushed_at_exactly_its_speed() {
    for site in sites() {
        for (sleep, count) in [(false, 1), (true, 1), (true, 4)] {
            let mut app = site.app();
            let world = app.world_mut();
            world.resource_mut::<SleepSettings>().enabled = sleep;
            site.ground(world);
            let blocks: Vec<Entity> = (0..count)
                .map(|i| site.body(world, (cube(1.0), Mass(1000.0)), [4.0 + i as f32, 0.5, 0.0]))
                .collect();
            let pusher = (cube(0.5), Mass(0.1), Dominance(1), GravityScale(0.0));
            let pusher = site.body(
                world,
                (pusher, Velocity::linear(site.turn * Vec3::X)),
                [0.0, 0.5, 0.0],
            );
            site.run(world, 6.0);
            let v = velocity(world, pusher).linear;
            assert_eq!(v, site.turn * Vec3::X, "{site:?}, {sleep}, {count}");
            for block in blocks {
                let v = site.speed(world, block);
                assert!(
                    (v - Vec3::X).length() < 0.01,
                    "{site:?}, {sleep}, {count}: {v}"
                );
            }
        }
    }
}

/// A body that sleeps in free space is not static for a dominant one.
#[test]
fn sleeping_bodies_in_free_space_do_not_stop_it() {
    let mut app = app();
    let world = app.world_mut();
    let heavy = [0.0, 1.0, 2.0].map(|x| {
        let body = (cube(1.0), Mass(1000.0), GravityScale(0.0));
        HERE.body(world, body, [x, 0.0, 0.0])
    });
    steps(world, 120);
    assert!(world.get::<Sleeping>(heavy[0]).unwrap().asleep);
    let light = (
        Collider::ball(0.2),
        Mass(0.1),
        Dominance(1),
        GravityScale(0.0),
    );
    let light = HERE.body(world, (light, Velocity::linear(Vec3::X)), [-2.0, 0.0, 0.0]);
    steps(world, 180);
    assert_eq!(velocity(world, light).linear, Vec3::X);
    for body in heavy {
        assert!(velocity(world, body).linear.x > 0.95);
    }
}

/// They come to rest and sleep, and wake when the ton is taken away.
#[test]
fn a_feather_and_a_ton_sleep_and_wake() {
    for site in sites() {
        let mut app = site.app();
        let world = app.world_mut();
        world.resource_mut::<SleepSettings>().enabled = true;
        site.ground(world);
        let ton = site.body(world, (cube(1.0), Mass(1000.0)), [0.0, 0.55, 0.0]);
        let feather = site.body(
            world,
            (cube(1.0), Mass(0.01), Dominance(1)),
            [0.0, 1.7, 0.0],
        );
        site.run(world, 5.0);
        for body in [ton, feather] {
            assert!(world.get::<Sleeping>(body).unwrap().asleep, "{site:?}");
        }
        assert!(site.place(world, ton).y > 0.499, "{site:?}");
        // One that falls on the sleeping ton is carried, too.
        let second = (cube(0.2), Mass(0.01), Dominance(1));
        let second = site.body(world, second, [0.0, 2.5, 0.0]);
        site.run(world, 5.0);
        assert!(site.place(world, second).y > 2.09, "{site:?}");
        assert!(site.place(world, ton).y > 0.499, "{site:?}");
        world.despawn(ton);
        site.run(world, 2.0);
        assert!(
            (site.place(world, feather).y - 0.5).abs() < 2e-3,
            "{site:?}"
        );
    }
}

#[test]
fn it_does_not_depend_on_threads() {
    let run = |threads: usize| {
        let mut app = app();
        let world = app.world_mut();
        world.insert_resource(PhysicsThreads::new(threads).unwrap().with_min_items(2));
        HERE.ground(world);
        let mut bodies = Vec::new();
        for i in 0..60 {
            let at = [
                (i % 6) as f32 * 0.55,
                0.3 + (i / 6) as f32 * 0.6,
                (i % 7) as f32 * 0.05,
            ];
            let body = (cube(0.5), Mass(1.0 + i as f32), Dominance((i % 3) as i8));
            bodies.push(HERE.body(world, body, at));
        }
        steps(world, 200);
        bodies
            .iter()
            .for_each(|&body| assert!(position(world, body).y > 0.2));
        let bits = |&body: &Entity| position(world, body).to_array().map(f32::to_bits);
        bodies.iter().map(bits).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(2));
}
