//! Structures on a slope that can be tipped, and the limits at which they fall by statics.

use crate::masonry::blocks::Masonry;
use crate::masonry::drawings::{arch, stack, wall};
use crate::masonry::site::{As, End, Site};
use crate::masonry::statics::limit_tilt;
use crate::{G, Lab};
use drystone::settings::Gravity;
use glam::DVec3;

/// The steepest limit of all is a slope of 1 in 3.
const FRICTION: f64 = 0.9;

/// A block has fallen if it is farther than this from its initial position, m. It is a fifth of a brick's depth, and more than any
/// settlement here.
const FALLEN: f64 = 0.1;

/// Shares of the limit a second, far from it and near it.
pub const FAST: f64 = 0.02;
pub const SLOW: f64 = 0.01;

/// From where it is tipped slowly, as a share of the limit.
pub const NEAR: f64 = 0.8;

/// Step lengths, s, and how far from the true limit something may fall, as a share of it.
pub const STEPS: [(f32, f64); 3] = [(1.0 / 60.0, 0.03), (1.0 / 30.0, 0.03), (0.1, 0.05)];

/// Something built, and its true limit.
#[derive(Clone)]
pub struct Structure {
    pub what: String,
    masonry: Masonry,
    shapes: As,
    /// The direction in which it is tipped.
    towards: DVec3,
    /// rad
    pub limit: f64,
}

impl Structure {
    /// Tipped in the plane in which it is drawn.
    fn along(what: String, masonry: Masonry, shapes: As) -> Self {
        let limit = limit_tilt(&masonry);
        Self {
            what,
            masonry,
            shapes,
            towards: DVec3::NEG_X,
            limit,
        }
    }

    pub fn stack(n: usize) -> Self {
        let masonry = stack(n, FRICTION);
        Self::along(format!("stack of {n}"), masonry, As::Cuboids)
    }

    pub fn arch() -> Self {
        let masonry = arch(15, 0.2, FRICTION);
        Self::along("arch of 15".into(), masonry, As::Hulls)
    }

    /// Bricks do not touch those beside them: where there is friction on all sides, limit analysis says more than is true, as it takes
    /// what slides to move apart.
    pub fn wall_along(courses: usize) -> Self {
        let what = format!("wall of {courses} along");
        Self::along(what, wall(4, courses, 0.05, FRICTION), As::Cuboids)
    }

    /// It turns over its lower edge as one: any part above a joint would have to be tipped farther.
    pub fn wall_across(courses: usize) -> Self {
        let masonry = wall(6, courses, 0.0, FRICTION);
        let brick = masonry.blocks[1].cuboid().expect("bricks are cuboids");
        Self {
            what: format!("wall of {courses} across"),
            limit: (brick.z / (courses as f64 * brick.y)).atan(),
            masonry,
            shapes: As::Cuboids,
            towards: DVec3::Z,
        }
    }
}

/// Turns gravity as if the ground were tilted by an angle, rad, so that what stands on it leans in this direction.
pub fn tip(lab: &mut Lab, angle: f64, towards: DVec3) {
    let (sin, cos) = angle.sin_cos();
    let down = cos * DVec3::NEG_Y + sin * towards;
    lab.world.resource_mut::<Gravity>().0 = G * down.as_vec3();
}

/// The tilts of the steps of `dt` s from one tilt to another, at so much a second.
pub fn tilts([from, to]: [f64; 2], rate: f64, dt: f32) -> impl Iterator<Item = f64> {
    let steps = ((to - from) / (rate * f64::from(dt))).ceil() as usize;
    (1..=steps).map(move |step| from + (to - from) * step as f64 / steps as f64)
}

/// A structure on a slope.
pub struct Slope {
    pub site: Site,
    structure: Structure,
    /// The slope's tilt as a share of the limit.
    pub tilt: f64,
}

impl Slope {
    /// With default settings and steps of so many seconds.
    pub fn new(structure: &Structure, dt: f32, tilt: f64) -> Self {
        let mut site = Site::leaning(&structure.masonry, 0.0, structure.shapes);
        site.lab.dt = dt;
        let structure = structure.clone();
        let mut slope = Self {
            site,
            structure,
            tilt: 0.0,
        };
        slope.tip(tilt);
        slope
    }

    fn tip(&mut self, tilt: f64) {
        self.tilt = tilt;
        let angle = tilt * self.structure.limit;
        tip(&mut self.site.lab, angle, self.structure.towards);
    }

    /// Tips it on to there, where it is not beyond, at so many shares of the limit a second; false if it falls on the way.
    pub fn turn(&mut self, to: f64, rate: f64) -> bool {
        let mut tilts = tilts([self.tilt, to], rate, self.site.lab.dt);
        tilts.all(|tilt| {
            self.tip(tilt);
            self.site.lab.step();
            self.site.moved() < FALLEN
        })
    }

    /// Lets it be for so many seconds; false if it falls.
    pub fn rest(&mut self, seconds: f32) -> bool {
        let steps = (seconds / self.site.lab.dt).ceil() as usize;
        (0..steps).all(|_| {
            self.site.lab.step();
            self.site.moved() < FALLEN
        })
    }

    /// How it ends where it is.
    pub fn end(&mut self) -> End {
        self.site.end(FALLEN, false)
    }
}
