//! A brick that slides over the seams of a floor, or along those of a wall, goes as on one slab.

use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{ExternalForce, Pose, RigidBody};
use drystone::collider::{Collider, CombineRule, Friction};
use glam::{Quat, Vec3, vec3};
use support::Lab;
use support::masonry::site::As;

/// Size of floors and walls, m.
const BRICK: Vec3 = vec3(0.5, 0.25, 0.25);
/// Size of the slider, m.
const SLIDER: Vec3 = vec3(0.6, 0.2, 0.35);
/// m/s
const SPEED: f32 = 3.0;

/// The surface that a slider lies on or leans against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bed {
    Slab,
    Bricks,
    /// In two rows on a slab, free to move.
    FreeBricks,
}

/// One way to slide.
#[derive(Clone, Copy, Debug)]
struct Slide {
    shapes: As,
    friction: f32,
    /// Angle of the slider relative to its direction of motion, rad.
    yaw: f32,
    /// Rotation of the whole scene about the vertical, rad.
    turn: f32,
}

/// How a slider stands and moves after a step, in the axes of the scene.
type Moment = (Pose, Vec3);
type Track = Vec<Moment>;

impl Slide {
    /// All cases, without yaws.
    fn all() -> impl Iterator<Item = Self> {
        let shapes = [As::Cuboids, As::Hulls].into_iter();
        let all = shapes.flat_map(|shapes| [0.3, 0.0].map(|friction| (shapes, friction)));
        all.flat_map(|(shapes, friction)| {
            [0.0, 0.3].map(|turn| Self {
                shapes,
                friction,
                yaw: 0.0,
                turn,
            })
        })
    }

    fn spin(&self) -> Quat {
        Quat::from_rotation_y(self.turn)
    }

    fn collider(&self, size: Vec3) -> Collider {
        if self.shapes == As::Cuboids {
            return Collider::cuboid(size.x, size.y, size.z);
        }
        let corner =
            |i: i32| size * (vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5);
        Collider::convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).expect("a brick has volume")
    }

    /// A body with its middle there.
    fn put(&self, lab: &mut Lab, kind: RigidBody, size: Vec3, middle: Vec3, yaw: f32) -> Entity {
        let slides = Friction::new(self.friction).with_rule(CombineRule::Min);
        lab.spawn((
            kind,
            self.collider(size),
            if size == SLIDER {
                slides
            } else {
                Friction::new(0.8)
            },
            Transform::from_translation(self.spin() * middle)
                .with_rotation(self.spin() * Quat::from_rotation_y(yaw)),
        ))
    }

    /// Bricks that fill a box, or one slab; counts along x, y, z from a corner.
    fn fill(&self, lab: &mut Lab, kind: RigidBody, bricks: bool, corner: Vec3, counts: [usize; 3]) {
        let count = Vec3::from_array(counts.map(|n| n as f32));
        if !bricks {
            let size = BRICK * count;
            self.put(lab, kind, size, corner + 0.5 * size, 0.0);
            return;
        }
        let [x, y, z] = counts;
        for i in 0..x * y * z {
            let at = vec3((i % x) as f32, (i / x % y) as f32, (i / x / y) as f32);
            self.put(lab, kind, BRICK, corner + BRICK * (at + 0.5), 0.0);
        }
    }

    /// The track of a slider that is launched after half a second at rest.
    fn track(&self, mut lab: Lab, slider: Entity, seconds: f32) -> Track {
        lab.run(0.5);
        lab.set_velocity(slider, self.spin() * Vec3::X * SPEED, Vec3::ZERO);
        let back = self.spin().inverse();
        let mut track = Vec::new();
        for _ in 0..(seconds / lab.dt) as usize {
            lab.step();
            let pose = lab.pose(slider);
            let pose = Pose {
                position: back * pose.position,
                rotation: back * pose.rotation,
            };
            track.push((pose, back * lab.velocity(slider).linear));
        }
        assert_eq!(lab.errors(), []);
        track
    }

    fn over_floor(&self, bed: Bed) -> Track {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let wide = if bed == Bed::FreeBricks { 2 } else { 8 };
        let corner = vec3(-1.0, -BRICK.y, -0.5 * BRICK.z * wide as f32);
        let counts = [14, 1, wide];
        if bed == Bed::FreeBricks {
            let below = corner - Vec3::Y * BRICK.y;
            self.fill(&mut lab, RigidBody::Static, false, below, counts);
            self.fill(&mut lab, RigidBody::Dynamic, true, corner, counts);
        } else {
            self.fill(
                &mut lab,
                RigidBody::Static,
                bed == Bed::Bricks,
                corner,
                counts,
            );
        }
        let middle = Vec3::Y * 0.5 * SLIDER.y;
        let slider = self.put(&mut lab, RigidBody::Dynamic, SLIDER, middle, self.yaw);
        self.track(lab, slider, 1.5)
    }

    /// On a slab, along a wall that it is pushed against by a fifth of its weight.
    fn along_wall(&self, bed: Bed) -> Track {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let floor = vec3(-1.0, -BRICK.y, -BRICK.z);
        self.fill(&mut lab, RigidBody::Static, false, floor, [14, 1, 5]);
        let bricks = bed == Bed::Bricks;
        // Half a brick lower, so that there is a seam along the slider too.
        let wall = vec3(-1.0, -0.5 * BRICK.y, -BRICK.z);
        self.fill(&mut lab, RigidBody::Static, bricks, wall, [14, 3, 1]);
        let middle = 0.5 * SLIDER.with_x(0.0);
        let slider = self.put(&mut lab, RigidBody::Dynamic, SLIDER, middle, 0.0);
        let weight = 1000.0 * SLIDER.element_product() * support::G;
        lab.world.entity_mut(slider).insert(ExternalForce {
            force: self.spin() * Vec3::NEG_Z * 0.2 * weight,
            torque: Vec3::ZERO,
            ..Default::default()
        });
        self.track(lab, slider, 1.5)
    }

    /// Describes differences between a bed and a slab: of heights by more than 0.1 mm, of distances and speeds by more than 1 %, of angles
    /// by more than 0.01 rad, and sideways motion of more than `most_aside` (m).
    fn compare(&self, bed: Bed, most_aside: f32, of: impl Fn(Bed) -> Track) -> Option<String> {
        let [found, slab] = [bed, Bed::Slab].map(of);
        let pairs = || found.iter().zip(&slab);
        let worst = |difference: &dyn Fn(&Moment, &Moment) -> f32| {
            let each = pairs().map(|(a, b)| difference(a, b));
            // NaN is worse than any number.
            each.fold(
                0.0f32,
                |w, x| if x.is_nan() { f32::INFINITY } else { w.max(x) },
            )
        };
        let height = worst(&|a, b| (a.0.position.y - b.0.position.y).abs());
        let aside = worst(&|a, b| (a.0.position.z - b.0.position.z).abs());
        let speed = worst(&|a, b| (a.1.length() - b.1.length()).abs()) / SPEED;
        let turn = worst(&|a, b| 2.0 * (a.0.rotation.inverse() * b.0.rotation).xyz().length());
        let [end, slab_end] =
            [&found, &slab].map(|track| track.last().expect("it slid").0.position.x);
        let way = (end / slab_end - 1.0).abs();
        let figures = format!(
            "{bed:?} {self:?}: height {:.3} mm, aside {:.3} mm, speed {:.2} %, turn {turn:.4}, way {end:.3} of {slab_end:.3} m",
            1e3 * height,
            1e3 * aside,
            100.0 * speed,
        );
        println!("{figures}");
        assert!(slab_end > 1.0, "{slab_end} m: it must slide");
        let good = height < 1e-4 && speed < 0.01 && way < 0.01 && turn < 0.01 && aside < most_aside;
        (!good).then_some(figures)
    }
}

