import pathlib

import pytest

import romgen

MODELS = pathlib.Path(__file__).resolve().parents[2] / "models"


@pytest.fixture(scope="session")
def structure():
    return MODELS / "fmb.toml"


@pytest.fixture(scope="session")
def model(structure):
    """The frame of Hesse & Palacios, 30 elements, 6 modes."""
    return romgen.build(structure, modes=6, parameters={"elements": 30})
