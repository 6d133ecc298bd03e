"""Directional derivatives against differences of what the FMU itself gives."""

import numpy as np
import pytest

# Of the outputs of the frame, at loads and motions of a few N and m/s.
OUTPUTS = ["r_CM_G", "p_G", "L_G", "r_G", "v_G", "w_G", "P.dR_A", "P.R_G", "P.zeta", "P.v_G", "P.w_G", "P.a_G", "P.alpha_G", "'nose imu'.a_S", "'nose imu'.alpha_S"]
SCALARS = ["E_kin", "E_el", "E_grav", "q[1]", "q_dot[3]", "der(q_dot[1])", "der(q_dot[5])"]


def names_of(host):
    """Outputs looked at, states and their rates in the order of the description."""
    all_names = list(host.names)
    outputs = [n for n in all_names if n.rpartition(".")[0] in OUTPUTS or n in SCALARS]
    rates = [unknown.variable.name for unknown in host.description.derivatives]
    states = [next(v for v in host.description.modelVariables if v.name == rate).derivative.name for rate in rates]
    assert len(states) == 2 * 10 + 13
    return outputs, states, rates


def test_the_description_names_states_and_their_rates(slave):
    _, states, rates = names_of(slave())
    pairs = dict(zip(states, rates))
    assert pairs["q[1]"] == "q_dot[1]" and pairs["q_dot[1]"] == "der(q_dot[1])"
    assert pairs["r_G.z"] == "v_G.z" and pairs["zeta.w"] == "der(zeta.w)" and pairs["w_A.y"] == "der(w_A.y)"
    assert states[-1] == "r_G.z"


@pytest.mark.parametrize("method", [1, 2, 3])
def test_derivatives_by_inputs_are_what_inputs_add(slave, method):
    """Accelerations are linear in the loads: one difference, of any size, is exact."""
    host = slave().start(method=method, load_case=2).go()
    host.step(0.0, 0.2)
    outputs, _, rates = names_of(host)
    host.set(**{"Q.body.force.x": 3.0, "P.follower.moment.y": -2.0})
    for knowns, seeds in [
        (["P.dead.force.x"], [1.0]),
        (["P.body.moment.z", "Q.dead.force.y", "Q.body.force.x"], [0.5, -2.0, 1.0]),
        (["P.follower.force.y", "P.follower.moment.y"], [1.0, 3.0]),
    ]:
        found = host.derivative(outputs + rates, knowns, seeds)
        start, before = host.get(*knowns), host.get(*outputs, *rates)
        host.set(**dict(zip(knowns, start + seeds)))
        added = host.get(*outputs, *rates) - before
        host.set(**dict(zip(knowns, start)))
        assert np.abs(added).max() > 1e-3
        assert found == pytest.approx(added, rel=1e-9, abs=1e-10 * np.abs(before).max())


@pytest.mark.parametrize("method", [1, 2, 3])
def test_derivatives_by_the_motion_of_a_are_differences_of_starts(slave, method):
    rng = np.random.default_rng(2)
    zeta = rng.standard_normal(4)
    start = dict(zip(["r_G.x", "r_G.y", "r_G.z"], rng.standard_normal(3)))
    start |= dict(zip(["v_A.x", "v_A.y", "v_A.z"], rng.standard_normal(3)))
    start |= dict(zip(["w_A.x", "w_A.y", "w_A.z"], rng.standard_normal(3)))
    start |= dict(zip(["zeta.w", "zeta.x", "zeta.y", "zeta.z"], zeta / np.linalg.norm(zeta)))

    def at(values):
        host = slave()
        host.set(**{"initial_" + name: value for name, value in values.items()})
        host.start(method=method, **{"gravity.z": -9.81})
        host.set(**{"P.dead.force.x": 5.0, "Q.body.moment.y": -3.0})
        return host

    host = at(start)
    outputs, _, rates = names_of(host)
    for _ in range(6):
        seeds = dict(zip(start, rng.standard_normal(len(start))))
        # Along the sphere: the parameter is scaled to unit length.
        q, dq = (np.array([values[n] for n in start if n.startswith("zeta")]) for values in (start, seeds))
        seeds |= dict(zip([n for n in start if n.startswith("zeta")], dq - (dq @ q) * q))
        found = host.derivative(outputs + rates, list(seeds), list(seeds.values()))
        h = 1e-3
        # Sixth order: 1e-18 of the derivatives beyond, and round-off over h.
        rule = [(1, 0.75), (2, -0.15), (3, 1 / 60)]
        moved = lambda k: at({n: v + k * h * seeds[n] for n, v in start.items()}).get(*outputs, *rates)
        difference = sum(weight / h * (moved(k) - moved(-k)) for k, weight in rule)
        scale = np.abs(difference).max()
        assert found == pytest.approx(difference, rel=1e-8, abs=1e-11 * scale)


@pytest.mark.parametrize("method", [1, 2])
def test_along_the_rates_of_the_states_outputs_change_as_in_time(slave, method):
    """d y/d t = (d y/d x) x_dot where nothing depends on the time itself."""
    host = slave().start(method=method, integrator=2, dt=1e-4)
    host.set(**{"P.body.force.z": 30.0, "Q.dead.force.y": -20.0, "P.follower.moment.x": 15.0})
    host.go()
    host.step(0.0, 0.3)
    outputs, states, rates = names_of(host)
    rate = host.get(*rates)
    assert np.count_nonzero(rate) > 25
    found = host.derivative(outputs + rates, states, rate)
    h, saved = 2e-4, host.save()
    values = [host.get(*outputs, *rates)]
    for k in range(4):
        host.step(0.3 + k * h, h)
        values.append(host.get(*outputs, *rates))
    host.load(saved)
    # One-sided, fourth order: with frequencies of 120 rad/s (0.024)^4/5 of the derivative.
    weights = np.array([-25 / 12, 4, -3, 4 / 3, -1 / 4]) / h
    difference = sum(w * v for w, v in zip(weights, values))
    scale = np.maximum(np.abs(difference), np.abs(values[0]).max() * 1e-3)
    assert np.abs(found - difference).max() <= 2e-6 * scale.max()
    assert np.all(np.abs(found - difference) <= 1e-5 * scale)


def test_what_has_no_derivative_is_refused_in_words(slave):
    host = slave()
    with pytest.raises(RuntimeError, match="phase"):
        host.derivative(["v_G.x"], ["q[1]"], [1.0])
    host.start().go()
    for unknowns, knowns, seed, words in [
        (["v_G.x"], ["dt"], 1.0, "by dt is asked for"),
        (["v_G.x"], ["P.R_G.x"], 1.0, "by P.R_G.x is asked for"),
        (["P.dead.force.x"], ["q[1]"], 1.0, "of P.dead.force.x is asked for"),
        (["v_G.x"], ["q[1]"], np.nan, "seed of q"),
    ]:
        with pytest.raises(RuntimeError, match=words):
            host.derivative(unknowns, knowns, [seed])
    assert host.derivative([], ["q[1]"], [1.0]).size == 0
    assert not host.derivative(["v_G.x"], [], []).any()
