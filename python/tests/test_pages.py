"""The Python of the pages runs as it is shown, the blocks of a page one after the other. FMUs have tests of their own."""

import pathlib
import re

import numpy as np
import pytest

import romgen

ROOT = pathlib.Path(__file__).resolve().parents[2]


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", (ROOT / page).read_text(), re.M | re.S)


def run(page):
    """Names that the blocks of a page leave behind."""
    names, shown = {}, blocks(page, "python")
    assert shown, page
    for block in shown:
        exec(compile(block, page, "exec"), names)
    return names


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the models, as the pages see them."""
    (tmp_path / "models").symlink_to(ROOT / "models")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_readme(folder):
    assert run("README.md")["model"].n_modes == 10


def test_readme_of_the_package(folder):
    names = run("python/README.md")
    assert np.abs(names["results"]["P.dR_A"]).max() > 0.1
    assert names["motion"].position.shape == (32, 3)


def test_tutorial(folder, capsys):
    (structure,) = blocks("docs/tutorial.md", "toml")
    romgen.build(structure, modes=10).save("wing.rom")
    run("docs/tutorial.md")
    assert capsys.readouterr().out == blocks("docs/tutorial.md", "text")[-1]


def test_linearise(folder, model):
    model.save("fmb.rom")
    linear = romgen.linearise(model)
    np.savez("fmb.npz", A=linear.A, B=linear.B, C=linear.C, D=linear.D, inputs=linear.inputs, outputs=linear.outputs)
    assert run("docs/linearise.md")["system"].A.shape == linear.A.shape


def test_model_file(folder, model):
    model.save("fmb.rom")
    assert run("docs/rom-format.md")["mass"] == pytest.approx(model.mass, rel=1e-15)
