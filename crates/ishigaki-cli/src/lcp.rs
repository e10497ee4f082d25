//! `ishigaki lcp`: solves a box LCP, or a frictional contact problem of others, with a method of the laboratory.

use crate::failure::{At, Failure};
use crate::lcp_file::LcpFile;
use crate::number;
use crate::output::{self, AtomicFile};
use clap::Args;
use ishigaki::lcp::{ContactSolution, FrictionContact, Method, Order, Settings, Solution};
use serde_json::json;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Lcp {
    /// A box LCP (.json, as `run --export-lcp` writes it), a friction-contact problem in the text format of Siconos, or -
    /// for stdin.
    file: String,
    /// lemke, jacobi, gauss-seidel, projected-jacobi, pgs, nncg, block-pgs or dantzig; pgs or block-pgs for friction-contact
    /// problems.
    #[arg(long, value_name = "NAME", value_parser = method)]
    method: Method,
    /// Sweeps, or pivots, at most.
    #[arg(long, value_name = "N", default_value = "10000", value_parser = number::steps, allow_hyphen_values = true)]
    sweeps: u64,
    /// Solved when the residual is not greater.
    #[arg(long, value_name = "T", default_value = "1e-10", value_parser = not_negative, allow_hyphen_values = true)]
    tolerance: f64,
    /// Order of the rows in a sweep: fixed, random or alternating.
    #[arg(long, value_name = "ORDER", default_value = "fixed", value_parser = order)]
    order: Order,
    /// Seed of the random order.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// The part of its step that each row takes.
    #[arg(long, value_name = "W", default_value = "1", value_parser = relaxation, allow_hyphen_values = true)]
    relaxation: f64,
    /// block-pgs: passes over the normals of a block in each visit.
    #[arg(long, value_name = "N", default_value = "10", value_parser = clap::value_parser!(u64).range(1..=1000))]
    passes: u64,
    /// lemke: corners of the polygon that stands for a friction disk.
    #[arg(long, value_name = "N", default_value = "8", value_parser = clap::value_parser!(u64).range(3..=1000))]
    corners: u64,
    /// Start from the file's "start" instead of from nothing.
    #[arg(long)]
    warm: bool,
    /// Write the residual after every sweep as comma-separated values.
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
    /// No remarks on stderr; errors stay.
    #[arg(long)]
    quiet: bool,
}

impl Lcp {
    pub fn execute(&self) -> Result<(), Failure> {
        let (text, origin) = self.read()?;
        // Readable before anything is computed; written when all is known.
        if text.trim_start().starts_with('{') {
            self.solve_box_lcp(&LcpFile::parse(&text).input_at(origin)?)
        } else {
            self.solve_contacts(&FrictionContact::parse(&text).input_at(origin)?)
        }
    }

    fn read(&self) -> Result<(String, &str), Failure> {
        if self.file == "-" {
            let mut text = String::new();
            std::io::stdin().read_to_string(&mut text).input_at("stdin")?;
            return Ok((text, "stdin"));
        }
        if Path::new(&self.file).is_dir() {
            return Err(Failure::input(format!("{}: is a directory; name a file in it", self.file)));
        }
        Ok((std::fs::read_to_string(&self.file).input_at(&self.file)?, &self.file))
    }

    fn settings(&self, start: Option<Vec<f64>>) -> Settings {
        Settings {
            sweeps: self.sweeps as usize,
            tolerance: self.tolerance,
            relaxation: self.relaxation,
            order: self.order,
            seed: self.seed,
            start,
            passes: self.passes as usize,
            corners: self.corners as usize,
        }
    }

    fn solve_box_lcp(&self, file: &LcpFile) -> Result<(), Failure> {
        if self.warm && file.start.is_none() {
            return Err(Failure::input(format!("{}: --warm needs \"start\" in the file", self.file)));
        }
        let trace = self.trace.as_deref().map(AtomicFile::create).transpose()?;
        let solution = self.method.solve(&file.problem, &self.settings(file.start.clone().filter(|_| self.warm)));
        write_trace(trace, "residual", &solution.residuals)?;
        if !self.quiet {
            self.remark(file, &solution);
        }
        let result = json!({
            "lambda": solution.lambda, "w": solution.w, "residual": solution.residual, "sweeps": solution.sweeps,
            "status": solution.status.name(),
        });
        output::print(&result.to_string())
    }

    /// What the numbers alone would not say.
    fn remark(&self, file: &LcpFile, solution: &Solution) {
        if let Some(helper) = solution.fallback {
            eprintln!("note: {} left the problem to {helper}", self.method.name());
        }
        let bounded = |i: usize| file.problem.lower()[i].is_finite() || file.problem.upper()[i].is_finite();
        let any_bound = (0..file.problem.len()).any(|i| file.problem.friction()[i].is_some() || bounded(i));
        if !self.method.is_projected() && any_bound {
            eprintln!("note: {} leaves bounds alone; the residual knows them", self.method.name());
        }
        if self.method == Method::Lemke && file.problem.has_disks() {
            eprintln!(
                "note: friction disks are polygons of {} corners; the residual is that of the disks",
                self.corners
            );
        }
    }

    fn solve_contacts(&self, problem: &FrictionContact) -> Result<(), Failure> {
        if self.warm {
            return Err(Failure::input("--warm belongs to box LCPs; a friction-contact file has no start"));
        }
        let solve: fn(&FrictionContact, &Settings) -> ContactSolution = match self.method {
            Method::BlockProjectedGaussSeidel => FrictionContact::solve_blocks,
            Method::ProjectedGaussSeidel => FrictionContact::solve_rows,
            other => {
                let message = "is for box LCPs; friction-contact problems take block-pgs or pgs";
                return Err(Failure::input(format!("--method {} {message}", other.name())));
            }
        };
        let trace = self.trace.as_deref().map(AtomicFile::create).transpose()?;
        let solution = solve(problem, &self.settings(None));
        write_trace(trace, "error", &solution.errors)?;
        let result = json!({
            "reaction": solution.reaction, "velocity": solution.velocity, "error": solution.error,
            "errors": solution.errors, "sweeps": solution.sweeps, "status": solution.status.name(),
        });
        output::print(&result.to_string())
    }
}

fn write_trace(file: Option<AtomicFile>, quantity: &str, values: &[f64]) -> Result<(), Failure> {
    let Some(mut file) = file else { return Ok(()) };
    let shown = file.path().display().to_string();
    writeln!(file, "sweep,{quantity}").other_at(&shown)?;
    for (sweep, value) in (1..).zip(values) {
        writeln!(file, "{sweep},{value:e}").other_at(&shown)?;
    }
    file.commit()
}

fn method(name: &str) -> Result<Method, String> {
    let names: Vec<&str> = Method::ALL.iter().map(|m| m.name()).collect();
    Method::ALL.into_iter().find(|m| m.name() == name).ok_or_else(|| format!("must be one of {}", names.join(", ")))
}

fn order(name: &str) -> Result<Order, String> {
    match name {
        "fixed" => Ok(Order::Fixed),
        "random" => Ok(Order::Random),
        "alternating" => Ok(Order::Alternating),
        _ => Err("must be fixed, random or alternating".into()),
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("must be a number ≥ 0, such as 1e-10".into()),
    }
}

fn relaxation(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 2.0 => Ok(value),
        _ => Err("must be a number between 0 and 2".into()),
    }
}