#[track_caller]
fn none_differ(different: impl Iterator<Item = Option<String>>) {
    let all: Vec<_> = different.collect();
    let bad: Vec<_> = all.iter().flatten().collect();
    assert!(
        bad.is_empty(),
        "{} of {} differ: {bad:#?}",
        bad.len(),
        all.len()
    );
}

/// A fiftieth of the way of what friction stops.
const ASIDE: f32 = 0.03;

fn at_yaws(slide: Slide, yaws: &[f32]) -> impl Iterator<Item = Slide> {
    yaws.iter().map(move |&yaw| Slide { yaw, ..slide })
}

#[test]
fn a_brick_slides_over_the_seams_of_a_floor() {
    let all = Slide::all().flat_map(|slide| at_yaws(slide, &[0.0, 0.1, 0.3, 0.5, 0.7]));
    none_differ(all.map(|slide| slide.compare(Bed::Bricks, ASIDE, |bed| slide.over_floor(bed))));
}

#[test]
fn a_brick_slides_over_bricks_that_lie_loose() {
    let all = Slide::all().flat_map(|slide| at_yaws(slide, &[0.0, 0.3]));
    none_differ(
        all.map(|slide| slide.compare(Bed::FreeBricks, ASIDE, |bed| slide.over_floor(bed))),
    );
}

#[test]
fn a_brick_slides_along_the_seams_of_a_wall() {
    let all = Slide::all();
    none_differ(all.map(|slide| slide.compare(Bed::Bricks, ASIDE, |bed| slide.along_wall(bed))));
}

/// The result does not depend on the direction of motion relative to the world axes.
#[test]
fn a_brick_slides_straight_over_the_seams_of_a_floor() {
    let cuboids = Slide::all().filter(|slide| slide.shapes == As::Cuboids && slide.friction > 0.0);
    let all = cuboids.flat_map(|slide| at_yaws(slide, &[0.1, 0.3, 0.5, 0.7]));
    none_differ(all.map(|slide| slide.compare(Bed::Bricks, 1e-3, |bed| slide.over_floor(bed))));
}
