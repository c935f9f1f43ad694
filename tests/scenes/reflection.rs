//! The plugins register what a user reads, edits or saves for reflection, and the documentation of `drystone::reflection` names it.

use bevy_app::App;
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{ReflectComponent, ReflectMessage, ReflectResource};
use bevy_reflect::{GetTypeRegistration, TypePath, TypeRegistry};
use drystone::DrystonePlugins;
use drystone::prelude::*;
use drystone::state::{Stored, Visitor};
use std::any::TypeId;
use std::fmt::Debug;

/// Types that are not registered, and why.
const INTERNAL: [(&str, &str); 34] = [
    ("body::inactive::Inactive", "private; stages insert it"),
    ("joint::edge::JointEdge", "private; stages insert it"),
    ("body::table::BodyTable", "computed in every step"),
    ("broadphase::Broadphase", "computed in every step"),
    ("graph::edges::ConstraintGraph", "computed in every step"),
    ("graph::islands::Islands", "computed in every step"),
    (
        "settings::check::ActiveSettings",
        "the settings of the last step",
    ),
    (
        "contact::moving_surfaces::MovingSurfaces",
        "computed in every step",
    ),
    ("diagnosis::Told", "what was reported"),
    ("contact::hooks::ContactHooks", "code"),
    ("settings::threads::PhysicsThreads", "threads"),
    ("profile::Profile", "clocks"),
    ("masonry::log::EditLog", "belongs to one world"),
    (
        "recording::recorder::Recorder",
        "a file and what it watches; no state",
    ),
    ("body::pending::Pending", "derived, for queries"),
    (
        "body::written_transforms::WrittenTransforms",
        "hidden; empty between steps",
    ),
    (
        "warm_start::problems::IslandProblems",
        "scratch of a step, with the memory of solvers",
    ),
    ("diagnosis::Suspects", "hidden; empty between steps"),
    ("contact::LostPairs", "hidden; empty between steps"),
    ("contact::events::EndedPairs", "hidden; empty between steps"),
    (
        "contact::events::Untriggered",
        "hidden; empty between steps",
    ),
    ("contact::cache::NarrowphaseCache", "hidden; data of parry"),
    ("joint::edge::JointChanges", "hidden; empty between steps"),
    ("joint::forces::BrokenJoints", "hidden; empty between steps"),
    (
        "mortar::events::BrokenMortar",
        "hidden; empty between steps",
    ),
    (
        "children::assemble::Unassembled",
        "hidden; a list of changes",
    ),
    ("sensor::zones::Sensors", "hidden; the tree of sensors"),
    (
        "sensor::events::UntriggeredSensorEvents",
        "hidden; empty between steps",
    ),
    ("saving::restore::Restored", "hidden; empty between steps"),
    ("streaming::suspended::Suspended", "hidden"),
    (
        "streaming::arrivals::Arrivals",
        "hidden; empty between steps",
    ),
    ("collapse::Stands", "hidden; where a watched body stood"),
    ("collapse::Structures", "hidden; history of collapses"),
    ("schedule::StepMessages", "private; a list of functions"),
];

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), HandPlugin, CollapsePlugin));
    app
}

/// Compares the types on the list of the state with the registry.
struct Registered<'a> {
    registry: &'a TypeRegistry,
    unknown: Vec<&'static str>,
    count: usize,
}

impl Registered<'_> {
    fn check<T: 'static>(&mut self) {
        let name = std::any::type_name::<T>();
        let Some(path) = name.strip_prefix("drystone::") else {
            return;
        };
        self.count += 1;
        let registered = self.registry.get(TypeId::of::<T>()).is_some();
        let internal = INTERNAL.iter().any(|(known, _)| *known == path);
        assert!(
            !(registered && internal),
            "{path} is registered, and on the list"
        );
        if !registered && !internal {
            self.unknown.push(path);
        }
    }
}

impl Visitor for Registered<'_> {
    fn component<T: Component<Mutability = Mutable> + Stored + PartialEq>(&mut self) {
        self.check::<T>();
    }

    fn internal<T: Component<Mutability = Mutable> + Stored>(&mut self) {
        self.check::<T>();
    }

    fn immutable<T: Component + Stored + PartialEq>(&mut self) {
        self.check::<T>();
    }

    fn marker<T: Component<Mutability = Mutable> + Clone + Debug + Default>(&mut self) {
        self.check::<T>();
    }

    fn code<T: Resource + Component<Mutability = Mutable> + Clone + Debug>(&mut self) {
        self.check::<T>();
    }

    fn resource<T: Resource + Component<Mutability = Mutable> + Stored>(&mut self) {
        self.check::<T>();
    }

    fn derived<T: Resource + Default>(&mut self) {
        self.check::<T>();
    }
}

