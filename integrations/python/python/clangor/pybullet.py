"""Records a PyBullet run: a contact point that approaches and is pushed apart within a step is one impact.

PyBullet solves impulses, so an impact lasts one time step. `getContactPoints` after a step gives its
forces: their sum times the step is m dv - m g dt, if the damping of the bodies is 0. Points that do not
approach carry load only. Bodies without links, of one sphere or box, and planes are recorded.
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Union

import numpy as np
import pybullet  # type: ignore[import-not-found]

from . import Session, Sound, materials as presets
from .recording import BodyShape, Floats, Impact, Recording, write_timeline

__all__ = ["Recorder"]


class Recorder:
    """Steps the world of `client`. `materials` maps numbers of bodies to presets; `step` is its time step
    [s].

    `approach` [m/s] is the least normal speed of an impact. Errors: ValueError names the argument or body.
    """

    def __init__(
        self,
        client: int,
        step: float,
        gravity: Sequence[float],
        materials: Mapping[int, str],
        approach: float = 0.05,
    ) -> None:
        if len(gravity) != 3:
            raise ValueError(f"gravity: needs 3 numbers, not {len(gravity)}")
        if not (step > 0.0 and approach > 0.0):
            raise ValueError("step, approach: must be above 0")
        self.client, self.dt, self.approach = client, step, approach
        self._folder = tempfile.TemporaryDirectory(prefix="clangor-")
        self.recording = Recording([], np.array(gravity, float))
        self.ledger: list[tuple[float, str, float, float]] = []
        """Per step and free body: time [s], name, |sum of J + m g dt - m dv| and |m dv| [N s]."""
        self._mass: dict[int, float] = {}
        self._steps = 0
        self._stopped = False
        bodies = [pybullet.getBodyUniqueId(k, client) for k in range(pybullet.getNumBodies(client))]
        for body in sorted(set(materials) - set(bodies)):
            raise ValueError(f"materials: the world has no body {body}")
        for body in bodies:
            self._add(body, materials.get(body))

    def _add(self, body: int, material: str | None) -> None:
        shapes = pybullet.getCollisionShapeData(body, -1, self.client)
        if len(shapes) != 1 or pybullet.getNumJoints(body, self.client):
            raise ValueError(f"body {body}: only bodies of one shape and without links can be recorded")
        if material is None:
            warnings.warn(f"body {body} has no material: steel is taken", stacklevel=4)
            material = "steel"
        if material not in presets():
            raise ValueError(f"materials[{body}]: no preset is called {material!r}")
        kind, size = shapes[0][2], shapes[0][3]
        if kind not in (pybullet.GEOM_SPHERE, pybullet.GEOM_BOX, pybullet.GEOM_PLANE):
            raise ValueError(f"body {body}: only spheres, boxes and planes can be recorded")
        sphere = kind == pybullet.GEOM_SPHERE
        sizes = f"sphere:{size[0]:.9g}" if sphere else "box:" + "x".join(f"{s:.9g}" for s in size)
        mass = float(pybullet.getDynamicsInfo(body, -1, self.client)[0])
        place, turn, _, _ = self._state(body)
        plane = kind == pybullet.GEOM_PLANE
        self.recording.bodies.append(
            BodyShape(f"body-{body}", f'shape = "{sizes}"', material, mass, place, turn, plane)
        )
        self._mass[body] = mass

    def _state(self, body: int) -> tuple[Floats, Floats, Floats, Floats]:
        place, turn = pybullet.getBasePositionAndOrientation(body, self.client)
        velocity, spin = pybullet.getBaseVelocity(body, self.client)
        matrix = np.array(pybullet.getMatrixFromQuaternion(turn)).reshape(3, 3)
        return np.array(place), matrix, np.array(velocity), np.array(spin)

    def step(self) -> None:
        """One `stepSimulation`, recorded. Errors: RuntimeError after `stop`."""
        if self._stopped:
            raise RuntimeError("step: the recorder was stopped")
        time = self._steps * self.dt
        self._steps += 1
        before = {body: self._state(body) for body in self._mass}
        free = [body for body, mass in self._mass.items() if mass > 0.0]
        self.recording.poses += [(time, f"body-{body}", *before[body]) for body in free]
        pybullet.stepSimulation(self.client)
        total = {body: np.zeros(3) for body in self._mass}
        for c in pybullet.getContactPoints(physicsClientId=self.client):
            a, b, normal = c[1], c[2], np.array(c[7])
            impulse = (normal * c[9] + np.array(c[11]) * c[10] + np.array(c[13]) * c[12]) * self.dt
            total[a] += impulse
            total[b] -= impulse
            point = np.array(c[5])
            if self._mass[a] == 0.0:
                a, b, normal, impulse, point = b, a, -normal, -impulse, np.array(c[6])
            speed = np.zeros(3)
            for body, sign in ((a, 1.0), (b, -1.0)):
                place, _, velocity, spin = before[body]
                speed += sign * (velocity + np.cross(spin, point - place))
            if c[9] > 0.0 and -float(speed @ normal) >= self.approach:
                number = len(self.recording.impacts) + 1
                names = f"body-{a}", f"body-{b}"
                self.recording.impacts.append(
                    Impact(time, *names, point, normal, impulse, speed, self.dt, number)
                )
        for body in free:
            change = self._mass[body] * (self._state(body)[2] - before[body][2])
            rest = total[body] + self._mass[body] * self.recording.gravity * self.dt - change
            self.ledger.append(
                (time, f"body-{body}", float(np.linalg.norm(rest)), float(np.linalg.norm(change)))
            )

    def stop(self) -> None:
        """Ends the recording. May be repeated."""
        self._stopped = True

    def session(self, listener: Sequence[float] = (0.3, 0.3, 0.4)) -> Session:
        """A session that renders what was recorded; `listener` is a place (3,) [m], z up."""
        if len(listener) != 3:
            raise ValueError(f"listener: needs 3 numbers, not {len(listener)}")
        self.stop()
        x, y, z = (float(value) for value in listener)
        target = Path(self._folder.name) / "run.timeline"
        write_timeline(self.recording, Path(self._folder.name) / "scene.toml", target, [(x, z, -y)])
        return Session(target, listeners=[(x, z, -y)])

    def render(
        self, output: Union[str, PathLike[str], None] = None, listener: Sequence[float] = (0.3, 0.3, 0.4)
    ) -> list[Sound]:
        """The sound at `listener` [m], z up; written to `output` if it is given."""
        return self.session(listener).render(output)
