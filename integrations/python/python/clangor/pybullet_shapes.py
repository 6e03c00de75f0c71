"""Surfaces of PyBullet's collision shapes as shapes of a scene file, or as triangles.

The frames of a link's shapes lie in its inertial frame, and so do the vertices that PyBullet gives. A mesh
collides as its convex hull; a file of several objects as the hull of each; a concave one as it is. The
k-th shape is the k-th child of the link's compound: of a mesh that is a compound in it, PyBullet gives the
first hull alone, and so the file is read. Nothing is computed about the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .recording import Floats
from .surfaces import AXIS_Y_TO_Z, Triangles, ball, box, capsule, cylinder, hull, union

__all__ = ["Part", "link_parts", "rotation"]

_FLOOR = 10.0
"""Least length and width [m] of a box that, where it does not move, is a plane at its upper face."""
_WHOLE = 0.1
"""Share of its size by which the box about a surface may be smaller than Bullet's, besides its margins."""
_MARGIN = 0.02


@dataclass
class Part:
    """A solid: `line` of a scene file if the format has its shape, else `mesh` alone; place [m] and axes.

    `mesh` is in the axes of the simulator's shape, before `turn`; `axes` are those of `line`.
    """

    line: str
    mesh: Triangles
    place: Floats
    turn: Floats
    axes: Floats
    plane: bool = False

    def moved(self, place: Floats, turn: Floats) -> Part:
        """The part in a frame in which that of now is at `place` and has the axes `turn`."""
        at = place + turn @ self.place
        return Part(self.line, self.mesh, at, turn @ self.turn, turn @ self.axes, self.plane)

    def triangles(self) -> Triangles:
        """The surface in the frame of `place`."""
        return self.mesh[0] @ self.turn.T + self.place, self.mesh[1]


def rotation(quaternion: Any) -> Floats:
    """The matrix (3, 3) of a quaternion (x, y, z, w)."""
    return np.array(pybullet.getMatrixFromQuaternion(quaternion), float).reshape(3, 3)


def link_parts(client: int, link: tuple[int, int], fixed: bool, name: str) -> list[Part]:
    """The solids of a link (number of the body and of the link), in its inertial frame.

    `fixed`: the link does not move and is a body of its own. Errors: ValueError names body and link.
    """
    rows = pybullet.getCollisionShapeData(*link, client)
    fixed = fixed and len(rows) == 1
    parts = [_part(client, link, k, row, fixed, name) for k, row in enumerate(rows)]
    if any(part.plane for part in parts):
        if len(parts) > 1:
            raise ValueError(f"{name}: a plane cannot be one of several shapes")
    elif any(row[2] == pybullet.GEOM_MESH for row in rows):
        _check_whole(client, link, parts, name)
    return parts


def _part(client: int, link: tuple[int, int], k: int, row: Any, fixed: bool, name: str) -> Part:
    kind, size, place, turn = row[2], row[3], np.array(row[5], float), rotation(row[6])
    if kind == pybullet.GEOM_MESH:
        line, mesh, place, turn = "", *_mesh(client, link, k, row, name)
    elif kind == pybullet.GEOM_SPHERE:
        line, mesh = f'shape = "sphere:{size[0]:.9g}"', ball(np.full(3, size[0]))
    elif kind == pybullet.GEOM_BOX:
        if fixed and sorted(size)[1] >= _FLOOR:
            return _floor(client, link, place, turn, np.array(size, float))
        line = 'shape = "box:' + "x".join(f"{s:.9g}" for s in size) + '"'
        mesh = box(0.5 * np.array(size, float))
    elif kind == pybullet.GEOM_CYLINDER:
        line, mesh = f'shape = "cylinder:{size[1]:.9g}x{size[0]:.9g}"', cylinder(size[1], 0.5 * size[0])
        return Part(line, mesh, place, turn, turn @ AXIS_Y_TO_Z)
    elif kind == pybullet.GEOM_CAPSULE:
        line, mesh = "", capsule(size[1], 0.5 * size[0])
    elif kind == pybullet.GEOM_PLANE:
        return _plane(place, turn @ np.array(size, float))
    else:
        raise ValueError(f"{name}: shapes of kind {kind} cannot be recorded")
    return Part(line, mesh, place, turn, turn)


