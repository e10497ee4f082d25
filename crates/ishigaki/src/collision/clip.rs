//! Contact points of two touching polygons: the incident one is clipped to the prism over the reference one.
//!
//! Sutherland and Hodgman (1974). Every side of the clipped polygon remembers whether it is a side of the
//! incident or of the reference polygon, so a corner is known by the two sides that meet in it: two incident
//! sides make an incident vertex (vertex × face), one of each a crossing (edge × edge), two reference sides a
//! reference corner inside the incident face (face × vertex). The names are the same whichever polygon is the
//! reference. Without them warm starting hands impulses to the wrong points when a box turns.
//! Tests: `tests/feature_ids.rs`.

use crate::collision::feature_id::{Feature, FeatureId};
use crate::collision::manifold::LocalPoint;
use crate::collision::polyhedron::Polygon;
use crate::math::Vec3;
use smallvec::SmallVec;

/// Points before they are reduced to four.
pub(crate) type Candidates = SmallVec<[LocalPoint; 16]>;

/// A corner of the polygon that is being clipped.
#[derive(Clone, Copy)]
struct Clipped {
    point: Vec3,
    /// Side that leaves it: the number of an incident side, or `REFERENCE` + the number of a reference side.
    side: u32,
}

pub(crate) const REFERENCE: u32 = 1 << 31;

type Ring = SmallVec<[Clipped; 16]>;

/// How points of a clipped polygon become contact points.
#[derive(Clone, Copy)]
pub(crate) struct Clip {
    /// Whether the reference polygon belongs to A.
    pub reference_is_a: bool,
    /// The incident surface is this far in front of the incident polygon (capsules), m.
    pub radius: f32,
    /// Points up to this separation are kept, m.
    pub margin: f32,
    /// Points this far outside count as inside, m: a vertex that lies on a side keeps its name when it trembles.
    pub tolerance: f32,
}

impl Clip {
    /// Appends the contact points of `incident` over `reference`.
    pub fn points(self, reference: &Polygon, incident: &Polygon, out: &mut Candidates) {
        let count = incident.corners.len() as u32;
        let mut ring: Ring =
            incident.corners.iter().zip(0..count).map(|(corner, side)| Clipped { point: corner.point, side }).collect();
        let corners = &reference.corners;
        for (i, corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()];
            let Some(outward) = (next.point - corner.point).cross(reference.normal).try_normalize() else { continue };
            clip_by_side(&mut ring, outward, outward.dot(corner.point) + self.tolerance, REFERENCE | i as u32);
        }
        for i in 0..ring.len() {
            let before = ring[if i == 0 { ring.len() - 1 } else { i - 1 }].side;
            let Clipped { point, side } = ring[i];
            let height = reference.normal.dot(point) - reference.offset;
            let separation = height - self.radius;
            if separation <= self.margin {
                let on_reference = point - reference.normal * height;
                let on_incident = point - reference.normal * self.radius;
                let (of_reference, of_incident) = features(reference, incident, before, side);
                out.push(if self.reference_is_a {
                    let id = FeatureId::new(of_reference, of_incident);
                    LocalPoint { on_a: on_reference, on_b: on_incident, separation, id }
                } else {
                    let id = FeatureId::new(of_incident, of_reference);
                    LocalPoint { on_a: on_incident, on_b: on_reference, separation, id }
                });
            }
        }
    }
}

/// Keeps what lies below the plane `outward·x = offset`.
fn clip_by_side(ring: &mut Ring, outward: Vec3, offset: f32, side: u32) {
    let height = |corner: &Clipped| outward.dot(corner.point) - offset;
    if ring.iter().all(|corner| height(corner) <= 0.0) {
        return;
    }
    let mut kept = Ring::new();
    for i in 0..ring.len() {
        let (here, next) = (ring[i], ring[if i + 1 == ring.len() { 0 } else { i + 1 }]);
        let (d_here, d_next) = (height(&here), height(&next));
        if d_here <= 0.0 {
            kept.push(here);
        }
        if (d_here <= 0.0) != (d_next <= 0.0) {
            let point = here.point + (next.point - here.point) * (d_here / (d_here - d_next));
            // Leaving, the polygon goes on along the clipping side; entering, along the side it was on.
            kept.push(Clipped { point, side: if d_here <= 0.0 { side } else { here.side } });
        }
    }
    *ring = kept;
}

