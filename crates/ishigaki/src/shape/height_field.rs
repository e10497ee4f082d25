//! A terrain over a regular grid.

use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::shape::{extent, within_reach};
use parry3d::shape::HeightField as ParryField;
use parry3d::utils::Array2;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Heights along Y over a grid in X (columns) and Z (rows), centered on the origin; serialized as its numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "FieldData", into = "FieldData")]
pub struct HeightField {
    data: FieldData,
    pub(crate) field: Arc<ParryField>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct FieldData {
    rows: usize,
    columns: usize,
    heights: Vec<f32>,
    size_x: f32,
    size_z: f32,
}

impl HeightField {
    /// `heights[row * columns + column]`, m.
    ///
    /// # Errors
    /// Fewer than two rows or columns, a length that does not match, a height that is not finite, a size ≤ 0.
    pub fn new(rows: usize, columns: usize, heights: Vec<f32>, size_x: f32, size_z: f32) -> Result<Self> {
        Self::try_from(FieldData { rows, columns, heights, size_x, size_z })
    }

    /// Rows (along Z) and columns (along X) of grid points.
    pub fn dimensions(&self) -> (usize, usize) {
        (self.data.rows, self.data.columns)
    }

    /// `heights[row * columns + column]`, m.
    pub fn heights(&self) -> &[f32] {
        &self.data.heights
    }

    /// Extent along X and Z, m.
    pub fn size(&self) -> (f32, f32) {
        (self.data.size_x, self.data.size_z)
    }
}

impl PartialEq for HeightField {
    fn eq(&self, other: &Self) -> bool {
        self.data == other.data
    }
}

impl TryFrom<FieldData> for HeightField {
    type Error = Error;
    fn try_from(data: FieldData) -> Result<Self> {
        extent("size_x", data.size_x)?;
        extent("size_z", data.size_z)?;
        if data.rows < 2 || data.columns < 2 {
            let message = format!("needs at least 2 rows and 2 columns, has {} and {}", data.rows, data.columns);
            return Err(Error::invalid("heights", message));
        }
        if data.rows.checked_mul(data.columns) != Some(data.heights.len()) {
            let message =
                format!("{} rows × {} columns do not match {} heights", data.rows, data.columns, data.heights.len());
            return Err(Error::invalid("heights", message));
        }
        for (i, &height) in data.heights.iter().enumerate() {
            within_reach(Vec3::Y * height, || format!("heights[{i}]"))?;
        }
        // parry stores its matrix column by column, rows along Z.
        let mut column_major = Vec::with_capacity(data.heights.len());
        for column in 0..data.columns {
            for row in 0..data.rows {
                column_major.push(data.heights[row * data.columns + column]);
            }
        }
        let matrix = Array2::new(data.rows, data.columns, column_major);
        let field = ParryField::new(matrix, Vec3::new(data.size_x, 1.0, data.size_z));
        Ok(Self { data, field: Arc::new(field) })
    }
}

impl From<HeightField> for FieldData {
    fn from(field: HeightField) -> Self {
        field.data
    }
}
