use crate::patches::PatchSolver;
use crate::{Body, BondEnd, JointAxis, JointConstraint, Memory, PatchProblem, Section, SoftStep};
use glam::{Mat3, Quat, Vec2, Vec3};

const DT: f32 = 1.0 / 60.0;

/// A square section of this side, m, that does not break.
fn section(side: f32) -> Section {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let square = side * side;
    Section {
        area: square,
        inertia: Vec2::splat(square * square / 12.0),
        corners: corners.map(|[y, z]| 0.5 * side * Vec2::new(y, z)),
        tension: f32::INFINITY,
        cohesion: f32::INFINITY,
        friction: 0.0,
    }
}

/// Cubes of 1 kg and 1 m in a row along x about the origin, and the bonds between them.
fn row(count: u32) -> (Vec<Body>, Vec<JointConstraint>) {
    let cube = Body {
        inverse_mass: 1.0,
        inverse_inertia: Mat3::from_diagonal(Vec3::splat(6.0)),
        ..Body::default()
    };
    let at = |i: u32| Vec3::X * (i as f32 - 0.5 * (count as f32 - 1.0));
    let bond = |i: u32| {
        let end = |body: u32, arm: Vec3| BondEnd {
            arm,
            frame: Quat::IDENTITY,
            center: at(body),
            rotation: Quat::IDENTITY,
        };
        let arms = [0.5 * Vec3::X, -0.5 * Vec3::X];
        JointConstraint {
            bodies: [i, i + 1],
            arms,
            axes: [JointAxis::LOCKED; 6],
            section: Some(section(1.0)),
            bond: Some([end(i, arms[0]), end(i + 1, arms[1])]),
            order: i.into(),
            ..JointConstraint::default()
        }
    };
    (
        vec![cube; count as usize],
        (0..count - 1).map(bond).collect(),
    )
}

fn solve(bodies: &mut [Body], joints: &mut [JointConstraint]) {
    let mut memory = Memory::default();
    SoftStep::default().solve(&mut PatchProblem {
        bodies,
        patches: &mut [],
        points: &mut [],
        grabs: &mut [],
        joints,
        surfaces: &[],
        dt: DT,
        max_recent_dt: DT,
        gravity: Vec3::ZERO,
        effort: 1.0,
        broke: false,
        max_correction_speed: 1.0,
        settling: None,
        stays_awake: true,
        record_history: false,
        threads: 1,
        memory: &mut memory,
    });
}

/// Each bond of a row that is pushed at one end pushes the bodies behind it.
#[test]
fn bonds_pass_on_what_accelerates_the_bodies_behind_them() {
    let (mut bodies, mut joints) = row(4);
    bodies[0].linear = 8.0 * DT * Vec3::X;
    solve(&mut bodies, &mut joints);
    for (i, joint) in joints.iter().enumerate() {
        let wanted = 2.0 * (3 - i) as f32;
        assert!(
            (joint.mean[0] - wanted * Vec3::X).length() < 1e-3,
            "{i}: {:?}",
            joint.mean
        );
        assert!(joint.mean[1].length() < 1e-3);
    }
    for body in &bodies {
        assert!((body.linear - 2.0 * DT * Vec3::X).length() < 1e-6);
    }
}

/// A row that spins pulls its bonds by the centripetal force of the bodies beyond them.
#[test]
fn bonds_hold_bodies_that_spin() {
    let (mut bodies, mut joints) = row(4);
    let spin = 3.0 * Vec3::Z;
    for (i, body) in bodies.iter_mut().enumerate() {
        body.linear = spin.cross(Vec3::X * (i as f32 - 1.5));
        body.angular = spin;
        body.start = [body.linear, spin];
    }
    solve(&mut bodies, &mut joints);
    // m ω² r of the bodies at 1.5 and 0.5 m.
    for (joint, pull) in joints.iter().zip([13.5, 18.0, 13.5]) {
        let force = joint.frames[0].inverse() * joint.mean[0];
        assert!((force + pull * Vec3::X).length() < 1e-2, "{force}");
        assert!(joint.mean[1].length() < 1e-2);
    }
    // The ends have moved on their circle.
    let turned = Quat::from_rotation_z(3.0 * DT) * (1.5 * Vec3::X) - 1.5 * Vec3::X;
    let way = bodies[3].motion.unwrap_or_default()[0] * DT;
    assert!((way - turned).length() < 1e-6, "{way} {turned}");
}

/// Bonds side by side share a load by their areas.
#[test]
fn bonds_between_two_bodies_share_their_load_by_areas() {
    let (mut bodies, mut joints) = row(2);
    let small = JointConstraint {
        section: Some(section(0.5)),
        order: 1,
        ..joints[0]
    };
    joints.push(small);
    bodies[0].linear = 8.0 * DT * Vec3::X;
    solve(&mut bodies, &mut joints);
    for (joint, wanted) in joints.iter().zip([3.2, 0.8]) {
        assert!((joint.mean[0].x - wanted).abs() < 1e-3, "{:?}", joint.mean);
    }
}
