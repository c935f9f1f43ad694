//! The polyhedra of a collider, beside its parry shape. The parry shape is used for ray casts, bounding boxes and round shapes.

use super::{ColliderError, Moments, Polyhedron};
use glam::DVec3;
use parry3d::mass_properties::MassProperties;
use parry3d::shape::{ConvexPolyhedron, SharedShape};
use std::sync::Arc;

/// The polyhedra of a collider. A cuboid needs none: it is given by its half extents.
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    /// Parry's alone: curved, composite, a box, or flat.
    Other,
    /// Of a convex hull.
    Hull(Arc<Polyhedron>),
    /// Of each part of a compound.
    Parts(Arc<[Option<Arc<Polyhedron>>]>),
}

impl Solid {
    /// Of a shape that was made by parry. A hull that is none but by parry's rules stays parry's.
    pub fn of(shape: &SharedShape) -> Self {
        let Some(compound) = shape.as_compound() else {
            return hull(shape).map_or(Self::Other, Self::Hull);
        };
        let parts = compound.shapes().iter();
        Self::Parts(parts.map(|(_, part)| hull(part)).collect())
    }

    pub fn hull(&self) -> Option<Arc<Polyhedron>> {
        match self {
            Self::Hull(hull) => Some(hull.clone()),
            _ => None,
        }
    }

    pub fn is_same_hull(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Hull(one), Self::Hull(other)) => one == other,
            _ => false,
        }
    }

    /// Those of hulls, and of compounds with hulls in them; none where parry's are as good.
    pub fn moments(&self, shape: &SharedShape) -> Option<Moments> {
        match self {
            Self::Other => None,
            Self::Hull(hull) => Some(hull.moments()),
            Self::Parts(hulls) => {
                hulls.iter().flatten().next()?;
                let parts = shape.as_compound()?.shapes().iter().zip(&**hulls);
                let moments = parts.map(|((at, part), hull)| {
                    let moments = hull.as_ref().map_or_else(|| doubled(part), |h| h.moments());
                    moments.placed(at.translation.as_dvec3(), at.rotation.as_dquat())
                });
                Some(Moments::sum(&moments.collect::<Vec<_>>()))
            }
        }
    }
}

fn hull(shape: &SharedShape) -> Option<Arc<Polyhedron>> {
    let points = shape.as_convex_polyhedron()?.points();
    Polyhedron::new(points).ok().map(Arc::new)
}

/// Parry's, in double precision.
fn doubled(shape: &SharedShape) -> Moments {
    let unit = shape.mass_properties(1.0);
    let inverse = |x: f32| if x > 0.0 { f64::from(x).recip() } else { 0.0 };
    Moments::new(
        inverse(unit.inv_mass),
        unit.local_com.as_dvec3(),
        DVec3::from_array(unit.inv_principal_inertia.to_array().map(inverse)),
        unit.principal_inertia_local_frame.as_dquat(),
    )
}

/// As parry has them, in single precision.
pub(super) fn rounded(moments: Moments) -> MassProperties {
    let (principal, axes) = moments.principal();
    MassProperties {
        local_com: moments.centroid.as_vec3(),
        inv_mass: moments.volume.recip() as f32,
        inv_principal_inertia: principal.recip().as_vec3(),
        principal_inertia_local_frame: axes.as_quat().normalize(),
    }
}

/// Of the same corners. Parry takes facets up to 1.5° apart for one face; of what has no other edges it makes no face at all, and
/// then panics at the first contact.
///
/// It follows the outlines of its faces from facet to facet, which neither fails nor goes on without end where each edge has two
/// facets that run along it in opposite ways, as those of a [`Polyhedron`] do.
pub(super) fn to_parry(polyhedron: &Polyhedron) -> Result<SharedShape, ColliderError> {
    let points = polyhedron.points.to_vec();
    let count = points.len();
    let triangles: Vec<_> = polyhedron.triangles().map(|t| t.map(u32::from)).collect();
    match ConvexPolyhedron::from_convex_mesh(points, &triangles) {
        None => Err(ColliderError::DegenerateHull),
        Some(hull) if hull.faces().is_empty() => Err(ColliderError::TooManyCorners(count)),
        Some(hull) => Ok(SharedShape::new(hull)),
    }
}

#[cfg(test)]
mod tests {
    use crate::collider::Collider;
    use glam::{Quat, Vec3};
    use parry3d::shape::SharedShape;
    use std::f32::consts::PI;

    /// Two wedges, and a box beside them.
    #[test]
    fn parts_weigh_what_the_whole_does() {
        let wedge = Collider::wedge(1.0, 0.5, 2.0).expect("a wedge");
        let turned = Quat::from_rotation_z(PI);
        let cuboid = Collider::cuboid(1.0, 0.5, 2.0);
        let parts = vec![
            (Vec3::ZERO, Quat::IDENTITY, wedge.clone()),
            (Vec3::ZERO, turned, wedge.clone()),
            (Vec3::X, Quat::IDENTITY, cuboid),
        ];
        let compound = Collider::compound(parts).expect("a compound");
        let [found, expected] =
            [compound.clone(), Collider::cuboid(2.0, 0.5, 2.0)].map(|c| c.mass_properties());
        assert!((found.mass() - expected.mass()).abs() < 1e-5);
        assert!((found.local_com - 0.5 * Vec3::X).length() < 1e-6);
        let inertia = [found, expected].map(|m| m.reconstruct_inertia_matrix());
        assert!(inertia[0].abs_diff_eq(inertia[1], 1e-5), "{inertia:?}");

        assert_eq!(compound.part_polyhedron(1), wedge.polyhedron());
        assert!(compound.part_polyhedron(2).is_none() && compound.part_polyhedron(3).is_none());
        let again = Collider::from(wedge.shape().clone());
        assert_eq!(again.polyhedron(), wedge.polyhedron());
        assert!(
            Collider::from(compound.shape().clone())
                .part_polyhedron(1)
                .is_some()
        );
        assert!(Collider::wedge(1.0, 0.5, 2.0).is_ok_and(|other| other.is_same(&wedge)));
        assert!(
            Collider::from(SharedShape::ball(1.0))
                .polyhedron()
                .is_none()
        );
    }
}
