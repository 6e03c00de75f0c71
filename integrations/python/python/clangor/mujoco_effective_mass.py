"""Effective mass of two bodies of MuJoCo at a contact, where one of them is on joints.

1/m = n^T J M^-1 J^T n, with the mass matrix M of all joints and the Jacobian J of the velocity of one body
against the other at the point. M has the armature of the joints: a rotor behind a gear is heavy. Equality
constraints, limits and friction of joints are not in M. No force is computed here.
"""

from __future__ import annotations

from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .recording import Floats

__all__ = ["effective_mass", "on_joints"]

_make_mass_matrix = getattr(mujoco, "mj_makeM", mujoco.mj_crb)
"""Armature of tendons is in `mj_makeM`, which earlier versions of MuJoCo have not."""


def on_joints(model: Any) -> list[bool]:
    """Of each body, whether joints move it, other than a free joint of it alone."""
    freedoms = np.bincount(model.body_rootid, model.body_dofnum, model.nbody)
    found = []
    for body in range(model.nbody):
        root, welded = int(model.body_rootid[body]), int(model.body_weldid[body])
        joint = int(model.body_jntadr[root])
        free = joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
        alone = free and model.body_jntnum[root] == 1 and freedoms[root] == 6
        found.append(bool(welded != 0 and not alone))
    return found


def effective_mass(
    model: Any, data: Any, bodies: tuple[int, int], point: Floats, normal: Floats
) -> float | None:
    """Effective mass [kg] of two bodies along `normal` at `point` [m]; None if no force moves them there.

    `data` has positions of all bodies and inertias (`mj_kinematics`, `mj_comPos`); its mass matrix is
    written.
    """
    rows = np.zeros((2, 3, model.nv))
    for row, body in zip(rows, bodies):
        mujoco.mj_jac(model, data, row, None, point, body)
    along = np.ascontiguousarray((normal @ (rows[0] - rows[1]))[None, :])
    answer = np.zeros_like(along)
    _make_mass_matrix(model, data)
    mujoco.mj_factorM(model, data)
    mujoco.mj_solveM(model, data, answer, along)
    inverse = float(along[0] @ answer[0])
    return 1.0 / inverse if inverse > 0.0 else None
