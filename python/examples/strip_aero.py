"""Strip theory on the stations of a trimmed aircraft in a gust: an aerodynamic code in a loop with the reduced model.

Quasi-steady two-dimensional lift of every strip, from the velocity of the air at the strip itself: the wing that bends, twists, pitches
and heaves changes its own incidence. What this adds to the lift of level flight acts on the model, which is in balance there.

    python strip_aero.py [picture.png]
"""

import pathlib
import sys

import numpy as np

import romgen

MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"
SPEED, DENSITY, SLOPE = 25.0, 0.0889, 2 * np.pi  # m/s, kg/m^3 at 20 km, 1/rad
CHORD = {"wing": 1.0, "tailplane": 0.5}  # m
SPAN = {"wing": 32.0, "tailplane": 5.0}  # m
GUST, LENGTH = 1.0, 50.0  # m/s upwards, m from end to end


def gust(position):
    """Velocity of the air in G, m/s - (n, 3): a 1 - cosine that the aircraft flies into, 10 m ahead of it."""
    along = np.clip((position[:, 0] - 10.0) / LENGTH, 0.0, 1.0)
    air = np.zeros_like(position)
    air[:, 2] = 0.5 * GUST * (1 - np.cos(2 * np.pi * along))
    return air


def into_sections(attitude, vectors):
    """Components in the axes that unit quaternions turn into G - (n, 3)."""
    w, v = attitude[:, :1], -attitude[:, 1:]
    return vectors + 2 * np.cross(v, np.cross(v, vectors) + w * vectors)


class Strips:
    """A block of stations at the quarter chord. Section axes: x along the span, y to the rear, z up."""

    def __init__(self, model, name):
        self.name, self.stations = name, romgen.Stations(model, name)
        self.area = CHORD[name] * SPAN[name] / len(self.stations)
        # Level flight: its lift is among the loads of the equilibrium.
        self.level = np.zeros(len(self.stations))
        self.level = self.lift(level_flight(model), np.zeros((1, 3)))

    def lift(self, of, air):
        """Lift of every strip by its incidence and speed against the air, less that of level flight, N - (n)."""
        motion = self.stations.read(of)
        flow = into_sections(motion.attitude, (gust(motion.position) if air is None else air) - motion.velocity)
        angle, speed = np.arctan2(flow[:, 2], flow[:, 1]), np.hypot(flow[:, 1], flow[:, 2])
        return 0.5 * DENSITY * speed**2 * self.area * SLOPE * angle - self.level

    def wrenches(self, of, with_gust):
        """Force and moment on every strip beyond level flight, section axes, N and N m - (n, 6)."""
        loads = np.zeros((len(self.stations), 6))
        loads[:, 2] = self.lift(of, None if with_gust else np.zeros((1, 3)))
        return loads


def level_flight(model, after=0.0):
    """The state of the aircraft that flies on undisturbed."""
    state = romgen.State(model)
    state.beta_star = [SPEED, 0, 0, 0, 0, 0]
    state.position = state.position + [SPEED * after, 0, 0]
    return state


def fly(model, blocks, with_gust, responding, dt=0.01, t_end=8.0):
    """Time, displacement of the left tip upwards, climb of A and its pitch rate."""
    # The loads of the equilibrium act as well: those of a load case without any of its own.
    (level,) = model.read_load_cases({"load_cases": {"level": {"t_end": t_end, "dt": dt, "loads": []}}})
    loads = model.load_set([], case=level, stations=blocks)
    strips = [Strips(model, name) for name in blocks]
    simulation = romgen.Simulation(model, dt)
    simulation.state = level_flight(model)
    rows = []
    for step in range(round(t_end / dt)):
        # Without response the air meets the wing as if it flew on undisturbed.
        of = simulation if responding else level_flight(model, step * dt)
        for strip in strips:
            loads.set_stations(strip.name, strip.wrenches(of, with_gust))
        simulation.step(loads)
        rigid = simulation.rigid
        rows.append([simulation.time, simulation.point("left tip").dR_A[2], rigid.v_G[2], rigid.w_A[1]])
    return np.array(rows).T


def main():
    picture = sys.argv[1] if len(sys.argv) > 1 else "strip_aero.png"
    model = romgen.build(MODELS / "hale.toml", modes=12)
    blocks = ["wing", "tailplane"]

    still = fly(model, blocks, with_gust=False, responding=True, t_end=1.0)
    print(f"level flight without gust: the tip moves by {np.abs(still[1]).max():.2e} m")
    assert np.abs(still[1]).max() < 1e-6, "level flight stays what it is"

    frozen = fly(model, blocks, with_gust=True, responding=False)
    flown = fly(model, blocks, with_gust=True, responding=True)
    for name, rows in [("gust alone", frozen), ("strips in their own motion", flown)]:
        print(f"{name}: tip up to {np.abs(rows[1]).max():.3f} m, climb up to {np.abs(rows[2]).max():.3f} m/s")
    # What the wing bends by in the end, once the gust is over: damped by the air.
    late = flown[0] > 6.0
    swing = [np.ptp(rows[1][late]) for rows in (frozen, flown)]
    print(f"swing of the tip after 6 s: {swing[0]:.3f} m and {swing[1]:.3f} m")
    assert swing[1] < 0.2 * swing[0], "the air damps the bending of the wing"

    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
    for rows, label in [(frozen, "gust alone"), (flown, "strips in their own motion")]:
        axes[0].plot(rows[0], rows[1], label=label)
        axes[1].plot(rows[0], rows[2], label=label)
    axes[0].set_ylabel("tip, upwards in A, m")
    axes[1].set_ylabel("climb of A, m/s")
    axes[1].set_xlabel("time, s")
    axes[0].legend()
    for axis in axes:
        axis.grid(alpha=0.3)
    figure.savefig(picture, dpi=120)
    print(picture)


main()
