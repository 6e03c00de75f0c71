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

from .material_pairs import Material
from .mujoco_bodies import Bodies
from .mujoco_contacts import Contacts, GeomPush
from .mujoco_restitution import hear_as
from .recorded_run import Push, RecordedRun, State
from .recording import Recording

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
        self._reach = {body.name: body.reach for body in self._bodies.bodies}
        self._joints = self._bodies.joints()
        self._start = float(data.time)
        step = float(model.opt.timestep)
        self.recording = Recording(self._bodies.shapes, np.array(model.opt.gravity), step)

    def step(self) -> None:
        """One `mj_step`, recorded. Errors: RuntimeError after `stop`."""
        self._check_running()
        time = float(self.data.time) - self._start
        self._bodies.read(self.data)
        before = {body.name: self._bodies.state(body) for body in self._bodies.bodies}
        if self._joints.there:
            self._joints.start()
        pushes = [found for push in self._contacts.step(self.data) for found in self._between(push, before)]
        self._bodies.read(self.data)
        after = {body.name: self._bodies.state(body) for body in self._moving}
        self._add_step(time, pushes, before, after)

    def _between(self, push: GeomPush, before: Mapping[str, State]) -> list[Push]:
        """The contact of recorded bodies of which one moves, if it is one; positions are of its start."""
        a, b = (self._bodies.of_geom.get(g) for g in (push.second, push.first))
        if a is None or b is None or not (a.root or b.root):
            return []
        found = Push(a.name, b.name, push.point, push.normal, push.impulse)
        if not a.root:
            found = Push(b.name, a.name, push.point, -push.normal, -push.impulse)
        if self._bodies.on_joints(a, b) and self._may_begin(found, before):
            found.mass = self._bodies.effective_mass(a, b, push.point, push.normal)
        return [found]
