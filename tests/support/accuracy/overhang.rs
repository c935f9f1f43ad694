//! Blocks that hang over.

use super::{Settings, Values, threshold};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use drystone::body::RigidBody;
use drystone::collider::Collider;
use glam::Vec3;

/// The depth of a course, m.
type Depth = fn(u32) -> f32;

/// Whether `n` blocks of a length of 1 m stand with this share of the best overhang of each.
fn stands(settings: Settings, dt: f32, n: u32, share: f32, depth: Depth) -> bool {
    let mut lab = settings(dt);
    lab.spawn((
        RigidBody::Static,
        Collider::cuboid(4.0, 1.0, 1.0),
        Transform::from_xyz(-2.0, -0.5, 0.0),
    ));
    let mut right = 0.0;
    let mut blocks = Vec::new();
    for course in 0..n {
        right += share / (2 * (n - course)) as f32;
        let position = Vec3::new(right - 0.5, 0.125 + 0.25 * course as f32, 0.0);
        let block = Collider::cuboid(1.0, 0.25, depth(course));
        blocks.push((lab.body(block, position), position));
    }
    lab.run(4.0);
    let moved = |&(body, start): &(Entity, Vec3)| (lab.position(body) - start).length();
    blocks.iter().all(|block| moved(block) < 0.02)
}

/// Row 10: the overhang of n blocks may be off by 2 %. At 98 % the margin of every interface is 1 cm, and beyond it none.
///
/// Flush blocks have edges that lie exactly on each other: in this case parry loses corners to rounding.
pub fn overhangs(settings: Settings, dt: f32) -> Values {
    let mut values = Values::at(dt);
    let depths: [(&str, Depth); 2] = [
        ("", |course| 0.5 - 0.02 * course as f32),
        (" flush", |_| 0.5),
    ];
    for (name, depth) in depths {
        for n in 1..=4 {
            let best: f32 = (1..=n).map(|k| 0.5 / k as f32).sum();
            let share = threshold(0.95, 1.05, 0.005, |share| {
                stands(settings, dt, n, share, depth)
            });
            let what = format!("10: {n}{name} blocks hang over, m");
            values.add_near(what, (share.map(|share| share * best), best), 0.02);
        }
    }
    values
}
