//! Contacts of composite shapes. Parry finds which parts of meshes, height fields and compounds may touch. The contacts of convex parts
//! that are polyhedra, cylinders, cones or two capsules are computed here ([`polyhedra`](super::polyhedra), [`round`](super::round),
//! [`capsules`]), all others by parry.

use super::capsules;
use super::forms::{Form, WithTwo, ours, with_two};
use super::polyhedra::{Axis, Contact, Placement, Search, Solid, separate, touch, touch_along};
use super::round::{self, Found, Part};
use crate::body::BodyState;
use crate::pair::ParryManifold;
use glam::{DVec3, Vec3};
use parry3d::math::Pose;
use parry3d::query::details::*;
use parry3d::query::*;
use parry3d::shape::{PackedFeatureId, Shape, ShapeType};

/// Computes the contacts of the parts of two bodies.
pub(super) struct Dispatcher<'a> {
    pub bodies: [&'a BodyState; 2],
    /// See [`Search::graze`], m.
    pub graze: f32,
    /// Maximum number of points of a patch.
    pub most: usize,
    /// Manifolds of the last detection that parry does not know of.
    pub kept: &'a [ParryManifold],
}

impl PersistentQueryDispatcher<Axis, ()> for Dispatcher<'_> {
    fn contact_manifolds(
        &self,
        place: &Pose,
        a: &dyn Shape,
        b: &dyn Shape,
        reach: f32,
        manifolds: &mut Vec<ParryManifold>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        use ShapeType::{HeightField, TriMesh, Voxels};
        let back = place.inverse();
        let kinds = [a.shape_type(), b.shape_type()];
        let parts = [a.as_composite_shape(), b.as_composite_shape()];
        match (kinds, parts) {
            ([Voxels, _] | [_, Voxels], _) => {
                return DefaultQueryDispatcher
                    .contact_manifolds(place, a, b, reach, manifolds, workspace);
            }
            (_, [Some(of_a), Some(of_b)]) => contact_manifolds_composite_shape_composite_shape(
                self, place, of_a, of_b, reach, manifolds, workspace,
            ),
            ([TriMesh, _] | [_, TriMesh], _) => contact_manifolds_trimesh_shape_shapes(
                self, place, a, b, reach, manifolds, workspace,
            ),
            ([HeightField, _], [_, Some(of_b)]) => {
                let field = a.as_heightfield().ok_or(Unsupported)?;
                contact_manifolds_heightfield_composite_shape(
                    self, place, &back, field, of_b, reach, manifolds, workspace, false,
                );
            }
            ([_, HeightField], [Some(of_a), _]) => {
                let field = b.as_heightfield().ok_or(Unsupported)?;
                contact_manifolds_heightfield_composite_shape(
                    self, &back, place, field, of_a, reach, manifolds, workspace, true,
                );
            }
            ([HeightField, _] | [_, HeightField], _) => contact_manifolds_heightfield_shape_shapes(
                self, place, a, b, reach, manifolds, workspace,
            ),
            (_, [Some(of_a), None]) => contact_manifolds_composite_shape_shape(
                self, place, of_a, b, reach, manifolds, workspace, false,
            ),
            (_, [None, Some(of_b)]) => contact_manifolds_composite_shape_shape(
                self, &back, of_b, a, reach, manifolds, workspace, true,
            ),
            _ => {
                if manifolds.is_empty() {
                    manifolds.push(ContactManifold::new());
                }
                let [only, ..] = &mut manifolds[..] else {
                    return Err(Unsupported);
                };
                return self.contact_manifold_convex_convex(place, a, b, None, None, reach, only);
            }
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        place: &Pose,
        a: &dyn Shape,
        b: &dyn Shape,
        normals_a: Option<&dyn NormalConstraints>,
        normals_b: Option<&dyn NormalConstraints>,
        reach: f32,
        manifold: &mut ParryManifold,
    ) -> Result<(), Unsupported> {
        self.touch(place, [a, b], (normals_a, normals_b), reach, manifold)?;
        Ok(())
    }
}

/// What keeps the normals of two parts, if they belong to surfaces.
type Normals<'a> = (
    Option<&'a dyn NormalConstraints>,
    Option<&'a dyn NormalConstraints>,
);

