//! Sparse and dense linear algebra behind one door.

pub mod block_ldu;
pub mod dense;
pub mod eigen;
pub mod ordering;
