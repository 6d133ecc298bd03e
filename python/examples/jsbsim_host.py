"""JSBSim flies the rigid glider, this package bends it: the coupling of a flexible body to a flight-dynamics code.

JSBSim carries mass and inertia of the undeformed glider. Every step it receives, as external reactions, the wrench of the loads
on the deformed body and of what elasticity adds (`reaction.loads + reaction.increment`), and hands back how it moves; the
modes are marched under that prescribed motion.

The increment holds a part that is proportional to the acceleration, `K rate`: the inertia that the modes take along at once. A
light fuselage between wings has shares of it near one, and one step late such a part shakes the modes to pieces at
any practical step. So the acceleration to come is solved for, from the total wrench extrapolated by
a step (`Exchange`). What is exchanged is second order in the step then.

    python jsbsim_host.py [OUT.png]

flies a manoeuvre in steps that are halved, sets it beside the free flight of this package alone, and checks that the
difference goes with the square of the step, and that momentum changes by what acts.

| quantity | here: frame A, SI | JSBSim: body axes, US units |
|---|---|---|
| axes | x aft, y right, z up (JSBSim's structural axes) | x forward, y right, z down: D = diag(-1, 1, -1) |
| inertial axes | G: south, east, up | local frame: north, east, down, of a planet that is large and does not turn |
| reference point of velocities, moments | origin of A | centre of gravity, r from the origin of A |
| force | N | lbf = 4.4482216152605 N: F_b = D F / 4.448.. |
| moment | N m | lbf ft = 1.3558179483314 N m: M_b = D (M - r x F) / 1.355.. |
| velocity | m/s | ft/s = 0.3048 m/s: v = 0.3048 D (u, v, w) - w x r |
| its rate, components in the axes that turn | m/s^2 | ft/s^2: v_dot = 0.3048 D (udot, vdot, wdot) - w_dot x r |
| angular velocity and its rate | rad/s | rad/s: w = D (p, q, r) |
| mass, inertia about the centre of gravity | kg, kg m^2 | kg in the file; slug ft^2 = 1.3558179483314 kg m^2: D I D / 1.355.. |
| attitude | quaternion A to G, scalar first | roll, pitch, yaw: (w, x, y, z) of body to local, then (w, -x, y, -z) |
| weight | among the loads of the model: taken off, for it is | applied by JSBSim itself |
"""

import pathlib
import sys
import tempfile

import jsbsim
import numpy as np

import romgen

HERE = pathlib.Path(__file__).resolve().parent
FOOT, POUND = 0.3048, 4.4482216152605
D = np.array([-1.0, 1.0, -1.0])
G = 9.80665
SPEED = 20.0
T_END = 4.0

AIRCRAFT = """<?xml version="1.0"?>
<fdm_config name="glider" version="2.0" release="ALPHA">
  <metrics>
    <wingarea unit="M2">18</wingarea> <wingspan unit="M">18</wingspan> <chord unit="M">1</chord>
    <location name="AERORP" unit="M"> <x>0</x> <y>0</y> <z>0</z> </location>
    <location name="VRP" unit="M"> <x>0</x> <y>0</y> <z>0</z> </location>
  </metrics>
  <mass_balance negated_crossproduct_inertia="true">
    <ixx unit="SLUG*FT2">{ixx}</ixx> <iyy unit="SLUG*FT2">{iyy}</iyy> <izz unit="SLUG*FT2">{izz}</izz>
    <ixy unit="SLUG*FT2">{ixy}</ixy> <ixz unit="SLUG*FT2">{ixz}</ixz> <iyz unit="SLUG*FT2">{iyz}</iyz>
    <emptywt unit="KG">{mass}</emptywt>
    <location name="CG" unit="M"> <x>{x}</x> <y>{y}</y> <z>{z}</z> </location>
  </mass_balance>
  <ground_reactions/> <propulsion/> <flight_control name="none"/> <aerodynamics/>
  <external_reactions>
    <force name="body" frame="BODY">
      <location unit="M"> <x>{x}</x> <y>{y}</y> <z>{z}</z> </location>
      <direction> <x>1</x> <y>0</y> <z>0</z> </direction>
    </force>
    <moment name="turn" frame="BODY"> <direction> <x>1</x> <y>0</y> <z>0</z> </direction> </moment>
  </external_reactions>
</fdm_config>
"""
# So large that it is flat and its gravity uniform; it does not turn.
PLANET = """<?xml version="1.0"?>
<planet name="flat">
  <semimajor_axis unit="M">1e9</semimajor_axis> <semiminor_axis unit="M">1e9</semiminor_axis>
  <rotation_rate unit="RAD/SEC">0</rotation_rate> <GM unit="M3/SEC2">{gm}</GM> <J2>0</J2>
</planet>
"""


