"""What the recorders of all simulators share: states, the ledger, the end of a recording, and its sound.

The velocity of a point of a body is v + w x (p - place). The ledger of a body is what a step leaves of
sum of J + m g dt - m dv. No contact is found here.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Union

import numpy as np

from . import Session, Sound
from .impacts import Load, Touches, close_recording
from .joint_impulses import Joints
from .material_pairs import Material, warn_of_level
from .recording import Floats, Impact, Recording, cross, open_session

__all__ = ["Push", "RecordedRun", "State"]


@dataclass
class Push:
    """Impulse [N s] of one contact on `a`, which moves, at a point [m]; the normal points to it from `b`.

    `mass` [kg] is the effective mass of both along the normal, where one is on joints.
    """

    a: str
    b: str
    point: Floats
    normal: Floats
    impulse: Floats
    mass: float | None = None


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
    _joints: Joints
    _reach: Mapping[str, float]
    """Bounding radius [m] of every body."""

    def __init__(self, approach: float, longest: float) -> None:
        self._touches = Touches(approach, longest)
        self._folder = tempfile.TemporaryDirectory(prefix="clangor-")
        self._material: dict[str, Material] = {}
        self._stopped = self._compared = False
        self.ledger: list[tuple[float, str, float, float]] = []
        """Per step and moving body: time [s], name, |sum of J + m g dt - m dv| and |m dv| [N s].

        With joints, J holds their impulses, and only bodies on no joint leave a difference.
        """

    def _check_running(self) -> None:
        if self._stopped:
            raise RuntimeError("step: the recorder was stopped")

    def _add_step(
        self, time: float, pushes: list[Push], before: Mapping[str, State], after: Mapping[str, State]
    ) -> None:
        """Keeps poses, loads, joints and the ledger of a step; `after` holds the bodies that move."""
        dt, gravity = self.recording.step, self.recording.gravity
        mass = {body.name: body.mass for body in self.recording.bodies}
        total = {name: np.zeros(3) for name in after}
        for name in after:
            s = before[name]
            self.recording.poses.append((time, name, s.place, s.rotation, s.velocity, s.spin))
        for push in pushes:
            for name, sign in ((push.a, 1.0), (push.b, -1.0)):
                if name in total:
                    total[name] = total[name] + sign * push.impulse
        loading = [push for push in pushes if push.a != push.b and float(push.impulse @ push.normal) > 0.0]
        self._touches.step([self._load(push, time, before, mass[push.a]) for push in loading])
        self._keep(self._touches.closed, after)
        change = {name: mass[name] * (after[name].velocity - before[name].velocity) for name in after}
        rest = {name: total[name] + mass[name] * gravity * dt - change[name] for name in after}
        if self._joints.there:
            rows, rest = self._joints.finish(time, dt, total, gravity)
            self._touches.lasting += rows
        for name in after:
            sizes = float(np.linalg.norm(rest[name])), float(np.linalg.norm(change[name]))
            self.ledger.append((time, name, *sizes))

    def _may_begin(self, push: Push, before: Mapping[str, State]) -> bool:
        """Whether an impact may begin with this load, by its speed of approach."""
        speed = before[push.a].velocity_at(push.point) - before[push.b].velocity_at(push.point)
        return -float(speed @ push.normal) >= self._touches.approach

    def _load(self, push: Push, time: float, before: Mapping[str, State], mass: float) -> Load:
        a, b, point, dt = push.a, push.b, push.point, self.recording.step
        speed = before[a].velocity_at(point) - before[b].velocity_at(point)
        impact = Impact(time, a, b, point, push.normal, push.impulse, speed, dt, mass=push.mass)
        local = before[a].rotation.T @ (point - before[a].place)
        weight = mass * float(np.linalg.norm(self.recording.gravity)) * dt
        return Load((a, b), impact, local, 0.5 * self._reach[a], weight)

    def _keep(self, impacts: list[Impact], after: Mapping[str, State]) -> None:
        """Keeps impacts that are over; the first is compared with the restitution of its materials."""
        self.recording.impacts += impacts
        if not impacts or self._compared:
            return
        first, self._compared = impacts[0], True
        states = [after.get(name) for name in (first.a, first.b)]
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
