//! The polyhedra of a collider, which contact detection uses. The parry shape is used for ray casts, bounding boxes and round shapes.

use super::{ColliderError, Moments, Polyhedron};
use glam::{DQuat, DVec3};
use parry3d::mass_properties::MassProperties;
use parry3d::shape::{ConvexPolyhedron, SharedShape};
use std::f64::consts::PI;
use std::sync::Arc;

/// The polyhedra of a collider. A cuboid has none, because its half extents are enough.
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    /// No polyhedron: the shape is curved, a box, a surface, or flat.
    Other,
    /// The polyhedron of a convex hull.
    Hull(Arc<Polyhedron>),
    /// The polyhedron of each part of a compound that is a convex hull.
    Parts(Arc<[Option<Arc<Polyhedron>>]>),
}

impl Solid {
    /// The polyhedra of a parry shape. A hull that is valid only by parry's rules gets none.
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

    /// The moments of a hull, of a rounded box, or of a compound with hulls in it. Returns `None` for other shapes, for which parry's are
    /// accurate.
    pub fn moments(&self, shape: &SharedShape) -> Option<Moments> {
        match self {
            Self::Other => round_cuboid(shape),
            Self::Hull(hull) => Some(hull.moments()),
            Self::Parts(hulls) => {
                let parts = shape.as_compound()?.shapes();
                let is_accurate = parts
                    .iter()
                    .all(|(_, part)| part.as_round_cuboid().is_none());
                if is_accurate && hulls.iter().all(Option::is_none) {
                    return None;
                }
                let parts = parts.iter().zip(&**hulls);
                let moments = parts.map(|((at, part), hull)| {
                    let moments = hull.as_ref().map(|hull| hull.moments());
                    let moments = moments.or_else(|| round_cuboid(part));
                    let moments = moments.unwrap_or_else(|| parry_moments(part));
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

/// The volume of a shape that is neither a hull nor a compound, m³.
pub(crate) fn volume(shape: &SharedShape) -> f32 {
    let moments = round_cuboid(shape).unwrap_or_else(|| parry_moments(shape));
    moments.volume as f32
}

/// The moments that parry computes for a shape, converted to double precision.
pub(super) fn parry_moments(shape: &SharedShape) -> Moments {
    let unit = shape.mass_properties(1.0);
    let inverse = |x: f32| if x > 0.0 { f64::from(x).recip() } else { 0.0 };
    Moments::new(
        inverse(unit.inv_mass),
        unit.local_com.as_dvec3(),
        DVec3::from_array(unit.inv_principal_inertia.to_array().map(inverse)),
        unit.principal_inertia_local_frame.as_dquat(),
    )
}

/// The moments of a rounded box, whose border parry leaves out: those of the inner box, of six slabs on its faces, of a cylinder along each
/// axis, whose quarters lie on four edges, and of a ball, whose eighths lie on the corners.
fn round_cuboid(shape: &SharedShape) -> Option<Moments> {
    let round = shape.as_round_cuboid()?;
    let (h, r) = (
        round.inner_shape.half_extents.as_dvec3(),
        f64::from(round.border_radius),
    );
    let cubed = |length: f64| length * length * length;
    let fourth = (r * r) * (r * r);
    let (area, ball) = (PI * r * r, 4.0 / 3.0 * PI * cubed(r));
    // The second moment ∫x² of what has a constant section from -h to h.
    let even = |volume: f64, h: f64| volume * h * h / 3.0;
    let (mut volume, mut second) = (ball, DVec3::ZERO);
    volume += 8.0 * h.element_product();
    for i in 0..3 {
        let [x, y, z] = [i, (i + 1) % 3, (i + 2) % 3].map(|axis| h[axis]);
        let (slab, cylinder) = (8.0 * r * y * z, 2.0 * x * area);
        let slabs_aside = 8.0 * r * x * (y + z);
        volume += slab + cylinder;
        let core = even(8.0 * h.element_product(), x);
        let slabs = 8.0 * y * z * (cubed(x + r) - cubed(x)) / 3.0 + even(slabs_aside, x);
        let disc = x * x * area + x * 8.0 / 3.0 * cubed(r) + PI * fourth / 4.0;
        let cylinders = even(cylinder, x) + 2.0 * (y + z) * disc;
        let corners = x * x * ball + x * PI * fourth + ball * r * r / 5.0;
        second[i] = core + slabs + cylinders + corners;
    }
    let principal = DVec3::new(
        second.y + second.z,
        second.z + second.x,
        second.x + second.y,
    );
    Some(Moments::new(
        volume,
        DVec3::ZERO,
        principal,
        DQuat::IDENTITY,
    ))
}

/// Converts moments to parry's mass properties, in single precision.
pub(super) fn to_parry_mass(moments: Moments) -> MassProperties {
    let (principal, axes) = moments.principal();
    MassProperties {
        local_com: moments.centroid.as_vec3(),
        inv_mass: moments.volume.recip() as f32,
        inv_principal_inertia: principal.recip().as_vec3(),
        principal_inertia_local_frame: axes.as_quat().normalize(),
    }
}

impl Moments {
    /// As parry's mass properties, in single precision.
    pub(crate) fn rounded(self) -> MassProperties {
        to_parry_mass(self)
    }
}

/// Creates parry's shape with the same corners.
///
/// Parry merges facets up to 1.5° apart into one face. If all edges of a hull are that flat, parry's hull has no face and panics at the
/// first contact, so such a hull is an error.
///
/// Parry follows the outlines of faces from facet to facet. This always terminates, because each edge of a [`Polyhedron`] has two facets
/// that traverse it in opposite directions.
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
    use crate::body::collider::Collider;
    use glam::{Quat, Vec3};
    use parry3d::shape::SharedShape;
    use std::f32::consts::PI;

    #[test]
    fn a_rounded_box_has_the_moments_of_its_border_too() {
        let close = |found: Collider, expected: Collider| {
            let [found, expected] = [found, expected].map(|collider| collider.mass_properties());
            assert!(
                (found.mass() / expected.mass() - 1.0).abs() < 1e-3,
                "{found:?} {expected:?}"
            );
            let [found, expected] = [found, expected].map(|m| m.reconstruct_inertia_matrix());
            let within = 2e-3 * expected.x_axis.x.max(expected.y_axis.y);
            assert!(found.abs_diff_eq(expected, within), "{found} {expected}");
        };
        let ball = Collider::round_cuboid(1e-4, 1e-4, 1e-4, 0.5);
        close(ball, Collider::ball(0.5));
        let cuboid = Collider::round_cuboid(1.0, 0.5, 2.0, 1e-4);
        close(cuboid, Collider::cuboid(1.0002, 0.5002, 2.0002));
        let capsule = Collider::round_cuboid(1e-5, 1.0, 1e-5, 0.3);
        let expected = Collider::capsule(0.3, 1.0);
        close(capsule.clone(), expected.clone());
        let part =
            |collider| Collider::compound(vec![(Vec3::X, Quat::IDENTITY, collider)]).unwrap();
        close(part(capsule), part(expected));
    }

    /// The compound consists of two wedges that form a box, and a box beside them.
    #[test]
    fn a_compound_has_the_moments_of_the_whole() {
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
