//! Semicircular arches, as thin as they can be.

use super::{Settings, Values, threshold};
use crate::Lab;
use crate::masonry::drawings;
use crate::masonry::statics;
use bevy_ecs::prelude::*;
use drystone::collider::Friction;
use drystone::masonry::Arch;
use glam::{Quat, Vec3};

/// The mean radius, m.
const RADIUS: f32 = 3.0;

/// Friction at which joints only open, and the least at which an arch of many voussoirs stands.
pub const ARCH_FRICTIONS: [f32; 2] = [0.5, 0.3092];

/// The least thickness of an arch of infinitely many voussoirs at these frictions, as a share of the mean radius.
pub const ARCH_LIMITS: [f32; 2] = [0.1074, 0.2006];

/// The least thickness of an arch of `n` voussoirs as a share of its mean radius, by limit analysis: within 6 % below that of infinitely
/// many or, of few voussoirs, less. `None` if none there stands: at the least friction a thicker arch slides.
pub fn arch_by_statics(n: usize, friction: f32, limit: f32) -> Option<f32> {
    let of = |share: f64| drawings::arch(n, share, friction.into());
    let stands = |share: &f64| statics::stands(&of(*share));
    let limit = f64::from(limit);
    let mut shares = (0..=60).map(|i| limit * (1.0 - 1e-3 * f64::from(i)));
    let share = shares.find(stands)?;
    Some(statics::threshold(0.02, share, of) as f32)
}

/// Whether an arch of this thickness stands for ten seconds: no voussoir moves by a twentieth of the thickness.
fn stands(settings: Settings, dt: f32, n: usize, share: f32, friction: f32) -> bool {
    let mut lab = settings(dt);
    lab.slope(0.0, friction);
    let arch = Arch {
        radius: RADIUS,
        thickness: share * RADIUS,
        voussoirs: n as u32,
        ..Default::default()
    };
    let voussoirs: Vec<(Entity, Vec3, Quat)> = arch
        .blocks()
        .expect("its sizes are valid")
        .into_iter()
        .map(|block| {
            let at = block.pose;
            let body = lab.spawn((block.bundle(), Friction::new(friction)));
            (body, at.position, at.rotation)
        })
        .collect();
    let most = 0.05 * share * RADIUS;
    let stays = |lab: &Lab| {
        voussoirs.iter().all(|&(body, position, rotation)| {
            let pose = lab.pose(body);
            let turn = pose.rotation.angle_between(rotation);
            pose.position.distance(position) < most && turn < most
        })
    };
    for _ in 0..20 {
        lab.run(0.5);
        if !stays(&lab) {
            return false;
        }
    }
    true
}

/// The least thickness of an arch as a share of its mean radius in the simulation, to 0.5 %, between 0.9 and 1.05 times the limit by
/// statics. At the least friction a much thicker arch slides.
pub fn arch_simulated(
    settings: Settings,
    dt: f32,
    n: usize,
    friction: f32,
    limit: f32,
) -> Option<f32> {
    threshold(1.05 * limit, 0.9 * limit, 0.005 * limit, |share| {
        stands(settings, dt, n, share, friction)
    })
}

/// Row 11, at numbers of voussoirs; against limit analysis of as many, which converges to the formula.
pub fn arches(settings: Settings, dt: f32, numbers: &[usize]) -> Values {
    let mut values = Values::at(dt);
    for (friction, limit) in ARCH_FRICTIONS.into_iter().zip(ARCH_LIMITS) {
        for &n in numbers {
            let limit = arch_by_statics(n, friction, limit).expect("some thickness stands");
            let found = arch_simulated(settings, dt, n, friction, limit);
            let what = format!("11: arch of {n}, μ {friction}, least thickness over radius");
            values.add_near(what, (found, limit), 0.03);
        }
    }
    values
}

/// Row 11 with 11 and 25 voussoirs.
pub fn arch_stands(settings: Settings, dt: f32) -> Values {
    arches(settings, dt, &[11, 25])
}
