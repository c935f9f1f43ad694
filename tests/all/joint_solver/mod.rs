//! What joints hold, at rest and in motion, at 60, 30 and 10 Hz.

mod world;

use drystone::solver::{JointAxis, JointMotor};
use glam::{Quat, Vec3};
use world::{G, Thing, World};

const FREE: JointAxis = JointAxis::FREE;
const LOCKED: JointAxis = JointAxis::LOCKED;
const BALL: [JointAxis; 6] = [LOCKED, LOCKED, LOCKED, FREE, FREE, FREE];
const FIXED: [JointAxis; 6] = [LOCKED; 6];
/// A hinge about z.
const HINGE: [JointAxis; 6] = [LOCKED, LOCKED, LOCKED, LOCKED, LOCKED, FREE];

/// Steps of 60, 30 and 10 Hz, s.
const STEPS: [f32; 3] = [1.0 / 60.0, 1.0 / 30.0, 0.1];

/// Velocities are those with which bodies came to their positions, so the energy of a pendulum seems to rise and fall by half of what
/// its weight does in a substep.
const MEASURED: f32 = 3e-3;

/// A chain of links of 1 kg and 0.5 m that hangs from the origin along a direction, with a load at its end.
fn chain(links: usize, load: f32, along: Vec3) -> World {
    let mut world = World::new();
    let turn = Quat::from_rotation_arc(Vec3::NEG_Y, along);
    let mut last = 0;
    for i in 0..links {
        let mut link = Thing::cuboid(
            1.0,
            Vec3::new(0.05, 0.5, 0.05),
            (i as f32 * 0.5 + 0.25) * along,
        );
        link.rotation = turn;
        let link = world.add(link);
        world.join([last, link], i as f32 * 0.5 * along, BALL);
        last = link;
    }
    if load > 0.0 {
        let size = (load / 1000.0f32).cbrt();
        let end = links as f32 * 0.5 * along;
        let mut load = Thing::cuboid(load, Vec3::splat(size), end + 0.5 * size * along);
        load.rotation = turn;
        let load = world.add(load);
        world.join([last, load], end, BALL);
    }
    world
}

/// A hinge about z with something on its axis.
fn hinge(axis: JointAxis) -> [JointAxis; 6] {
    let mut axes = HINGE;
    axes[5] = axis;
    axes
}

fn motor(motor: JointMotor) -> JointAxis {
    JointAxis {
        motor: Some(motor),
        ..FREE
    }
}

/// A motor that holds a position, with limited force.
fn servo(target_position: f32, max_force: f32) -> JointAxis {
    motor(JointMotor {
        target_position,
        target_velocity: 0.0,
        stiffness: f32::INFINITY,
        damping: 0.0,
        max_force,
    })
}

#[track_caller]
fn below(value: f32, limit: f32, what: &str) {
    assert!(value < limit, "{what}: {value}, not below {limit}");
}

/// The rise of energy over its smallest value so far, and its value now, as shares of `scale`; `reach` is the largest gap of a joint, m.
#[derive(Debug)]
struct Swings {
    gain: f32,
    lost: f32,
    reach: f32,
}

fn swing(world: &mut World, seconds: f32, dt: f32, scale: f32) -> Swings {
    let begin = world.energy();
    let (mut most, mut reach) = (0f64, 0f32);
    world.run_with(seconds, dt, |world| {
        most = most.max(world.energy() - begin);
        reach = reach.max(world.widest());
    });
    Swings {
        gain: most as f32 / scale,
        lost: (begin - world.energy()) as f32 / scale,
        reach,
    }
}

/// The energy that a world could lose if all of it fell to where it hangs straight down.
fn depth(world: &World) -> f32 {
    let things = world.things.iter();
    2.0 * G
        * things
            .map(|thing| thing.mass * thing.position.length())
            .sum::<f32>()
}

