//! Items generated from the [list](super::list) of the properties of a body: queries, filters, and copies of components.

use super::list::{body_properties, names::*};
use super::prepare::{Rows, written_rows};
use super::{BodyProperties, KeptProperty, RigidBody};
use crate::diagnosis::BodyProblem;
use crate::stored::{Role, Visitor};
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_transform::components::Transform;

/// Whether the table has a value already: the expression of a line of the list.
macro_rules! known {
    () => {
        |_, _| false
    };
    ($known:expr) => {
        $known
    };
}

macro_rules! listed {
    (
        essential { $($essential:ident: $Essential:ident $(= $essential_known:expr)?,)* }
        computed { $($computed:ident: $Computed:ident,)* }
        pushing { $($pushing:ident: $Pushing:ident $(= $pushing_known:expr)?,)* }
        optional { $($optional:ident: $Optional:ident $(= $optional_known:expr)?,)* }
        described { $($described:ident: $Described:ident $(= $described_known:expr)?,)* }
        kept { $($(#[$_doc:meta])* $kept:ident: $Kept:ident,)* }
    ) => {
        /// Filter for bodies that lack a component that every body must have.
        pub type Incomplete = (
            With<RigidBody>,
            Or<($(Without<$Essential>,)* $(Without<$Computed>,)* Without<Transform>)>,
        );

        /// The components that every body must have, except `Transform`.
        pub fn essentials() -> impl Bundle {
            ($(<$Essential>::default(),)* $(<$Computed>::default(),)*)
        }

        /// The components of a body that have it described anew when they are written. [`lost_description`](super::lost_description)
        /// reports removals.
        #[derive(QueryData)]
        #[query_data(contiguous(all))]
        pub struct Describing {
            entity: Entity,
            kind: Ref<'static, RigidBody>,
            slot: Ref<'static, BodyIndex>,
            $($described: Option<Ref<'static, $Described>>,)*
            $($kept: Option<Ref<'static, $Kept>>,)*
        }

        impl DescribingContiguousItem<'_, '_> {
            /// Finds the bodies of which such a component was written since the system ran last.
            pub(in crate::body) fn find(self, found: &mut EntityHashSet) {
                let mut note = |rows: &mut dyn Iterator<Item = usize>| {
                    found.extend(rows.map(|row| self.entity[row]));
                };
                note(&mut written_rows(&self.kind));
                note(&mut written_rows(&self.slot));
                $(if let Some(column) = &self.$described {
                    note(&mut written_rows(column));
                })*
                $(if let Some(column) = &self.$kept {
                    note(&mut written_rows(column));
                })*
            }
        }

        /// The components that describe a body.
        #[derive(QueryData)]
        #[query_data(mutable)]
        pub struct Described {
            pub kind: &'static RigidBody,
            $(pub $described: Option<&'static $Described>,)*
            $($kept: Option<&'static $Kept>,)*
            pub properties: &'static mut MassProperties,
        }

        /// The bodies, with the components that describe them. They are found by other queries first, which have filters.
        pub type DescribedBodies<'w, 's> = Query<'w, 's, Described>;

        impl DescribedItem<'_, '_> {
            /// The properties that the table copies.
            ///
            /// # Errors
            /// If one of them is invalid.
            pub fn kept(&self) -> Result<BodyProperties, BodyProblem> {
                let kept = BodyProperties {
                    $($kept: self.$kept.cloned().unwrap_or_default(),)*
                };
                $(KeptProperty::check(&kept.$kept)?;)*
                Ok(kept)
            }
        }

        /// The components besides `Transform` that a user may write to an inactive body.
        #[derive(QueryData)]
        #[query_data(contiguous(all))]
        pub struct Written {
            pub entity: Entity,
            pub slot: &'static BodyIndex,
            kind: Ref<'static, RigidBody>,
            $($essential: Ref<'static, $Essential>,)*
            $($pushing: Option<Ref<'static, $Pushing>>,)*
            $($optional: Option<Ref<'static, $Optional>>,)*
            $($described: Option<Ref<'static, $Described>>,)*
            $($kept: Option<Ref<'static, $Kept>>,)*
        }

        impl WrittenContiguousItem<'_, '_> {
            /// Finds the bodies whose properties were written with values that differ from the table; once for each property.
            pub(in crate::body) fn find(self, rows: Rows, found: &mut Vec<Entity>) {
                rows.compare(self.kind, |body, kind| body.kind == *kind, found);
                $(rows.compare(self.$essential, known!($($essential_known)?), found);)*
                $(if let Some(column) = self.$pushing {
                    rows.compare(column, known!($($pushing_known)?), found);
                })*
                $(if let Some(column) = self.$optional {
                    rows.compare(column, known!($($optional_known)?), found);
                })*
                $(if let Some(column) = self.$described {
                    rows.compare(column, known!($($described_known)?), found);
                })*
                $(if let Some(column) = self.$kept {
                    rows.compare(column, |body, value| body.properties.$kept == *value, found);
                })*
            }
        }

        /// Passes every component of the list to a visitor.
        pub fn visit(visitor: &mut impl Visitor) {
            visitor.component::<RigidBody>(Role::Other);
            $(visitor.component::<$Essential>(Role::Other);)*
            $(visitor.component::<$Computed>(Role::Other);)*
            $(visitor.component::<$Pushing>(Role::Body);)*
            $(visitor.component::<$Optional>(Role::Other);)*
            $(visitor.component::<$Described>(Role::Body);)*
            $(visitor.component::<$Kept>(Role::Body);)*
        }

        /// Registers all components of the list for reflection.
        #[cfg(feature = "bevy_reflect")]
        pub(crate) fn register(app: &mut bevy_app::App) {
            app.register_type::<RigidBody>();
            $(app.register_type::<$Essential>();)*
            $(app.register_type::<$Computed>();)*
            $(app.register_type::<$Pushing>();)*
            $(app.register_type::<$Optional>();)*
            $(app.register_type::<$Described>();)*
            $(app.register_type::<$Kept>();)*
        }
    };
}
body_properties!(listed);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DrystonePlugins;
    use crate::body::BodyTable;

    macro_rules! kept {
        (
            essential { $($_essential:tt)* }
            computed { $($_computed:tt)* }
            pushing { $($_pushing:tt)* }
            optional { $($_optional:tt)* }
            described { $($_described:tt)* }
            kept { $($(#[$_doc:meta])* $_kept:ident: $Kept:ident,)* }
        ) => {
            /// Removing a property counts as writing it.
            #[test]
            fn the_removal_of_a_property_is_noted() {
                let mut app = bevy_app::App::new();
                app.add_plugins(DrystonePlugins::default());
                let world = app.world_mut();
                $({
                    let body = world.spawn((RigidBody::Static, <$Kept>::default())).id();
                    world.entity_mut(body).remove::<$Kept>();
                    let reduced = world.resource::<BodyTable>().reduced();
                    assert_eq!(reduced.last(), Some(&body), stringify!($Kept));
                    world.despawn(body);
                })*
            }
        };
    }
    body_properties!(kept);
}
