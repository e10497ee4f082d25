//! The convex hull of points, with the faces, edges and vertices that contacts are named by.

use crate::collision::side_by_side::SideBySide;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::shape::within_reach;
use parry3d::shape::ConvexPolyhedron;
use parry3d::transformation::try_convex_hull;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Triangles of one face may lie off its plane by this, × the greatest extent of the hull.
const COPLANAR: f32 = 1.0e-4;

/// A convex polyhedron; made from points, serialized as those points.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "HullPoints", into = "HullPoints")]
pub struct ConvexHull {
    /// As given, so that a restored hull is built from the same numbers.
    points: Vec<Vec3>,
    /// For queries and mass; contacts use the fields below.
    pub(crate) polyhedron: Arc<ConvexPolyhedron>,
    pub(crate) topology: Topology,
}

/// A plane polygon of a polyhedron: the corners `first..first + count` of the lists of corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    /// Unit, outward.
    pub normal: Vec3,
    /// `normal·x` of its points, m.
    pub offset: f32,
    pub first: u32,
    pub count: u32,
}

/// A straight line between two faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    /// In the order in which `faces[0]` walks them (counter-clockwise seen from outside).
    pub vertices: [u32; 2],
    pub faces: [u32; 2],
}

/// Vertices, edges and faces of a convex polyhedron, and what belongs to what.
#[derive(Clone, Debug, Default)]
pub(crate) struct Topology {
    pub vertices: Vec<Vec3>,
    pub faces: Vec<Face>,
    /// Vertex of every corner, face by face, counter-clockwise seen from outside.
    pub corner_vertices: Vec<u32>,
    /// Edge from every corner to the next.
    pub corner_edges: Vec<u32>,
    pub edges: Vec<Edge>,
    /// The same for searches.
    pub side_by_side: SideBySide,
    /// Mean of the vertices.
    pub center: Vec3,
    /// From `center` to the nearest face, m.
    pub inner_radius: f32,
    /// From the origin to the farthest vertex, m.
    pub outer_radius: f32,
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
        for (i, &point) in points.iter().enumerate() {
            within_reach(point, || format!("points[{i}]"))?;
        }
        let flat = || Error::invalid("points", "must span a volume: they lie in one plane or on one line");
        let (vertices, triangles) = try_convex_hull(points).map_err(|_| flat())?;
        let topology = Topology::new(&vertices, &triangles).ok_or_else(flat)?;
        let polyhedron = ConvexPolyhedron::from_convex_mesh(vertices, &triangles).ok_or_else(flat)?;
        Ok(Self { points: points.to_vec(), polyhedron: Arc::new(polyhedron), topology })
    }

    /// The points it was made from.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The corners of the hull, m.
    pub fn vertices(&self) -> &[Vec3] {
        &self.topology.vertices
    }

    /// How many faces it has: triangles in one plane are one face.
    pub fn face_count(&self) -> usize {
        self.topology.faces.len()
    }

    /// Outward unit normal of a face and the vertices around it, counter-clockwise seen from outside.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn face(&self, index: usize) -> (Vec3, &[u32]) {
        let face = self.topology.faces[index];
        let corners = face.first as usize..(face.first + face.count) as usize;
        (face.normal, &self.topology.corner_vertices[corners])
    }

    /// Distance from the mean of the vertices to the nearest face, m.
    pub fn inner_radius(&self) -> f32 {
        self.topology.inner_radius
    }
}

impl Topology {
    /// Merges the triangles of a closed convex surface into plane faces; `None` if it has no volume.
    fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let merged = merge_coplanar(points, triangles).and_then(|loops| Self::from_loops(points, &loops));
        // A surface too ragged to merge keeps its triangles: more faces than needed, but none wrong.
        let topology = merged.or_else(|| {
            let loops: Vec<_> = triangles.iter().map(|t| t.to_vec()).collect();
            Self::from_loops(points, &loops)
        })?;
        (topology.inner_radius > 0.0).then_some(topology)
    }

    fn from_loops(points: &[Vec3], loops: &[Vec<u32>]) -> Option<Self> {
        let mut topology = Self::default();
        let mut number = vec![u32::MAX; points.len()];
        for &corner in loops.iter().flatten() {
            let number = &mut number[corner as usize];
            if *number == u32::MAX {
                *number = topology.vertices.len() as u32;
                topology.vertices.push(points[corner as usize]);
            }
        }
        let mut edge_of = BTreeMap::new();
        for (face, corners) in loops.iter().enumerate() {
            let corners: Vec<u32> = corners.iter().map(|&c| number[c as usize]).collect();
            topology.push_face(face as u32, &corners, &mut edge_of)?;
        }
        if topology.edges.iter().any(|edge| edge.faces[1] == u32::MAX) {
            return None;
        }
        let sum: Vec3 = topology.vertices.iter().sum();
        topology.center = sum / topology.vertices.len() as f32;
        let distance = |face: &Face| face.offset - face.normal.dot(topology.center);
        topology.outer_radius = topology.vertices.iter().map(|v| v.length()).fold(0.0, f32::max);
        topology.inner_radius = topology.faces.iter().map(distance).fold(f32::INFINITY, f32::min);
        topology.side_by_side = SideBySide::new(&topology.vertices, &topology.faces, &topology.edges);
        Some(topology)
    }

    fn push_face(
        &mut self,
        index: u32,
        corners: &[u32],
        edge_of: &mut BTreeMap<(u32, u32), (u32, bool)>,
    ) -> Option<()> {
        let first = self.corner_vertices.len() as u32;
        for (i, &start) in corners.iter().enumerate() {
            let end = corners[(i + 1) % corners.len()];
            let next = self.edges.len() as u32;
            let (edge, complete) = edge_of.entry((start.min(end), start.max(end))).or_insert((next, false));
            if *edge == next {
                self.edges.push(Edge { vertices: [start, end], faces: [index, u32::MAX] });
            } else {
                // A third face, or a neighbor that walks the edge the same way: not a closed surface.
                if *complete || self.edges[*edge as usize].vertices != [end, start] {
                    return None;
                }
                self.edges[*edge as usize].faces[1] = index;
                *complete = true;
            }
            self.corner_vertices.push(start);
            self.corner_edges.push(*edge);
        }
        let normal = newell(&self.vertices, corners).try_normalize()?;
        let heights = corners.iter().map(|&c| normal.dot(self.vertices[c as usize]));
        let offset = heights.fold(f32::NEG_INFINITY, f32::max);
        self.faces.push(Face { normal, offset, first, count: corners.len() as u32 });
        Some(())
    }
}

