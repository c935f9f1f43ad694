//! Part of the stage *contact events*: impulses are the whole step's, whatever the substeps.
//!
//! While substeps go on [`ContactImpulses`] holds those of the one at hand, since that is what classifies friction; what those before
//! it gave waits in a list beside.

use super::{ContactImpulses, Given};
use crate::body::Resting;
use crate::narrowphase::{Origins, inherit};
use crate::settings::StepTime;
use bevy_ecs::prelude::*;
use glam::Vec3;

impl ContactImpulses {
    /// Before contacts are looked for: what the points have goes to what they got earlier; in the first substep nothing did.
    pub(crate) fn begin_substep(&mut self, time: &StepTime) {
        if time.substep == 0 {
            self.elsewhere = Given::default();
            self.earlier.clear();
        } else {
            self.earlier.resize(self.points.len(), Given::default());
            for (earlier, point) in self.earlier.iter_mut().zip(&mut self.points) {
                earlier.add(point.normal, point.tangential);
                (point.normal, point.tangential) = (0.0, Vec3::ZERO);
            }
        }
    }

    /// When points come, go or change places. What those got that go has acted all the same.
    pub(crate) fn reorder(&mut self, origins: &Origins) {
        inherit(origins, &mut self.points);
        if self.earlier.is_empty() {
            return;
        }
        let mut gone = std::mem::take(&mut self.earlier);
        for origin in origins {
            let kept = origin.and_then(|i| gone.get_mut(i as usize));
            self.earlier
                .push(kept.map(std::mem::take).unwrap_or_default());
        }
        for lost in gone {
            self.elsewhere.add(lost.normal, lost.tangential);
        }
    }
}

impl Given {
    fn add(&mut self, normal: f32, tangential: Vec3) {
        self.normal += normal;
        self.tangential += tangential;
    }
}

/// See the module's text.
pub fn whole_step(time: Res<StepTime>, mut pairs: Query<&mut ContactImpulses, Without<Resting>>) {
    if time.substeps == 1 || !time.is_last() {
        return;
    }
    for mut impulses in &mut pairs {
        let impulses = impulses.bypass_change_detection();
        for (earlier, point) in impulses.earlier.drain(..).zip(&mut impulses.points) {
            point.normal += earlier.normal;
            point.tangential += earlier.tangential;
        }
    }
}
