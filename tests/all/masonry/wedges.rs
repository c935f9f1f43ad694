//! Wedges on a slope, in a groove, between two blocks, and in a flat arch.
//!
//! A wedge whose narrow end is up holds between two supports only if it was pressed in, of which statics of rigid blocks knows
//! nothing. All that is here is determinate.

use support::masonry::blocks::Frame;
use support::masonry::drawings::{flat_arch, frustum, groove, splitter};
use support::masonry::limit::{SHARE, all_met};
use support::masonry::limits::wedges::*;
use support::masonry::site::{As, End, How, Site, joints_stay_whole};
use support::masonry::statics::limit_tilt;

#[test]
fn a_frustum_leaves_its_slope_where_statics_says() {
    all_met(frustums(), How::SLOWLY, SHARE);
}

#[test]
fn a_wedge_leaves_its_groove_where_statics_says() {
    all_met(grooves(), How::SLOWLY, SHARE);
}

#[test]
fn a_wedge_parts_two_blocks_where_statics_says() {
    all_met(splitters(), How::SLOWLY, SHARE);
}

#[test]
fn a_wedge_built_at_once_holds_as_one_built_slowly() {
    all_met(wedges(), How::AT_ONCE, SHARE);
}

/// The solver alone.
#[test]
fn a_wedge_of_true_contacts_holds_where_statics_says() {
    all_met(wedges(), How::TRUE_SLOWLY, SHARE);
    all_met(wedges(), How::TRUE_AT_ONCE, SHARE);
}

#[test]
fn a_flat_arch_gives_way_where_statics_says() {
    all_met(flat_arches(), How::SLOWLY, SHARE);
}

#[test]
fn a_flat_arch_built_at_once_holds_as_one_built_slowly() {
    all_met(flat_arches(), How::AT_ONCE, SHARE);
}

/// The solver alone.
#[test]
fn a_flat_arch_of_true_contacts_gives_way_where_statics_says() {
    all_met(flat_arches(), How::TRUE_SLOWLY, SHARE);
}

/// A wedge jams if friction exceeds the slope of its sides, in any orientation.
#[test]
fn a_slender_wedge_jams_in_its_groove() {
    let masonry = groove(10.0, 0.84);
    assert_eq!(limit_tilt(&masonry), 0.5 * std::f64::consts::PI);
    for degrees in [0.0f64, 20.0, 40.0, 60.0, 80.0] {
        let mut site = Site::leaning(&masonry, degrees.to_radians(), As::Hulls);
        let end = site.end(SETTLES, false);
        println!("{degrees}°: {end:?}, moved {} m", site.moved());
        assert_eq!(end, End::Stands, "{degrees}°: {} m", site.moved());
    }
}

#[test]
fn all_joints_of_wedges_are_found_whole() {
    let drawings = [
        ("frustum", frustum(0.5)),
        ("groove", groove(30.0, 0.3)),
        ("slender groove", groove(10.0, 0.84)),
        ("splitter", splitter(30.0, 0.6)),
        ("flat arch of 5", flat_arch(5, 0.3, None)),
        (
            "loaded flat arch of 5",
            flat_arch(5, 0.3, Some(2)).loaded(5.0),
        ),
        (
            "loaded flat arch of 7",
            flat_arch(7, 0.3, Some(1)).loaded(5.0),
        ),
    ];
    let sites = drawings.iter().flat_map(|(what, masonry)| {
        [0.0, 0.4, 1.1].map(|yaw| {
            let frame = Frame { tilt: 0.0, yaw };
            let site = Site::build(masonry, frame, As::Hulls);
            (format!("{what}, yaw {yaw}"), site)
        })
    });
    joints_stay_whole(sites);
}