/// What the corners of a polygon are called in their shape.
pub(crate) trait Sides {
    /// Number of the face.
    fn face(&self) -> u32;
    /// How many corners it has.
    fn count(&self) -> usize;
    /// Number of the vertex in a corner.
    fn vertex(&self, corner: usize) -> u32;
    /// Number of the edge from a corner to the next.
    fn edge(&self, corner: usize) -> u32;
}

impl Sides for Polygon {
    fn face(&self) -> u32 {
        self.face
    }

    fn count(&self) -> usize {
        self.corners.len()
    }

    fn vertex(&self, corner: usize) -> u32 {
        self.corners[corner].vertex
    }

    fn edge(&self, corner: usize) -> u32 {
        self.corners[corner].edge
    }
}

/// What touches what in the corner where side `before` ends and side `after` begins: (of reference, of incident).
pub(crate) fn features(reference: &impl Sides, incident: &impl Sides, before: u32, after: u32) -> (Feature, Feature) {
    let crossing = |reference_side: u32, incident_side: u32| {
        let of_reference = reference.edge((reference_side & !REFERENCE) as usize);
        (Feature::edge(of_reference), Feature::edge(incident.edge(incident_side as usize)))
    };
    match (before & REFERENCE != 0, after & REFERENCE != 0) {
        (false, false) => (Feature::face(reference.face()), Feature::vertex(incident.vertex(after as usize))),
        (false, true) => crossing(after, before),
        (true, false) => crossing(before, after),
        (true, true) => {
            // Seen from the reference the incident polygon runs clockwise, so the side after is the side before in
            // the reference polygon, and the corner between them begins the latter.
            let (before, after) = ((before & !REFERENCE) as usize, (after & !REFERENCE) as usize);
            let corner = if (after + 1) % reference.count() == before { before } else { after };
            (Feature::vertex(reference.vertex(corner)), Feature::face(incident.face()))
        }
    }
}

/// Nearest points of two segments, as parts s and t in [0, 1] of their lengths.
///
/// Where the segments are parallel the points in the middle of their overlap are taken.
pub(crate) fn nearest_on_segments([p1, q1]: [Vec3; 2], [p2, q2]: [Vec3; 2]) -> (f32, f32) {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e) = (d1.length_squared(), d2.length_squared());
    let (c, f) = (d1.dot(r), d2.dot(r));
    if a <= f32::MIN_POSITIVE {
        let t = if e <= f32::MIN_POSITIVE { 0.0 } else { (f / e).clamp(0.0, 1.0) };
        return (0.0, t);
    }
    if e <= f32::MIN_POSITIVE {
        return ((-c / a).clamp(0.0, 1.0), 0.0);
    }
    // |d1 × d2|² = a e − b², without its cancellation.
    let b = d1.dot(d2);
    let denominator = d1.cross(d2).length_squared();
    let s = if denominator > 1e-6 * a * e {
        ((b * f - c * e) / denominator).clamp(0.0, 1.0)
    } else {
        // Parallel: the ends of segment 2 on segment 1.
        let (s0, s1) = (-c / a, (b - c) / a);
        let (low, high) = (s0.min(s1).clamp(0.0, 1.0), s0.max(s1).clamp(0.0, 1.0));
        0.5 * (low + high)
    };
    let t = (b * s + f) / e;
    if (0.0..=1.0).contains(&t) {
        return (s, t);
    }
    let t = t.clamp(0.0, 1.0);
    (((b * t - c) / a).clamp(0.0, 1.0), t)
}
