//! Planes and vertices of a polyhedron eight side by side, for searches over all of them: loops that compilers turn into
//! vectors of any width, to the same bits.

use crate::collision::polyhedron::Polyhedron;
use crate::math::{Mat3, Vec3};
use crate::shape::hull::{Edge, Face};
use smallvec::{SmallVec, smallvec};

/// How many are looked at side by side.
pub(crate) const SIDE_BY_SIDE: usize = 8;

/// A number of each.
pub(crate) type Lane = [f32; SIDE_BY_SIDE];

/// Vectors by coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vectors([Lane; 3]);

impl Vectors {
    pub fn set(&mut self, lane: usize, vector: Vec3) {
        for (lanes, value) in self.0.iter_mut().zip(vector.to_array()) {
            lanes[lane] = value;
        }
    }

    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::from_array(self.0.map(|lanes| lanes[lane]))
    }

    #[inline(never)]
    pub fn turned(&self, turn: &Mat3) -> Self {
        let rows = turn.transpose();
        Self([self.dots(rows.x_axis), self.dots(rows.y_axis), self.dots(rows.z_axis)])
    }

    #[inline(always)]
    pub fn dots(&self, by: Vec3) -> Lane {
        let [x, y, z] = &self.0;
        let mut dots = [0.0; SIDE_BY_SIDE];
        for k in 0..SIDE_BY_SIDE {
            dots[k] = x[k] * by.x + y[k] * by.y + z[k] * by.z;
        }
        dots
    }
}

#[derive(Clone, Copy, Debug)]
struct Planes {
    normals: Vectors,
    offsets: Lane,
}

/// An edge with what tells which others cross it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeAxis {
    pub start: Vec3,
    pub along: Vec3,
    /// Of its faces.
    pub normals: [Vec3; 2],
    faces: [u32; 2],
    /// Length of the mean of both normals.
    middle: f32,
}

/// A polyhedron by planes and vertices; as much as a box has lies in it.
#[derive(Clone, Debug, Default)]
pub(crate) struct SideBySide {
    /// The last ones are filled up with planes that nothing is near.
    planes: SmallVec<[Planes; 1]>,
    /// The last ones are filled up with the first vertex.
    vertices: SmallVec<[Vectors; 1]>,
    pub edges: SmallVec<[EdgeAxis; 12]>,
}

impl SideBySide {
    pub fn new(vertices: &[Vec3], faces: &[Face], edges: &[Edge]) -> Self {
        let planes = faces.chunks(SIDE_BY_SIDE).map(|faces| {
            let mut planes = Planes { normals: Vectors::default(), offsets: [f32::INFINITY; SIDE_BY_SIDE] };
            for (lane, face) in faces.iter().enumerate() {
                planes.normals.set(lane, face.normal);
                planes.offsets[lane] = face.offset;
            }
            planes
        });
        let points = vertices.chunks(SIDE_BY_SIDE).map(|chunk| {
            let mut points = Vectors::default();
            (0..SIDE_BY_SIDE).for_each(|lane| points.set(lane, *chunk.get(lane).unwrap_or(&vertices[0])));
            points
        });
        let edges = edges.iter().map(|edge| {
            let [start, end] = edge.vertices.map(|vertex| vertices[vertex as usize]);
            let normals = edge.faces.map(|face| faces[face as usize].normal);
            let middle = 0.5 * (normals[0] + normals[1]).length();
            EdgeAxis { start, along: end - start, normals, faces: edge.faces, middle }
        });
        Self { planes: planes.collect(), vertices: points.collect(), edges: edges.collect() }
    }

    pub fn of(solid: &Polyhedron) -> Self {
        Self::new(solid.vertices, solid.faces, solid.edges)
    }

    /// Heights of a point above all faces, m; there may be more of them than faces.
    pub fn heights_above(&self, point: Vec3) -> SmallVec<[f32; 32]> {
        let mut heights = SmallVec::new();
        for planes in &self.planes {
            let mut lanes = planes.normals.dots(point);
            lanes.iter_mut().zip(&planes.offsets).for_each(|(height, offset)| *height -= offset);
            heights.extend_from_slice(&lanes);
        }
        heights
    }

    /// The edges that are as far as `bar` (m) from the center of the other shape along some direction on the arc between the
    /// normals of their faces, and perhaps some others; `heights` are those of the center above the faces.
    ///
    /// Along αn₀ + βn₁ with α + β = 1 the height is no more than the greater of both, by a vector no shorter than the one in
    /// the middle.
    pub fn edges_in_reach(&self, heights: &[f32], bar: f32) -> Numbers {
        if bar <= 0.0 {
            return (0..self.edges.len() as u32).collect();
        }
        let edges = &self.edges[..];
        numbers_of(edges.len(), |number| {
            let edge = &edges[number];
            let [first, second] = edge.faces.map(|face| heights[face as usize]);
            (first >= bar * edge.middle) | (second >= bar * edge.middle)
        })
    }

    /// The least `normal·x` of its vertices, m.
    pub fn least_along(&self, normal: Vec3) -> f32 {
        let mut least = [f32::INFINITY; SIDE_BY_SIDE];
        for vertices in &self.vertices {
            let heights = vertices.dots(normal);
            for k in 0..SIDE_BY_SIDE {
                least[k] = if heights[k] < least[k] { heights[k] } else { least[k] };
            }
        }
        least.iter().fold(f32::INFINITY, |least, &height| if height < least { height } else { least })
    }
}

/// Numbers of edges or faces.
pub(crate) type Numbers = SmallVec<[u32; 40]>;

/// The numbers of what something is true of; without a branch for each, since nobody could foretell it.
fn numbers_of(count: usize, is: impl Fn(usize) -> bool) -> Numbers {
    let mut numbers: Numbers = smallvec![0; count];
    let mut end = 0;
    let slots = &mut numbers[..];
    for number in 0..count {
        slots[end] = number as u32;
        end += usize::from(is(number));
    }
    numbers.truncate(end);
    numbers
}

/// The numbers of those of at least `bar`.
#[inline(never)]
pub(crate) fn at_least(heights: &[f32], bar: f32) -> Numbers {
    numbers_of(heights.len(), |number| heights[number] >= bar)
}
