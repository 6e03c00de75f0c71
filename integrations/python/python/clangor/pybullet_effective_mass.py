"""Effective mass of two bodies of PyBullet at a contact, where one of them is on joints.

1/m = n^T J M^-1 J^T n. Of links, M and J are Bullet's, in the axes of the base, for the angles at the start
of the step; a base that moves comes first, with its three rotations and three translations. Of a body on no
joint, 1/m = 1/M + (r x n)^T I^-1 (r x n). Bodies with spherical and planar joints have none, and
`createConstraint` does not count. No force is computed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .pybullet_bodies import Bodies, RigidBody
from .recorded_run import State
from .recording import Floats, cross

__all__ = ["EffectiveMasses"]

_SIMPLE = (pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC, pybullet.JOINT_FIXED)


class EffectiveMasses:
    """The effective masses of `bodies` at the start of a step."""

    def __init__(self, client: int, bodies: Bodies) -> None:
        self.client, self._bodies = client, bodies
        self._inertia = {shape.name: shape.inertia for shape in bodies.shapes}
        self._mass = {shape.name: shape.mass for shape in bodies.shapes}
        self._joints: dict[int, list[int]] = {}
        """Numbers of the joints that move, of bodies that have any."""
        self._unknown: set[int] = set()
        for body in sorted({group.key[0] for group in bodies.bodies}):
            joints = range(pybullet.getNumJoints(body, client))
            rows = [pybullet.getJointInfo(body, k, client) for k in joints]
            moving = [int(row[0]) for row in rows if row[2] != pybullet.JOINT_FIXED]
            if moving:
                self._joints[body] = moving
            if any(row[2] not in _SIMPLE for row in rows):
                self._unknown.add(body)
        self._angles: dict[int, list[float]] = {}
        self._anchors: dict[tuple[int, int], Floats] = {}
        self._bases: dict[int, tuple[Floats, Floats]] = {}

    def start(self) -> None:
        """Takes the angles and places of all joints."""
        for body, joints in self._joints.items():
            rows = pybullet.getJointStates(body, joints, physicsClientId=self.client)
            self._angles[body] = [float(row[0]) for row in rows]
            self._bases[body] = self._bodies.base(body)
        self._anchors = self._bodies.anchors()

    def of(
        self, pair: tuple[RigidBody, RigidBody], point: Floats, normal: Floats, states: Mapping[str, State]
    ) -> float | None:
        """Effective mass [kg] of two bodies along `normal` at `point` [m]; None if both are on no joint.

        `states` are those at the start of the step.
        """
        numbers = {group.key[0] for group in pair}
        if not numbers & set(self._joints) or numbers & self._unknown:
            return None
        inverse = 0.0
        for number in numbers:
            mine = [(group, sign) for group, sign in zip(pair, (1.0, -1.0)) if group.key[0] == number]
            if number in self._joints:
                inverse += self._of_links(number, mine, point, normal)
            elif mine[0][0].moving:
                inverse += self._alone(mine[0][0].name, point, normal, states)
        return 1.0 / inverse if inverse > 0.0 else None

    def _of_links(
        self, body: int, links: list[tuple[RigidBody, float]], point: Floats, normal: Floats
    ) -> float:
        """1/m [1/kg] of links of one body, each with its sign, against each other or against others."""
        angles, (place, turn) = self._angles[body], self._bases[body]
        matrix = np.array(pybullet.calculateMassMatrix(body, angles, physicsClientId=self.client))
        along = np.zeros(len(matrix))
        for group, sign in links:
            along += sign * self._row(group, turn.T @ (point - place), turn.T @ normal, len(matrix))
        return float(along @ np.linalg.solve(matrix, along))

    def _row(self, group: RigidBody, point: Floats, normal: Floats, freedoms: int) -> Floats:
        """n^T J of a link, at a point and along a normal in the frame of its base."""
        (body, link), row = group.key, np.zeros(freedoms)
        if link < 0:
            if group.moving:
                row[:3], row[3:6] = cross(point, normal), normal
            return row
        angles, zeros = self._angles[body], [0.0] * len(self._angles[body])
        options: dict[str, Any] = dict(physicsClientId=self.client)
        pair = pybullet.calculateJacobian(body, link, [0.0] * 3, angles, zeros, zeros, **options)
        place, turn = self._bases[body]
        arm = point - turn.T @ (self._anchors[body, link] - place)
        found: Floats = normal @ np.array(pair[0]) + cross(arm, normal) @ np.array(pair[1])
        return found

    def _alone(self, name: str, point: Floats, normal: Floats, states: Mapping[str, State]) -> float:
        """1/m [1/kg] of a body on no joint; a body whose inertia is singular does not turn."""
        state, inertia, mass = states[name], self._inertia[name], self._mass[name]
        arm = state.rotation.T @ cross(point - state.place, normal)
        if inertia is None or not np.linalg.eigvalsh(inertia)[0] > 0.0:
            return 1.0 / mass
        return float(1.0 / mass + arm @ np.linalg.solve(inertia, arm))
