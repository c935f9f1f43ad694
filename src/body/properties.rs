//! The list of the properties of a body: the macro that expands the list in `mod.rs`, and the traits of the components on it.
//!
//! A property is a component that a user may write. It has a line in the list, and its behaviour is defined next to it ([`BodyProperty`],
//! [`KeptProperty`]). The macro generates from the list
//! - the required components of a [`RigidBody`](super::RigidBody), and the components that are restored when they are removed,
//! - the change detection of active bodies (`Changes`) and of inactive ones (`Written`),
//! - the properties that the [`BodyTable`](super::BodyTable) copies ([`BodyProperties`](super::BodyProperties)),
//! - the components that a preview copies and those that belong to the [state](crate::state) of a world.
//!
//! A component whose removal must be noticed has the hook [`lost_description`](super::lost_description).

use super::BodyState;
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;

/// A component that describes a body and that a user may write.
pub(crate) trait BodyProperty: Component + Clone {
    /// Returns true if the table has this value already. Writing an equal value does not activate an inactive body.
    fn is_known(&self, _: &BodyState) -> bool {
        false
    }
}

/// A property that the table copies. A body without the component has the default value.
pub(crate) trait KeptProperty: BodyProperty + Default + PartialEq {
    /// Validates the value.
    ///
    /// # Errors
    /// If the value is invalid. The body is then quarantined.
    fn check(&self) -> Result<(), BodyProblem> {
        Ok(())
    }
}

