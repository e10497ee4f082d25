//! `<geom>` and the assets it refers to.

use super::defaults::{Compiler, quaternion};
use super::{Inside, Reader};
use crate::error::{SceneError, unknown};
use crate::mesh::{self, Hull, TriangleSoup};
use crate::models::inertia::{Inertia, unit_density};
use crate::models::tree::{Motion, Piece, Surface, pose, y_to_z};
use crate::models::xml::{Attributes, Document};
use glamx::{DPose3, DQuat, DVec3};
use ishigaki::{ConvexHull, Geometry, HeightField, Vec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Points of the hull that stands for an ellipsoid: rings × points.
const ELLIPSOID: (usize, usize) = (7, 12);

/// Meshes and height fields by name, each loaded when a geom first needs it.
pub(super) struct Assets {
    base: PathBuf,
    mesh_dir: PathBuf,
    strip_path: bool,
    meshes: BTreeMap<String, usize>,
    hfields: BTreeMap<String, usize>,
    loaded: BTreeMap<usize, LoadedMesh>,
}

#[derive(Clone)]
struct LoadedMesh {
    hull: Arc<ConvexHull>,
    inertia: Inertia,
    told: Option<String>,
}

impl Assets {
    pub fn read(document: &Document, compiler: &Compiler, base: &Path) -> Self {
        let mut assets = Self {
            base: base.to_owned(),
            mesh_dir: base.join(&compiler.mesh_dir),
            strip_path: compiler.strip_path,
            meshes: BTreeMap::new(),
            hfields: BTreeMap::new(),
            loaded: BTreeMap::new(),
        };
        for id in document.in_sections("asset") {
            let element = document.element(id);
            let table = match element.tag.as_str() {
                "mesh" => &mut assets.meshes,
                "hfield" => &mut assets.hfields,
                _ => continue,
            };
            // Without a name, the file's is taken.
            let stem = |file: &str| Path::new(file).file_stem().map(|s| s.to_string_lossy().into_owned());
            let name =
                element.attribute("name").map(str::to_owned).or_else(|| element.attribute("file").and_then(stem));
            if let Some(name) = name {
                table.insert(name, id);
            }
        }
        assets
    }

    fn path(&self, directory: &Path, file: &str) -> PathBuf {
        let file = Path::new(file);
        let file = if self.strip_path { file.file_name().map_or(file, Path::new) } else { file };
        directory.join(file)
    }
}

/// A geom without what all geoms have.
struct Form {
    geometry: Geometry,
    /// Added to the geom's pose.
    turn: DQuat,
    /// density 1, in the geom's frame; `None` for planes and height fields.
    inertia: Option<Inertia>,
}

impl<'a> Reader<'a> {
    pub(super) fn geom(&mut self, id: usize, inside: Inside<'a>, from_geoms: bool) -> Result<(), SceneError> {
        let a = self.classes.attributes(self.document, id, "geom", inside.around)?;
        let a = &a;
        let document = self.document;
        let surface = self.surface(a)?;
        let group = a.integer("group")?.unwrap_or(0) as f64;
        let [least, most] = self.compiler.inertia_groups;
        let weighs = from_geoms && inside.link != 0 && (least..=most).contains(&group);
        let mass = a.number("mass")?;
        let density = a.number("density")?.unwrap_or(1000.0);
        if density < 0.0 || mass.is_some_and(|m| m < 0.0) {
            return Err(a.error("density", "mass and density must be ≥ 0"));
        }
        let visual = surface.contype == 0 && surface.conaffinity == 0;
        let is_mesh = a.text("mesh").is_some();
        if is_mesh && visual && !(weighs && mass.unwrap_or(density) > 0.0) {
            return Ok(());
        }
        let (form, geom_pose) = self.form(a)?;
        let link_from_geom = inside.frame * geom_pose;
        if weighs && let Some(unit) = form.inertia {
            let factor = match mass {
                Some(mass) if unit.mass > 0.0 => mass / unit.mass,
                _ => density,
            };
            let part = unit.scaled(factor).transformed(link_from_geom);
            let link = &mut self.tree.links[inside.link];
            link.inertia = if link.inertia == Inertia::ZERO { part } else { link.inertia.merged(&part) };
        }
        let moves = |mut link: usize| {
            while link != 0 {
                if !matches!(self.tree.links[link].motion, Motion::Welded) {
                    return true;
                }
                link = self.tree.links[link].parent;
            }
            false
        };
        if !form.geometry.is_solid() && moves(inside.link) {
            return Err(document.error(a.id, "planes and height fields can only be on bodies that do not move"));
        }
        if let Some(name) = document.element(a.id).attribute("name") {
            self.geom_names.insert(name, self.pieces);
        }
        if !(is_mesh && visual) {
            let pose = link_from_geom * pose(DVec3::ZERO, form.turn);
            let piece = Piece { id: self.pieces, geometry: form.geometry, pose, surface };
            self.tree.links[inside.link].pieces.push(piece);
        }
        self.pieces += 1;
        Ok(())
    }

    fn surface(&self, a: &Attributes) -> Result<Surface, SceneError> {
        // Friction that is said in part keeps MuJoCo's defaults for the rest.
        let mut friction = [1.0, 0.005, 0.0001];
        for (slot, value) in friction.iter_mut().zip(a.list("friction", 1, 3)?.unwrap_or_default()) {
            if value < 0.0 {
                return Err(a.error("friction", format!("must be ≥ 0, is {value}")));
            }
            *slot = value;
        }
        let condim = match a.integer("condim")?.unwrap_or(3) {
            n @ (1 | 3 | 4 | 6) => n as u8,
            other => return Err(a.error("condim", format!("must be 1, 3, 4 or 6, is {other}"))),
        };
        // 32 bits; written as a signed number by some.
        let mask = |name: &str| Ok::<u32, SceneError>(a.integer(name)?.unwrap_or(1) as u32);
        let on = |mask: u32| if self.contacts { mask } else { 0 };
        Ok(Surface {
            contype: on(mask("contype")?),
            conaffinity: on(mask("conaffinity")?),
            condim,
            priority: a.integer("priority")?.unwrap_or(0),
            friction,
        })
    }

    /// The form of a geom and its pose on the body.
    fn form(&mut self, a: &Attributes) -> Result<(Form, DPose3), SceneError> {
        let kind = a.text("type").unwrap_or(if a.text("mesh").is_some() { "mesh" } else { "sphere" });
        let mut size = [0.0; 3];
        let given = a.list("size", 1, 3)?.unwrap_or_default();
        size[..given.len()].copy_from_slice(&given);
        let mut geom_pose = self.compiler.pose(a)?;
        let long = matches!(kind, "capsule" | "cylinder" | "ellipsoid" | "box");
        if let Some([x0, y0, z0, x1, y1, z1]) = a.array::<6>("fromto")?.filter(|_| long) {
            let (from, to) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
            let along = from - to;
            let z = along.try_normalize().ok_or_else(|| a.error("fromto", "its two ends are one point"))?;
            geom_pose = pose(0.5 * (from + to), DQuat::from_rotation_arc(DVec3::Z, z));
            let half = 0.5 * along.length();
            size = if matches!(kind, "capsule" | "cylinder") { [size[0], half, 0.0] } else { [size[0], size[0], half] };
        }
        if a.text("mesh").is_some() || kind == "mesh" {
            if kind != "mesh" {
                self.warn(a.id, format!("a {kind} fitted to a mesh is not known: the mesh's hull is taken"));
            }
            return Ok((self.mesh_form(a)?, geom_pose));
        }
        let needed = match kind {
            "sphere" => 1,
            "capsule" | "cylinder" => 2,
            "ellipsoid" | "box" => 3,
            _ => 0,
        };
        if let Some(i) = (0..needed).find(|&i| size[i] <= 0.0) {
            return Err(
                a.error("size", format!("a {kind} needs {needed} numbers > 0, number {} is {}", i + 1, size[i]))
            );
        }
        let [x, y, z] = size;
        let half = DVec3::from_array(size);
        let (r, h) = (x as f32, y as f32);
        let solid = |geometry: Geometry, turn: DQuat, inertia: Inertia| Form { geometry, turn, inertia: Some(inertia) };
        let form = match kind {
            "sphere" => solid(Geometry::Ball { radius: r }, DQuat::IDENTITY, unit_density::ball(x)),
            "capsule" => solid(Geometry::Capsule { half_length: h, radius: r }, y_to_z(), unit_density::capsule(y, x)),
            "cylinder" => {
                solid(Geometry::Cylinder { half_height: h, radius: r }, y_to_z(), unit_density::cylinder(y, x))
            }
            "box" => {
                let half_extents = Vec3::new(r, h, z as f32);
                solid(Geometry::Cuboid { half_extents }, DQuat::IDENTITY, unit_density::cuboid(half))
            }
            "ellipsoid" => {
                let points = ellipsoid_points(half);
                self.warn(a.id, format!("the ellipsoid is taken as the hull of {} of its points", points.len()));
                let hull = ConvexHull::new(&points).map_err(|e| a.error("size", e))?;
                solid(Geometry::ConvexHull(Arc::new(hull)), DQuat::IDENTITY, unit_density::ellipsoid(half))
            }
            "plane" => Form { geometry: Geometry::HalfSpace { normal: Vec3::Z }, turn: DQuat::IDENTITY, inertia: None },
            "hfield" => self.height_field(a)?,
            other => return Err(a.error("type", format!("`{other}` geoms are not known"))),
        };
        Ok((form, geom_pose))
    }

    fn mesh_form(&mut self, a: &Attributes) -> Result<Form, SceneError> {
        let name = a.required("mesh")?;
        let Some(&asset) = self.assets.meshes.get(name) else {
            return Err(a.error("mesh", unknown("mesh", name, self.assets.meshes.keys().map(String::as_str))));
        };
        if !self.assets.loaded.contains_key(&asset) {
            let loaded = self.load_mesh(asset)?;
            if let Some(told) = &loaded.told {
                self.warn(asset, format!("mesh `{name}` {told}"));
            }
            self.assets.loaded.insert(asset, loaded);
        }
        let loaded = &self.assets.loaded[&asset];
        let geometry = Geometry::ConvexHull(loaded.hull.clone());
        Ok(Form { geometry, turn: DQuat::IDENTITY, inertia: Some(loaded.inertia) })
    }

    fn load_mesh(&self, asset: usize) -> Result<LoadedMesh, SceneError> {
        let document = self.document;
        let a = self.classes.attributes(document, asset, "mesh", None)?;
        let mut soup = match (a.text("file"), a.list("vertex", 12, 3_000_000)?) {
            (Some(file), _) => {
                let path = self.assets.path(&self.assets.mesh_dir, file);
                mesh::load(&path).map_err(|e| a.error("file", format!("{} {e}", path.display())))?
            }
            (None, Some(numbers)) => inline_mesh(&a, &numbers)?,
            (None, None) => return Err(document.error(asset, "needs the attribute `file` or `vertex`")),
        };
        let scale = a.array("scale")?.map_or(DVec3::ONE, DVec3::from_array);
        let shift = a.array("refpos")?.map_or(DVec3::ZERO, DVec3::from_array);
        let back = quaternion(&a, "refquat")?.inverse();
        for v in &mut soup.vertices {
            *v = (back * (*v - shift)) * scale;
        }
        if scale.x * scale.y * scale.z < 0.0 {
            soup.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let hull = mesh::hull(&soup).map_err(|e| document.error(asset, e))?;
        let told = hull.approximation();
        let Hull { points, inertia, solid, .. } = hull;
        let convex = a.text("inertia") == Some("convex");
        let built = ConvexHull::new(&points).map_err(|e| document.error(asset, e))?;
        Ok(LoadedMesh { hull: Arc::new(built), inertia: solid.filter(|_| !convex).unwrap_or(inertia), told })
    }

    /// Rows of the file go from +y to −y, the engine's from −z to +z: with y up turned to z up they are the same.
    fn height_field(&mut self, a: &Attributes) -> Result<Form, SceneError> {
        let name = a.required("hfield")?;
        let Some(&asset) = self.assets.hfields.get(name) else {
            return Err(a.error("hfield", unknown("hfield", name, self.assets.hfields.keys().map(String::as_str))));
        };
        let field = self.document.attributes(asset, None);
        let Some([radius_x, radius_y, top, _base]) = field.array("size")? else {
            return Err(field.error("size", "this attribute is missing"));
        };
        let (rows, columns, data) = match field.text("file") {
            Some(file) => {
                let path = self.assets.path(&self.assets.base.clone(), file);
                read_height_file(&path).map_err(|e| field.error("file", format!("{} {e}", path.display())))?
            }
            None => {
                let count = |name: &str| {
                    let n = field.integer(name)?.unwrap_or(0);
                    usize::try_from(n).map_err(|_| field.error(name, format!("must be ≥ 2, is {n}")))
                };
                let (rows, columns) = (count("nrow")?, count("ncol")?);
                let cells = rows.checked_mul(columns).filter(|&n| n <= 16_000_000);
                let cells = cells.ok_or_else(|| field.error("nrow", "more than 16 million heights"))?;
                let data = field.list("elevation", cells, cells)?.unwrap_or_else(|| vec![0.0; cells]);
                (rows, columns, data)
            }
        };
        let (least, most) = data.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), &h| (l.min(h), m.max(h)));
        let range = if most > least { most - least } else { 1.0 };
        let heights = data.iter().map(|h| ((h - least) / range * top) as f32).collect();
        let (size_x, size_z) = ((2.0 * radius_x) as f32, (2.0 * radius_y) as f32);
        let built =
            HeightField::new(rows, columns, heights, size_x, size_z).map_err(|e| self.document.error(asset, e))?;
        Ok(Form { geometry: Geometry::HeightField(Arc::new(built)), turn: y_to_z(), inertia: None })
    }
}

