//! The JSON file of a box LCP: w = Aλ + b, null for an infinite bound.
//!
//! `{"a": [[…]], "b": […], "lower": [… or null], "upper": [… or null]}` and, where they are needed: `"mu_of"`, for each row
//! null, the index of the normal row whose λ bounds it, or a list of such rows whose sum does; `"mu"`, the coefficients;
//! `"disk"`, for each row null or the index of the other row of its friction disk (without it each row is bounded alone);
//! `"group"`, a number for each row: rows of one number are a block; `"start"`, λ to begin with; `"labels"`, for people.

use crate::failure::{At, Failure};
use crate::output::AtomicFile;
use ishigaki::World;
use ishigaki::lcp::{BoxLcp, Friction, Matrix};
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::Path;

const KNOWN: [&str; 10] = ["a", "b", "lower", "upper", "mu_of", "mu", "disk", "group", "start", "labels"];

/// A problem and what a file says beside it.
pub struct LcpFile {
    pub problem: BoxLcp,
    pub start: Option<Vec<f64>>,
}

impl LcpFile {
    /// Reads a problem; errors name their place, as `a[3][2]`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let value: Value = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let Value::Object(fields) = value else { return Err("must be an object".into()) };
        if let Some(unknown) = fields.keys().find(|key| !KNOWN.contains(&key.as_str())) {
            return Err(format!("{unknown}: no such field; there are {}", KNOWN.join(", ")));
        }
        let b = array(&fields, "b")?.iter().enumerate().map(|(i, x)| number(x, || format!("b[{i}]")));
        let b = b.collect::<Result<Vec<f64>, String>>()?;
        let problem = BoxLcp::new(
            matrix(array(&fields, "a")?, b.len())?,
            b,
            bounds(&fields, "lower", f64::NEG_INFINITY)?,
            bounds(&fields, "upper", f64::INFINITY)?,
        );
        let mut problem = problem.map_err(|e| e.to_string())?;
        let n = problem.len();
        if let Some(friction) = friction(&fields, n)? {
            problem = problem.with_friction(friction).map_err(|e| e.to_string())?;
        }
        if fields.contains_key("group") {
            let groups = array(&fields, "group")?.iter().enumerate();
            let groups = groups.map(|(i, x)| index(x, || format!("group[{i}]"))).collect::<Result<_, _>>()?;
            problem = problem.with_groups(groups).map_err(|e| e.to_string())?;
        }
        let start = match fields.get("start") {
            None | Some(Value::Null) => None,
            Some(_) => {
                let values = sized(&fields, "start", n)?.iter().enumerate();
                Some(values.map(|(i, x)| number(x, || format!("start[{i}]"))).collect::<Result<_, _>>()?)
            }
        };
        Ok(Self { problem, start })
    }
}

fn array<'a>(fields: &'a Map<String, Value>, name: &str) -> Result<&'a [Value], String> {
    match fields.get(name) {
        Some(Value::Array(values)) => Ok(values),
        Some(other) => Err(format!("{name}: must be a list, is {}", kind(other))),
        None => Err(format!("{name}: is missing")),
    }
}

fn sized<'a>(fields: &'a Map<String, Value>, name: &str, n: usize) -> Result<&'a [Value], String> {
    let values = array(fields, name)?;
    if values.len() != n {
        return Err(format!("{name}: must have {n} entries, one for each row, has {}", values.len()));
    }
    Ok(values)
}

fn number(value: &Value, place: impl Fn() -> String) -> Result<f64, String> {
    let number = value.as_f64().filter(|x| x.is_finite());
    number.ok_or_else(|| format!("{}: must be a finite number, is {}", place(), kind(value)))
}

fn index(value: &Value, place: impl Fn() -> String) -> Result<usize, String> {
    let index = value.as_u64().and_then(|x| usize::try_from(x).ok());
    index.ok_or_else(|| format!("{}: must be a whole number ≥ 0, is {}", place(), kind(value)))
}

/// For messages: numbers as they are, longer things by what they are.
fn kind(value: &Value) -> String {
    match value {
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "an object".into(),
        Value::String(_) => "a text".into(),
        other => other.to_string(),
    }
}

fn matrix(rows: &[Value], n: usize) -> Result<Matrix, String> {
    if rows.len() != n {
        return Err(format!("a: must have {n} rows, as many as b has entries, has {}", rows.len()));
    }
    for (i, row) in rows.iter().enumerate() {
        match row {
            Value::Array(row) if row.len() == n => {}
            Value::Array(row) => return Err(format!("a[{i}]: must have {n} entries, has {}", row.len())),
            other => return Err(format!("a[{i}]: must be a list, is {}", kind(other))),
        }
    }
    let mut matrix = Matrix::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            matrix[(i, j)] = number(&rows[i][j], || format!("a[{i}][{j}]"))?;
        }
    }
    Ok(matrix)
}

