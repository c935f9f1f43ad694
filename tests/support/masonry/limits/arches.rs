//! Semicircular arches: how thin, how smooth and how tilted they may be.

use crate::masonry::blocks::Masonry;
use crate::masonry::drawings::arch;
use crate::masonry::limit::Limit;
use crate::masonry::site::{End, How, Site};
use crate::masonry::statics::{limit_tilt, threshold};

pub const VOUSSOIRS: [usize; 4] = [11, 12, 15, 20];

/// The thickness, as a share of the mean radius, of arches that are tried in other ways.
pub const THICK: f64 = 0.2;

pub fn end(masonry: &Masonry, tilt: f64, how: How) -> End {
    let [inner, outer] = [0, 1].map(|i| masonry.blocks[1].outline[i].length());
    Site::leaning(masonry, tilt, how.shapes).end(0.05 * (outer - inner), how.slowly)
}

pub fn thickness(n: usize) -> Vec<Limit> {
    let each = |friction| {
        let of = move |share| arch(n, share, friction);
        Limit::from(
            format!("thickness of {n} voussoirs, friction {friction}"),
            threshold(0.02, 0.3, of),
            move |share, how| end(&of(share), 0.0, how),
        )
    };
    [0.6, 0.84].map(each).into()
}

pub fn friction(n: usize) -> Vec<Limit> {
    let of = move |friction| arch(n, THICK, friction);
    vec![Limit::from(
        format!("friction of {n} voussoirs"),
        threshold(0.1, 0.9, of),
        move |friction, how| end(&of(friction), 0.0, how),
    )]
}

/// With joints that open, and with some that slide as well.
pub fn tilt(n: usize, friction: f64) -> Vec<Limit> {
    let masonry = arch(n, THICK, friction);
    vec![Limit::up_to(
        format!("tilt of {n} voussoirs, friction {friction}"),
        limit_tilt(&masonry),
        move |tilt, how| end(&masonry, tilt, how),
    )]
}

pub fn all(n: usize) -> Vec<Limit> {
    let tilts = [0.5, 0.84].map(|friction| tilt(n, friction));
    let mut all = [thickness(n), friction(n)].concat();
    all.extend(tilts.concat());
    all
}
