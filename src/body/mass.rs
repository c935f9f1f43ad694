//! Mass, inertia and centre of mass: from shape and density, or set by hand.

use super::{BodyProperty, RigidBody, limits, table};
use crate::collider::Collider;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_reflect::{Reflect, std_traits::ReflectDefault};
use glam::{Mat3, Quat, Vec3};

/// Density of a body's material, kg/m³; 1000 by default.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct Density(pub f32);

impl Density {
    /// kg/m³, of bodies without a [`Density`] of their own.
    pub const DEFAULT: f32 = 1000.0;
}

/// Sets a body's mass by hand, kg. Inertia follows it in proportion unless [`AngularInertia`] is set too.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct Mass(pub f32);

/// Sets a body's principal moments of inertia by hand, kg·m², about its centre of mass.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct AngularInertia {
    /// About the three principal axes, kg·m².
    pub principal: Vec3,
    /// The rotation from the body's axes to the principal ones.
    pub local_frame: Quat,
}

/// Sets a body's centre of mass by hand, m, in the body's frame.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Debug)]
#[component(on_insert = weigh, on_remove = table::lost_description, summary_tick)]
pub struct CenterOfMass(pub Vec3);

impl BodyProperty for Density {}

impl BodyProperty for Mass {}

impl BodyProperty for AngularInertia {}

impl BodyProperty for CenterOfMass {}

/// What the solver needs to know of a body's inertia. Computed; set [`Density`], [`Mass`], [`AngularInertia`] or
/// [`CenterOfMass`] to change it.
///
/// It is known as soon as a body, its shape or one of these is inserted. What is written in place or taken off counts from the next
/// step or [`refresh`](crate::refresh()) on.
///
/// As computed it is that of the *material*. Static and kinematic bodies keep theirs (so that they can become
/// dynamic again) and enter the solver with zeros.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Debug, Default)]
#[component(on_add = weigh, on_remove = table::lost_description)]
pub struct MassProperties {
    /// 1/kg
    pub inverse_mass: f32,
    /// Centre of mass in the body's frame, m.
    pub local_center: Vec3,
    /// About the principal axes, 1/(kg·m²).
    pub inverse_inertia: Vec3,
    /// The rotation from the body's axes to the principal ones.
    pub local_frame: Quat,
}

/// Whatever a body's inertia follows from is inserted: the hook of these components. Invalid input is left to the stage *prepare*.
pub(crate) fn weigh(mut world: DeferredWorld, context: HookContext) {
    let body = world.entity(context.entity);
    let collider = body.get::<Collider>();
    let (Some(kind), false) = (
        body.get::<RigidBody>(),
        collider.is_some_and(Collider::is_degenerate),
    ) else {
        return;
    };
    let computed = MassProperties::new(
        collider,
        body.get::<Density>(),
        body.get::<Mass>(),
        body.get::<AngularInertia>(),
        body.get::<CenterOfMass>(),
    );
    let radius = collider.map_or(0.0, |c| c.radius_about(computed.local_center));
    if *kind == RigidBody::Dynamic && !computed.is_valid(radius) {
        return;
    }
    if let Some(mut properties) = world.get_mut::<MassProperties>(context.entity) {
        properties.set_if_neq(computed);
    }
}

impl MassProperties {
    /// From a shape, and what was set by hand. Not finite or not positive where the input is bad: the stage
    /// *prepare* checks. A body without a shape is a ball of 1 kg and 1 m across, for want of anything better.
    pub(crate) fn new(
        collider: Option<&Collider>,
        density: Option<&Density>,
        mass: Option<&Mass>,
        inertia: Option<&AngularInertia>,
        center: Option<&CenterOfMass>,
    ) -> Self {
        let density = density.map_or(Density::DEFAULT, |d| d.0);
        let unit = match collider {
            // Unit density first: parry would hide a bad density behind its own guards against division by zero.
            Some(collider) => collider.mass_properties(),
            None => parry3d::mass_properties::MassProperties::new(
                Vec3::ZERO,
                1.0 / Density::DEFAULT,
                Vec3::splat(0.1 / Density::DEFAULT),
            ),
        };
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

    /// kg; infinite for a body that has none.
    pub fn mass(&self) -> f32 {
        self.inverse_mass.recip()
    }

    /// True where a dynamic body with this bounding radius (m) can have it: every number finite, mass and moments positive and
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

    /// The inverse inertia in world axes for a body with this orientation, 1/(kg·m²).
    ///
    /// Rounded to 2⁻²² of its greatest moment, half a bit more than it is known to anyway. What rests turns to and fro by a billionth of a
    /// degree; so its inertia stays the same number, and nothing that was made of it must be made anew.
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
