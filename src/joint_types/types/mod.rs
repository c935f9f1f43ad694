//! The joint types. To add one, write its component in a file of its own beside these, and add it to this file
//! (`docs/adding.md` shows how).

mod cylindrical;
mod distance;
mod fixed;
mod generic;
mod joint_type;
mod prismatic;
mod revolute;
mod spherical;
mod spring;

pub use cylindrical::CylindricalJoint;
pub use distance::DistanceJoint;
pub use fixed::FixedJoint;
pub use generic::{GenericJoint, JointAxes};
pub(crate) use joint_type::joint_ends;
pub use prismatic::PrismaticJoint;
pub use revolute::RevoluteJoint;
pub use spherical::SphericalJoint;
pub use spring::SpringJoint;

/// Passes the names of all joint types to a macro.
macro_rules! with_joint_types {
    ($with:ident) => {
        $with! {
            FixedJoint,
            RevoluteJoint,
            PrismaticJoint,
            SphericalJoint,
            DistanceJoint,
            SpringJoint,
            CylindricalJoint,
            GenericJoint,
            MortarJoint,
        }
    };
}
pub(super) use with_joint_types;
