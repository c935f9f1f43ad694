use super::{How, Kind, Slice, Values};
use crate::stored::{Role, Stored};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{EntityHashMap, SceneEntityMapper};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::storage::TableId;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// It owns memory.
#[derive(Component, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Name(String, #[entities] Option<Entity>);

impl Clone for Name {
    fn clone(&self) -> Self {
        Self(self.0.clone(), self.1)
    }

    fn clone_from(&mut self, from: &Self) {
        self.0.clone_from(&from.0);
        self.1 = from.1;
    }
}

#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Number(f64);

#[derive(Component, Clone, Debug, Default)]
struct Marker;

#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(storage = "SparseSet")]
struct Sparse(u8);

#[derive(Resource, Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Settings(Vec<u32>);

/// It counts its owners, and panics when the clone of a bad one is made.
#[derive(Component, Debug)]
struct Counted {
    owners: Arc<()>,
    is_bad: bool,
}

impl Clone for Counted {
    fn clone(&self) -> Self {
        assert!(!self.is_bad, "bad");
        Self {
            owners: self.owners.clone(),
            is_bad: false,
        }
    }
}

fn compared<T: Component + Stored + PartialEq>() -> Kind {
    Kind::compared::<T>(How::Marked, Role::Other)
}

fn name(text: &str) -> Values {
    Values::with(compared::<Name>(), Name(text.to_owned(), None))
}

fn names(texts: &[&str]) -> Values {
    let mut all = Values::new(compared::<Name>());
    for text in texts {
        all.push(name(text).as_slice());
    }
    all
}

fn texts(values: Slice<'_>) -> Vec<&str> {
    let names = values.typed::<Name>().unwrap();
    names.iter().map(|name| &*name.0).collect()
}

#[test]
fn lists_clone_and_keep_memory() {
    let mut all = names(&["a", "b", "c"]);
    let place = |values: &Values| {
        let names = values.as_slice().typed::<Name>().unwrap();
        names[1].0.as_ptr()
    };
    let before = place(&all);
    all.overwrite(1, names(&["d", "e", "f"]).as_slice());
    assert_eq!(texts(all.as_slice()), ["a", "d", "e", "f"]);
    assert_eq!(place(&all), before, "the memory of the value is used again");
    let copy = all.clone();
    all.truncate(2);
    all.truncate(3);
    assert_eq!(texts(all.as_slice()), ["a", "d"]);
    assert_eq!(texts(copy.part(1..3)), ["d", "e"]);
    assert_eq!(copy.part(4..4).len(), 0);
    let mut other = names(&["x", "y"]);
    all.as_mut().swap(&mut other.as_mut());
    assert_eq!(
        (texts(all.as_slice()), texts(other.as_slice())),
        (vec!["x", "y"], vec!["a", "d"])
    );
    let text = format!("{:?} {:?}", all.one(1).debug(), names(&["z"]));
    assert_eq!(text, "Name(\"y\", None) [Name(\"z\", None)]");
}

#[test]
fn the_first_difference_is_found() {
    let all = names(&["a", "b", "c"]);
    let other = names(&["a", "x", "y"]);
    assert_eq!(all.as_slice().first_difference(other.as_slice()), Some(1));
    assert_eq!(all.as_slice().first_difference(all.as_slice()), None);
    let nan = Values::with(compared::<Number>(), Number(f64::NAN));
    assert_eq!(nan.as_slice().first_difference(nan.as_slice()), Some(0));
    let markers = Values::with(Kind::valueless::<Marker>(Role::Other), Marker);
    assert_eq!(
        markers.as_slice().first_difference(markers.as_slice()),
        None
    );
}

#[test]
fn no_value_is_dropped_twice() {
    let owners = Arc::new(());
    let one = Counted {
        owners: owners.clone(),
        is_bad: false,
    };
    let kind = Kind::code::<Counted>(Role::Other);
    let mut all = Values::with(kind, one);
    for _ in 0..4 {
        let copy = all.clone();
        all.push(copy.as_slice());
    }
    assert_eq!((all.len(), Arc::strong_count(&owners)), (16, 17));
    all.truncate(5);
    assert_eq!(Arc::strong_count(&owners), 6);
    let bad = Counted {
        owners: owners.clone(),
        is_bad: true,
    };
    let mut others = all.clone();
    let bad = Values::with(kind, bad);
    others.as_mut().part(2..3).swap(&mut { bad }.as_mut());
    let failed = catch_unwind(AssertUnwindSafe(|| all.push(others.as_slice())));
    assert!(failed.is_err());
    assert_eq!(all.len(), 5);
    let failed = catch_unwind(AssertUnwindSafe(|| all.overwrite(1, others.as_slice())));
    assert!(failed.is_err());
    assert_eq!(all.len(), 5);
    drop((all, others));
    let leaked = 2;
    assert_eq!(
        Arc::strong_count(&owners),
        1 + leaked,
        "the two that were cloned before the bad one are in no list"
    );
}