/// Twice the area of a polygon times its normal (Newell): Σ pᵢ × pᵢ₊₁, taken about its first corner.
fn newell(vertices: &[Vec3], corners: &[u32]) -> Vec3 {
    let origin = vertices[corners[0] as usize];
    let at = |i: usize| vertices[corners[i] as usize] - origin;
    (1..corners.len() - 1).map(|i| at(i).cross(at(i + 1))).sum()
}

/// The boundary loops of the plane faces of a triangulated convex surface, without corners on straight lines.
fn merge_coplanar(points: &[Vec3], triangles: &[[u32; 3]]) -> Option<Vec<Vec<u32>>> {
    let mut owner_of_edge = BTreeMap::new();
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            owner_of_edge.insert((corners[k], corners[(k + 1) % 3]), t);
        }
    }
    let region = grow_regions(points, triangles, &owner_of_edge)?;
    let region_count = region.iter().max()? + 1;

    // Walk around each region along the edges that no triangle of the same region shares.
    let mut next_corner = vec![BTreeMap::new(); region_count];
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (start, end) = (corners[k], corners[(k + 1) % 3]);
            let neighbor = *owner_of_edge.get(&(end, start))?;
            if region[neighbor] != region[t] && next_corner[region[t]].insert(start, end).is_some() {
                return None;
            }
        }
    }
    let mut loops = Vec::with_capacity(region_count);
    for next in &next_corner {
        let (&start, _) = next.iter().next()?;
        let mut corners = vec![start];
        let mut corner = *next.get(&start)?;
        while corner != start && corners.len() <= next.len() {
            corners.push(corner);
            corner = *next.get(&corner)?;
        }
        if corners.len() != next.len() {
            return None;
        }
        loops.push(corners);
    }

    // A corner of only two faces lies on the straight line between them.
    let mut uses = vec![0; points.len()];
    loops.iter().flatten().for_each(|&c| uses[c as usize] += 1);
    for corners in &mut loops {
        corners.retain(|&c| uses[c as usize] > 2);
        if corners.len() < 3 {
            return None;
        }
    }
    Some(loops)
}

/// Which plane face each triangle belongs to: faces grow from the greatest triangle left.
fn grow_regions(
    points: &[Vec3],
    triangles: &[[u32; 3]],
    owner_of_edge: &BTreeMap<(u32, u32), usize>,
) -> Option<Vec<usize>> {
    let least = points.iter().fold(Vec3::INFINITY, |a, &b| a.min(b));
    let greatest = points.iter().fold(Vec3::NEG_INFINITY, |a, &b| a.max(b));
    let size = (greatest - least).max_element();
    let doubled_area: Vec<Vec3> = triangles.iter().map(|t| newell(points, t)).collect();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&a, &b| doubled_area[b].length_squared().total_cmp(&doubled_area[a].length_squared()));

    let mut region = vec![usize::MAX; triangles.len()];
    let mut count = 0;
    for seed in order {
        if region[seed] != usize::MAX {
            continue;
        }
        let normal = doubled_area[seed].try_normalize()?;
        let origin = points[triangles[seed][0] as usize];
        region[seed] = count;
        let mut to_visit = vec![seed];
        while let Some(t) = to_visit.pop() {
            for k in 0..3 {
                let neighbor = *owner_of_edge.get(&(triangles[t][(k + 1) % 3], triangles[t][k]))?;
                let flat = triangles[neighbor]
                    .iter()
                    .all(|&c| (points[c as usize] - origin).dot(normal).abs() <= COPLANAR * size);
                // The normal of a sliver is noise; of all others it must not turn away.
                let area = doubled_area[neighbor];
                let sliver = area.length() < 10.0 * COPLANAR * size * size;
                if region[neighbor] == usize::MAX && flat && (sliver || area.dot(normal) > 0.99 * area.length()) {
                    region[neighbor] = count;
                    to_visit.push(neighbor);
                }
            }
        }
        count += 1;
    }
    Some(region)
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
