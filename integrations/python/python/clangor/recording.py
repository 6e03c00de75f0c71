"""A recorded run as a timeline: bodies, poses and impacts of another simulator, which a session renders.

The scene is simulated for one millisecond, which writes surfaces and materials as `docs/format/timeline.md`
says; then recorded poses and impacts replace its tables. Mass, its centre and inertia are the simulator's.
Vectors turn from z up to y up: (x, y, z) becomes (x, z, -y). No dynamics is computed here.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import Session
from .material_pairs import Material, material_key, material_table

Floats = npt.NDArray[np.float64]
_TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
_WORLD = 4294967295
_LIFT = 100.0
"""Height [m] between bodies in the scene that writes their surfaces."""
_KEPT: list[tempfile.TemporaryDirectory[str]] = []


@dataclass
class Impact:
    """One impact at one point, z up; `a` and `b` are names of bodies, the normal points from b to a.

    Without a number it is the load of one step; at a joint (`joint`), the normal is 0 and `b` may be the
    world.

    `mass` is the effective mass of the pair along the normal, where one is on joints; None: of the bodies
    alone.

    Units: `time` and `window` s, `point` m, `impulse` N s (on a), `velocity` m/s (a against b, before),
    `mass` kg.
    """

    time: float
    a: str
    b: str
    point: Floats
    normal: Floats
    impulse: Floats
    velocity: Floats
    window: float
    number: int = 0
    joint: bool = False
    mass: float | None = None


@dataclass
class BodyShape:
    """A body: `shape` or `mesh` of a scene file, material, mass [kg] (0: fixed), first pose (z up).

    `inertia` [kg m²] (3, 3) about the centre of mass, in the axes of the shape; None: that of the shape.
    `centre` is the centre of mass [m] in the coordinates of the shape or mesh; None: that of the solid. A
    pose is that of the centre of mass; of a body that does not move, that of the origin of the coordinates.
    """

    name: str
    surface: str
    material: Material
    mass: float
    position: Floats
    rotation: Floats
    plane: bool = False
    inertia: Floats | None = None
    centre: Floats | None = None


@dataclass
class Recording:
    """Bodies, poses as (time, body, position, rotation, velocity, angular velocity), and impacts.

    `lasting` are loads of single steps outside impacts, and carried weight; with the impacts they are all
    that the contacts gave.
    """

    bodies: list[BodyShape]
    gravity: Floats
    step: float
    poses: list[tuple[float, str, Floats, Floats, Floats, Floats]] = field(default_factory=list)
    impacts: list[Impact] = field(default_factory=list)
    lasting: list[Impact] = field(default_factory=list)


def cross(a: Floats, b: Floats) -> Floats:
    """The vector product of two vectors (3,); `numpy.cross` takes ten times as long."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def up(vector: Floats) -> Floats:
    """A vector of a world with z up, in one with y up."""
    turned: Floats = _TURN @ vector
    return turned


def quaternion(rotation: Floats) -> Floats:
    """The unit quaternion (x, y, z, w) of a rotation matrix (3, 3), from the largest eigenvector."""
    r = rotation
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[1, 0] + r[0, 1], r[2, 0] + r[0, 2], r[2, 1] - r[1, 2]],
            [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], r[2, 1] + r[1, 2], r[0, 2] - r[2, 0]],
            [r[2, 0] + r[0, 2], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
        ]
    )
    found: Floats = np.linalg.eigh(k)[1][:, -1]
    return found


def scene_text(recording: Recording, listeners: Sequence[Sequence[float]]) -> str:
    """The scene (TOML) of the bodies; listeners have y up [m].

    Bodies that move are lifted apart, since links overlap, which a scene may not; see `_put_back`.
    """
    lines = ["version = 1", f"gravity = {up(recording.gravity).tolist()}"]
    names: dict[str, str] = {}
    for body in recording.bodies:
        key = material_key(body.material)
        if isinstance(body.material, str):
            names[key] = key
        elif key not in names:
            names[key] = f"custom-{len(names) + 1}"
            lines += material_table(names[key], body.material)
    for k, body in enumerate(recording.bodies):
        lines += ["[[plane]]" if body.plane else "[[body]]", f"name = {json.dumps(body.name)}"]
        lines += [f"material = {json.dumps(names[material_key(body.material)])}"]
        if body.plane:
            normal = up(body.rotation[:, 2])
            lines += [f"normal = {normal.tolist()}", f"point = {up(body.position).tolist()}"]
            continue
        turn = quaternion(_TURN @ body.rotation).tolist()
        key, lift = ("position", _LIFT * (k + 1)) if body.mass > 0.0 else ("origin", 0.0)
        lines += [body.surface, f"{key} = {(up(body.position) + [0.0, lift, 0.0]).tolist()}"]
        lines += [f"orientation = {{ quaternion = {turn} }}"]
        lines += ['motion = "fixed"'] if body.mass == 0.0 else _mass_lines(body)
    for place in listeners:
        lines += ["[[listener]]", f"position = {[float(x) for x in place]}"]
    return "\n".join(lines) + "\n"