class Host:
    """JSBSim with the rigid body of a model."""

    def __init__(self, model, dt, speed):
        mass, r = model.mass, model.centre_of_mass
        # About the centre of mass, in body axes: Ixz keeps its sign, Ixy and Iyz change it. With "negated" products the
        # file has the entries of the matrix; in slug ft^2, for JSBSim's own conversion of kg m^2 is good to four digits.
        inertia = model.mass_matrix[3:, 3:] - mass * (r @ r * np.eye(3) - np.outer(r, r))
        inertia = D[:, None] * inertia * D
        numbers = dict(mass=mass, x=r[0], y=r[1], z=r[2])
        for i, j in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]:
            numbers["i" + "xyz"[i] + "xyz"[j]] = repr(float(inertia[i, j] / (POUND * FOOT)))
        self.r = r
        self.folder = tempfile.TemporaryDirectory()
        root = pathlib.Path(self.folder.name)
        (root / "aircraft" / "glider").mkdir(parents=True)
        (root / "aircraft" / "glider" / "glider.xml").write_text(AIRCRAFT.format(**numbers))
        (root / "planet.xml").write_text(PLANET.format(gm=repr(G * 1e18)))
        self.fdm = jsbsim.FGFDMExec(str(root))
        self.fdm.set_debug_level(0)
        assert self.fdm.load_planet(str(root / "planet.xml"), False)
        assert self.fdm.load_model("glider")
        self.fdm.set_dt(dt)
        for what in ("rate", "position"):
            for kind in ("rotational", "translational"):
                # Adams-Bashforth of second order throughout; by default the rotation is integrated to first order.
                self.fdm[f"simulation/integrator/{what}/{kind}"] = 3
        self.fdm["ic/h-sl-ft"] = 3000.0
        self.fdm["ic/u-fps"] = speed / FOOT
        assert self.fdm.run_ic()
        self.start = self.centre()
        assert np.allclose(self.inertia(), inertia, rtol=1e-7, atol=1e-9 * inertia.max())

    def inertia(self):
        return self.fdm.get_mass_balance().get_J() * POUND * FOOT

    def vector(self, *names):
        return np.array([self.fdm[name] for name in names])

    def motion(self):
        """How frame A moves, as `step_prescribed` wants it."""
        w = D * self.vector("velocities/pi-rad_sec", "velocities/qi-rad_sec", "velocities/ri-rad_sec")
        w_dot = D * self.vector(*(f"accelerations/{x}dot-rad_sec2" for x in "pqr"))
        v = FOOT * D * self.vector(*(f"velocities/{x}-fps" for x in "uvw")) - np.cross(w, self.r)
        v_dot = FOOT * D * self.vector(*(f"accelerations/{x}dot-ft_sec2" for x in "uvw")) - np.cross(w_dot, self.r)
        angles = self.vector("attitude/phi-rad", "attitude/theta-rad", "attitude/psi-rad") / 2
        (cr, cp, cy), (sr, sp, sy) = np.cos(angles), np.sin(angles)
        zeta = np.array([
            cr * cp * cy + sr * sp * sy,
            -(sr * cp * cy - cr * sp * sy),
            cr * sp * cy + sr * cp * sy,
            -(cr * cp * sy - sr * sp * cy),
        ])
        position = self.centre() - self.start - turn(zeta, self.r)
        return dict(velocity=[*v, *w], rate=[*v_dot, *w_dot], attitude=zeta, position=position)

    def centre(self):
        """The centre of gravity in G, but for a constant."""
        return FOOT * self.vector(*(f"position/from-start-neu-{x}-ft" for x in "neu")) * [-1, 1, 1]

    def step(self, wrench):
        """One step under a wrench (force, moment) about the origin of A, components in A."""
        force, moment = np.array(wrench[:3]), np.array(wrench[3:])
        force, moment = D * force / POUND, D * (moment - np.cross(self.r, force)) / (POUND * FOOT)
        self.fdm["external_reactions/body/magnitude"] = 1.0
        self.fdm["external_reactions/turn/magnitude-lbsft"] = 1.0
        for name, value in zip(["body/x", "body/y", "body/z", "turn/l", "turn/m", "turn/n"], [*force, *moment]):
            self.fdm[f"external_reactions/{name}"] = value
        assert self.fdm.run()


