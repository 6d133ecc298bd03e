"""Derivatives of the equations of motion and linear models."""

import numpy as np
import pytest
import scipy.io
import scipy.linalg

import romgen


def test_columns_of_the_jacobian_are_slopes_of_the_derivatives(model):
    simulation = romgen.Simulation(model, 0.01)
    state = simulation.state
    state.q = np.linspace(-1, 1, model.n_modes)
    state.q_dot = np.linspace(2, -1, model.n_modes)
    simulation.state = state
    loads = model.load_set(["P"], frame="dead")
    loads.add("P", [30, 10, -20], [5, 0, 2])
    jacobian = simulation.jacobian(loads)
    m, n = model.n_modes, 2 * model.n_modes + 12
    assert jacobian.matrix.shape == (n, n) and len(jacobian.states) == n
    assert jacobian.states[0] == "q.1" and jacobian.states[-1] == "r_G.z"
    h = 1e-3
    for k in range(m):
        rates = []
        for sign in (1, -1):
            moved = simulation.state
            q = moved.q
            q[k] += sign * h
            moved.q = q
            rates.append(model.derivatives(moved, loads).u_dot)
        slope = (rates[0] - rates[1]) / (2 * h)
        # Central differences: h^2 of third derivatives, round-off over h.
        assert jacobian.matrix[m : 2 * m + 6, k] == pytest.approx(slope, abs=1e-7 * np.abs(slope).max())
    assert model.jacobian(state, loads).matrix == pytest.approx(jacobian.matrix)
    unit = model.load_set(["P"], frame="dead")
    unit.add("P", [0, 0, 1])
    before = model.derivatives(state, loads).u_dot
    loads.add("P", [0, 0, 1])
    grown = model.derivatives(state, loads).u_dot - before
    assert jacobian.by_load(unit)[m : 2 * m + 6] == pytest.approx(grown, abs=1e-10)


def test_a_linear_model_has_the_frequencies_and_goes_to_matlab_and_back(model, tmp_path):
    linear = romgen.linearise(model, inputs=["P", "A"], outputs=["A", "P", "modes"], reduce=True)
    n = len(linear.states)
    assert linear.A.shape == (n, n) and linear.B.shape == (n, 12)
    assert linear.C.shape == (len(linear.outputs), n) and linear.D.shape == (len(linear.outputs), 12)
    found = np.sort(linear.poles.imag[linear.poles.imag > 1e-3])
    assert found == pytest.approx(np.sort(model.omega), rel=1e-9)
    assert linear.steady["wrench"] is None and linear.steady["residual"] == 0
    # scipy reads what is written, and finds the same poles.
    linear.save(tmp_path / "model.mat")
    mat = scipy.io.loadmat(tmp_path / "model.mat", simplify_cells=True)
    for name in "ABCD":
        assert np.array_equal(mat[name], getattr(linear, name))
    assert list(mat["states"]) == linear.states
    assert list(mat["inputs"]) == linear.inputs and list(mat["outputs"]) == linear.outputs
    assert mat["input_units"][0] == "N" and mat["poles"] == pytest.approx(linear.poles)
    again = np.sort(scipy.linalg.eigvals(mat["A"]).imag)[-model.n_modes :]
    assert again == pytest.approx(np.sort(model.omega), rel=1e-8)
    linear.save(tmp_path / "model.npz")
    npz = np.load(tmp_path / "model.npz")
    assert np.array_equal(npz["C"], linear.C) and list(npz["outputs"]) == linear.outputs


def test_a_steady_rotation_and_refusals(model):
    spinning = romgen.linearise(model, rate=[0, 0.5, 0])
    assert spinning.steady["velocity"][4] == pytest.approx(0.5)
    held = romgen.linearise(model, rate=[0.2, 0.3, 0], velocity=[1, 0, 0], hold=True)
    assert np.abs(held.steady["wrench"]).max() > 1
    with pytest.raises(romgen.ModelError, match="no input"):
        romgen.linearise(model, inputs=["nowhere"])
    with pytest.raises(romgen.Error, match="accelerates by"):
        romgen.linearise(model, model.load_case("lc2"), time=1.0)
    with pytest.raises(ValueError, match="rate"):
        romgen.linearise(model, rate=[0, np.nan, 0])
