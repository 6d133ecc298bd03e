//! Lowest elastic modes of a free body by block Lanczos, shifted to zero and inverted.
//!
//! The rigid modes are removed exactly instead of being computed: an elastic mode carries no momentum, `M_RS phi_S + M_RR
//! phi_R = 0`, which leaves
//!
//! ```text
//! K_SS phi = omega^2 (M_SS - M_SR M_RR^{-1} M_RS) phi
//! ```
//!
//! (for a clamped structure with `M_SS` alone on the right) with the clamped, positive definite `K_SS`: no zero eigenvalue, no deflation tolerance. The iteration runs on
//! `K_SS^{-1} M_eff` in the inner product of `M_eff`, with full re-orthogonalisation. A Sturm count (inertia of
//! `K - sigma M` with its rigid border) proves that no eigenvalue below `sigma` was missed.

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix6, SMatrix, Vector6};

use super::block_ldu::{Factor, SingularPivot, Symbolic};
use super::dense::{DenseError, generalised_eigen, symmetric_eigen};
use crate::assembly::{Assembly, BlockMatrix, MassMatrix, StrainForm};
use crate::configuration::Configuration;
use crate::mesh::Support;

/// Columns iterated together: wide enough for the sixfold symmetry that a structure can have, narrow enough for registers.
const B: usize = 8;
/// Most panels kept; 8 x 80 vectors find well over 300 modes.
const MAX_PANELS: usize = 80;
/// Up to this many unknowns a request for most of the modes is solved densely.
const MAX_DENSE: usize = 3000;
/// Residual of a converged Ritz pair relative to its own `1/omega^2`. The shapes are as good as this over the gap, and they
/// make the tensors, so it is close to round-off.
const TOLERANCE: f64 = 1e-13;
/// Corrections smaller than this, over the solution, are round-off of the strains they come from.
const REFINED: f64 = 1e-13;
/// Most corrections of a solution; each gains the digits that the factorisation has, and none is left of 16 beyond a million elements.
const MAX_CORRECTIONS: usize = 8;

type Panel = SMatrix<f64, 6, B>;
type Small = SMatrix<f64, B, B>;

/// The modes could not be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EigenError {
    /// The stiffness matrix about the equilibrium has negative eigenvalues.
    #[error(
        "the equilibrium is not stable: the stiffness matrix has {count} negative eigenvalue(s) with the reference node held"
    )]
    Unstable {
        /// How many.
        count: usize,
    },
    /// A part of the structure can move without strain.
    #[error("the stiffness matrix is singular at block row {}: a part of the structure is a mechanism", .0.row)]
    Singular(SingularPivot),
    /// The mass left after removing the rigid body is not positive definite.
    #[error("the mass matrix is not positive definite after removing the rigid-body motion")]
    MassNotDefinite,
    /// More modes asked for than the structure has or the method can find.
    #[error(
        "{requested} elastic modes requested; this structure of {available} elastic degrees of freedom gives at most {limit}"
    )]
    TooMany {
        /// Modes requested.
        requested: usize,
        /// Elastic degrees of freedom.
        available: usize,
        /// Largest possible request.
        limit: usize,
    },
    /// The iteration ended before all modes converged.
    #[error("mode iteration stopped after {vectors} vectors with {converged} of {requested} modes converged")]
    NoConvergence {
        /// Size of the Krylov basis.
        vectors: usize,
        /// Converged modes.
        converged: usize,
        /// Requested modes.
        requested: usize,
    },
    /// The Sturm count disagrees with the modes found.
    #[error(
        "{found} modes were found below {omega} rad/s, but the inertia of K - omega^2 M counts {counted}"
    )]
    Missed {
        /// Modes found.
        found: usize,
        /// Sturm count.
        counted: usize,
        /// Frequency of the count, rad/s.
        omega: f64,
    },
    /// A dense step failed.
    #[error(transparent)]
    Dense(#[from] DenseError),
}

/// Elastic modes before they are scaled and signed.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    /// `omega^2`, ascending, rad^2/s^2 - (m).
    pub omega2: Vec<f64>,
    /// Shapes over the unknowns, `phi^t M_eff phi = 1` - (m of n six-vectors).
    pub vectors: Vec<Vec<Vector6<f64>>>,
    /// The next value above, if the iteration saw it.
    pub next_omega2: Option<f64>,
    /// Proof of completeness; none when all modes of the structure were asked for or no gap above them is known.
    pub sturm: Option<SturmCount>,
}

