//! The combined surface properties of a contact patch between parts of bodies.

use super::{ContactPair, ManifoldPatch};
use crate::body::collider::{Friction, Restitution, RollingFriction};
use crate::body::{BodyState, BodyTable};
use crate::solver::Both;

/// The combined coefficients of the two surfaces that touch in a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PatchSurface {
    pub friction: f32,
    pub restitution: f32,
    pub rolling_friction: f32,
}

impl ContactPair {
    /// The coefficients in a patch: those of the pair, unless a child collider takes part and no hook set them.
    #[inline]
    pub(crate) fn surface(&self, patch: &ManifoldPatch, table: &BodyTable) -> PatchSurface {
        if !patch.parts.is_whole()
            && !self.hooked()
            && let Some(bodies) = table.both(self.slots)
        {
            return of_parts(bodies, patch);
        }
        self.whole_surface()
    }

    /// As [`Self::surface`], with the two bodies.
    #[inline]
    pub(crate) fn surface_between(
        &self,
        patch: &ManifoldPatch,
        bodies: [&BodyState; 2],
    ) -> PatchSurface {
        match patch.parts.is_whole() || self.hooked() {
            true => self.whole_surface(),
            false => of_parts(bodies, patch),
        }
    }

    fn whole_surface(&self) -> PatchSurface {
        PatchSurface {
            friction: self.friction,
            restitution: self.restitution,
            rolling_friction: self.rolling_friction,
        }
    }
}

#[cold]
fn of_parts(bodies: [&BodyState; 2], patch: &ManifoldPatch) -> PatchSurface {
    let [a, b] = [0, 1].both(|i| surface(bodies[i], patch.parts.get(i)));
    PatchSurface {
        friction: a.0.combine(b.0),
        restitution: a.1.combine(b.1),
        rolling_friction: a.2.combine(b.2),
    }
}

fn surface(body: &BodyState, number: u16) -> (Friction, Restitution, RollingFriction) {
    let part = body.parts.as_ref().and_then(|parts| parts.part(number));
    match part {
        Some(part) => (part.friction, part.restitution, part.rolling),
        None => {
            let own = &body.properties;
            (own.friction, own.restitution, own.rolling)
        }
    }
}
