//! The linear solver of the methods in the floating frame.

use std::sync::Arc;

use nalgebra::{Matrix6, SMatrix, Vector6};

use super::floating::Rows;
use super::method::Prepared;
use crate::assembly::BlockMatrix;
use crate::solve::block_ldu::{Factor, Symbolic};

/// Solver of `[[K + c M_SS, c M_SR], [c M_RS, c M_RR]]`: sparse block plus a border of six, by its Schur complement.
pub(super) struct Bordered {
    factor: Factor,
    /// `A_SS^{-1} c M_SR`.
    columns: Vec<SMatrix<f64, 6, 6>>,
    /// `c M_RS` row blocks.
    rows: Vec<Matrix6<f64>>,
    schur_inverse: Matrix6<f64>,
    /// The `c` that was factorised last.
    pub(super) factor_of: f64,
}

impl Bordered {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let symbolic = Arc::new(Symbolic::new(prepared.stiffness.pattern.clone()));
        let n = prepared.assembly.n_blocks();
        Self {
            factor: Factor::new(symbolic),
            columns: vec![Matrix6::zeros(); n],
            rows: vec![Matrix6::zeros(); n],
            schur_inverse: Matrix6::zeros(),
            factor_of: f64::NAN,
        }
    }

    pub(super) fn factorise(&mut self, prepared: &Prepared, k: &BlockMatrix, c: f64) -> Result<(), String> {
        let mass = &prepared.mass;
        self.factor_of = c;
        self.factor.refactor(&k.plus(c, &mass.ss)).map_err(|e| e.to_string())?;
        for (i, sr) in mass.sr.iter().enumerate() {
            self.columns[i] = sr * c;
            self.rows[i] = sr.transpose() * c;
        }
        self.factor.solve_panels::<6>(&mut self.columns);
        let coupling: Matrix6<f64> = self.rows.iter().zip(&self.columns).map(|(r, x)| r * x).sum();
        self.schur_inverse =
            (mass.rr * c - coupling).try_inverse().ok_or("the mass matrix of the rigid body is singular")?;
        Ok(())
    }

    /// The structural rows alone, with A where it is.
    pub(super) fn solve_held(&self, rows: &mut Rows) {
        self.factor.solve(&mut rows.s);
        rows.r = Vector6::zeros();
    }

    pub(super) fn solve(&self, rows: &mut Rows) {
        self.factor.solve(&mut rows.s);
        let carried: Vector6<f64> = self.rows.iter().zip(&rows.s).map(|(r, x)| r * x).sum();
        rows.r = self.schur_inverse * (rows.r - carried);
        for (x, column) in rows.s.iter_mut().zip(&self.columns) {
            *x -= column * rows.r;
        }
    }
}
