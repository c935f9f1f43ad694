//! The grid of cells.

use super::cells::{CellBox, Cells, SIDE};
use crate::body::Pose;
use bevy_ecs::entity::{EntityMapper, MapEntities};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
#[cfg(feature = "bevy_reflect")]
use bevy_reflect::Reflect;
use glam::{IVec3, Vec3};
use std::collections::BTreeMap;

/// A solid of equal cells, which is edited cell by cell; see the [module](super). Cell (0, 0, 0) has one corner at the origin of the
/// entity and the other at (`size`, `size`, `size`).
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(Reflect),
    reflect(opaque),
    reflect(Component, Clone, Debug)
)]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(map_entities, on_remove = despawn_chunks)]
pub struct Voxels {
    size: f32,
    splits: bool,
    ground: Option<i32>,
    /// Whether its chunks are bodies of their own.
    pub(super) divided: bool,
    /// Where its chunks are.
    pub(super) placed: Pose,
    #[cfg_attr(feature = "serde", serde(with = "super::saved"))]
    pub(super) chunks: BTreeMap<[i32; 3], Chunk>,
    /// Chunks whose colliders must be made anew; some may be there twice.
    pub(super) dirty: Vec<[i32; 3]>,
    /// Cells that were emptied, and may have held parts together.
    pub(super) emptied: Vec<[i32; 3]>,
}

/// The body of a chunk of a static body with [`Voxels`]: the entity of that body. Drystone spawns and despawns it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy_reflect", derive(Reflect), reflect(Component, Debug))]
#[cfg_attr(
    all(feature = "bevy_reflect", feature = "serde"),
    reflect(bevy_reflect::Serialize, bevy_reflect::Deserialize)
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VoxelChunk(#[entities] pub Entity);

/// Hook of [`Voxels`]: the bodies of its chunks go with it.
fn despawn_chunks(mut world: DeferredWorld, context: HookContext) {
    let Some(voxels) = world.get::<Voxels>(context.entity) else {
        return;
    };
    let chunks: Vec<Entity> = voxels.chunk_bodies().collect();
    let mut commands = world.commands();
    for chunk in chunks {
        if let Ok(mut chunk) = commands.get_entity(chunk) {
            chunk.try_despawn();
        }
    }
}

/// The cells of a chunk, and the body with their collider, if there is one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chunk {
    pub cells: Cells,
    pub entity: Option<Entity>,
}

impl MapEntities for Voxels {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        for chunk in self.chunks.values_mut() {
            chunk.entity.map_entities(mapper);
        }
    }
}

/// The six neighbours of a cell or chunk.
pub(super) const SIDES: [IVec3; 6] = [
    IVec3::X,
    IVec3::NEG_X,
    IVec3::Y,
    IVec3::NEG_Y,
    IVec3::Z,
    IVec3::NEG_Z,
];

/// The chunk that a cell is in, and the cell in that chunk.
fn placed(cell: IVec3) -> (IVec3, IVec3) {
    let side = IVec3::splat(SIDE);
    let chunk = cell.div_euclid(side);
    (chunk, cell - chunk * side)
}

impl Voxels {
    /// An empty grid of cells with this edge, m.
    pub fn new(size: f32) -> Self {
        Self {
            size,
            splits: true,
            ground: None,
            divided: false,
            placed: Pose::default(),
            chunks: BTreeMap::new(),
            dirty: Vec::new(),
            emptied: Vec::new(),
        }
    }

    /// Sets whether parts that are no longer joined to the rest become bodies of their own. Default: `true`.
    #[must_use]
    pub fn with_splits(mut self, splits: bool) -> Self {
        self.splits = splits;
        self
    }

    /// Has the cells of a static body up to this height, as a number of cells along y, stand on the ground: a part with such a cell stays
    /// when it is cut off. Default: no cell does, and only the largest part stays.
    #[must_use]
    pub fn with_ground(mut self, ground: i32) -> Self {
        self.ground = Some(ground);
        self
    }

    /// The greatest y of cells that stand on the ground.
    pub fn ground(&self) -> Option<i32> {
        self.ground
    }

    /// The edge of a cell, m.
    pub fn size(&self) -> f32 {
        self.size
    }

    /// Whether parts that are no longer joined to the rest become bodies of their own.
    pub fn splits(&self) -> bool {
        self.splits
    }

    /// Whether a cell is filled.
    pub fn get(&self, cell: IVec3) -> bool {
        let (chunk, cell) = placed(cell);
        let chunk = self.chunks.get(&chunk.to_array());
        chunk.is_some_and(|chunk| chunk.cells.get(cell))
    }

    /// Fills or empties a cell. Returns whether that changed it. Its collider follows in the next step or [`refresh`](crate::refresh()).
    pub fn set(&mut self, cell: IVec3, filled: bool) -> bool {
        let is_changed = self.put(cell, filled);
        if is_changed && !filled && self.splits {
            self.emptied.push(cell.to_array());
        }
        is_changed
    }

    /// As [`set`](Self::set), for a cell that holds no parts together.
    pub(super) fn put(&mut self, cell: IVec3, filled: bool) -> bool {
        let (key, inside) = placed(cell);
        if !filled && !self.chunks.contains_key(&key.to_array()) {
            return false;
        }
        let chunk = self.chunk_mut(key);
        let was_full = !filled && chunk.cells.is_full();
        if !chunk.cells.set(inside, filled) {
            return false;
        }
        let covers = was_full || filled && chunk.cells.is_full();
        self.touch(key, covers);
        true
    }

