//! A surface of triangles.

use crate::error::{Error, Result};
use crate::math::Vec3;
use parry3d::shape::{TriMesh, TriMeshFlags};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A surface of triangles, counter-clockwise seen from outside; serialized as vertices and triangles.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "MeshData", into = "MeshData")]
pub struct TriangleMesh {
    pub(crate) mesh: Arc<TriMesh>,
}

#[derive(Serialize, Deserialize)]
struct MeshData {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// A mesh of at least one triangle, m.
    ///
    /// # Errors
    /// No triangle, an index out of range, a vertex that is not finite.
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        if triangles.is_empty() {
            return Err(Error::invalid("triangles", "a mesh needs at least one triangle"));
        }
        if let Some(i) = vertices.iter().position(|v| !v.is_finite()) {
            return Err(Error::invalid(format!("vertices[{i}]"), "must be finite"));
        }
        for (i, triangle) in triangles.iter().enumerate() {
            if let Some(&bad) = triangle.iter().find(|&&v| v as usize >= vertices.len()) {
                return Err(Error::invalid(
                    format!("triangles[{i}]"),
                    format!("vertex {bad} does not exist: there are {}", vertices.len()),
                ));
            }
        }
        let mesh = TriMesh::with_flags(vertices, triangles, TriMeshFlags::FIX_INTERNAL_EDGES)
            .map_err(|e| Error::invalid("triangles", e.to_string()))?;
        Ok(Self { mesh: Arc::new(mesh) })
    }

    /// Vertices, m.
    pub fn vertices(&self) -> &[Vec3] {
        self.mesh.vertices()
    }

    /// Vertex indices of the triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.mesh.indices()
    }
}

impl PartialEq for TriangleMesh {
    fn eq(&self, other: &Self) -> bool {
        self.vertices() == other.vertices() && self.triangles() == other.triangles()
    }
}

impl TryFrom<MeshData> for TriangleMesh {
    type Error = Error;
    fn try_from(from: MeshData) -> Result<Self> {
        Self::new(from.vertices, from.triangles)
    }
}

impl From<TriangleMesh> for MeshData {
    fn from(mesh: TriangleMesh) -> Self {
        Self { vertices: mesh.vertices().to_vec(), triangles: mesh.triangles().to_vec() }
    }
}
