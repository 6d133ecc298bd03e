"""Results of a run."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np


class Results(dict):
    """Time histories of one run: a dict of arrays, one row per instant recorded, under the names of ``results.npz``.

    ``results["v_G"]`` has shape (rows, 3), a scalar like ``results["t"]`` has shape (rows,).

    Attributes:
        units: unit of every channel, for example ``{"v_G": "m/s"}``.
        descriptions: what every channel is, and in which frame.
        components: names of its columns, empty for a scalar.
        metadata: facts about the run.
    """

    units: dict[str, str]
    descriptions: dict[str, str]
    components: dict[str, list[str]]
    metadata: dict[str, Any]

    def __init__(self, arrays=(), units=None, descriptions=None, components=None, metadata=None):
        super().__init__(arrays)
        self.units = units or {}
        self.descriptions = descriptions or {}
        self.components = components or {}
        self.metadata = metadata or {}

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Results:
        """Reads a ``results.npz`` of this package or of ``romrun``."""
        with np.load(path) as archive:
            arrays = {name: archive[name] for name in archive.files if name != "metadata"}
            metadata = json.loads(archive["metadata"].tobytes())
        channels = {channel["name"]: channel for channel in metadata.pop("channels")}
        of = lambda key: {name: channels[name][key] for name in arrays}  # noqa: E731
        return cls(arrays, of("unit"), of("description"), of("components"), metadata)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the ``results.npz`` that ``romrun`` would write."""
        channels = [
            {
                "name": name,
                "components": self.components.get(name, []),
                "unit": self.units.get(name, ""),
                "description": self.descriptions.get(name, ""),
            }
            for name in self
        ]
        text = json.dumps({**self.metadata, "channels": channels}).encode()
        np.savez(path, **self, metadata=np.frombuffer(text, dtype=np.uint8))

    def __repr__(self) -> str:
        rows = len(self["t"]) if "t" in self else 0
        return f"Results({rows} rows: {', '.join(self)})"
