//! The impulses of the earlier substeps of a step.
//!
//! During a step with substeps [`ContactImpulses`] holds the impulses of the current substep, which the classification of friction needs.
//! [`Earlier`] holds the sums of the substeps before it.

use super::lists::fit_sums;
use super::{ContactImpulses, ImpulseSum, Manifold, Origins};
use crate::settings::StepTime;
use glam::Vec3;

/// Sums of the impulses of the earlier substeps of a step. Unused without substeps.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Earlier {
    /// One for each point.
    points: Vec<ImpulseSum>,
    /// The sum at points that have ended.
    elsewhere: ImpulseSum,
}

impl Earlier {
    /// Moves the sums after points came, went or changed their indices. Those of points that ended are kept as one sum.
    pub(super) fn reorder(&mut self, origins: &Origins) {
        if self.points.is_empty() {
            return;
        }
        let mut gone = std::mem::take(&mut self.points);
        self.points.extend(origins.iter().map(|origin| {
            let kept = origin.and_then(|i| gone.get_mut(i as usize));
            kept.map(std::mem::take).unwrap_or_default()
        }));
        for lost in gone {
            self.elsewhere.add(lost.normal, lost.tangential);
        }
    }
}

impl ContactImpulses {
    /// The impulse of this step at points that have ended.
    pub(super) fn elsewhere(&self) -> ImpulseSum {
        let earlier = self.earlier.as_ref();
        earlier.map_or(ImpulseSum::default(), |earlier| earlier.elsewhere)
    }

    /// Before detection: adds the impulses of the last substep to the earlier ones. In the first substep there are none, and the sums are
    /// cleared.
    #[inline]
    pub(crate) fn begin_substep(&mut self, time: &StepTime, manifold: &Manifold) {
        if time.substep > 0 {
            self.set_aside(manifold);
        } else if let Some(earlier) = &mut self.earlier {
            earlier.elsewhere = ImpulseSum::default();
            earlier.points.clear();
        }
    }

    fn set_aside(&mut self, manifold: &Manifold) {
        self.fit(manifold);
        let mut earlier = self.earlier.take().unwrap_or_default();
        fit_sums(&mut earlier.points, manifold);
        for (number, patch) in manifold.patches.iter().enumerate() {
            for point in manifold.range(patch) {
                let tangential = self.tangential_at(patch, number, point);
                earlier.points[point].add(self.points[point].normal, tangential);
            }
        }
        self.earlier = Some(earlier);
        self.points.iter_mut().for_each(|point| point.normal = 0.0);
        for point in &mut self.friction {
            point.tangential = Vec3::ZERO;
        }
        for patch in &mut self.patches {
            patch.tangential = Vec3::ZERO;
        }
    }

    /// Adds the earlier impulses to those of the last substep.
    pub(crate) fn add_up(&mut self, manifold: &Manifold) {
        self.fit(manifold);
        let Some(earlier) = &mut self.earlier else {
            return;
        };
        let by_points = !self.friction.is_empty();
        for (patch, whole) in manifold.patches.iter().zip(&mut self.patches) {
            for i in manifold.range(patch) {
                let Some(earlier) = earlier.points.get(i) else {
                    continue;
                };
                self.points[i].normal += earlier.normal;
                match by_points {
                    true => self.friction[i].tangential += earlier.tangential,
                    false => whole.tangential += earlier.tangential,
                }
            }
        }
        earlier.points.clear();
    }
}

impl ImpulseSum {
    fn add(&mut self, normal: f32, tangential: Vec3) {
        self.normal += normal;
        self.tangential += tangential;
    }
}
