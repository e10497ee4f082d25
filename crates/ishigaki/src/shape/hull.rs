//! The convex hull of points, with the faces, edges and vertices that contacts are named by.

use crate::error::{Error, Result};
use crate::math::Vec3;
use parry3d::shape::ConvexPolyhedron;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A convex polyhedron; made from points, serialized as those points.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "HullPoints", into = "HullPoints")]
pub struct ConvexHull {
    /// As given, so that a restored hull is built from the same numbers.
    points: Vec<Vec3>,
    pub(crate) polyhedron: Arc<ConvexPolyhedron>,
}

#[derive(Serialize, Deserialize)]
struct HullPoints {
    points: Vec<Vec3>,
}

impl ConvexHull {
    /// The hull of at least four points that do not lie in one plane, m.
    ///
    /// # Errors
    /// Fewer than four points, not finite, or all in one plane.
    pub fn new(points: &[Vec3]) -> Result<Self> {
        if points.len() < 4 {
            return Err(Error::invalid("points", format!("a hull needs at least 4 points, has {}", points.len())));
        }
        let polyhedron = ConvexPolyhedron::from_convex_hull(points)
            .ok_or_else(|| Error::invalid("points", "must span a volume: they lie in one plane or on one line"))?;
        Ok(Self { points: points.to_vec(), polyhedron: Arc::new(polyhedron) })
    }

    /// The points it was made from.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The corners of the hull, m.
    pub fn vertices(&self) -> &[Vec3] {
        self.polyhedron.points()
    }

    /// Distance from the mean of the vertices to the nearest face, m.
    pub fn inner_radius(&self) -> f32 {
        let vertices = self.polyhedron.points();
        let center = vertices.iter().sum::<Vec3>() / vertices.len() as f32;
        let faces = self.polyhedron.faces().iter();
        let distances = faces.map(|face| {
            let corner = self.polyhedron.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
            face.normal.dot(vertices[corner as usize] - center)
        });
        distances.fold(f32::INFINITY, f32::min).max(0.0)
    }
}

impl PartialEq for ConvexHull {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points
    }
}

impl TryFrom<HullPoints> for ConvexHull {
    type Error = Error;
    fn try_from(from: HullPoints) -> Result<Self> {
        Self::new(&from.points)
    }
}

impl From<ConvexHull> for HullPoints {
    fn from(hull: ConvexHull) -> Self {
        Self { points: hull.points }
    }
}
