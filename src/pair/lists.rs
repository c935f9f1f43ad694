//! The lists that run in parallel with a [`Manifold`]: impulses, targets and anchors, with an entry for each of its points or patches.
//!
//! Their lengths change only here: by [`reorder`] after points were detected anew, and by [`fit`] after other code has changed the length
//! of a list.

use super::{
    ContactAnchors, ContactImpulses, ContactTargets, ImpulseSum, Manifold, Origins, inherit,
};
use smallvec::{Array, SmallVec};

/// The lists of a pair that a stage has access to.
#[derive(Default)]
pub(crate) struct Lists<'a> {
    /// The flag is true if points have friction of their own, as under point solvers.
    pub impulses: Option<(&'a mut ContactImpulses, bool)>,
    /// The flag is true if points have anchors, too.
    pub anchors: Option<(&'a mut ContactAnchors, bool)>,
    /// The flag is true if points have targets, too.
    pub targets: Option<(&'a mut ContactTargets, bool)>,
}

/// Makes the lists as long as those of the manifold. Entries keep their indices; new ones have their default.
#[inline(always)]
pub(crate) fn fit(manifold: &Manifold, lists: Lists) {
    let (points, patches) = (manifold.points.len(), manifold.patches.len());
    if let Some((impulses, by_points)) = lists.impulses {
        set_length(&mut impulses.points, points);
        set_length(&mut impulses.patches, patches);
        // Only point solvers fill this list.
        if by_points || !impulses.friction.is_empty() {
            set_length(&mut impulses.friction, points);
        }
    }
    if let Some((anchors, of_points)) = lists.anchors {
        set_length(&mut anchors.points, if of_points { points } else { 0 });
        set_length(&mut anchors.patches, patches);
    }
    if let Some((targets, of_points)) = lists.targets {
        set_length(&mut targets.patches, patches);
        if of_points {
            set_length(&mut targets.points, points);
        }
    }
}

/// Moves entries to the indices of their points and patches in a manifold that was detected anew; the origins give the index in the old
/// manifold. Entries of new points and patches have their default. The pair gets a new revision, so targets and slips are computed anew.
pub(crate) fn reorder(
    points: &Origins,
    patches: &Origins,
    impulses: &mut ContactImpulses,
    anchors: &mut ContactAnchors,
    targets: &mut ContactTargets,
) {
    inherit(points, &mut impulses.points);
    if !impulses.friction.is_empty() {
        inherit(points, &mut impulses.friction);
    }
    if let Some(earlier) = &mut impulses.earlier {
        earlier.reorder(points);
    }
    inherit(patches, &mut impulses.patches);
    if !anchors.points.is_empty() {
        inherit(points, &mut anchors.points);
    }
    inherit(patches, &mut anchors.patches);
    targets.points.clear();
    targets.patches.clear();
    set_length(&mut targets.patches, patches.len());
}

/// Makes the sums of earlier substeps as long as the list of points.
pub(super) fn fit_sums(sums: &mut Vec<ImpulseSum>, manifold: &Manifold) {
    set_length(sums, manifold.points.len());
}

#[inline(always)]
fn set_length<T: Clone + Default>(list: &mut impl List<T>, length: usize) {
    if list.length() != length {
        list.resize_to(length);
    }
}

/// A list whose length can change.
trait List<T> {
    fn length(&self) -> usize;

    fn resize_to(&mut self, length: usize);
}

impl<T: Clone + Default> List<T> for Vec<T> {
    #[inline(always)]
    fn length(&self) -> usize {
        self.len()
    }

    #[cold]
    fn resize_to(&mut self, length: usize) {
        self.resize(length, T::default());
    }
}

impl<A: Array<Item: Clone + Default>> List<A::Item> for SmallVec<A> {
    #[inline(always)]
    fn length(&self) -> usize {
        self.len()
    }

    #[cold]
    fn resize_to(&mut self, length: usize) {
        self.resize(length, A::Item::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::FeatureId;
    use crate::pair::{ContactPoint, Impulse, ManifoldPatch, Target};
    use glam::Vec3;

    fn manifold(points: usize, patches: usize) -> Manifold {
        let point = ContactPoint {
            arm: Vec3::ZERO,
            distance: 0.0,
            detected: 0.0,
            feature: FeatureId::NONE,
        };
        let patch = ManifoldPatch {
            normal: Vec3::Y,
            center: Vec3::ZERO,
            first: 0,
            count: points as u32,
            curved: false,
            parts: Default::default(),
            ahead: Vec3::ZERO,
        };
        Manifold {
            patches: std::iter::repeat_n(patch, patches).collect(),
            points: std::iter::repeat_n(point, points).collect(),
            between: Vec3::ZERO,
        }
    }

    fn pushed(normal: f32) -> Impulse {
        Impulse {
            normal,
            ..Default::default()
        }
    }

    #[test]
    fn lists_become_as_long_as_the_manifold_and_entries_stay() {
        let mut impulses = ContactImpulses::default();
        let mut anchors = ContactAnchors::default();
        let mut targets = ContactTargets::default();
        impulses.points.push(pushed(3.0));
        targets.points.push(Target::default());
        let lists = Lists {
            impulses: Some((&mut impulses, false)),
            anchors: Some((&mut anchors, true)),
            targets: Some((&mut targets, false)),
        };
        fit(&manifold(4, 2), lists);
        assert_eq!((impulses.points.len(), impulses.patches.len()), (4, 2));
        assert_eq!(impulses.points[0].normal, 3.0);
        assert!(impulses.friction.is_empty());
        assert_eq!((anchors.points.len(), anchors.patches.len()), (4, 2));
        assert_eq!((targets.points.len(), targets.patches.len()), (1, 2));
        let lists = Lists {
            anchors: Some((&mut anchors, false)),
            ..Default::default()
        };
        fit(&manifold(4, 1), lists);
        assert_eq!((anchors.points.len(), anchors.patches.len()), (0, 1));
    }

    #[test]
    fn entries_go_with_their_points() {
        let mut impulses = ContactImpulses::default();
        let mut anchors = ContactAnchors::default();
        let mut targets = ContactTargets::default();
        impulses.points.extend([1.0, 2.0].map(pushed));
        let points = Origins::from_slice(&[None, Some(1), Some(0)]);
        let patches = Origins::from_slice(&[None]);
        reorder(&points, &patches, &mut impulses, &mut anchors, &mut targets);
        let normals = impulses.points.iter().map(|point| point.normal);
        assert_eq!(normals.collect::<Vec<_>>(), [0.0, 2.0, 1.0]);
        assert_eq!((impulses.patches.len(), targets.patches.len()), (1, 1));
        assert!(anchors.points.is_empty());
    }
}
