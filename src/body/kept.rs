//! The properties that the [`BodyTable`](super::BodyTable) copies.

use super::list::{body_properties, names::*};

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
        pub struct BodyProperties {
            $($(#[$doc])* pub $kept: $Kept,)*
        }
    };
}
body_properties!(table_copies);
