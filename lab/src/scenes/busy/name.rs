//! Busy scenes by name, there and back.

use super::{Busy, Drive, Hang};
use crate::scenes::SceneError;
use crate::scenes::name::Name;
use std::fmt;
use std::ops::RangeInclusive;

/// Balls along an edge of a net: it is counted in 32 bits.
const EDGES: RangeInclusive<f32> = 2.0..=400.0;
/// Shapes of a body, and cubes along an edge of a clump.
const PARTS: RangeInclusive<f32> = 1.0..=1000.0;
/// m/s; more than the fastest body that is allowed.
const SPEEDS: RangeInclusive<f32> = 0.0..=1000.0;

/// Boxes of a floor.
const FLOOR: RangeInclusive<f32> = 1.0..=1_000_000.0;

/// The scene of a kind, if the kind is one of these.
pub fn parse(name: &Name) -> Option<Result<Busy, SceneError>> {
    let simple: fn(u32) -> Busy = match name.kind {
        "large_pyramid" => Busy::LargePyramid,
        "many_pyramids" => Busy::ManyPyramids,
        "rain" => Busy::Rain,
        "convex_pile" => Busy::ConvexPile,
        "smash" => Busy::Smash,
        "spinner" => Busy::Spinner,
        "washer" => Busy::Washer,
        "junkyard" => Busy::Junkyard,
        "mesh_drop" => Busy::MeshDrop,
        "field_drop" => Busy::FieldDrop,
        "joint_grid" => return Some(joint_grid(name)),
        "tumbler" => return Some(tumbler(name)),
        "compounds" => return Some(parts(name, Busy::Compounds)),
        "voxels" => return Some(parts(name, Busy::Voxels)),
        "large_world" => return Some(bounded(name, name.size, FLOOR).map(Busy::LargeWorld)),
        "flyers" => return Some(flyers(name)),
        _ => return None,
    };
    Some(name.count(name.size).map(simple))
}

fn bounded(name: &Name, text: &str, allowed: RangeInclusive<f32>) -> Result<u32, SceneError> {
    let n = name.count(text)?;
    name.within(n as f32, allowed)?;
    Ok(n)
}

fn joint_grid(name: &Name) -> Result<Busy, SceneError> {
    let (hang, n) = match name.size.split_once(':') {
        None => (Hang::Row, name.size),
        Some(("seven", n)) => (Hang::Seven, n),
        Some(("corner", n)) => (Hang::Corner, n),
        Some(_) => return Err(name.unknown()),
    };
    Ok(Busy::JointGrid(hang, bounded(name, n, EDGES)?))
}

fn tumbler(name: &Name) -> Result<Busy, SceneError> {
    let (drive, n) = match name.size.split_once(':') {
        Some(("kinematic", n)) => (Drive::Kinematic, n),
        Some(("hinge", n)) => (Drive::Hinge, n),
        _ => return Err(name.unknown()),
    };
    Ok(Busy::Tumbler(drive, name.count(n)?))
}

fn parts(name: &Name, of: fn(u32, u32) -> Busy) -> Result<Busy, SceneError> {
    let (n, parts) = name.size.split_once('x').ok_or_else(|| name.unknown())?;
    Ok(of(name.count(n)?, bounded(name, parts, PARTS)?))
}

fn flyers(name: &Name) -> Result<Busy, SceneError> {
    let (n, speed) = name.size.split_once(':').ok_or_else(|| name.unknown())?;
    let speed = name.number(speed, SPEEDS)?;
    Ok(Busy::Flyers(bounded(name, n, PARTS)?, speed))
}

impl fmt::Display for Busy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LargePyramid(n) => write!(f, "large_pyramid:{n}"),
            Self::ManyPyramids(n) => write!(f, "many_pyramids:{n}"),
            Self::JointGrid(Hang::Row, n) => write!(f, "joint_grid:{n}"),
            Self::JointGrid(Hang::Seven, n) => write!(f, "joint_grid:seven:{n}"),
            Self::JointGrid(Hang::Corner, n) => write!(f, "joint_grid:corner:{n}"),
            Self::Rain(n) => write!(f, "rain:{n}"),
            Self::ConvexPile(n) => write!(f, "convex_pile:{n}"),
            Self::Smash(n) => write!(f, "smash:{n}"),
            Self::Spinner(n) => write!(f, "spinner:{n}"),
            Self::Tumbler(Drive::Kinematic, n) => write!(f, "tumbler:kinematic:{n}"),
            Self::Tumbler(Drive::Hinge, n) => write!(f, "tumbler:hinge:{n}"),
            Self::Washer(n) => write!(f, "washer:{n}"),
            Self::Junkyard(n) => write!(f, "junkyard:{n}"),
            Self::MeshDrop(n) => write!(f, "mesh_drop:{n}"),
            Self::FieldDrop(n) => write!(f, "field_drop:{n}"),
            Self::Compounds(n, parts) => write!(f, "compounds:{n}x{parts}"),
            Self::Voxels(n, cubes) => write!(f, "voxels:{n}x{cubes}"),
            Self::LargeWorld(n) => write!(f, "large_world:{n}"),
            Self::Flyers(n, speed) => write!(f, "flyers:{n}:{speed}"),
        }
    }
}
