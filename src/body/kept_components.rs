//! The components that pieces of a body take over from it.

use crate::body::collider::Collider;
use crate::body::{
    AngularInertia, CenterOfMass, CompoundCollider, Density, ExternalForce, Mass, listed,
};
use crate::stored::erased::{How, Kind, Values};
use crate::stored::{Role, Stored, Visitor};
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use std::any::TypeId;
use std::sync::LazyLock;

/// Those that describe a body and are not about the whole of it: surface, layers, gravity and so on.
struct Kept(Vec<Kind>);

static KEPT: LazyLock<Kept> = LazyLock::new(|| {
    let mut kept = Kept(Vec::new());
    listed::visit(&mut kept);
    kept
});

impl Visitor for Kept {
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self, role: Role) {
        let of_the_whole = [
            TypeId::of::<Collider>(),
            TypeId::of::<CompoundCollider>(),
            TypeId::of::<Density>(),
            TypeId::of::<Mass>(),
            TypeId::of::<AngularInertia>(),
            TypeId::of::<CenterOfMass>(),
            TypeId::of::<ExternalForce>(),
        ];
        if role == Role::Body && !of_the_whole.contains(&TypeId::of::<T>()) {
            self.0.push(Kind::compared::<T>(How::Marked, role));
        }
    }
}

/// The components that pieces of a body take over, as lists of one value.
pub(crate) fn kept_components(world: &World, body: Entity) -> Vec<Values> {
    let found = KEPT.0.iter().filter_map(|kind| {
        let cells = kind.read(world)?.entity(body)?;
        Some(Values::of(cells.values))
    });
    found.collect()
}

/// Gives a piece these components, if it still exists.
pub(crate) fn take_over(world: &mut World, kept: &[Values], piece: Entity) {
    if let Ok(mut piece) = world.get_entity_mut(piece) {
        let copies = kept.iter().map(|values| Values::of(values.as_slice()));
        Values::insert_all_into(&mut copies.collect::<Vec<_>>(), &mut piece);
    }
}
