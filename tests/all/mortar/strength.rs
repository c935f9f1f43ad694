//! Bonds break where statics says, at every length of a step.

use super::*;
use drystone::body::ExternalForce;
use support::{G, assert_near, bisect};

/// Area of a face of a cube, m².
const AREA: f32 = EDGE * EDGE;

/// Section modulus of a face of a cube, b h²/6, m³.
const MODULUS: f32 = EDGE * EDGE * EDGE / 6.0;

/// The parameter at which what `build` builds breaks within a second, near the one that is wanted; it holds above.
fn limit(dt: f32, wanted: f32, build: impl Fn(&mut Lab, f32)) -> f32 {
    bisect(1.3 * wanted, 0.7 * wanted, 2e-3 * wanted, |parameter| {
        let mut lab = Lab::shipped(dt);
        build(&mut lab, parameter);
        holds(&mut lab, 1.0)
    })
}

fn holds(lab: &mut Lab, seconds: f32) -> bool {
    for _ in 0..(seconds / lab.dt).round() as usize {
        lab.step();
        if !broken(lab).is_empty() {
            return false;
        }
    }
    true
}

/// M/W at the root: M = m g n · n l/2.
fn root_stress(cubes: usize) -> f32 {
    let n = cubes as f32;
    MASS * G * n * n * EDGE / 2.0 / MODULUS
}

#[test]
fn a_cantilever_breaks_at_its_root_by_its_moment() {
    for dt in STEPS {
        for cubes in [3, 10, 20] {
            let wanted = root_stress(cubes);
            let found = limit(dt, wanted, |lab, strength| {
                cantilever(lab, cubes, tensile(strength));
            });
            assert_near(found, wanted, 0.01, &format!("{cubes} cubes, dt {dt}"));
        }
    }
}

#[test]
fn a_hung_brick_breaks_by_its_weight() {
    for dt in STEPS {
        let wanted = MASS * G / AREA;
        let found = limit(dt, wanted, |lab, strength| {
            root(lab, Vec3::Y * EDGE);
            brick(lab, Vec3::ZERO, tensile(strength));
        });
        assert_near(found, wanted, 0.01, &format!("hung, dt {dt}"));
    }
}

#[test]
fn a_brick_on_a_wall_face_breaks_by_its_cohesion() {
    for dt in STEPS {
        let wanted = MASS * G / AREA;
        let found = limit(dt, wanted, |lab, strength| {
            root(lab, Vec3::ZERO);
            brick(lab, Vec3::X * EDGE, cohesive(strength));
        });
        assert_near(found, wanted, 0.01, &format!("sheared, dt {dt}"));
    }
}

/// Pressure adds to the shear strength: c + μσ.
#[test]
fn a_pressed_bed_bears_more_shear() {
    for dt in STEPS {
        let pressure = MASS * G / AREA;
        let mortar = |cohesion: f32| Mortar {
            friction: 0.5,
            ..cohesive(cohesion)
        };
        let wanted = 10e3 * AREA;
        let found = limit(dt, 1.0, |lab, share| {
            root(lab, Vec3::ZERO);
            let push = ExternalForce {
                force: Vec3::new(0.6, 0.0, 0.8) * wanted / share,
                ..Default::default()
            };
            brick(lab, Vec3::Y * EDGE, (mortar(10e3 - 0.5 * pressure), push));
        });
        assert_near(found, 1.0, 0.01, &format!("pressed and sheared, dt {dt}"));
    }
}

/// τ = T r/I_p, r half a diagonal and I_p = a⁴/6.
#[test]
fn a_twisted_bed_breaks_at_its_corners() {
    for dt in STEPS {
        let torque = 1_000.0;
        let radius = EDGE * 0.5f32.sqrt();
        let wanted = torque * radius / (EDGE.powi(4) / 6.0);
        let found = limit(dt, wanted, |lab, strength| {
            root(lab, Vec3::ZERO);
            let twist = ExternalForce {
                torque: Vec3::Y * torque,
                ..Default::default()
            };
            brick(lab, Vec3::Y * EDGE, (cohesive(strength), twist));
        });
        assert_near(found, wanted, 0.01, &format!("twisted, dt {dt}"));
    }
}

/// At the foot σ = F H/W − m g n/A.
#[test]
fn a_tower_that_is_pushed_at_its_top_breaks_at_its_foot() {
    for dt in STEPS {
        let (cubes, force) = (10, 1_500.0);
        let height = EDGE * (cubes as f32 - 0.5);
        let wanted = force * height / MODULUS - cubes as f32 * MASS * G / AREA;
        let found = limit(dt, wanted, |lab, strength| {
            root(lab, Vec3::ZERO);
            for i in 1..=cubes {
                let push = ExternalForce {
                    force: if i == cubes {
                        Vec3::X * force
                    } else {
                        Vec3::ZERO
                    },
                    ..Default::default()
                };
                let at = Vec3::Y * (EDGE * i as f32);
                brick(lab, at, (tensile(strength), push));
            }
        });
        assert_near(found, wanted, 0.01, &format!("pushed, dt {dt}"));
    }
}

/// A beam of cubes between two walls. Bonds of one stiffness share its moment so that their rotations add up to zero.
#[test]
fn a_beam_between_two_walls_has_its_moments_by_compatibility() {
    for cubes in [7, 15] {
        let mut lab = Lab::shipped(1.0 / 60.0);
        let all = cantilever(&mut lab, cubes, tensile(1e12));
        root(&mut lab, Vec3::new(EDGE * (cubes + 1) as f32, 10.0, 0.0));
        lab.run(3.0);
        let at = |i: usize| {
            let (x, weight) = (EDGE * i as f32, MASS * G);
            let span = EDGE * cubes as f32;
            0.5 * weight / EDGE * x * (span - x)
        };
        let mean = (0..=cubes).map(at).sum::<f32>() / (cubes + 1) as f32;
        let wanted = mean / MODULUS;
        let mut joints = lab.world.query::<(&MortarJoint, &JointForces)>();
        let of_root = joints.iter(&lab.world);
        let mut of_root = of_root.filter(|(joint, _)| joint.body1 == Some(all[0]));
        let (joint, forces) = of_root.next().unwrap();
        let found = 1e12 * joint.utilization(forces);
        assert_near(found, wanted, 0.02, &format!("a beam of {cubes}"));
    }
}
