"""Impulses of the joints between the links of a MuJoCo model, from the motion of the links.

For every link and step, P = m dv - (contact impulses) - m g dt + sum of P of the links that hang on it:
what the parent gave it through the joint, whether by constraint, motor or spring. P of a body on a free
joint is 0 up to the error of integration, which is its ledger. Couples of joints are not computed.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .mujoco_bodies import Bodies
from .recorded_run import State
from .recording import Floats, Impact

__all__ = ["Joints"]


class Joints:
    """The joints of `bodies`; `there` is false if all bodies are free."""

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = bodies
        self._links = bodies.links()
        self.there = any(not bodies.free(body.root) for body, _ in self._links)
        self._parent = {body.root: parent for body, parent in self._links}
        self._names = {body.root: body.name for body, _ in self._links if body.name}
        self._before: dict[int, State] = {}
        self._anchors: dict[int, Floats] = {}

    def start(self) -> None:
        """Takes the state at the start of a step."""
        self._before = {body.root: self._bodies.state(body) for body, _ in self._links}
        self._anchors = {body.root: self._bodies.anchor(body.root) for body, _ in self._links}

    def finish(
        self, time: float, step: float, given: Mapping[str, Floats], gravity: Floats
    ) -> tuple[list[Impact], dict[str, Floats]]:
        """Rows of all joints, and what is left of the momentum of bodies on free joints [N s]."""
        pull = {root: np.zeros(3) for root in self._parent}
        rows: list[Impact] = []
        left = {name: np.zeros(3) for name in given}
        for body, parent in reversed(self._links):
            root, contacts = body.root, given.get(body.name, np.zeros(3))
            change = self._bodies.state(body).velocity - self._before[root].velocity
            pull[root] += body.mass * (change - gravity * step) - contacts
            if self._bodies.free(root):
                left[body.name] = pull[root]
                continue
            if parent:
                pull[parent] += pull[root]
            if body.name:
                far = self._recorded(parent)
                zero, anchor = np.zeros(3), self._anchors[root]
                rows.append(Impact(time, body.name, far, anchor, zero, pull[root], zero, step, joint=True))
        return rows, left

    def _recorded(self, root: int) -> str:
        """Name of the nearest recorded body on the way to the world, or of none."""
        while root and root not in self._names:
            root = self._parent[root]
        return self._names.get(root, "")
