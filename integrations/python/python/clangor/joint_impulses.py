"""Impulses of the joints between links, from the motion of the links, for all simulators.

For every link and step, P = m dv - (contact impulses) - m g dt + sum of P of the links that hang on it:
what the parent gave it through the joint, whether by constraint, motor, spring or damping. P of a body on
no joint is 0 up to the error of integration, which is its ledger. Couples of joints are not computed.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass

import numpy as np

from .recording import Floats, Impact

__all__ = ["Joints", "Link"]


@dataclass
class Link:
    """A moving body; `parent` is the key of what it is joined to, which may not move."""

    key: Hashable
    parent: Hashable
    mass: float
    free: bool


class Joints:
    """The joints of `links`, parents first; `there` is false if all are free.

    `names` are those of the recorded bodies. `velocity` gives that of the centre of mass [m/s] and `anchor`
    the place [m] of the joint of a link.
    """

    def __init__(
        self,
        links: list[Link],
        names: Mapping[Hashable, str],
        velocity: Callable[[Hashable], Floats],
        anchor: Callable[[Hashable], Floats],
    ) -> None:
        self._links, self._names = links, dict(names)
        self._velocity, self._anchor = velocity, anchor
        self.there = any(not link.free for link in links)
        self._parent = {link.key: link.parent for link in links}
        self._before: dict[Hashable, Floats] = {}
        self._anchors: dict[Hashable, Floats] = {}

    def start(self) -> None:
        """Takes the state at the start of a step."""
        self._before = {link.key: self._velocity(link.key) for link in self._links}
        self._anchors = {link.key: self._anchor(link.key) for link in self._links if not link.free}

    def finish(
        self, time: float, step: float, given: Mapping[str, Floats], gravity: Floats
    ) -> tuple[list[Impact], dict[str, Floats]]:
        """Rows of all joints, and what is left of the momentum of bodies on no joint [N s]."""
        pull = {link.key: np.zeros(3) for link in self._links}
        rows: list[Impact] = []
        left = {name: np.zeros(3) for name in given}
        for link in reversed(self._links):
            key, name = link.key, self._names.get(link.key, "")
            change = self._velocity(key) - self._before[key]
            pull[key] += link.mass * (change - gravity * step) - given.get(name, np.zeros(3))
            if link.free:
                left.update({name: pull[key]} if name else {})
                continue
            if link.parent in pull:
                pull[link.parent] += pull[key]
            if name:
                far, at, zero = self._recorded(link.parent), self._anchors[key], np.zeros(3)
                rows.append(Impact(time, name, far, at, zero, pull[key], zero, step, joint=True))
        return rows, left

    def _recorded(self, key: Hashable) -> str:
        """Name of the nearest recorded body on the way to the world, or of none."""
        while key in self._parent and key not in self._names:
            key = self._parent[key]
        return self._names.get(key, "")
