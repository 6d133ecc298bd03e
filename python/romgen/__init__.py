"""Reduced-order models of flexible bodies that fly: build them, march them, put them into a loop.

    import romgen

    model = romgen.build("models/fmb.toml", modes=10)          # or romgen.Model.load("fmb.rom")
    results = romgen.run(model, "lc2")                         # what romrun records, as NumPy arrays
    results["P.dR_A"]                                          # displacement of point P in A, m - (rows, 3)

Frames: G inertial, A on the reference node of the body. SI units, angles in radians. A wrench is (force, moment).
"""

from __future__ import annotations

from typing import Literal

from ._core import (
    BuildError,
    Error,
    InputError,
    Jacobian,
    Ledger,
    LoadCase,
    LoadSet,
    Model,
    ModelError,
    PointMotion,
    PointOutput,
    Reaction,
    RigidOutput,
    SensorReading,
    SettingsError,
    Simulation,
    State,
    StateRate,
    StateSpace,
    StationMotion,
    Stations,
    StepError,
    __version__,
    build,
    linearise,
    schema,
)
from ._results import Results

__all__ = [
    "BuildError",
    "Error",
    "InputError",
    "Jacobian",
    "Ledger",
    "LoadCase",
    "LoadSet",
    "Model",
    "ModelError",
    "PointMotion",
    "PointOutput",
    "Reaction",
    "Results",
    "RigidOutput",
    "SensorReading",
    "SettingsError",
    "Simulation",
    "State",
    "StateRate",
    "StateSpace",
    "StationMotion",
    "Stations",
    "StepError",
    "__version__",
    "build",
    "linearise",
    "run",
    "schema",
]


def run(
    model: Model,
    load_case: str | LoadCase,
    *,
    dt: float | None = None,
    t_end: float | None = None,
    integrator: Literal["newmark", "gen-alpha", "rk4", "energy-momentum"] = "newmark",
    numerical_damping: float | None = None,
    every: int = 1,
    points: list[str] | None = None,
) -> Results:
    """Runs a load case from where it starts, as ``romrun MODEL --loads NAME`` does.

    Args:
        model: the model; ``model.with_method("rigid")`` for a simpler method.
        load_case: name of one of the model's, or one from :meth:`Model.read_load_cases`.
        dt: time step, s; default: the load case's.
        t_end: end of the run, s; default: the load case's.
        integrator: ``"newmark"``, ``"gen-alpha"``, ``"rk4"`` or ``"energy-momentum"``.
        numerical_damping: of the implicit integrators; default: the load case's.
        every: record every so many steps, and the last.
        points: named points to record; default: all.

    Raises:
        StepError: when the numbers fail; its attribute ``results`` holds what was recorded until then.
    """
    case = model.load_case(load_case) if isinstance(load_case, str) else load_case
    if numerical_damping is None:
        # That of the load case is meant for the integrators that have one to adjust.
        numerical_damping = case.numerical_damping if integrator in ("newmark", "gen-alpha") else 0.0
    simulation = Simulation(
        model,
        case.dt if dt is None else dt,
        integrator=integrator,
        numerical_damping=numerical_damping,
    )
    simulation.state = case.initial_state
    return simulation.run(case, t_end=case.t_end if t_end is None else t_end, every=every, points=points)
