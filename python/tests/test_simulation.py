"""Stepping, loads, states. What the runtime computes is proven by its own tests; these prove that it arrives."""

import copy
import pickle
import threading

import numpy as np
import pytest

import romgen


def test_a_run_is_the_steps_one_by_one(model):
    case = model.load_case("lc2")
    results = romgen.run(model, "lc2", t_end=1.0, points=["P"])
    simulation = romgen.Simulation(model, case.dt, numerical_damping=case.numerical_damping)
    for row in range(len(results["t"])):
        if row > 0:
            simulation.step(case)
        rigid = simulation.rigid
        for name in ["r_G", "v_G", "w_G", "v_A", "w_A", "zeta"]:
            assert np.array_equal(getattr(rigid, name), results[name][row]), name
        point = simulation.point("P")
        assert np.array_equal(point.dR_A, results["P.dR_A"][row])
        assert np.array_equal(point.R_G, results["P.R_G"][row])
        ledger = simulation.ledger
        for name in ["r_CM_G", "p_G", "L_G", "E_kin", "E_el", "E_grav"]:
            assert np.array_equal(getattr(ledger, name), results[name][row]), name
        assert np.array_equal(simulation.state.q, results["q"][row])
    assert results["t"][-1] == 1.0 and len(results["t"]) == 101
    assert results.units["v_G"] == "m/s" and results.components["zeta"] == list("wxyz")
    assert "Q.dR_A" not in results


def test_dead_forces_move_a_rigid_body_as_newton_says(model):
    rigid = model.with_method("rigid")
    force, arm = np.array([30.0, -10.0, 20.0]), np.array([10.0, 0.0, 5.0])
    loads = rigid.load_set(["P"], frame="dead")
    loads.set([[*force, 0, 0, 0]])
    first = rigid.derivatives(romgen.State(rigid), loads).u_dot
    assert rigid.mass_matrix @ first == pytest.approx(np.r_[force, np.cross(arm, force)], rel=1e-9)

    def error(dt):
        results = romgen.Simulation(rigid, dt).run(loads, t_end=1.0)
        return np.linalg.norm(results["p_G"][-1] - force * 1.0) / np.linalg.norm(force)

    # Second order: the axes of the body turn during a step.
    coarse, fine = error(0.01), error(0.005)
    assert coarse < 1e-4 and (fine < 1e-12 or 3.5 < coarse / fine < 4.5)