impl Dispatcher<'_> {
    /// Computes the contact of two convex parts. Returns a lower bound of their distance, m; −∞ if none is known.
    pub fn touch(
        &self,
        place: &Pose,
        [a, b]: [&dyn Shape; 2],
        normals: Normals,
        reach: f32,
        manifold: &mut ParryManifold,
    ) -> Result<f32, Unsupported> {
        let parts = |of: &ParryManifold| [of.subshape1, of.subshape2];
        let known = parts(manifold);
        if let Some(kept) = self.kept.iter().find(|kept| parts(kept) == known) {
            manifold.clone_from(kept);
        }
        if let [Some(a), Some(b)] = [a.as_capsule(), b.as_capsule()] {
            capsules::touch(place, a, b, reach, manifold);
            return Ok(f32::NEG_INFINITY);
        }
        let [body_a, body_b] = self.bodies;
        let form_a = Form::of_part(body_a, a, manifold.subshape1);
        let form_b = Form::of_part(body_b, b, manifold.subshape2);
        let [Some(form_a), Some(form_b)] = ours(&form_a, &form_b) else {
            let parry = DefaultQueryDispatcher;
            return parry
                .contact_manifold_convex_convex(place, a, b, normals.0, normals.1, reach, manifold)
                .map(|()| f32::NEG_INFINITY);
        };
        let graze = match [a.shape_type(), b.shape_type()].contains(&ShapeType::Triangle) {
            // Triangles of a surface always have a neighbour at their edges, so the test for seams does not apply.
            true => f64::NEG_INFINITY,
            false => self.graze as f64,
        };
        let mut axis = manifold.data;
        let mut contact = Contact::default();
        let mut apart = f32::NEG_INFINITY;
        let parts = Parts {
            place,
            normals,
            search: Search {
                reach: reach as f64,
                graze,
            },
            axis: &mut axis,
            contact: &mut contact,
            apart: &mut apart,
        };
        if form_a.is_round() || form_b.is_round() {
            parts.with_round(form_a, form_b);
            // Reduce the points to as many as a whole body may have.
            let radius = body_a.rolling_radius().min(body_b.rolling_radius());
            round::simplify(&mut contact, self.most, radius, |_| false);
        } else {
            with_two(form_a, form_b, parts);
        }
        manifold.data = axis;
        manifold.points.clear();
        let single = |v: DVec3| v.as_vec3();
        manifold.local_n1 = single(-contact.normal);
        manifold.local_n2 = place.rotation.inverse() * single(contact.normal);
        manifold.points.extend(contact.points.iter().map(|point| {
            let half = contact.normal * (0.5 * point.distance);
            TrackedContact::new(
                single(point.position + half),
                place.inverse_transform_point(single(point.position - half)),
                PackedFeatureId(point.feature.0),
                PackedFeatureId::UNKNOWN,
                point.distance as f32,
            )
        }));
        Ok(apart)
    }
}

/// Two parts that may touch.
struct Parts<'a> {
    place: &'a Pose,
    normals: Normals<'a>,
    search: Search,
    axis: &'a mut Axis,
    contact: &'a mut Contact,
    /// Lower bound of their distance, m. It is only set if they are out of reach.
    apart: &'a mut f32,
}

impl Parts<'_> {
    fn place(&self) -> Placement {
        let rotation = self.place.rotation.as_dquat().normalize();
        Placement::new(self.place.translation.as_dvec3(), rotation)
    }

    /// The normal, or at an inner edge of a surface the normal of the faces there, because an inner edge must not be hit by itself. `None`
    /// if there is no contact.
    fn constrained(&self, normal: DVec3) -> Option<DVec3> {
        let single = normal.as_vec3();
        let mut of_a = single;
        let mut of_b = self.place.rotation.inverse() * -single;
        let counts = self
            .normals
            .project_local_normals(self.place, &mut of_a, &mut of_b);
        counts.then(|| match of_a == single {
            true => normal,
            false => of_a.as_dvec3().normalize(),
        })
    }

    fn with_round(self, a: &Form, b: &Form) {
        let [a, b] = Part::two(a, b, self.place());
        let Ok(found) = round::separate(&a, &b, self.search.reach, None) else {
            return;
        };
        if let Some(normal) = self.constrained(found.normal) {
            // Along another normal only faces may touch: the nearest points are those of the edge, and so is their distance.
            let distance = match normal == found.normal {
                true => found.distance,
                false => f64::INFINITY,
            };
            let found = Found {
                normal,
                distance,
                ..found
            };
            round::touch(&a, &b, &found, self.search.reach, self.contact);
        }
    }
}

impl WithTwo for Parts<'_> {
    fn with<A: Solid, B: Solid>(self, a: &A, b: &B) {
        let place = self.place();
        let found = separate(a, b, &place, self.search.reach, *self.axis);
        *self.axis = found.best.axis;
        if found.best.distance > self.search.reach {
            *self.apart = found.best.distance as f32;
            return;
        }
        let Some(normal) = self.constrained(found.best.normal) else {
            return;
        };
        if normal == found.best.normal {
            *self.axis = touch(a, b, &place, &found, self.search, self.contact);
        } else {
            touch_along(a, b, &place, normal, self.search.reach, self.contact);
        }
    }
}

impl QueryDispatcher for Dispatcher<'_> {
    fn intersection_test(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        Err(Unsupported)
    }

    fn distance(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
    ) -> Result<ShapeDistance, Unsupported> {
        Err(Unsupported)
    }

    fn contact(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: f32,
    ) -> Result<Option<parry3d::query::Contact>, Unsupported> {
        Err(Unsupported)
    }

    fn closest_points(
        &self,
        _: &Pose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: f32,
    ) -> Result<ClosestPoints, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes(
        &self,
        _: &Pose,
        _: Vec3,
        _: &dyn Shape,
        _: &dyn Shape,
        _: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes_nonlinear(
        &self,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: f32,
        _: f32,
        _: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }
}