#[test]
fn a_pendulum_keeps_its_energy() {
    for dt in STEPS {
        let mut world = chain(1, 0.0, Vec3::X);
        // A period of 1.33 s: 30 swings.
        let swings = swing(&mut world, 20.0, dt, G * 0.25);
        assert!(swings.lost.abs() < 30.0 * 0.0005, "{dt}: {swings:?}");
        below(swings.gain, MEASURED, "gain");
        below(swings.reach, 1e-4, "gap");
    }
}

/// A door of 200 kg on a level hinge, let go from horizontal.
#[test]
fn a_door_keeps_its_energy() {
    for dt in STEPS {
        let mut world = World::new();
        let door = Thing::cuboid(200.0, Vec3::new(1.0, 0.05, 2.0), 0.5 * Vec3::X);
        let door = world.add(door);
        world.join([0, door], Vec3::ZERO, HINGE);
        let swings = swing(&mut world, 20.0, dt, 200.0 * G * 0.5);
        // 22 swings.
        assert!(swings.lost.abs() < 22.0 * 0.0005, "{dt}: {swings:?}");
        below(swings.gain, MEASURED, "gain");
        below(swings.reach, 1e-4, "gap");
    }
}

/// Straight chains at rest hide instabilities, so they are kicked.
#[test]
fn chains_hang_still_and_bear_a_kick() {
    for dt in STEPS {
        for (links, load) in [(10, 100.0), (10, 1000.0), (40, 100.0), (40, 1000.0)] {
            let mut world = chain(links, load, Vec3::NEG_Y);
            world.run(2.0, dt);
            below(world.widest(), 1e-5, "at rest");
            below(world.fastest()[0], 1e-5, "trembling");
            for thing in world.things.iter_mut().skip(1) {
                thing.linear.x += 0.3;
            }
            let energy = 0.5 * 0.09 * (load + links as f32);
            let swings = swing(&mut world, 6.0, dt, energy);
            below(swings.gain, 1e-3, "gain");
            below(swings.reach, 1e-4, "gap");
        }
    }
}

#[test]
fn chains_whip_without_gaining_energy() {
    for dt in STEPS {
        for links in [10, 40] {
            for load in [0.0, 1.0, 100.0, 1000.0] {
                let mut world = chain(links, load, Vec3::X);
                let scale = depth(&world);
                let swings = swing(&mut world, 8.0, dt, scale);
                below(swings.gain, 1e-3, "gain");
                let reach = if load < 100.0 { 10e-3 } else { 3e-3 };
                below(swings.reach, reach, &format!("{links} {load} {dt} gap"));
            }
        }
    }
}

/// Forty planks of 20 kg between two banks, on two joints each, with 10 t on four of them, in the shape that statics gives.
#[test]
fn a_bridge_bears_ten_tons() {
    let masses: Vec<f32> = (0..40)
        .map(|i| if (18..22).contains(&i) { 2500.0 } else { 20.0 })
        .collect();
    let total: f64 = masses.iter().map(|&mass| mass as f64).sum();
    let slopes = |pull: f64| {
        let mut shear = 0.5 * total;
        masses
            .iter()
            .map(|&mass| {
                let slope = (shear - 0.5 * mass as f64) / pull;
                shear -= mass as f64;
                slope
            })
            .collect::<Vec<f64>>()
    };
    let span = |pull: f64| {
        slopes(pull)
            .iter()
            .map(|slope| 0.5 / (1.0 + slope * slope).sqrt())
            .sum::<f64>()
    };
    let (mut least, mut most) = (1.0, 1e7);
    for _ in 0..100 {
        let pull = 0.5 * (least + most);
        if span(pull) < 19.5 {
            least = pull
        } else {
            most = pull
        }
    }
    for dt in STEPS {
        let mut world = World::new();
        let (mut at, mut last) = (Vec3::ZERO, 0);
        for (slope, &mass) in slopes(least).iter().zip(&masses) {
            let turn = Quat::from_rotation_z(-(*slope as f32).atan());
            let next = at + turn * (0.5 * Vec3::X);
            let mut plank = Thing::cuboid(mass, Vec3::new(0.5, 0.05, 1.0), 0.5 * (at + next));
            plank.rotation = turn;
            let plank = world.add(plank);
            for side in [-0.5, 0.5] {
                world.join([last, plank], at + side * Vec3::Z, BALL);
            }
            (at, last) = (next, plank);
        }
        for side in [-0.5, 0.5] {
            world.join([last, 0], at + side * Vec3::Z, BALL);
        }
        let places: Vec<Vec3> = world.things.iter().map(|thing| thing.position).collect();
        world.run(5.0, dt);
        let moved = world.things.iter().zip(&places);
        let moved = moved
            .map(|(thing, place)| thing.position.distance(*place))
            .fold(0.0, f32::max);
        below(moved, 1e-3, "off statics");
        below(world.widest(), 1e-4, "gap");
        let pull = (least * G as f64) as f32;
        let found: f32 = world.links[..2]
            .iter()
            .map(|link| link.constraint.mean[0].x)
            .sum();
        assert!((found.abs() - pull).abs() < 0.01 * pull, "{found} {pull}");
    }
}

