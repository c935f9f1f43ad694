//! Wedges on a slope, in a groove, between two blocks, and in a flat arch.

use crate::masonry::blocks::Masonry;
use crate::masonry::drawings::{flat_arch, frustum, groove, splitter};
use crate::masonry::limit::Limit;
use crate::masonry::site::{End, How, Site};
use crate::masonry::statics::{limit_load, limit_tilt, threshold};

/// Maximum settlement of a wedge of 1 m height, m.
pub const SETTLES: f64 = 0.05;

pub fn end(masonry: &Masonry, tilt: f64, how: How) -> End {
    Site::leaning(masonry, tilt, how.shapes).end(SETTLES, how.slowly)
}

pub fn tilt(what: String, masonry: Masonry) -> Limit {
    Limit::up_to(
        format!("tilt of {what}"),
        limit_tilt(&masonry),
        move |tilt, how| end(&masonry, tilt, how),
    )
}

/// The weight of the last block, as a multiple of what it is drawn with.
pub fn load(what: String, masonry: Masonry) -> Limit {
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

pub fn friction(what: String, of: impl Fn(f64) -> Masonry + 'static) -> Limit {
    Limit::from(
        format!("friction of {what}"),
        threshold(0.0, 1.0, &of),
        move |friction, how| end(&of(friction), 0.0, how),
    )
}

pub fn frustums() -> Vec<Limit> {
    let each = |mu| tilt(format!("a frustum, friction {mu}"), frustum(mu));
    [0.3, 0.84].map(each).into()
}

pub fn grooves() -> Vec<Limit> {
    let each = |(half, mu)| {
        let what = format!("a wedge of {half}° in a groove, friction {mu}");
        tilt(what, groove(half, mu))
    };
    [(30.0, 0.3), (45.0, 0.3), (50.0, 0.84), (60.0, 0.84)]
        .map(each)
        .into()
}

pub fn splitters() -> Vec<Limit> {
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

pub fn flat_arches() -> Vec<Limit> {
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

pub fn wedges() -> impl Iterator<Item = Limit> {
    frustums().into_iter().chain(grooves()).chain(splitters())
}
