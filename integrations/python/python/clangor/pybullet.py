"""Records a PyBullet run: a contact point that approaches and is pushed apart is one impact.

PyBullet solves impulses: after a step, the sum of the contact forces times the step is m dv - m g dt of
every body, if its damping is 0. A contact is solved before the bodies touch, at a gap d, and then leaves
with e v - d / dt, so that a bounce may take two steps and lose its speed; `hear_as` leaves such contacts
out. Impulses of one point in successive steps are one impact. Sliding and rolling are not heard.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .impacts import Load
from .material_pairs import Material
from .pybullet_bodies import add_body, hear_as, pose
from .recorded_run import RecordedRun, State
from .recording import Floats, Impact, Recording

__all__ = ["Recorder", "hear_as"]

class Recorder(RecordedRun):
    """Steps the world of `client`, and records what is heard.

    `materials` maps numbers of bodies to presets, or to mappings with a `base`. `approach` [m/s] is the
    least normal speed of an impact, `longest` [s] its longest window. Time step and gravity are read from
    the client. Errors: ValueError names the argument or body.
    """

    def __init__(
        self, client: int, materials: Mapping[int, Material], approach: float = 0.05, longest: float = 0.08
    ) -> None:
        super().__init__(approach, longest)
        world = pybullet.getPhysicsEngineParameters(client)
        if world["numSubSteps"] > 1:
            raise ValueError("client: contacts of substeps cannot be read; set numSubSteps=0")
        self.client, self.dt = client, float(world["fixedTimeStep"])
        gravity = np.array([world[f"gravityAcceleration{axis}"] for axis in "XYZ"], float)
        self.recording = Recording([], gravity, self.dt)
        self.ledger: list[tuple[float, str, float, float]] = []
        """Per step and free body: time [s], name, |sum of J + m g dt - m dv| and |m dv| [N s]."""
        self._steps = 0
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

    def _state(self, body: int) -> State:
        velocity, spin = pybullet.getBaseVelocity(body, self.client)
        place, turn = pose(self.client, body)
        return State(place, turn @ self._axes[body], np.array(velocity), np.array(spin))

    def step(self) -> None:
        """One `stepSimulation`, recorded. Errors: RuntimeError after `stop`."""
        self._check_running()
        time, dt = self._steps * self.dt, self.dt
        self._steps += 1
        before = {body: self._state(body) for body in self._mass}
        for body in self._free:
            s = before[body]
            self.recording.poses.append((time, f"body-{body}", s.place, s.rotation, s.velocity, s.spin))
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
        self._keep(self._touches.closed, {f"body-{k}": state for k, state in after.items()}.get)
        for body in self._free:
            change = self._mass[body] * (after[body].velocity - before[body].velocity)
            rest = total[body] + self._mass[body] * self.recording.gravity * dt - change
            sizes = float(np.linalg.norm(rest)), float(np.linalg.norm(change))
            self.ledger.append((time, f"body-{body}", *sizes))

    def _load(
        self,
        pair: tuple[int, int],
        time: float,
        push: tuple[Floats, Floats, Floats],
        before: Mapping[int, State],
    ) -> Load:
        (a, b), (point, normal, impulse) = pair, push
        speed = before[a].velocity_at(point) - before[b].velocity_at(point)
        impact = Impact(time, f"body-{a}", f"body-{b}", point, normal, impulse, speed, self.dt)
        local = before[a].rotation.T @ (point - before[a].place)
        weight = self._mass[a] * float(np.linalg.norm(self.recording.gravity)) * self.dt
        return Load((a, b), impact, local, 0.5 * self._reach[a], weight)