fn table(height: f32) -> (World, u32) {
    let mut world = World::new();
    let top = Thing::cuboid(1000.0, Vec3::new(2.0, 0.2, 2.0), Vec3::Y * (height + 0.9));
    let top = world.add(top);
    for (x, z) in [(-0.9, -0.9), (-0.9, 0.9), (0.9, -0.9), (0.9, 0.9)] {
        let leg = Thing::cuboid(1.0, Vec3::new(0.1, 0.8, 0.1), Vec3::new(x, height + 0.4, z));
        let leg = world.add(leg);
        world.join([top, leg], Vec3::new(x, height + 0.8, z), FIXED);
        world.stand([leg, 0], -0.4 * Vec3::Y, Vec3::new(0.05, 0.0, 0.05));
    }
    (world, top)
}

#[test]
fn a_table_on_light_legs_stands_and_lands() {
    for dt in STEPS {
        let (mut world, top) = table(0.0);
        // Loads at rest are followed slowly.
        world.run(15.0, dt);
        below(world.fastest()[0], 1e-5, &format!("{dt} trembling"));
        below(
            (world.things[top as usize].position.y - 0.9).abs(),
            1e-3,
            "sinks",
        );
        let (mut world, top) = table(0.1);
        let (mut lowest, mut hop) = (f32::INFINITY, 0f32);
        world.run_with(6.0, dt, |world| {
            let y = world.things[top as usize].position.y;
            lowest = lowest.min(y);
            hop = hop.max(y - lowest);
        });
        below(hop, 10e-3, &format!("{dt} hop"));
        below(0.89, lowest, "depth");
        world.run(15.0, dt);
        below(world.fastest()[0], 1e-5, &format!("{dt} after landing"));
    }
}

/// A block of a ton that no joint holds stands on the table.
#[test]
fn a_table_bears_a_block() {
    for dt in STEPS {
        let (mut world, top) = table(0.0);
        let block = Thing::cuboid(1000.0, Vec3::splat(1.0), Vec3::new(0.2, 1.5, 0.1));
        let block = world.add(block);
        world.stand([block, top], -0.5 * Vec3::Y, Vec3::new(0.5, 0.0, 0.5));
        world.run(15.0, dt);
        below(world.fastest()[0], 1e-5, &format!("{dt} trembling"));
        let place = world.things[block as usize].position;
        below((place - Vec3::new(0.2, 1.5, 0.1)).length(), 2e-3, "moves");
    }
}

