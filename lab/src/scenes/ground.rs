//! The ground of scenes.

use drystone::collider::Collider;
use glam::Vec3;
use std::fmt;
use std::str::FromStr;

/// A plane, y = 0, in one form or another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ground {
    /// All below it.
    #[default]
    HalfSpace,
    /// A triangle mesh of 64 × 64 squares of 2 m.
    Mesh,
    /// A height field of as many.
    HeightField,
}

/// Squares along an edge, and the length of one, m.
const SQUARES: u32 = 64;
const LENGTH: f32 = 2.0;

impl Ground {
    const ALL: [(Self, &str); 3] = [
        (Self::HalfSpace, "half-space"),
        (Self::Mesh, "mesh"),
        (Self::HeightField, "height-field"),
    ];

    /// Its shape, its middle at the origin.
    pub fn collider(self) -> Collider {
        match self {
            Self::HalfSpace => Collider::half_space(Vec3::Y),
            Self::Mesh => mesh(),
            Self::HeightField => {
                let heights = vec![vec![0.0; SQUARES as usize + 1]; SQUARES as usize + 1];
                let edge = SQUARES as f32 * LENGTH;
                Collider::height_field(&heights, Vec3::new(edge, 1.0, edge))
                    .expect("a field of finite heights")
            }
        }
    }
}

fn mesh() -> Collider {
    let along = SQUARES + 1;
    let middle = 0.5 * SQUARES as f32;
    let corner = |i: u32| {
        let (x, z) = ((i % along) as f32, (i / along) as f32);
        LENGTH * Vec3::new(x - middle, 0.0, z - middle)
    };
    let square = |i: u32| {
        let a = i / SQUARES * along + i % SQUARES;
        let (b, c, d) = (a + 1, a + along, a + along + 1);
        [[a, c, b], [b, c, d]]
    };
    let triangles = (0..SQUARES * SQUARES).flat_map(square).collect();
    Collider::trimesh((0..along * along).map(corner).collect(), triangles)
        .expect("triangles of corners that there are")
}

impl FromStr for Ground {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let known = Self::ALL.iter().find(|(_, known)| *known == name);
        known.map(|(ground, _)| *ground).ok_or_else(|| {
            let known = Self::ALL.map(|(_, name)| name).join(", ");
            format!("no ground `{name}`; known: {known}")
        })
    }
}

impl fmt::Display for Ground {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mine = Self::ALL.iter().find(|(ground, _)| ground == self);
        f.write_str(mine.map_or("", |(_, name)| name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use drystone::settings::Preset;

    #[test]
    fn names_go_there_and_back() {
        for (ground, name) in Ground::ALL {
            assert_eq!(
                (name.parse(), ground.to_string()),
                (Ok(ground), name.into())
            );
        }
        let error = "sand".parse::<Ground>().unwrap_err();
        assert!(
            error.contains("sand") && error.contains("height-field"),
            "{error}"
        );
    }

    #[test]
    fn a_stack_stands_on_each() {
        for (ground, name) in Ground::ALL {
            let scene = "stack:3".parse().unwrap();
            let mut experiment = Experiment::new(scene, Preset::Default);
            experiment.options.ground = ground;
            let found = experiment.run(120).displacement;
            assert!(found.drift < 1e-3 && found.sag < 1e-3, "{name}: {found:?}");
        }
    }
}
