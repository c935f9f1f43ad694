//! What every solve must leave behind, on random contact graphs: impulses inside their cones, momentum where it was, and
//! velocities that are the initial ones plus M⁻¹Jᵀλ.

use drystone::solver::merit::free_merit;
use drystone::solver::{
    Body, Contact, ContactInput, ContactSolver, FrictionCone, Nncg, Pgs, Problem, SolveReport,
};
use glam::{Mat3, Quat, Vec3};
use proptest::prelude::*;

/// A contact graph, with what is needed to check it.
#[derive(Clone, Debug)]
struct Graph {
    positions: Vec<Vec3>,
    bodies: Vec<Body>,
    contacts: Vec<ContactInput>,
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

fn direction() -> impl Strategy<Value = Vec3> {
    vector(1.0)
        .prop_filter("has a direction", |v| v.length() > 0.1)
        .prop_map(Vec3::normalize)
}

/// A body between 0.1 and 1000 kg, with moments of inertia as of a box about a random frame; or one that nothing moves.
fn body(fixed: bool) -> impl Strategy<Value = (Vec3, Body)> {
    let kind = if fixed { 0.3 } else { 0.0 };
    (
        vector(2.0),
        prop::bool::weighted(kind),
        -1.0f32..3.0,
        prop::array::uniform3(0.2f32..1.0),
        vector(3.0),
        vector(3.0),
        vector(2.0),
    )
        .prop_map(|(position, fixed, mass, size, turn, linear, angular)| {
            if fixed {
                return (position, Body::default());
            }
            let (mass, [x, y, z]) = (10f32.powf(mass), size.map(|s| s * s));
            let inertia = Vec3::new(y + z, z + x, x + y) * (mass / 12.0);
            let axes = Mat3::from_quat(Quat::from_scaled_axis(turn));
            let inverse = axes * Mat3::from_diagonal(inertia.recip()) * axes.transpose();
            let body = Body {
                linear,
                inverse_mass: 1.0 / mass,
                angular,
                inverse_inertia: inverse,
                ..Default::default()
            };
            (position, body)
        })
}

/// Between any two bodies up to three points with one normal; demands and first impulses at random.
fn graph(fixed: bool) -> impl Strategy<Value = Graph> {
    let points = prop::collection::vec((vector(1.0), vector(0.3), -1.0f32..1.0, 0.0f32..5.0), 1..4);
    let pair = (any::<u16>(), any::<u16>(), direction(), 0.0f32..1.2, points);
    (
        prop::collection::vec(body(fixed), 2..8),
        prop::collection::vec(pair, 1..10),
    )
        .prop_map(|(bodies, pairs)| {
            let (positions, mut bodies): (Vec<_>, Vec<_>) = bodies.into_iter().unzip();
            let n = bodies.len();
            let mut contacts = Vec::new();
            for (a, b, normal, friction, points) in pairs {
                let a = a as usize % n;
                let b = (a + 1 + b as usize % (n - 1)) % n;
                if bodies[a].inverse_mass + bodies[b].inverse_mass == 0.0 {
                    continue;
                }
                let middle = 0.5 * (positions[a] + positions[b]);
                for (offset, slip, target, impulse) in points {
                    let point = middle + 0.5 * offset;
                    contacts.push(ContactInput {
                        bodies: [a as u32, b as u32],
                        normal,
                        arms: [point - positions[a], point - positions[b]],
                        friction,
                        target_normal: target,
                        target_tangential: slip - normal * normal.dot(slip),
                        impulse_normal: impulse,
                        impulse_tangential: Vec3::ZERO,
                    });
                }
            }
            // Velocities hold the effect of the impulses that a solve starts from.
            for contact in &contacts {
                let first = Contact::prepare(contact, &bodies);
                first.push(&mut bodies, first.world(first.impulse));
            }
            Graph {
                positions,
                bodies,
                contacts,
            }
        })
}

struct Solved {
    bodies: Vec<Body>,
    contacts: Vec<Contact>,
    report: SolveReport,
}

fn solve(
    graph: &Graph,
    solver: &dyn ContactSolver,
    cone: FrictionCone,
    iterations: usize,
) -> Solved {
    solve_until(graph, solver, cone, iterations, 0.0, true)
}

fn solve_until(
    graph: &Graph,
    solver: &dyn ContactSolver,
    cone: FrictionCone,
    iterations: usize,
    tolerance: f32,
    record_history: bool,
) -> Solved {
    let mut bodies = graph.bodies.clone();
    let prepare = |input| Contact::prepare(input, &bodies);
    let mut contacts: Vec<_> = graph.contacts.iter().map(prepare).collect();
    let free_merit = free_merit(&bodies, &contacts);
    let report = solver.solve(&mut Problem {
        bodies: &mut bodies,
        contacts: &mut contacts,
        patches: &mut [],
        points: &mut [],
        dt: 1.0 / 60.0,
        gravity: Vec3::ZERO,
        max_correction_speed: 0.0,
        cone,
        iterations,
        tolerance,
        free_merit,
        record_history,
    });
    Solved {
        bodies,
        contacts,
        report,
    }
}

fn all() -> [(Box<dyn ContactSolver>, FrictionCone); 4] {
    [
        (Box::new(Pgs), FrictionCone::Circular),
        (Box::new(Pgs), FrictionCone::Box),
        (Box::new(Nncg), FrictionCone::Circular),
        (Box::new(Nncg), FrictionCone::Box),
    ]
}

/// Linear momentum, angular momentum about the origin, and the size of both.
fn momentum(graph: &Graph, bodies: &[Body]) -> (Vec3, Vec3, f32) {
    let (mut linear, mut angular, mut size) = (Vec3::ZERO, Vec3::ZERO, 0.0);
    for (position, body) in graph.positions.iter().zip(bodies) {
        let push = body.linear / body.inverse_mass;
        let spin = body.inverse_inertia.inverse() * body.angular;
        linear += push;
        angular += position.cross(push) + spin;
        size += push.length() + spin.length();
    }
    (linear, angular, size)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn impulses_push_and_stay_inside_the_cone(graph in graph(true), iterations in 1usize..40) {
        for (solver, cone) in all() {
            let solved = solve(&graph, &*solver, cone, iterations);
            for contact in &solved.contacts {
                let [normal, t1, t2] = contact.impulse.to_array();
                prop_assert!(contact.impulse.is_finite() && normal >= 0.0, "{} {}", solver.name(), contact.impulse);
                let limit = contact.friction * normal * (1.0 + 1e-5);
                let inside = match cone {
                    FrictionCone::Circular => t1.hypot(t2) <= limit,
                    FrictionCone::Box => t1.abs() <= limit && t2.abs() <= limit,
                };
                prop_assert!(inside, "{} {cone:?} {} {}", solver.name(), contact.friction, contact.impulse);
            }
            for (before, body) in graph.bodies.iter().zip(&solved.bodies) {
                prop_assert!(body.linear.is_finite() && body.angular.is_finite());
                prop_assert!(body.inverse_mass > 0.0 || body == before, "what is fixed stays");
            }
        }
    }

    /// To rounding: of each impulse added, f32 keeps seven digits.
    #[test]
    fn momentum_of_a_closed_group_stays(graph in graph(false)) {
        for (solver, cone) in all() {
            let solved = solve(&graph, &*solver, cone, 30);
            let (linear, angular, size) = momentum(&graph, &graph.bodies);
            let (linear_after, angular_after, size_after) = momentum(&graph, &solved.bodies);
            let slack = 1e-4 * (size + size_after);
            prop_assert!((linear_after - linear).length() <= slack, "{} {linear} {linear_after}", solver.name());
            prop_assert!((angular_after - angular).length() <= slack, "{} {angular} {angular_after}", solver.name());
        }
    }

    #[test]
    fn velocities_are_the_first_ones_and_what_the_impulses_make(graph in graph(true)) {
        for (solver, cone) in all() {
            let solved = solve(&graph, &*solver, cone, 30);
            let mut expected = graph.bodies.clone();
            for (input, contact) in graph.contacts.iter().zip(&solved.contacts) {
                let first = Contact::prepare(input, &graph.bodies);
                contact.push(&mut expected, contact.world(contact.impulse - first.impulse));
            }
            // Rounding is relative to the largest changes that met in a body.
            let size = solved.contacts.iter().zip(&graph.contacts).map(|(c, input)| {
                let [a, b] = c.bodies.map(|i| &graph.bodies[i as usize]);
                let turn = |b: &Body| b.inverse_inertia.col(0).length().max(b.inverse_inertia.col(1).length()).max(b.inverse_inertia.col(2).length());
                (c.impulse.length() + input.impulse_normal) * (a.inverse_mass + b.inverse_mass + turn(a) + turn(b))
            }).fold(10.0, f32::max);
            for (found, expected) in solved.bodies.iter().zip(&expected) {
                prop_assert!((found.linear - expected.linear).length() < 1e-4 * size, "{}", solver.name());
                prop_assert!((found.angular - expected.angular).length() < 1e-4 * size, "{}", solver.name());
            }
        }
    }
}

/// A tower of 1 m cubes on the ground, each resting on the four corners of the one below, one step of gravity in.
fn tower(n: usize) -> Graph {
    let (dt, mass) = (1.0 / 60.0, 1000.0);
    let cube = Body {
        linear: Vec3::NEG_Y * 9.81 * dt,
        inverse_mass: 1.0 / mass,
        angular: Vec3::ZERO,
        inverse_inertia: Mat3::from_diagonal(Vec3::splat(6.0 / mass)),
        ..Default::default()
    };
    let mut graph = Graph {
        positions: vec![Vec3::ZERO],
        bodies: vec![Body::default()],
        contacts: Vec::new(),
    };
    for i in 1..=n {
        graph.positions.push(Vec3::Y * (i as f32 - 0.5));
        graph.bodies.push(cube);
        for (x, z) in [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)] {
            let point = Vec3::new(x, i as f32 - 1.0, z);
            graph.contacts.push(ContactInput {
                bodies: [i as u32, i as u32 - 1],
                normal: Vec3::Y,
                arms: [point - graph.positions[i], point - graph.positions[i - 1]],
                friction: 0.5,
                ..Default::default()
            });
        }
    }
    graph
}