    /// Fills or empties all cells from one corner up to, but without, another one. Returns how many that changed.
    pub fn set_box(&mut self, from: IVec3, to: IVec3, filled: bool) -> usize {
        if !filled {
            return self.set_all(from, to, false, |_| true);
        }
        // Chunks that are filled as a whole share their cells.
        let full = Cells::full();
        let [first, last] = [from, to - 1].map(|cell| placed(cell).0);
        let mut changed = 0;
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                for x in first.x..=last.x {
                    let key = IVec3::new(x, y, z);
                    let corner = key * SIDE;
                    let [low, high] = [from.max(corner), to.min(corner + SIDE)];
                    if (high - low) != IVec3::splat(SIDE) {
                        changed += self.set_all(low, high, true, |_| true);
                        continue;
                    }
                    let chunk = self.chunk_mut(key);
                    let more = (SIDE * SIDE * SIDE) as u32 - chunk.cells.count();
                    if more > 0 {
                        chunk.cells = full.clone();
                        self.touch(key, true);
                        changed += more as usize;
                    }
                }
            }
        }
        changed
    }

    /// Fills or empties all cells with their centre in a ball (m, in the frame of the entity). Returns how many that changed.
    pub fn set_ball(&mut self, center: Vec3, radius: f32, filled: bool) -> usize {
        let is_ball = center.is_finite() && radius > 0.0 && radius.is_finite();
        if !is_ball {
            return 0;
        }
        let (from, to) = (self.cell_at(center - radius), self.cell_at(center + radius));
        let size = self.size;
        let is_in = |cell: IVec3| {
            let at = (cell.as_vec3() + 0.5) * size;
            at.distance_squared(center) <= radius * radius
        };
        self.set_all(from, to + 1, filled, is_in)
    }

    fn set_all(
        &mut self,
        from: IVec3,
        to: IVec3,
        filled: bool,
        is_in: impl Fn(IVec3) -> bool,
    ) -> usize {
        let mut changed = 0;
        for z in from.z..to.z {
            for y in from.y..to.y {
                for x in from.x..to.x {
                    let cell = IVec3::new(x, y, z);
                    if is_in(cell) {
                        changed += usize::from(self.set(cell, filled));
                    }
                }
            }
        }
        changed
    }

    /// The cell at a point in the frame of the entity, m.
    pub fn cell_at(&self, point: Vec3) -> IVec3 {
        (point / self.size).floor().as_ivec3()
    }

    /// The centre of a cell in the frame of the entity, m.
    pub fn center_of(&self, cell: IVec3) -> Vec3 {
        (cell.as_vec3() + 0.5) * self.size
    }

    /// Number of filled cells.
    pub fn count(&self) -> usize {
        let chunks = self.chunks.values();
        chunks.map(|chunk| chunk.cells.count() as usize).sum()
    }

    /// The filled cells.
    pub fn cells(&self) -> impl Iterator<Item = IVec3> + '_ {
        self.chunks.iter().flat_map(|(key, chunk)| {
            let corner = IVec3::from_array(*key) * SIDE;
            chunk.cells.iter().map(move |cell| corner + cell)
        })
    }

    /// The sides of filled cells that nothing covers, to draw them: each as its cell and the direction in which it looks.
    pub fn faces(&self) -> impl Iterator<Item = (IVec3, IVec3)> + '_ {
        let open = self.chunks.iter().filter(|(key, _)| !self.is_buried(**key));
        let cells = open.flat_map(|(key, chunk)| {
            let corner = IVec3::from_array(*key) * SIDE;
            chunk.cells.iter().map(move |cell| corner + cell)
        });
        cells.flat_map(move |cell| {
            let open = SIDES
                .into_iter()
                .filter(move |&side| !self.get(cell + side));
            open.map(move |side| (cell, side))
        })
    }

    /// The boxes of a chunk: their centres and sizes in the frame of the entity, m.
    pub(super) fn boxes_of(&self, key: [i32; 3]) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        let boxes = self.chunks.get(&key).map(|chunk| chunk.cells.boxes());
        let corner = IVec3::from_array(key) * SIDE;
        let boxes = boxes.into_iter().flatten();
        boxes.map(move |CellBox { from, to }| {
            let middle = (corner + from).as_vec3() + 0.5 * (to - from).as_vec3();
            (middle * self.size, (to - from).as_vec3() * self.size)
        })
    }

    /// The bodies of the chunks.
    pub(super) fn chunk_bodies(&self) -> impl Iterator<Item = Entity> + '_ {
        self.chunks.values().filter_map(|chunk| chunk.entity)
    }

    /// Whether nothing can touch a chunk, since it is full and so are its neighbours.
    pub(super) fn is_buried(&self, key: [i32; 3]) -> bool {
        let full = |key: IVec3| {
            let chunk = self.chunks.get(&key.to_array());
            chunk.is_some_and(|chunk| chunk.cells.is_full())
        };
        let key = IVec3::from_array(key);
        full(key) && SIDES.into_iter().all(|side| full(key + side))
    }

    fn chunk_mut(&mut self, key: IVec3) -> &mut Chunk {
        let chunk = self.chunks.entry(key.to_array());
        chunk.or_insert_with(|| Chunk {
            cells: Cells::empty(),
            entity: None,
        })
    }

    /// Notes that a chunk has changed, and whether its neighbours may be buried no longer, or from now on.
    fn touch(&mut self, key: IVec3, covers: bool) {
        let mut note = |key: IVec3| {
            if self.dirty.last() != Some(&key.to_array()) {
                self.dirty.push(key.to_array());
            }
        };
        if covers {
            SIDES.into_iter().for_each(|side| note(key + side));
        }
        note(key);
    }
}
