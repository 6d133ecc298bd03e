//! The equations of motion themselves, for hosts that integrate on their own.

use std::sync::Arc;

use rom_runtime::{Jacobian, Model, State, StateRate, Workspace};

use crate::loads::rom_loads;
use crate::model::{expect_length, rom_model};
use crate::pointers::{Place, array, array_mut, exclusive, shared};
use crate::status::{Failure, guard, rom_status};

/// Memory of the evaluation of the equations of motion.
pub struct rom_evaluator {
    model: Arc<Model>,
    state: State,
    rate: StateRate,
    work: Workspace,
    jacobian: Jacobian,
    /// Whether it has been evaluated.
    evaluated: bool,
}

impl rom_evaluator {
    /// Takes over time and variables.
    fn set(&mut self, t: f64, y: &[f64]) -> Result<(), Failure> {
        let m = self.model.n_modes();
        expect_length("y", y.len(), 2 * m + 13)?;
        if let Some(found) = y.iter().chain(&[t]).find(|x| !x.is_finite()) {
            return Err(Failure::argument(format_args!("t or y holds {found}, expected finite numbers")));
        }
        if y[2 * m + 6..2 * m + 10].iter().all(|&x| x == 0.0) {
            return Err(Failure::argument("the attitude in y is zero, expected a quaternion"));
        }
        let state = &mut self.state;
        state.time = t;
        let parts: [&mut [f64]; 5] =
            [&mut state.q, &mut state.q_dot, &mut state.beta_star, &mut state.attitude, &mut state.position];
        for (to, from) in parts.into_iter().flatten().zip(y) {
            *to = *from;
        }
        Ok(())
    }
}

/// An evaluator for a model. Free it with rom_evaluator_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_evaluator_new(
    model: *const rom_model,
    evaluator: *mut *mut rom_evaluator,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (model, place) = unsafe { (shared(model, "model")?, Place::new(evaluator, "evaluator")?) };
        let model = model.model.clone();
        let evaluator = rom_evaluator {
            state: State::at_rest(&model),
            rate: StateRate::new(&model),
            work: Workspace::new(&model),
            jacobian: Jacobian::new(model.clone()),
            evaluated: false,
            model,
        };
        place.set(Box::into_raw(Box::new(evaluator)));
        Ok(())
    })
}

/// Frees an evaluator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_evaluator_free(evaluator: *mut rom_evaluator) {
    guard(|| {
        if !evaluator.is_null() {
            // SAFETY: made by Box::into_raw, and the caller has no other use for it.
            drop(unsafe { Box::from_raw(evaluator) });
        }
        Ok(())
    });
}

/// Number of variables of the equations of motion of a model, 2 m + 13: `q` (m), `q_dot` (m), `beta_star` (6), `attitude`
/// (4), `position` (3), as in rom_state_layout. 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_variables(model: *const rom_model) -> usize {
    // SAFETY: the pointer is the caller's, as the header asks for.
    unsafe { model.as_ref() }.map_or(0, |model| 2 * model.model.n_modes() + 13)
}

/// `y_dot = f(t, y)` under the loads: `y` and `y_dot` have the `n` variables of rom_model_n_variables, in their order. The
/// attitude need not be of unit length: its direction counts. Finite `y` may still give a `y_dot` that is not, where a load
/// has no finite value.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_evaluator_derivatives(
    evaluator: *mut rom_evaluator,
    t: f64,
    y: *const f64,
    n: usize,
    loads: *const rom_loads,
    y_dot: *mut f64,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, y, loads) =
            unsafe { (exclusive(evaluator, "evaluator")?, array(y, n, "y")?, shared(loads, "loads")?) };
        this.set(t, y)?;
        this.model.derivatives(&this.state, &loads.set, &mut this.work, &mut this.rate)?;
        // SAFETY: as above; made last, so that it may be the memory of `y`.
        let y_dot = unsafe { array_mut(y_dot, n, "y_dot") }?;
        let rate = &this.rate;
        let parts: [&[f64]; 4] = [&rate.q_dot, &rate.u_dot, &rate.attitude_dot, &rate.position_dot];
        for (to, from) in y_dot.iter_mut().zip(parts.into_iter().flatten()) {
            *to = *from;
        }
        Ok(())
    })
}

/// Number of tangent coordinates of a model, 2 m + 12: `q` (m), `q_dot` (m), `beta_star` (6), a small turn of A about its own axes (3,
/// rad), the position of its origin in G (3, m). 0 for NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_model_n_tangent(model: *const rom_model) -> usize {
    // SAFETY: the pointer is the caller's, as the header asks for.
    unsafe { model.as_ref() }.map_or(0, |model| 2 * model.model.n_modes() + 12)
}

/// Exact derivative of the rates of the tangent coordinates by themselves at `y`, under the loads, into `matrix`: `entries` of them, the
/// square of rom_model_n_tangent, row by row. The rate of the turn is relative to the motion at hand, `dw - w x turn`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_evaluator_jacobian(
    evaluator: *mut rom_evaluator,
    t: f64,
    y: *const f64,
    n: usize,
    loads: *const rom_loads,
    matrix: *mut f64,
    entries: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, y, loads) =
            unsafe { (exclusive(evaluator, "evaluator")?, array(y, n, "y")?, shared(loads, "loads")?) };
        let size = 2 * this.model.n_modes() + 12;
        expect_length("matrix", entries, size * size)?;
        this.set(t, y)?;
        this.evaluated = false;
        this.jacobian.evaluate(&this.state, &loads.set)?;
        this.evaluated = true;
        // SAFETY: as above.
        let matrix = unsafe { array_mut(matrix, entries, "matrix") }?;
        matrix.copy_from_slice(this.jacobian.matrix());
        Ok(())
    })
}

/// Derivative of the rates of the tangent coordinates by a factor on `loads`, at the place of the last rom_evaluator_jacobian, into `column`
/// with the `n` entries of rom_model_n_tangent: what these loads add. With one unit force among the loads it is the column of that force.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rom_evaluator_by_load(
    evaluator: *mut rom_evaluator,
    loads: *const rom_loads,
    column: *mut f64,
    n: usize,
) -> rom_status {
    guard(|| {
        // SAFETY: pointers are the caller's, as the header asks for.
        let (this, loads) = unsafe { (exclusive(evaluator, "evaluator")?, shared(loads, "loads")?) };
        expect_length("column", n, 2 * this.model.n_modes() + 12)?;
        if !this.evaluated {
            return Err(Failure::argument("call rom_evaluator_jacobian first: it says where"));
        }
        // SAFETY: as above.
        let column = unsafe { array_mut(column, n, "column") }?;
        this.jacobian.by_load(&loads.set, column)?;
        Ok(())
    })
}
