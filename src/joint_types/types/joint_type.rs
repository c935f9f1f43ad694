//! The parts that all joint types share: the two bodies, their frames, whether they collide, and the builder methods for these.

/// Declares a joint type. The fields of its own stand in the braces, each with its default. The documentation of `new` follows.
macro_rules! joint_type {
    (
        $(#[$about:meta])*
        pub struct $Type:ident {
            $($(#[$about_field:meta])* pub $field:ident: $Kind:ty = $default:expr,)*
        }
        $(#[$about_new:meta])*
        pub fn new;
    ) => {
        $(#[$about])*
        #[derive(bevy_ecs::component::Component, Clone, Debug, PartialEq)]
        #[cfg_attr(feature = "bevy_reflect", derive(bevy_reflect::Reflect), reflect(Component, Debug))]
        #[cfg_attr(
            all(feature = "bevy_reflect", feature = "serde"),
            reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
        )]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[component(on_remove = $crate::joint_types::look_again)]
        #[require($crate::joint_types::JointForces, $crate::body::SpawnOrder)]
        pub struct $Type {
            /// The first body; `None` is the world.
            #[entities]
            pub body1: Option<Entity>,
            /// The second body; `None` is the world.
            #[entities]
            pub body2: Option<Entity>,
            /// The frame on body 1.
            pub frame1: $crate::joint_types::JointFrame,
            /// The frame on body 2.
            pub frame2: $crate::joint_types::JointFrame,
            $($(#[$about_field])* pub $field: $Kind,)*
            /// Whether the two bodies collide with each other. Default: false.
            pub collision: bool,
        }

        impl $Type {
            $(#[$about_new])*
            pub fn new(
                body1: impl Into<Option<Entity>>,
                body2: impl Into<Option<Entity>>,
            ) -> Self {
                Self {
                    body1: body1.into(),
                    body2: body2.into(),
                    frame1: Default::default(),
                    frame2: Default::default(),
                    $($field: $default,)*
                    collision: false,
                }
            }
            /// With this anchor on body 1, from its origin in its frame, m. If body 1 is the world, it is a point in the world.
            pub fn with_local_anchor1(mut self, anchor: glam::Vec3) -> Self {
                self.frame1.anchor = $crate::joint_types::JointAnchor::Local(anchor);
                self
            }

            /// With this anchor on body 2, from its origin in its frame, m. If body 2 is the world, it is a point in the world.
            pub fn with_local_anchor2(mut self, anchor: glam::Vec3) -> Self {
                self.frame2.anchor = $crate::joint_types::JointAnchor::Local(anchor);
                self
            }

            /// With both anchors at this point of the world (m), on the bodies as they are when the joint is added.
            pub fn with_anchor(mut self, anchor: glam::Vec3) -> Self {
                self.frame1.anchor = $crate::joint_types::JointAnchor::FromGlobal(anchor);
                self.frame2.anchor = $crate::joint_types::JointAnchor::FromGlobal(anchor);
                self
            }

            /// With these axes on body 1: the rotation from the joint's axes to those of the body.
            pub fn with_local_basis1(mut self, basis: glam::Quat) -> Self {
                self.frame1.basis = $crate::joint_types::JointBasis::Local(basis);
                self
            }

            /// With these axes on body 2: the rotation from the joint's axes to those of the body.
            pub fn with_local_basis2(mut self, basis: glam::Quat) -> Self {
                self.frame2.basis = $crate::joint_types::JointBasis::Local(basis);
                self
            }

            /// With these axes on both bodies, as they are when the joint is added: the rotation from the joint's axes to those of the
            /// world.
            pub fn with_basis(mut self, basis: glam::Quat) -> Self {
                self.frame1.basis = $crate::joint_types::JointBasis::FromGlobal(basis);
                self.frame2.basis = $crate::joint_types::JointBasis::FromGlobal(basis);
                self
            }

            /// With this frame on body 1.
            pub fn with_frame1(mut self, frame: $crate::joint_types::JointFrame) -> Self {
                self.frame1 = frame;
                self
            }

            /// With this frame on body 2.
            pub fn with_frame2(mut self, frame: $crate::joint_types::JointFrame) -> Self {
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

/// Implements `JointEnds` for a joint type with the fields `body1`, `body2`, `frame1` and `frame2`. The
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

            fn set_frames(&mut self, frames: [$crate::joint_types::JointFrame; 2]) {
                [self.frame1, self.frame2] = frames;
            }
        }
    };
}
pub(crate) use joint_ends;
pub(super) use joint_type;
