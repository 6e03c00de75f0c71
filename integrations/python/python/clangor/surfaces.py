"""Closed surfaces of triangles: balls, boxes, capsules, cylinders, hulls and unions, written as OBJ files.

Surfaces of revolution have 48 sides, at most r (1 - cos(pi / 48)) = 0.2 % of the radius inside the round
one. The centre is that of the solid, sum of V_i c_i / sum of V_i over the tetrahedra from the origin. Hulls
and unions need the package `manifold3d`. Meshes are not mended here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .recording import Floats

__all__ = ["Triangles", "ball", "box", "capsule", "centroid", "cylinder", "hull", "union", "write_obj"]

_SIDES = 48
Triangles = tuple[Floats, Any]
"""Vertices (n, 3) [m] and the numbers of the corners of every face (m, 3)."""


def write_obj(path: Path, mesh: Triangles) -> str:
    """Writes an OBJ file and gives the line of the scene file."""
    lines = ["v " + " ".join(f"{x:.9g}" for x in v) for v in mesh[0]]
    lines += ["f " + " ".join(str(int(i) + 1) for i in f) for f in mesh[1]]
    path.write_text("\n".join(lines) + "\n")
    return f'mesh = "{path.name}"'


def ball(radii: Floats) -> Triangles:
    """An ellipsoid of three semi-axes [m]."""
    angles = np.linspace(0.0, np.pi, _SIDES // 2 + 1)[1:-1]
    vertices, faces = _revolved([(np.sin(a), -np.cos(a)) for a in angles], 1.0)
    return vertices * radii, faces


def box(half: Floats) -> Triangles:
    """A box of three half edges [m]."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def cylinder(radius: float, half: float) -> Triangles:
    """A cylinder along z; `half` is half its height [m]."""
    return _revolved([(radius, -half), (radius, half)], half)


def capsule(radius: float, half: float) -> Triangles:
    """A capsule along z; `half` is half the length [m] of its straight part."""
    turns = np.linspace(0.0, np.pi / 2.0, _SIDES // 4 + 1)
    lower = [(radius * np.sin(a), -half - radius * np.cos(a)) for a in turns[1:]]
    upper = [(radius * np.cos(a), half + radius * np.sin(a)) for a in turns[:-1]]
    return _revolved(lower + upper, half + radius)


def union(meshes: list[Triangles], name: str) -> Triangles:
    """The union of closed surfaces. Errors: ValueError names the body if it is not one solid."""
    manifold3d = _manifold3d(name)
    solid = manifold3d.Manifold()
    for vertices, faces in meshes:
        mesh = manifold3d.Mesh64(np.ascontiguousarray(vertices), np.asarray(faces).astype(np.uint64))
        mesh.merge()
        solid += manifold3d.Manifold(mesh)
    if len(solid.decompose()) != 1:
        raise ValueError(f"body {name!r}: its parts do not form one solid")
    return _taken(solid)


def hull(points: Floats, name: str) -> Triangles:
    """The convex hull of points (n, 3) [m]."""
    return _taken(_manifold3d(name).Manifold.hull_points(np.ascontiguousarray(points)))


def _manifold3d(name: str) -> Any:
    try:
        import manifold3d  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise ValueError(f"body {name!r}: its surface needs the package `manifold3d`") from None
    return manifold3d


def _taken(solid: Any) -> Triangles:
    found = solid.to_mesh64()
    return np.array(found.vert_properties)[:, :3], np.array(found.tri_verts).astype(int)


def centroid(mesh: Triangles) -> Floats:
    """Centre of the solid [m]."""
    a, b, c = (mesh[0][mesh[1][:, k].astype(int)] for k in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    centre: Floats = volumes @ (a + b + c) / (4.0 * volumes.sum())
    return centre


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