/// Three motors hold 100 kg at the end of an arm of 3 m, and lift it.
#[test]
fn an_arm_holds_a_load() {
    for dt in STEPS {
        let mut world = World::new();
        let mut last = 0;
        for i in 0..3 {
            let link = Thing::cuboid(5.0, Vec3::new(1.0, 0.1, 0.1), Vec3::X * (i as f32 + 0.5));
            let link = world.add(link);
            world.join([last, link], Vec3::X * i as f32, hinge(servo(0.0, 1e4)));
            last = link;
        }
        let load = world.add(Thing::cuboid(100.0, Vec3::splat(0.3), 3.0 * Vec3::X));
        world.join([last, load], 3.0 * Vec3::X, FIXED);
        world.run(2.0, dt);
        let droop = (-world.things[load as usize].position.y / 3.0).to_degrees();
        below(droop.abs(), 0.1, "droop");
        below(world.fastest()[0], 1e-4, "trembling");
        let begin = world.time;
        while world.time < begin + 4.0 {
            let target = (0.1 * (world.time - begin)).min(0.3);
            for joint in 0..3 {
                world.links[joint].constraint.axes[5] = servo(target, 1e4);
            }
            world.step(dt);
        }
        let end = world.things[load as usize].rotation.to_scaled_axis().z;
        below((end - 0.9).abs().to_degrees(), 0.1, "lifted");
        below(world.widest(), 1e-4, "gap");
        // Motors that are too weak give way, and joints hold nevertheless.
        for joint in 0..3 {
            world.links[joint].constraint.axes[5] = servo(0.3, 1000.0);
        }
        let (mut lowest, mut reach) = (f32::INFINITY, 0f32);
        world.run_with(4.0, dt, |world| {
            lowest = lowest.min(world.things[load as usize].position.y);
            reach = reach.max(world.widest());
        });
        below(lowest, -1.0, "falls");
        below(reach, 1e-3, "gap");
    }
}

/// A wheel of 2 kg·m² on a hinge, without gravity.
fn wheel(axis: JointAxis) -> World {
    let mut world = World::new();
    world.gravity = Vec3::ZERO;
    let mut wheel = Thing::cuboid(10.0, Vec3::ONE, Vec3::ZERO);
    wheel.inertia = Vec3::new(1.0, 1.0, 2.0);
    let wheel = world.add(wheel);
    world.join([0, wheel], Vec3::ZERO, hinge(axis));
    world
}

#[test]
fn motors_reach_their_velocity_with_limited_torque() {
    for dt in STEPS {
        let mut world = wheel(motor(JointMotor {
            target_position: 0.0,
            target_velocity: 8.0,
            stiffness: 0.0,
            damping: f32::INFINITY,
            max_force: 10.0,
        }));
        world.run(1.0, dt);
        let spin = world.things[1].angular.z;
        assert!((spin - 5.0).abs() < 0.02, "{dt}: {spin}");
        assert!((world.links[0].constraint.forces[5] - 10.0).abs() < 0.01);
        world.run(1.0, dt);
        let spin = world.things[1].angular.z;
        assert!((spin - 8.0).abs() < 1e-3, "{dt}: {spin}");
    }
}

/// A spring on a hinge swings with its period at any stiffness that substeps can follow, and is stable at any.
#[test]
fn springs_swing_and_are_stable() {
    let spring = |stiffness: f32| {
        motor(JointMotor {
            target_position: 0.0,
            target_velocity: 0.0,
            stiffness,
            damping: 0.0,
            max_force: f32::INFINITY,
        })
    };
    for dt in STEPS {
        // ω = √(k / I) = 2 rad/s.
        let mut world = wheel(spring(8.0));
        world.things[1].angular.z = 1.0;
        world.run(3.0, dt);
        let angle = world.things[1].rotation.to_scaled_axis().z;
        let wanted = 0.5 * (2.0 * world.time).sin();
        assert!((angle - wanted).abs() < 0.02, "{dt}: {angle} {wanted}");
        let mut world = wheel(spring(1e9));
        world.things[1].angular.z = 1.0;
        world.run(2.0, dt);
        below(world.fastest()[1], 1e-3, "a stiff spring");
    }
}

