//! The operations on values of a type.

use crate::stored::{Role, Stored};
use bevy_ecs::component::{Component, ComponentId, Components, StorageType};
use bevy_ecs::entity::EntityMapper;
use bevy_ecs::world::World;
use std::alloc::Layout;
use std::any::TypeId;
use std::fmt::{self, Debug};
use std::marker::PhantomData;
use std::slice;

/// How the values of a component are written into a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum How {
    /// Users may read it: it is marked as changed if it differs.
    Marked,
    /// Stages write it and users read it: it is marked as changed if it differs, but stages do not take it for one that a user has added.
    Output,
    /// Stages write it without change detection: they take its ticks for edits by users.
    Silent,
    /// It can only be replaced.
    Replaced,
    /// It has no value.
    Valueless,
    /// It is a resource.
    Resource,
}

/// A type on the list of the [state](crate::state).
#[derive(Clone, Copy)]
pub(crate) struct Kind {
    functions: &'static Functions,
    pub how: How,
    pub role: Role,
}

impl Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The functions of a type. Those with pointers are called with aligned pointers to as many values of the type as they are told, which they
/// may read, or also write if the pointer is `*mut`.
pub(super) struct Functions {
    id: TypeId,
    name: fn() -> &'static str,
    storage: StorageType,
    register: fn(&mut World) -> ComponentId,
    pub layout: Layout,
    /// Clones values to where there are none yet.
    pub clone: unsafe fn(*const u8, *mut u8, usize),
    /// Makes values equal to others, in the memory that they have.
    pub clone_from: unsafe fn(*const u8, *mut u8, usize),
    /// Drops values. `None` if there is nothing to do.
    pub drop: Option<unsafe fn(*mut u8, usize)>,
    /// Replaces the entities that values refer to.
    pub map: unsafe fn(*mut u8, usize, &mut dyn EntityMapper),
    /// The index of the first value that differs; the number of values if none does.
    pub first_difference: Option<unsafe fn(*const u8, *const u8, usize) -> usize>,
    pub debug: fn(*const u8) -> *const dyn Debug,
    /// Puts the default value where there is none yet.
    #[cfg(feature = "serde")]
    pub default: Option<unsafe fn(*mut u8)>,
    #[cfg(feature = "serde")]
    pub code: Option<Code>,
}

/// How values are written to bytes and read from them.
#[cfg(feature = "serde")]
#[derive(Clone, Copy)]
pub(super) struct Code {
    pub encode: unsafe fn(*const u8, &mut postcard::Serializer<Out>) -> postcard::Result<()>,
    /// Reads a value to where there is none yet. After an error there is none.
    pub decode: unsafe fn(&mut Decoder, *mut u8) -> postcard::Result<()>,
}

#[cfg(feature = "serde")]
pub(super) type Decoder<'a> = postcard::Deserializer<'a, postcard::de_flavors::Slice<'a>>;

/// Bytes to which postcard appends.
#[cfg(feature = "serde")]
pub(crate) struct Out<'a>(pub &'a mut Vec<u8>);

#[cfg(feature = "serde")]
impl postcard::ser_flavors::Flavor for Out<'_> {
    type Output = ();

    fn try_extend(&mut self, data: &[u8]) -> postcard::Result<()> {
        self.0.extend_from_slice(data);
        Ok(())
    }

    fn try_push(&mut self, data: u8) -> postcard::Result<()> {
        self.0.push(data);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

struct Of<T>(PhantomData<T>);

impl<T: Component + Clone + Debug> Of<T> {
    const PLAIN: Functions = Functions {
        id: TypeId::of::<T>(),
        name: std::any::type_name::<T>,
        storage: T::STORAGE_TYPE,
        register: World::register_component::<T>,
        layout: Layout::new::<T>(),
        clone: clone::<T>,
        clone_from: clone_from::<T>,
        drop: match std::mem::needs_drop::<T>() {
            true => Some(drop::<T>),
            false => None,
        },
        map: map::<T>,
        first_difference: None,
        debug: debug::<T>,
        #[cfg(feature = "serde")]
        default: None,
        #[cfg(feature = "serde")]
        code: None,
    };
    const CODE: &Functions = &Self::PLAIN;
}

impl<T: Component + Stored> Of<T> {
    const WRITTEN: Functions = Functions {
        #[cfg(feature = "serde")]
        code: Some(Code {
            encode: encode::<T>,
            decode: decode::<T>,
        }),
        ..Self::PLAIN
    };
    const STORED: &Functions = &Self::WRITTEN;
}

impl<T: Component + Stored + PartialEq> Of<T> {
    const COMPARED: &Functions = &Functions {
        first_difference: Some(first_difference::<T>),
        ..Self::WRITTEN
    };
}

impl<T: Component + Clone + Debug + Default> Of<T> {
    const VALUELESS: &Functions = &Functions {
        #[cfg(feature = "serde")]
        default: Some(default::<T>),
        ..Self::PLAIN
    };
}

impl Kind {
    /// Values that can be compared.
    pub const fn compared<T: Component + Stored + PartialEq>(how: How, role: Role) -> Self {
        Self {
            functions: Of::<T>::COMPARED,
            how,
            role,
        }
    }

    /// Values that cannot be compared.
    pub const fn stored<T: Component + Stored>(how: How, role: Role) -> Self {
        Self {
            functions: Of::<T>::STORED,
            how,
            role,
        }
    }

    /// A component without a value.
    pub const fn valueless<T: Component + Clone + Debug + Default>(role: Role) -> Self {
        Self {
            functions: Of::<T>::VALUELESS,
            how: How::Valueless,
            role,
        }
    }

    /// A resource that is code of the user, and cannot be written to bytes.
    pub const fn code<T: Component + Clone + Debug>(role: Role) -> Self {
        Self {
            functions: Of::<T>::CODE,
            how: How::Resource,
            role,
        }
    }

    pub(super) fn functions(self) -> &'static Functions {
        self.functions
    }

    pub fn type_id(self) -> TypeId {
        self.functions.id
    }

    pub fn name(self) -> &'static str {
        (self.functions.name)()
    }

    /// Whether the component is not kept in tables.
    pub fn is_sparse(self) -> bool {
        matches!(self.functions.storage, StorageType::SparseSet)
    }

    /// Whether values can be compared.
    pub fn is_compared(self) -> bool {
        self.functions.first_difference.is_some()
    }

    /// Whether values are written to bytes.
    #[cfg(feature = "serde")]
    pub fn has_code(self) -> bool {
        self.functions.code.is_some()
    }

    /// The component in a world, if the world knows it.
    pub fn id(self, components: &Components) -> Option<ComponentId> {
        components.get_valid_id(self.functions.id)
    }

    /// Makes a world know the component.
    pub fn register(self, world: &mut World) -> ComponentId {
        match self.id(world.components()) {
            Some(id) => id,
            None => (self.functions.register)(world),
        }
    }
}

