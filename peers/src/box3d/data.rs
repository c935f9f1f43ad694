//! Hulls, meshes and height fields that Box3D made and that must be given back.

use super::world::vec3;
use box3d_sys as b3;
use drystone::prelude::Vec3;

/// A convex hull that Box3D made and that must be given back.
pub struct Hull(*mut b3::b3HullData);

impl Hull {
    /// # Errors
    /// If there is none, or one with other corners: Box3D welds what is close together.
    pub fn new(corners: &[Vec3]) -> Result<Self, String> {
        let points: Vec<b3::b3Vec3> = corners.iter().copied().map(vec3).collect();
        let most = b3::B3_MAX_HULL_VERTICES as usize;
        if points.len() > most {
            let count = points.len();
            return Err(format!(
                "Box3D has no hulls of {count} corners, only of {most}"
            ));
        }
        let count = points.len() as i32;
        // SAFETY: so many points are there, all finite, and Box3D keeps none.
        let hull = Self(unsafe { b3::b3CreateHull(points.as_ptr(), count, count) });
        if hull.0.is_null() {
            return Err(format!("Box3D makes no hull of these {count} corners"));
        }
        // SAFETY: not null, and so a whole hull.
        match unsafe { (*hull.0).vertexCount } {
            made if made == count => Ok(hull),
            made => Err(format!(
                "Box3D makes a hull of {made} corners of these {count}"
            )),
        }
    }
}

impl Hull {
    pub fn data(&self) -> *const b3::b3HullData {
        self.0
    }
}

impl Drop for Hull {
    fn drop(&mut self) {
        if !self.0.is_null() {
            // SAFETY: Box3D made it, and no other code has it: shapes have copies.
            unsafe { b3::b3DestroyHull(self.0) }
        }
    }
}

/// A triangle mesh.
pub struct Mesh(*mut b3::b3MeshData);

impl Mesh {
    /// # Errors
    /// If Box3D makes none of it, or leaves out triangles.
    pub fn new(corners: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, String> {
        let mut vertices: Vec<b3::b3Vec3> = corners.iter().copied().map(vec3).collect();
        let mut indices: Vec<i32> = triangles.iter().flatten().map(|&i| i as i32).collect();
        // SAFETY: so many corners and triangles are there, all finite and in range, Box3D keeps none, and all other fields may be zero.
        let mesh = Self(unsafe {
            let mut definition: b3::b3MeshDef = std::mem::zeroed();
            definition.vertices = vertices.as_mut_ptr();
            definition.indices = indices.as_mut_ptr();
            definition.vertexCount = vertices.len() as i32;
            definition.triangleCount = triangles.len() as i32;
            // So that bodies do not catch on inner edges.
            definition.identifyEdges = true;
            b3::b3CreateMesh(&definition, std::ptr::null_mut(), 0)
        });
        // SAFETY: if it is not null, it is a whole mesh.
        match !mesh.0.is_null() && unsafe { (*mesh.0).triangleCount } == triangles.len() as i32 {
            true => Ok(mesh),
            false => Err("Box3D makes no mesh of all these triangles".into()),
        }
    }

    pub fn data(&self) -> *const b3::b3MeshData {
        self.0
    }
}

impl Drop for Mesh {
    fn drop(&mut self) {
        if !self.0.is_null() {
            // SAFETY: Box3D made it, and the world whose shapes refer to it is gone.
            unsafe { b3::b3DestroyMesh(self.0) }
        }
    }
}

/// A height field.
pub struct Field(*mut b3::b3HeightFieldData);

impl Field {
    /// Heights, m, by rows along z, of so many columns and rows, and the distances of its points, m.
    ///
    /// # Errors
    /// If Box3D makes none of it.
    pub fn new(heights: &[f32], counts: [usize; 2], scale: Vec3) -> Result<Self, String> {
        let mut heights = heights.to_vec();
        let all = heights.iter().copied();
        let (low, high) = all.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        // SAFETY: so many heights are there, all finite, Box3D keeps none, and all other fields may be zero.
        let field = Self(unsafe {
            let mut definition: b3::b3HeightFieldDef = std::mem::zeroed();
            definition.heights = heights.as_mut_ptr();
            definition.scale = vec3(scale);
            [definition.countX, definition.countZ] = counts.map(|count| count as i32);
            definition.globalMinimumHeight = low;
            definition.globalMaximumHeight = high;
            b3::b3CreateHeightField(&definition)
        });
        match field.0.is_null() {
            true => Err("Box3D makes no field of these heights".into()),
            false => Ok(field),
        }
    }

    pub fn data(&self) -> *const b3::b3HeightFieldData {
        self.0
    }
}

impl Drop for Field {
    fn drop(&mut self) {
        if !self.0.is_null() {
            // SAFETY: Box3D made it, and the world whose shapes refer to it is gone.
            unsafe { b3::b3DestroyHeightField(self.0) }
        }
    }
}
