//! Wedges on a slope, in a groove, between two blocks, and in a flat arch.
//!
//! A wedge whose narrow end is up holds between two supports only if it was pressed in, of which statics of rigid blocks knows
//! nothing. All that is here is determinate.

use crate::masonry::blocks::{Frame, Masonry};
use crate::masonry::drawings::{flat_arch, frustum, groove, splitter};
use crate::masonry::limit::{Limit, SHARE, all_found, all_met};
use crate::masonry::site::{As, End, How, Site, joints_stay_whole};
use crate::masonry::statics::{limit_load, limit_tilt, threshold};

/// What a wedge a metre high may give way as it settles, m.
const SETTLES: f64 = 0.05;

fn end(masonry: &Masonry, tilt: f64, how: How) -> End {
    Site::leaning(masonry, tilt, how.shapes).end(SETTLES, how.slowly)
}

fn tilt(what: String, masonry: Masonry) -> Limit {
    Limit::up_to(
        format!("tilt of {what}"),
        limit_tilt(&masonry),
        move |tilt, how| end(&masonry, tilt, how),
    )
}

/// The weight of the last block, as a multiple of what it is drawn with.
fn load(what: String, masonry: Masonry) -> Limit {
    let last = masonry.blocks.len() - 1;
    Limit::up_to(
        format!("load on {what}"),
        limit_load(&masonry, last),
        move |factor, how| {
            let masonry = masonry.clone().loaded(factor);
            end(&masonry, 0.0, how)
        },
    )
}

fn friction(what: String, of: impl Fn(f64) -> Masonry + 'static) -> Limit {
    Limit::from(
        format!("friction of {what}"),
        threshold(0.0, 1.0, &of),
        move |friction, how| end(&of(friction), 0.0, how),
    )
}

fn frustums() -> Vec<Limit> {
    let each = |mu| tilt(format!("a frustum, friction {mu}"), frustum(mu));
    [0.3, 0.84].map(each).into()
}

fn grooves() -> Vec<Limit> {
    let each = |(half, mu)| {
        let what = format!("a wedge of {half}° in a groove, friction {mu}");
        tilt(what, groove(half, mu))
    };
    [(30.0, 0.3), (45.0, 0.3), (50.0, 0.84), (60.0, 0.84)]
        .map(each)
        .into()
}

fn splitters() -> Vec<Limit> {
    let each = |(half, mu)| {
        let what = format!("blocks parted by a wedge of {half}°");
        [
            load(format!("{what}, friction {mu}"), splitter(half, mu)),
            friction(what, move |mu| splitter(half, mu).loaded(10.0)),
        ]
    };
    let all = [(20.0, 0.3), (10.0, 0.4), (30.0, 0.3)];
    all.into_iter().flat_map(each).collect()
}

fn flat_arches() -> Vec<Limit> {
    let each = |(n, on, mu)| {
        let what = format!("voussoir {on} of a flat arch of {n}");
        let of = move |mu| flat_arch(n, mu, Some(on));
        [
            load(format!("{what}, friction {mu}"), of(mu)),
            friction(what, move |mu| of(mu).loaded(20.0)),
        ]
    };
    let all = [(5, 2, 0.05), (5, 1, 0.05), (7, 3, 0.08), (7, 1, 0.08)];
    all.into_iter().flat_map(each).collect()
}

fn wedges() -> impl Iterator<Item = Limit> {
    frustums().into_iter().chain(grooves()).chain(splitters())
}

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

#[test]
#[ignore = "long"]
fn limits_of_wedges() {
    all_found(wedges());
}

#[test]
#[ignore = "long"]
fn limits_of_flat_arches() {
    all_found(flat_arches());
}

/// Where friction is more than the slope of its sides it jams, however it is turned.
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
