//! A drawing that is built in a world, and the checks of it.

use crate::Lab;
use crate::masonry::blocks::{Block, Frame, Joint, Masonry};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::{Density, Pose, RigidBody};
use drystone::collider::{Collider, Friction};
use drystone::contact::{ContactPair, ContactPoint, Manifold};
use drystone::settings::Gravity;
use glam::{DQuat, DVec2, DVec3, Quat, Vec3};

/// The kind of shape that blocks are built of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum As {
    Hulls,
    /// Cuboids for blocks that are rectangles.
    Cuboids,
    /// Hulls whose contacts are not found, but those of the drawing: to tell what the solver does from what collision detection does.
    TrueContacts,
}

/// How a drawing is built.
#[derive(Clone, Copy, Debug)]
pub struct How {
    pub shapes: As,
    /// Its weight comes on over five seconds, as if centring were taken away; else at once.
    pub slowly: bool,
}

impl How {
    pub const SLOWLY: Self = Self {
        shapes: As::Hulls,
        slowly: true,
    };
    pub const AT_ONCE: Self = Self {
        shapes: As::Hulls,
        slowly: false,
    };
    pub const TRUE_SLOWLY: Self = Self {
        shapes: As::TrueContacts,
        slowly: true,
    };
    pub const TRUE_AT_ONCE: Self = Self {
        shapes: As::TrueContacts,
        slowly: false,
    };
    pub const ALL: [Self; 4] = [
        Self::SLOWLY,
        Self::AT_ONCE,
        Self::TRUE_SLOWLY,
        Self::TRUE_AT_ONCE,
    ];
}

/// How it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Stands,
    /// Nothing has gone far, but something moves.
    Shakes,
    Falls,
}

/// A built drawing.
pub struct Site {
    pub lab: Lab,
    pub masonry: Masonry,
    pub frame: Frame,
    /// One for each block.
    pub bodies: Vec<Entity>,
    start: Vec<Pose>,
}

/// Seconds after which what still stands is taken to stand.
const LONG: f32 = 10.0;

/// Seconds in which weight comes on slowly.
const SLOW: f32 = 5.0;

/// A patch's normal may be off by this, rad: 0.1°.
const NORMAL: f64 = 0.1 * std::f64::consts::PI / 180.0;

fn hull(block: &Block, shapes: As) -> Collider {
    // If contacts are not found from the shapes, the shapes only need to be near each other, which is always detected.
    let smaller = if shapes == As::TrueContacts {
        1e-4
    } else {
        0.0
    };
    let corners: Vec<Vec3> = block
        .corners()
        .into_iter()
        .map(|corner| (corner - smaller * corner.signum()).as_vec3())
        .collect();
    Collider::convex_hull(&corners).expect("a block has volume")
}

fn pose(frame: Frame, center: DVec2, turn: f64) -> Pose {
    let rotation = frame.rotation();
    Pose {
        position: (rotation * center.extend(0.0)).as_vec3(),
        rotation: (rotation * DQuat::from_rotation_z(turn)).as_quat(),
    }
}

impl Site {
    /// At 60 Hz with the default settings, without sleeping.
    pub fn build(masonry: &Masonry, frame: Frame, shapes: As) -> Self {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let mut bodies = Vec::new();
        let mut start = Vec::new();
        for block in &masonry.blocks {
            let collider = match block.cuboid() {
                Some(size) if shapes == As::Cuboids => {
                    let [x, y, z] = size.as_vec3().to_array();
                    Collider::cuboid(x, y, z)
                }
                _ => hull(block, shapes),
            };
            let pose = pose(frame, block.center(), block.turn());
            start.push(pose);
            bodies.push(lab.spawn((
                if block.fixed {
                    RigidBody::Static
                } else {
                    RigidBody::Dynamic
                },
                collider,
                Friction::new(masonry.friction as f32),
                Density(block.density as f32),
                Transform::from_translation(pose.position).with_rotation(pose.rotation),
            )));
        }
        let mut site = Self {
            lab,
            masonry: masonry.clone(),
            frame,
            bodies,
            start,
        };
        if shapes == As::TrueContacts {
            site.hold_true_contacts();
        }
        site
    }

    /// Under a gravity that leans towards −x by this angle, rad.
    pub fn leaning(masonry: &Masonry, tilt: f64, shapes: As) -> Self {
        let mut site = Self::build(masonry, Frame::default(), shapes);
        let down = DQuat::from_rotation_z(-tilt) * DVec3::NEG_Y;
        site.lab.world.resource_mut::<Gravity>().0 = crate::G * down.as_vec3();
        site
    }

    pub fn poses(&self) -> Vec<Pose> {
        self.bodies
            .iter()
            .map(|&body| self.lab.pose(body))
            .collect()
    }

    /// The farthest that anything is from where it was, m: ways, and turns on an arm of a metre.
    pub fn moved(&self) -> f64 {
        apart(&self.start, &self.poses())
    }

    /// The fastest, m/s.
    pub fn speed(&self) -> f32 {
        let speed = |&body: &Entity| self.lab.velocity(body).linear.length();
        self.bodies.iter().map(speed).fold(0.0, f32::max)
    }