/// Declares `RigidBody` and all items that are generated from the list of its properties.
///
/// | group | required | restored when removed | checked when written |
/// |---|---|---|---|
/// | `essential` | yes | yes | on inactive bodies; the stages read it of active ones in every step |
/// | `computed` | yes | yes | no: stages write it |
/// | `pushing` | yes | no | like `essential` |
/// | `optional` | no | no | like `essential` |
/// | `described` | no | no | on all; [`describe`](super::describe) reads it |
/// | `kept` | no | no | on all; the table keeps a copy |
macro_rules! body_properties {
    (
        $(#[$meta:meta])*
        pub enum RigidBody { $($variants:tt)* }
        essential { $($essential:ident: $Essential:ident,)* }
        computed { $($computed:ident: $Computed:ident,)* }
        pushing { $($pushing:ident: $Pushing:ident,)* }
        optional { $($optional:ident: $Optional:ident,)* }
        described { $($described:ident: $Described:ident,)* }
        kept { $($(#[$doc:meta])* $kept:ident: $Kept:ident,)* }
    ) => {
        $(#[$meta])*
        #[require($($Essential,)* $($Computed,)* $($Pushing,)* Transform)]
        pub enum RigidBody { $($variants)* }

        /// The table's copies of properties. A body without a component has its default value.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct BodyProperties {
            $($(#[$doc])* pub $kept: $Kept,)*
        }

        $(impl properties::BodyProperty for $Kept {
            fn is_known(&self, body: &BodyState) -> bool {
                body.properties.$kept == *self
            }
        })*

        /// Items generated from the list.
        mod listed {
            use super::*;
            use super::inactive::Rows;
            use crate::diagnosis::BodyProblem;
            use bevy_ecs::{hierarchy::ChildOf, query::QueryData};

            /// Filter for bodies that lack a component that every body must have.
            pub type Incomplete = (
                With<RigidBody>,
                Or<($(Without<$Essential>,)* $(Without<$Computed>,)* Without<Transform>)>,
            );

            /// The components that every body must have, except `Transform`.
            pub fn essentials() -> impl Bundle {
                ($(<$Essential>::default(),)* $(<$Computed>::default(),)*)
            }

            /// Filter for bodies whose description was written or removed ([`lost_description`](super::lost_description)).
            pub type Changes = Or<(
                Changed<RigidBody>,
                Changed<BodyIndex>,
                Or<($(Changed<$Described>,)*)>,
                Or<($(Changed<$Kept>,)*)>,
            )>;

            /// The components that describe a body.
            #[derive(QueryData)]
            #[query_data(mutable)]
            pub struct Described {
                pub kind: &'static RigidBody,
                $(pub $described: Option<&'static $Described>,)*
                $($kept: Option<&'static $Kept>,)*
                pub properties: &'static mut MassProperties,
            }

            impl DescribedItem<'_, '_> {
                /// The properties that the table copies.
                ///
                /// # Errors
                /// If one of them is invalid.
                pub fn kept(&self) -> Result<BodyProperties, BodyProblem> {
                    let kept = BodyProperties {
                        $($kept: self.$kept.cloned().unwrap_or_default(),)*
                    };
                    $(properties::KeptProperty::check(&kept.$kept)?;)*
                    Ok(kept)
                }
            }

            /// All components that a user may write to an inactive body.
            #[derive(QueryData)]
            #[query_data(contiguous(all))]
            pub struct Written {
                pub entity: Entity,
                pub slot: &'static BodyIndex,
                pub at: &'static Pose,
                pub transform: Ref<'static, Transform>,
                pub parent: Option<&'static ChildOf>,
                kind: Ref<'static, RigidBody>,
                $($essential: Ref<'static, $Essential>,)*
                $($pushing: Option<Ref<'static, $Pushing>>,)*
                $($optional: Option<Ref<'static, $Optional>>,)*
                $($described: Option<Ref<'static, $Described>>,)*
                $($kept: Option<Ref<'static, $Kept>>,)*
            }

            impl WrittenContiguousItem<'_, '_> {
                /// Finds the bodies whose properties were written with values that differ from the table; once for each property.
                pub(super) fn find(self, rows: Rows, found: &mut Vec<Entity>) {
                    rows.compare(self.kind, found);
                    $(rows.compare(self.$essential, found);)*
                    macro_rules! look_if_there {
                        ($column:expr) => {
                            if let Some(column) = $column {
                                rows.compare(column, found);
                            }
                        };
                    }
                    $(look_if_there!(self.$pushing);)*
                    $(look_if_there!(self.$optional);)*
                    $(look_if_there!(self.$described);)*
                    $(look_if_there!(self.$kept);)*
                }
            }

            /// The components of a body besides pose, motion and sleep, for spawning a copy. This bundle has the components of most bodies,
            /// and those whose absence has a meaning.
            pub fn properties_of(body: EntityRef) -> impl Bundle + use<> {
                (
                    ($(body.get::<$Pushing>().cloned().unwrap_or_default(),)*),
                    ($(body.get::<$Kept>().cloned().unwrap_or_default(),)*),
                )
            }

            /// Inserts the components that only some bodies have into a copy.
            pub fn copy_description(body: EntityRef, copy: &mut EntityWorldMut) {
                $(if let Some(property) = body.get::<$Described>()
                    && !copy.contains::<$Described>()
                {
                    copy.insert(property.clone());
                })*
            }

            /// Passes every component of the list to a visitor.
            pub fn visit(visitor: &mut impl crate::state::Visitor) {
                visitor.component::<RigidBody>();
                $(visitor.component::<$Essential>();)*
                $(visitor.component::<$Computed>();)*
                $(visitor.component::<$Pushing>();)*
                $(visitor.component::<$Optional>();)*
                $(visitor.component::<$Described>();)*
                $(visitor.component::<$Kept>();)*
            }

            #[cfg(test)]
            mod tests {
                use super::*;
                use crate::DrystonePlugins;

                /// Removing a property counts as writing it.
                #[test]
                fn removing_a_property_marks_the_body_as_changed() {
                    let mut app = bevy_app::App::new();
                    app.add_plugins(DrystonePlugins::default());
                    let world = app.world_mut();
                    $({
                        let body = world.spawn((RigidBody::Static, <$Kept>::default())).id();
                        world.clear_trackers();
                        world.entity_mut(body).remove::<$Kept>();
                        let index = world.entity(body).get_ref::<BodyIndex>();
                        assert!(index.unwrap().is_changed(), stringify!($Kept));
                    })*
                }
            }
        }
    };
}
pub(super) use body_properties;