/// Number of modes below a frequency, counted without computing them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SturmCount {
    /// Frequency of the count, rad/s, in a gap of the spectrum.
    pub omega: f64,
    /// Modes below by inertia.
    pub counted: usize,
    /// Modes below found by the iteration.
    pub found: usize,
}

/// The eigenproblem of a free body, or of a clamped structure.
pub struct FreeBody<'a> {
    k: &'a BlockMatrix,
    strains: StrainForm,
    /// Largest distance of a node from the origin of A, m.
    length: f64,
    mass: &'a MassMatrix,
    /// `M_RR^{-1}`; none where the structure is clamped.
    rr_inverse: Option<Matrix6<f64>>,
    symbolic: Arc<Symbolic>,
    factor: Factor,
}

impl<'a> FreeBody<'a> {
    /// Factorises `K_SS`, the elastic stiffness about a configuration, which must be positive definite.
    pub fn new(
        assembly: &Assembly,
        at: &Configuration,
        k: &'a BlockMatrix,
        mass: &'a MassMatrix,
    ) -> Result<Self, EigenError> {
        let symbolic = Arc::new(Symbolic::new(k.pattern.clone()));
        let mut factor = Factor::new(symbolic.clone());
        factor.refactor(k).map_err(EigenError::Singular)?;
        let count = factor.negative_eigenvalues();
        if count > 0 {
            return Err(EigenError::Unstable { count });
        }
        let rr_inverse = match assembly.support {
            Support::Clamped => None,
            Support::Free => Some(mass.rr.cholesky().ok_or(EigenError::MassNotDefinite)?.inverse()),
        };
        let strains = StrainForm::new(assembly, at);
        let length = at.positions.iter().map(|r| r.norm()).fold(f64::MIN_POSITIVE, f64::max);
        Ok(Self { k, strains, length, mass, rr_inverse, symbolic, factor })
    }

    /// Static response `K_SS^{-1} (f_S - M_SR M_RR^{-1} f_R)` to forces on the unknowns, `forces`, and their resultant about the
    /// origin of A: the free body accelerates as a whole, its inertia balances the loads (inertia relief) - (n).
    pub fn static_response(&self, forces: &[Vector6<f64>], resultant: &Vector6<f64>) -> Vec<Vector6<f64>> {
        // A clamp takes the resultant.
        let acceleration = self.rr_inverse.map_or_else(Vector6::zeros, |inverse| inverse * resultant);
        let mut x: Vec<_> =
            forces.iter().zip(&self.mass.sr).map(|(force, sr)| force - sr * acceleration).collect();
        self.solve_panels::<1>(&mut x);
        x
    }

    /// `u . K_SS u`, twice the strain energy of a field.
    pub fn strain_work(&self, u: &[Vector6<f64>]) -> f64 {
        let mut force = vec![Vector6::zeros(); u.len()];
        self.strains.subtract(u, &mut force);
        -u.iter().zip(&force).map(|(u, force)| u.dot(force)).sum::<f64>()
    }

    /// `K_SS^{-1} f` in place for many fields of forces on the unknowns, A held.
    pub fn held_responses(&self, fields: &mut [Vec<Vector6<f64>>]) {
        for group in fields.chunks_mut(B) {
            let entry =
                |row: usize, column: usize, k: usize| group.get(column).map_or(0.0, |field| field[row][k]);
            let mut panel: Vec<Panel> = (0..self.k.pattern.n())
                .map(|row| Panel::from_fn(|k, column| entry(row, column, k)))
                .collect();
            self.solve_panels(&mut panel);
            for (column, field) in group.iter_mut().enumerate() {
                field.iter_mut().zip(&panel).for_each(|(x, block)| *x = block.column(column).into_owned());
            }
        }
    }