#[test]
fn every_component_and_resource_of_the_state_is_registered() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let mut registered = Registered {
        registry: &registry,
        unknown: Vec::new(),
        count: 0,
    };
    drystone::state::visit(&mut registered);
    assert!(registered.count > 80, "{}", registered.count);
    assert!(
        registered.unknown.is_empty(),
        "not registered: {:#?}",
        registered.unknown
    );
}

/// The source names more types than a world knows: those that only some entities have.
#[test]
fn every_type_of_the_source_is_registered() {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/../src");
    let mut found = Vec::new();
    visit(source.as_ref(), &mut found);
    assert!(found.len() > 90, "{}", found.len());
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let registered: Vec<&str> = registry
        .iter()
        .map(|of| of.type_info().type_path_table().short_path())
        .collect();
    let is_internal = |name: &str| {
        let mut internal = INTERNAL.iter();
        internal.any(|(path, _)| path.rsplit("::").next() == Some(name))
    };
    // Debug rendering has plugins of its own.
    found.retain(|name| !is_internal(name) && !registered.contains(&name.as_str()));
    assert!(found.is_empty(), "not registered: {found:#?}");
}

/// The names of the public types in a folder that derive `Component`, `Resource` or `Message`.
fn visit(folder: &std::path::Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            visit(&path, found);
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let (mut derives, mut in_list) = (false, false);
        for line in text.lines().map(str::trim) {
            let begins = line.strip_prefix("#[derive(");
            if begins.is_some() {
                (derives, in_list) = (false, true);
            }
            if in_list {
                let names = begins.unwrap_or(line).split([',', ')']);
                let mut names = names.map(str::trim);
                derives |= names.any(|name| ["Component", "Resource", "Message"].contains(&name));
                in_list = !line.ends_with(")]");
            }
            let declared = ["pub struct ", "pub enum "].iter();
            let mut declared = declared.filter_map(|kind| line.strip_prefix(kind));
            if let Some(name) = declared.next()
                && std::mem::take(&mut derives)
            {
                let end = name.find(|c: char| !c.is_alphanumeric());
                found.push(name[..end.unwrap_or(name.len())].to_owned());
            }
        }
    }
}

#[test]
fn types_can_be_inserted_and_sent_through_reflection() {
    fn has<T: GetTypeRegistration + TypePath, D: bevy_reflect::TypeData>(app: &App) {
        let registry = app.world().resource::<AppTypeRegistry>().read();
        let of = registry.get(std::any::TypeId::of::<T>());
        let data = of.and_then(|of| of.data::<D>());
        assert!(data.is_some(), "{}", T::type_path());
    }
    let app = app();
    has::<Collider, ReflectComponent>(&app);
    has::<RevoluteJoint, ReflectComponent>(&app);
    has::<PrismaticJoint, ReflectComponent>(&app);
    has::<SphericalJoint, ReflectComponent>(&app);
    has::<FixedJoint, ReflectComponent>(&app);
    has::<DistanceJoint, ReflectComponent>(&app);
    has::<SpringJoint, ReflectComponent>(&app);
    has::<GenericJoint, ReflectComponent>(&app);
    has::<BreakForce, ReflectComponent>(&app);
    has::<JointForces, ReflectComponent>(&app);
    has::<JointDisabled, ReflectComponent>(&app);
    has::<Mortar, ReflectComponent>(&app);
    has::<MortarJoint, ReflectComponent>(&app);
    has::<ContactPair, ReflectComponent>(&app);
    has::<SolverSettings, ReflectResource>(&app);
    has::<PhysicsTime, ReflectResource>(&app);
    has::<ContactStarted, ReflectMessage>(&app);
    has::<Collapse, ReflectMessage>(&app);
}

/// The table names exactly the types that can be inserted, read or sent.
#[test]
fn the_documentation_names_them() {
    let page = include_str!("../../src/reflection.rs");
    let table = page.lines().filter(|line| line.starts_with("//! | "));
    let mut named: Vec<&str> = table
        .flat_map(|line| line.split('`').skip(1).step_by(2))
        .collect();
    named.sort_unstable();
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in &named {
        assert!(
            registry.get_with_short_type_path(name).is_some(),
            "{name} is not registered"
        );
    }
    let registered = registry.iter().filter(|of| {
        of.type_info().type_path().starts_with("drystone")
            && (of.data::<ReflectComponent>().is_some()
                || of.data::<ReflectResource>().is_some()
                || of.data::<ReflectMessage>().is_some())
    });
    for of in registered {
        let name = of.type_info().type_path_table().short_path();
        assert!(named.binary_search(&name).is_ok(), "{name} is not named");
    }
}
