//! The properties that the [`BodyTable`](super::BodyTable) copies.

mod contact;
mod dominance;
mod kept_property;
mod locked_axes;
mod max_speed;
mod solver_effort;

pub use contact::{ActiveContactHooks, ContactEvents};
pub use dominance::Dominance;
pub(crate) use kept_property::KeptProperty;
pub use locked_axes::LockedAxes;
pub use max_speed::{MaxAngularSpeed, MaxLinearSpeed};
pub use solver_effort::SolverEffort;

use super::list::{body_properties, names::*};
use std::sync::{Arc, LazyLock};

macro_rules! table_copies {
    (
        essential { $($_essential:tt)* }
        computed { $($_computed:tt)* }
        pushing { $($_pushing:tt)* }
        optional { $($_optional:tt)* }
        described { $($_described:tt)* }
        kept { $($(#[$doc:meta])* $kept:ident: $Kept:ident,)* }
    ) => {
        /// The table's copies of properties. A body without a component has its default value.
        #[derive(Clone, Debug, Default, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct BodyProperties {
            $($(#[$doc])* pub $kept: $Kept,)*
        }
    };
}
body_properties!(table_copies);

impl BodyProperties {
    /// The properties of a body without any of the components, shared by all such bodies.
    pub(in crate::body) fn shared_default() -> Arc<Self> {
        static DEFAULT: LazyLock<Arc<BodyProperties>> = LazyLock::new(Arc::default);
        DEFAULT.clone()
    }
}
