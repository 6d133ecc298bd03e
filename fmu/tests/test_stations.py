"""Blocks of stations through FMUs: the same as the Python package does with them."""

import re

import fmpy
import numpy as np
import pytest
import romgen
from conftest import ROOT, tool
from fmpy.validation import validate_fmu
from slave import Slave

DT, STEPS = 0.01, 20
FRAMES = ["dead", "body", "follower"]
OUTPUTS = {"R_G": "position", "zeta": "attitude", "v_G": "velocity", "w_G": "angular_velocity"}


@pytest.fixture(scope="module")
def hale(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stations")
    options = ["--set", "wing_elements=6", "--modes", "5"]
    tool("romgen", "build", ROOT / "models" / "hale.toml", *options, "-o", folder / "hale.rom")
    tool("romgen", "export", folder / "hale.rom", "--fmu", folder / "hale.fmu", "--stations", "all")
    tool("romgen", "export", folder / "hale.rom", "--fmu", folder / "tail.fmu", "--stations", "tailplane")
    return folder


@pytest.fixture(params=["3.0", "2.0"], scope="module")
def stations_fmu(request, hale, tmp_path_factory):
    path = hale / {"3.0": "hale.fmu", "2.0": "hale-fmi2.fmu"}[request.param]
    return path, fmpy.extract(str(path), str(tmp_path_factory.mktemp("unzipped")))


@pytest.fixture
def host(stations_fmu):
    return lambda: Slave(*stations_fmu)


def test_blocks_are_variables_where_they_are_asked_for(hale, stations_fmu):
    path, _ = stations_fmu
    tail = path.with_name(path.name.replace("hale", "tail"))
    # FMPy looks at every pair of variables: the smaller one.
    assert validate_fmu(str(tail)) == []
    description = fmpy.read_model_description(path)
    names = {v.name: v for v in description.modelVariables}
    if description.fmiVersion == "3.0":
        forces = names["wing.follower.force"]
        assert [d.start for d in forces.dimensions] == [32, 3] and forces.unit == "N" and forces.causality == "input"
        assert [d.start for d in names["tailplane.zeta"].dimensions] == [8, 4]
    else:
        assert names["wing.follower.force[3].x"].unit == "N" and "wing.zeta[32].z" in names
        assert names["wing.R_G[1].y"].valueReference == names["wing.R_G[1].x"].valueReference + 1
    # The same references whichever blocks are asked for.
    alone = {v.name: v.valueReference for v in fmpy.read_model_description(tail).modelVariables}
    assert alone == {name: v.valueReference for name, v in names.items() if not name.startswith("wing.")}


def test_the_program_of_the_page_runs(hale, monkeypatch, capsys):
    page = (ROOT / "docs" / "fmu.md").read_text().split("## Stations")[1]
    monkeypatch.chdir(hale)
    exec(re.search(r"```python\n(.*?)```", page, re.S)[1], {})
    assert capsys.readouterr().out == "(11, 32, 3)\n"


def test_a_host_records_and_sets_arrays(hale):
    forces = np.zeros((32, 3))
    forces[:, 2] = 1.0
    found = fmpy.simulate_fmu(
        str(hale / "hale.fmu"), stop_time=0.1, output_interval=0.05,
        start_values={"wing.follower.force": forces.ravel()}, output=["wing.R_G", "tailplane.w_G"],
    )
    assert found["wing.R_G"].shape == (3, 32, 3) and found["wing.R_G"][-1, 0, 2] > found["wing.R_G"][0, 0, 2] + 1e-4


@pytest.mark.parametrize("frame, method", [*((frame, "rom") for frame in FRAMES), ("follower", "mean-axes")])
def test_a_loop_through_the_stations_is_that_of_python(hale, host, frame, method):
    """Damping of every station by its own velocity, and a load of its own on every station."""
    model = romgen.Model.load(hale / "hale.rom")
    blocks = model.stations
    rng = np.random.default_rng(1)
    sizes = {name: len(romgen.Stations(model, name)) for name in blocks}
    own = {name: rng.standard_normal((n, 6)) for name, n in sizes.items()}

    def wrenches(name, velocity):
        return own[name] - 2.0 * np.hstack([velocity, np.zeros_like(velocity)])

    simple = model.with_method(method)
    (level,) = simple.read_load_cases({"load_cases": {"level": {"t_end": 1, "dt": DT, "loads": []}}})
    loads, simulation = simple.load_set([], case=level, stations=blocks), romgen.Simulation(simple, DT)
    readers = {name: romgen.Stations(simple, name) for name in blocks}
    fmu = host().start(dt=DT, method={"rom": 1, "mean-axes": 2}[method]).go()
    for step in range(STEPS):
        for name in blocks:
            loads.set_stations(name, wrenches(name, readers[name].read(simulation).velocity), frame)
            wrench = wrenches(name, fmu.get_array(f"{name}.v_G", sizes[name]))
            fmu.set_array(f"{name}.{frame}.force", wrench[:, :3])
            fmu.set_array(f"{name}.{frame}.moment", wrench[:, 3:])
        simulation.step(loads)
        fmu.step(step * DT, DT)
    for name in blocks:
        expected = readers[name].read(simulation)
        for output, field in OUTPUTS.items():
            found = fmu.get_array(f"{name}.{output}", sizes[name])
            assert np.abs(found - getattr(expected, field)).max() <= 1e-9, (name, output)
    # It is a motion, not a rest: the wing bends by millimetres.
    assert np.abs(fmu.get("'left tip'.dR_A.z")).max() > 1e-3


@pytest.mark.parametrize("frame", FRAMES)
def test_accelerations_are_linear_in_the_loads_of_stations(host, frame):
    """In every frame, besides loads in the others: one difference is exact."""
    fmu = host().start().go()
    rng = np.random.default_rng(3)
    for other in FRAMES:
        fmu.set_array(f"wing.{other}.force", rng.standard_normal((32, 3)))
    fmu.step(0.0, 0.1)
    rates = ["der(v_A.x)", "der(w_A.y)", "der(q_dot[1])", "der(q_dot[5])"]
    inputs = [f"wing.{frame}.force", f"wing.{frame}.moment"]
    before, seeds = fmu.get(*rates), rng.standard_normal((2, 32, 3))
    of, by = [fmu.names[n] for n in rates], [ref for name in inputs for ref in fmu.elements(name)]
    arguments = [] if fmu.old else [len(of)]
    found = np.array(fmu.call(fmu.fmu.getDirectionalDerivative, of, by, list(seeds.ravel()), *arguments))
    start = [fmu.call(fmu.fmu.getReal, by) if fmu.old else fmu.call(fmu.fmu.getFloat64, by, 2 * 96)]
    setter = fmu.fmu.setReal if fmu.old else fmu.fmu.setFloat64
    fmu.call(setter, by, list(np.ravel(start) + seeds.ravel()))
    added = fmu.get(*rates) - before
    assert np.abs(added).max() > 1e-2
    assert found == pytest.approx(added, rel=1e-8, abs=1e-10)


def test_along_the_rates_of_the_states_stations_move_as_in_time(host):
    """d y/d t = (d y/d x) x_dot: positions change by the velocities, all else by differences in time."""
    fmu = host().start(dt=1e-3, integrator=2)
    fmu.set_array("wing.follower.force", 20 * np.random.default_rng(5).standard_normal((32, 3)))
    fmu.go()
    fmu.step(0.0, 0.2)
    rates = [unknown.variable.name for unknown in fmu.description.derivatives]
    states = [next(v for v in fmu.description.modelVariables if v.name == rate).derivative.name for rate in rates]
    outputs = [f"wing.{name}" for name in OUTPUTS]
    of, by = [ref for name in outputs for ref in fmu.elements(name)], [fmu.names[n] for n in states]
    arguments = [] if fmu.old else [32 * 13]
    found = np.array(fmu.call(fmu.fmu.getDirectionalDerivative, of, by, list(fmu.get(*rates)), *arguments))
    velocity = fmu.get_array("wing.v_G", 32)
    assert found[:96] == pytest.approx(velocity.ravel(), rel=1e-9, abs=1e-12) and np.abs(velocity).max() > 0.1
    h, values = 1e-3, []
    for step in range(5):
        values.append(np.concatenate([fmu.get_array(name, 32).ravel() for name in outputs]))
        fmu.step(0.2 + step * h, h)
    # One-sided, fourth order: 160 rad/s is the fastest of the modes, (0.16)^4/5 of it beyond.
    difference = np.array([-25 / 12, 4, -3, 4 / 3, -1 / 4]) / h @ values
    for part in (slice(0, 96), slice(96, 224), slice(224, 320), slice(320, 416)):
        assert np.abs(found[part] - difference[part]).max() <= 1e-3 * np.abs(difference[part]).max()


def test_states_with_loads_on_stations_are_saved(host):
    fmu, other = host().start().go(), host()
    fmu.set_array("tailplane.body.force", np.full((8, 3), 0.5))
    fmu.step(0.0, 0.05)
    other.load(other.from_bytes(fmu.to_bytes(fmu.save())))
    ends = []
    for instance in (fmu, other):
        instance.step(0.05, 0.05)
        ends.append(instance.get_array("wing.R_G", 32))
    assert np.array_equal(*ends)


def test_wrong_numbers_of_values_are_refused(host):
    fmu = host().start()
    if not fmu.old:
        with pytest.raises(RuntimeError, match="95 values for 1 variables with 96 elements"):
            fmu.set_array("wing.body.force", np.zeros(95))
    with pytest.raises(RuntimeError, match="wing.v_G.* is an output"):
        fmu.set_array("wing.v_G", np.zeros((32, 3)))