#[test]
fn friction_holds_up_to_its_torque() {
    for dt in STEPS {
        let mut world = World::new();
        let bar = world.add(Thing::cuboid(1.0, Vec3::new(1.0, 0.1, 0.1), 0.5 * Vec3::X));
        let rub = |friction: f32| hinge(JointAxis { friction, ..FREE });
        world.join([0, bar], Vec3::ZERO, rub(5.0));
        world.run(2.0, dt);
        below(-world.things[1].position.y, 1e-4, "slips");
        // The weight has a moment of 4.9 N·m.
        let mut world = wheel(JointAxis {
            friction: 2.0,
            ..FREE
        });
        world.things[1].angular.z = 5.0;
        world.run(1.0, dt);
        let spin = world.things[1].angular.z;
        assert!((spin - 4.0).abs() < 0.02, "{dt}: {spin}");
        world.run(5.0, dt);
        below(world.fastest()[1], 1e-4, "stops");
    }
}

#[test]
fn limits_stop_a_bar_and_let_it_go() {
    for dt in STEPS {
        let mut world = World::new();
        let bar = world.add(Thing::cuboid(1.0, Vec3::new(1.0, 0.1, 0.1), 0.5 * Vec3::X));
        let limited = JointAxis {
            limits: [-0.5, 2.0],
            ..FREE
        };
        world.join([0, bar], Vec3::ZERO, hinge(limited));
        world.run(3.0, dt);
        let angle = world.things[1].rotation.to_scaled_axis().z;
        below((angle + 0.5).abs(), 1e-3, &format!("{dt} angle {angle}"));
        below(world.fastest()[1], 1e-3, "at rest");
        let bar = &mut world.things[1];
        bar.angular.z = 5.0;
        bar.linear = bar.angular.cross(bar.position);
        let mut most = f32::NEG_INFINITY;
        world.run_with(3.0, dt, |world| {
            most = most.max(world.things[1].rotation.to_scaled_axis().z);
        });
        // 4.17 J lift it from −0.5 to 0.38 rad.
        assert!((most - 0.38).abs() < 0.02, "{dt}: {most}");
        let angle = world.things[1].rotation.to_scaled_axis().z;
        below((angle + 0.5).abs(), 1e-3, &format!("{dt} angle {angle}"));
    }
}

/// A weight on a rope of 1 m falls freely until the rope is taut, and hangs; a rod keeps its length while it swings.
#[test]
fn ropes_hold_and_rods_keep_their_length() {
    for dt in STEPS {
        let mut world = World::new();
        let weight = world.add(Thing::cuboid(
            10.0,
            Vec3::splat(0.2),
            Vec3::new(0.0, -0.5, 0.0),
        ));
        let rope = world.join([0, weight], Vec3::ZERO, [FREE; 6]);
        let ends = [f32::NEG_INFINITY, 1.0];
        let link = &mut world.links[rope];
        link.anchors = [Vec3::ZERO; 2];
        link.constraint.distance = Some(JointAxis {
            limits: ends,
            ..FREE
        });
        world.run(0.2, dt);
        let free = -0.5 - 0.5 * G * 0.04;
        below((world.things[1].position.y - free).abs(), 0.02, "falls");
        let mut longest = 0f32;
        world.run_with(4.0, dt, |world| longest = longest.max(world.gap(0)));
        below(longest, 1.003, "rope");
        below((world.gap(0) - 1.0).abs(), 1e-4, "hangs");
        below(world.fastest()[0], 1e-4, "still");

        let mut world = World::new();
        let weight = world.add(Thing::cuboid(10.0, Vec3::splat(0.2), Vec3::X));
        let rod = world.join([0, weight], Vec3::ZERO, [FREE; 6]);
        let link = &mut world.links[rod];
        link.anchors = [Vec3::ZERO; 2];
        link.constraint.distance = Some(JointAxis {
            limits: [1.0; 2],
            ..FREE
        });
        let (mut longest, mut shortest) = (0f32, f32::INFINITY);
        let begin = world.energy();
        world.run_with(20.0, dt, |world| {
            longest = longest.max(world.gap(0));
            shortest = shortest.min(world.gap(0));
        });
        below(longest - shortest, 2e-4, "rod");
        // 17 swings.
        let lost = (begin - world.energy()) as f32 / (10.0 * G);
        below(lost.abs(), 17.0 * 0.001, "energy of a rod");
    }
}

