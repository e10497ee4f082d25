//! Surfaces from files as convex hulls: STL (binary and ASCII) and Wavefront OBJ.
//!
//! STL is read by `stl_io`; of OBJ only vertices and faces matter here, and the known readers panic on malformed
//! materials and texture indices, so those two kinds of lines are read below.

use crate::models::inertia::{Inertia, of_surface, principal_axes};
use glamx::{DMat3, DVec3};
use ishigaki::math::Vec3;
use parry3d::transformation::try_convex_hull;
use std::io::Cursor;
use std::path::Path;

/// Hulls with more vertices than this are simplified: the narrow phase looks at each of them.
const MAX_HULL_VERTICES: usize = 128;
/// A mesh with more triangles than this is refused.
const MAX_TRIANGLES: usize = 4_000_000;
/// Coordinates beyond this cannot be told from rubbish, m.
const MAX_COORDINATE: f64 = 1.0e6;

/// A surface of triangles, m.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct TriangleSoup {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// The convex hull of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub points: Vec<Vec3>,
    /// Of the hull, density 1 kg/m³.
    pub inertia: Inertia,
    /// Of what the surface encloses, density 1 kg/m³; `None` if it does not enclose anything sensibly.
    pub solid: Option<Inertia>,
    /// How many vertices the hull had before it was simplified.
    pub exact_vertices: usize,
}

impl Hull {
    /// By how much it is larger than the surface (hollows filled) and than its own exact form, as a sentence.
    pub fn approximation(&self) -> Option<String> {
        let mut said = Vec::new();
        match self.solid {
            Some(solid) if solid.mass < 0.95 * self.inertia.mass => {
                let part = 100.0 * (self.inertia.mass / solid.mass - 1.0);
                said.push(format!("is not convex: its hull is {part:.0} % larger"));
            }
            None => said.push("is not a closed surface: taken as its hull".into()),
            _ => {}
        }
        if self.points.len() < self.exact_vertices {
            said.push(format!("its hull's {} vertices are simplified to {}", self.exact_vertices, self.points.len()));
        }
        (!said.is_empty()).then(|| said.join("; "))
    }
}

/// Reads a file by its extension.
pub(crate) fn load(path: &Path) -> Result<TriangleSoup, String> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if !matches!(extension.as_str(), "stl" | "obj") {
        return Err(format!("`.{extension}` meshes are not read: convert it to STL or OBJ"));
    }
    let bytes = std::fs::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    let soup = if extension == "stl" { read_stl(bytes)? } else { read_obj(&String::from_utf8_lossy(&bytes))? };
    let wrong = |v: &DVec3| !(v.is_finite() && v.abs().max_element() <= MAX_COORDINATE);
    if let Some(i) = soup.vertices.iter().position(wrong) {
        return Err(format!("vertex {i} is not finite or beyond {MAX_COORDINATE} m"));
    }
    Ok(soup)
}

pub(crate) fn read_stl(mut bytes: Vec<u8>) -> Result<TriangleSoup, String> {
    // Binary files whose header starts with "solid" exist; their length gives them away.
    let count = bytes.get(80..84).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if count.is_some_and(|n| 84 + 50 * u64::from(n) == bytes.len() as u64) {
        bytes[0] = b' ';
    }
    let mut cursor = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(|e| format!("is not STL: {e}"))?;
    let mut soup = TriangleSoup::default();
    // Not collected at once: the header's count may be anything.
    for triangle in reader {
        let triangle = triangle.map_err(|e| format!("is damaged: {e}"))?;
        let first = soup.vertices.len() as u32;
        soup.vertices.extend(triangle.vertices.map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())));
        soup.triangles.push([first, first + 1, first + 2]);
        too_many(&soup)?;
    }
    Ok(soup)
}

pub(crate) fn read_obj(text: &str) -> Result<TriangleSoup, String> {
    let mut soup = TriangleSoup::default();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|w| w.parse::<f64>().ok());
                let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
                    return Err(format!("line {}: a vertex needs three numbers", i + 1));
                };
                soup.vertices.push(DVec3::new(x, y, z));
            }
            Some("f") => {
                let count = soup.vertices.len() as i64;
                // `7`, `7/1`, `7//3`: the first is the vertex, from 1; negative ones count from the last.
                let index = |word: &str| {
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if number < 0 { count + number } else { number - 1 };
                    (0..count).contains(&index).then_some(index as u32)
                };
                let corners: Option<Vec<u32>> = words.map(index).collect();
                let Some(corners) = corners.filter(|c| c.len() >= 3) else {
                    return Err(format!("line {}: a face needs three or more known vertices", i + 1));
                };
                for pair in corners[1..].windows(2) {
                    soup.triangles.push([corners[0], pair[0], pair[1]]);
                }
                too_many(&soup)?;
            }
            _ => {}
        }
    }
    Ok(soup)
}

fn too_many(soup: &TriangleSoup) -> Result<(), String> {
    if soup.triangles.len() > MAX_TRIANGLES || soup.vertices.len() > 3 * MAX_TRIANGLES {
        return Err(format!("has more than {MAX_TRIANGLES} triangles"));
    }
    Ok(())
}