    /// Brings the weight on bit by bit.
    fn load_slowly(&mut self) {
        let all = self.lab.world.resource::<Gravity>().0;
        let steps = (SLOW / self.lab.dt) as usize;
        for step in 0..steps {
            self.lab.world.resource_mut::<Gravity>().0 = all * (step as f32 / steps as f32);
            self.lab.step();
        }
        self.lab.world.resource_mut::<Gravity>().0 = all;
    }

    /// Whether something moves by `most` m in ten seconds, or is still on its way then.
    pub fn end(&mut self, most: f64, slowly: bool) -> End {
        if slowly {
            self.load_slowly();
        }
        for _ in 0..(LONG / self.lab.dt) as usize {
            self.lab.step();
            if self.moved() > most {
                return End::Falls;
            }
        }
        match self.speed() < 0.01 {
            true => End::Stands,
            false => End::Shakes,
        }
    }

    /// The manifold between two blocks, with the sign that turns its normals from the second to the first.
    fn manifold(&mut self, blocks: [usize; 2]) -> Option<(Manifold, f32)> {
        let [a, b] = blocks.map(|i| self.bodies[i]);
        let mut pairs = self.lab.world.query::<(&ContactPair, &Manifold)>();
        pairs.iter(&self.lab.world).find_map(|(pair, manifold)| {
            let sign = match pair.bodies {
                [first, second] if (first, second) == (a, b) => 1.0,
                [first, second] if (first, second) == (b, a) => -1.0,
                _ => return None,
            };
            Some((manifold.clone(), sign))
        })
    }

    /// Describes faults of the joints. Each must have one patch of four points. As built, it must also have the joint's normal, and a point
    /// within 1 mm of each corner.
    pub fn flaws(&mut self, as_built: bool) -> Vec<String> {
        let mut flaws = Vec::new();
        for joint in self.masonry.joints() {
            let found = match self.manifold(joint.blocks) {
                Some((manifold, _)) if manifold.points.len() != 4 => {
                    vec![format!("{} corners", manifold.points.len())]
                }
                Some((manifold, sign)) if as_built => self.misplaced(&joint, &manifold, sign),
                Some(_) => Vec::new(),
                None => vec!["no pair".to_owned()],
            };
            let named = |flaw| format!("joint {:?}: {flaw}", joint.blocks);
            flaws.extend(found.into_iter().map(named));
        }
        flaws
    }

    /// How a manifold differs from a joint.
    fn misplaced(&self, joint: &Joint, manifold: &Manifold, sign: f32) -> Vec<String> {
        let mut flaws = Vec::new();
        let rotation = self.frame.rotation();
        let first = joint.blocks[if sign > 0.0 { 0 } else { 1 }];
        let origin = self.poses()[first].position;
        for patch in &manifold.patches {
            let normal = (sign * patch.normal).as_dvec3();
            let off = normal.angle_between(rotation * joint.normal.extend(0.0));
            if off.is_nan() || off > NORMAL {
                flaws.push(format!("normal off by {:.2}°", off.to_degrees()));
            }
        }
        for corner in Masonry::joint_corners(joint).map(|p| rotation * p) {
            let away = |point: &ContactPoint| (origin + point.arm).as_dvec3().distance(corner);
            let nearest = manifold
                .points
                .iter()
                .map(away)
                .fold(f64::INFINITY, f64::min);
            if nearest > 1e-3 {
                flaws.push(format!("no point within {nearest:.3} m of a corner"));
            }
        }
        flaws
    }
}

/// The farthest that two sets of poses of the same bodies are apart, m: ways, and turns on an arm of a metre.
pub fn apart(one: &[Pose], other: &[Pose]) -> f64 {
    let turn = |a: Quat, b: Quat| 2.0 * (a.inverse() * b).xyz().length();
    let pairs = one.iter().zip(other);
    let each = pairs.map(|(a, b)| {
        a.position
            .distance(b.position)
            .max(turn(a.rotation, b.rotation))
    });
    // NaN counts as infinitely far.
    each.fold(0.0, |most: f64, x| {
        if x.is_nan() {
            f64::INFINITY
        } else {
            most.max(x as f64)
        }
    })
}

/// Asserts that all joints are found whole as they are built, to 0.1° and a millimetre, and have four corners after two seconds.
#[track_caller]
pub fn joints_stay_whole(sites: impl IntoIterator<Item = (String, Site)>) {
    let mut bad = Vec::new();
    for (what, mut site) in sites {
        site.lab.step();
        let first = site.flaws(true);
        site.lab.run(2.0);
        let later = site.flaws(false);
        let figures = format!(
            "{what}: in {} joints {} flaws at first, {} after 2 s, moved {:.2e} m; {:?} {:?}",
            site.masonry.joints().len(),
            first.len(),
            later.len(),
            site.moved(),
            first.first(),
            later.first(),
        );
        println!("{figures}");
        if !(first.is_empty() && later.is_empty()) {
            bad.push(figures);
        }
    }
    assert!(bad.is_empty(), "{} scenes have flaws: {bad:#?}", bad.len());
}
