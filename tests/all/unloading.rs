//! Load that goes away at once: springs that carried it must not throw what stays.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, RigidBody};
use drystone::collider::Collider;
use drystone_lab::scenes::{Scene, SceneOptions};
use glam::Vec3;
use support::*;

/// A structure that has stood for ten seconds and loses its load.
struct Loaded {
    lab: Lab,
    load: Vec<Entity>,
    left: Vec<Entity>,
}

/// The motion within two seconds of the bodies that remain.
struct Relief {
    /// The largest displacement, m.
    moved: f32,
    /// The fastest way up, m/s.
    up: f32,
    /// The increase of their kinetic (without spin) and potential energy, as the height by which it would lift them all, m.
    gained: f32,
}

fn built(scene: &str, dt: f32) -> (Lab, Vec<Entity>) {
    let mut lab = Lab::shipped(dt);
    let scene: Scene = scene.parse().unwrap();
    let built = scene.build(&mut lab.world, &SceneOptions::default());
    (lab, built.bodies)
}

impl Loaded {
    /// By its upper half.
    fn by_itself(scene: &str, dt: f32) -> Self {
        let (mut lab, bodies) = built(scene, dt);
        lab.run(10.0);
        let height = |&body: &Entity| lab.position(body).y;
        let top = bodies.iter().map(height).fold(0.0, f32::max);
        let (load, left) = bodies.iter().partition(|body| height(body) > 0.5 * top);
        Self { lab, load, left }
    }

    /// By the last body of a scene.
    fn by_last(scene: &str, dt: f32) -> Self {
        let (mut lab, mut left) = built(scene, dt);
        lab.run(10.0);
        let load = left.pop().into_iter().collect();
        Self { lab, load, left }
    }

    /// An arch of 15 with a block of twice the weight of a voussoir on its keystone.
    fn arch(dt: f32) -> Self {
        let (mut lab, left) = built("arch:15", dt);
        let top = 3.3 * (6f32).to_radians().cos();
        let block = lab.spawn((
            RigidBody::Dynamic,
            Collider::cuboid(0.6, 0.5, 1.0),
            Density(2500.0),
            Transform::from_xyz(0.0, top + 0.25, 0.0),
        ));
        lab.run(10.0);
        let load = vec![block];
        Self { lab, load, left }
    }

    /// In one step all load is away: despawned, or thrown far off.
    fn relieve(mut self, despawn: bool) -> Relief {
        let lab = &mut self.lab;
        for (i, body) in self.load.into_iter().enumerate() {
            if despawn {
                lab.world.despawn(body);
            } else {
                let mut transform = lab.world.get_mut::<Transform>(body).unwrap();
                transform.translation += Vec3::new(100.0 + 10.0 * i as f32, 0.0, 0.0);
            }
        }
        let before: Vec<Vec3> = self.left.iter().map(|&b| lab.position(b)).collect();
        let weights: Vec<f32> = self
            .left
            .iter()
            .map(|&body| G * lab.mass(body).mass())
            .collect();
        let mut relief = Relief {
            moved: 0.0,
            up: 0.0,
            gained: 0.0,
        };
        for _ in 0..(2.0 / lab.dt) as usize {
            lab.step();
            let mut gained = 0.0;
            for ((&body, before), weight) in self.left.iter().zip(&before).zip(&weights) {
                let (way, v) = (lab.position(body) - *before, lab.velocity(body).linear);
                relief.moved = relief.moved.max(way.length());
                relief.up = relief.up.max(v.y);
                gained += weight * (way.y + 0.5 * v.length_squared() / G);
            }
            relief.gained = relief.gained.max(gained / weights.iter().sum::<f32>());
        }
        relief
    }
}

/// Asserts that nothing moves by more than so many millimetres.
#[track_caller]
fn stays(scene: &str, dt: f32, most: f32) {
    holds(scene, dt, Loaded::by_itself(scene, dt).relieve(true), most);
}

/// Asserts that nothing moves, nor could by what energy it gains, by more than so many millimetres.
#[track_caller]
fn holds(what: &str, dt: f32, relief: Relief, most: f32) {
    let Relief { moved, up, gained } = relief;
    println!(
        "{what} at {dt:.4}: moved {:.3} mm, up at {up:.4} m/s, energy for {:.3} mm",
        1e3 * moved,
        1e3 * gained
    );
    assert!(1e3 * moved < most, "{what} at {dt}: moved {moved} m");
    assert!(1e3 * gained < most, "{what} at {dt}: gained {gained} m");
}

#[test]
fn structures_unloaded_at_once_do_not_jump() {
    for scene in ["stack:10", "wall:10x10", "pyramid:10"] {
        stays(scene, 1.0 / 60.0, 1.0);
        stays(scene, 0.1, 1.0);
    }
    stays("stack:30", 1.0 / 60.0, 1.0);
}

#[test]
fn an_arch_whose_load_is_taken_away_does_not_jump() {
    let dt = 1.0 / 60.0;
    holds("arch:15", dt, Loaded::arch(dt).relieve(true), 1.0);
}

#[test]
fn an_arch_whose_load_is_taken_away_does_not_jump_at_large_steps() {
    holds("arch:15", 0.1, Loaded::arch(0.1).relieve(true), 1.0);
}

/// Asserts that what loses its topmost body is not moved by more than a millimetre.
#[track_caller]
fn nothing_pushes(scene: &str, dt: f32) {
    let relief = Loaded::by_last(scene, dt).relieve(false);
    holds(&format!("under {scene}"), dt, relief, 1.0);
}

#[test]
fn bodies_thrown_off_leave_no_push_behind() {
    nothing_pushes("stack:10", 1.0 / 60.0);
}

#[test]
fn bodies_thrown_off_leave_no_push_behind_at_large_steps() {
    nothing_pushes("stack:10", 0.1);
}

/// A hundred times as heavy as each of the five cubes that have carried it.
#[test]
fn a_great_weight_that_is_thrown_off_leaves_no_push_behind() {
    nothing_pushes("massratio:100", 1.0 / 60.0);
}

#[test]
fn a_great_weight_that_is_thrown_off_leaves_no_push_behind_at_large_steps() {
    nothing_pushes("massratio:100", 0.1);
}

/// Round bodies have no stored load, but the bodies below carry their weight. No step treats this as a load that was removed.
#[test]
fn structures_under_a_ball_stay_still() {
    for dt in [1.0 / 60.0, 0.1] {
        let mut lab = Lab::shipped(dt);
        lab.ground();
        let cube = lab.cube(Vec3::Y * 0.5);
        let ball = lab.spawn((
            RigidBody::Dynamic,
            Collider::ball(0.5),
            Density(20_000.0),
            Transform::from_xyz(0.0, 1.5, 0.0),
        ));
        lab.run(2.0);
        let from = lab.position(cube);
        for _ in 0..(2.0 / dt) as usize {
            lab.step();
            let speed = lab.velocity(cube).linear.length();
            assert!(speed < 1e-5, "at {dt}: {speed} m/s");
        }
        assert!(lab.position(cube).distance(from) < 1e-6);
        assert!(lab.position(ball).y > 1.49);
    }
}