fn inline_mesh(a: &Attributes, numbers: &[f64]) -> Result<TriangleSoup, SceneError> {
    let vertices: Vec<DVec3> = numbers.chunks_exact(3).map(|v| DVec3::new(v[0], v[1], v[2])).collect();
    let faces = a.list("face", 0, 9_000_000)?.unwrap_or_default();
    let mut triangles = Vec::new();
    for face in faces.chunks_exact(3) {
        let known = |f: f64| f >= 0.0 && f < vertices.len() as f64 && f.fract() == 0.0;
        if !face.iter().all(|&f| known(f)) {
            return Err(
                a.error("face", format!("({}, {}, {}) names a vertex that is not there", face[0], face[1], face[2]))
            );
        }
        triangles.push([face[0] as u32, face[1] as u32, face[2] as u32]);
    }
    Ok(TriangleSoup { vertices, triangles })
}

/// MuJoCo's own binary format: two 32-bit counts, then 32-bit floats, the first row at −y.
fn read_height_file(path: &Path) -> Result<(usize, usize, Vec<f64>), String> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Err("is a picture: only MuJoCo's binary height fields are read".into());
    }
    let bytes = std::fs::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    let count = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map(i32::from_le_bytes);
    let (Some(rows), Some(columns)) = (count(0), count(4)) else { return Err("is too short".into()) };
    let (rows, columns) = (usize::try_from(rows).unwrap_or(0), usize::try_from(columns).unwrap_or(0));
    let cells = rows.checked_mul(columns).unwrap_or(0);
    if cells == 0 || cells.checked_mul(4).and_then(|n| n.checked_add(8)) != Some(bytes.len()) {
        return Err(format!("does not have the length of {rows} × {columns} heights"));
    }
    let mut data = Vec::with_capacity(cells);
    for row in (0..rows).rev() {
        for column in 0..columns {
            let at = 8 + 4 * (row * columns + column);
            let height = f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
            if !height.is_finite() {
                return Err(format!("has a height that is not finite in row {row}"));
            }
            data.push(height.into());
        }
    }
    Ok((rows, columns, data))
}

fn ellipsoid_points(half: DVec3) -> Vec<Vec3> {
    use std::f64::consts::PI;
    let (rings, around) = ELLIPSOID;
    let mut points = vec![DVec3::Z, -DVec3::Z];
    for ring in 1..rings {
        let polar = PI * ring as f64 / rings as f64;
        for k in 0..around {
            let angle = 2.0 * PI * k as f64 / around as f64;
            let across = libm::sin(polar);
            points.push(DVec3::new(across * libm::cos(angle), across * libm::sin(angle), libm::cos(polar)));
        }
    }
    points.into_iter().map(|p| crate::models::tree::vec32(p * half)).collect()
}
