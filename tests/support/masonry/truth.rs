//! Contacts of the drawing in place of those that collision detection finds.

use crate::masonry::blocks::{Joint, Masonry};
use crate::masonry::site::Site;
use drystone::body::Pose;
use drystone::contact::{
    ContactAnchors, ContactImpulses, ContactPair, ContactPoint, ContactTargets, Manifold,
    ManifoldPatch,
};
use drystone::narrowphase::polyhedra::FeatureId;
use drystone::settings::{Gravity, NarrowphaseSettings};
use glam::{DQuat, Vec3};

impl Site {
    /// Replaces the contacts that are found in a first step of length zero without weight, and keeps them: manifolds are detected anew only
    /// after a body has moved far, and here no distance counts as far.
    pub fn hold_true_contacts(&mut self) {
        let lab = &mut self.lab;
        let (gravity, dt) = (lab.world.resource::<Gravity>().0, lab.dt);
        lab.world.resource_mut::<Gravity>().0 = Vec3::ZERO;
        let mut settings = lab.world.resource_mut::<NarrowphaseSettings>();
        settings.recycle_share = 1e3;
        lab.dt = 1e-6;
        lab.step();
        lab.dt = dt;
        lab.world.resource_mut::<Gravity>().0 = gravity;
        self.replace_contacts();
    }

    fn replace_contacts(&mut self) {
        let joints = self.masonry.joints();
        let (rotation, poses) = (self.frame.rotation(), self.poses());
        let number = |body| self.bodies.iter().position(|&b| b == body);
        let mut pairs = self.lab.world.query::<(
            &ContactPair,
            &mut Manifold,
            &mut ContactImpulses,
            &mut ContactAnchors,
            &mut ContactTargets,
        )>();
        let mut replaced = 0;
        for (pair, mut manifold, mut impulses, mut anchors, mut targets) in
            pairs.iter_mut(&mut self.lab.world)
        {
            let blocks = pair.bodies.map(|body| number(body).expect("it was built"));
            *manifold = Manifold::default();
            for joint in &joints {
                if joint.blocks == blocks || joint.blocks == [blocks[1], blocks[0]] {
                    *manifold = of(joint, blocks, rotation, &poses);
                    replaced += 1;
                }
            }
            let (points, patches) = (manifold.points.len(), manifold.patches.len());
            // Nothing is carried yet, whatever was.
            impulses.points = vec![Default::default(); points].into();
            impulses.patches = vec![Default::default(); patches].into();
            anchors.points = vec![Default::default(); points];
            anchors.patches = vec![Default::default(); patches].into();
            targets.points = vec![Default::default(); points];
            targets.patches = vec![Default::default(); patches].into();
        }
        assert_eq!(replaced, joints.len(), "each joint has a pair");
    }
}

/// Four corners that touch, between A and B.
fn of(joint: &Joint, blocks: [usize; 2], rotation: DQuat, poses: &[Pose]) -> Manifold {
    let sign = if joint.blocks == blocks { 1.0 } else { -1.0 };
    let mut manifold = Manifold::default();
    for corner in Masonry::joint_corners(joint) {
        let position = (rotation * corner).as_vec3();
        manifold.points.push(ContactPoint {
            arm: position - poses[blocks[0]].position,
            distance: 0.0,
            detected: 0.0,
            feature: FeatureId::NONE,
        });
    }
    let arms = manifold.points.iter().map(|point| point.arm);
    let center = arms.sum::<Vec3>() / 4.0;
    manifold.between = poses[blocks[0]].position - poses[blocks[1]].position;
    manifold.patches.push(ManifoldPatch {
        center,
        normal: (sign * (rotation * joint.normal.extend(0.0))).as_vec3(),
        first: 0,
        count: 4,
        curved: false,
        parts: Default::default(),
        ahead: Vec3::ZERO,
    });
    manifold
}
