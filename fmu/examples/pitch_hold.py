"""A pitch hold around the glider, rigid and flexible, as FMUs: how elasticity takes gain from a flight-control loop.

A controller at 100 Hz reads the pitch rate q of the gyro in the nose, integrates it to the pitch angle, and pulls at the tail:

    F = K (theta + T q)        force on the tail, up (nose down for a nose that is up), held for 10 ms

To the rigid glider any gain up to the limit of the sampling will do. The flexible one bends, the gyro reads the slope of the
bent nose, and at a fraction of that gain the loop drives a mode.

    python pitch_hold.py ROMGEN [OUT.png]

builds the glider with this romgen, sweeps the gain on both models behind the same calls, finds where either begins to grow, and checks
that against the eigenvalues of the sampled linear loop, made from the arrays of `romgen export --npz`.
"""

import pathlib
import subprocess
import sys
import tempfile

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave

GLIDER = pathlib.Path(__file__).resolve().parents[2] / "python" / "examples" / "glider.toml"
PERIOD = 0.01  # of the controller, s
LEAD = 0.8  # T, s
UNSTABLE = 0.5  # growth from which a loop counts as unstable, 1/s: it doubles in 1.4 s. Less is not told from decay in a short run
FLEXIBLE, RIGID = 1, 3  # values of the parameter `method`
RK4 = 2  # value of the parameter `integrator`


