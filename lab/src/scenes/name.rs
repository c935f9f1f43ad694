//! Scenes by name, there and back.

use super::busy::name as busy;
use super::{Grain, Scene};
use std::fmt;
use std::num::IntErrorKind;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// How every scene is called.
pub const KNOWN: &str = "wall:WxH, stack:N, pyramid:N, tower:N, arch:N, dome:N, castle:N, heap:N, \
    pile:balls|capsules|cylinders|hulls:N, dominoes:N, incline:DEG, massratio:R[xN], cardhouse:N, \
    cantilever:N, rocking:N, rolling, sliding, dropped, overlap:M, pressed:N, chain:N, bridge:N, \
    ragdolls:N, large_pyramid:N, many_pyramids:N, joint_grid:[seven:|corner:]N, rain:N, convex_pile:N, smash:N, \
    spinner:N, tumbler:kinematic|hinge:N, washer:N, junkyard:N, mesh_drop:N, field_drop:N, \
    compounds:NxPARTS, voxels:NxCUBES, large_world:N, flyers:N:SPEED";

/// The kinds of piles, by name.
const GRAINS: [(Grain, &str); 4] = [
    (Grain::Balls, "balls"),
    (Grain::Capsules, "capsules"),
    (Grain::Cylinders, "cylinders"),
    (Grain::Hulls, "hulls"),
];

/// A scene by name has at most so many bodies: more would not fit into memory, or not end in a day.
pub const MAX_BODIES: u64 = 200_000;

/// How many cubes carry the weight of `massratio:R`.
const CARRIERS: u32 = 5;

/// Thinner voussoirs are no hulls.
const VOUSSOIRS: RangeInclusive<f32> = 3.0..=1000.0;
/// A castle has a course above its gate, and is laid out to be counted.
const COURSES: RangeInclusive<f32> = 4.0..=1000.0;
/// °
const SLOPES: RangeInclusive<f32> = -90.0..=90.0;
/// Beyond, single precision has no digits left.
const RATIOS: RangeInclusive<f32> = 1e-6..=1e6;
/// m; from a gap between the cubes to one all inside the other.
const OVERLAPS: RangeInclusive<f32> = -10.0..=1.0;

/// Why a name is not that of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// No scene is called so.
    Unknown(String),
    /// It would have more than [`MAX_BODIES`].
    TooManyBodies(String),
    /// Its number is not one of these.
    OutOfRange(String, RangeInclusive<f32>),
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => write!(f, "no scene `{name}`; known scenes: {KNOWN}"),
            Self::TooManyBodies(name) => {
                write!(f, "`{name}` is too large: at most {MAX_BODIES} bodies")
            }
            Self::OutOfRange(name, allowed) => write!(
                f,
                "`{name}` is out of range: from {} to {}",
                allowed.start(),
                allowed.end()
            ),
        }
    }
}

impl std::error::Error for SceneError {}

/// The name of a scene: its kind and what follows the first colon.
pub(super) struct Name<'a> {
    full: &'a str,
    pub kind: &'a str,
    pub size: &'a str,
}

impl<'a> Name<'a> {
    fn new(full: &'a str) -> Self {
        let (kind, size) = full.split_once(':').unwrap_or((full, ""));
        Self { full, kind, size }
    }

    pub fn unknown(&self) -> SceneError {
        SceneError::Unknown(self.full.to_owned())
    }

    /// A number of bodies, at least one.
    pub fn count(&self, text: &str) -> Result<u32, SceneError> {
        match text.parse::<u32>() {
            Ok(n) if n > 0 => Ok(n),
            Err(error) if *error.kind() == IntErrorKind::PosOverflow => {
                Err(SceneError::TooManyBodies(self.full.to_owned()))
            }
            _ => Err(self.unknown()),
        }
    }

