//! Shapes of meshes: each is made once for all entities that share mesh and shape. Decompositions are computed off the main thread.

use crate::body::collider::{Collider, ColliderError, MeshShape, mesh_triangles};
use bevy_asset::AssetId;
use bevy_mesh::Mesh;
use bevy_tasks::{AsyncComputeTaskPool, Task, block_on};
use std::collections::HashMap;

/// Decompositions that are being computed.
#[derive(Debug, Default)]
pub(super) struct Decompositions(
    Vec<(
        AssetId<Mesh>,
        MeshShape,
        Task<Result<Collider, ColliderError>>,
    )>,
);

/// The shapes that were made in one run of the system.
pub(super) struct Shapes<'a> {
    pub(super) made: HashMap<AssetId<Mesh>, Vec<(MeshShape, Result<Collider, ColliderError>)>>,
    pub(super) decompositions: &'a mut Decompositions,
}

impl Shapes<'_> {
    /// The collider of a mesh, or `None` while it is being computed.
    pub(super) fn get(
        &mut self,
        id: AssetId<Mesh>,
        mesh: &Mesh,
        shape: MeshShape,
    ) -> Option<Result<Collider, ColliderError>> {
        let made = self.made.entry(id).or_default();
        if let Some((_, known)) = made.iter().find(|(of, _)| *of == shape) {
            return Some(known.clone());
        }
        let collider = match shape {
            MeshShape::Decomposition(_) => self.decompositions.poll(id, mesh, shape)?,
            _ => Collider::from_mesh(mesh, shape),
        };
        made.push((shape, collider.clone()));
        Some(collider)
    }
}

impl Decompositions {
    /// The result if it is there. Begins to compute it if nobody has.
    fn poll(
        &mut self,
        id: AssetId<Mesh>,
        mesh: &Mesh,
        shape: MeshShape,
    ) -> Option<Result<Collider, ColliderError>> {
        let jobs = &mut self.0;
        let known = jobs
            .iter()
            .position(|(of, known, _)| (*of, *known) == (id, shape));
        let Some(known) = known else {
            let (vertices, triangles) = match mesh_triangles(mesh) {
                Ok(mesh) => mesh,
                Err(error) => return Some(Err(error)),
            };
            let work = async move { Collider::of_triangles(vertices, triangles, shape) };
            let pool = AsyncComputeTaskPool::get_or_init(Default::default);
            jobs.push((id, shape, pool.spawn(work)));
            return None;
        };
        let is_done = jobs[known].2.is_finished();
        is_done.then(|| block_on(jobs.swap_remove(known).2))
    }
}