/// # Safety
/// See [`Functions`]. `to` has room for the values, and does not overlap `from`.
unsafe fn clone<T: Clone>(from: *const u8, to: *mut u8, count: usize) {
    let (from, to) = (from.cast::<T>(), to.cast::<T>());
    let mut at = 0;
    // `write_clone_of_slice` of the standard library is four times as much code, for each type.
    while at < count {
        // SAFETY: By the caller, since `at` is less than `count`.
        unsafe { to.add(at).write(T::clone(&*from.add(at))) };
        at += 1;
    }
}

/// # Safety
/// See [`Functions`]. The two do not overlap.
unsafe fn clone_from<T: Clone>(from: *const u8, to: *mut u8, count: usize) {
    // SAFETY: By the caller.
    let (from, to) = unsafe {
        (
            slice::from_raw_parts(from.cast::<T>(), count),
            slice::from_raw_parts_mut(to.cast::<T>(), count),
        )
    };
    to.clone_from_slice(from);
}

/// # Safety
/// See [`Functions`]. The values are not used any more.
unsafe fn drop<T>(values: *mut u8, count: usize) {
    let values = std::ptr::slice_from_raw_parts_mut(values.cast::<T>(), count);
    // SAFETY: By the caller.
    unsafe { values.drop_in_place() };
}

/// # Safety
/// See [`Functions`].
unsafe fn map<T: Component>(values: *mut u8, count: usize, mut mapper: &mut dyn EntityMapper) {
    // SAFETY: By the caller.
    let values = unsafe { slice::from_raw_parts_mut(values.cast::<T>(), count) };
    for value in values {
        T::map_entities(value, &mut mapper);
    }
}

/// # Safety
/// See [`Functions`].
unsafe fn first_difference<T: PartialEq>(a: *const u8, b: *const u8, count: usize) -> usize {
    let (a, b) = (a.cast::<T>(), b.cast::<T>());
    let mut at = 0;
    // SAFETY: By the caller, since `at` is less than `count`.
    while at < count && unsafe { *a.add(at) == *b.add(at) } {
        at += 1;
    }
    at
}

fn debug<T: Debug + 'static>(value: *const u8) -> *const dyn Debug {
    value.cast::<T>() as *const dyn Debug
}

/// # Safety
/// See [`Functions`]. There is room for a value.
#[cfg(feature = "serde")]
unsafe fn default<T: Default>(to: *mut u8) {
    // SAFETY: By the caller.
    unsafe { to.cast::<T>().write(T::default()) };
}

/// # Safety
/// See [`Functions`].
#[cfg(feature = "serde")]
unsafe fn encode<T: serde::Serialize>(
    value: *const u8,
    to: &mut postcard::Serializer<Out>,
) -> postcard::Result<()> {
    // SAFETY: By the caller.
    unsafe { &*value.cast::<T>() }.serialize(to)
}

/// # Safety
/// See [`Functions`]. There is room for a value.
#[cfg(feature = "serde")]
unsafe fn decode<T: serde::de::DeserializeOwned>(
    from: &mut Decoder,
    to: *mut u8,
) -> postcard::Result<()> {
    let value = T::deserialize(from)?;
    // SAFETY: By the caller.
    unsafe { to.cast::<T>().write(value) };
    Ok(())
}
