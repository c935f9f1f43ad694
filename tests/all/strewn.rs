//! Bodies strewn over each other in a cubic metre part without being thrown.

use drystone::contact::Manifold;
use drystone::diagnosis::BodyProblem;
use drystone_lab::energy::{Fall, Loose, Shape};
use drystone_lab::metrics;
use support::Lab;

const DT: f32 = 1.0 / 60.0;

/// Without weight, so that all that moves was thrown.
fn part(count: u32, shape: Shape, seconds: f32) -> Fall {
    let strewn = Loose::Strewn {
        count,
        shape,
        side: 1.0,
        middle: None,
    };
    let fall = strewn.run(1, DT, seconds);
    println!("{count} {shape:?}: {fall:?}");
    fall
}

/// The mean speed that a kinetic energy stands for, m/s, of so many balls of 1000 kg/m³.
fn mean_speed(fall: &Fall, count: u32, radius: f32) -> f64 {
    let volume = 4.0 / 3.0 * std::f64::consts::PI * f64::from(radius).powi(3);
    (2.0 * fall.kinetic / (1000.0 * volume * f64::from(count))).sqrt()
}

#[test]
fn balls_part_slowly() {
    for (count, radius) in [(300, 0.1), (100, 0.25), (300, 0.25)] {
        let fall = part(count, Shape::Ball(radius), 2.0);
        let mean = mean_speed(&fall, count, radius);
        println!("mean speed {mean:.2} m/s");
        assert!(fall.fastest <= 3.0, "{} m/s", fall.fastest);
        assert!(mean <= 1.6, "{mean} m/s on the whole");
        assert!(fall.overlap <= 0.001, "{} m deep in the end", fall.overlap);
    }
}

#[test]
fn bricks_part_slowly() {
    let fall = part(300, Shape::Brick, 0.5);
    assert!(fall.fastest <= 3.0, "{} m/s", fall.fastest);
}

#[test]
fn a_heap_of_balls_on_the_ground_is_not_thrown_about() {
    let strewn = Loose::Strewn {
        count: 300,
        shape: Shape::Ball(0.1),
        side: 1.0,
        middle: Some(0.5),
    };
    let fall = strewn.run(1, DT, 2.0);
    println!("{fall:?}");
    assert!(fall.fastest <= 5.0, "{} m/s", fall.fastest);
}

/// A hundred bricks in 30 × 30 × 30 cm meet in 4 950 pairs, of which no more than 16 of each body are solved at once.
#[test]
fn a_crowd_is_named_once_and_parts_all_the_same() {
    let mut lab = Lab::new();
    let crowd = Loose::Strewn {
        count: 100,
        shape: Shape::Brick,
        side: 0.3,
        middle: None,
    };
    crowd.build(&mut lab.world, 1);
    lab.step();
    let mut manifolds = lab.world.query::<&Manifold>();
    let pairs = manifolds.iter(&lab.world);
    let touching = pairs.filter(|manifold| !manifold.points.is_empty()).count();
    assert!((100..=1_600).contains(&touching), "{touching} pairs");
    lab.run(5.0);
    let errors = lab.errors();
    let named = errors
        .iter()
        .filter(|error| error.problem == BodyProblem::Crowded);
    assert_eq!(named.count(), 1, "{errors:?}");
    let overlap = metrics::gaps(&mut lab.world).penetration_max;
    println!("{touching} pairs, overlap {overlap}");
    assert!(overlap < 0.005, "{overlap} m deep in the end");
}
