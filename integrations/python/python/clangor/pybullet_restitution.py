"""Settings under which the bodies of a PyBullet world bounce as their materials do.

Two bodies bounce with e = r_a r_b: r of every body is the least-squares solution of
log r_a + log r_b = log e over the pairs of materials. Nothing is computed about the motion.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .material_pairs import Material, check_material, meetings, pair_restitution
from .pybullet_bodies import Key, body_numbers, check_keys, link_material, moves
from .recording import Floats

__all__ = ["hear_as"]

_SETTINGS = {
    "restitutionVelocityThreshold": 0.02,
    "erp": 0.0,
    "contactERP": 0.0,
    "contactBreakingThreshold": 1e-6,
}
"""Contacts are solved when bodies overlap, bounce above 2 cm/s, and overlap is not corrected."""


def hear_as(client: int, materials: Mapping[Key, Material], restitution: float | None = None) -> None:
    """Sets the restitution of every link to that of its material, or of all pairs to `restitution`.

    It also sets the damping of all bodies to 0, the solver's error correction to 0, and lets contacts act
    only when bodies overlap. PyBullet does not give these back, so they stay as set, the overlap for all
    clients of the process. Damping of joints is left. Errors: ValueError for a body or material that is not
    known and a restitution outside 0 to 1.
    """
    if restitution is not None and not 0.0 <= restitution <= 1.0:
        raise ValueError(f"restitution: {restitution} is not between 0 and 1")
    check_keys(client, materials)
    kinds: list[Material] = []
    kind: dict[tuple[int, int], int] = {}
    moving: dict[tuple[int, int], bool] = {}
    for body in body_numbers(client):
        for link in range(-1, pybullet.getNumJoints(body, client)):
            material = link_material(materials, body, [link]) or "steel"
            if material not in kinds:
                kinds.append(material)
            k = kind[body, link] = kinds.index(material)
            moving[body, k] = moving.get((body, k), False) or moves(client, body, link)
    pairs = meetings([k for _, k in moving], list(moving.values()))
    given = restitution is not None or not pairs
    factors = np.full(len(kinds), (restitution or 0.0) ** 0.5) if given else _factors(kinds, pairs)
    pybullet.setPhysicsEngineParameter(**_SETTINGS, physicsClientId=client)
    still = dict(linearDamping=0.0, angularDamping=0.0, physicsClientId=client)
    for (body, link), k in kind.items():
        pybullet.changeDynamics(body, link, restitution=float(factors[k]), **still)


def _factors(kinds: list[Material], pairs: list[tuple[int, int]]) -> Floats:
    rows = np.array([[float((k == i) + (k == j)) for k in range(len(kinds))] for i, j in pairs])
    wanted = [max(pair_restitution(kinds[i], kinds[j]), 1e-3) for i, j in pairs]
    found: Floats = np.exp(np.linalg.lstsq(rows, np.log(wanted), rcond=None)[0])
    return found
