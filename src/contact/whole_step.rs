//! Part of the stage *contact events*: makes impulses those of the whole step, whatever the number of substeps.

use crate::graph::ConstraintGraph;
use crate::pair::PairsMut;
use crate::settings::StepTime;
use bevy_ecs::prelude::*;

/// Whether the last substep of several has ended.
#[doc(hidden)]
pub fn any_earlier_substeps(time: Res<StepTime>) -> bool {
    time.substeps > 1 && time.is_last()
}

/// After the last substep, adds the impulses of the earlier ones to those of the last.
pub fn whole_step(graph: Res<ConstraintGraph>, mut pairs: PairsMut) {
    let mut active = pairs.iter_many_mut(graph.active_pairs());
    while let Some(pair) = active.fetch_next() {
        if let Ok((_, (_, _, manifold, mut impulses, ..))) = pair {
            impulses.bypass_change_detection().add_up(&manifold);
        }
    }
}
