//! A surface of triangles.

use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::shape::within_reach;
use parry3d::shape::{TriMesh, TriMeshFlags};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A surface of triangles, counter-clockwise seen from outside; serialized as vertices and triangles.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "MeshData", into = "MeshData")]
pub struct TriangleMesh {
    pub(crate) mesh: Arc<TriMesh>,
    /// The triangle across each edge (from vertex k to the next); `None` at the border.
    pub(crate) neighbors: Vec<[Option<u32>; 3]>,
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
        for (i, &vertex) in vertices.iter().enumerate() {
            within_reach(vertex, || format!("vertices[{i}]"))?;
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
        let neighbors = neighbors(mesh.vertices(), mesh.indices());
        Ok(Self { mesh: Arc::new(mesh), neighbors })
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

/// Finds the triangle across each edge; vertices at the same place are one, whatever their numbers.
fn neighbors(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[Option<u32>; 3]> {
    let mut number_at = BTreeMap::new();
    // Adding zero makes −0 the same place as 0.
    let place = |v: &Vec3| (*v + Vec3::ZERO).to_array().map(f32::to_bits);
    let numbers: Vec<u32> =
        (0..).zip(vertices).map(|(i, vertex)| *number_at.entry(place(vertex)).or_insert(i)).collect();
    let edge = |triangle: &[u32; 3], k: usize| (numbers[triangle[k] as usize], numbers[triangle[(k + 1) % 3] as usize]);
    // Where more than two triangles meet, none is the neighbor of another.
    let mut owner: BTreeMap<(u32, u32), Option<u32>> = BTreeMap::new();
    for (t, triangle) in (0..).zip(triangles) {
        for k in 0..3 {
            owner.entry(edge(triangle, k)).and_modify(|owner| *owner = None).or_insert(Some(t));
        }
    }
    let across = |triangle: &[u32; 3], k: usize| {
        let (start, end) = edge(triangle, k);
        owner.get(&(start, end)).copied().flatten()?;
        owner.get(&(end, start)).copied().flatten()
    };
    triangles.iter().map(|triangle| std::array::from_fn(|k| across(triangle, k))).collect()
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
