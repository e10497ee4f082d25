//! The methods by name.

use crate::lcp::box_lcp::BoxLcp;
use crate::lcp::settings::{Settings, Solution};
use crate::lcp::{
    block_projected_gauss_seidel, dantzig, gauss_seidel, jacobi, lemke, nncg, projected_gauss_seidel, projected_jacobi,
};

/// A method of the laboratory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// [`lemke`].
    Lemke,
    /// [`dantzig`].
    Dantzig,
    /// [`jacobi`].
    Jacobi,
    /// [`gauss_seidel`].
    GaussSeidel,
    /// [`projected_jacobi`].
    ProjectedJacobi,
    /// [`projected_gauss_seidel`].
    ProjectedGaussSeidel,
    /// [`nncg`].
    Nncg,
    /// [`block_projected_gauss_seidel`].
    BlockProjectedGaussSeidel,
}

impl Method {
    /// All of them, in the order of the talk.
    pub const ALL: [Self; 8] = [
        Self::Lemke,
        Self::Jacobi,
        Self::GaussSeidel,
        Self::ProjectedJacobi,
        Self::ProjectedGaussSeidel,
        Self::Nncg,
        Self::BlockProjectedGaussSeidel,
        Self::Dantzig,
    ];

    /// As the command line calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lemke => "lemke",
            Self::Dantzig => "dantzig",
            Self::Jacobi => "jacobi",
            Self::GaussSeidel => "gauss-seidel",
            Self::ProjectedJacobi => "projected-jacobi",
            Self::ProjectedGaussSeidel => "pgs",
            Self::Nncg => "nncg",
            Self::BlockProjectedGaussSeidel => "block-pgs",
        }
    }

    /// Whether the method knows the bounds; those that do not solve A λ + b = 0.
    pub fn is_projected(self) -> bool {
        !matches!(self, Self::Jacobi | Self::GaussSeidel)
    }

    /// Solves a problem with it.
    pub fn solve(self, problem: &BoxLcp, settings: &Settings) -> Solution {
        let solve = match self {
            Self::Lemke => lemke,
            Self::Dantzig => dantzig,
            Self::Jacobi => jacobi,
            Self::GaussSeidel => gauss_seidel,
            Self::ProjectedJacobi => projected_jacobi,
            Self::ProjectedGaussSeidel => projected_gauss_seidel,
            Self::Nncg => nncg,
            Self::BlockProjectedGaussSeidel => block_projected_gauss_seidel,
        };
        solve(problem, settings)
    }
}
