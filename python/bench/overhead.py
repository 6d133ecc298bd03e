"""What a step costs from Python, beside the same steps made by one call.

    python overhead.py

The difference of the two is the overhead of a call; figures of a debug build say nothing.
"""

import pathlib
import timeit

import numpy as np

import romgen

MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"
STEPS = 100_000


def best(work, number, repeat=5):
    """Nanoseconds per call."""
    return min(timeit.repeat(work, number=number, repeat=repeat)) / number * 1e9


def main():
    model = romgen.build(MODELS / "fmb.toml", modes=10)
    case = model.load_case("lc2")
    print(f"{'':22}{'one call, ns/step':>20}{'step by step, ns':>20}{'overhead, ns':>16}")
    for integrator in ["rk4", "newmark"]:
        simulation = romgen.Simulation(model, 1e-3, integrator=integrator)
        start = simulation.state

        def many():
            simulation.state = start
            simulation.run(case, steps=STEPS, every=STEPS, points=[])

        def single(simulation=simulation):
            simulation.step(case)

        bulk = best(many, 1) / STEPS
        simulation.state = start
        call = best(single, STEPS)
        print(f"{integrator + ', 10 modes':22}{bulk:20.0f}{call:20.0f}{call - bulk:16.0f}")

    loads = model.load_set(["P", "Q"])
    wrenches = np.ones((2, 6))
    print(f"LoadSet.set of (2, 6): {best(lambda: loads.set(wrenches), 20_000):.0f} ns")
    print(f"Simulation.point:      {best(lambda: simulation.point('P').dR_A, 20_000):.0f} ns")


if __name__ == "__main__":
    main()
