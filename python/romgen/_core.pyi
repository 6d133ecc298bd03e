"""Classes of the native part. SI units, angles in radians; G inertial frame, A body frame on the reference node.

``m`` is the number of elastic modes. Arrays that are returned are copies.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._results import Results

_Array = NDArray[np.float64]
_Frame = Literal["dead", "body", "follower"]
_Integrator = Literal["newmark", "gen-alpha", "rk4", "energy-momentum"]
_Method = Literal["rom", "mean-axes", "rigid"]

__version__: str

class Error(Exception):
    """Base of all exceptions of this package. Their texts are those of the command-line tools."""

class InputError(Error):
    """A structure or load file is wrong: one line per mistake, with file, line, column and what to do."""

class BuildError(Error):
    """A reduced model could not be made of a structure."""

class ModelError(Error):
    """A model file or its contents are wrong, or the model does not have what was asked for by name."""

class SettingsError(Error):
    """Settings of a simulation out of range, or a state that does not fit the model."""

class StepError(Error):
    """A step could not be made; the state is the one before it."""

    results: Results
    """What was recorded until then; there when a run raised the error."""

def build(
    structure: str | os.PathLike[str] | Mapping[str, Any],
    *,
    modes: int | Sequence[int] | str | None = None,
    residual: Sequence[str] | str | None = None,
    parameters: Mapping[str, float | str] | None = None,
    all_nodes: bool = False,
    inertia: str | None = None,
    elastic: str | None = None,
) -> Model:
    """Builds the reduced model of a structure. What is not given of modes, residual, inertia and elastic is as its table ``[reduction]``
    says, else the default.

    Args:
        structure: path of a structure file, its text (anything with a line break), or the same as a dict.
        modes: how many of the lowest elastic modes, a list of their numbers from 1, or a frequency limit such as ``"15Hz"`` or
            ``"90rad/s"`` (else 10).
        residual: names of points whose static response to loads residual modes are to complete, ``"all"`` that carry loads, or
            ``"none"`` (else the default).
        parameters: values of parameters of the structure, as numbers or expressions (``--set`` of the command line).
        all_nodes: keep the mode shapes at every node, for pictures.
        inertia: mass matrix, ``"constant"`` (else the default) or ``"consistent"`` (that of the deformed body).
        elastic: elastic forces, ``"linear"`` (else the default) or ``"geometric"`` (large deflections, with consistent inertia).

    Raises:
        InputError: for a structure that is wrong.
        BuildError: for one that cannot be reduced.

    Warns:
        RuntimeWarning: for a check of the model that is not passed.
    """

def schema() -> str:
    """JSON Schema of the structure file."""

@final
class Model:
    """A reduced model: constant, to be shared by any number of simulations and threads. Can be pickled."""

    @staticmethod
    def load(source: str | os.PathLike[str] | bytes) -> Model:
        """Reads a model file, or the bytes of one."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the model file; whoever opens it sees the old one or the whole new one."""

    def to_bytes(self) -> bytes:
        """Contents of the model file."""

    def with_method(self, method: _Method) -> Model:
        """The same body by a simpler method (``"mean-axes"``, ``"rigid"``), or by the full one again (``"rom"``)."""

    @property
    def name(self) -> str:
        """Name of the structure."""
    @property
    def method(self) -> _Method:
        """How the equations are simplified."""
    @property
    def n_modes(self) -> int:
        """Number of elastic modes m."""
    @property
    def points(self) -> list[str]:
        """Names of points."""
    @property
    def load_cases(self) -> list[str]:
        """Names of load cases."""
    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the structure."""
    @property
    def structure_text(self) -> str:
        """The structure file, verbatim."""
    @property
    def checks(self) -> list[tuple[str, float, float]]:
        """Checks that the generator made: (what, value, limit)."""
    @property
    def mode_numbers(self) -> list[int]:
        """Numbers of the modes in the structure's list of elastic modes, from 1 - (m)."""
    @property
    def omega(self) -> _Array:
        """Circular frequencies, rad/s - (m)."""
    @property
    def damping_ratio(self) -> _Array:
        """Critical damping ratios, 1 - (m)."""
    @property
    def mass(self) -> float:
        """Total mass, kg."""
    @property
    def centre_of_mass(self) -> _Array:
        """Centre of mass in A, m - (3)."""
    @property
    def mass_matrix(self) -> _Array:
        """Rigid mass matrix about the origin of A: kg, kg m, kg m^2 - (6, 6), v then w."""

    @property
    def apparent_inertia(self) -> _Array:
        """Inertia about the origin of A with the modes free to respond - (6, 6): what a sudden acceleration meets."""
    @property
    def gravity(self) -> _Array:
        """Acceleration of free fall in G, under which the model is marched, m/s^2 - (3): zero in weightlessness."""
    @property
    def equilibrium(self) -> LoadCase:
        """What acts in the equilibrium that the model is about, and nothing else: the loads in balance there, to which those of a
        :class:`LoadSet` are added where this is its ``case``."""
    @property
    def sensors(self) -> list[str]:
        """Names of inertial sensors."""
    @property
    def stations(self) -> list[str]:
        """Names of blocks of stations; see :class:`Stations`."""

    def stable_dt(self, integrator: _Integrator) -> float | None:
        """Longest stable time step of the oscillators, s; None without limit."""

    def load_case(self, name: str) -> LoadCase:
        """A load case of the model, ready to be stepped with."""

    def read_load_cases(
        self,
        source: str | os.PathLike[str] | Mapping[str, Any],
        parameters: Mapping[str, float | str] | None = None,
    ) -> list[LoadCase]:
        """Load cases of a file of their own (path, text or dict); ``parameters`` gives its parameters other values."""

    def load_set(
        self,
        points: Sequence[str],
        frame: _Frame = "body",
        member: str | None = None,
        case: LoadCase | None = None,
        stations: Sequence[str] = ...,
    ) -> LoadSet:
        """Wrenches on these points, to be set from step to step; see :class:`LoadSet`."""

    def derivatives(self, state: State, loads: LoadCase | LoadSet | None = None) -> StateRate:
        """Right-hand side of the equations of motion, for hosts that integrate themselves."""

    def jacobian(self, state: State, loads: LoadCase | LoadSet | None = None) -> Jacobian:
        """Exact derivatives of the equations of motion at a state, see :class:`Jacobian`."""

    def velocity(self, state: State) -> _Array:
        """True velocity of A in A, ``Phi_R q_dot + beta_star``: (v, w), m/s and rad/s - (6)."""

    def rigid_output(self, state: State) -> RigidOutput:
        """Motion of frame A."""

    def point_output(self, state: State, point: str) -> PointOutput:
        """Where a named point is."""

    def ledger(self, state: State) -> Ledger:
        """Centre of mass, momenta and energies."""

