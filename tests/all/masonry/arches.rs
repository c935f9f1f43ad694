//! Semicircular arches of hulls that touch exactly.

use support::masonry::blocks::Frame;
use support::masonry::drawings::{RADIUS, arch};
use support::masonry::limit::{SHARE, all_met};
use support::masonry::limits::arches::*;
use support::masonry::site::{As, How, Site, joints_stay_whole};

#[test]
fn an_arch_too_thin_falls() {
    all_met(VOUSSOIRS.map(thickness).concat(), How::SLOWLY, SHARE);
}

#[test]
fn an_arch_of_too_little_friction_falls() {
    all_met(VOUSSOIRS.map(friction).concat(), How::SLOWLY, SHARE);
}

#[test]
fn an_arch_tilted_too_far_falls() {
    let all = VOUSSOIRS.map(|n| tilt(n, 0.84));
    all_met(all.concat(), How::SLOWLY, SHARE);
}

#[test]
fn an_arch_tilted_until_it_slides_falls() {
    let all = VOUSSOIRS.map(|n| tilt(n, 0.5));
    all_met(all.concat(), How::SLOWLY, SHARE);
}

#[test]
fn an_arch_built_at_once_stands_as_one_built_slowly() {
    let all = [11, 12, 15].map(|n| [thickness(n), friction(n)].concat());
    all_met(all.concat(), How::AT_ONCE, SHARE);
}

#[test]
fn a_long_or_leaning_arch_built_at_once_stands_as_one_built_slowly() {
    all_met(VOUSSOIRS.map(all).concat(), How::AT_ONCE, SHARE);
}

/// The solver alone.
#[test]
fn an_arch_of_true_contacts_falls_where_statics_says() {
    let all = VOUSSOIRS.map(|n| [thickness(n), friction(n), tilt(n, 0.84)].concat());
    all_met(all.concat(), How::TRUE_SLOWLY, SHARE);
}

/// Far from all limits an arch hardly moves.
#[test]
fn a_thick_arch_stays_where_it_is() {
    let moved = VOUSSOIRS.map(|n| {
        let mut site = Site::leaning(&arch(n, THICK, 0.84), 0.0, As::Hulls);
        site.lab.run(20.0);
        let (moved, speed) = (site.moved(), site.speed());
        println!("{n} voussoirs: moved {moved:.2e} m, {speed:.1e} m/s");
        moved
    });
    assert!(moved.iter().all(|&m| m < 1e-3 * RADIUS), "{moved:?} m");
}

#[test]
fn all_joints_of_an_arch_are_found_whole() {
    let turned = VOUSSOIRS.into_iter().flat_map(|n| {
        [(THICK, 0.0), (THICK, 0.4), (0.15, 0.7)].map(|(share, yaw)| {
            let frame = Frame { tilt: 0.0, yaw };
            let site = Site::build(&arch(n, share, 0.84), frame, As::Hulls);
            (format!("{n} voussoirs {share} thick, yaw {yaw}"), site)
        })
    });
    let leaning = VOUSSOIRS.into_iter().map(|n| {
        let site = Site::leaning(&arch(n, THICK, 0.84), 0.15, As::Hulls);
        (format!("{n} voussoirs, leaning"), site)
    });
    joints_stay_whole(turned.chain(leaning));
}
