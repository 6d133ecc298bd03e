"""Reads the files that .ci/vtk made with meshio and holds them against the results of the run."""

import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import meshio
import numpy

folder = Path(sys.argv[1])
results, model = numpy.load(folder / "results.npz"), numpy.load(folder / "fmb.npz")

# The collection: instants in order, the first and the last of the run among them, every file there.
frames = xml.parse(folder / "structure.pvd").getroot().findall(".//DataSet")
times = numpy.array([float(frame.get("timestep")) for frame in frames])
assert len(frames) == 50 and times[0] == 0.0 and times[-1] == results["t"][-1] and (numpy.diff(times) > 0).all()

rest = model["picture.positions"]
grids = [meshio.read(folder / frame.get("file")) for frame in frames]
lengths = []
for t, grid in zip(times, grids):
    row = numpy.flatnonzero(results["t"] == t)[0]
    assert grid.points.shape == rest.shape and [block.type for block in grid.cells] == ["line"]
    assert numpy.unique(grid.cell_data["member"][0]).tolist() == [1, 2, 3, 4]
    # Where A is and how it is turned, from the results alone.
    w, x, y, z = results["zeta"][row]
    turn = numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])
    displacement = grid.point_data["displacement"]
    expected = results["r_G"][row] + rest @ turn.T + displacement
    assert numpy.allclose(grid.points, expected, rtol=0, atol=1e-12), t
    # The tip P, by the channel that the run recorded of it.
    tip = numpy.argmin(numpy.linalg.norm(grid.points - results["P.R_G"][row], axis=1))
    assert numpy.linalg.norm(grid.points[tip] - results["P.R_G"][row]) < 1e-9, t
    assert numpy.allclose(displacement[tip], turn @ results["P.dR_A"][row], rtol=0, atol=1e-9), t
    lengths.append(numpy.linalg.norm(displacement[tip]))
assert max(lengths) > 1e-3

# Velocities are those of the positions: the mean of two over the step against the difference, to the order of its square. Taken from
# neighbouring rows of the results at the tip, where it moves fastest.
grid, t = grids[25], times[25]
row = numpy.flatnonzero(results["t"] == t)[0]
tip = numpy.argmin(numpy.linalg.norm(grid.points - results["P.R_G"][row], axis=1))
h = results["t"][row + 1] - t
central = (results["P.R_G"][row + 1] - results["P.R_G"][row - 1]) / (2 * h)
third = numpy.abs(numpy.diff(results["P.R_G"][row - 2 : row + 3], 3, axis=0)).max() / h**3
error = numpy.abs(grid.point_data["velocity"][tip] - central).max()
assert error < 2 * third * h**2 / 6 + 1e-9, (error, third * h**2 / 6)

# Modes: the arrays of the model, node by node; in space they carry no momentum, so the reference node moves against them.
modes = meshio.read(folder / "modes.vtu")
shapes = model["picture.phi_translation"]
assert numpy.array_equal(modes.points, rest)
for j in range(shapes.shape[2]):
    assert numpy.array_equal(modes.point_data[f"mode {j + 1}"], shapes[:, :, j])
    assert not numpy.array_equal(modes.point_data[f"mode {j + 1} in space"], shapes[:, :, j])
# A model on a curved manifold: its tip is where the results say, to 0.5 % of its displacement (terms of the picture and of the point that
# are dropped), not to the several percent by which straight shapes would miss it.
soft = numpy.load(folder / "soft" / "results.npz")
largest, worst = 0.0, 0.0
for frame in xml.parse(folder / "soft" / "structure.pvd").getroot().findall(".//DataSet"):
    row = numpy.flatnonzero(soft["t"] == float(frame.get("timestep")))[0]
    grid = meshio.read(folder / "soft" / frame.get("file"))
    distance = numpy.linalg.norm(grid.points - soft["P.R_G"][row], axis=1).min()
    largest, worst = max(largest, numpy.linalg.norm(soft["P.dR_A"][row])), max(worst, distance)
assert largest > 0.5 and worst < 0.005 * largest, (largest, worst)

# Internal loads of the aircraft: places at 1/2, 5/8, 3/4 and 7/8 of the wing, whose 16 quadratic elements are pieces 0 to 31. A place at a node is on
# the piece after it; between two places the pieces are linear at their middles; nothing is known elsewhere.
run, wing = numpy.load(folder / "hale" / "results.npz"), [16, 20, 24, 28]
frames = xml.parse(folder / "hale" / "structure.pvd").getroot().findall(".//DataSet")
assert len(frames) == 5
for frame in frames:
    row = numpy.flatnonzero(run["t"] == float(frame.get("timestep")))[0]
    grid = meshio.read(folder / "hale" / frame.get("file"))
    for field, channel in [("internal_force", "F"), ("internal_moment", "M")]:
        found = grid.cell_data[field][0]
        told = numpy.array([run[f"left wing {k}.{channel}"][row] for k in range(1, 5)])
        assert numpy.array_equal(found[wing], told)
        for piece in set(range(16, 28)) - set(wing):
            middle = [numpy.interp((piece + 0.5) / 32, [0.5, 0.625, 0.75, 0.875], told[:, k]) for k in range(3)]
            assert numpy.allclose(found[piece], middle, rtol=1e-9, atol=1e-9), piece
        assert numpy.isnan(found[:16]).all() and numpy.isnan(found[29:]).all()
    assert numpy.abs(grid.cell_data["internal_moment"][0][16]).max() > 10
wings = meshio.read(folder / "hale.vtu")
for j in range(6):
    assert numpy.abs(wings.cell_data[f"mode {j + 1} internal_moment"][0][wing]).max() > 0

print(f"{len(grids)} frames of {len(rest)} nodes and {shapes.shape[2]} modes read back by meshio {meshio.__version__}")

# Films of validation runs, every step a frame: at all nodes the velocities are the differences of the positions, to the order of the step.
films = sorted((folder / "study").rglob("structure.pvd"))
assert len(films) == 4, films
for film in films:
    frames = xml.parse(film).getroot().findall(".//DataSet")
    t = numpy.array([float(frame.get("timestep")) for frame in frames])
    grids = [meshio.read(film.parent / frame.get("file")) for frame in frames]
    place, velocity = (numpy.array(list(values)) for values in
                       zip(*((grid.points, grid.point_data["velocity"]) for grid in grids)))
    h = t[1] - t[0]
    assert len(t) == 101 and numpy.allclose(numpy.diff(t), h)
    third = numpy.abs(numpy.diff(place, 3, axis=0)).max() / h**3
    error = numpy.abs((place[2:] - place[:-2]) / (2 * h) - velocity[1:-1]).max()
    # Displacements of films are exact to 5e-4 of the largest.
    seen = 5e-4 * max(numpy.abs(grid.point_data["displacement"]).max() for grid in grids) / h
    assert error < 2 * third * h**2 / 6 + seen, (film, error, third * h**2 / 6, seen)
    assert numpy.abs(velocity).max() > 5 * error, (film, numpy.abs(velocity).max(), error)