def test_rows_of_wrenches_are_the_loads_of_their_step(model):
    rng = np.random.default_rng(1)
    wrenches = 50 * rng.standard_normal((40, 2, 6))
    loads = model.load_set(["P", "left corner"], frame="body")
    simulation = romgen.Simulation(model, 0.01)
    results = simulation.run_wrenches(loads, wrenches, every=10)
    by_hand = romgen.Simulation(model, 0.01)
    for row in wrenches:
        loads.clear()
        for point, wrench in zip(loads.points, row):
            loads.add(point, force=wrench[:3], moment=wrench[3:])
        by_hand.step(loads)
    assert by_hand.state == simulation.state
    assert results["t"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    # A second run goes on where the first one ended.
    more = simulation.run(None, steps=10)
    assert more["t"][0] == results["t"][-1]
    assert np.array_equal(more["q"][0], results["q"][-1])


def test_wrenches_beside_a_load_case(model):
    case = model.load_case("lc2")
    loads = model.load_set(["Q"], frame="dead", case=case)
    state = romgen.State(model)
    state.time = 5.0
    only, both = model.derivatives(state, case).u_dot, model.derivatives(state, loads).u_dot
    # One point more, without a load: the same but for the order of the sums.
    assert both == pytest.approx(only, abs=1e-14 * np.abs(only).max())
    loads.add("Q", force=[0, 3, 0])
    alone = model.load_set(["Q"], frame="dead")
    alone.add("Q", force=[0, 3, 0])
    expected = only + model.derivatives(state, alone).u_dot
    # At one state the accelerations are linear in the loads.
    assert model.derivatives(state, loads).u_dot == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_a_wrench_on_a_and_forces_on_the_modes(model):
    state = romgen.State(model)
    nothing = model.load_set([])
    free = model.derivatives(state, nothing).u_dot
    loads = model.load_set([])
    loads.add_wrench(force=[0, 0, 405.0])
    # The frame weighs 405 kg; its centre of mass is above A, on the line of the force.
    assert (model.derivatives(state, loads).u_dot - free)[-4] == pytest.approx(1.0, rel=1e-9)
    loads.clear()
    forces = np.linspace(1.0, 2.0, model.n_modes)
    loads.add_modal(forces)
    assert model.derivatives(state, loads).u_dot - free == pytest.approx(np.append(forces, np.zeros(6)), abs=1e-9)
    with pytest.raises(ValueError):
        loads.add_modal([1.0])
    with pytest.raises(ValueError):
        loads.add_wrench(force=[1, 2, 3], frame="follower")


def test_follower_loads_are_in_the_axes_of_the_section(model):
    # At t = 0 the right arm runs along z: its local x is global z.
    follower = model.load_set(["P"], frame="follower")
    follower.add("P", force=[7.0, 0, 0])
    dead = model.load_set(["P"], frame="dead")
    dead.add("P", force=[0, 0, 7.0])
    state = romgen.State(model)
    one, other = (model.derivatives(state, loads).u_dot for loads in (follower, dead))
    assert one == pytest.approx(other, abs=1e-12 * np.abs(other).max())
    with pytest.raises(romgen.ModelError, match="right arm"):
        model.load_set(["right corner"], frame="follower")
    model.load_set(["right corner"], frame="follower", member="right arm")


def test_gravity_may_be_switched_on(model):
    simulation = romgen.Simulation(model, 0.01)
    assert not simulation.gravity.any() and not model.gravity.any()
    simulation.gravity = [0, 0, -9.81]
    for _ in range(100):
        simulation.step()
    # Newmark is exact for a parabola.
    assert simulation.rigid.v_G == pytest.approx([0, 0, -9.81], abs=1e-9)
    ledger = simulation.ledger
    assert ledger.E_kin + ledger.E_grav == pytest.approx(model.mass * 9.81 * model.centre_of_mass[2], rel=1e-9)
    with pytest.raises(romgen.SettingsError, match="gravity"):
        simulation.gravity = [0, 0, np.nan]


def test_the_loads_of_the_equilibrium_act_beside_those_of_a_host(structure):
    model = romgen.build(structure.with_name("hale.toml"), modes=4)
    states = []
    for loads in [None, model.equilibrium, model.load_set(["left tip"], case=model.equilibrium)]:
        simulation = romgen.Simulation(model, 0.02)
        for _ in range(100):
            simulation.step(loads)
        states.append(simulation.rigid)
        # Trimmed: what is left of the acceleration is round-off and what the equilibrium was solved to.
        assert np.abs(simulation.rigid.v_G).max() < 1e-6
    simulation = romgen.Simulation(model, 0.02)
    for _ in range(100):
        simulation.step(model.load_set(["left tip"]))
    # Weight alone: two seconds of free fall, whatever the wings do that are let go. They swing by metres, where a constant mass matrix
    # does not keep momentum to the last digit (docs/results.md).
    assert simulation.ledger.p_G[2] == pytest.approx(2 * model.gravity[2] * model.mass, rel=1e-3)


def test_derivatives_are_the_slope_of_a_short_step(model):
    case = model.load_case("lc2")
    start = romgen.State(model)
    start.q = 0.01 * np.arange(1, 7)
    start.q_dot = 0.02 * np.ones(6)
    start.beta_star = [0.1, 0.2, 0.3, 0.4, -0.3, 0.2]
    start.attitude = [2.0, 0.2, 0.0, -0.4]
    start.position = [1.0, 2.0, 3.0]
    start.time = 4.0
    assert np.linalg.norm(start.attitude) == pytest.approx(1.0, rel=1e-15)
    rate = model.derivatives(start, case)
    h = 1e-5
    simulation = romgen.Simulation(model, h, integrator="rk4")
    simulation.state = start
    simulation.step(case)
    end = simulation.state
    for name, slope in [
        ("q", rate.q_dot),
        ("position", rate.position_dot),
        ("attitude", rate.attitude_dot),
        ("beta_star", rate.u_dot[6:]),
        ("q_dot", rate.u_dot[:6]),
    ]:
        difference = (getattr(end, name) - getattr(start, name)) / h
        # First order in h; second derivatives are of the order of omega times the first.
        assert difference == pytest.approx(slope, abs=200 * h * max(1.0, np.abs(slope).max())), name
    assert end.time == pytest.approx(4.0 + h, rel=1e-15)


def test_snapshots_rewind_to_the_bit(model):
    case = model.load_case("lc1")
    simulation = romgen.Simulation(model, 0.01)
    simulation.run(case, steps=50)
    snapshots = [simulation.state, copy.copy(simulation.state), copy.deepcopy(simulation.state)]
    snapshots += [simulation.state.copy(), pickle.loads(pickle.dumps(simulation.state))]
    simulation.run(case, steps=50)
    end = simulation.state
    for snapshot in snapshots:
        simulation.state = snapshot
        simulation.run(case, steps=50)
        assert simulation.state == end


def test_a_host_that_moves_the_frame_gets_the_reaction(model):
    """Free flight, replayed as a prescribed motion: nothing is left for the host to do."""
    case = model.load_case("lc2")
    free = romgen.Simulation(model, 0.01)
    free.run(case, steps=200)
    held = romgen.Simulation(model, 0.01)
    held.state = free.state

    def motion(simulation):
        state = simulation.state
        # beta_dot = Phi_R q_ddot + beta*_dot, as velocity() puts beta together.
        rates = state.copy()
        rates.q_dot, rates.beta_star = state.u_dot[:6], state.u_dot[6:]
        return dict(
            velocity=model.velocity(state),
            rate=model.velocity(rates),
            attitude=state.attitude,
            position=state.position,
        )

    for _ in range(20):
        free.step(case)
        held.step_prescribed(case, **motion(free))
        reaction = held.reaction
        scale = np.abs(reaction.loads).max()
        # Free flight and prescribed motion integrate the rigid rows differently, to second order.
        assert reaction.total == pytest.approx(np.zeros(6), abs=1e-3 * scale)
        assert reaction.total == pytest.approx(reaction.inertia + reaction.loads + reaction.increment)
    assert held.state.q == pytest.approx(free.state.q, abs=1e-4 * np.abs(free.state.q).max())
    held.prescribe(case, **motion(free))
    held.step(case)
    assert held.reaction is None
    with pytest.raises(romgen.StepError, match="unit|length"):
        held.step_prescribed(case, **{**motion(free), "attitude": [2, 0, 0, 0]})


def test_load_cases_of_ones_own(model):
    text = """
    [parameters]
    push = 10
    [load_cases.push]
    t_end = 1
    dt = 0.01
    loads = [{ point = "A", frame = "dead", force = ["push", 0, 0] }]
    """
    (case,) = model.read_load_cases(text, parameters={"push": 20})
    assert (case.name, case.t_end, case.dt) == ("push", 1.0, 0.01)
    assert romgen.run(model, case)["p_G"][-1][0] == pytest.approx(20.0, rel=1e-2)
    table = {"t_end": 1, "dt": 0.01, "loads": [{"point": "A", "frame": "dead", "force": [20, 0, 0]}]}
    (same,) = model.read_load_cases({"load_cases": {"push": table}})
    assert np.array_equal(romgen.run(model, same)["p_G"], romgen.run(model, case)["p_G"])
    with pytest.raises(romgen.InputError, match="nowhere"):
        model.read_load_cases(text.replace('"A"', '"nowhere"'))


def test_simpler_methods_run_behind_the_same_calls(model):
    rigid, mean_axes = (
        romgen.run(model.with_method(method), "lc2", t_end=2.0) for method in ("rigid", "mean-axes")
    )
    assert "q" not in rigid and mean_axes["q"].shape == (201, 6)
    assert np.all(rigid["P.dR_A"] == 0.0)
    full = romgen.run(model, "lc2", t_end=2.0)
    # Small deformations so far: all three turn alike.
    assert mean_axes["w_G"][-1] == pytest.approx(full["w_G"][-1], abs=0.05 * np.abs(full["w_G"]).max())


def test_what_cannot_be_is_refused(model):
    simulation = romgen.Simulation(model, 0.01)
    with pytest.raises(romgen.SettingsError, match="too long for the explicit RK4"):
        romgen.Simulation(model, 10.0, integrator="rk4")
    with pytest.raises(ValueError, match="newmark, rk4, gen-alpha"):
        romgen.Simulation(model, 0.01, integrator="euler")
    with pytest.raises(ValueError, match=r"shape \[1, 5\], expected \(1, 6\)"):
        model.load_set(["P"]).set(np.zeros((1, 5)))
    with pytest.raises(ValueError, match="finite"):
        model.load_set(["P"]).set([[np.nan, 0, 0, 0, 0, 0]])
    with pytest.raises(ValueError, match="only for: P"):
        model.load_set(["P"]).add("Q", force=[1, 0, 0])
    with pytest.raises(romgen.ModelError, match="each point once"):
        model.load_set(["P", "P"])
    with pytest.raises(TypeError, match="LoadCase"):
        simulation.step(np.zeros(6))
    with pytest.raises(ValueError, match="either steps or t_end"):
        simulation.run(None)
    with pytest.raises(romgen.SettingsError, match="length of q"):
        simulation.state = romgen.State(model.with_method("rigid"))
    state = romgen.State(model)
    with pytest.raises(ValueError, match="expected"):
        state.q = np.zeros(5)
    with pytest.raises(ValueError, match="no rotation"):
        state.attitude = np.zeros(4)


def test_a_run_that_fails_hands_over_what_it_has(model):
    loads = model.load_set(["P"])
    simulation = romgen.Simulation(model, 0.05, max_iterations=3)
    wrenches = np.zeros((20, 1, 6))
    wrenches[10:, 0, 1] = 1e12
    with pytest.raises(romgen.StepError, match="step to t = 0.5") as caught:
        simulation.run_wrenches(loads, wrenches)
    assert caught.value.results["t"][-1] == pytest.approx(0.5)
    assert np.all(np.isfinite(caught.value.results["q"]))


def test_runs_release_the_interpreter_lock(model):
    """While a thread runs, this one counts; with the lock held it could not until the run ends."""
    simulation = romgen.Simulation(model, 1e-4)
    case = model.load_case("lc2")
    done = threading.Event()

    def work():
        simulation.run(case, steps=50_000, every=50_000)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    count = 0
    while not done.wait(0.001):
        count += 1
    thread.join()
    assert count > 5


def test_results_can_be_saved_and_read(model, tmp_path):
    results = romgen.run(model, "lc2", t_end=0.2)
    path = tmp_path / "results.npz"
    results.save(path)
    again = romgen.Results.read(path)
    assert list(again) == list(results)
    assert all(np.array_equal(again[name], results[name]) for name in results)
    assert (again.units, again.components, again.metadata) == (results.units, results.components, results.metadata)


def test_forces_on_stations_are_those_on_points(structure):
    text = structure.read_text() + """
[stations.top]
members = ["right arm"]
fractions = [0, 1]

[stations.beam]
members = ["right half beam"]
count = 4
offset = [0, 0.1, 0]
"""
    model = romgen.build(text, modes=6, parameters={"elements": 30})
    assert model.stations == ["top", "beam"]
    stations = romgen.Stations(model, "top")
    assert stations.name == "top" and len(stations) == 2 and stations.members == [("right arm", 2)]
    assert np.array_equal(stations.fraction, [0, 1]) and np.array_equal(stations.offset, np.zeros((2, 3)))
    on_points, on_stations = model.load_set(["P"], "dead"), model.load_set([], stations=["top", "beam"])
    wrenches = np.array([[0.0] * 6, [3.0, -2.0, 1.0, 0.1, 0.2, 0.3]])
    on_points.set(wrenches[1:])
    on_stations.set_stations("top", wrenches, "dead")
    ends = []
    for loads in (on_points, on_stations):
        simulation = romgen.Simulation(model, 0.01)
        for _ in range(30):
            simulation.step(loads)
        ends.append(simulation.state.q)
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-12) and np.abs(ends[0]).max() > 1e-3
    motion, state = stations.read(simulation), simulation.state
    assert motion.velocity[1] == pytest.approx(simulation.point_motion("P", on_stations).v_G, abs=1e-12)
    body, section = stations.read(state, "body"), stations.read(state, axes="section")
    assert motion.attitude.shape == (2, 4) and motion.angular_velocity.shape == (2, 3)
    assert np.linalg.norm(body.velocity, axis=1) == pytest.approx(np.linalg.norm(section.velocity, axis=1))
    with pytest.raises(romgen.ModelError, match="top, beam"):
        romgen.Stations(model, "wing")
    with pytest.raises(ValueError, match="expected \\(2, 6\\)"):
        on_stations.set_stations("top", np.zeros((3, 6)))
    with pytest.raises(ValueError, match="only for: top, beam"):
        on_stations.set_stations("wing", wrenches)
    with pytest.raises(ValueError, match="axes"):
        stations.read(state, "wind")


def test_internal_loads_are_recorded_and_read(structure):
    text = structure.read_text() + """
[internal_loads.root]
member = "right arm"
fractions = [0]
"""
    model = romgen.build(text, modes=6, parameters={"elements": 30})
    results = romgen.run(model, "lc2", t_end=0.5)
    case = model.load_case("lc2")
    simulation = romgen.Simulation(model, case.dt, numerical_damping=case.numerical_damping)
    own = simulation.run(case, t_end=0.5)
    assert np.array_equal(results["root.M"], own["root.M"]) and results.units["root.M"] == "N m"
    found = simulation.internal_loads(case)
    assert list(found) == ["root"]
    assert np.array_equal(found["root"], np.r_[own["root.F"][-1], own["root.M"][-1]])
    assert np.abs(found["root"]).max() > 1 and not np.array_equal(own["root.M"], own["root.M_modes"])
