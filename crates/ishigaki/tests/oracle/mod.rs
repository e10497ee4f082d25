//! Distance and overlap of convex bodies by brute force in f64: every plane, every pair of edges, no tricks.

use parry3d::glamx::DVec3;

/// Splitmix64: the same pairs in every run.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.bits() >> 40) as f32 / (1u64 << 24) as f32)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }
}

/// The convex hull of points, inflated by a radius.
#[derive(Clone)]
pub struct Body {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[usize; 3]>,
    pub edges: Vec<[usize; 2]>,
    pub radius: f64,
}

impl Body {
    /// All triples of points that have all others on one side are faces; what two planes share is an edge.
    pub fn hull(points: Vec<DVec3>, radius: f64) -> Self {
        let mut body = Self { points, triangles: Vec::new(), edges: Vec::new(), radius };
        let count = body.points.len();
        let size = body.points.iter().fold(0.0, |s: f64, p| s.max(p.length()));
        let mut planes: Vec<DVec3> = Vec::new();
        let mut on_planes: Vec<Vec<bool>> = Vec::new();
        for i in 0..count {
            for j in i + 1..count {
                for k in j + 1..count {
                    let p = [body.points[i], body.points[j], body.points[k]];
                    let Some(mut normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
                    let height = |q: &DVec3, n: DVec3| n.dot(*q - p[0]);
                    if body.points.iter().any(|q| height(q, normal) > 1e-6 * size) {
                        normal = -normal;
                    }
                    if body.points.iter().any(|q| height(q, normal) > 1e-6 * size) {
                        continue;
                    }
                    body.triangles.push([i, j, k]);
                    if planes.iter().all(|n| n.dot(normal) < 1.0 - 1e-9) {
                        planes.push(normal);
                        on_planes.push(body.points.iter().map(|q| height(q, normal).abs() < 1e-6 * size).collect());
                    }
                }
            }
        }
        for i in 0..count {
            for j in i + 1..count {
                if count == 2 || on_planes.iter().filter(|on| on[i] && on[j]).count() >= 2 {
                    body.edges.push([i, j]);
                }
            }
        }
        body
    }

    pub fn placed(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        Self { points: self.points.iter().map(|&p| place(p)).collect(), ..self.clone() }
    }

    fn reach(&self, direction: DVec3) -> f64 {
        self.points.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn corners(&self, t: &[usize; 3]) -> [DVec3; 3] {
        t.map(|i| self.points[i])
    }

    fn normals(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.triangles.iter().filter_map(|t| {
            let [a, b, c] = self.corners(t);
            (b - a).cross(c - a).try_normalize()
        })
    }

    fn directions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.edges.iter().map(|&[i, j]| self.points[j] - self.points[i])
    }

    /// How far a point is from the surface, m: negative inside.
    pub fn height_of(&self, point: DVec3) -> f64 {
        signed_distance(self, &Self { points: vec![point], triangles: vec![], edges: vec![], radius: 0.0 })
    }
}

/// Separation of B from A along a direction from A to B.
pub fn separation_along(a: &Body, b: &Body, direction: DVec3) -> f64 {
    -b.reach(-direction) - a.reach(direction) - a.radius - b.radius
}

/// Distance of two bodies, or minus the least translation that parts them.
pub fn signed_distance(a: &Body, b: &Body) -> f64 {
    let mut best = f64::NEG_INFINITY;
    let radii = a.radius + b.radius;
    let mut consider = |axis: DVec3| {
        if let Some(axis) = axis.try_normalize() {
            best = best.max(separation_along(a, b, axis)).max(separation_along(a, b, -axis));
        }
    };
    a.normals().chain(b.normals()).for_each(&mut consider);
    for along_a in a.directions() {
        for along_b in b.directions() {
            let cross = along_a.cross(along_b);
            if cross.length() > 1e-9 * along_a.length() * along_b.length() {
                consider(cross);
            }
        }
    }
    let solid = !a.triangles.is_empty() || !b.triangles.is_empty();
    if solid && best + radii <= 0.0 {
        return best;
    }
    core_distance(a, b) - radii
}

/// Distance of the point sets' hulls, which do not overlap: all pairs of features.
fn core_distance(a: &Body, b: &Body) -> f64 {
    let mut best = f64::INFINITY;
    for (p, q) in [(a, b), (b, a)] {
        for &point in &p.points {
            for t in &q.triangles {
                best = best.min(point_triangle(point, q.corners(t)));
            }
            for &[i, j] in &q.edges {
                best = best.min(segment_segment([point, point], [q.points[i], q.points[j]]));
            }
            for &other in &q.points {
                best = best.min((other - point).length());
            }
        }
    }
    for &[i, j] in &a.edges {
        for &[k, l] in &b.edges {
            best = best.min(segment_segment([a.points[i], a.points[j]], [b.points[k], b.points[l]]));
        }
    }
    best
}

/// Distance to the inside of a triangle; infinite beside it (edges are looked at on their own).
fn point_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return f64::INFINITY };
    let beside = |s: DVec3, e: DVec3| (e - s).cross(p - s).dot(normal) < 0.0;
    if beside(a, b) || beside(b, c) || beside(c, a) { f64::INFINITY } else { normal.dot(p - a).abs() }
}

fn segment_segment([p1, q1]: [DVec3; 2], [p2, q2]: [DVec3; 2]) -> f64 {
    let on = |p: DVec3, s: DVec3, e: DVec3| {
        let along = e - s;
        let square = along.length_squared();
        let t = if square > 0.0 { ((p - s).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
        (s + along * t - p).length()
    };
    let ends = on(p1, p2, q2).min(on(q1, p2, q2)).min(on(p2, p1, q1)).min(on(q2, p1, q1));
    // Crossing: both nearest points inside.
    let (d1, d2, r) = (q1 - p1, q2 - p2, p2 - p1);
    let cross = d1.cross(d2);
    let square = cross.length_squared();
    if square < 1e-18 * d1.length_squared() * d2.length_squared() {
        return ends;
    }
    let (s, t) = (r.cross(d2).dot(cross) / square, r.cross(d1).dot(cross) / square);
    if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
        ends.min((r.dot(cross) / square.sqrt()).abs())
    } else {
        ends
    }
}
