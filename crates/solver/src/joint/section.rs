//! The section of a bonded patch: the stresses in it, and the stresses at which it breaks.
//!
//! The bodies are rigid and the bond between them is thin and even, so the stress is linear over the patch: σ = N/A plus M/W about each of
//! its principal axes, as in a beam; τ = V/A plus T·r/I_p.

#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::{Vec2, Vec3};

/// A bonded patch, in the frame of its joint on A: x is the normal, from A to B; y and z are the principal axes of its area; the origin is
/// its centroid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Section {
    /// Area, m².
    pub area: f32,
    /// ∫y² and ∫z² over the area, m⁴.
    pub inertia: Vec2,
    /// Corners, y and z, m.
    pub corners: [Vec2; 4],
    /// Tensile strength, Pa.
    pub tension: f32,
    /// Shear strength without pressure, Pa.
    pub cohesion: f32,
    /// Shear strength gained per pressure.
    pub friction: f32,
}

/// How mortar broke.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MortarFailure {
    /// The tension at a corner of the patch exceeded the tensile strength: it was pulled or bent.
    #[default]
    Tension,
    /// The shear stress at a corner exceeded the shear strength: it was pushed sideways or twisted.
    Shear,
    /// An edit moved its bodies apart.
    Misfit,
}

/// How near a section is to breaking.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Utilization {
    /// Stress over strength; it breaks above 1.
    pub share: f32,
    /// The stress, Pa.
    pub stress: f32,
    /// The kind of stress.
    pub how: MortarFailure,
}

impl Section {
    /// Whether it has an area and strengths that are numbers.
    pub fn is_valid(&self) -> bool {
        let strengths = [self.tension, self.cohesion, self.friction];
        let sizes = [self.area, self.inertia.x, self.inertia.y];
        // A comparison with NaN is false.
        strengths.iter().all(|&strength| strength >= 0.0)
            && sizes.iter().all(|&size| size > 0.0 && size.is_finite())
    }

    /// The utilization by a force (N) and a torque (N·m) on B at the origin.
    pub fn utilization(&self, [force, torque]: [Vec3; 2]) -> Utilization {
        let pressure = force.x / self.area;
        let slope = Vec2::new(torque.z, -torque.y) / self.inertia;
        let pull = -pressure + self.most(|corner| slope.dot(corner));
        let even = Vec2::new(force.y, force.z) / self.area;
        let twist = torque.x / self.inertia.element_sum();
        let shear = self.most(|corner| (even + twist * corner.perp()).length());
        let strength = (self.cohesion + self.friction * pressure).max(0.0);
        let tension = Utilization {
            share: share(pull.max(0.0), self.tension),
            stress: pull,
            how: MortarFailure::Tension,
        };
        let shear = Utilization {
            share: share(shear, strength),
            stress: shear,
            how: MortarFailure::Shear,
        };
        if shear.share > tension.share {
            shear
        } else {
            tension
        }
    }

    /// The stiffness of a bond of even stiffness per area against a coordinate of its joint, per that stiffness: the area for translations,
    /// m², and the moments of the area for rotations, m⁴.
    pub fn stiffness(&self, coordinate: usize) -> f32 {
        match coordinate {
            3 => self.inertia.element_sum(),
            4 => self.inertia.y,
            5 => self.inertia.x,
            _ => self.area,
        }
    }

    fn most(&self, of: impl Fn(Vec2) -> f32) -> f32 {
        self.corners.into_iter().map(of).fold(f32::MIN, f32::max)
    }
}

fn share(stress: f32, strength: f32) -> f32 {
    match stress > 0.0 {
        true => stress / strength.max(f32::MIN_POSITIVE),
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.4 m high (y) and 0.3 m deep (z).
    fn section() -> Section {
        let [h, d] = [0.4, 0.3];
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        Section {
            area: h * d,
            inertia: Vec2::new(d * h * h * h, h * d * d * d) / 12.0,
            corners: corners.map(|[y, z]| 0.5 * Vec2::new(y * h, z * d)),
            tension: 1e5,
            cohesion: 2e5,
            friction: 0.5,
        }
    }

    #[test]
    fn stresses_are_those_of_a_beam() {
        let section = section();
        let of = |force: [f32; 3], torque: [f32; 3]| {
            section.utilization([Vec3::from(force), Vec3::from(torque)])
        };
        let near = |found: Utilization, stress: f32, share: f32, is_shear: bool| {
            let how = match is_shear {
                true => MortarFailure::Shear,
                false => MortarFailure::Tension,
            };
            assert!(
                (found.stress / stress - 1.0).abs() < 1e-4
                    && (found.share / share - 1.0).abs() < 1e-4
                    && found.how == how,
                "{found:?}"
            );
        };
        // Pulled.
        near(of([-6e3, 0.0, 0.0], [0.0; 3]), 5e4, 0.5, false);
        // Bent about z, in either direction: W = d h²/6 = 0.008 m³.
        near(of([0.0; 3], [0.0, 0.0, 400.0]), 5e4, 0.5, false);
        near(of([0.0; 3], [0.0, 0.0, -400.0]), 5e4, 0.5, false);
        // About both axes, and pressed: W = h d²/6 = 0.006 m³ about y.
        near(of([3.6e3, 0.0, 0.0], [0.0, -300.0, 400.0]), 7e4, 0.7, false);
        // Sheared under a pressure of 1e5 Pa.
        near(of([1.2e4, 0.0, 9e3], [0.0; 3]), 7.5e4, 0.3, true);
        // Twisted: I_p = 0.0025 m⁴, r = 0.25 m.
        near(of([0.0; 3], [1e3, 0.0, 0.0]), 1e5, 0.5, true);
        // Pressure alone does not break it.
        assert_eq!(of([1e9, 0.0, 0.0], [0.0; 3]).share, 0.0);
    }
}
