//! Convex decomposition: a mesh with hollows as a compound of convex hulls, for dynamic bodies.

use super::{Collider, ColliderError};
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Quat, Vec3};
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

/// How finely [`Collider::convex_decomposition`] divides a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Debug, Default, PartialEq)
)]
pub struct DecompositionSettings {
    /// Number of voxels along the longest side of the mesh. Default: 64. The time grows with its cube.
    pub resolution: u32,
    /// Depth of a hollow that a part may keep, as a share of the size of the mesh. Default: 0.01.
    pub concavity: f32,
    /// Maximum number of parts. Default: 32.
    pub max_parts: u32,
}

impl Default for DecompositionSettings {
    fn default() -> Self {
        Self {
            resolution: 64,
            concavity: 0.01,
            max_parts: 32,
        }
    }
}

impl Collider {
    /// A compound of convex hulls that fills a closed mesh, computed with V-HACD. Unlike [`trimesh`](Self::trimesh) it has an inside and a
    /// mass, so it is for dynamic bodies.
    ///
    /// It takes from a tenth of a second to many seconds: call it when assets are made or loaded, not during a game.
    ///
    /// ```
    /// use drystone::collider::DecompositionSettings;
    /// use drystone::prelude::*;
    ///
    /// // An L of three cubes, from the side.
    /// let outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    /// let vertices: Vec<Vec3> = [0.0, 1.0].iter().flat_map(|&z| outline.map(|(x, y)| Vec3::new(x, y, z))).collect();
    /// let mut triangles = vec![[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]];
    /// triangles.extend([[6, 7, 8], [6, 8, 9], [6, 9, 10], [6, 10, 11]]);
    /// triangles.extend((0..6).flat_map(|i| [[i, (i + 1) % 6, i + 6], [(i + 1) % 6, (i + 1) % 6 + 6, i + 6]]));
    /// let settings = DecompositionSettings { resolution: 32, ..Default::default() };
    /// let l = Collider::convex_decomposition(&vertices, &triangles, &settings).unwrap();
    /// assert!(l.shape().as_compound().unwrap().shapes().len() >= 2);
    /// ```
    ///
    /// # Errors
    /// [`ColliderError::InvalidMesh`] if a vertex is not finite, a triangle names a vertex that does not exist, there are no triangles, or
    /// nothing solid is found; also if a setting is zero or not finite.
    pub fn convex_decomposition(
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        settings: &DecompositionSettings,
    ) -> Result<Self, ColliderError> {
        let invalid = |why: &str| Err(ColliderError::InvalidMesh(why.into()));
        if !vertices.iter().all(|v| v.is_finite()) {
            return invalid("a vertex is not finite");
        }
        let count = vertices.len() as u32;
        if triangles.is_empty() || triangles.iter().flatten().any(|&i| i >= count) {
            return invalid("there are no triangles, or one names a vertex that does not exist");
        }
        let is_sound = settings.concavity.is_finite() && settings.concavity > 0.0;
        if !is_sound || settings.resolution == 0 || settings.max_parts == 0 {
            return invalid("the resolution, concavity and number of parts must be positive");
        }
        let parameters = VHACDParameters {
            resolution: settings.resolution,
            concavity: settings.concavity,
            max_convex_hulls: settings.max_parts,
            ..Default::default()
        };
        let found = VHACD::decompose(&parameters, vertices, triangles, true);
        let hulls = found.compute_exact_convex_hulls(vertices, triangles);
        // Slivers without a volume are left out.
        let parts = hulls.into_iter().filter_map(|(points, _)| {
            let hull = Self::convex_hull(&points).ok()?;
            Some((Vec3::ZERO, Quat::IDENTITY, hull))
        });
        let parts: Vec<_> = parts.collect();
        match parts.is_empty() {
            true => invalid("it encloses no volume"),
            false => Self::compound(parts),
        }
    }
}