def turn(zeta, vector):
    """Components in A of quaternion zeta to components in G."""
    w, x = zeta[0], np.asarray(zeta[1:])
    vector = np.asarray(vector)
    return vector + 2 * np.cross(x, np.cross(x, vector) + w * vector)


def back(zeta, vector):
    return turn([zeta[0], *(-np.asarray(zeta[1:]))], vector)


def wrenches(t):
    """Forces and moments on tail, left tip, right tip in A: a pull-up and a roll, both smooth."""
    pulse = lambda start, duration: np.sin(np.pi * np.clip((t - start) / duration, 0, 1)) ** 2  # noqa: E731
    lift = 0.1 * 228.81 * G * (1 - np.exp(-2 * t))
    roll = 15 * pulse(0.5, 1.0) - 15 * pulse(1.5, 1.0)
    return [
        [0, 0, -30 * pulse(0.2, 0.8), 0, 0, 0],
        [0, 0, lift / 2 - roll, 0, 0, 0],
        [0, 0, lift / 2 + roll, 0, 0, 0],
    ]


POINTS = ["tail", "left tip", "right tip"]


def start(model, dt, speed=SPEED):
    simulation = romgen.Simulation(model, dt)
    state = simulation.state
    # Forward is -x of A. The origin of G is where the centre of mass begins, as in the host.
    state.beta_star = [-speed, 0, 0, 0, 0, 0]
    state.position = -model.centre_of_mass
    simulation.state = state
    return simulation, model.load_set(POINTS, frame="body")


def free_flight(model, dt):
    """All in one model: what the coupling has to come to."""
    simulation, loads = start(model, dt)
    rows = [record(simulation)]
    for step in range(1, round(T_END / dt) + 1):
        loads.set(wrenches(step * dt))
        simulation.step(loads)
        rows.append(record(simulation))
    return np.array(rows)


def taken_along(model):
    """K: what the increment at rest gains with each component of the rate of A - (6, 6)."""
    simulation, still = romgen.Simulation(model, 0.01), dict(velocity=[0] * 6, attitude=[1, 0, 0, 0], position=[0] * 3)

    def increment(rate):
        simulation.prescribe(None, rate=rate, **still)
        return simulation.reaction.increment

    none = increment([0] * 6)
    return np.array([increment(unit) - none for unit in np.eye(6)]).T


class Exchange:
    """The wrench on the host for its next step, from what both sides said at the end of the last one."""

    def __init__(self, model):
        self.mass = model.mass_matrix
        self.taken_along = taken_along(model)
        self.wrench, self.before = np.zeros(6), None

    def next(self, wrench_of_body, rate):
        """`wrench_of_body` on the host at a rate of A at which the host was under `self.wrench`."""
        # Of the body, and of all else that acts on the host, if A were not accelerated.
        body = wrench_of_body - self.taken_along @ rate
        other = self.mass @ rate - self.wrench
        now = np.array([body, other])
        body, other = 2 * now - (now if self.before is None else self.before)
        self.before = now
        to_come = np.linalg.solve(self.mass - self.taken_along, body + other)
        self.wrench = body + self.taken_along @ to_come
        return self.wrench


