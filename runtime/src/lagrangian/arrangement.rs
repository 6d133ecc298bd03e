//! Which four fields lie side by side in the registers of the machine.

use alloc::{vec, vec::Vec};

use crate::data::{LagrangianData, PolynomialData};
use crate::four::Four;
use crate::products::distinct;
use crate::tensor::row_blocks;

/// The fields in blocks of four whose coordinates share as many products of amplitudes as possible. In a structure with planes of
/// symmetry these are fields of the same symmetry: what one of them has terms of, the others have too.
#[derive(Clone, Debug)]
pub(super) struct Arrangement {
    /// The field at every place; the last block may have places without - (4 x blocks).
    fields: Vec<Option<usize>>,
    /// The place of every field - (n).
    places: Vec<usize>,
}

impl Arrangement {
    pub(super) fn new(modes: usize, data: &LagrangianData) -> Self {
        let n = data.fields as usize;
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        // Linear terms first, then those of second and third order, every product a column.
        let pairs = distinct(data.curve.quadratic.iter().map(|term| term.1));
        let triples = distinct(data.curve.cubic.iter().map(|term| term.1));
        let mut push = |row: usize, column: usize, value: f64| {
            if let Some(row) = rows.get_mut(row) {
                row.push((column as u32, value));
            }
        };
        for (at, &value) in data.linear.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            push(at / modes.max(1), at % modes.max(1), value);
        }
        for (row, factors, value) in &data.curve.quadratic {
            push(*row as usize, modes + pairs.partition_point(|it| it < factors), *value);
        }
        for (row, factors, value) in &data.curve.cubic {
            let column = modes + pairs.len() + triples.partition_point(|it| it < factors);
            push(*row as usize, column, *value);
        }
        let blocks = row_blocks(&rows, modes + pairs.len() + triples.len());
        let field = |&row: &u32| (row != u32::MAX).then_some(row as usize);
        let fields: Vec<Option<usize>> = blocks.as_flattened().iter().map(field).collect();
        let mut places = vec![0; n];
        for (place, field) in fields.iter().enumerate() {
            if let Some(to) = field.and_then(|field| places.get_mut(field)) {
                *to = place;
            }
        }
        Arrangement { fields, places }
    }

    /// Number of blocks.
    pub(super) fn blocks(&self) -> usize {
        self.fields.len() / 4
    }

    /// Place of a field.
    pub(super) fn place(&self, field: u32) -> usize {
        self.places.get(field as usize).copied().unwrap_or(0)
    }

    /// A number of each of the four fields of a block, zero where there is none.
    pub(super) fn four(&self, block: usize, value: impl Fn(usize) -> f64) -> Four {
        core::array::from_fn(|lane| self.fields.get(4 * block + lane).copied().flatten().map_or(0.0, &value))
    }

    /// Polynomials by field, now by place.
    pub(super) fn placed(&self, curve: &PolynomialData) -> PolynomialData {
        let mut placed = curve.clone();
        placed.quadratic.iter_mut().for_each(|term| term.0 = self.place(term.0) as u32);
        placed.cubic.iter_mut().for_each(|term| term.0 = self.place(term.0) as u32);
        placed
    }
}
