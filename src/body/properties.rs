//! What a body is made of, declared in one list: the macro that the list in `mod.rs` goes through, and what a component on it implements.
//!
//! A property is a component that a user may write. It has a line on the list, and its behaviour next to its definition
//! ([`BodyProperty`], [`KeptProperty`]). From the list come
//! - what a [`RigidBody`](super::RigidBody) requires, and what is put back where it was taken off,
//! - the change detection of active bodies (`Changes`) and of resting ones (`Written`),
//! - what the [`BodyTable`](super::BodyTable) keeps a copy of ([`BodyProperties`](super::BodyProperties)),
//! - what a preview copies, and what belongs to the [state](crate::state) of a world.
//!
//! Where it matters that a property is taken off, its component has the hook [`lost_description`](super::lost_description).

use super::BodyState;
use crate::diagnosis::BodyProblem;
use bevy_ecs::prelude::*;

/// A component that describes a body and that a user may write.
pub(crate) trait BodyProperty: Component + Clone {
    /// True where the table has this value already. A resting body stays at rest where the value that it has is written again.
    fn is_known(&self, _: &BodyState) -> bool {
        false
    }
}

/// A property that the table keeps a copy of, which has its default value where a body lacks the component.
pub(crate) trait KeptProperty: BodyProperty + Default + PartialEq {
    /// # Errors
    /// What is wrong with the value. The body is then disabled.
    fn check(&self) -> Result<(), BodyProblem> {
        Ok(())
    }
}

/// Declares `RigidBody` and all that is made from the list of its properties.
///
/// | group | required | put back where taken off | looked for when written |
/// |---|---|---|---|
/// | `essential` | yes | yes | on resting bodies; the stages read it of active ones in every step |
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

        /// The table's copies of properties. Where a body lacks a component, its value is the default.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct BodyProperties {
            $($(#[$doc])* pub $kept: $Kept,)*
        }

        $(impl properties::BodyProperty for $Kept {
            fn is_known(&self, body: &BodyState) -> bool {
                body.properties.$kept == *self
            }
        })*

        /// What is made from the list.
        mod listed {
            use super::*;
            use super::inactive::Rows;
            use crate::diagnosis::BodyProblem;
            use bevy_ecs::{hierarchy::ChildOf, query::QueryData};

            /// A body that lacks what every body has.
            pub type Incomplete = (
                With<RigidBody>,
                Or<($(Without<$Essential>,)* $(Without<$Computed>,)* Without<Transform>)>,
            );

            /// What every body has, but for its `Transform`.
            pub fn essentials() -> impl Bundle {
                ($(<$Essential>::default(),)* $(<$Computed>::default(),)*)
            }

            /// Something of the description was written, or taken off ([`lost_description`](super::lost_description)).
            pub type Changes = Or<(
                Changed<RigidBody>,
                Changed<BodyIndex>,
                Or<($(Changed<$Described>,)*)>,
                Or<($(Changed<$Kept>,)*)>,
            )>;

            /// What a body is described by.
            #[derive(QueryData)]
            #[query_data(mutable)]
            pub struct Described {
                pub kind: &'static RigidBody,
                $(pub $described: Option<&'static $Described>,)*
                $($kept: Option<&'static $Kept>,)*
                pub properties: &'static mut MassProperties,
            }

            impl DescribedItem<'_, '_> {
                /// The properties that the table keeps.
                ///
                /// # Errors
                /// What is wrong with one of them.
                pub fn kept(&self) -> Result<BodyProperties, BodyProblem> {
                    let kept = BodyProperties {
                        $($kept: self.$kept.cloned().unwrap_or_default(),)*
                    };
                    $(properties::KeptProperty::check(&kept.$kept)?;)*
                    Ok(kept)
                }
            }

            /// All that a user may write to a resting body.
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
                /// Finds the bodies whose properties were written with values that the table does not know; once for each property.
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

            /// What a body has besides its place, motion and sleep, to spawn a copy with: in one bundle what most bodies have, or what
            /// its absence means.
            pub fn properties_of(body: EntityRef) -> impl Bundle + use<> {
                (
                    ($(body.get::<$Pushing>().cloned().unwrap_or_default(),)*),
                    ($(body.get::<$Kept>().cloned().unwrap_or_default(),)*),
                )
            }

            /// Gives a copy what only some bodies have.
            pub fn copy_description(body: EntityRef, copy: &mut EntityWorldMut) {
                $(if let Some(property) = body.get::<$Described>()
                    && !copy.contains::<$Described>()
                {
                    copy.insert(property.clone());
                })*
            }

            /// Shows a visitor every component on the list.
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

                /// A property that is taken off counts as one that is written.
                #[test]
                fn whatever_describes_a_body_is_missed_when_it_is_taken_off() {
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