    /// `K_SS^{-1} b` in place, corrected by the residuals of the strains until the digits are those of the strains and not of the
    /// factorisation.
    fn solve_panels<const C: usize>(&self, x: &mut [SMatrix<f64, 6, C>]) {
        let b = x.to_vec();
        self.factor.solve_panels(x);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_CORRECTIONS {
            let mut correction = b.clone();
            self.strains.subtract(x, &mut correction);
            self.factor.solve_panels(&mut correction);
            let size = self.relative_size(&correction, x);
            // Not smaller than the one before: nothing to gain from it.
            if size.is_nan() || size >= 0.5 * last {
                return;
            }
            x.iter_mut().zip(&correction).for_each(|(x, c)| *x += c);
            if size < REFINED {
                return;
            }
            last = size;
        }
    }

    /// Largest motion of a correction over that of what it corrects, translations in lengths of the body, in the worst column.
    fn relative_size<const C: usize>(
        &self,
        correction: &[SMatrix<f64, 6, C>],
        x: &[SMatrix<f64, 6, C>],
    ) -> f64 {
        let largest = |panel: &[SMatrix<f64, 6, C>], column: usize| {
            let of = |block: &SMatrix<f64, 6, C>| {
                let (moved, turned) =
                    (block.fixed_view::<3, 1>(0, column), block.fixed_view::<3, 1>(3, column));
                (moved.amax() / self.length).max(turned.amax())
            };
            panel.iter().map(of).fold(f64::MIN_POSITIVE, f64::max)
        };
        (0..C).map(|column| largest(correction, column) / largest(x, column)).fold(0.0, f64::max)
    }

    /// Elastic degrees of freedom.
    pub fn size(&self) -> usize {
        6 * self.k.pattern.n()
    }

    /// The `count` lowest elastic modes, proven complete.
    pub fn lowest(&self, count: usize) -> Result<Eigenpairs, EigenError> {
        let size = self.size();
        let dense = size <= MAX_DENSE && (size <= 12 * B || 4 * (count + B) > size);
        let limit = if size <= MAX_DENSE { size } else { MAX_PANELS * B / 2 };
        if count > limit {
            return Err(EigenError::TooMany { requested: count, available: size, limit });
        }
        let mut pairs = if dense { self.all_dense()? } else { self.lanczos(count + 2)? };
        let found = pairs.omega2.len();
        pairs.next_omega2 = pairs.omega2.get(count).copied();
        pairs.sturm = self.check_complete(&pairs.omega2, count.min(found))?;
        pairs.omega2.truncate(count);
        pairs.vectors.truncate(count);
        Ok(pairs)
    }

    /// Number of elastic modes below a circular frequency (rad/s), by inertia.
    pub fn count_below(&self, omega: f64) -> Result<usize, EigenError> {
        let sigma = omega * omega;
        let mut factor = Factor::new(self.symbolic.clone());
        factor.refactor(&self.k.plus(-sigma, &self.mass.ss)).map_err(EigenError::Singular)?;
        if self.rr_inverse.is_none() {
            return Ok(factor.negative_eigenvalues());
        }
        // Schur complement of the rigid border: -sigma M_RR - sigma^2 M_RS (K - sigma M_SS)^{-1} M_SR.
        let mut x = self.mass.sr.clone();
        factor.solve_panels::<6>(&mut x);
        let coupling: Matrix6<f64> = self.mass.sr.iter().zip(&x).map(|(sr, x)| sr.transpose() * x).sum();
        let schur = self.mass.rr * (-sigma) - coupling * (sigma * sigma);
        let symmetric = (schur + schur.transpose()) * 0.5;
        let border = symmetric.symmetric_eigenvalues().iter().filter(|&&v| v < 0.0).count();
        Ok((factor.negative_eigenvalues() + border).saturating_sub(6))
    }

    /// Sturm count in the first clear gap at or above `count` modes.
    fn check_complete(&self, omega2: &[f64], count: usize) -> Result<Option<SturmCount>, EigenError> {
        let gap = (count.max(1)..omega2.len()).find(|&p| omega2[p] - omega2[p - 1] > 1e-5 * omega2[p]);
        let Some(p) = gap else { return Ok(None) };
        let omega = (0.5 * (omega2[p] + omega2[p - 1])).sqrt();
        let counted = self.count_below(omega)?;
        if counted == p {
            Ok(Some(SturmCount { omega, counted, found: p }))
        } else {
            Err(EigenError::Missed { found: p, counted, omega })
        }
    }