#[test]
fn the_residual_falls_until_the_tower_rests() {
    let graph = tower(3);
    for (solver, cone) in all() {
        let solved = solve(&graph, &*solver, cone, 2000);
        let (first, last) = (solved.report.history[0], solved.report.residual);
        println!("{} {cone:?}: {first} to {last}", solver.name());
        assert_eq!(solved.report.history.len(), solved.report.sweeps);
        // Rounding ends it at about 1e-7 of each impulse.
        assert!(last < 1e-4 && last < 1e-3 * first);
        for body in &solved.bodies {
            assert!(body.linear.length() < 1e-4 && body.angular.length() < 1e-4);
        }
        // Reference value 18: the lowest interface carries all.
        let carried: f32 = solved.contacts[..4].iter().map(|c| c.impulse.x).sum();
        let weight = 3.0 * 1000.0 * 9.81 / 60.0;
        assert!((carried / weight - 1.0).abs() < 1e-3, "{carried} {weight}");
    }
}

#[test]
fn conjugate_gradients_get_further_than_gauss_seidel_on_a_tall_tower() {
    let graph = tower(20);
    for sweeps in [50, 100, 200] {
        let [pgs, nncg] = [&Pgs as &dyn ContactSolver, &Nncg]
            .map(|solver| solve(&graph, solver, FrictionCone::Circular, sweeps).report);
        println!(
            "{sweeps} sweeps: pgs {}, nncg {}",
            pgs.residual, nncg.residual
        );
        assert_eq!(pgs.sweeps, nncg.sweeps);
        assert!(nncg.residual < 0.5 * pgs.residual, "{sweeps}");
    }
}

#[test]
fn a_solve_ends_early_when_it_is_good_enough() {
    let graph = tower(3);
    for solver in [&Pgs as &dyn ContactSolver, &Nncg] {
        let cone = FrictionCone::Circular;
        let report = solve_until(&graph, solver, cone, 1000, 1e-2, false).report;
        assert!(
            report.sweeps < 1000 && report.residual <= 1e-2,
            "{report:?}"
        );
        assert!(report.history.is_empty());
    }
}