class Glider:
    """The FMU in the hands of a controller."""

    def __init__(self, fmu, folder):
        self.description = fmpy.read_model_description(fmu)
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.slave = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=fmpy.extract(str(fmu), str(folder)),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="glider",
        )
        self.slave.instantiate()

    def fly(self, method, gain, t_end, kick=0.01):
        """Pitch rate read at every sample, from a pitch rate of `kick` (rad/s) about the reference point on."""
        slave, at = self.slave, self.reference
        slave.reset()
        # RK4 holds the inputs over its steps, as the actuator does; Newmark would blend them into the first one.
        slave.setInt64([at["method"], at["integrator"]], [method, RK4])
        slave.setFloat64([at["dt"], at["initial_w_A.y"]], [PERIOD / 10, kick])
        slave.enterInitializationMode(startTime=0.0)
        slave.exitInitializationMode()
        rates, theta = [], 0.0
        for sample in range(round(t_end / PERIOD)):
            # Axes of the drawing: x aft, y right, z up. Nose up is about +y.
            (rate,) = slave.getFloat64([at["imu.w_S.y"]])
            rates.append(rate)
            theta += PERIOD * rate
            if abs(rate) > 1:
                break
            slave.setFloat64([at["tail.body.force.z"]], [gain * (theta + LEAD * rate)])
            slave.doStep(sample * PERIOD, PERIOD)
        return np.array(rates)

    def growth(self, method, gain):
        """Rate at which what is left after the start grows, 1/s: from its envelope."""
        rates = np.abs(self.fly(method, gain, 10.0, kick=1e-6))
        thirds = np.array_split(rates[len(rates) // 4 :], 3)
        return np.log(thirds[-1].max() / thirds[0].max()) / (2 * PERIOD * len(thirds[0]))


def linear_loop(arrays, flexible):
    """Gain -> largest growth of the loop from sample to sample, from the arrays of a model (theory, linear at rest)."""
    omega, ratio = arrays["modes.omega"], arrays["modes.damping_ratio"]
    shape_tail, turn_nose = arrays["points.tail.phi_translation"], arrays["points.nose.phi_rotation"]
    phi_r, mass = arrays["modes.phi_r"], arrays["rigid.mass_matrix"]
    if not flexible:
        omega, ratio, shape_tail, turn_nose, phi_r = omega[:0], ratio[:0], shape_tail[:, :0], turn_nose[:, :0], phi_r[:, :0]
    m = len(omega)
    # A unit force up on the tail: resultant about the origin of A, and on every mode.
    tail = arrays["points.tail.node_position"]
    resultant = np.r_[0, 0, 1, np.cross(tail, [0, 0, 1])]
    modal = shape_tail[2] + phi_r.T @ resultant
    # x = (q, q_dot, w*_y): the other rigid velocities do not act back.
    n = 2 * m + 1
    a, b, c = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    a[:m, m : 2 * m] = np.eye(m)
    a[m : 2 * m, :m], a[m : 2 * m, m : 2 * m] = -np.diag(omega**2), -np.diag(2 * ratio * omega)
    b[m : 2 * m], b[-1] = modal, np.linalg.solve(mass, resultant)[4]
    c[m : 2 * m], c[-1] = phi_r[4] + turn_nose[1], 1.0
    # Exact over a sample with the force held.
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = a * PERIOD, b * PERIOD
    step = power = np.eye(n + 1)
    for k in range(1, 30):
        power = power @ (whole / 2**8) / k
        step = step + power
    for _ in range(8):
        step = step @ step
    phi, gamma = step[:n, :n], step[:n, n]

    def growth(gain):
        # With the integrated angle: theta' = theta + PERIOD c x, F = gain (theta' + LEAD c x).
        loop = np.zeros((n + 1, n + 1))
        loop[:n, :n] = phi + gain * (PERIOD + LEAD) * np.outer(gamma, c)
        loop[:n, n] = gain * gamma
        loop[n, :n], loop[n, n] = PERIOD * c, 1.0
        return np.log(np.abs(np.linalg.eigvals(loop)).max()) / PERIOD

    return growth


def limit(unstable, low, high):
    """The gain at which a loop that is stable at `low` and not at `high` changes, to 0.5 %."""
    assert not unstable(low) and unstable(high), "the limit is not where it is looked for"
    while high / low > 1.005:
        middle = np.sqrt(low * high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return np.sqrt(low * high)


def main(romgen, out=None):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        run = lambda *arguments: subprocess.run([romgen, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)  # noqa: E731
        run("build", GLIDER, "--set", "weightless=1", "-o", folder / "glider.rom")
        run("export", folder / "glider.rom", "--fmu", folder / "glider.fmu", "--fmi", "3", "--npz", folder / "glider.npz")
        glider, arrays = Glider(folder / "glider.fmu", folder / "fmu"), dict(np.load(folder / "glider.npz"))
        limits, loops = {}, {}
        for name, method in [("rigid", RIGID), ("flexible", FLEXIBLE)]:
            loops[name] = linear_loop(arrays, method == FLEXIBLE)
            predicted = limit(lambda gain: loops[name](gain) > UNSTABLE, 10.0, 1e6)
            found = limit(lambda gain: glider.growth(method, gain) > UNSTABLE, predicted / 1.5, predicted * 1.5)
            limits[name] = found
            print(f"{name:>8}: good up to K = {found:6.0f} N/rad, by the eigenvalues of the linear loop {predicted:6.0f} N/rad")
            # The search is good to 0.5 %; the envelope of a few swings to a few percent of the growth.
            assert abs(found / predicted - 1) < 0.05
        assert limits["flexible"] < 0.5 * limits["rigid"], "elasticity costs half of the gain and more"
        between = np.sqrt(limits["flexible"] * limits["rigid"])
        rigid, flexible = (glider.fly(method, between, 3.0) for method in (RIGID, FLEXIBLE))
        print(f"K = {between:.0f} N/rad: after {PERIOD * len(rigid):.1f} s the rigid glider turns at {abs(rigid[-1]):.0e} rad/s, "
              f"the flexible one at {abs(flexible[-20:]).max():.1g} rad/s after {PERIOD * len(flexible):.2f} s")
        assert abs(rigid[-1]) < 1e-3 and abs(flexible).max() > 0.1
        if out:
            plot(out, glider, loops, limits, between)
        glider.slave.terminate()
        glider.slave.freeInstance()


def plot(out, glider, loops, limits, between):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
    low, styles = 0.5 * limits["flexible"], {"rigid": "C3--", "flexible": "C0"}
    for ax, gain, title in zip(axes, [low, between], ["half of the flexible limit", "between the limits"]):
        for name, method in [("rigid", RIGID), ("flexible", FLEXIBLE)]:
            rates = glider.fly(method, gain, 2.0)
            ax.plot(PERIOD * np.arange(len(rates)), 1e3 * rates, styles[name], lw=1, label=name)
        ax.set(title=f"K = {gain:.0f} N/rad, {title}", xlabel="t (s)", ylabel="pitch rate read (mrad/s)", ylim=(-25, 25))
        ax.grid(alpha=0.3)
    gains = np.geomspace(0.1 * limits["flexible"], 1.3 * limits["rigid"], 120)
    for name, style in styles.items():
        axes[2].semilogx(gains, [loops[name](gain) for gain in gains], style, label=f"{name}: eigenvalues")
        axes[2].plot(limits[name], 0, "o", color=style[:2], label=f"{name}: limit simulated")
    axes[2].axhline(0, color="k", lw=0.5)
    axes[2].set(title="growth of the loop (1/s)", xlabel="K (N/rad)", ylim=(-2, 10))
    axes[2].grid(alpha=0.3)
    axes[0].legend(fontsize=8)
    axes[2].legend(fontsize=7)
    figure.savefig(out, dpi=110)
    print(f"wrote {out}")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(*sys.argv[1:3])
