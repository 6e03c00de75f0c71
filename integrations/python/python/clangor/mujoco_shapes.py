"""Surfaces of MuJoCo's geoms as shapes of a scene file, or as OBJ files for those that the format has not.

Spheres, boxes, ellipsoids and cylinders are shapes; capsules and meshes become OBJ files; several geoms of
one body become the union of their solids. A mesh that is not one closed surface is its convex hull, as it is
in collisions. Axes are those of the geom, or of the body for a union. Height fields and distance fields have
no closed surface here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .recording import Floats
from .surfaces import Triangles, ball, box, capsule, closed, cylinder, union, write_obj

__all__ = ["geom_surface", "union_surface"]

_TYPES = mujoco.mjtGeom


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
) -> str:
    """The line of a scene file for the union of geoms (number, place [m], rotation)."""
    meshes = []
    for g, place, turn in placed:
        vertices, faces = _triangles(model, g, name)
        meshes.append((vertices @ turn.T + place, faces))
    return write_obj(folder / f"body-{placed[0][0]}.obj", union(meshes, f"body {name!r}"))


def _triangles(model: Any, g: int, name: str) -> Triangles:
    kind, size = model.geom_type[g], model.geom_size[g]
    if kind == _TYPES.mjGEOM_MESH:
        k = model.geom_dataid[g]
        vertices = model.mesh_vert[model.mesh_vertadr[k] :][: model.mesh_vertnum[k]]
        faces = model.mesh_face[model.mesh_faceadr[k] :][: model.mesh_facenum[k]]
        return closed((np.array(vertices, float), np.array(faces)), f"body {name!r}")
    if kind == _TYPES.mjGEOM_BOX:
        return box(size)
    if kind == _TYPES.mjGEOM_SPHERE:
        return ball(np.full(3, size[0]))
    if kind == _TYPES.mjGEOM_ELLIPSOID:
        return ball(size)
    if kind == _TYPES.mjGEOM_CYLINDER:
        return cylinder(size[0], size[1])
    if kind == _TYPES.mjGEOM_CAPSULE:
        return capsule(size[0], size[1])
    raise ValueError(f"geom {name!r}: height fields and distance fields cannot be recorded")