    pub fn within(&self, x: f32, allowed: RangeInclusive<f32>) -> Result<f32, SceneError> {
        match allowed.contains(&x) {
            true => Ok(x),
            false => Err(SceneError::OutOfRange(self.full.to_owned(), allowed)),
        }
    }

    pub fn number(&self, text: &str, allowed: RangeInclusive<f32>) -> Result<f32, SceneError> {
        self.within(text.parse().map_err(|_| self.unknown())?, allowed)
    }
}

impl FromStr for Scene {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        let name = Name::new(text);
        let scene = match busy::parse(&name) {
            Some(busy) => Self::Busy(busy?),
            None => Self::parse(&name)?,
        };
        if scene.bodies() > MAX_BODIES {
            return Err(SceneError::TooManyBodies(text.to_owned()));
        }
        Ok(scene)
    }
}

impl Scene {
    /// A scene that is not one of the busy ones.
    fn parse(name: &Name) -> Result<Self, SceneError> {
        let size = name.size;
        let count = || name.count(size);
        let scene = match name.kind {
            "wall" => {
                let (w, h) = size.split_once('x').ok_or_else(|| name.unknown())?;
                Self::Wall(name.count(w)?, name.count(h)?)
            }
            "stack" => Self::Stack(count()?),
            "pyramid" => Self::Pyramid(count()?),
            "tower" => Self::Tower(count()?),
            "arch" => {
                let n = count()?;
                name.within(n as f32, VOUSSOIRS)?;
                Self::Arch(n)
            }
            "dome" => Self::Dome(count()?),
            "castle" => {
                let n = count()?;
                name.within(n as f32, COURSES)?;
                Self::Castle(n)
            }
            "heap" => Self::Heap(count()?),
            "pile" => {
                let (grain, n) = size.split_once(':').ok_or_else(|| name.unknown())?;
                let known = GRAINS.iter().find(|(_, known)| *known == grain);
                let (grain, _) = known.ok_or_else(|| name.unknown())?;
                Self::Pile(*grain, name.count(n)?)
            }
            "dominoes" => Self::Dominoes(count()?),
            "incline" => Self::Incline(name.number(size, SLOPES)?),
            "massratio" => {
                let (ratio, carriers) = match size.split_once('x') {
                    Some((ratio, n)) => (ratio, name.count(n)?),
                    None => (size, CARRIERS),
                };
                Self::MassRatio(name.number(ratio, RATIOS)?, carriers)
            }
            "cardhouse" => Self::CardHouse(count()?),
            "cantilever" => Self::Cantilever(count()?),
            "overlap" => Self::Overlap(name.number(size, OVERLAPS)?),
            "pressed" => Self::Pressed(count()?),
            "chain" => Self::Chain(count()?),
            "bridge" => Self::Bridge(count()?),
            "ragdolls" => Self::Ragdolls(count()?),
            "rocking" => Self::Rocking(count()?),
            "rolling" if size.is_empty() => Self::Rolling,
            "sliding" if size.is_empty() => Self::Sliding,
            "dropped" if size.is_empty() => Self::Dropped,
            _ => return Err(name.unknown()),
        };
        Ok(scene)
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Wall(w, h) => write!(f, "wall:{w}x{h}"),
            Self::Stack(n) => write!(f, "stack:{n}"),
            Self::Pyramid(n) => write!(f, "pyramid:{n}"),
            Self::Tower(n) => write!(f, "tower:{n}"),
            Self::Arch(n) => write!(f, "arch:{n}"),
            Self::Dome(n) => write!(f, "dome:{n}"),
            Self::Castle(n) => write!(f, "castle:{n}"),
            Self::Heap(n) => write!(f, "heap:{n}"),
            Self::Pile(grain, n) => {
                let known = GRAINS.iter().find(|(known, _)| known == grain);
                write!(f, "pile:{}:{n}", known.map_or("", |(_, name)| name))
            }
            Self::Dominoes(n) => write!(f, "dominoes:{n}"),
            Self::Incline(degrees) => write!(f, "incline:{degrees}"),
            Self::MassRatio(ratio, CARRIERS) => write!(f, "massratio:{ratio}"),
            Self::MassRatio(ratio, n) => write!(f, "massratio:{ratio}x{n}"),
            Self::CardHouse(n) => write!(f, "cardhouse:{n}"),
            Self::Cantilever(n) => write!(f, "cantilever:{n}"),
            Self::Rocking(n) => write!(f, "rocking:{n}"),
            Self::Rolling => f.write_str("rolling"),
            Self::Sliding => f.write_str("sliding"),
            Self::Dropped => f.write_str("dropped"),
            Self::Overlap(depth) => write!(f, "overlap:{depth}"),
            Self::Pressed(n) => write!(f, "pressed:{n}"),
            Self::Chain(n) => write!(f, "chain:{n}"),
            Self::Bridge(n) => write!(f, "bridge:{n}"),
            Self::Ragdolls(n) => write!(f, "ragdolls:{n}"),
            Self::Busy(busy) => busy.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_there_and_back() {
        for name in [
            "wall:40x25",
            "stack:20",
            "pyramid:5",
            "arch:15",
            "dome:6",
            "castle:8",
            "heap:100",
            "pile:balls:300",
            "pile:hulls:7",
            "dominoes:30",
            "incline:26.4",
            "massratio:100",
            "massratio:1000x3",
            "cardhouse:3",
            "cantilever:4",
            "rocking:8",
            "rolling",
            "sliding",
            "dropped",
            "overlap:0.4",
            "pressed:5",
            "chain:40",
            "bridge:40",
            "ragdolls:100",
        ] {
            assert_eq!(name.parse::<Scene>().unwrap().to_string(), name);
        }
    }

    #[test]
    fn unknown_names_get_the_list() {
        for name in [
            "wal:3x3",
            "wall:3",
            "wall:0x3",
            "stack:",
            "stack:x",
            "rolling:1",
            "massratio:10x0",
            "massratio:x3",
            "cantilever:0",
            "pile:300",
            "pile:bricks:300",
            "pile:balls:0",
            "",
        ] {
            let error = name.parse::<Scene>().unwrap_err().to_string();
            assert!(
                error.contains("cardhouse:N") && error.contains(name),
                "{error}"
            );
        }
    }

    #[test]
    fn absurd_sizes_get_what_is_allowed() {
        for (name, allowed) in [
            ("wall:1000000x1000000", "200000 bodies"),
            ("wall:4294967295x4294967295", "200000 bodies"),
            ("stack:99999999999999999999", "200000 bodies"),
            ("stack:1000000", "200000 bodies"),
            ("pyramid:632", "200000 bodies"),
            ("heap:200001", "200000 bodies"),
            ("cardhouse:4294967295", "200000 bodies"),
            ("pile:balls:200001", "200000 bodies"),
            ("dominoes:200001", "200000 bodies"),
            ("cantilever:200001", "200000 bodies"),
            ("pressed:200001", "200000 bodies"),
            ("ragdolls:13334", "200000 bodies"),
            ("massratio:2x200000", "200000 bodies"),
            ("arch:2", "from 3 to 1000"),
            ("arch:100000", "from 3 to 1000"),
            ("castle:3", "from 4 to 1000"),
            ("incline:1e30", "from -90 to 90"),
            ("incline:nan", "from -90 to 90"),
            ("massratio:-1", "from 0.000001 to 1000000"),
            ("massratio:1e38", "from 0.000001 to 1000000"),
            ("overlap:inf", "from -10 to 1"),
            ("overlap:-1e30", "from -10 to 1"),
        ] {
            let error = name.parse::<Scene>().unwrap_err().to_string();
            assert!(error.contains(allowed) && error.contains(name), "{error}");
        }
        for name in ["wall:1000x100", "pyramid:631", "arch:1000", "massratio:1e6"] {
            name.parse::<Scene>().unwrap();
        }
    }
}
