//! Mass, inertia and centre of mass: computed from shape and density, or set by hand.

use super::{RigidBody, limits, parts, table};
use crate::body::collider::Collider;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Mat3, Quat, Vec3};

/// Density of a body's material, kg/m³. Default: 1000. A dynamic body whose density is not finite and positive is
/// [quarantined](super::Quarantined).
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct Density(pub f32);

impl Density {
    /// Density of bodies without this component, kg/m³.
    pub const DEFAULT: f32 = 1000.0;
}

/// Sets the mass of a body by hand, kg. Its inertia is scaled in proportion unless [`AngularInertia`] is set too. A dynamic body whose mass
/// is not within [`limits`] is [quarantined](super::Quarantined).
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct Mass(pub f32);

/// Sets the principal moments of inertia of a body by hand, kg·m², about its centre of mass.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct AngularInertia {
    /// Moments about the three principal axes, kg·m².
    pub principal: Vec3,
    /// Rotation from the body's axes to the principal axes.
    pub local_frame: Quat,
}

/// Sets the centre of mass of a body by hand, m, in the body's frame.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct CenterOfMass(pub Vec3);

/// Mass, centre of mass and inertia of a body, as the solver uses them. This component is computed: set [`Density`], [`Mass`],
/// [`AngularInertia`] or [`CenterOfMass`] to change it.
///
/// It is up to date as soon as a body, its shape, a [part](crate::children) or one of these components is inserted. Components that are
/// changed in place or removed take effect in the next step or [`refresh`](crate::refresh()).
///
/// The values are those of the *material*. Static and kinematic bodies keep theirs, so that they can become dynamic again, but the solver
/// treats them as infinitely heavy.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(Component, Debug, Default)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_add = weigh, on_remove = table::lost_description)]
pub struct MassProperties {
    /// Inverse mass, 1/kg.
    pub inverse_mass: f32,
    /// Centre of mass in the body's frame, m.
    pub local_center: Vec3,
    /// Inverse moments about the principal axes, 1/(kg·m²).
    pub inverse_inertia: Vec3,
    /// Rotation from the body's axes to the principal axes.
    pub local_frame: Quat,
}

/// Hook of the components that mass properties depend on: recomputes them on insertion. The stage *prepare* validates the input.
pub(crate) fn weigh(mut world: DeferredWorld, context: HookContext) {
    weigh_above(&mut world, context.entity);
}

/// Recomputes the mass properties of the body that an entity is, or that it is a part of. A part may leave its body before the next step
/// has seen it there, so that step weighs the body once more.
pub(crate) fn weigh_above(world: &mut DeferredWorld, entity: Entity) {
    if let Some(body) = parts::body_of(world, entity) {
        if body == entity {
            weigh_body(world, body);
        } else {
            weigh_with_parts(world, body);
        }
    }
}

/// Recomputes the mass properties of a body that got a part, and has the next step weigh it once more. That of a body with many parts is
/// left to the step: each part that is added would weigh all of them.
pub(crate) fn weigh_with_parts(world: &mut DeferredWorld, body: Entity) {
    if parts::has_few(world, body) {
        weigh_body(world, body);
    }
    parts::mark(world, body);
}

/// Recomputes the mass properties of a body from its components and those of its parts.
pub(crate) fn weigh_body(world: &mut DeferredWorld, entity: Entity) {
    let Ok(body) = world.get_entity(entity) else {
        return;
    };
    let collider = body.get::<Collider>();
    let (Some(kind), false) = (
        body.get::<RigidBody>(),
        collider.is_some_and(Collider::is_degenerate),
    ) else {
        return;
    };
    let (density, mass) = (body.get::<Density>(), body.get::<Mass>());
    let (inertia, center) = (body.get::<AngularInertia>(), body.get::<CenterOfMass>());
    let compound = parts::compound_mass(world, entity);
    let computed = match &compound {
        Some(compound) => compound.mass_properties(density, mass, inertia, center),
        None => MassProperties::new(collider, density, mass, inertia, center),
    };
    // The shape of a compound is made in the next step.
    let collider = collider.filter(|_| compound.is_none());
    let radius = collider.map_or(0.0, |c| c.radius_about(computed.local_center));
    if *kind == RigidBody::Dynamic && !computed.is_valid(radius) {
        return;
    }
    if let Some(mut properties) = world.get_mut::<MassProperties>(entity) {
        properties.set_if_neq(computed);
    }
}

