"""What the recorders of all simulators share: the state of a body, the end of a recording, and its sound.

The velocity of a point of a body is v + w x (p - place). No contact is found here.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Union

import numpy as np

from . import Session, Sound
from .impacts import Touches, close_recording
from .material_pairs import Material, warn_of_level
from .recording import Floats, Impact, Recording, cross, open_session

__all__ = ["RecordedRun", "State"]


@dataclass
class State:
    """Place [m] and rotation of the shape, velocities [m/s] of the centre of mass and [rad/s], world."""

    place: Floats
    rotation: Floats
    velocity: Floats
    spin: Floats

    def velocity_at(self, point: Floats) -> Floats:
        """Velocity [m/s] of the point of the body at `point` [m], world."""
        velocity: Floats = self.velocity + cross(self.spin, point - self.place)
        return velocity


class RecordedRun:
    """A run that is recorded step by step, and then heard."""

    recording: Recording

    def __init__(self, approach: float, longest: float) -> None:
        self._touches = Touches(approach, longest)
        self._folder = tempfile.TemporaryDirectory(prefix="clangor-")
        self._material: dict[str, Material] = {}
        self._stopped = self._compared = False

    def _check_running(self) -> None:
        if self._stopped:
            raise RuntimeError("step: the recorder was stopped")

    def _keep(self, impacts: list[Impact], state_after: Callable[[str], State | None]) -> None:
        """Keeps impacts that are over; the first is compared with the restitution of its materials."""
        self.recording.impacts += impacts
        if not impacts or self._compared:
            return
        first, self._compared = impacts[0], True
        states = [state_after(name) for name in (first.a, first.b)]
        ends = [np.zeros(3) if state is None else state.velocity_at(first.point) for state in states]
        speed = -float(first.velocity @ first.normal)
        bounce = float((ends[0] - ends[1]) @ first.normal) / speed
        pair = self._material[first.a], self._material[first.b]
        warn_of_level(pair, speed, bounce, f"{first.a!r} on {first.b!r}")

    def stop(self) -> None:
        """Ends the recording: open impacts are closed, carried weight is taken off. May be repeated."""
        if self._stopped:
            return
        self._stopped = True
        close_recording(self.recording, self._touches)

    def session(self, listener: Sequence[float] = (0.3, 0.3, 0.4)) -> Session:
        """A session that renders what was recorded; `listener` is a place (3,) [m], z up."""
        self.stop()
        return open_session(self.recording, self._folder, listener, keep=True)

    def render(
        self, output: Union[str, PathLike[str], None] = None, listener: Sequence[float] = (0.3, 0.3, 0.4)
    ) -> list[Sound]:
        """The sound at `listener` [m], z up; written to `output` if it is given."""
        self.stop()
        return open_session(self.recording, self._folder, listener, keep=False).render(output)