@final
class State:
    """Everything that changes while a model is marched. Plain data: copy it to take a snapshot; can be pickled.

    A new one is at rest and undeformed at t = 0, A along G with its origin where the model says. Changing a part by hand
    makes the next step solve the accelerations anew.
    """

    def __new__(cls, model: Model) -> State: ...

    @property
    def time(self) -> float:
        """Time, s."""
    @time.setter
    def time(self, time: float) -> None: ...
    @property
    def q(self) -> _Array:
        """Modal amplitudes - (m)."""
    @q.setter
    def q(self, values: ArrayLike) -> None: ...
    @property
    def q_dot(self) -> _Array:
        """Modal rates, 1/s - (m)."""
    @q_dot.setter
    def q_dot(self, values: ArrayLike) -> None: ...
    @property
    def beta_star(self) -> _Array:
        """Rigid part of the velocity of A, in A: v* (m/s), w* (rad/s) - (6). The true one is :meth:`Model.velocity`."""
    @beta_star.setter
    def beta_star(self, values: ArrayLike) -> None: ...
    @property
    def attitude(self) -> _Array:
        """Quaternion, scalar first, turns components in A into components in G - (4). Scaled to unit length when set."""
    @attitude.setter
    def attitude(self, values: ArrayLike) -> None: ...
    @property
    def position(self) -> _Array:
        """Position of the origin of A in G, m - (3)."""
    @position.setter
    def position(self, values: ArrayLike) -> None: ...
    @property
    def u_dot(self) -> _Array:
        """Accelerations (q_ddot, beta_star_dot), valid where ``accelerations_known`` - (m + 6)."""
    @property
    def accelerations_known(self) -> bool:
        """Whether ``u_dot`` belongs to the rest of the state."""

    def copy(self) -> State:
        """A snapshot; stepping on from it gives the same bits."""

    def __copy__(self) -> State: ...
    def __deepcopy__(self, memo: Any) -> State: ...

