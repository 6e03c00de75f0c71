"""Impacts from the contact impulses of a simulator's time steps.

The impulse of an impact at one point is J = sum of F dt over the steps in which the point is loaded, from the
first load until the normal velocity ends. A body at rest on a fixed one is carried with m g dt per step; this
share is taken off. It is not a contact model: forces are the simulator's.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field, replace

import numpy as np

from .recording import Floats, Impact, Recording

__all__ = ["Load", "Touches", "close_recording"]

_ENDED = 0.02
"""Share of the approach speed below which the normal velocity has ended."""


@dataclass
class Load:
    """A loaded contact point of one step: `local` is its place [m] in the frame of the first body."""

    pair: tuple[Hashable, Hashable]
    impact: Impact
    local: Floats
    near: float
    """Distance [m] within which two steps load the same point."""
    weight: float
    """Weight of the first body times the step [N s]."""


@dataclass
class _Touch:
    local: Floats
    impact: Impact
    weighted: Floats
    load: float
    last: float
    rest: float = 0.0
    done: bool = False
    steps: list[Impact] = field(default_factory=list)


class Touches:
    """The points that are loaded now; `approach` [m/s] is the least normal speed, `longest` [s] a window."""

    def __init__(self, approach: float, longest: float) -> None:
        if not (approach > 0.0 and longest > 0.0):
            raise ValueError("approach, longest: must be above 0")
        self.approach, self.longest = approach, longest
        self.closed: list[Impact] = []
        """Impacts that ended in the last step."""
        self.lasting: list[Impact] = []
        """Loads of single steps, so far, that belong to no impact."""
        self._touches: dict[tuple[Hashable, Hashable], list[_Touch]] = {}

    def step(self, loads: list[Load]) -> None:
        """Adds the loads of one step; touches without a load end."""
        self.closed = []
        loaded = {id(self._merge(load)) for load in loads}
        for pair, touches in list(self._touches.items()):
            for touch in touches:
                if id(touch) not in loaded and not touch.done:
                    self._close(touch)
            self._touches[pair] = [touch for touch in touches if id(touch) in loaded]
            if not self._touches[pair]:
                del self._touches[pair]

    def finish(self) -> list[Impact]:
        """Ends all touches and gives the impacts that were open."""
        self.step([])
        return self.closed

    def _merge(self, load: Load) -> _Touch:
        """Adds a step's impulse to the touch of the nearest point, or begins a touch."""
        new = load.impact
        along = float(new.impulse @ new.normal)
        touches = self._touches.setdefault(load.pair, [])
        close = [t for t in touches if t.last < new.time and np.linalg.norm(t.local - load.local) < load.near]
        touch = min(close, key=lambda t: float(np.linalg.norm(t.local - load.local)), default=None)
        closing = float(new.velocity @ new.normal)
        if touch is None or (touch.done and closing < -self.approach and along > 3.0 * touch.rest):
            if touch is not None:
                touches.remove(touch)
            touch = _Touch(load.local, new, new.point * along, along, new.time)
            touch.steps.append(replace(new))
            touches.append(touch)
            return touch
        touch.local, touch.last = load.local, new.time
        if touch.done:
            touch.rest = 0.9 * touch.rest + 0.1 * along
            self.lasting.append(new)
            return touch
        touch.steps.append(new)
        run = touch.impact
        run.impulse, run.window = run.impulse + new.impulse, run.window + new.window
        touch.weighted, touch.load = touch.weighted + new.point * along, touch.load + along
        ended = abs(float(new.velocity @ run.normal)) < _ENDED * abs(float(run.velocity @ run.normal))
        # A bounce passes through zero velocity at its deepest point; only a load near the weight is rest.
        if (ended and along < 2.0 * load.weight) or run.window > self.longest:
            touch.rest = along
            self._close(touch)
        return touch

    def _close(self, touch: _Touch) -> None:
        touch.done = True
        impact = touch.impact
        if -float(impact.velocity @ impact.normal) >= self.approach:
            impact.point = touch.weighted / touch.load
            self.closed.append(impact)
        else:
            self.lasting += touch.steps
        touch.steps = []


def close_recording(recording: Recording, touches: Touches) -> None:
    """Impacts in order of time, numbered; the weight that a fixed body carries meanwhile becomes lasting
    load."""
    impacts = sorted(recording.impacts + touches.finish(), key=lambda impact: impact.time)
    mass = {body.name: body.mass for body in recording.bodies}
    along = [float(i.impulse @ i.normal) for i in impacts]
    recording.impacts, recording.lasting = impacts, touches.lasting
    for k, impact in enumerate(impacts):
        impact.number = k + 1
        if mass[impact.b] > 0.0:
            continue
        end = impact.time + impact.window
        mates = [
            n
            for j, n in zip(impacts, along)
            if j.a == impact.a and j.time < end and impact.time < j.time + j.window
        ]
        weight = -mass[impact.a] * float(recording.gravity @ impact.normal) * impact.window
        carried = min(max(0.0, weight) * along[k] / sum(mates), 0.99 * along[k])
        if carried > 0.0:
            recording.lasting.append(replace(impact, impulse=impact.normal * carried, number=0))
        impact.impulse = impact.impulse - impact.normal * carried