    /// `M_eff X` for a panel of vectors.
    fn mass_times(&self, x: &[Panel]) -> Vec<Panel> {
        let pattern = &self.mass.ss.pattern;
        let momentum: Panel = self.mass.sr.iter().zip(x).map(|(sr, x)| sr.transpose() * x).sum();
        let rigid = self.rr_inverse.map_or_else(Panel::zeros, |inverse| inverse * momentum);
        (0..pattern.n())
            .map(|i| {
                let elastic: Panel = pattern.row(i).map(|(j, slot)| self.mass.ss.values[slot] * x[j]).sum();
                elastic - self.mass.sr[i] * rigid
            })
            .collect()
    }

    fn lanczos(&self, wanted: usize) -> Result<Eigenpairs, EigenError> {
        let n = self.k.pattern.n();
        // Two inverse iterations damp what the random start has in the stiff modes.
        let mut candidate = start_panel(n);
        self.solve_panels(&mut candidate);
        candidate = self.mass_times(&candidate);
        self.solve_panels(&mut candidate);
        let mut basis = Basis::default();
        let mut ritz = Ritz::default();
        for panels in 1..=MAX_PANELS.min(self.size() / B) {
            let Some(coupling) = basis.append(candidate, |x| self.mass_times(x)) else { break };
            basis.couple(coupling);
            candidate = basis.mass_times_last().to_vec();
            self.solve_panels(&mut candidate);
            basis.project(&mut candidate);
            if panels * B >= wanted + B {
                ritz = basis.ritz(wanted, &candidate, |x| self.mass_times(x))?;
                if ritz.converged >= wanted {
                    return Ok(basis.eigenpairs(&ritz, wanted));
                }
            }
        }
        Err(EigenError::NoConvergence {
            vectors: basis.v.len() * B,
            converged: ritz.converged,
            requested: wanted,
        })
    }

    /// All modes of a small structure.
    fn all_dense(&self) -> Result<Eigenpairs, EigenError> {
        let (size, n) = (self.size(), self.k.pattern.n());
        let dense = |a: &BlockMatrix| {
            let mut out = DMatrix::zeros(size, size);
            for i in 0..n {
                for (j, slot) in a.pattern.row(i) {
                    out.view_mut((6 * i, 6 * j), (6, 6)).copy_from(&a.values[slot]);
                }
            }
            out
        };
        let mut sr = DMatrix::zeros(size, 6);
        for (i, block) in self.mass.sr.iter().enumerate() {
            sr.view_mut((6 * i, 0), (6, 6)).copy_from(block);
        }
        let mut m = dense(&self.mass.ss);
        if let Some(inverse) = self.rr_inverse {
            m -= &sr * inverse * sr.transpose();
        }
        // Inverse problem M x = (1/lambda) K x: the lowest modes come out with the smallest relative error.
        let (inverse, x) = generalised_eigen(&((&m + m.transpose()) * 0.5), &dense(self.k))?;
        let mut pairs =
            Eigenpairs { omega2: Vec::new(), vectors: Vec::new(), next_omega2: None, sturm: None };
        for j in (0..size).rev() {
            if inverse[j] <= 0.0 {
                return Err(EigenError::MassNotDefinite);
            }
            let scale = 1.0 / inverse[j].sqrt();
            pairs.omega2.push(1.0 / inverse[j]);
            pairs.vectors.push((0..n).map(|i| Vector6::from_fn(|k, _| x[(6 * i + k, j)] * scale)).collect());
        }
        Ok(pairs)
    }
}

/// Deterministic start vectors with parts in every mode.
fn start_panel(n: usize) -> Vec<Panel> {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| Panel::from_fn(|_, _| next())).collect()
}

/// Krylov basis, orthonormal in `M_eff`, with `M_eff V` beside it and the projected operator.
#[derive(Default)]
struct Basis {
    v: Vec<Vec<Panel>>,
    mv: Vec<Vec<Panel>>,
    /// Columns of `V^t M OP V`, block by block: `t[j][i]`, i <= j + 1.
    t: Vec<Vec<Small>>,
}

#[derive(Default)]
struct Ritz {
    /// `1/omega^2`, descending.
    theta: Vec<f64>,
    y: DMatrix<f64>,
    converged: usize,
}

