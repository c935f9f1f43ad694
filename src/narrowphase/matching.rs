//! Matching of contact points with those of the last step: first by their features, then by distance to the points that either body has
//! carried along. Matched points inherit impulses, sticking and anchors.

use super::polyhedra::FeatureId;
use crate::pair::{ContactPoint, Manifold, ManifoldPatch, Origins};
use glam::Quat;
use smallvec::SmallVec;

/// Matches the points of a manifold with those of the last one: first points with the same feature, then points that are nearer to each
/// other than `radius` (m). `turns` are the rotations of A and B since then.
pub(crate) fn match_points(
    old: &Manifold,
    new: &Manifold,
    turns: [Quat; 2],
    radius: f32,
) -> Origins {
    let mut origins: Origins = smallvec::smallvec![None; new.points.len()];
    let mut taken: SmallVec<[bool; 8]> = smallvec::smallvec![false; old.points.len()];
    for (point, origin) in new.points.iter().zip(&mut origins) {
        let same = |i: &usize| !taken[*i] && old.points[*i].feature == point.feature;
        let before = (0..old.points.len()).find(same);
        if point.feature != FeatureId::NONE
            && let Some(i) = before
        {
            taken[i] = true;
            *origin = Some(i as u16);
        }
    }
    for (point, origin) in new.points.iter().zip(&mut origins) {
        if origin.is_some() {
            continue;
        }
        let gap = |before: &ContactPoint| {
            let a = (turns[0] * before.arm).distance_squared(point.arm);
            let on_b = turns[1] * (before.arm + old.between);
            a.min(on_b.distance_squared(point.arm + new.between))
        };
        let nearest = (0..old.points.len())
            .filter(|&i| !taken[i])
            .map(|i| (gap(&old.points[i]), i))
            .min_by(|x, y| x.0.total_cmp(&y.0));
        if let Some((gap, i)) = nearest
            && gap < radius * radius
        {
            taken[i] = true;
            *origin = Some(i as u16);
        }
    }
    origins
}

/// Two patches may be the same if the cosine between their normals is above this.
const SAME_PATCH: f32 = 0.9;

/// Returns for each new patch the index of the old patch with the nearest normal.
pub(crate) fn match_patches(old: &Manifold, new: &Manifold) -> Origins {
    let mut taken: SmallVec<[bool; 8]> = smallvec::smallvec![false; old.patches.len()];
    let origin = |patch: &ManifoldPatch| {
        let along = |i: usize| old.patches[i].normal.dot(patch.normal);
        let nearest = (0..old.patches.len())
            .filter(|&i| !taken[i] && along(i) > SAME_PATCH)
            .max_by(|&i, &j| along(i).total_cmp(&along(j)))?;
        taken[nearest] = true;
        Some(nearest as u16)
    };
    new.patches.iter().map(origin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::inherit;
    use glam::Vec3;

    fn manifold(xs: &[f32]) -> Manifold {
        let point = |&x: &f32| ContactPoint {
            arm: Vec3::X * x,
            distance: 0.0,
            detected: 0.0,
            feature: FeatureId::NONE,
        };
        Manifold {
            patches: Default::default(),
            points: xs.iter().map(point).collect(),
            between: Vec3::ZERO,
        }
    }

    #[test]
    fn nearest_points_inherit_and_each_old_point_serves_once() {
        let (old, new) = (manifold(&[0.0, 1.0]), manifold(&[0.99, 0.02, 0.01, 5.0]));
        let origins = match_points(&old, &new, [Quat::IDENTITY; 2], 0.1);
        assert_eq!(origins.as_slice(), [Some(1), Some(0), None, None]);
        let mut kept: SmallVec<[u32; 4]> = smallvec::smallvec![7, 8];
        inherit(&origins, &mut kept);
        assert_eq!(kept.as_slice(), [8, 7, 0, 0]);
    }
}
