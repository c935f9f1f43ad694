//! The properties that the [`BodyTable`](super::BodyTable) copies.

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
    pub(super) fn shared_default() -> Arc<Self> {
        static DEFAULT: LazyLock<Arc<BodyProperties>> = LazyLock::new(Arc::default);
        DEFAULT.clone()
    }
}