@final
class StateRate:
    """Time derivative of a state."""

    @property
    def q_dot(self) -> _Array:
        """Modal rates, 1/s - (m)."""
    @property
    def u_dot(self) -> _Array:
        """(q_ddot, beta_star_dot): 1/s^2, m/s^2, rad/s^2 - (m + 6)."""
    @property
    def attitude_dot(self) -> _Array:
        """Rate of the quaternion, 1/s - (4)."""
    @property
    def position_dot(self) -> _Array:
        """Velocity of the origin of A in G, m/s - (3)."""

@final
class LoadCase:
    """A load case made ready for one model. Constant."""

    @property
    def name(self) -> str:
        """Its name."""
    @property
    def description(self) -> str:
        """One line for people; may be empty."""
    @property
    def t_end(self) -> float:
        """End of the run, s."""
    @property
    def dt(self) -> float:
        """Time step its author ran it with, s."""
    @property
    def numerical_damping(self) -> float:
        """Numerical damping of the implicit integrators."""
    @property
    def initial_state(self) -> State:
        """State in which it starts; a simulation begins there once its ``state`` is set to it."""

@final
class LoadSet:
    """Wrenches (force in N, moment in N m) on some points, held until they are changed.

    The implicit integrators take them for the loads at the end of the step, RK4 holds them over the step. Without a
    load case they are all the loads there are: about a loaded equilibrium those in balance there have to be among them, or act
    besides with ``case=model.equilibrium``.

    Args:
        points: names of the points, each once.
        frame: of the components: ``"body"`` (A), ``"dead"`` (G) or ``"follower"`` (axes of the section, turning
            with it).
        member: for follower loads where members with different section axes meet: the one to follow.
        case: a load case that acts besides, and with it the loads of a loaded equilibrium.
        stations: names of blocks of stations that :meth:`set_stations` can load.
    """

    def __new__(
        cls,
        model: Model,
        points: Sequence[str],
        frame: _Frame = "body",
        member: str | None = None,
        case: LoadCase | None = None,
        stations: Sequence[str] = ...,
    ) -> LoadSet: ...

    @property
    def points(self) -> list[str]:
        """Names of the points."""

    @property
    def stations(self) -> list[str]:
        """Names of the blocks of stations."""

    def set_stations(self, name: str, wrenches: ArrayLike, frame: _Frame = "follower") -> None:
        """Replaces what acts on a block of stations: (fx, fy, fz, mx, my, mz) at every station - (n, 6), components in ``"dead"`` (G),
        ``"body"`` (A) or ``"follower"`` axes, those of every section."""

    def clear(self) -> None:
        """Removes all wrenches; a load case stays."""

    def set(self, wrenches: ArrayLike) -> None:
        """Replaces all wrenches: (fx, fy, fz, mx, my, mz) on every point - (points, 6). Those on stations become zero."""

    def add(
        self,
        point: str,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        frame: _Frame | None = None,
        member: str | None = None,
    ) -> None:
        """Adds a force (3) and a moment (3) on one of the points, in the set's frame or in another."""

    def add_wrench(
        self,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        frame: Literal["body", "dead"] = "body",
    ) -> None:
        """Adds a force (3) on the origin of frame A and a moment (3), components in ``"body"`` (A) or ``"dead"`` (G) axes."""

    def add_modal(self, forces: ArrayLike) -> None:
        """Adds generalised forces on the elastic modes - (m): the work of loads in their shapes. What the same loads do to the rigid
        motion goes by :meth:`add_wrench`."""

