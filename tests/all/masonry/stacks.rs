//! Columns of cubes on a slope, which turn over where statics says, whatever shape they are given as.

use support::masonry::blocks::{Frame, Masonry};
use support::masonry::drawings::stack;
use support::masonry::limit::all_met;
use support::masonry::limits::columns::*;
use support::masonry::site::{As, End, How, Site, apart, joints_stay_whole};
use support::masonry::statics::limit_tilt;

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
        let end = Site::build(&stack(5, FRICTION), frame, shapes).end(SETTLES, false);
        assert_eq!(end, End::Falls, "{shapes:?}");
    }
}

#[test]
fn a_column_tips_where_statics_says_whatever_it_is_built_of() {
    for shapes in [As::Cuboids, As::TrueContacts, As::Hulls] {
        println!("{shapes:?}");
        let how = How {
            shapes,
            slowly: true,
        };
        all_met(COLUMNS.map(column), how, 0.02);
    }
}

#[test]
fn a_column_built_at_once_tips_where_statics_says_whatever_it_is_built_of() {
    for shapes in [As::Cuboids, As::TrueContacts, As::Hulls] {
        println!("{shapes:?}");
        let how = How {
            shapes,
            slowly: false,
        };
        all_met([2, 3, 5].map(column), how, 0.02);
    }
}

#[test]
fn a_tall_column_built_at_once_tips_where_statics_says() {
    all_met([column(8)], How::AT_ONCE, 0.02);
}

/// Leaning at all angles below the limit: a standing stack does not move.
#[test]
fn a_leaning_column_of_cuboids_does_not_shake() {
    let mut bad = Vec::new();
    for n in [3, 5, 8, 12] {
        let masonry = stack(n, FRICTION);
        for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
            let tilt = share * limit_tilt(&masonry);
            for yaw in [0.0, yaw(n)] {
                let mut site = Site::build(&masonry, Frame { tilt, yaw }, As::Cuboids);
                let end = site.end(SETTLES, false);
                let speed = site.speed();
                println!(
                    "{n} cuboids at {share} of the limit, yaw {yaw:.2}: {end:?}, {speed:.1e} m/s"
                );
                if end != End::Stands {
                    bad.push((n, share, yaw, end, speed));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{bad:?}");
}

#[test]
fn all_joints_of_a_column_are_found_whole() {
    let masonry = stack(5, FRICTION);
    let limit = limit_tilt(&masonry);
    let site = |(i, shapes)| {
        let share = 0.1 * i as f64;
        let frame = Frame {
            tilt: share * limit,
            yaw: yaw(i),
        };
        let what = format!("{shapes:?} at {share:.1} of the limit");
        (what, Site::build(&masonry, frame, shapes))
    };
    let all = [As::Cuboids, As::Hulls].into_iter();
    joints_stay_whole(
        all.flat_map(|shapes| (0..10).map(move |i| (i, shapes)))
            .map(site),
    );
}
