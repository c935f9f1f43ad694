//! Reflection (feature `bevy_reflect`): the types that inspectors, scenes and the remote protocol see.
//!
//! The [plugins](crate::DrystonePlugins) register what a user reads, edits or saves, and the types in the fields of these: all components
//! of bodies, colliders, joints, mortar, hands, characters and pairs, all settings, messages and reports, and the components of Bevy that
//! bodies have.
//!
//! Types that belong to one world, hold code or threads, or are computed in every step are not reflected: the table of bodies, the
//! broadphase, the constraint graph, islands, the profile, hooks, threads and the log of edits. The list of the [state] says of its types
//! whether they are. A shape is opaque, and is read by its [description](crate::collider::Collider::description). With the feature `serde`
//! the types are also serialized by reflection, as scenes do.

use crate::body::collider::ColliderShape;
use crate::caster::{RayCaster, ShapeCaster};
use crate::collapse::{Collapse, CollapseEnded};
use crate::contact::{ContactEnded, ContactForce, ContactStarted};
use crate::diagnosis::{BodyError, StepError};
use crate::fracture::Fractured;
use crate::joint::JointBroke;
use crate::joint_types::{JointError, types::JointAxes};
use crate::masonry::Laid;
use crate::mortar::MortarBroke;
use crate::query::{Ground, MoveAndSlide};
use crate::sensor::{SensorEntered, SensorExited};
use crate::settings::ContactSolver;
use crate::solve::SolveReports;
use crate::solver::{Nncg, Pgs, SoftStep};
use crate::state;
use bevy_app::App;
use bevy_ecs::hierarchy::Children;

macro_rules! register {
    ($app:expr, $($type:ty),+ $(,)?) => {
        $($app.register_type::<$type>();)+
    };
}

/// Registers them.
pub(crate) fn register(app: &mut App) {
    state::register(app);
    // Types in their fields.
    register!(app, ColliderShape, MoveAndSlide, Ground, JointAxes);
    register!(app, ContactSolver, SoftStep, Pgs, Nncg);
    // Components that are no part of the state.
    register!(app, Laid, Children, RayCaster, ShapeCaster);
    // Messages and reports.
    register!(app, BodyError, StepError, SolveReports);
    register!(app, ContactStarted, ContactEnded, ContactForce);
    register!(app, SensorEntered, SensorExited);
    register!(app, JointBroke, JointError, MortarBroke);
    register!(app, Collapse, CollapseEnded, Fractured);
    #[cfg(feature = "mesh")]
    register!(app, crate::mesh_colliders::MeshColliders);
    #[cfg(feature = "mesh")]
    register!(app, crate::mesh_colliders::MeshCollidersReady);
}