/// The convex hull of a surface, simplified if it has too many vertices.
pub(crate) fn hull(soup: &TriangleSoup) -> Result<Hull, String> {
    spans_volume(&soup.vertices)?;
    let cast = |v: &DVec3| Vec3::new(v.x as f32, v.y as f32, v.z as f32);
    let mut points: Vec<Vec3> = soup.vertices.iter().map(cast).collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    points.dedup();
    let (mut vertices, mut faces) = try_convex_hull(&points).map_err(|e| format!("has no convex hull: {e}"))?;
    let exact_vertices = vertices.len();
    if vertices.len() > MAX_HULL_VERTICES {
        let kept = extreme_points(&vertices);
        (vertices, faces) = try_convex_hull(&kept).map_err(|e| format!("has no convex hull: {e}"))?;
    }
    let wide: Vec<DVec3> = vertices.iter().map(|v| DVec3::new(v.x.into(), v.y.into(), v.z.into())).collect();
    let inertia = of_surface(&wide, &faces);
    let solid = of_surface(&soup.vertices, &soup.triangles);
    // A surface that is open or turned inside out has another volume than any body within its hull.
    let sane = solid.mass > 0.01 * inertia.mass && solid.mass < 1.02 * inertia.mass && positive(solid.matrix);
    Ok(Hull { points: vertices, inertia, solid: sane.then_some(solid), exact_vertices })
}

fn positive(matrix: DMat3) -> bool {
    let (moments, _) = principal_axes(matrix);
    moments.is_finite() && moments.min_element() > 0.0 && 2.0 * moments.max_element() <= 1.001 * moments.element_sum()
}

/// Refuses what has no hull with a volume: the hull builder is not made for it.
fn spans_volume(vertices: &[DVec3]) -> Result<(), String> {
    if vertices.len() < 4 {
        return Err(format!("has {} vertices: a hull needs four", vertices.len()));
    }
    let mean = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    let mut covariance = DMat3::ZERO;
    for v in vertices {
        let d = *v - mean;
        covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    let (spread, _) = principal_axes(covariance);
    // The square of thickness to length.
    let thick = spread.min_element() > 1e-10 * spread.max_element();
    if !thick {
        return Err("lies in one plane or on one line: it has no volume".into());
    }
    Ok(())
}

/// The points that are farthest in directions spread evenly over the sphere (a golden spiral).
fn extreme_points(points: &[Vec3]) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let mut chosen = Vec::with_capacity(MAX_HULL_VERTICES);
    for i in 0..MAX_HULL_VERTICES {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / MAX_HULL_VERTICES as f64;
        let (r, angle) = ((1.0 - z * z).sqrt(), golden * i as f64);
        let direction = Vec3::new((r * libm::cos(angle)) as f32, (r * libm::sin(angle)) as f32, z as f32);
        let mut best = 0;
        for (k, p) in points.iter().enumerate() {
            if p.dot(direction) > points[best].dot(direction) {
                best = k;
            }
        }
        chosen.push(best);
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str =
        "# four corners\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/1 4/1\nf 1//2 4//2 3//2\nf -3 -2 -1\n";

    fn binary_stl(soup: &TriangleSoup, header: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0_u8; 80];
        bytes[..header.len()].copy_from_slice(header);
        bytes.extend((soup.triangles.len() as u32).to_le_bytes());
        for t in &soup.triangles {
            bytes.extend([0_u8; 12]);
            for v in t.map(|i| soup.vertices[i as usize]) {
                for x in v.to_array() {
                    bytes.extend((x as f32).to_le_bytes());
                }
            }
            bytes.extend([0, 0]);
        }
        bytes
    }

    #[test]
    fn a_tetrahedron_has_a_sixth_of_its_box() {
        let hull = hull(&read_obj(TETRAHEDRON).unwrap()).unwrap();
        assert_eq!(hull.points.len(), 4);
        assert!((hull.inertia.mass - 1.0 / 6.0).abs() < 1e-7);
        let solid = hull.solid.expect("closed");
        assert!((solid.mass - 1.0 / 6.0).abs() < 1e-12);
        assert!((solid.center - DVec3::splat(0.25)).length() < 1e-12);
        assert_eq!(hull.approximation(), None);
    }

    #[test]
    fn stl_binary_and_ascii_are_the_same_surface() {
        let soup = read_obj(TETRAHEDRON).unwrap();
        let mut ascii = String::from("solid t\n");
        for t in &soup.triangles {
            ascii += "facet normal 0 0 0\nouter loop\n";
            for v in t.map(|i| soup.vertices[i as usize]) {
                ascii += &format!("vertex {} {} {}\n", v.x, v.y, v.z);
            }
            ascii += "endloop\nendfacet\n";
        }
        ascii += "endsolid t\n";
        let from_ascii = read_stl(ascii.into_bytes()).unwrap();
        for header in [&b"made by a test"[..], b"solid lies"] {
            assert_eq!(read_stl(binary_stl(&soup, header)).unwrap(), from_ascii);
        }
    }

    #[test]
    fn rubbish_is_refused() {
        for bytes in [&b""[..], b"solid", b"solid x\nfacet normal nan 0 0\n", &[0xff; 90]] {
            assert!(read_stl(bytes.to_vec()).is_err() || read_stl(bytes.to_vec()).unwrap().vertices.is_empty());
        }
        for text in ["v 1 2", "v 0 0 0\nf 1 2 3", "v a b c", "f 0 0 0", "f -1 -1 -1", "v 1 2 3\nf 1 1"] {
            assert!(read_obj(text).is_err(), "{text}");
        }
        let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 3";
        assert!(hull(&read_obj(flat).unwrap()).is_err());
    }

    #[test]
    fn a_round_mesh_is_simplified_and_says_so() {
        let mut soup = TriangleSoup::default();
        for i in 0..40 {
            for k in 0..40 {
                let (a, b) = (f64::from(i) * 0.0785, f64::from(k) * 0.157);
                soup.vertices.push(DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos()));
            }
        }
        let hull = hull(&soup).unwrap();
        assert!(hull.points.len() <= MAX_HULL_VERTICES);
        assert!((hull.inertia.mass - 4.18879).abs() < 0.06 * 4.18879, "{}", hull.inertia.mass);
        assert!(hull.approximation().unwrap().contains("simplified"));
    }
}