#[test]
fn values_without_a_size_need_no_memory() {
    let mut all = Values::with(Kind::valueless::<Marker>(Role::Other), Marker);
    for _ in 0..10 {
        let copy = all.clone();
        all.push(copy.as_slice());
    }
    assert_eq!(all.as_slice().typed::<Marker>().unwrap().len(), 1024);
    all.clear();
    assert!(all.is_empty());
}

#[test]
fn other_types_and_places_are_refused() {
    let number = Values::with(compared::<Number>(), Number(1.0));
    assert!(number.as_slice().typed::<Name>().is_none());
    let refused: [&mut dyn FnMut(); 8] = [
        &mut || name("a").push(number.as_slice()),
        &mut || name("a").as_mut().clone_from(number.as_slice()),
        &mut || name("a").as_mut().clone_from(names(&["a", "b"]).as_slice()),
        &mut || name("a").as_mut().swap(&mut number.clone().as_mut()),
        &mut || _ = name("a").as_slice().first_difference(number.as_slice()),
        &mut || _ = name("a").one(1),
        &mut || name("a").overwrite(2, name("b").as_slice()),
        &mut || _ = Values::with(compared::<Name>(), Number(1.0)),
    ];
    for (number, call) in refused.into_iter().enumerate() {
        assert!(catch_unwind(AssertUnwindSafe(call)).is_err(), "{number}");
    }
    let mut world = World::new();
    let mut entity = world.spawn_empty();
    let mut empty = Values::new(compared::<Name>());
    assert!(catch_unwind(AssertUnwindSafe(|| empty.insert_into(&mut entity))).is_err());
    let mut twice = [name("a"), name("b")];
    let call = || Values::insert_all_into(&mut twice, &mut entity);
    assert!(catch_unwind(AssertUnwindSafe(call)).is_err());
}

#[test]
fn entities_are_mapped() {
    let mut world = World::new();
    let [old, new] = [world.spawn_empty().id(), world.spawn_empty().id()];
    let mut values = Values::with(compared::<Name>(), Name(String::new(), Some(old)));
    let mut map = EntityHashMap::from_iter([(old, new)]);
    SceneEntityMapper::world_scope(&mut map, &mut world, |_, mapper| {
        values.as_mut().map(mapper);
    });
    assert_eq!(values.as_slice().typed::<Name>().unwrap()[0].1, Some(new));
}

#[test]
fn a_table_of_a_world_is_read_and_written() {
    let mut world = World::new();
    let kind = compared::<Name>();
    assert!(kind.read(&world).is_none(), "the world does not know it");
    let spawned = ["a", "b", "c"].map(|text| {
        let name = Name(text.to_owned(), None);
        world.spawn((name, Number(1.0))).id()
    });
    let disabled = world.spawn((Name("d".to_owned(), None), Disabled)).id();
    let table = world.entity(spawned[0]).location().table_id;
    let cells = kind.read(&world).unwrap().table(table).unwrap();
    assert_eq!(texts(cells.values), ["a", "b", "c"]);
    assert_eq!(cells.entities, spawned);
    assert_eq!((cells.added.len(), cells.changed.len()), (3, 3));
    assert!(
        kind.read(&world)
            .unwrap()
            .table(TableId::from_usize(99))
            .is_none()
    );
    let cells = kind.read(&world).unwrap().entity(disabled).unwrap();
    assert_eq!(texts(cells.values), ["d"]);
    assert_eq!(kind.read(&world).unwrap().holders().len(), 4);

    let now = Tick::new(1000);
    let mut known = kind.write(&mut world).unwrap();
    let mut cells = known.table(table).unwrap();
    cells
        .values
        .part(1..3)
        .clone_from(names(&["x", "y"]).as_slice());
    cells.set_changed(1, now);
    cells.set_added(2, now);
    let mut cells = known.entity(disabled).unwrap();
    cells.values.clone_from(name("z").as_slice());
    let ticks = spawned.map(|entity| {
        let of = world.entity(entity).get_ref::<Name>().unwrap();
        (of.0.clone(), of.added() == now, of.last_changed() == now)
    });
    let expected = [("a", false, false), ("x", false, true), ("y", true, true)];
    assert_eq!(
        ticks,
        expected.map(|(text, added, changed)| (text.to_owned(), added, changed))
    );
    assert_eq!(world.get::<Name>(disabled).unwrap().0, "z");

    world.despawn(spawned[1]);
    assert!(kind.read(&world).unwrap().entity(spawned[1]).is_none());
    let cells = kind.read(&world).unwrap().table(table).unwrap();
    assert_eq!(texts(cells.values), ["a", "y"]);
    for entity in [spawned[0], spawned[2]] {
        world.despawn(entity);
    }
    assert!(
        kind.read(&world).unwrap().table(table).is_none(),
        "no value"
    );
}