def _mass_lines(body: BodyShape) -> list[str]:
    """Mass, centre of mass and inertia of a moving body; an inertia with a moment of 0 is left out."""
    lines = [f"mass = {float(body.mass)!r}"]
    if body.centre is not None:
        lines.append(f"centre_of_mass = {body.centre.tolist()}")
    if body.inertia is not None and np.linalg.eigvalsh(body.inertia)[0] > 0.0:
        lines.append(f"inertia = {(0.5 * (body.inertia + body.inertia.T)).tolist()}")
    return lines


def open_session(
    recording: Recording, folder: tempfile.TemporaryDirectory[str], listener: Sequence[float], keep: bool
) -> Session:
    """A session of what was recorded, at `listener` (3,) [m], z up.

    The folder lasts as long as the process if `keep`, since a session reads it when it renders.
    """
    if len(listener) != 3:
        raise ValueError(f"listener: needs 3 numbers, not {len(listener)}")
    x, y, z = (float(value) for value in listener)
    if keep and folder not in _KEPT:
        _KEPT.append(folder)
    target = Path(folder.name) / "run.timeline"
    write_timeline(recording, Path(folder.name) / "scene.toml", target, [(x, z, -y)])
    return Session(target, listeners=[(x, z, -y)])


def write_timeline(
    recording: Recording, scene: Path, folder: Path, listeners: Sequence[Sequence[float]]
) -> None:
    """Writes the timeline folder; `scene` is where the scene file goes, beside its meshes.

    Errors: ImportError without pyarrow, ClangorError for a material or shape that is not known.
    """
    import pyarrow.parquet as parquet  # type: ignore[import-untyped]

    if not recording.poses:
        raise ValueError("recording: no step was recorded")
    scene.write_text(scene_text(recording, listeners))
    Session(scene, duration=0.001, timeline=folder).simulate()
    head = folder / "timeline.json"
    header: dict[str, Any] = json.loads(head.read_text())
    index = {body["name"]: k for k, body in enumerate(header["bodies"])}
    _put_back(header, recording)
    for name, table in (("contacts", _contacts(recording, index)), ("poses", _poses(recording, index))):
        parquet.write_table(table, folder / f"{name}.parquet", compression="zstd")
        header[name] = {"rows": table.num_rows}
    times = [row[0] for row in recording.poses]
    header["origin"]["duration"] = times[-1]
    header["origin"]["raw_log"], header["origin"]["time_step"] = True, recording.step
    header["origin"]["pose_rate"] = (
        (len(set(times)) - 1) / (times[-1] - times[0]) if times[-1] > times[0] else 1.0
    )
    header.pop("scene", None)
    head.write_text(json.dumps(header))


def _put_back(header: dict[str, Any], recording: Recording) -> None:
    """Moving bodies begin at their first poses."""
    first = {body.name: body for body in recording.bodies if body.mass > 0.0}
    for row in header["bodies"]:
        if row["name"] in first:
            row["position"] = up(first[row["name"]].position).tolist()


def _table(columns: dict[str, npt.NDArray[Any]], vectors: dict[str, tuple[str, list[Floats]]]) -> Any:
    import pyarrow

    for name, (axes, rows) in vectors.items():
        values = np.array(rows, dtype=np.float32).reshape(-1, len(axes))
        columns.update({f"{name}_{axis}": values[:, k] for k, axis in enumerate(axes)})
    return pyarrow.table(columns)


def _contacts(recording: Recording, index: dict[str, int]) -> Any:
    rows = sorted(recording.impacts + recording.lasting, key=lambda row: row.time)
    along = [float(i.impulse @ i.normal) for i in rows]
    columns: dict[str, npt.NDArray[Any]] = {
        "t": np.array([i.time for i in rows], np.float64),
        "body_a": np.array([index[i.a] for i in rows], np.uint32),
        "body_b": np.array([index.get(i.b, _WORLD) for i in rows], np.uint32),
        "kind": np.array([2 if i.joint else 0 if i.number else 1 for i in rows], np.uint8),
        "impulse_n": np.array(along, np.float32),
        "depth": np.zeros(len(rows), np.float32),
        "impact_id": np.array([i.number for i in rows], np.uint64),
    }
    masses = [i.mass if i.number else None for i in rows]
    if any(mass is not None for mass in masses):
        columns["effective_mass"] = np.array(masses, np.float32)  # NaN for None
    across = [up(i.impulse - n * i.normal) for i, n in zip(rows, along)]
    vectors = {
        "point": ("xyz", [up(i.point) for i in rows]),
        "normal": ("xyz", [up(i.normal) for i in rows]),
        "impulse_t": ("xyz", across),
        "couple": ("xyz", [np.zeros(3) for _ in rows]),
        "velocity": ("xyz", [up(i.velocity) for i in rows]),
    }
    return _table(columns, vectors)


def _poses(recording: Recording, index: dict[str, int]) -> Any:
    rows = recording.poses
    columns: dict[str, npt.NDArray[Any]] = {
        "t": np.array([row[0] for row in rows], np.float64),
        "body": np.array([index[row[1]] for row in rows], np.uint32),
    }
    vectors = {
        "position": ("xyz", [up(row[2]) for row in rows]),
        "orientation": ("xyzw", [quaternion(_TURN @ row[3]) for row in rows]),
        "velocity": ("xyz", [up(row[4]) for row in rows]),
        "angular_velocity": ("xyz", [up(row[5]) for row in rows]),
    }
    return _table(columns, vectors)
