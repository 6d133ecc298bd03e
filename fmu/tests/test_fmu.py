"""The FMUs as a host uses them, through FMPy: both versions of FMI do the same, and what romrun does."""

import re
import threading

import fmpy
import numpy as np
import pytest
from conftest import ROOT
from fmpy.validation import validate_fmu
from slave import Slave, values

# Of lc2 in the list of the parameter's type: none, lc1, lc2, ...
LC2 = 2


def test_the_description_is_valid(fmu):
    assert validate_fmu(str(fmu)) == []


def test_names_of_every_kind_are_valid_and_unique(bent):
    for path in bent:
        assert validate_fmu(str(path)) == []
        names = [v.name for v in fmpy.read_model_description(path).modelVariables]
        assert len(set(names)) == len(names)
        assert "knee.follower.'rod+'[2].moment.z" in names


def test_a_load_case_chosen_by_parameter_is_that_of_romrun(fmu, romrun):
    expected = romrun("lc2", "--point-motion")
    description = fmpy.read_model_description(fmu)
    channels = {n: values(description, n) for n in expected.files if n not in ("metadata", "t", "error_indicator", "predicted_error")}
    # Estimates of errors belong to runs, not to FMUs; results.npz has the amplitudes as one channel.
    channels["q"] = [v for v in description.modelVariables if v.name.startswith("q[")]
    names = [v.name for variables in channels.values() for v in variables]
    found = fmpy.simulate_fmu(
        str(fmu), start_values={"load_case": LC2}, stop_time=10.0, output_interval=0.01, output=names
    )
    assert len(found) == len(expected["t"])
    for name, variables in channels.items():
        rows = np.atleast_2d(expected[name].T)
        assert len(variables) == len(rows) > 0, name
        for variable, row in zip(variables, rows):
            scale = max(1.0, np.abs(expected[name]).max())
            assert np.abs(found[variable.name] - row).max() <= 1e-9 * scale, variable.name


def test_the_program_of_the_page_runs(folder, monkeypatch):
    page = (ROOT / "docs" / "fmu.md").read_text()
    monkeypatch.chdir(folder)
    names = {}
    exec(re.search(r"```python\n(.*?)```", page, re.S)[1], names)
    assert names["result"]["time"][-1] == 10.0 and np.abs(names["result"]["w_G.y"]).max() > 0.01


@pytest.mark.parametrize("integrator", [2, 3])
def test_other_integrators_are_those_of_romrun(fmu, romrun, integrator):
    name, dt = {2: ("rk4", 0.002), 3: ("gen-alpha", 0.005)}[integrator]
    expected = romrun("lc2", "--integrator", name, "--dt", str(dt), "--t-end", "2")
    found = fmpy.simulate_fmu(
        str(fmu),
        start_values={"load_case": LC2, "integrator": integrator, "dt": dt},
        stop_time=2.0,
        output_interval=0.1,
        output=["w_G.y"],
    )
    every = round(0.1 / dt)
    assert np.abs(found["w_G.y"] - expected["w_G"][::every, 1]).max() <= 1e-9


def test_sampled_inputs_are_as_good_as_their_sampling(slave, romrun):
    """A sine held over every communication step against the same sine as a load case: first order in the step."""
    end = romrun("push")["p_G"][-1]

    def error(size):
        host = slave().start(dt=0.001).go()
        for step in range(round(2.0 / size)):
            host.set(**{"P.body.force.y": 40 * np.sin(3 * step * size)})
            host.step(step * size, size)
        return np.linalg.norm(host.get("p_G.x", "p_G.y", "p_G.z") - end) / np.linalg.norm(end)

    errors = [error(size) for size in (0.04, 0.02, 0.01)]
    assert errors[-1] < 0.03
    for coarse, fine in zip(errors, errors[1:]):
        assert 1.7 < coarse / fine < 2.3, errors