#[test]
fn sparse_components_and_resources_are_found() {
    let mut world = World::new();
    let kind = compared::<Sparse>();
    assert!(kind.is_sparse() && kind.how == How::Marked);
    let holder = world.spawn(Sparse(3)).id();
    let other = world.spawn_empty().id();
    let table = world.entity(holder).location().table_id;
    let known = kind.read(&world).unwrap();
    assert_eq!(known.holders(), [holder]);
    assert!(known.table(table).is_none() && known.entity(other).is_none());
    let cells = known.entity(holder).unwrap();
    assert_eq!(cells.values.typed::<Sparse>().unwrap(), [Sparse(3)]);
    assert_eq!(cells.entities, [holder]);
    let mut known = kind.write(&mut world).unwrap();
    let mut cells = known.entity(holder).unwrap();
    cells
        .values
        .clone_from(Values::with(kind, Sparse(4)).as_slice());
    cells.set_changed(0, Tick::new(1000));
    let value = world.entity(holder).get_ref::<Sparse>().unwrap();
    assert_eq!((value.0, value.last_changed()), (4, Tick::new(1000)));

    let kind = Kind::stored::<Settings>(How::Resource, Role::Other);
    assert_eq!(kind.how, How::Resource);
    let mut values = Values::with(kind, Settings(vec![1, 2]));
    values.insert_resource(&mut world);
    assert!(values.is_empty());
    assert_eq!(world.resource::<Settings>().0, [1, 2]);
    let mut known = kind.write(&mut world).unwrap();
    let now = Values::with(kind, Settings(vec![3]));
    known.resource().unwrap().values.clone_from(now.as_slice());
    assert_eq!(world.resource::<Settings>().0, [3]);
    world.remove_resource::<Settings>();
    assert!(kind.read(&world).unwrap().resource().is_none());
}

#[test]
fn values_are_inserted_with_their_hooks() {
    #[derive(Resource, Default)]
    struct Seen(Vec<(bool, bool)>);
    let mut world = World::new();
    world.init_resource::<Seen>();
    world.add_observer(
        |new: On<Insert<Name>>, all: Query<Has<Number>>, mut seen: ResMut<Seen>| {
            seen.0.push((true, all.get(new.entity).unwrap()));
        },
    );
    world.add_observer(
        |new: On<Insert<Number>>, all: Query<Has<Name>>, mut seen: ResMut<Seen>| {
            seen.0.push((false, all.get(new.entity).unwrap()));
        },
    );
    let mut entity = world.spawn_empty();
    let mut list = names(&["a", "b"]);
    list.insert_into(&mut entity);
    assert_eq!(entity.get::<Name>().unwrap().0, "b");
    list.insert_into(&mut entity);
    assert_eq!(entity.get::<Name>().unwrap().0, "a");
    assert!(list.is_empty());
    let mut both = [name("c"), Values::with(compared::<Number>(), Number(2.0))];
    let both_in = world.spawn_empty().id();
    Values::insert_all_into(&mut both, &mut world.entity_mut(both_in));
    assert_eq!(world.get::<Number>(both_in), Some(&Number(2.0)));
    let seen = &world.resource::<Seen>().0;
    assert_eq!(
        seen[..],
        [(true, false), (true, false), (true, true), (false, true)]
    );
}

#[cfg(feature = "serde")]
#[test]
fn values_are_read_as_they_were_written() {
    let all = names(&["a", "long", ""]);
    let mut bytes = Vec::new();
    for at in 0..3 {
        all.one(at).encode(&mut bytes).unwrap();
    }
    let mut from = &bytes[..];
    let mut read = Values::new(all.kind());
    for _ in 0..3 {
        read.push_decoded(&mut from).unwrap();
    }
    assert!(from.is_empty());
    assert_eq!(all.as_slice().first_difference(read.as_slice()), None);
    for len in 0..2 {
        let mut from = &bytes[..len];
        assert!(read.push_decoded(&mut from).is_err());
        assert_eq!((read.len(), from.len()), (3, len), "nothing was read");
    }
    let mut markers = Values::new(Kind::valueless::<Marker>(Role::Other));
    markers.push_decoded(&mut &[][..]).unwrap();
    let len = bytes.len();
    markers.one(0).encode(&mut bytes).unwrap();
    assert_eq!((markers.len(), bytes.len()), (1, len), "it has no bytes");
    let mut code = Values::new(Kind::code::<Counted>(Role::Other));
    assert!(code.push_decoded(&mut &bytes[..]).is_err());
    assert!(!code.kind().has_code() && all.kind().has_code());
}
