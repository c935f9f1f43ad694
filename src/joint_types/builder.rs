//! The builder methods that all joint types share.

/// Implements the shared builder methods for a joint type, and [`JointEnds`](super::definition::JointEnds).
macro_rules! joint_builder {
    ($Type:ident) => {
        impl $Type {
            /// With this anchor on body 1, from its origin in its frame, m. If body 1 is the world, it is a point in the world.
            pub fn with_local_anchor1(mut self, anchor: Vec3) -> Self {
                self.frame1.anchor = JointAnchor::Local(anchor);
                self
            }

            /// With this anchor on body 2, from its origin in its frame, m. If body 2 is the world, it is a point in the world.
            pub fn with_local_anchor2(mut self, anchor: Vec3) -> Self {
                self.frame2.anchor = JointAnchor::Local(anchor);
                self
            }

            /// With both anchors at this point of the world (m), on the bodies as they are when the joint is added.
            pub fn with_anchor(mut self, anchor: Vec3) -> Self {
                self.frame1.anchor = JointAnchor::FromGlobal(anchor);
                self.frame2.anchor = JointAnchor::FromGlobal(anchor);
                self
            }

            /// With these axes on body 1: the rotation from the joint's axes to those of the body.
            pub fn with_local_basis1(mut self, basis: Quat) -> Self {
                self.frame1.basis = JointBasis::Local(basis);
                self
            }

            /// With these axes on body 2: the rotation from the joint's axes to those of the body.
            pub fn with_local_basis2(mut self, basis: Quat) -> Self {
                self.frame2.basis = JointBasis::Local(basis);
                self
            }

            /// With these axes on both bodies, as they are when the joint is added: the rotation from the joint's axes to those of the
            /// world.
            pub fn with_basis(mut self, basis: Quat) -> Self {
                self.frame1.basis = JointBasis::FromGlobal(basis);
                self.frame2.basis = JointBasis::FromGlobal(basis);
                self
            }

            /// With this frame on body 1.
            pub fn with_frame1(mut self, frame: JointFrame) -> Self {
                self.frame1 = frame;
                self
            }

            /// With this frame on body 2.
            pub fn with_frame2(mut self, frame: JointFrame) -> Self {
                self.frame2 = frame;
                self
            }

            /// With collision between the two bodies, or without.
            pub fn with_collision(mut self, collision: bool) -> Self {
                self.collision = collision;
                self
            }
        }

        $crate::joint_types::joint_ends!($Type, |joint| joint.collision);
    };
}

/// Implements [`JointEnds`](super::definition::JointEnds) for a joint type with the fields `body1`, `body2`, `frame1` and `frame2`. The
/// last argument says whether its bodies collide.
macro_rules! joint_ends {
    ($Type:ident, |$joint:ident| $collision:expr) => {
        impl $crate::joint_types::JointEnds for $Type {
            fn locked(&self) -> $crate::joint_types::JointDefinition {
                let $joint = self;
                let bodies = [self.body1, self.body2];
                let frames = [self.frame1, self.frame2];
                $crate::joint_types::JointDefinition::locked(bodies, frames, $collision)
            }

            fn set_bodies(&mut self, bodies: [Option<Entity>; 2]) {
                [self.body1, self.body2] = bodies;
            }

            fn set_frames(&mut self, frames: [JointFrame; 2]) {
                [self.frame1, self.frame2] = frames;
            }
        }
    };
}
pub(super) use joint_builder;
pub(crate) use joint_ends;
