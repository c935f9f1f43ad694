//! The list as [kinds](Kind): what snapshots, recordings and previews read.

use super::visit;
use crate::stored::erased::{How, Kind, Values};
use crate::stored::{Role, Stored, Visitor};
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

/// The components with a role that an entity has, as lists of one value.
pub(crate) fn parts_of(world: &World, entity: Entity, role: Role) -> Vec<Values> {
    let kinds = list().components.iter().filter(|kind| kind.role == role);
    let found = kinds.filter_map(|kind| {
        let cells = kind.read(world)?.entity(entity)?;
        Some(Values::of(cells.values))
    });
    found.collect()
}

/// Gives a world the settings of another one, except those of plugins that it lacks.
pub(crate) fn copy_settings(from: &World, to: &mut World) {
    let settings = list().resources.iter();
    for setting in settings.filter(|kind| kind.role == Role::Setting) {
        let value = |world| setting.read(world)?.resource();
        if let (Some(setting), Some(_)) = (value(from), value(to)) {
            Values::of(setting.values).insert_resource(to);
        }
    }
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
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self, role: Role) {
        self.components.push(Kind::compared::<T>(How::Marked, role));
    }

    fn output<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self, role: Role) {
        self.components.push(Kind::compared::<T>(How::Output, role));
    }

    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self, role: Role) {
        self.components.push(Kind::stored::<T>(How::Silent, role));
    }

    fn immutable<T: Component + Stored + PartialEq>(&mut self, role: Role) {
        self.components
            .push(Kind::compared::<T>(How::Replaced, role));
    }

    fn marker<T: Component<Mutability = Mutable> + Clone + Debug + Default>(&mut self, role: Role) {
        self.components.push(Kind::valueless::<T>(role));
    }

    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self, role: Role) {
        self.resources.push(Kind::stored::<T>(How::Resource, role));
    }

    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self, role: Role) {
        self.resources.push(Kind::code::<T>(role));
    }

    fn derived<T: Resource + Default>(&mut self) {
        self.derived.push(|world| {
            if world.contains_resource::<T>() {
                world.insert_resource(T::default());
            }
        });
    }
}
