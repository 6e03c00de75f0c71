"""Records a PyBullet run: a contact point that approaches and is pushed apart is one impact.

PyBullet solves impulses: after a step, the sum of the contact forces times the step is m dv - m g dt of
every body, if its damping is 0. A contact is solved before the bodies touch, at a gap d, and then leaves
with e v - d / dt, so that a bounce may take two steps and lose its speed; `hear_as` leaves such contacts
out. Impulses of one point in successive steps are one impact. Sliding and rolling are not heard.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Union

import numpy as np
import pybullet  # type: ignore[import-not-found]

from . import Session, Sound
from .impacts import Load, Touches, close_recording
from .material_pairs import Material, warn_of_level
from .pybullet_bodies import add_body, hear_as, pose
from .recording import Floats, Impact, Recording, cross, open_session

__all__ = ["Recorder", "hear_as"]

_Motion = tuple[Floats, Floats, Floats, Floats]


class Recorder:
    """Steps the world of `client`, and records what is heard.

    `materials` maps numbers of bodies to presets, or to mappings with a `base`. `approach` [m/s] is the
    least normal speed of an impact, `longest` [s] its longest window. Time step and gravity are read from
    the client. Errors: ValueError names the argument or body.
    """

    def __init__(
        self, client: int, materials: Mapping[int, Material], approach: float = 0.05, longest: float = 0.08
    ) -> None:
        self._touches = Touches(approach, longest)
        world = pybullet.getPhysicsEngineParameters(client)
        if world["numSubSteps"] > 1:
            raise ValueError("client: contacts of substeps cannot be read; set numSubSteps=0")
        self.client, self.dt = client, float(world["fixedTimeStep"])
        self._folder = tempfile.TemporaryDirectory(prefix="clangor-")
        gravity = np.array([world[f"gravityAcceleration{axis}"] for axis in "XYZ"], float)
        self.recording = Recording([], gravity, self.dt)
        self.ledger: list[tuple[float, str, float, float]] = []
        """Per step and free body: time [s], name, |sum of J + m g dt - m dv| and |m dv| [N s]."""
        self._steps, self._stopped, self._compared = 0, False, False
        bodies = [pybullet.getBodyUniqueId(k, client) for k in range(pybullet.getNumBodies(client))]
        for body in sorted(set(materials) - set(bodies)):
            raise ValueError(f"materials: the world has no body {body}")
        self._axes: dict[int, Floats] = {}
        self._reach: dict[int, float] = {}
        for body in bodies:
            shape, axes, reach = add_body(client, body, materials.get(body), Path(self._folder.name))
            self.recording.bodies.append(shape)
            self._axes[body], self._reach[body] = axes, reach
        self._mass = {body: shape.mass for body, shape in zip(bodies, self.recording.bodies)}
        self._material = {shape.name: shape.material for shape in self.recording.bodies}
        self._free = [body for body, mass in self._mass.items() if mass > 0.0]

    def _state(self, body: int) -> _Motion:
        velocity, spin = pybullet.getBaseVelocity(body, self.client)
        place, turn = pose(self.client, body)
        return place, turn @ self._axes[body], np.array(velocity), np.array(spin)

    def step(self) -> None:
        """One `stepSimulation`, recorded. Errors: RuntimeError after `stop`."""
        if self._stopped:
            raise RuntimeError("step: the recorder was stopped")
        time, dt = self._steps * self.dt, self.dt
        self._steps += 1
        before = {body: self._state(body) for body in self._mass}
        self.recording.poses += [(time, f"body-{body}", *before[body]) for body in self._free]
        pybullet.stepSimulation(self.client)
        after = {body: self._state(body) for body in self._free}
        total = {body: np.zeros(3) for body in self._mass}
        loads = []
        for row in pybullet.getContactPoints(physicsClientId=self.client):
            a, b, normal = row[1], row[2], np.array(row[7])
            along = np.array(row[11]) * row[10] + np.array(row[13]) * row[12]
            impulse = (normal * row[9] + along) * dt
            total[a] += impulse
            total[b] -= impulse
            point = np.array(row[5])
            if self._mass[a] == 0.0:
                a, b, normal, impulse, point = b, a, -normal, -impulse, np.array(row[6])
            if row[9] > 0.0:
                loads.append(self._load((a, b), time, (point, normal, impulse), before))
        self._touches.step(loads)
        self._keep(self._touches.closed, after)
        for body in self._free:
            change = self._mass[body] * (after[body][2] - before[body][2])
            rest = total[body] + self._mass[body] * self.recording.gravity * dt - change
            sizes = float(np.linalg.norm(rest)), float(np.linalg.norm(change))
            self.ledger.append((time, f"body-{body}", *sizes))

    def _load(
        self,
        pair: tuple[int, int],
        time: float,
        push: tuple[Floats, Floats, Floats],
        before: Mapping[int, _Motion],
    ) -> Load:
        (a, b), (point, normal, impulse) = pair, push
        speed = _velocity(before[a], point) - _velocity(before[b], point)
        impact = Impact(time, f"body-{a}", f"body-{b}", point, normal, impulse, speed, self.dt)
        local = before[a][1].T @ (point - before[a][0])
        weight = self._mass[a] * float(np.linalg.norm(self.recording.gravity)) * self.dt
        return Load((a, b), impact, local, 0.5 * self._reach[a], weight)

    def _keep(self, impacts: list[Impact], after: Mapping[int, _Motion]) -> None:
        self.recording.impacts += impacts
        if not impacts or self._compared:
            return
        first, self._compared = impacts[0], True
        ends = {f"body-{body}": _velocity(state, first.point) for body, state in after.items()}
        apart = ends[first.a] - ends.get(first.b, np.zeros(3))
        speed = -float(first.velocity @ first.normal)
        pair = self._material[first.a], self._material[first.b]
        warn_of_level(pair, speed, float(apart @ first.normal) / speed, f"{first.a} on {first.b}")

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


def _velocity(state: _Motion, point: Floats) -> Floats:
    velocity: Floats = state[2] + cross(state[3], point - state[0])
    return velocity
