//! Disks, rings and cubes that spin on the ground.

use super::feet::{self, RADIUS};
use super::{Settings, Values, threshold};
use crate::{G, Lab};
use bevy_ecs::prelude::*;
use drystone::collider::{Collider, Friction};
use drystone::contact::{ContactImpulses, ContactPair, Manifold};
use glam::Vec3;

/// Names of bodies.
const RING: &str = "ring of 24 feet";
const DISK: &str = "disk of 91 feet";
const CYLINDER: &str = "cylinder on four points";

/// Friction everywhere.
const FRICTION: f32 = 0.1;

/// Lays a body on the ground of a laboratory.
type Lay = fn(&mut Lab) -> Entity;

fn ring(lab: &mut Lab) -> Entity {
    feet::ring(lab, FRICTION)
}

fn disk(lab: &mut Lab) -> Entity {
    feet::disk(lab, FRICTION)
}

fn laid(lab: &mut Lab, collider: Collider, half: f32) -> Entity {
    let body = lab.body(collider, Vec3::Y * half);
    lab.world.entity_mut(body).insert(Friction::new(FRICTION));
    body
}

fn cylinder(lab: &mut Lab) -> Entity {
    laid(lab, Collider::cylinder(RADIUS, 0.05), 0.025)
}

fn cube(lab: &mut Lab) -> Entity {
    laid(lab, Collider::cuboid(0.5, 0.5, 0.5), 0.25)
}

/// At rest for half a second, so that pressure is found; then with this velocity (m/s) and spin (rad/s).
fn set_off(settings: Settings, dt: f32, lay: Lay, speed: f32, spin: f32) -> (Lab, Entity) {
    let mut lab = settings(dt);
    lab.slope(0.0, FRICTION);
    let body = lay(&mut lab);
    lab.run(0.5);
    lab.set_velocity(body, Vec3::X * speed, Vec3::Y * spin);
    (lab, body)
}

/// Speed (m/s) and spin (rad/s) in the plane.
fn motion(lab: &Lab, body: Entity) -> (f32, f32) {
    let v = lab.velocity(body);
    (v.linear.with_y(0.0).length(), v.angular.y.abs())
}

/// The ratio v/(R ω) that does not change while a body slides and spins: larger ones decrease and smaller ones grow.
fn steady_ratio(settings: Settings, dt: f32, lay: Lay, [low, high]: [f32; 2]) -> Option<f32> {
    let spin = 6.0;
    let grows = |ratio: f32| {
        let (mut lab, body) = set_off(settings, dt, lay, ratio * RADIUS * spin, spin);
        lab.run(0.5);
        let (speed, spin) = motion(&lab, body);
        speed / (RADIUS * spin) > ratio
    };
    threshold(low, high, 0.005, grows)
}

/// When the sliding and the spinning of a body end, s: when they are less than a thousandth.
fn ends(settings: Settings, dt: f32, lay: Lay) -> (Option<f32>, Option<f32>) {
    let (speed, spin) = (2.0, 4.0);
    let (mut lab, body) = set_off(settings, dt, lay, speed, spin);
    let (mut slid, mut spun) = (None, None);
    for i in 1..=(6.0 / dt).round() as usize {
        lab.step();
        let now = motion(&lab, body);
        let time = i as f32 * dt;
        if now.0 < 1e-3 * speed && slid.is_none() {
            slid = Some(time);
        }
        if now.1 < 1e-3 * spin && spun.is_none() {
            spun = Some(time);
        }
    }
    (slid, spun)
}

/// Row 12 for a body whose steady ratio is this.
fn slide_and_spin(
    settings: Settings,
    (name, lay, expected): (&str, Lay, f32),
    share: f32,
    values: &mut Values,
) {
    let range = [0.3 * expected, 2.0 * expected];
    let found = steady_ratio(settings, values.dt(), lay, range);
    let what = format!("12: {name} slides and spins, steady v/(R ω)");
    values.add_near(what, (found, expected), share);
    let (slid, spun) = ends(settings, values.dt(), lay);
    let ratio = slid.zip(spun).map(|(slid, spun)| spun / slid);
    let what = format!("12: {name} slides and spins, spinning time over sliding time");
    values.add(what, (ratio, 1.0), share);
}

/// Row 12: a ring.
pub fn ring_slides_and_spins(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    slide_and_spin(settings, (RING, ring, 1.0), 0.02, &mut values);
    values
}

/// Row 12: a disk, and a cylinder, which has a manifold of four points and should behave like a ring.
pub fn disk_slides_and_spins(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    slide_and_spin(settings, (DISK, disk, 0.653), 0.02, &mut values);
    let cylinder: (_, Lay, _) = (CYLINDER, cylinder, 1.0);
    slide_and_spin(settings, cylinder, 0.05, &mut values);
    values
}

/// A pure spin that slows.
struct Slowing {
    /// Deceleration over 0.3 s, rad/s².
    found: f32,
    /// The mean distance of the pressure from the axis meanwhile, m.
    arm: f32,
}

fn slowing(settings: Settings, dt: f32, lay: Lay) -> Slowing {
    let (mut lab, body) = set_off(settings, dt, lay, 0.0, 8.0);
    lab.run(0.2);
    let before = motion(&lab, body).1;
    let (mut moment, mut pressure) = (0.0, 0.0);
    for _ in 0..(0.3 / dt).round() as usize {
        lab.step();
        let mut contacts = lab
            .world
            .query::<(&ContactPair, &Manifold, &ContactImpulses)>();
        for (pair, manifold, impulses) in contacts.iter(&lab.world) {
            let own = lab.position(pair.bodies[0]) - lab.position(body);
            for (point, impulse) in manifold.points.iter().zip(&impulses.points) {
                moment += impulse.normal * (own + point.arm).with_y(0.0).length();
                pressure += impulse.normal;
            }
        }
    }
    Slowing {
        found: (before - motion(&lab, body).1) / 0.3,
        arm: moment / pressure,
    }
}

/// Row 13 for a body that should slow at this rate, rad/s².
fn slow(
    settings: Settings,
    (name, lay, expected): (&str, Lay, f32),
    values: &mut Values,
) -> Slowing {
    let slowing = slowing(settings, values.dt(), lay);
    let what = format!("13: {name} spins and slows, rad/s²");
    values.add_near(what, (slowing.found, expected), 0.02);
    slowing
}

/// Row 13. A ring has μ g/R; a cylinder on the four points of its manifold, all on its rim, 2 μ g/R.
pub fn spin_slows(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let a = FRICTION * G;
    let bodies: [(&str, Lay, f32); 3] = [
        (RING, ring, a / RADIUS),
        (CYLINDER, cylinder, 2.0 * a / RADIUS),
        ("cube", cube, 3.0 * 2f32.sqrt() * a / 0.5),
    ];
    for body in bodies {
        slow(settings, body, &mut values);
    }
    values
}

/// Row 13: a disk. Statics does not say how its feet share its weight, so it is also compared with the pressure that the solver found: μ g
/// r/(½ R²).
pub fn disk_spin_slows(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let a = FRICTION * G;
    let disk: (_, Lay, _) = (DISK, disk, 4.0 * a / (3.0 * RADIUS));
    let Slowing { found, arm } = slow(settings, disk, &mut values);
    let expected = 2.0 * a * arm / (RADIUS * RADIUS);
    let what = format!("13: {DISK} spins and slows, by the pressure found, rad/s²");
    values.add_near(what, (found, expected), 0.02);
    values
}
