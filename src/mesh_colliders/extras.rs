//! Reads glTF extras: JSON that artists write as custom properties (feature `gltf`).
//!
//! `bevy_gltf` puts them into components, which are found here by their names, through reflection: that crate compiles parts of the
//! renderer.

use super::MeshColliders;
use super::error::MeshProblem;
use crate::body::collider::{Collider, DecompositionSettings, Friction, MeshShape, Restitution};
use crate::body::{Density, Mass, RigidBody, Sensor};
use crate::components::put;
use bevy_ecs::prelude::*;
use bevy_reflect::TypeRegistry;
use serde_json::{Map, Value};

/// What the extras of an entity and of those above it say, the nearest first.
#[derive(Debug, Default)]
pub(super) struct Found {
    body: Option<(Entity, RigidBody, Option<f32>)>,
    density: Option<f32>,
    friction: Option<f32>,
    restitution: Option<f32>,
    sensor: Option<bool>,
}

/// The keys, for the message about another one.
const KEYS: &str = "collider, body, mass, density, friction, restitution, sensor";

impl Found {
    /// Adds what an entity says, where no nearer one has said it. Returns its shape: `Some(None)` means no collider.
    pub(super) fn add(
        &mut self,
        rules: &MeshColliders,
        world: &World,
        entity: Entity,
    ) -> Result<Option<Option<MeshShape>>, MeshProblem> {
        if !rules.extras {
            return Ok(None);
        }
        let Some(registry) = world.get_resource::<AppTypeRegistry>() else {
            return Ok(None);
        };
        let registry = registry.read();
        let mut shape = None;
        for component in COMPONENTS {
            let Some(text) = text_of(&registry, world.entity(entity), component) else {
                continue;
            };
            let found = self.read(entity, &text);
            let named = |why| match world.get::<Name>(entity) {
                Some(name) => format!("the glTF extras of `{name}`: {why}"),
                None => format!("its glTF extras: {why}"),
            };
            shape = shape.or(found.map_err(|why| MeshProblem::Extras(named(why)))?);
        }
        Ok(shape)
    }

    fn read(&mut self, entity: Entity, text: &str) -> Result<Option<Option<MeshShape>>, String> {
        // Extras are any JSON. Only an object can have our properties.
        let Ok(Value::Object(all)) = serde_json::from_str(text) else {
            return Ok(None);
        };
        let (mut shape, mut body, mut mass) = (None, None, None);
        for (key, value) in ours(all)? {
            match key.as_str() {
                "collider" => shape = Some(shape_of(&value)?),
                "body" => body = Some(body_of(&value)?),
                "mass" => mass = Some(number(&key, &value)?),
                "density" => keep(&mut self.density, number(&key, &value)?),
                "friction" => keep(&mut self.friction, number(&key, &value)?),
                "restitution" => keep(&mut self.restitution, number(&key, &value)?),
                "sensor" => keep(&mut self.sensor, truth(&value)?),
                _ => return Err(format!("`{key}` is no property; there are {KEYS}")),
            }
        }
        match (body, mass) {
            (Some(body), _) => keep(&mut self.body, (entity, body, mass)),
            (None, Some(_)) => return Err("`mass` needs `body` beside it".into()),
            (None, None) => (),
        }
        Ok(shape)
    }

    /// Inserts a collider with its surface, then the body.
    pub(super) fn insert(&self, world: &mut World, entity: Entity, collider: Collider) {
        put(world, entity, collider);
        if let Some(density) = self.density {
            put_new(world, entity, Density(density));
        }
        if let Some(friction) = self.friction {
            put_new(world, entity, Friction::new(friction));
        }
        if let Some(restitution) = self.restitution {
            put_new(world, entity, Restitution::new(restitution));
        }
        if self.sensor == Some(true) {
            put_new(world, entity, Sensor);
        }
        if let Some((body, kind, mass)) = self.body {
            if let Some(mass) = mass {
                put_new(world, body, Mass(mass));
            }
            put_new(world, body, kind);
        }
    }
}

/// The components of `bevy_gltf` with extras: of nodes and parts of meshes, of the material of a part, of the whole mesh. The first one
/// that says something decides.
const COMPONENTS: [&str; 3] = ["GltfExtras", "GltfMaterialExtras", "GltfMeshExtras"];

/// The text of a component with extras, if the entity has it.
fn text_of(registry: &TypeRegistry, entity: EntityRef, component: &str) -> Option<String> {
    let known = registry.get_with_short_type_path(component)?;
    let extras = known.data::<ReflectComponent>()?.reflect(entity)?;
    let text = extras.reflect_ref().as_struct().ok()?.field("value")?;
    text.try_downcast_ref::<String>().cloned()
}

/// Sets what no nearer entity has set.
fn keep<T>(known: &mut Option<T>, value: T) {
    known.get_or_insert(value);
}

/// Inserts a component, unless the entity has it or is gone.
fn put_new(world: &mut World, entity: Entity, component: impl Component) {
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert_if_new(component);
    }
}

/// The properties of drystone: those of the object `drystone`, and those whose key begins with `drystone.`.
fn ours(all: Map<String, Value>) -> Result<Vec<(String, Value)>, String> {
    let mut found = Vec::new();
    for (key, value) in all {
        if let Some(name) = key.strip_prefix("drystone.") {
            found.push((name.to_owned(), value));
        } else if key == "drystone" {
            match value {
                Value::Object(object) => found.extend(object),
                Value::String(_) => found.push(("collider".into(), value)),
                _ => return Err("`drystone` is neither an object nor the name of a shape".into()),
            }
        }
    }
    Ok(found)
}

fn shape_of(value: &Value) -> Result<Option<MeshShape>, String> {
    Ok(Some(match value.as_str() {
        Some("surface") => MeshShape::Surface,
        Some("hull") => MeshShape::ConvexHull,
        Some("decomposition") => MeshShape::Decomposition(DecompositionSettings::default()),
        Some("cuboid") => MeshShape::Cuboid,
        Some("ball") => MeshShape::Ball,
        Some("capsule") => MeshShape::Capsule,
        Some("cylinder") => MeshShape::Cylinder,
        Some("none") => return Ok(None),
        _ => {
            return Err(format!(
                "{value} is no shape; `collider` is one of surface, hull, decomposition, cuboid, ball, capsule, cylinder, none"
            ));
        }
    }))
}

fn body_of(value: &Value) -> Result<RigidBody, String> {
    match value.as_str() {
        Some("dynamic") => Ok(RigidBody::Dynamic),
        Some("static") => Ok(RigidBody::Static),
        Some("kinematic") => Ok(RigidBody::Kinematic),
        _ => Err(format!(
            "{value} is no body; `body` is one of dynamic, static, kinematic"
        )),
    }
}

fn number(key: &str, value: &Value) -> Result<f32, String> {
    let found = value.as_f64().map(|number| number as f32);
    found.ok_or_else(|| format!("`{key}` is {value}, but must be a number"))
}

/// Blender exports some booleans as numbers.
fn truth(value: &Value) -> Result<bool, String> {
    let number = value.as_f64().map(|number| number != 0.0);
    let found = value.as_bool().or(number);
    found.ok_or_else(|| format!("`sensor` is {value}, but must be true or false"))
}