@final
class Stations:
    """A block of stations of a model: where they are and how they move, in one call.

    Args:
        model: the model, or a simplification of it (:meth:`Model.with_method`).
        name: of the block.
    """

    def __new__(cls, model: Model, name: str) -> Stations: ...

    @property
    def name(self) -> str:
        """Name of the block."""
    @property
    def members(self) -> list[tuple[str, int]]:
        """Members that it goes along, with the number of stations on each, in the order of the stations."""
    @property
    def fraction(self) -> _Array:
        """Place of every station as a fraction of the length of its member - (n)."""
    @property
    def offset(self) -> _Array:
        """From the axis to the stations, section axes, m - (n, 3)."""
    def __len__(self) -> int: ...

    def read(self, of: Simulation | State, axes: Literal["inertial", "body", "section"] = "inertial") -> StationMotion:
        """Where the stations are and how they move in a state, or in that of a simulation.

        Args:
            of: a :class:`Simulation` or a :class:`State` of the model.
            axes: ``"inertial"``: everything in G. ``"body"``: positions from the origin of A and attitudes against it; velocities are
                those against G with components in A. ``"section"``: as ``"body"``, velocities with components in the axes of every section.
        """

@final
class StationMotion:
    """Where stations are and how they move."""

    @property
    def position(self) -> _Array:
        """Positions, m - (n, 3)."""
    @property
    def attitude(self) -> _Array:
        """Attitudes of the section axes: unit quaternions, scalar first - (n, 4)."""
    @property
    def velocity(self) -> _Array:
        """Velocities against G, m/s - (n, 3)."""
    @property
    def angular_velocity(self) -> _Array:
        """Angular velocities of the sections against G, rad/s - (n, 3)."""

@final
class RigidOutput:
    """Motion of frame A."""

    @property
    def r_G(self) -> _Array:
        """Position of the origin of A in G, m - (3)."""
    @property
    def v_G(self) -> _Array:
        """Its velocity, components in G, m/s - (3)."""
    @property
    def w_G(self) -> _Array:
        """Angular velocity of A, components in G, rad/s - (3)."""
    @property
    def v_A(self) -> _Array:
        """Velocity of the origin, components in A, m/s - (3)."""
    @property
    def w_A(self) -> _Array:
        """Angular velocity, components in A, rad/s - (3)."""
    @property
    def zeta(self) -> _Array:
        """Attitude quaternion, scalar first, A to G - (4)."""

@final
class PointOutput:
    """Where a named point is."""

    @property
    def dR_A(self) -> _Array:
        """Displacement from the equilibrium in A, m - (3)."""
    @property
    def R_G(self) -> _Array:
        """Position in G, m - (3)."""

@final
class PointMotion:
    """How a named point moves, seen from G."""

    @property
    def zeta(self) -> _Array:
        """Attitude quaternion of the node's axes, scalar first, node to G - (4)."""
    @property
    def v_G(self) -> _Array:
        """Velocity in G, m/s - (3)."""
    @property
    def w_G(self) -> _Array:
        """Angular velocity in G, rad/s - (3)."""
    @property
    def a_G(self) -> _Array:
        """Acceleration in G, m/s^2 - (3)."""
    @property
    def alpha_G(self) -> _Array:
        """Angular acceleration in G, rad/s^2 - (3)."""

@final
class SensorReading:
    """What an inertial sensor reads, in its own axes."""

    @property
    def a(self) -> _Array:
        """Acceleration, less that of free fall where the sensor feels gravity, m/s^2 - (3)."""
    @property
    def w(self) -> _Array:
        """Angular velocity, rad/s - (3)."""
    @property
    def alpha(self) -> _Array:
        """Angular acceleration, rad/s^2 - (3)."""

@final
class Ledger:
    """Quantities whose balance tells whether a result can be trusted."""

    @property
    def r_CM_G(self) -> _Array:
        """Centre of mass in G, m - (3)."""
    @property
    def p_G(self) -> _Array:
        """Linear momentum in G, kg m/s - (3)."""
    @property
    def L_G(self) -> _Array:
        """Angular momentum about the origin of G, kg m^2/s - (3)."""
    @property
    def E_kin(self) -> float:
        """Kinetic energy, J."""
    @property
    def E_el(self) -> float:
        """Elastic energy of the kept modes, J."""
    @property
    def E_grav(self) -> float:
        """Potential energy in the field of gravity, zero with the centre of mass at the origin of G, J."""