def coupled_flight(model, dt, elastic=True):
    """JSBSim and the modes, one step after the other. Also the impulse of all that acts, in G."""
    host, exchange = Host(model, dt, SPEED), Exchange(model)
    simulation, loads = start(model, dt)
    loads.set(wrenches(0.0))
    motion = host.motion()
    simulation.prescribe(loads, **motion)
    rows, impulse = [record(simulation)], [np.zeros(3)]
    for step in range(1, round(T_END / dt) + 1):
        reaction = simulation.reaction
        # JSBSim has its own weight; that of the undeformed body is among the loads here.
        weight = back(motion["attitude"], [0, 0, -G * model.mass])
        wrench = reaction.loads - np.array([*weight, *np.cross(model.centre_of_mass, weight)])
        host.step(exchange.next(wrench + reaction.increment, motion["rate"]) if elastic else wrench)
        force = turn(motion["attitude"], reaction.loads[:3])
        loads.set(wrenches(step * dt))
        motion = host.motion()
        simulation.step_prescribed(loads, **motion)
        force = (force + turn(motion["attitude"], simulation.reaction.loads[:3])) / 2
        rows.append(record(simulation))
        impulse.append(impulse[-1] + dt * force)
    return np.array(rows), np.array(impulse)


def record(simulation):
    rigid, tip = simulation.rigid, simulation.point("right tip")
    return np.concatenate([[simulation.time], rigid.r_G, rigid.v_G, rigid.w_G, tip.dR_A, simulation.ledger.p_G])


def difference(rows, reference):
    """Largest difference of path, velocity, rate, tip displacement and momentum, as shares of the largest values."""
    every = (len(reference) - 1) // (len(rows) - 1)
    return [
        np.abs(rows[:, c] - reference[::every, c]).max() / np.abs(reference[:, c]).max()
        for c in (slice(1, 4), slice(4, 7), slice(7, 10), slice(10, 13), slice(13, 16))
    ]


def main(out=None):
    model = romgen.build(HERE / "glider.toml", modes=10)
    reference = free_flight(model, 0.0005)
    print("largest differences from the free flight, relative:")
    print(f"{'dt (s)':>8} {'path':>10} {'velocity':>10} {'rate':>10} {'tip':>10} {'momentum':>10}")
    errors = []
    for dt in (0.004, 0.002, 0.001):
        rows, impulse = coupled_flight(model, dt)
        errors.append(difference(rows, reference))
        print(f"{dt:8.3f} " + " ".join(f"{e:10.2e}" for e in errors[-1]))
    rigid, _ = coupled_flight(model, 0.001, elastic=False)
    momentum = rows[:, 13:] - rows[0, 13:]
    lost = np.abs(momentum - impulse).max() / np.abs(momentum).max()
    print(f"change of momentum less impulse of all that acts: {lost:.2e} of the change")
    print("without the increment: " + " ".join(f"{e:9.2e}" for e in difference(rigid, reference)))
    errors = np.array(errors)
    ratios = errors[:-1] / errors[1:]
    # Second order; path, velocity and momentum come near what a half-millisecond reference and JSBSim's constants can tell.
    assert np.all(ratios[:, 2:4] > 3), f"rates and tip should be four times as near at half the step: {ratios}"
    assert np.all(errors[-1] < 2e-4), errors[-1]
    # The mass matrix of the reduced model is that of the undeformed body: what is lost goes with the deformation, not the step.
    assert lost < 4e-3, lost
    assert difference(rigid, reference)[2] > 10 * errors[-1][2], "the manoeuvre shows the elastic motion"
    if out:
        plot(out, reference, rows, rigid)


def plot(out, reference, rows, rigid):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
    for ax, column, title in zip(axes, [8, 7, 12], ["pitch rate (rad/s)", "roll rate (rad/s)", "tip, upwards in A (m)"]):
        ax.plot(reference[:, 0], reference[:, column], "k", lw=3, alpha=0.3, label="free flight, this package alone")
        ax.plot(rows[:, 0], rows[:, column], "C0", lw=1, label="JSBSim with increment")
        ax.plot(rigid[:, 0], rigid[:, column], "C3--", lw=1, label="JSBSim, loads alone")
        ax.set(title=title, xlabel="t (s)")
        ax.grid(alpha=0.3)
    axes[0].legend(fontsize=7)
    figure.savefig(out, dpi=110)
    print(f"wrote {out}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
