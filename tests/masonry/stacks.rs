//! Columns of cubes on a slope, which turn over where statics says, whatever shape they are given as.

use crate::blocks::{Frame, Masonry};
use crate::drawings::stack;
use crate::limit::{Limit, all_met};
use crate::site::{As, Site, apart, joints_stay_whole};
use crate::statics::limit_tilt;

/// Enough not to slide before they tip.
const FRICTION: f64 = 0.9;

/// What a column may give way as it settles, m.
const SETTLES: f64 = 0.05;

/// The golden angle: no two scenes stand alike, and none along an axis.
fn yaw(i: usize) -> f64 {
    0.3 + 2.399_963 * i as f64
}

/// How far apart the same scene of hulls and of cuboids ends after 20 s, and how far the hulls moved, m.
fn hulls_against_cuboids(masonry: &Masonry, frame: Frame) -> (f64, f64) {
    let [hulls, cuboids] = [As::Hulls, As::Cuboids].map(|shapes| {
        let mut site = Site::build(masonry, frame, shapes);
        site.lab.run(20.0);
        site
    });
    (apart(&hulls.poses(), &cuboids.poses()), hulls.moved())
}

#[test]
fn cubes_given_as_hulls_stand_at_fifty_tilts_as_cuboids_do() {
    let masonry = stack(5, FRICTION);
    let most = 0.97 * limit_tilt(&masonry);
    let mut bad = Vec::new();
    for i in 0..50 {
        let tilt = most * i as f64 / 49.0;
        let (off, moved) = hulls_against_cuboids(&masonry, Frame { tilt, yaw: yaw(i) });
        let degrees = tilt.to_degrees();
        println!("{degrees:.2}°: {off:.1e} m apart, moved {moved:.1e} m");
        if off > 1e-4 || moved > SETTLES {
            bad.push((degrees, off, moved));
        }
    }
    assert!(
        bad.is_empty(),
        "{} of 50 tilts (°, m, m): {bad:?}",
        bad.len()
    );
}

/// Four of them stand at 13.27°; a fifth makes them fall.
#[test]
fn cubes_given_as_hulls_stand_at_13_degrees_as_cuboids_do() {
    let frame = Frame {
        tilt: 13.27f64.to_radians(),
        yaw: 0.4,
    };
    let (off, moved) = hulls_against_cuboids(&stack(4, FRICTION), frame);
    println!("{off:e} m apart, moved {moved:e} m");
    assert!(off < 1e-4, "{off} m apart");
    assert!(moved < SETTLES, "{moved} m");
    for shapes in [As::Hulls, As::Cuboids] {
        assert!(
            !Site::build(&stack(5, FRICTION), frame, shapes).stands(SETTLES),
            "{shapes:?}"
        );
    }
}

#[test]
fn a_column_tips_where_statics_says_whatever_it_is_built_of() {
    let each = |(n, shapes)| {
        let masonry = stack(n, FRICTION);
        let what = format!("tilt of {n} {shapes:?}");
        Limit::up_to(what, limit_tilt(&masonry), move |tilt| {
            let frame = Frame { tilt, yaw: yaw(n) };
            Site::build(&masonry, frame, shapes).stands(SETTLES)
        })
    };
    let all = [2, 3, 5, 8].into_iter();
    let all = all.flat_map(|n| [(n, As::Cuboids), (n, As::Hulls)]);
    all_met(all.map(each), 0.02);
}

#[test]
fn all_joints_of_a_column_are_found_whole() {
    let masonry = stack(5, FRICTION);
    let limit = limit_tilt(&masonry);
    for shapes in [As::Cuboids, As::Hulls] {
        for (i, share) in [0.0, 0.2, 0.4, 0.6, 0.8, 0.95].into_iter().enumerate() {
            let frame = Frame {
                tilt: share * limit,
                yaw: yaw(i),
            };
            let mut site = Site::build(&masonry, frame, shapes);
            joints_stay_whole(&mut site, &format!("{shapes:?} at {share} of the limit"));
        }
    }
}
