//! The meters that examples, tests and the comparison with other engines share: penetration, drift, sag, tilt, jitter, energy.
//!
//! All of them read components only and change nothing. None of them overlooks a body: a body that is quarantined, despawned or not finite
//! is infinitely far off, fast and energetic.

use bevy_ecs::prelude::*;
use drystone::body::{GravityScale, MassProperties, Pose, Quarantined, RigidBody, Velocity};
use drystone::contact::{ContactImpulses, Manifold};
use drystone::settings::{Gravity, StabilizationSettings};
use glam::{Quat, Vec3};

/// The pose and the velocity of a watched body. The pose of a despawned or quarantined body is NaN, which [`Displacement`] counts as
/// fallen.
pub fn watch(world: &World, body: Entity) -> (Pose, Velocity) {
    let seen = || {
        let body = world.get_entity(body).ok()?;
        let sound = !body.contains::<Quarantined>();
        sound.then(|| Some((*body.get::<Pose>()?, *body.get::<Velocity>()?)))?
    };
    seen().unwrap_or((NOWHERE, Velocity::linear(Vec3::NAN)))
}

/// The pose of a lost body.
pub const NOWHERE: Pose = Pose {
    position: Vec3::NAN,
    rotation: Quat::from_array([f32::NAN; 4]),
};

/// The maximum in which NaN counts as larger than any number; comparisons and `max` would ignore it.
fn or_infinite(x: f32) -> f32 {
    if x.is_nan() { f32::INFINITY } else { x }
}

/// Mechanical energy of all dynamic bodies, J: kinetic, and potential against the origin. Infinite where one of them is lost.
pub fn energy(world: &mut World) -> f64 {
    let gravity = world.resource::<Gravity>().0;
    of_dynamic(world, |pose, velocity, mass, scale| {
        let height = -(gravity * scale.0).dot(pose.transform_point(mass.local_center));
        mass.kinetic_energy(pose.rotation, velocity) as f64 + (mass.mass() * height) as f64
    })
}

/// Kinetic energy of all dynamic bodies, J. Infinite where one of them is lost.
pub fn kinetic_energy(world: &mut World) -> f64 {
    of_dynamic(world, |pose, velocity, mass, _| {
        mass.kinetic_energy(pose.rotation, velocity) as f64
    })
}

fn of_dynamic(
    world: &mut World,
    energy: impl Fn(&Pose, &Velocity, &MassProperties, GravityScale) -> f64,
) -> f64 {
    let mut bodies = world.query::<(
        &RigidBody,
        &Pose,
        &Velocity,
        &MassProperties,
        Option<&GravityScale>,
        Has<Quarantined>,
    )>();
    let all: f64 = bodies
        .iter(world)
        .filter(|(kind, ..)| **kind == RigidBody::Dynamic)
        .map(|(_, pose, velocity, mass, scale, lost)| match lost {
            true => f64::NAN,
            false => energy(pose, velocity, mass, scale.copied().unwrap_or_default()),
        })
        .sum();
    if all.is_finite() { all } else { f64::INFINITY }
}

/// Root mean square of the speeds of all dynamic bodies' centres, m/s: jitter, where nothing should move. Infinite where one of
/// them is lost.
pub fn rms_speed(world: &mut World) -> f32 {
    let mut bodies = world.query::<(&RigidBody, &Velocity, Has<Quarantined>)>();
    let (sum, count) = bodies
        .iter(world)
        .filter(|(kind, ..)| **kind == RigidBody::Dynamic)
        .fold((0.0, 0), |(sum, count), (_, velocity, lost)| {
            let square = match lost {
                true => f32::INFINITY,
                false => velocity.linear.length_squared(),
            };
            (sum + square, count + 1)
        });
    if count == 0 {
        0.0
    } else {
        or_infinite((sum / count as f32).sqrt())
    }
}

/// How contact points stand to each other, as detected in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// Deepest overlap of real surfaces, m.
    pub penetration_max: f32,
    /// Mean overlap over all points inside the envelope, m.
    pub penetration_mean: f32,
    /// Largest distance of a loaded point from the method's ideal, m.
    pub ideal_error_max: f32,
    /// Number of points.
    pub points: usize,
}

/// Measures the [`Gaps`] of all contact points.
pub fn gaps(world: &mut World) -> Gaps {
    let settings = *world.resource::<StabilizationSettings>();
    let mut pairs = world.query::<(&Manifold, &ContactImpulses)>();
    let mut gaps = Gaps::default();
    let (mut sum, mut inside) = (0.0, 0);
    for (manifold, impulses) in pairs.iter(world) {
        gaps.points += manifold.points.len();
        for (point, impulse) in manifold.points.iter().zip(&impulses.points) {
            let overlap = or_infinite(-point.distance).max(0.0);
            gaps.penetration_max = gaps.penetration_max.max(overlap);
            if overlap > 0.0 || point.distance <= settings.outer_distance() {
                sum += overlap;
                inside += 1;
            }
            if impulse.normal > 0.0 {
                let error = (point.distance - settings.rest_distance()).abs();
                gaps.ideal_error_max = gaps.ideal_error_max.max(or_infinite(error));
            }
        }
    }
    gaps.penetration_mean = if inside == 0 {
        0.0
    } else {
        sum / inside as f32
    };
    gaps
}

/// The displacement of bodies from their initial poses. It is infinite if a body is lost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// Largest distance sideways, m.
    pub drift: f32,
    /// Largest distance downwards, m.
    pub sag: f32,
    /// Largest turn, rad.
    pub tilt: f32,
}

/// A body that is further off than any of these counts as fallen.
pub const FALLEN: Displacement = Displacement {
    drift: 0.5,
    sag: 0.25,
    tilt: 0.6,
};

impl Displacement {
    /// Between two sets of poses of the same bodies.
    pub fn between<'a>(
        start: impl IntoIterator<Item = &'a Pose>,
        now: impl IntoIterator<Item = &'a Pose>,
    ) -> Self {
        let mut worst = Self::default();
        for (start, now) in start.into_iter().zip(now) {
            let moved = match start.is_finite() && now.is_finite() {
                true => now.position - start.position,
                // This includes a body that is infinitely high, which neither drifts nor sags.
                false => Vec3::NAN,
            };
            worst.drift = worst.drift.max(or_infinite(moved.with_y(0.0).length()));
            worst.sag = worst.sag.max(or_infinite(-moved.y));
            worst.tilt = worst.tilt.max(or_infinite(turn(start, now)));
        }
        worst
    }

    /// True where a body has fallen ([`FALLEN`]).
    pub fn has_fallen(&self) -> bool {
        !(self.drift <= FALLEN.drift && self.sag <= FALLEN.sag && self.tilt <= FALLEN.tilt)
    }
}

/// The angle between two orientations, rad. From the sine of the half: the cosine loses small angles in rounding. By `clamp`, which
/// keeps NaN, and not `min`, which makes it 1.
fn turn(a: &Pose, b: &Pose) -> f32 {
    let between = a.rotation.inverse() * b.rotation;
    2.0 * between.xyz().length().clamp(0.0, 1.0).asin()
}