def test_steps_that_are_no_multiple_are_made_of_equal_ones(slave, romrun):
    # 0.025 s in steps of at most 0.01 s: three of a third.
    host = slave().start(load_case=LC2, dt=0.01).go()
    for step in range(40):
        host.step(0.025 * step, 0.025)
    expected = romrun("lc2", "--dt", repr(0.025 / 3), "--t-end", "1")
    assert host.get("time")[0] == pytest.approx(1.0, rel=1e-14)
    assert host.get("w_G.y")[0] == pytest.approx(expected["w_G"][-1, 1], rel=1e-9)
    # Long runs of short steps do not lose the host's time.
    host = slave().start(dt=0.01).go()
    for step in range(10_000):
        host.step(0.1 * step, 0.1)
    assert host.get("time")[0] == pytest.approx(1000.0, rel=1e-13)


def test_saved_states_rewind_to_the_bit(slave):
    host = slave().start(load_case=LC2)
    host.set(**{"Q.dead.force.x": 3.0})
    host.go()

    def run(host, first):
        for step in range(first, first + 40):
            host.set(**{"P.follower.moment.y": np.sin(step)})
            # Some steps are no multiples of dt: they are part of the state too.
            host.step(0.01 * step, 0.004)
            host.step(0.01 * step + 0.004, 0.006)
        return host.outputs()

    run(host, 0)
    saved, here = host.save(), host.outputs()
    data = host.to_bytes(saved)
    end = run(host, 40)
    host.load(saved)
    assert np.array_equal(host.outputs(), here)
    assert np.array_equal(run(host, 40), end)
    assert not np.array_equal(here, end)
    # In another instance, from bytes.
    other = slave()
    other.load(other.from_bytes(data))
    assert np.array_equal(other.outputs(), here)
    assert np.array_equal(run(other, 40), end)
    for place in (0, len(data) // 2, len(data) - 1):
        damaged = bytearray(data)
        damaged[place] ^= 1
        with pytest.raises(RuntimeError, match="damaged"):
            other.from_bytes(bytes(damaged))
    assert np.array_equal(other.outputs(), end)


def test_motion_and_gravity_at_the_start(slave):
    half = np.sqrt(0.5)
    start = {
        "gravity.z": -9.81, "initial_v_A.x": 20.0, "initial_r_G.z": 100.0,
        "initial_zeta.w": half, "initial_zeta.y": half,
    }
    for method in (1, 2, 3):
        host = slave().start(method=method, **start)
        r = host.get("r_CM_G.x", "r_CM_G.y", "r_CM_G.z")
        # A quarter turn about y: x of A is -z of G.
        assert host.get("v_G.x", "v_G.y", "v_G.z") == pytest.approx([0, 0, -20], abs=1e-12)
        assert host.get("r_G.x", "r_G.y", "r_G.z") == pytest.approx([0, 0, 100], abs=1e-12)
        host.go()
        host.step(0.0, 1.0)
        # Newmark is exact for a parabola.
        fall = host.get("r_CM_G.x", "r_CM_G.y", "r_CM_G.z") - r
        assert fall == pytest.approx([0, 0, -20 - 9.81 / 2], abs=1e-9)
        assert host.get("'nose imu'.a_S.x", "'nose imu'.a_S.y", "'nose imu'.a_S.z") == pytest.approx([0] * 3, abs=1e-9)


def test_accelerations_at_the_start_are_those_under_the_inputs(slave):
    host = slave().start(method=3)
    assert host.get("A.a_G.x")[0] == 0.0
    host.set(**{"CM.dead.force.x": 60.0})
    with_force = host.get("A.a_G.x")[0]
    assert with_force != 0.0
    host.go()
    host.set(**{"CM.dead.force.x": 30.0})
    assert host.get("A.a_G.x")[0] == pytest.approx(with_force / 2, rel=1e-12)
    host.set(**{"CM.dead.force.x": 60.0})
    host.step(0.0, 0.01)
    assert host.get("v_G.x")[0] == pytest.approx(with_force * 0.01, rel=1e-3)


def test_what_cannot_be_is_refused_in_words(slave, fmu, unzipped):
    other = Slave.__new__(Slave)
    with pytest.raises(Exception):
        other.__init__(fmu, unzipped, token="{00000000-0000-0000-0000-000000000000}")
    assert "belongs to the token" in other.log[0]
    host = slave()
    for set_wrong, words in [
        (lambda: host.set(**{"P.body.force.x": np.nan}), "finite"),
        (lambda: host.set(**{"v_G.x": 1.0}), "v_G.x is an output"),
        (lambda: host.start(load_case=9), r"load_case is set to 9, expected 0 \(none\) to 4"),
        (lambda: host.start(method=0), "method is 0, expected 1 to"),
        (lambda: host.step(0.0, 0.01), "only in Step"),
    ]:
        with pytest.raises(RuntimeError, match=words):
            set_wrong()
    for parameters, words in [
        (dict(dt=-1.0), "time step dt is -1"),
        (dict(integrator=2, dt=10.0), "RK4"),
        (dict(initial_zeta__w=0.0), "initial_zeta"),
    ]:
        bad = slave().start(**parameters)
        with pytest.raises(RuntimeError, match=words):
            bad.go()
    host = slave().start().go()
    with pytest.raises(RuntimeError, match="fixed once"):
        host.set(dt=0.1)
    with pytest.raises(RuntimeError, match="should begin at 5 s"):
        host.step(5.0, 0.01)
    with pytest.raises(RuntimeError, match="expected a positive number"):
        host.step(0.0, 0.0)
    host.step(0.0, 0.01)


def test_a_step_that_fails_leaves_the_state_before_it(slave):
    host = slave().start().go()
    host.step(0.0, 0.05)
    before = host.outputs()
    host.set(**{"P.body.moment.y": 1e300})
    with pytest.raises(RuntimeError, match="diverged|converge"):
        host.step(0.05, 0.01)
    # Accelerations follow the input as it is now; without it everything is as before.
    host.set(**{"P.body.moment.y": 0.0})
    assert np.array_equal(host.outputs(), before)
    host.step(0.05, 0.01)


def test_accelerations_follow_the_inputs_between_steps(slave):
    host = slave().start(load_case=LC2).go()
    host.step(0.0, 0.1)
    host.set(**{"P.body.force.z": 2.0})
    host.step(0.1, 0.1)
    names = ["v_G.x", "P.dR_A.z", "P.a_G.z", "Q.alpha_G.y", "'nose imu'.a_S.x", "der(v_A.x)", "der(q_dot[2])"]
    under = {}
    for force in (2.0, 0.0, 5.0, 2.0):
        host.set(**{"P.body.force.z": force})
        found = host.get(*names)
        assert np.array_equal(under.setdefault(force, found), found)
    # Under the input of the step to the bit those of the step; the motion is the same, accelerations are linear in the loads.
    assert np.array_equal(under[5.0][:2], under[2.0][:2])
    assert np.all(under[5.0][2:] != under[2.0][2:])
    slope = (under[5.0] - under[2.0]) / 3
    # Newmark's accelerations are those of the equations to its tolerance.
    assert under[2.0] - 2 * slope == pytest.approx(under[0.0], rel=1e-8, abs=1e-10)


def test_instances_in_threads_do_not_know_of_each_other(slave):
    def run(host, moment):
        host.set(**{"P.body.moment.y": moment})
        for step in range(200):
            host.step(0.01 * step, 0.01)

    alone = [slave().start().go() for _ in range(3)]
    for i, host in enumerate(alone):
        run(host, 5.0 * i)
    together = [slave().start().go() for _ in range(3)]
    threads = [threading.Thread(target=run, args=(host, 5.0 * i)) for i, host in enumerate(together)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    for one, other in zip(alone, together):
        assert np.array_equal(one.outputs(), other.outputs())
        one.fmu.terminate()
        one.fmu.freeInstance()