@final
class Reaction:
    """What the body does to a host that moves its frame A: wrenches about the origin of A, axes of A, on the host.

    A host that carries mass and inertia of the undeformed body applies ``loads + increment``, one that applies the loads
    itself too the ``increment`` alone, one without inertia of the body the ``total``.
    """

    @property
    def inertia(self) -> _Array:
        """Inertia of the undeformed body, -(M_RR beta_dot + C_RR(beta) beta), N and N m - (6)."""
    @property
    def loads(self) -> _Array:
        """Resultant of the loads at the deformed points, N and N m - (6)."""
    @property
    def increment(self) -> _Array:
        """What elasticity adds, N and N m - (6)."""
    @property
    def total(self) -> _Array:
        """Sum of the three, zero in free flight - (6)."""

@final
class Jacobian:
    """Exact derivatives of the equations of motion at a state, see :meth:`Simulation.jacobian` and :meth:`Model.jacobian`."""

    @property
    def matrix(self) -> _Array:
        """Derivative of the rates of the states by the states - (n, n), n = 2 m + 12, in the order of :attr:`states`."""
    @property
    def states(self) -> list[str]:
        """Names of the states: amplitudes ``q``, rates ``q_dot``, rigid part ``beta*`` of the velocity of A in A, small turn ``theta`` of A
        about its own axes, position ``r_G``. The rate of ``theta`` is relative to the motion at hand."""
    @property
    def accelerations(self) -> _Array:
        """Accelerations ``(q_ddot, beta*_dot)`` there - (m + 6)."""
    def by_load(self, loads: LoadCase | LoadSet) -> _Array:
        """Derivative of the rates of the states by a factor on these loads - (n): what they add. With a :class:`LoadSet` of one unit force it is
        the column of that force."""

@final
class StateSpace:
    """A linear state-space model, ``x_dot = A x + B u``, ``y = C x + D u``, see :func:`linearise`."""

    @property
    def A(self) -> _Array:
        """(states, states)."""
    @property
    def B(self) -> _Array:
        """(states, inputs)."""
    @property
    def C(self) -> _Array:
        """(outputs, states)."""
    @property
    def D(self) -> _Array:
        """(outputs, inputs)."""
    @property
    def states(self) -> list[str]:
        """Names of the states."""
    @property
    def inputs(self) -> list[str]:
        """Names of the inputs."""
    @property
    def outputs(self) -> list[str]:
        """Names of the outputs."""
    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of ``A`` with all states, in ascending order of frequency - (n), complex."""
    @property
    def steady(self) -> dict[str, Any]:
        """The steady state: ``q``, ``velocity`` of A in A (v, w), ``attitude``, ``position``, changed ``factors``, the ``wrench`` that holds A
        (or None), and the ``residual`` accelerations relative to those of the loads."""
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes what the ending of the name says, as ``romgen linearise`` does: a MATLAB file ``.mat``, a plot of the poles ``.svg``, a page
        ``.html``; anything else is a NumPy archive."""

def linearise(
    model: Model,
    load_case: LoadCase | None = None,
    *,
    time: float = 0.0,
    velocity: ArrayLike | None = None,
    rate: ArrayLike | None = None,
    balance: Sequence[str] = ...,
    hold: bool = False,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    reduce: bool = False,
) -> StateSpace:
    """A linear model about the equilibrium, a load case or a steady rotation; see docs/linearise.md for states, inputs and outputs."""

