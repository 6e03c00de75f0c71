"""Surfaces of MuJoCo's geoms as shapes of a scene file, or as OBJ files for those that the format has not.

Spheres, boxes, ellipsoids and cylinders are shapes; capsules are surfaces of revolution with 48 sides (0.2
% of the radius off at most); several geoms of one body become the union of their solids, for which the
package `manifold3d` is needed. Nothing is moved: the axes are those of the geom, or of the body for a
union.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .recording import Floats

__all__ = ["AXIS_Y_TO_Z", "geom_surface", "union_surface", "write_obj"]

AXIS_Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Turns the axis of a shape of revolution, y, into MuJoCo's, z."""

_SIDES = 48
_TYPES = mujoco.mjtGeom
Triangles = tuple[Floats, Any]


def write_obj(path: Path, mesh: Triangles) -> str:
    """Writes an OBJ file and gives the line of the scene file."""
    lines = ["v " + " ".join(f"{x:.9g}" for x in v) for v in mesh[0]]
    lines += ["f " + " ".join(str(int(i) + 1) for i in f) for f in mesh[1]]
    path.write_text("\n".join(lines) + "\n")
    return f'mesh = "{path.name}"'


def geom_surface(model: Any, g: int, name: str, folder: Path) -> str:
    """The line of a scene file for geom `g`. Errors: ValueError for height fields and distance fields."""
    kind, size = model.geom_type[g], model.geom_size[g]
    if kind == _TYPES.mjGEOM_SPHERE:
        return f'shape = "sphere:{size[0]:.9g}"'
    if kind == _TYPES.mjGEOM_BOX:
        return 'shape = "box:' + "x".join(f"{2.0 * s:.9g}" for s in size) + '"'
    if kind == _TYPES.mjGEOM_ELLIPSOID:
        return 'shape = "ellipsoid:' + "x".join(f"{s:.9g}" for s in size) + '"'
    if kind == _TYPES.mjGEOM_CYLINDER:
        return f'shape = "cylinder:{size[0]:.9g}x{2.0 * size[1]:.9g}"'
    return write_obj(folder / f"geom-{g}.obj", _triangles(model, g, name))


def union_surface(
    model: Any, placed: list[tuple[int, Floats, Floats]], name: str, folder: Path
) -> tuple[str, Floats]:
    """The union of geoms (number, place [m], rotation), and its centre [m].

    Errors: ValueError if it is not one solid.
    """
    try:
        import manifold3d  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise ValueError(f"body {name!r}: has several geoms; their union needs `manifold3d`") from None
    solid = manifold3d.Manifold()
    for g, place, turn in placed:
        vertices, faces = _triangles(model, g, name)
        mesh = manifold3d.Mesh64(np.ascontiguousarray(vertices @ turn.T + place), faces.astype(np.uint64))
        mesh.merge()
        solid += manifold3d.Manifold(mesh)
    if len(solid.decompose()) != 1:
        raise ValueError(f"body {name!r}: its geoms do not form one solid")
    found = solid.to_mesh64()
    triangles = np.array(found.vert_properties)[:, :3], np.array(found.tri_verts)
    return write_obj(folder / f"body-{placed[0][0]}.obj", triangles), _centroid(triangles)


def _centroid(mesh: Triangles) -> Floats:
    """Centre of the solid: sum of the signed tetrahedra from the origin."""
    a, b, c = (mesh[0][mesh[1][:, k].astype(int)] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    centre: Floats = volumes @ (a + b + c) / (4.0 * volumes.sum())
    return centre


def _triangles(model: Any, g: int, name: str) -> Triangles:
    kind, size = model.geom_type[g], model.geom_size[g]
    if kind == _TYPES.mjGEOM_MESH:
        k = model.geom_dataid[g]
        vertices = model.mesh_vert[model.mesh_vertadr[k] :][: model.mesh_vertnum[k]]
        faces = model.mesh_face[model.mesh_faceadr[k] :][: model.mesh_facenum[k]]
        return np.array(vertices, float), np.array(faces)
    if kind == _TYPES.mjGEOM_BOX:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    turns = np.linspace(0.0, np.pi / 2.0, _SIDES // 4 + 1)
    if kind == _TYPES.mjGEOM_SPHERE or kind == _TYPES.mjGEOM_ELLIPSOID:
        radii = size if kind == _TYPES.mjGEOM_ELLIPSOID else np.full(3, size[0])
        angles = np.linspace(0.0, np.pi, _SIDES // 2 + 1)[1:-1]
        vertices, faces = _revolved([(np.sin(a), -np.cos(a)) for a in angles], 1.0)
        return vertices * radii, faces
    if kind == _TYPES.mjGEOM_CYLINDER:
        return _revolved([(size[0], -size[1]), (size[0], size[1])], size[1])
    if kind == _TYPES.mjGEOM_CAPSULE:
        r, h = size[0], size[1]
        lower = [(r * np.sin(a), -h - r * np.cos(a)) for a in turns[1:]]
        upper = [(r * np.cos(a), h + r * np.sin(a)) for a in turns[:-1]]
        return _revolved(lower + upper, h + r)
    raise ValueError(f"geom {name!r}: height fields and distance fields cannot be recorded")


def _revolved(profile: list[tuple[float, float]], top: float) -> Triangles:
    """A closed surface about z: rings (radius, z) from bottom to top, and poles at -top and +top."""
    phi = np.arange(_SIDES) * 2.0 * np.pi / _SIDES
    rings = [np.stack([r * np.cos(phi), r * np.sin(phi), np.full(_SIDES, z)], axis=1) for r, z in profile]
    vertices = np.concatenate([*rings, [[0.0, 0.0, -top], [0.0, 0.0, top]]])
    bottom, last, faces = len(rings) * _SIDES, (len(rings) - 1) * _SIDES, []
    for k in range(_SIDES):
        n = (k + 1) % _SIDES
        faces.append((bottom, n, k))
        for ring in range(0, last, _SIDES):
            faces.append((ring + k, ring + n, ring + _SIDES + n))
            faces.append((ring + k, ring + _SIDES + n, ring + _SIDES + k))
        faces.append((last + k, last + n, bottom + 1))
    return vertices, np.array(faces)