def _floor(client: int, link: tuple[int, int], place: Floats, turn: Floats, size: Floats) -> Part:
    """A plane at the upper face of a box."""
    upright = rotation(_pose(client, link)[1]) @ turn
    k = int(np.abs(upright[2]).argmax())
    normal = turn[:, k] * np.sign(upright[2, k])
    return _plane(place + 0.5 * size[k] * normal, normal)


def _plane(point: Floats, normal: Floats) -> Part:
    """A plane; z of its axes is the normal."""
    across = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
    across /= np.linalg.norm(across)
    axes = np.stack([across, np.cross(normal, across), normal], axis=1)
    return Part("", box(np.ones(3)), point, axes, axes, True)


def _mesh(
    client: int, link: tuple[int, int], k: int, row: Any, name: str
) -> tuple[Triangles, Floats, Floats]:
    """The surface of a mesh, its place and axes in the inertial frame."""
    try:
        points = pybullet.getMeshData(*link, collisionShapeIndex=k, physicsClientId=client)[1]
    except pybullet.error:
        points = ()
    file = Path(row[4].decode())
    objects = _objects(file) if file.suffix.lower() == ".obj" and file.is_file() else []
    scale = np.array(row[3], float)
    if not points and objects:
        vertices, faces = objects[0][0], np.concatenate([faces for _, faces in objects])
        return (vertices * scale, faces), np.array(row[5], float), rotation(row[6])
    if len(objects) > 1:
        hulls = [hull(v[np.unique(f)] * scale, name) for v, f in objects]
        return union(hulls, name), np.array(row[5], float), rotation(row[6])
    if len(points) < 4:
        raise ValueError(f"{name}: PyBullet gives no surface of its mesh")
    return hull(np.array(points, float), name), np.zeros(3), np.eye(3)


def _objects(file: Path) -> list[Triangles]:
    """All vertices of an OBJ file, with the triangles of each of its objects or groups."""
    vertices: list[list[float]] = []
    groups: list[list[tuple[int, int, int]]] = [[]]
    for line in file.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] in (["o"], ["g"]):
            groups.append([])
        elif words[:1] == ["f"]:
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            corners = [n - 1 if n > 0 else len(vertices) + n for n in numbers]
            groups[-1] += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    return [(np.array(vertices), np.array(faces)) for faces in groups if faces]


def _pose(client: int, link: tuple[int, int]) -> tuple[Any, Any]:
    if link[1] < 0:
        return pybullet.getBasePositionAndOrientation(link[0], client)  # type: ignore[no-any-return]
    state = pybullet.getLinkState(*link, computeForwardKinematics=1, physicsClientId=client)
    return state[0], state[1]


def _check_whole(client: int, link: tuple[int, int], parts: list[Part], name: str) -> None:
    """Compares the box about the parts with Bullet's: PyBullet does not give all of some meshes."""
    points = np.concatenate([part.triangles()[0] for part in parts])
    lower, upper = points.min(axis=0), points.max(axis=0)
    place, turn = _pose(client, link)
    found = np.abs(rotation(turn)) @ (upper - lower)
    low, high = pybullet.getAABB(*link, client)
    theirs = np.array(high) - np.array(low)
    if (theirs > found * (1.0 + _WHOLE) + _MARGIN).any():
        sizes = np.round(found, 4).tolist(), np.round(theirs, 4).tolist()
        text = f"PyBullet gives {sizes[0]} m of its mesh of {sizes[1]} m; load it from a URDF"
        raise ValueError(f"{name}: {text}")
