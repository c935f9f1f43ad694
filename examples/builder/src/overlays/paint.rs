//! Colours of pieces.

use super::{Falls, Legend, Margins, Overlays, Paint};
use crate::look::{Materials, Own};
use bevy::prelude::*;
use drystone::body::BodyIndex;
use drystone::graph::Islands;
use drystone::prelude::*;

type Painted = (
    Entity,
    &'static RigidBody,
    &'static BodyIndex,
    &'static Sleeping,
    &'static Load,
    &'static Own,
    &'static mut MeshMaterial3d<StandardMaterial>,
);

/// Whether a dynamic body sleeps.
#[derive(Clone, Copy)]
enum Rest {
    Awake,
    /// It sleeps beside bodies that are awake or were, and wakes if the forces on it change by some more.
    Touched,
    Asleep,
}

impl Rest {
    fn of(
        kind: RigidBody,
        index: BodyIndex,
        sleeping: &Sleeping,
        islands: &Islands,
    ) -> Option<Self> {
        (kind == RigidBody::Dynamic).then(|| match sleeping.asleep {
            false => Self::Awake,
            true if islands.has_open_account(index.0) => Self::Touched,
            true => Self::Asleep,
        })
    }
}

/// Bodies that would fall have precedence over the chosen colours, and these over bodies that fail first.
pub(super) fn paint(
    overlays: Res<Overlays>,
    materials: Res<Materials>,
    islands: Res<Islands>,
    (falls, margins): (Res<Falls>, Res<Margins>),
    mut legend: ResMut<Legend>,
    mut bodies: Query<Painted>,
) {
    let carries = bodies.iter().map(|body| body.4.supported_weight);
    let most = carries.fold(0.0, f32::max);
    let text = match overlays.paint {
        Paint::Loads => Some(format!("0 to {:.1} kN carried", 1e-3 * most)),
        Paint::Friction => Some("0 to all of the friction used".into()),
        Paint::Islands => Some("a colour for each island that is awake".into()),
        Paint::Sleep => {
            let mut counts = [0; 3];
            for (_, kind, index, sleeping, ..) in &bodies {
                if let Some(rest) = Rest::of(*kind, *index, sleeping, &islands) {
                    counts[rest as usize] += 1;
                }
            }
            let [awake, touched, asleep] = counts;
            Some(format!(
                "{awake} awake: yellow\n{touched} asleep that awake ones have touched: blue\n{asleep} others asleep: grey"
            ))
        }
        Paint::Own => None,
    };
    legend.set_if_neq(Legend(text));
    for (entity, kind, index, sleeping, load, own, mut material) in &mut bodies {
        let is_dynamic = *kind == RigidBody::Dynamic;
        let wanted = if falls.moves(entity) {
            &materials.falls
        } else {
            match overlays.paint {
                // Most pieces carry little: the root spreads them out.
                Paint::Loads if is_dynamic => {
                    materials.shade((load.supported_weight / most.max(1.0)).max(0.0).sqrt())
                }
                Paint::Friction if is_dynamic => materials.shade(load.friction_use),
                Paint::Islands if is_dynamic => match islands.of(index.0) {
                    Some(island) => &materials.hues[island % materials.hues.len()],
                    None => &materials.asleep,
                },
                Paint::Sleep => match Rest::of(*kind, *index, sleeping, &islands) {
                    Some(Rest::Awake) => &materials.awake,
                    Some(Rest::Touched) => &materials.touched,
                    Some(Rest::Asleep) => &materials.asleep,
                    None => &own.0,
                },
                Paint::Own if margins.moves(entity) => &materials.gives,
                _ => &own.0,
            }
        };
        if material.0 != *wanted {
            material.0 = wanted.clone();
        }
    }
}
