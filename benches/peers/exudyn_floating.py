#!/usr/bin/env python3
"""What a step of a free-flying flexible body of ten modes costs in Exudyn: its floating-frame object of reduced order.

The body is a U of cubes of springs and point masses with the size of the frame of `models/fmb.toml` (a beam of 20 m, arms of 5 m), reduced
to its first ten free-free modes, set spinning at 0.5 rad/s and marched by generalised-alpha at 0.01 s (its explicit solvers do not take
the object). Processor time is taken. What is compared is the cost of a step of such an object, not a motion: the frame's sections have no
counterpart among masses.

    pip install exudyn numpy scipy
    python benches/peers/exudyn_floating.py
"""

import importlib.metadata
import itertools
import os
import sys
import time

import exudyn as exu
import numpy as np
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
from scipy.sparse import csr_matrix

MODES = 10
SIZE = 0.5  # m, of a cube


def cubes():
    """Corners of the cubes along the U, each once."""
    along = [(x, 0) for x in range(-20, 21)] + [(x, z) for x in (-20, 20) for z in range(1, 11)]
    corners = {(x + a, b, z + c) for x, z in along for a, b, c in itertools.product((0, 1), repeat=3)}
    return SIZE * np.array(sorted(corners), dtype=float)


def body():
    """Point masses of 405 kg in all, springs to all neighbours up to a cube's diagonal."""
    position = cubes()
    n = len(position)
    stiffness = np.zeros((3 * n, 3 * n))
    for i in range(n):
        for j in range(i):
            arm = position[j] - position[i]
            length = np.linalg.norm(arm)
            if length < 1.8 * SIZE:
                k = 2e5 * np.outer(arm, arm) / length**2
                for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    stiffness[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * k
    fem = FEMinterface()
    fem.nodes = {"Position": position}
    fem.massMatrix = csr_matrix(np.eye(3 * n) * 405 / n)
    fem.stiffnessMatrix = csr_matrix(stiffness)
    fem.ComputeEigenmodes(MODES, excludeRigidBodyModes=6, useSparseSolver=False)
    return fem


def seconds_per_step(fem):
    """The difference of a long and a short run: what a solver does before and after its steps falls out."""
    dt, times = 0.01, []
    for steps in (200, 2200):
        system = exu.SystemContainer()
        mbs = system.AddSystem()
        ObjectFFRFreducedOrderInterface(fem).AddObjectFFRFreducedOrder(
            mbs, initialVelocity=[1, 0, 0], initialAngularVelocity=[0.1, 0.5, 0.1]
        )
        mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = steps * dt
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.98
        best = 1e9
        for _ in range(3):
            start = time.process_time()
            mbs.SolveDynamic(settings, storeSolver=False)
            best = min(best, time.process_time() - start)
        times.append(best)
    return (times[1] - times[0]) / 2000


def main():
    # The solver speaks; only the figures are for whoever reads this.
    out = os.dup(1)
    os.dup2(2, 1)
    fem = body()
    ns = 1e9 * seconds_per_step(fem)
    sys.stdout.flush()
    os.dup2(out, 1)
    version = importlib.metadata.version("exudyn")
    print(f"{version}\tfloating-frame object of reduced order, {MODES} modes, no loads, generalised-alpha {ns:.0f}", flush=True)


if __name__ == "__main__":
    main()