fn bounds(fields: &Map<String, Value>, name: &str, infinite: f64) -> Result<Vec<f64>, String> {
    let bound = |(i, value): (usize, &Value)| match value {
        Value::Null => Ok(infinite),
        other => number(other, || format!("{name}[{i}]")).map_err(|e| format!("{e} (null for infinite)")),
    };
    array(fields, name)?.iter().enumerate().map(bound).collect()
}

fn friction(fields: &Map<String, Value>, n: usize) -> Result<Option<Vec<Option<Friction>>>, String> {
    if !fields.contains_key("mu_of") {
        return match ["mu", "disk"].into_iter().find(|&name| fields.contains_key(name)) {
            Some(name) => Err(format!("{name}: means nothing without mu_of")),
            None => Ok(None),
        };
    }
    let (mu_of, mu) = (sized(fields, "mu_of", n)?, sized(fields, "mu", n)?);
    let disk = if fields.contains_key("disk") { sized(fields, "disk", n)? } else { &[] };
    let row = |i: usize| {
        let place = || format!("mu_of[{i}]");
        let partner = match disk.get(i) {
            None | Some(Value::Null) => None,
            Some(value) => Some(index(value, || format!("disk[{i}]"))?),
        };
        let normals = match &mu_of[i] {
            Value::Null if partner.is_some() => return Err(format!("disk[{i}]: row {i} has no normal in mu_of")),
            Value::Null => return Ok(None),
            Value::Array(rows) => rows.iter().map(|row| index(row, place)).collect::<Result<_, _>>()?,
            one => vec![index(one, place)?],
        };
        Ok(Some(Friction { normals, coefficient: number(&mu[i], || format!("mu[{i}]"))?, partner }))
    };
    (0..n).map(row).collect::<Result<Vec<_>, String>>().map(Some)
}

/// `run --export-lcp`: one step of a run, before it is taken.
pub struct LcpExport {
    step: u64,
    file: Option<AtomicFile>,
}

impl LcpExport {
    /// Refuses a step that the run does not reach, and a file that cannot be written.
    pub fn create(step: u64, path: &Path, steps: u64) -> Result<Self, Failure> {
        if step > steps {
            let message = format!("--export-lcp: step {step} is beyond the run, which has {steps} steps");
            return Err(Failure::input(message));
        }
        Ok(Self { step, file: Some(AtomicFile::create(path)?) })
    }

    /// To be called before each step, with its number.
    pub fn before(&mut self, step: u64, world: &World, dt: f32) -> Result<(), Failure> {
        match self.file.take_if(|_| step == self.step) {
            Some(file) => write(world, dt, file),
            None => Ok(()),
        }
    }
}

fn write(world: &World, dt: f32, mut file: AtomicFile) -> Result<(), Failure> {
    let shown = file.path().display().to_string();
    let export = world.export_lcp(dt).input_at("--export-lcp")?;
    let problem = &export.problem;
    let n = problem.len();
    let finite = |x: &f64| if x.is_finite() { json!(x) } else { Value::Null };
    let friction = |of: fn(&Friction) -> Value| -> Value {
        problem.friction().iter().map(|f| f.as_ref().map_or(Value::Null, of)).collect()
    };
    let normals = |f: &Friction| match &f.normals[..] {
        [one] => json!(one),
        several => json!(several),
    };
    let name = |handle| {
        let body = world.body(handle).map(ishigaki::BodyState::name).filter(|name| !name.is_empty());
        body.map_or_else(|| format!("body {}", handle.index()), str::to_string)
    };
    let labels: Value = export
        .labels
        .iter()
        .map(|l| json!({ "kind": l.kind.name(), "bodies": l.bodies.map(name), "group": l.group }))
        .collect();
    let bound =
        |i: usize, bounds: &[f64]| if problem.friction()[i].is_some() { Value::Null } else { finite(&bounds[i]) };
    let field = |name: &str, value: &Value| format!("  {}: {value}", json!(name));
    let rows: Vec<String> = (0..n).map(|i| format!("    {}", json!(problem.a().row(i)))).collect();
    let fields = [
        format!("  \"a\": [\n{}\n  ]", rows.join(",\n")),
        field("b", &json!(problem.b())),
        field("lower", &(0..n).map(|i| bound(i, problem.lower())).collect()),
        field("upper", &(0..n).map(|i| bound(i, problem.upper())).collect()),
        field("mu_of", &friction(normals)),
        field("mu", &friction(|f| json!(f.coefficient))),
        field("disk", &friction(|f| json!(f.partner))),
        field("group", &json!(problem.groups())),
        field("start", &json!(export.start)),
        field("labels", &labels),
    ];
    writeln!(file, "{{\n{}\n}}", fields.join(",\n")).other_at(&shown)?;
    file.commit()
}
