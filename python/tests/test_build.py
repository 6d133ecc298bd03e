"""Models from files, texts and dicts."""

import ast
import inspect
import pathlib
import pickle
import re

import numpy as np
import pytest

import romgen

BEAM = {
    "structure": {"name": "beam", "reference": "middle"},
    "parameters": {"L": 10.0},
    "sections": {
        "bar": {
            "shape": "constants",
            "EA": 1e6,
            "GAy": 1e6,
            "GAz": 1e6,
            "GJ": np.float64(500.0),
            "EIy": 500,
            "EIz": "2 * 500",
            "rhoA": 1.0,
            "rhoJ": np.array([2e-3, 1e-3, 1e-3]),
        }
    },
    "points": {"left": ["-L/2", 0, 0], "middle": [0, 0, 0], "right": ["L/2", 0, 0]},
    "members": [
        {
            "name": "beam",
            "path": ["left", "middle", "right"],
            "section": "bar",
            "elements": 40,
            "local_y": (0, 1, 0),
        }
    ],
}


def test_a_dict_makes_the_free_free_beam_of_the_textbooks():
    model = romgen.build(BEAM, modes=2)
    # First free-free bending, (beta l)^2 = 22.3733 (Euler-Bernoulli), in the soft plane and in the stiff one. Shear and rotary
    # inertia lower them by about 5 EI/(GA l^2) ~ 2.5e-5, the mesh of 40 linear elements raises them by (k h)^2/12 ~ 2e-2/12.
    expected = 22.3733 / 10**2 * np.sqrt([500.0, 1000.0])
    assert model.omega == pytest.approx(expected, rel=3e-3)
    assert model.mass == pytest.approx(10.0, rel=1e-12)
    assert model.mass_matrix[3:, 3:].diagonal()[1:] == pytest.approx(10.0 * 10**2 / 12 + 0.01, rel=1e-9)
    longer = romgen.build(BEAM, modes=1, parameters={"L": "2 * 10"})
    assert longer.omega[0] == pytest.approx(expected[0] / 4, rel=3e-3)
    assert longer.parameters == {"L": 20.0}


def test_path_and_text_give_the_same_model(structure):
    options = {"modes": [1, 3], "parameters": {"elements": 12, "sigma": "2*5"}}
    from_path = romgen.build(structure, **options)
    from_text = romgen.build(structure.read_text(), **options)
    assert from_path.to_bytes() == from_text.to_bytes()
    assert from_path.mode_numbers == [1, 3]
    assert from_path.points[:1] == ["A"] and "lc2" in from_path.load_cases
    assert all(value <= limit for _, value, limit in from_path.checks)


def test_modes_up_to_a_frequency(structure):
    model = romgen.build(str(structure), modes="3Hz", parameters={"elements": 12})
    assert model.n_modes == sum(model.omega < 3 * 2 * np.pi) == 3


def test_files_bytes_and_pickles_hold_the_same_model(model, tmp_path):
    path = tmp_path / "fmb.rom"
    model.save(path)
    copies = [romgen.Model.load(path), romgen.Model.load(str(path)), romgen.Model.load(path.read_bytes())]
    copies.append(pickle.loads(pickle.dumps(model)))
    assert all(copy.to_bytes() == model.to_bytes() for copy in copies)
    rigid = pickle.loads(pickle.dumps(model.with_method("rigid")))
    assert (rigid.method, rigid.n_modes) == ("rigid", 0)
    assert rigid.with_method("rom").n_modes == 6


def test_mistakes_are_told_as_the_command_line_tells_them(structure, model, tmp_path):
    with pytest.raises(romgen.InputError, match=r"text:\d+:\d+: .*elemnts"):
        romgen.build(structure.read_text().replace("elements = \"elements / 3\"", "elemnts = 3"))
    with pytest.raises(romgen.InputError, match="cannot be read"):
        romgen.build(tmp_path / "nothing.toml")
    with pytest.raises(romgen.BuildError, match="at most 300"):
        romgen.build(structure, modes=1000)
    with pytest.raises(ValueError, match="60Hz"):
        romgen.build(structure, modes="ten")
    with pytest.raises(TypeError, match=r"structure\.name is"):
        romgen.build({"structure": {"name": None}})
    with pytest.raises(romgen.ModelError, match="nothing.rom"):
        romgen.Model.load(tmp_path / "nothing.rom")
    damaged = bytearray(model.to_bytes())
    damaged[len(damaged) // 2] ^= 1
    with pytest.raises(romgen.ModelError):
        romgen.Model.load(bytes(damaged))
    with pytest.raises(romgen.ModelError, match="lc1"):
        model.load_case("lc9")
    assert issubclass(romgen.ModelError, romgen.Error)


def test_what_help_says_is_what_the_stubs_say():
    stubs = ast.parse((pathlib.Path(romgen.__file__).parent / "_core.pyi").read_text())

    def compare(nodes, owner):
        for node in nodes:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
                native = getattr(owner, node.name)
                assert inspect.cleandoc(native.__doc__) == ast.get_docstring(node), node.name
                if isinstance(node, ast.ClassDef):
                    compare(node.body, native)

    compare([node for node in stubs.body if not getattr(node, "name", "").endswith("Error")], romgen)


def test_the_structure_says_how_it_is_reduced_where_nothing_else_is_asked_for():
    structure = BEAM | {"reduction": {"modes": 3, "inertia": "consistent"}}
    assert romgen.build(structure).n_modes == 3
    # Both from the same text: what is asked for is named in the model.
    other = romgen.build(structure, modes=2, inertia="constant")
    assert other.n_modes == 2
    assert romgen.build(BEAM, modes=2).omega == pytest.approx(other.omega, rel=1e-12)
    with pytest.raises(romgen.InputError, match="consistent inertia"):
        romgen.build(BEAM | {"reduction": {"elastic": "geometric"}})


def test_the_programs_of_the_page_run(monkeypatch):
    """The first two of README.md, one after the other; the third needs an aerodynamic code."""
    root = pathlib.Path(__file__).resolve().parents[2]
    page = (root / "python" / "README.md").read_text()
    programs = re.findall(r"```python\n(.*?)```", page, re.S)
    monkeypatch.chdir(root)
    names = {}
    for program in programs[:2]:
        exec(program, names)
    assert len(programs) == 3
    assert names["results"]["P.dR_A"].shape[1] == 3 and names["simulation"].time == pytest.approx(10.0)
