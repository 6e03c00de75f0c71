"""Bodies of a PyBullet world: surface, mass, inertia and pose; and the settings under which they bounce.

Bullet moves the inertial frame; its shapes lie in that frame. A mesh collides as the convex hull of its
vertices, which is what is recorded. Two bodies bounce with e = r_a r_b: r of every body is the
least-squares solution of log r_a + log r_b = log e over the pairs of materials. Nothing is computed about
the motion.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .material_pairs import Material, check_material, meetings, pair_restitution
from .recording import BodyShape, Floats
from .surfaces import capsule, centroid, hull, write_obj

__all__ = ["add_body", "hear_as", "pose"]

_CENTRE_ERROR = 1e-3
_AXIS_Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_SETTINGS = {
    "restitutionVelocityThreshold": 0.02,
    "erp": 0.0,
    "contactERP": 0.0,
    "contactBreakingThreshold": 1e-6,
}
"""Contacts are solved when bodies overlap, bounce above 2 cm/s, and overlap is not corrected."""


def pose(client: int, body: int) -> tuple[Floats, Floats]:
    """Place [m] and rotation of the inertial frame."""
    place, turn = pybullet.getBasePositionAndOrientation(body, client)
    return np.array(place), np.array(pybullet.getMatrixFromQuaternion(turn)).reshape(3, 3)


def add_body(
    client: int, body: int, material: Material | None, folder: Path
) -> tuple[BodyShape, Floats, float]:
    """The body, the axes of its shape in the inertial frame, and its bounding radius [m].

    Errors: ValueError names the body.
    """
    name = _title(client, body)
    if pybullet.getNumJoints(body, client):
        raise ValueError(f"{name}: bodies with links cannot be recorded")
    shapes = pybullet.getCollisionShapeData(body, -1, client)
    if len(shapes) != 1:
        raise ValueError(f"{name}: has {len(shapes)} shapes, only bodies of one can be recorded")
    if material is None:
        warnings.warn(f"{name} has no material: steel is taken", stacklevel=4)
        material = "steel"
    check_material(material, f"materials[{body}]")
    dynamics = pybullet.getDynamicsInfo(body, -1, client)
    mass, diagonal = float(dynamics[0]), np.array(dynamics[2])
    surface, axes, centre, reach = _surface(client, body, shapes[0], folder)
    plane = shapes[0][2] == pybullet.GEOM_PLANE
    if not plane and np.linalg.norm(centre) > _CENTRE_ERROR * reach:
        text = f"its centre of mass is {np.round(-centre, 6).tolist()} m from that of its shape"
        raise ValueError(f"{name}: {text}; give baseInertialFramePosition")
    place, turn = pose(client, body)
    shape = BodyShape(f"body-{body}", surface, material, mass, place, turn @ axes, plane)
    shape.inertia = axes.T @ np.diag(diagonal) @ axes if mass > 0.0 else None
    return shape, axes, reach


def _title(client: int, body: int) -> str:
    name = pybullet.getBodyInfo(body, client)[1].decode()
    return f"body {body} ({name})" if name else f"body {body}"


def _surface(client: int, body: int, row: Any, folder: Path) -> tuple[str, Floats, Floats, float]:
    """The line of the scene file, the axes and centre [m] in the inertial frame, the bounding radius [m]."""
    kind, size, centre = row[2], row[3], np.array(row[5])
    axes = np.array(pybullet.getMatrixFromQuaternion(row[6])).reshape(3, 3)
    if kind == pybullet.GEOM_SPHERE:
        return f'shape = "sphere:{size[0]:.9g}"', axes, centre, float(size[0])
    if kind == pybullet.GEOM_BOX:
        sides = "x".join(f"{s:.9g}" for s in size)
        return f'shape = "box:{sides}"', axes, centre, 0.5 * float(np.linalg.norm(size))
    if kind == pybullet.GEOM_PLANE:
        return "", axes, centre, 1.0
    height, radius = float(size[0]), float(size[1])
    if kind == pybullet.GEOM_CYLINDER:
        reach = float(np.hypot(0.5 * height, radius))
        return f'shape = "cylinder:{radius:.9g}x{height:.9g}"', axes @ _AXIS_Y_TO_Z, centre, reach
    target = folder / f"body-{body}.obj"
    if kind == pybullet.GEOM_CAPSULE:
        surface = write_obj(target, capsule(radius, 0.5 * height))
        return surface, axes, centre, 0.5 * height + radius
    if kind != pybullet.GEOM_MESH:
        raise ValueError(f"{_title(client, body)}: shapes of kind {kind} cannot be recorded")
    count, points = pybullet.getMeshData(body, -1, physicsClientId=client)
    if count < 4:
        raise ValueError(f"{_title(client, body)}: its mesh has {count} vertices")
    solid = hull(np.array(points, float), _title(client, body))
    reach = float(np.linalg.norm(solid[0], axis=1).max())
    return write_obj(target, solid), np.eye(3), centroid(solid), reach


def hear_as(client: int, materials: Mapping[int, Material], restitution: float | None = None) -> None:
    """Sets the restitution of every body to that of its material, or of all pairs to `restitution`.

    It also sets the damping of all bodies to 0, the solver's error correction to 0, and lets contacts act
    only when bodies overlap. PyBullet does not give these back, so they stay as set, the overlap for all
    clients of the process. Errors: ValueError for a material that is not known and a restitution outside 0
    to 1.
    """
    if restitution is not None and not 0.0 <= restitution <= 1.0:
        raise ValueError(f"restitution: {restitution} is not between 0 and 1")
    for body, material in materials.items():
        check_material(material, f"materials[{body}]")
    bodies = [pybullet.getBodyUniqueId(k, client) for k in range(pybullet.getNumBodies(client))]
    kinds: list[Material] = []
    kind = []
    for body in bodies:
        material = materials.get(body, "steel")
        if material not in kinds:
            kinds.append(material)
        kind.append(kinds.index(material))
    moving = [float(pybullet.getDynamicsInfo(body, -1, client)[0]) > 0.0 for body in bodies]
    pairs = meetings(kind, moving)
    given = restitution is not None or not pairs
    factors = np.full(len(kinds), (restitution or 0.0) ** 0.5) if given else _factors(kinds, pairs)
    pybullet.setPhysicsEngineParameter(**_SETTINGS, physicsClientId=client)
    for body, k in zip(bodies, kind):
        for link in range(-1, pybullet.getNumJoints(body, client)):
            pybullet.changeDynamics(
                body,
                link,
                restitution=float(factors[k]),
                linearDamping=0.0,
                angularDamping=0.0,
                physicsClientId=client,
            )


def _factors(kinds: list[Material], pairs: list[tuple[int, int]]) -> Floats:
    rows = np.array([[float((k == i) + (k == j)) for k in range(len(kinds))] for i, j in pairs])
    wanted = [max(pair_restitution(kinds[i], kinds[j]), 1e-3) for i, j in pairs]
    found: Floats = np.exp(np.linalg.lstsq(rows, np.log(wanted), rcond=None)[0])
    return found