/// A weight on a slider falls to its stop.
#[test]
fn sliders_stop() {
    for dt in STEPS {
        let mut world = World::new();
        let weight = world.add(Thing::cuboid(10.0, Vec3::splat(0.2), Vec3::ZERO));
        let mut axes = FIXED;
        axes[1] = JointAxis {
            limits: [-1.0, 0.5],
            ..FREE
        };
        world.join([0, weight], Vec3::new(0.7, 0.0, 0.0), axes);
        world.run(0.3, dt);
        let fallen = -world.things[1].position.y;
        assert!((fallen - 0.5 * G * 0.09).abs() < 0.02, "{dt}: {fallen}");
        world.run(2.0, dt);
        let fallen = -world.things[1].position.y;
        below((fallen - 1.0).abs(), 1e-4, "stop");
        below(world.fastest()[0], 1e-4, "at rest");
    }
}

/// The force by which a joint breaks depends neither on the step nor on the rate of substeps.
#[test]
fn filtered_forces_do_not_depend_on_rates() {
    let peak = |dt: f32, max_substep: f32| {
        let mut world = World::new();
        world.solver.max_substep = max_substep;
        let weight = world.add(Thing::cuboid(20.0, Vec3::splat(0.2), Vec3::NEG_Y * 0.2));
        let rope = world.join([0, weight], Vec3::ZERO, [FREE; 6]);
        let link = &mut world.links[rope];
        link.anchors = [Vec3::ZERO; 2];
        link.constraint.distance = Some(JointAxis {
            limits: [f32::NEG_INFINITY, 1.0],
            ..FREE
        });
        let mut peak = 0f32;
        world.run_with(1.0, dt, |world| {
            peak = peak.max(world.links[0].constraint.peak[0])
        });
        peak
    };
    // 20 kg at 3.96 m/s over 10 ms: 7.9 kN, and its weight.
    for dt in STEPS {
        for rate in [480.0, 960.0, 1920.0] {
            let found = peak(dt, 1.0 / rate);
            assert!((found - 7.9e3).abs() < 0.1 * 7.9e3, "{dt} {rate}: {found}");
        }
    }
}

