//! The plugins register what a user reads, edits or saves for reflection.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{ReflectComponent, ReflectMessage, ReflectResource};
use bevy_reflect::{GetTypeRegistration, TypePath};
use drystone::DrystonePlugins;
use drystone::prelude::*;
use drystone::state::Visitor;
use std::fmt::Debug;

/// Types that are neither registered nor on the list of the state, and why.
const INTERNAL: [(&str, &str); 13] = [
    ("PhysicsThreads", "threads"),
    ("Profile", "clocks"),
    ("EditLog", "belongs to one world"),
    ("Recorder", "a file and what it watches; no state"),
    ("WrittenTransforms", "hidden; empty between steps"),
    ("StepMessages", "private; a list of functions"),
    ("Wakes", "a report; no state"),
    ("FluidField", "a function, which cannot be saved"),
    ("WaitingMeshes", "hidden; empty when all meshes are loaded"),
    (
        "MeshColliders",
        "with the feature `mesh`; `mesh_colliders` tests it",
    ),
    ("MeshCollidersReady", "with the feature `mesh`"),
    ("MeshColliderError", "a message for people"),
    (
        "PhysicsPanel",
        "with the feature `ui`; the place of a window",
    ),
];

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((DrystonePlugins::default(), HandPlugin, CollapsePlugin));
    app
}

/// The names of the types on the list of the state. Those of them that are not registered are in a group that is `hidden`.
#[derive(Default)]
struct OnTheList(Vec<&'static str>);

impl OnTheList {
    fn add<T>(&mut self) {
        self.0
            .extend(std::any::type_name::<T>().rsplit("::").next());
    }
}

impl Visitor for OnTheList {
    fn any_component<T: Component + Clone + Debug>(&mut self) {
        self.add::<T>();
    }

    fn any_resource<T: Resource + Clone + Debug>(&mut self) {
        self.add::<T>();
    }

    fn derived<T: Resource + Default>(&mut self) {
        self.add::<T>();
    }
}

/// Every public component, resource and message is registered, or its author has said that it need not be.
#[test]
fn every_type_of_the_source_is_registered() {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/../src");
    let mut found = Vec::new();
    visit(source.as_ref(), &mut found);
    assert!(found.len() > 90, "{}", found.len());
    let mut on_the_list = OnTheList::default();
    drystone::state::visit(&mut on_the_list);
    assert!(on_the_list.0.len() > 80, "{}", on_the_list.0.len());
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let registered: Vec<&str> = registry
        .iter()
        .map(|of| of.type_info().type_path_table().short_path())
        .collect();
    let is_internal = |name: &str| {
        on_the_list.0.contains(&name) || INTERNAL.iter().any(|(known, _)| *known == name)
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
        // The pages of the cookbook declare types too.
        if path.extension().is_none_or(|extension| extension != "rs") {
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
    has::<CylindricalJoint, ReflectComponent>(&app);
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
