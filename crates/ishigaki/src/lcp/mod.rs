//! The laboratory: box LCPs, dense and in f64, and the classic methods to solve them. TALK C.
//!
//! Nothing here takes part in a step. It is where the engine's own problems, exported by
//! [`World::export_lcp`](crate::World::export_lcp), are looked at: what Jacobi, Gauss–Seidel, PGS and the exact methods make
//! of them, sweep by sweep. Every method takes a [`BoxLcp`] and [`Settings`] and gives a [`Solution`]:
//!
//! | Method | Solves | Function |
//! |---|---|---|
//! | Lemke | box LCP, friction boxes exactly, disks as polygons | [`lemke`] |
//! | Dantzig | box LCP of symmetric A; falls back otherwise | [`dantzig`] |
//! | Jacobi, Gauss–Seidel | A λ + b = 0, bounds left alone | [`jacobi`], [`gauss_seidel`] |
//! | projected Jacobi, projected Gauss–Seidel | everything, one row a time | [`projected_jacobi`], [`projected_gauss_seidel`] |
//! | NNCG | everything, in fewer sweeps | [`nncg`] |
//! | block PGS | everything, a manifold at a time | [`block_projected_gauss_seidel`] |
//!
//! ```
//! use ishigaki::lcp::{Method, Settings, Status};
//! use ishigaki::{Body, Shape, Vec3, World};
//! let mut world = World::default();
//! world.add_body(Body::fixed(Shape::half_space(Vec3::Y)))?;
//! world.add_body(Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).mass(2.0).at(Vec3::Y * 0.5))?;
//! let export = world.export_lcp(1.0 / 60.0)?;
//! let solution = Method::ProjectedGaussSeidel.solve(&export.problem, &Settings::default());
//! assert_eq!(solution.status, Status::Solved);
//! // The four normals together carry the weight over a substep, m g h.
//! let normals = export.labels.iter().zip(&solution.lambda).filter(|(label, _)| label.kind.name() == "normal");
//! let h = 1.0 / 60.0 / f64::from(world.options().solver.substeps);
//! assert!((normals.map(|(_, lambda)| lambda).sum::<f64>() - 2.0 * 9.81 * h).abs() < 1e-5);
//! # Ok::<(), ishigaki::Error>(())
//! ```

mod block_projected_gauss_seidel;
mod box_lcp;
mod coulomb;
mod dantzig;
mod elimination;
mod export;
mod friction_contact;
mod gauss_seidel;
mod jacobi;
mod lemke;
mod matrix;
mod method;
mod nncg;
mod projected_gauss_seidel;
mod settings;
mod stewart_trinkle;

pub use block_projected_gauss_seidel::block_projected_gauss_seidel;
pub use box_lcp::{BoxLcp, Friction};
pub use coulomb::ContactSolution;
pub use dantzig::dantzig;
pub use export::{ExportedLcp, RowKind, RowLabel};
pub use friction_contact::FrictionContact;
pub use gauss_seidel::gauss_seidel;
pub use jacobi::{jacobi, projected_jacobi};
pub use lemke::lemke;
pub use matrix::Matrix;
pub use method::Method;
pub use nncg::nncg;
pub use projected_gauss_seidel::projected_gauss_seidel;
pub use settings::{Order, Settings, Solution, Status};