/// What a solver keeps changes no bit.
#[test]
fn results_do_not_depend_on_memory() {
    let run = |forgets: bool| {
        let (mut world, _) = table(0.05);
        let load = Thing::cuboid(50.0, Vec3::splat(0.3), Vec3::new(0.3, 0.2, 0.0));
        let load = world.add(load);
        world.join([1, load], Vec3::new(0.3, 0.5, 0.0), BALL);
        for _ in 0..60 {
            if forgets {
                world.forget();
            }
            world.step(1.0 / 60.0);
        }
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        let things = world.things.iter();
        things
            .map(|thing| {
                [
                    bits(thing.position),
                    bits(thing.linear),
                    bits(thing.angular),
                ]
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(run(false), run(true));
}

/// Bricks that are bonded to all of their neighbours stick out from a fixed one like a shelf, in loops of joints.
#[test]
fn bonded_bricks_are_a_shelf() {
    for dt in STEPS {
        let mut world = World::new();
        let mut bricks = [[0; 6]; 4];
        for (i, row) in bricks.iter_mut().enumerate() {
            for (j, brick) in row.iter_mut().enumerate() {
                let at = Vec3::new(j as f32 + 0.5, 0.5 * i as f32, 0.0);
                *brick = world.add(Thing::cuboid(100.0, Vec3::new(1.0, 0.5, 0.5), at));
            }
        }
        for i in 0..4 {
            for j in 0..6 {
                let at = Vec3::new(j as f32, 0.5 * i as f32, 0.0);
                let left = if j == 0 { 0 } else { bricks[i][j - 1] };
                world.join([left, bricks[i][j]], at, FIXED);
                if i > 0 {
                    let at = at + Vec3::new(0.5, -0.25, 0.0);
                    world.join([bricks[i - 1][j], bricks[i][j]], at, FIXED);
                }
            }
        }
        world.run(3.0, dt);
        below(world.widest(), 1e-4, "gap");
        below(world.fastest()[0], 1e-5, "trembling");
        let end = world.things[bricks[0][5] as usize].position;
        below((end - Vec3::X * 5.5).length(), 5e-4, "bends");
        let weight: f32 = world
            .links
            .iter()
            .filter(|link| link.constraint.bodies[0] == 0)
            .map(|link| link.constraint.mean[0].y)
            .sum();
        assert!((weight - 2400.0 * G).abs() < 5.0, "{weight}");
    }
}

/// A bar on a ball joint with limited rotations tumbles within its limits, and comes to rest at one.
#[test]
fn limited_balls_stay_within_limits() {
    for dt in STEPS {
        let mut world = World::new();
        let bar = Thing::cuboid(2.0, Vec3::new(1.0, 0.2, 0.3), 0.5 * Vec3::X);
        let bar = world.add(bar);
        let mut axes = BALL;
        for (axis, bound) in [(3, 0.3), (4, 0.6), (5, 0.5)] {
            axes[axis] = JointAxis {
                limits: [-bound, bound],
                ..FREE
            };
        }
        world.join([0, bar], Vec3::ZERO, axes);
        world.things[1].angular = Vec3::new(4.0, 3.0, 1.0);
        let scale = 2.0 * G;
        let mut most = Vec3::ZERO;
        let begin = world.energy();
        let mut gain = 0f64;
        world.run_with(6.0, dt, |world| {
            most = most.max(world.things[1].rotation.to_scaled_axis().abs());
            gain = gain.max(world.energy() - begin);
        });
        assert!(
            most.x < 0.32 && most.y < 0.62 && most.z < 0.52,
            "{dt}: {most}"
        );
        below(gain as f32 / scale, 1e-2, "gain");
        below(world.widest(), 1e-4, "gap");
    }
}

/// A crank that turns by itself drives a rod through a hinge.
#[test]
fn kinematic_bodies_drive_others() {
    for dt in STEPS {
        let mut world = World::new();
        world.gravity = Vec3::ZERO;
        let crank = world.add(Thing {
            angular: 3.0 * Vec3::Z,
            ..Thing::fixed()
        });
        let rod = world.add(Thing::cuboid(5.0, Vec3::new(1.0, 0.1, 0.1), Vec3::X));
        world.join([crank, rod], 0.5 * Vec3::X, FIXED);
        world.things[2].angular = 3.0 * Vec3::Z;
        world.things[2].linear = 3.0 * Vec3::Y;
        let mut reach = 0f32;
        world.run_with(4.0, dt, |world| reach = reach.max(world.widest()));
        below(reach, 1e-3, "gap");
        let rod = &world.things[2];
        below((rod.linear.length() - 3.0).abs(), 0.02, "speed");
        below((rod.angular - 3.0 * Vec3::Z).length(), 0.02, "spin");
        // m ω² r
        let pull = world.links[0].constraint.mean[0].length();
        below((pull - 45.0).abs(), 1.0, "pull");
    }
}
