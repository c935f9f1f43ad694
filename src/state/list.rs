//! The list as [kinds](Kind): what snapshots, recordings and previews read.

use super::visit;
use crate::stored::erased::{Kind, Values};
use crate::stored::{Stored, Visitor};
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use std::any::TypeId;
use std::fmt::Debug;
use std::sync::LazyLock;

/// All types of the state, in the order of the list.
pub(crate) struct List {
    pub components: Vec<Kind>,
    pub resources: Vec<Kind>,
    /// Resets a resource that is derived from the state, if the world has it.
    derived: Vec<fn(&mut World)>,
}

static LIST: LazyLock<List> = LazyLock::new(|| {
    let mut list = List {
        components: Vec::new(),
        resources: Vec::new(),
        derived: Vec::new(),
    };
    visit(&mut list);
    list
});

/// All types of the state.
pub(crate) fn list() -> &'static List {
    &LIST
}

/// The components of these types that an entity has, as lists of one value.
pub(crate) fn components_of(world: &World, entity: Entity, types: &[TypeId]) -> Vec<Values> {
    let kinds = types.iter().map(|&id| list().component(id));
    let found = kinds.filter_map(|kind| {
        let cells = kind.read(world)?.entity(entity)?;
        Some(Values::of(cells.values))
    });
    found.collect()
}

impl List {
    /// Resets what is derived from the state.
    pub fn reset_derived(&self, world: &mut World) {
        for reset in &self.derived {
            reset(world);
        }
    }

    /// The component of this type.
    ///
    /// # Panics
    /// If it is not on the list.
    pub fn component(&self, id: TypeId) -> Kind {
        let mut kinds = self.components.iter();
        let kind = kinds.find(|kind| kind.type_id() == id);
        *kind.expect("the component is on the list of the state")
    }
}

impl Visitor for List {
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self) {
        self.components.push(Kind::marked::<T>());
    }

    fn output<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self) {
        self.components.push(Kind::output::<T>());
    }

    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self) {
        self.components.push(Kind::silent::<T>());
    }

    fn immutable<T: Component + Stored + PartialEq>(&mut self) {
        self.components.push(Kind::replaced::<T>());
    }

    fn marker<T: Component<Mutability = Mutable> + Clone + Debug + Default>(&mut self) {
        self.components.push(Kind::valueless::<T>());
    }

    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self) {
        self.resources.push(Kind::code::<T>());
    }

    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self) {
        self.resources.push(Kind::resource::<T>());
    }

    fn derived<T: Resource + Default>(&mut self) {
        self.derived.push(|world| {
            if world.contains_resource::<T>() {
                world.insert_resource(T::default());
            }
        });
    }
}
