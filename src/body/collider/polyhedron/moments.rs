//! Volume, centroid and inertia in double precision, because a moment of inertia of a thin solid is a small difference of large numbers.

use super::Polyhedron;
use glam::{DMat3, DQuat, DVec3};

/// Volume, centroid and inertia tensor of a solid at a density of 1 kg/m³, in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Moments {
    /// Volume, m³.
    pub volume: f64,
    /// Centroid in the body's frame, m.
    pub centroid: DVec3,
    /// Inertia tensor about the centroid in the body's axes, m⁵ (kg·m² at 1 kg/m³).
    pub inertia: DMat3,
}

impl Moments {
    /// The moments of a polyhedron: the sum over the tetrahedra between one point and the triangles of the surface (divergence theorem).
    pub(super) fn of(polyhedron: &Polyhedron) -> Self {
        let points = &polyhedron.points;
        let sum: DVec3 = points.iter().map(|p| p.as_dvec3()).sum();
        let origin = sum / points.len() as f64;
        let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
        for triangle in polyhedron.triangles() {
            let [a, b, c] = triangle.map(|i| points[usize::from(i)].as_dvec3() - origin);
            let part = a.dot(b.cross(c)) / 6.0;
            let sum = a + b + c;
            volume += part;
            first += sum * (part / 4.0);
            second += (square(a) + square(b) + square(c) + square(sum)) * (part / 20.0);
        }
        let arm = first / volume;
        let second = second - square(arm) * volume;
        Self {
            volume,
            centroid: origin + arm,
            inertia: inertia(second),
        }
    }

    /// Creates moments from the volume (m³), the centroid (m), the principal moments of inertia (m⁵) and the rotation to the principal
    /// axes.
    pub(crate) fn new(volume: f64, centroid: DVec3, principal: DVec3, axes: DQuat) -> Self {
        let moments = Self {
            volume,
            centroid: DVec3::ZERO,
            inertia: DMat3::from_diagonal(principal),
        };
        Self {
            centroid,
            ..moments.placed(DVec3::ZERO, axes)
        }
    }

    /// The moments of the solid after a rotation and a translation (m).
    pub(crate) fn placed(&self, position: DVec3, rotation: DQuat) -> Self {
        let axes = DMat3::from_quat(rotation);
        Self {
            volume: self.volume,
            centroid: position + rotation * self.centroid,
            inertia: axes * self.inertia * axes.transpose(),
        }
    }

    /// The moments of several parts together.
    pub(crate) fn sum(parts: &[Self]) -> Self {
        let volume: f64 = parts.iter().map(|part| part.volume).sum();
        let first: DVec3 = parts.iter().map(|part| part.volume * part.centroid).sum();
        let centroid = first / volume;
        let about =
            |part: &Self| part.inertia + inertia(square(part.centroid - centroid) * part.volume);
        Self {
            volume,
            centroid,
            inertia: parts.iter().map(about).sum(),
        }
    }

    /// The principal moments of inertia, m⁵, and the rotation from the body's axes to the principal axes.
    ///
    /// Computed with C. G. J. Jacobi's rotations, each of which makes one off-diagonal element zero.
    pub fn principal(&self) -> (DVec3, DQuat) {
        let mut tensor = self.inertia;
        let mut axes = DMat3::IDENTITY;
        let negligible = 1e-15 * tensor.x_axis.x.max(tensor.y_axis.y).max(tensor.z_axis.z);
        for turn in 0..30 {
            let (i, j) = [(0, 1), (0, 2), (1, 2)][turn % 3];
            let off = tensor.col(i)[j];
            if off.abs() <= negligible {
                continue;
            }
            let cotangent = (tensor.col(j)[j] - tensor.col(i)[i]) / (2.0 * off);
            let tangent =
                cotangent.signum() / (cotangent.abs() + (cotangent * cotangent + 1.0).sqrt());
            let cos = (tangent * tangent + 1.0).sqrt().recip();
            let sin = tangent * cos;
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(i)[i] = cos;
            rotation.col_mut(j)[j] = cos;
            rotation.col_mut(i)[j] = -sin;
            rotation.col_mut(j)[i] = sin;
            tensor = rotation.transpose() * tensor * rotation;
            axes *= rotation;
        }
        let moments = DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z);
        (moments, DQuat::from_mat3(&axes).normalize())
    }
}

/// v vᵀ
fn square(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// The inertia tensor, from the second moment ∫ x xᵀ.
fn inertia(second: DMat3) -> DMat3 {
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    DMat3::from_diagonal(DVec3::splat(trace)) - second
}
