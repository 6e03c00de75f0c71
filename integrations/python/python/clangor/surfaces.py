"""Closed surfaces of triangles: balls, boxes, capsules, cylinders, hulls and unions, written as OBJ files.

Surfaces of revolution have 48 sides, at most r (1 - cos(pi / 48)) = 0.2 % of the radius inside the round
one. Parts of one body that leave gaps are joined, since a body is one solid. Hulls and unions need
the package `manifold3d`. Meshes are not mended here.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from .recording import Floats

__all__ = [
    "AXIS_Y_TO_Z",
    "Triangles",
    "ball",
    "box",
    "capsule",
    "closed",
    "cylinder",
    "hull",
    "off_centre",
    "union",
    "write_obj",
]

AXIS_Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Turns the axis of a shape of revolution, y, into that of simulators, z."""
_SIDES = 48
_APART = 5e-4
"""Share of the least extent by which parts grow, each by another one: none touch in a line or point."""
_TOUCH = 0.02
"""Gap of parts that touch, as a share of the least extent of the smaller one."""
_CENTRE = 1e-6
"""Distance of the centre of mass from that of a shape, over the bounding radius, that is rounding."""
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
    """The union of solids; an open surface is taken as its convex hull.

    Solids that just touch are made one. Wider gaps are bridged by bars, with a warning. Errors: ValueError
    names the body.
    """
    manifold3d = _manifold3d(name)
    solid = manifold3d.Manifold()
    for k, mesh in enumerate(meshes):
        part = _solid(manifold3d, mesh) or manifold3d.Manifold.hull_points(np.ascontiguousarray(mesh[0]))
        solid += _swollen(part, _APART * (1.0 + k / len(meshes))) if not part.is_empty() else part
    pieces = sorted(solid.decompose(), key=lambda piece: -float(piece.volume()))
    if not pieces:
        raise ValueError(f"{name}: its surface has no volume")
    whole, bars = pieces.pop(0), 0
    while pieces:
        gaps = [float(whole.min_gap(piece, _extents(whole + piece).sum())) for piece in pieces]
        part = pieces.pop(int(np.argmin(gaps)))
        grown = whole + _swollen(part, 2.0 * _APART, min(gaps))
        if min(gaps) > _TOUCH * _extents(part).min() or len(grown.decompose()) > 1:
            grown, bars = whole + part + _bar(manifold3d, whole, part, min(gaps)), bars + 1
        whole = grown
    if bars:
        warnings.warn(f"{name}: {bars} of its parts do not touch the others; bars join them", stacklevel=7)
    return _taken(whole)


def _swollen(part: Any, share: float, gap: float = 0.0) -> Any:
    """The part, larger by a share of its least extent and a gap [m] on all sides."""
    extents, around = _extents(part), np.array(part.bounding_box()).reshape(2, 3)
    centre, factors = around.mean(axis=0), 1.0 + 2.0 * (gap + share * extents.min()) / extents
    return part.translate(tuple(-centre)).scale(tuple(factors)).translate(tuple(centre))


def _extents(solid: Any) -> Floats:
    extents: Floats = np.ptp(np.array(solid.bounding_box()).reshape(2, 3), axis=0)
    return extents


def _bar(manifold3d: Any, whole: Any, part: Any, gap: float) -> Any:
    """A round bar across a gap [m]; its radius is a quarter of the least extent of the part."""
    extents, around = _extents(part), np.array(part.bounding_box()).reshape(2, 3)
    margin = gap + 0.01 * extents.max()
    window = manifold3d.Manifold.cube(tuple(extents + 2.0 * margin)).translate(tuple(around[0] - margin))
    a, b = (_taken(solid.refine_to_length(extents.max() / 8.0))[0] for solid in (whole ^ window, part))
    away = np.linalg.norm(a[:, None] - b, axis=2)
    ends = np.unravel_index(away.argmin(), away.shape)
    radius = 0.25 * float(extents.min())
    balls = [manifold3d.Manifold.sphere(radius, 16).translate(tuple(p[k])) for p, k in zip((a, b), ends)]
    return manifold3d.Manifold.batch_hull(balls)


def hull(points: Floats, name: str) -> Triangles:
    """The convex hull of points (n, 3) [m]. Errors: ValueError names the body if they are in one plane."""
    found = _manifold3d(name).Manifold.hull_points(np.ascontiguousarray(points))
    if found.is_empty() or found.volume() < 1e-9 * _extents(found).max() ** 3:
        raise ValueError(f"{name}: its surface has no volume")
    return _taken(found)


def closed(mesh: Triangles, name: str) -> Triangles:
    """The mesh if it is one closed surface, else its convex hull."""
    try:
        manifold3d = _manifold3d(name)
    except ValueError:
        return mesh
    solid = _solid(manifold3d, mesh)
    return mesh if solid is not None and len(solid.decompose()) == 1 else hull(mesh[0], name)


def off_centre(surface: str, centre: Floats | None, reach: float) -> Floats | None:
    """The centre of mass [m] in the coordinates of a shape or mesh, where it is not that of a shape."""
    shape = surface.startswith("shape")
    return None if centre is None or (shape and np.linalg.norm(centre) < _CENTRE * reach) else centre


def _solid(manifold3d: Any, mesh: Triangles) -> Any:
    """The solid of a closed surface, or None."""
    made = manifold3d.Mesh64(np.ascontiguousarray(mesh[0]), np.asarray(mesh[1]).astype(np.uint64))
    made.merge()
    solid = manifold3d.Manifold(made)
    return solid if not solid.is_empty() and solid.volume() > 0.0 else None


def _manifold3d(name: str) -> Any:
    try:
        import manifold3d  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        raise ValueError(f"{name}: its surface needs the package `manifold3d`") from None
    return manifold3d


def _taken(solid: Any) -> Triangles:
    found = solid.to_mesh64()
    return np.array(found.vert_properties)[:, :3], np.array(found.tri_verts).astype(int)


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