impl MassProperties {
    /// Computes mass properties from a shape and the components set by hand. The result is not finite or not positive if the input is
    /// invalid; the stage *prepare* checks that. A body without a shape counts as a ball of 1 kg and 1 m diameter.
    pub(crate) fn new(
        collider: Option<&Collider>,
        density: Option<&Density>,
        mass: Option<&Mass>,
        inertia: Option<&AngularInertia>,
        center: Option<&CenterOfMass>,
    ) -> Self {
        let unit = match collider {
            // With unit density first, because parry's guards against division by zero would hide an invalid density.
            Some(collider) => collider.mass_properties(),
            None => parry3d::mass_properties::MassProperties::new(
                Vec3::ZERO,
                1.0 / Density::DEFAULT,
                Vec3::splat(0.1 / Density::DEFAULT),
            ),
        };
        Self::of(unit, density, mass, inertia, center)
    }

    /// As [`Self::new`], from the mass properties of a shape at 1 kg/m³.
    pub(crate) fn of(
        unit: parry3d::mass_properties::MassProperties,
        density: Option<&Density>,
        mass: Option<&Mass>,
        inertia: Option<&AngularInertia>,
        center: Option<&CenterOfMass>,
    ) -> Self {
        let density = density.map_or(Density::DEFAULT, |d| d.0);
        let mut inverse_mass = unit.inv_mass / density;
        let mut inverse_inertia = unit.inv_principal_inertia / density;
        let mut local_frame = unit.principal_inertia_local_frame;
        if let Some(mass) = mass {
            let ratio = 1.0 / (mass.0 * inverse_mass);
            inverse_mass = 1.0 / mass.0;
            if ratio.is_finite() {
                inverse_inertia *= ratio;
            }
        }
        if let Some(inertia) = inertia {
            inverse_inertia = inertia.principal.recip();
            local_frame = inertia.local_frame;
        }
        Self {
            inverse_mass,
            local_center: center.map_or(unit.local_com, |c| c.0),
            inverse_inertia,
            local_frame,
        }
    }

    /// Mass, kg; infinite if the inverse mass is 0.
    pub fn mass(&self) -> f32 {
        self.inverse_mass.recip()
    }

    /// Returns true if these are valid for a dynamic body with this bounding radius (m): every number finite, mass and moments positive and
    /// within [`limits`].
    pub fn is_valid(&self, radius: f32) -> bool {
        let masses = limits::HEAVIEST.recip()..=limits::LIGHTEST.recip();
        masses.contains(&self.inverse_mass)
            && self.inverse_inertia.is_finite()
            && self.inverse_inertia.min_element() >= limits::INERTIA.recip()
            && self.inverse_inertia.max_element() * radius * radius
                <= limits::THINNEST * self.inverse_mass
            && self.local_center.is_finite()
            && self.local_frame.is_normalized()
    }

    /// The inverse inertia in world axes of a body with this orientation, 1/(kg·m²).
    ///
    /// It is rounded to 2⁻²² of the largest inverse moment, half a bit more than its accuracy. Bodies at rest rotate to and fro by a
    /// billionth of a degree; with the rounding their inertia stays bitwise equal, so values derived from it need not be computed anew.
    #[inline]
    pub fn world_inverse_inertia(&self, rotation: Quat) -> Mat3 {
        let i = self.inverse_inertia;
        if i.x == i.y && i.y == i.z {
            return Mat3::from_diagonal(i);
        }
        let axes = Mat3::from_quat(rotation * self.local_frame);
        let inertia = Mat3::from_cols(axes.x_axis * i.x, axes.y_axis * i.y, axes.z_axis * i.z)
            * axes.transpose();
        let grid = Vec3::splat(2.0 * i.max_element());
        let round = |column: Vec3| (column + grid) - grid;
        Mat3::from_cols(
            round(inertia.x_axis),
            round(inertia.y_axis),
            round(inertia.z_axis),
        )
    }

    /// Kinetic energy at a velocity, J.
    pub fn kinetic_energy(&self, rotation: Quat, velocity: &super::Velocity) -> f32 {
        if self.inverse_mass == 0.0 {
            return 0.0;
        }
        let spin = (rotation * self.local_frame).inverse() * velocity.angular;
        0.5 * (self.mass() * velocity.linear.length_squared()
            + (spin * spin / self.inverse_inertia).element_sum())
    }
}
