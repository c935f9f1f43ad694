//! Clones that use memory again.

/// Implements `Clone` field by field. Unlike a derived one, its `clone_from` uses the memory of lists again: snapshots of large worlds are taken and
/// restored many times a second.
macro_rules! clone_fields {
    ($Type:ident { $($field:ident),+ $(,)? }) => {
        impl Clone for $Type {
            fn clone(&self) -> Self {
                Self {
                    $($field: self.$field.clone(),)+
                }
            }

            fn clone_from(&mut self, from: &Self) {
                $(self.$field.clone_from(&from.$field);)+
            }
        }
    };
}
pub(crate) use clone_fields;
