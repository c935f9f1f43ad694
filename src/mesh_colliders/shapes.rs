//! Shapes of meshes: each is made once for all entities that share mesh and shape. Decompositions are computed off the main thread.

use crate::body::collider::{Collider, ColliderError, MeshShape, mesh_triangles};
use bevy_asset::AssetId;
use bevy_mesh::Mesh;
use bevy_tasks::{AsyncComputeTaskPool, Task, block_on};
use std::collections::HashMap;

/// The shapes that were made, or are being computed, while meshes wait.
#[derive(Debug, Default)]
pub(super) struct Shapes(HashMap<AssetId<Mesh>, Vec<(MeshShape, Progress)>>);

#[derive(Debug)]
enum Progress {
    Computed(Task<Result<Collider, ColliderError>>),
    Made(Result<Collider, ColliderError>),
}

impl Shapes {
    /// The collider of a mesh, or `None` while it is being computed.
    pub(super) fn get(
        &mut self,
        id: AssetId<Mesh>,
        mesh: &Mesh,
        shape: MeshShape,
    ) -> Option<Result<Collider, ColliderError>> {
        let all = self.0.entry(id).or_default();
        let known = all.iter().position(|(of, _)| *of == shape);
        let known = known.unwrap_or_else(|| {
            all.push((shape, begin(mesh, shape)));
            all.len() - 1
        });
        let progress = &mut all[known].1;
        if let Progress::Computed(task) = progress {
            if !task.is_finished() {
                return None;
            }
            *progress = Progress::Made(block_on(task));
        }
        match progress {
            Progress::Made(collider) => Some(collider.clone()),
            Progress::Computed(_) => None,
        }
    }
}

fn begin(mesh: &Mesh, shape: MeshShape) -> Progress {
    let MeshShape::Decomposition(_) = shape else {
        return Progress::Made(Collider::from_mesh(mesh, shape));
    };
    match mesh_triangles(mesh) {
        Ok((vertices, triangles)) => {
            let work = async move { Collider::of_triangles(vertices, triangles, shape) };
            let pool = AsyncComputeTaskPool::get_or_init(Default::default);
            Progress::Computed(pool.spawn(work))
        }
        Err(error) => Progress::Made(Err(error)),
    }
}
