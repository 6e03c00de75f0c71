"""Materials of recorded bodies, and the restitution of two of them.

A material is the name of a preset or a mapping with a `base`. The restitution e = J / (m v) - 1 is that of
a ball of 1 cm that meets a plane, both in our simulation: with vibration of neither. It is no table of
measurements.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from functools import lru_cache
from math import log10
from typing import Union

from . import ClangorError, Session, materials as presets

__all__ = [
    "Material",
    "check_material",
    "material_key",
    "material_table",
    "meetings",
    "pair_restitution",
    "warn_of_level",
]

Material = Union[str, Mapping[str, Union[str, float]]]

_RADIUS = 0.01
_HEARD = 0.5
"""Least error of level [dB] of which a warning tells."""
_MEETING = """version = 1
gravity = [0, 0, 0]
{tables}
[simulation]
duration = 0.003
[[body]]
name = "ball"
shape = "sphere:0.01"
material = {first}
position = [0, {height}, 0]
velocity = [0, -{speed}, 0]
[[plane]]
material = {second}
[[listener]]
position = [0.3, 0.4, 0.3]
"""


def material_key(material: Material) -> str:
    """A text that is the same for equal materials: the preset's name, or the mapping as JSON."""
    return material if isinstance(material, str) else json.dumps(dict(material), sort_keys=True)


def material_table(name: str, material: Mapping[str, Union[str, float]]) -> list[str]:
    """The table `[material.NAME]` of a scene file."""
    rows = [f"{key} = {json.dumps(value)}" for key, value in material.items()]
    return [f"[material.{json.dumps(name)}]", *rows]


def check_material(material: Material, where: str) -> None:
    """Errors: ValueError names `where` and what is wrong with the material."""
    preset = material if isinstance(material, str) else material.get("base")
    if preset not in presets():
        raise ValueError(f"{where}: no preset is called {preset!r}")
    if not isinstance(material, str):
        try:
            Session(text=_meeting(material, "steel", 1.0))
        except ClangorError as error:
            raise ValueError(f"{where}: {error}") from None


def _meeting(first: Material, second: Material, speed: float) -> str:
    names, tables = [], []
    for name, material in (("custom-1", first), ("custom-2", second)):
        names.append(material if isinstance(material, str) else name)
        tables += [] if isinstance(material, str) else material_table(name, material)
    first_name, second_name = (json.dumps(name) for name in names)
    return _MEETING.format(
        tables="\n".join(tables),
        first=first_name,
        second=second_name,
        height=_RADIUS + 0.001 * speed,
        speed=speed,
    )


@lru_cache(maxsize=256)
def _restitution(first: str, second: str, speed: float) -> float:
    pair = [json.loads(text) if text.startswith("{") else text for text in (first, second)]
    session = Session(text=_meeting(pair[0], pair[1], speed))
    mass = session.bodies[0].mass
    rows = session.simulate().contacts
    impacts = rows["impulse_n"][rows["kind"] == 0]
    return float(impacts.sum()) / (mass * speed) - 1.0


def pair_restitution(first: Material, second: Material, speed: float = 1.0) -> float:
    """Restitution (0 to 1) of a ball of 1 cm of `first` on a plane of `second`, at `speed` [m/s]."""
    return _restitution(material_key(first), material_key(second), round(min(max(speed, 0.1), 30.0), 2))


def meetings(kind: list[int], moving: list[bool]) -> list[tuple[int, int]]:
    """Pairs of kinds (lower first) of which two bodies can meet, when only `moving` ones come to others."""
    found = set()
    for a, i in enumerate(kind):
        others = [j for b, j in enumerate(kind) if b != a]
        found |= {(min(i, j), max(i, j)) for j in others} if moving[a] else set()
    return sorted(found)


def warn_of_level(pair: tuple[Material, Material], speed: float, bounce: float, names: str) -> None:
    """Warns by how much an impact at `speed` [m/s] that bounced with `bounce` is too quiet or too loud."""
    wanted = pair_restitution(pair[0], pair[1], speed)
    level = 20.0 * log10((1.0 + max(0.0, bounce)) / (1.0 + wanted))
    if abs(level) > _HEARD:
        text = f"restitution {bounce:.2f} of the simulator instead of the materials' {wanted:.2f} costs"
        warnings.warn(f"impact of {names}: {text} {level:+.1f} dB; `hear_as` sets it", stacklevel=5)