@final
class Simulation:
    """Marches one model from rest at t = 0, or from any state given to :attr:`state`.

    Args:
        dt: time step, s.
        integrator: ``"newmark"`` and ``"gen-alpha"`` are implicit, ``"rk4"`` explicit (see :meth:`Model.stable_dt`);
            ``"energy-momentum"`` keeps the energy of models with consistent inertia.
        numerical_damping: of the implicit ones, 0 to 1.
        max_iterations: most iterations of an implicit step, 1 to 1000.
    """

    def __new__(
        cls,
        model: Model,
        dt: float,
        *,
        integrator: _Integrator = "newmark",
        numerical_damping: float = 0.0,
        max_iterations: int = 40,
    ) -> Simulation: ...

    @property
    def state(self) -> State:
        """A copy of the state; set it to go on from a snapshot or from initial conditions."""
    @state.setter
    def state(self, state: State) -> None: ...
    @property
    def gravity(self) -> _Array:
        """Acceleration of free fall in G, m/s^2 - (3). It begins as that of the model and may be set at any time; it is no part of the
        state."""
    @gravity.setter
    def gravity(self, acceleration: ArrayLike) -> None: ...
    @property
    def dt(self) -> float:
        """Time step, s."""
    @property
    def integrator(self) -> _Integrator:
        """Its name."""
    @property
    def time(self) -> float:
        """Time, s."""
    def watch_errors(self, every: int = 4) -> None:
        """Estimates errors from now on, looking at the motion every so many steps; 0 turns it off."""
    @property
    def error_estimate(self) -> dict[str, float] | None:
        """Estimated relative errors of the run so far, as a validation measures them, and the use made of the range of the model
        (1: terms left out reach a tenth): ``{"indicator", "v_G", "w_G", "dR_A", "amplitude", "rate"}``. None unless errors
        are watched (:meth:`watch_errors`).
        """
    @property
    def rigid(self) -> RigidOutput:
        """Motion of frame A."""
    def internal_loads(self, loads: LoadCase | LoadSet | None = None) -> dict[str, _Array]:
        """Section forces at the places of internal loads: {name: (Fx, Fy, Fz, Mx, My, Mz)}, N and N m, on the positive face in section axes;
        by summation of forces where the model allows it."""

    @property
    def ledger(self) -> Ledger:
        """Centre of mass, momenta and energies."""

    def point(self, name: str) -> PointOutput:
        """Where a named point is."""

    def point_motion(self, name: str, loads: LoadCase | LoadSet | None = None) -> PointMotion:
        """How a named point moves: attitude, velocities, accelerations."""

    def sensor(self, name: str, loads: LoadCase | LoadSet | None = None) -> SensorReading:
        """What an inertial sensor reads."""

    def step(self, loads: LoadCase | LoadSet | None = None) -> None:
        """One time step; without loads those of a loaded equilibrium act alone."""

    def prescribe(
        self,
        loads: LoadCase | LoadSet | None,
        *,
        velocity: ArrayLike,
        rate: ArrayLike,
        attitude: ArrayLike,
        position: ArrayLike,
    ) -> None:
        """Begins a motion of frame A that the host prescribes, at the present time.

        Args:
            velocity: (v_A, w_A) of A in its own axes, m/s and rad/s - (6).
            rate: derivative of these components - (6); the inertial acceleration is ``v_A_dot + w_A x v_A``.
            attitude: unit quaternion, scalar first, A to G - (4).
            position: of the origin of A in G, m - (3).
        """

    def step_prescribed(
        self,
        loads: LoadCase | LoadSet | None,
        *,
        velocity: ArrayLike,
        rate: ArrayLike,
        attitude: ArrayLike,
        position: ArrayLike,
    ) -> None:
        """One step in which the host moves frame A, to this motion at its end; see :attr:`reaction`."""

    def jacobian(self, loads: LoadCase | LoadSet | None = None) -> Jacobian:
        """Exact derivatives of the equations of motion at the present state, see :class:`Jacobian`."""

    @property
    def reaction(self) -> Reaction | None:
        """What the body does to the host at the end of the last prescribed step; None in free flight."""

    def run(
        self,
        loads: LoadCase | LoadSet | None = None,
        steps: int | None = None,
        *,
        t_end: float | None = None,
        every: int = 1,
        points: Sequence[str] | None = None,
    ) -> Results:
        """So many steps, or steps up to ``t_end`` (s), without the interpreter lock.

        The first row recorded is the state now. ``every`` records every so many steps, and the last; ``points`` names
        the points to record, by default all. Raises :class:`StepError` with what was recorded in ``results``.
        """

    def run_wrenches(
        self, loads: LoadSet, wrenches: ArrayLike, *, every: int = 1, points: Sequence[str] | None = None
    ) -> Results:
        """One step for every row of wrenches - (steps, points of ``loads``, 6) - in the frames of ``loads``.

        The set itself is not changed. Otherwise as :meth:`run`.
        """