fn inner(a: &[Panel], b: &[Panel]) -> Small {
    a.iter().zip(b).map(|(a, b)| a.tr_mul(b)).sum()
}

fn subtract(x: &mut [Panel], v: &[Panel], c: &Small) {
    for (x, v) in x.iter_mut().zip(v) {
        *x -= v * c;
    }
}

impl Basis {
    /// Orthonormalises a panel against itself and appends it. Returns `R` with `panel = V_new R`, or nothing when the panel
    /// has vanished (the space is exhausted).
    fn append(&mut self, mut panel: Vec<Panel>, mass: impl Fn(&[Panel]) -> Vec<Panel>) -> Option<Small> {
        let mut r = Small::identity();
        // Twice is enough: the second pass removes what the first one's round-off left.
        for _ in 0..2 {
            let m = mass(&panel);
            let l = inner(&panel, &m).cholesky()?.l();
            let inverse = l.transpose().try_inverse()?;
            for p in &mut panel {
                *p *= inverse;
            }
            r = l.transpose() * r;
        }
        self.mv.push(mass(&panel));
        self.v.push(panel);
        Some(r)
    }

    /// Records the coupling of the newest panel with the one before it.
    fn couple(&mut self, r: Small) {
        if let Some(last) = self.t.last_mut() {
            last.push(r);
        }
    }

    fn mass_times_last(&self) -> &[Panel] {
        self.mv.last().expect("a panel was appended")
    }

    /// Removes from `w = OP V_last` its part in the basis (twice) and records it.
    fn project(&mut self, w: &mut [Panel]) {
        let mut column = vec![Small::zeros(); self.v.len()];
        for _ in 0..2 {
            for (i, c) in column.iter_mut().enumerate() {
                let part = inner(&self.mv[i], w);
                subtract(w, &self.v[i], &part);
                *c += part;
            }
        }
        self.t.push(column);
    }

    /// Eigenpairs of the projected operator and how many of the first `wanted` have converged.
    fn ritz(
        &self,
        wanted: usize,
        rest: &[Panel],
        mass: impl Fn(&[Panel]) -> Vec<Panel>,
    ) -> Result<Ritz, EigenError> {
        let panels = self.v.len();
        let n = panels * B;
        let mut t = DMatrix::zeros(n, n);
        for (j, column) in self.t.iter().enumerate() {
            for (i, block) in column.iter().enumerate().take(j + 1) {
                t.view_mut((i * B, j * B), (B, B)).copy_from(block);
                if i < j {
                    t.view_mut((j * B, i * B), (B, B)).copy_from(&block.transpose());
                }
            }
        }
        let (values, vectors) = symmetric_eigen(&((&t + t.transpose()) * 0.5))?;
        let theta: Vec<f64> = values.iter().rev().copied().collect();
        let y = DMatrix::from_fn(n, n, |i, j| vectors[(i, n - 1 - j)]);
        // |OP x - theta x| in M_eff is the norm of the rest times the last rows of y.
        let gram = inner(rest, &mass(rest));
        let converged = (0..wanted.min(n))
            .take_while(|&j| {
                let tail = y.view(((panels - 1) * B, j), (B, 1));
                let tail = SMatrix::<f64, B, 1>::from_iterator(tail.iter().copied());
                let residual = (tail.transpose() * gram * tail)[0].max(0.0).sqrt();
                residual <= TOLERANCE * theta[j] && theta[j] > 0.0
            })
            .count();
        Ok(Ritz { theta, y, converged })
    }

    fn eigenpairs(&self, ritz: &Ritz, count: usize) -> Eigenpairs {
        let n = self.v.first().map_or(0, Vec::len);
        let mut vectors = vec![vec![Vector6::zeros(); n]; count];
        for (j, vector) in vectors.iter_mut().enumerate() {
            for (p, panel) in self.v.iter().enumerate() {
                let c = SMatrix::<f64, B, 1>::from_fn(|k, _| ritz.y[(p * B + k, j)]);
                for (x, v) in vector.iter_mut().zip(panel) {
                    *x += v * c;
                }
            }
        }
        let omega2 = ritz.theta[..count].iter().map(|t| 1.0 / t).collect();
        Eigenpairs { omega2, vectors, next_omega2: None, sturm: None }
    }
}
