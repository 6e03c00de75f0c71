"""Records a PyBullet run: a contact point that approaches and is pushed apart is one impact.

PyBullet solves impulses: after a step, the sum of the contact forces times the step is m dv - m g dt of
every body on no joint, if its damping is 0. A contact is solved before the bodies touch, at a gap d, and
then leaves with e v - d / dt, so that a bounce may take two steps and lose its speed; `hear_as` leaves such
contacts out. Impulses of one point in successive steps are one impact. Sliding and rolling are not heard.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .material_pairs import Material
from .pybullet_bodies import Bodies, Key
from .pybullet_effective_mass import EffectiveMasses
from .pybullet_restitution import hear_as
from .recorded_run import Push, RecordedRun, State
from .recording import Recording

__all__ = ["Recorder", "hear_as"]


class Recorder(RecordedRun):
    """Steps the world of `client`, and records what is heard.

    `materials` maps numbers of bodies, or pairs of body and link, to presets, or to mappings with a `base`.
    `approach` [m/s] is the least normal speed of an impact, `longest` [s] its longest window. Time step and
    gravity are read from the client. Errors: ValueError names the argument, body or link.
    """

    def __init__(
        self, client: int, materials: Mapping[Key, Material], approach: float = 0.05, longest: float = 0.08
    ) -> None:
        super().__init__(approach, longest)
        world = pybullet.getPhysicsEngineParameters(client)
        if world["numSubSteps"] > 1:
            raise ValueError("client: contacts of substeps cannot be read; set numSubSteps=0")
        self.client, self.dt = client, float(world["fixedTimeStep"])
        gravity = np.array([world[f"gravityAcceleration{axis}"] for axis in "XYZ"], float)
        self._bodies = Bodies(client, materials, Path(self._folder.name))
        self._joints = self._bodies.joints()
        self._masses = EffectiveMasses(client, self._bodies)
        self._reach = {body.name: body.reach for body in self._bodies.bodies}
        self._material = {shape.name: shape.material for shape in self._bodies.shapes}
        self._moving = [body for body in self._bodies.bodies if body.moving]
        self.recording = Recording(self._bodies.shapes, gravity, self.dt)
        self._steps = 0

    def step(self) -> None:
        """One `stepSimulation`, recorded. Errors: RuntimeError after `stop`."""
        self._check_running()
        time = self._steps * self.dt
        self._steps += 1
        self._bodies.read()
        before = {body.name: self._bodies.state(body) for body in self._bodies.bodies}
        self._joints.start()
        self._masses.start()
        pybullet.stepSimulation(self.client)
        self._bodies.read()
        after = {body.name: self._bodies.state(body) for body in self._moving}
        rows = pybullet.getContactPoints(physicsClientId=self.client)
        pushes = [push for row in rows for push in self._between(row, before)]
        self._add_step(time, pushes, before, after)

    def _between(self, row: Any, before: Mapping[str, State]) -> list[Push]:
        """The contact of recorded bodies of which one moves, if it is one."""
        a, b = (self._bodies.of_link.get((row[k], row[k + 2])) for k in (1, 2))
        if a is None or b is None or not (a.name and b.name and (a.moving or b.moving)):
            return []
        normal = np.array(row[7])
        along = np.array(row[11]) * row[10] + np.array(row[13]) * row[12]
        impulse = (normal * row[9] + along) * self.dt
        found = Push(a.name, b.name, np.array(row[5]), normal, impulse)
        if not a.moving:
            found = Push(b.name, a.name, np.array(row[6]), -normal, -impulse)
        if found.impulse @ found.normal > 0.0 and self._may_begin(found, before):
            found.mass = self._masses.of((a, b), found.point, normal, before)
        return [found]
