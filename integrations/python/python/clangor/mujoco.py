"""Records a MuJoCo run: every contact point that approaches and is pushed apart becomes one impact.

After `mj_step`, contacts, frames and geom poses belong to the start of the step, `qvel` to its end. For
Euler-type integrators the sum over contacts of J^T F dt is M dv minus the smooth forces, so the impulses
are those that the bodies received. Planes, fixed and moving bodies are recorded; sliding and rolling are
not heard. No contact force is computed here: restitution and duration are those of the simulator.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .impacts import Load
from .material_pairs import Material
from .mujoco_bodies import Bodies
from .mujoco_contacts import Contacts, Push
from .mujoco_joints import Joints
from .mujoco_restitution import hear_as
from .recorded_run import RecordedRun, State
from .recording import Floats, Impact, Recording

__all__ = ["Recorder", "hear_as"]


class Recorder(RecordedRun):
    """Steps `model` and `data`, and records what is heard.

    `materials` maps names of bodies or geoms to presets, or to mappings with a `base`. `approach` [m/s] is
    the least normal speed of an impact, `longest` [s] its longest window. Errors: ValueError names the
    argument, body or geom that cannot be recorded.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        materials: Mapping[str, Material] | None = None,
        approach: float = 0.05,
        longest: float = 0.08,
    ) -> None:
        if data.qpos.shape != (model.nq,):
            raise ValueError(f"data: qpos has shape {data.qpos.shape}, the model needs ({model.nq},)")
        self._contacts = Contacts(model)
        self.model, self.data = model, data
        super().__init__(approach, longest)
        self._bodies = Bodies(model, data, materials or {}, Path(self._folder.name))
        self._material = {shape.name: shape.material for shape in self._bodies.shapes}
        self._moving = [body for body in self._bodies.bodies if body.root]
        self._mass = {body.name: body.mass for body in self._bodies.bodies}
        self._joints = Joints(self._bodies)
        self._start = float(data.time)
        step = float(model.opt.timestep)
        self.recording = Recording(self._bodies.shapes, np.array(model.opt.gravity), step)
        self.ledger: list[tuple[float, str, float, float]] = []
        """Per step and moving body: time [s], name, |sum of J + m g dt - m dv| and |m dv| [N s].

        With joints, J holds their impulses, and only bodies on free joints leave a difference.
        """

    def step(self) -> None:
        """One `mj_step`, recorded. Errors: RuntimeError after `stop`."""
        self._check_running()
        m, d = self.model, self.data
        time, dt = float(d.time) - self._start, float(m.opt.timestep)
        self._bodies.read(d)
        before = {body.name: self._bodies.state(body) for body in self._bodies.bodies}
        if self._joints.there:
            self._joints.start()
        pushes = self._contacts.step(d)
        self._bodies.read(d)
        after = {body.name: self._bodies.state(body) for body in self._moving}
        change = {name: after[name].velocity - before[name].velocity for name in after}
        for name in after:
            s = before[name]
            self.recording.poses.append((time, name, s.place, s.rotation, s.velocity, s.spin))
        total = {name: np.zeros(3) for name in after}
        loads = [load for push in pushes for load in self._load(push, time, before, total)]
        self._touches.step(loads)
        self._keep(self._touches.closed, after.get)
        rest = {n: total[n] + self._mass[n] * (m.opt.gravity * dt - change[n]) for n in total}
        if self._joints.there:
            rows, rest = self._joints.finish(time, dt, total, self.recording.gravity)
            self._touches.lasting += rows
        for n in total:
            sizes = float(np.linalg.norm(rest[n])), self._mass[n] * float(np.linalg.norm(change[n]))
            self.ledger.append((time, n, *sizes))

    def _load(
        self, push: Push, time: float, before: dict[str, State], total: dict[str, Floats]
    ) -> list[Load]:
        """The load of a contact, if it pushes; its impulse is added to `total`."""
        dt, known = float(self.model.opt.timestep), self._bodies.of_geom
        if push.first not in known or push.second not in known:
            return []
        a, b, impulse, normal = known[push.second], known[push.first], push.impulse, push.normal
        if not a.root:
            a, b, impulse, normal = b, a, -impulse, -normal
        for body, sign in ((a, 1.0), (b, -1.0)):
            if body.root:
                total[body.name] += sign * impulse
        if not float(impulse @ normal) > 0.0 or a is b:
            return []
        point = push.point
        speed = before[a.name].velocity_at(point) - before[b.name].velocity_at(point)
        impact = Impact(time, a.name, b.name, point, normal, impulse, speed, dt)
        local = before[a.name].rotation.T @ (point - before[a.name].place)
        weight = float(np.linalg.norm(self.model.opt.gravity)) * a.mass * dt
        return [Load((a.name, b.name), impact, local, 0.5 * a.reach, weight)]
