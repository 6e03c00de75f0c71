"""Records a MuJoCo run: every contact point that approaches and is pushed apart becomes one impact.

After `mj_step`, contacts, frames and geom poses belong to the start of the step, `qvel` to its end. For Euler-type
integrators the sum over contacts of J^T F dt is M dv minus the smooth forces. An impact is the sum of the force at one
point from its first load until the normal velocity ends; the body's weight over that window is carried load.
Free bodies of one geom (sphere, box, mesh), planes, fixed spheres and fixed boxes are recorded.
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Union

import mujoco  # type: ignore[import-untyped]
import numpy as np

from . import Session, Sound, materials as presets
from .mujoco_restitution import hear_as
from .recording import BodyShape, Floats, Impact, Recording, write_timeline

__all__ = ["Recorder", "hear_as"]


@dataclass
class _Touch:
    """A loaded point: `local` is its place in the frame of the body, `impact` runs until `done`."""

    local: Floats
    impact: Impact
    weighted: Floats
    load: float
    last: float
    rest: float = 0.0
    done: bool = False


class Recorder:
    """Steps `model` and `data`, and records what is heard. `materials` maps names of bodies or geoms to presets.

    `approach` [m/s] is the least normal speed of an impact, `longest` [s] its longest window. Errors: ValueError
    names the argument, body or geom that cannot be recorded.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        materials: Mapping[str, str] | None = None,
        approach: float = 0.05,
        longest: float = 0.08,
    ) -> None:
        if data.qpos.shape != (model.nq,):
            raise ValueError(f"data: qpos has shape {data.qpos.shape}, the model needs ({model.nq},)")
        if not (approach > 0.0 and longest > 0.0):
            raise ValueError("approach, longest: must be above 0")
        self.model, self.data, self.approach, self.longest = model, data, approach, longest
        self._folder = tempfile.TemporaryDirectory(prefix="clangor-")
        self._touches: dict[tuple[int, int], list[_Touch]] = {}
        self._stopped = False
        self._start = float(data.time)
        self.ledger: list[tuple[float, str, float, float]] = []
        """Per step and free body: time [s], name, |sum of J + m g dt - m dv| and |m dv| [N s]."""
        mujoco.mj_forward(model, data)
        self._names: dict[int, str] = {}
        self._free: dict[int, str] = {}
        self.recording = Recording([], np.array(model.opt.gravity))
        self._read_geoms(dict(materials or {}))

    def _read_geoms(self, given: dict[str, str]) -> None:
        m, used, owners = self.model, set(), set()
        for name, material in given.items():
            if material not in presets():
                raise ValueError(f"materials[{name!r}]: no preset is called {material!r}")
        for g in range(m.ngeom):
            if m.geom_contype[g] == 0 and m.geom_conaffinity[g] == 0:
                continue
            b = int(m.geom_bodyid[g])
            free = m.body_jntnum[b] == 1 and m.jnt_type[m.body_jntadr[b]] == mujoco.mjtJoint.mjJNT_FREE
            fixed = m.body_weldid[b] == 0
            name = (m.body(b).name if free else m.geom(g).name) or m.geom(g).name or f"geom-{g}"
            if not free and not fixed:
                raise ValueError(f"body {m.body(b).name!r}: only free and fixed bodies can be recorded")
            if free and b in owners:
                raise ValueError(f"body {name!r}: bodies of several geoms cannot be recorded")
            if free and not m.body_mass[b] > 0.0:
                raise ValueError(f"body {name!r}: has no mass")
            if free and np.linalg.norm(self.data.geom_xpos[g] - self.data.xipos[b]) > 1e-6:
                raise ValueError(f"body {name!r}: its centre of mass is not that of its geom")
            owners.add(b)
            keys = [key for key in (m.geom(g).name, m.body(b).name) if key in given]
            used.update(keys)
            if not keys:
                warnings.warn(f"{name!r} has no material: steel is taken", stacklevel=4)
            material = given[keys[0]] if keys else "steel"
            plane = m.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE
            mass = float(m.body_mass[b]) if free else 0.0
            place, turn = self._pose(g)
            surface = "" if plane else self._surface(g, name)
            self.recording.bodies.append(BodyShape(name, surface, material, mass, place, turn, plane))
            self._names[g] = name
            if free:
                self._free[b] = name
        unknown = sorted(set(given) - used)
        if unknown:
            raise ValueError(f"materials: the model has no body or geom {unknown[0]!r}")

    def _pose(self, g: int) -> tuple[Floats, Floats]:
        return np.array(self.data.geom_xpos[g]), np.array(self.data.geom_xmat[g]).reshape(3, 3)

    def _surface(self, g: int, name: str) -> str:
        m, kind, size = self.model, self.model.geom_type[g], self.model.geom_size[g]
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            return f'shape = "sphere:{size[0]:.9g}"'
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            return 'shape = "box:' + "x".join(f"{2.0 * s:.9g}" for s in size) + '"'
        if kind != mujoco.mjtGeom.mjGEOM_MESH:
            raise ValueError(f"geom {name!r}: only spheres, boxes, meshes and planes can be recorded")
        k = m.geom_dataid[g]
        vertices = m.mesh_vert[m.mesh_vertadr[k] :][: m.mesh_vertnum[k]]
        faces = m.mesh_face[m.mesh_faceadr[k] :][: m.mesh_facenum[k]] + 1
        lines = ["v " + " ".join(f"{x:.9g}" for x in v) for v in vertices]
        lines += ["f " + " ".join(str(i) for i in f) for f in faces]
        (Path(self._folder.name) / f"{g}.obj").write_text("\n".join(lines) + "\n")
        return f'mesh = "{g}.obj"'

    def _velocity(self, b: int) -> tuple[Floats, Floats]:
        """Velocities [m/s] of the centre of mass and [rad/s], of free body `b`, world, from qpos and qvel."""
        m, d = self.model, self.data
        q, v, r = m.jnt_qposadr[m.body_jntadr[b]], m.body_dofadr[b], np.zeros(9)
        mujoco.mju_quat2Mat(r, d.qpos[q + 3 : q + 7])
        spin = r.reshape(3, 3) @ d.qvel[v + 3 : v + 6]
        return d.qvel[v : v + 3] + np.cross(spin, r.reshape(3, 3) @ m.body_ipos[b]), spin

    def step(self) -> None:
        """One `mj_step`, recorded. Errors: RuntimeError after `stop`."""
        if self._stopped:
            raise RuntimeError("step: the recorder was stopped")
        m, d = self.model, self.data
        time, dt = float(d.time) - self._start, float(m.opt.timestep)
        before = {b: self._velocity(b) for b in self._free}
        mujoco.mj_step(m, d)
        for g, name in self._names.items():
            b = int(m.geom_bodyid[g])
            if b in self._free:
                self.recording.poses.append((time, name, *self._pose(g), *before[b]))
        total = {b: np.zeros(3) for b in self._free}
        loaded: set[int] = set()
        for i in range(d.ncon):
            self._contact(i, time, before, total, loaded)
        for pair, touches in self._touches.items():
            for touch in touches:
                if id(touch) not in loaded and not touch.done:
                    self._close(touch)
            self._touches[pair] = [touch for touch in touches if id(touch) in loaded]
        for b, name in self._free.items():
            change = m.body_mass[b] * (self._velocity(b)[0] - before[b][0])
            rest = total[b] + m.body_mass[b] * m.opt.gravity * dt - change
            self.ledger.append((time, name, float(np.linalg.norm(rest)), float(np.linalg.norm(change))))

    def _contact(self, i: int, time: float, before: Any, total: dict[int, Floats], loaded: set[int]) -> None:
        m, d, dt = self.model, self.data, float(self.model.opt.timestep)
        c, force = d.contact[i], np.zeros(6)
        mujoco.mj_contactForce(m, d, i, force)
        frame = np.array(c.frame).reshape(3, 3)
        impulse, normal = frame.T @ force[:3] * dt, frame[0]
        g, h = int(c.geom2), int(c.geom1)
        if int(m.geom_bodyid[g]) not in self._free:
            g, h, impulse, normal = h, g, -impulse, -normal
        a, b = int(m.geom_bodyid[g]), int(m.geom_bodyid[h])
        for body, sign in ((a, 1.0), (b, -1.0)):
            if body in total:
                total[body] += sign * impulse
        point = np.array(c.pos) + 0.5 * normal * min(float(c.dist), 0.0)
        speed = np.zeros(3)
        for body, sign in ((a, 1.0), (b, -1.0)):
            if body in before:
                speed += sign * (before[body][0] + np.cross(before[body][1], point - d.xipos[body]))
        load = float(impulse @ normal)
        if load > 0.0:
            impact = Impact(time, self._names[g], self._names[h], point, normal, impulse, speed, dt)
            loaded.add(id(self._merge((g, h), impact, load)))

    def _merge(self, pair: tuple[int, int], new: Impact, load: float) -> _Touch:
        """Adds a step's impulse to the touch of the nearest point, or begins a touch."""
        place, turn = self._pose(pair[0])
        local = turn.T @ (new.point - place)
        touches = self._touches.setdefault(pair, [])
        near = 0.5 * float(self.model.geom_rbound[pair[0]])
        close = [t for t in touches if t.last < new.time and np.linalg.norm(t.local - local) < near]
        touch = min(close, key=lambda t: float(np.linalg.norm(t.local - local)), default=None)
        closing = float(new.velocity @ new.normal)
        if touch is None or (touch.done and closing < -self.approach and load > 3.0 * touch.rest):
            if touch is not None:
                touches.remove(touch)
            touch = _Touch(local, new, new.point * load, load, new.time)
            touches.append(touch)
            return touch
        touch.local, touch.last = local, new.time
        if touch.done:
            touch.rest = 0.9 * touch.rest + 0.1 * load
            return touch
        run = touch.impact
        run.impulse, run.window = run.impulse + new.impulse, run.window + new.window
        touch.weighted, touch.load = touch.weighted + new.point * load, touch.load + load
        ended = abs(float(new.velocity @ run.normal)) < 0.02 * abs(float(run.velocity @ run.normal))
        # A bounce passes through zero velocity at its deepest point; only a load near the weight is rest.
        weight = 9.81 * float(self.model.body_mass[self.model.geom_bodyid[pair[0]]]) * new.window
        if (ended and load < 2.0 * weight) or run.window > self.longest:
            touch.rest = load
            self._close(touch)
        return touch

    def _close(self, touch: _Touch) -> None:
        touch.done = True
        impact = touch.impact
        if -float(impact.velocity @ impact.normal) >= self.approach:
            impact.point = touch.weighted / touch.load
            self.recording.impacts.append(impact)

    def stop(self) -> None:
        """Ends the recording: open impacts are closed, the weight that was carried is taken off. May be repeated."""
        if self._stopped:
            return
        self._stopped = True
        for touch in (t for touches in self._touches.values() for t in touches if not t.done):
            self._close(touch)
        mass = {body.name: body.mass for body in self.recording.bodies}
        impacts = sorted(self.recording.impacts, key=lambda impact: impact.time)
        along = [float(i.impulse @ i.normal) for i in impacts]
        for k, impact in enumerate(impacts):
            impact.number = k + 1
            if mass[impact.b] > 0.0:
                continue
            mates = [
                n
                for j, n in zip(impacts, along)
                if j.a == impact.a
                and j.time < impact.time + impact.window
                and impact.time < j.time + j.window
            ]
            weight = -mass[impact.a] * float(self.model.opt.gravity @ impact.normal) * impact.window
            carried = max(0.0, weight) * along[k] / sum(mates)
            impact.impulse = impact.impulse - impact.normal * min(carried, 0.99 * along[k])
        self.recording.impacts = impacts

    def session(self, listener: Sequence[float] = (0.3, 0.3, 0.4)) -> Session:
        """A session that renders what was recorded; `listener` is a place (3,) [m], z up."""
        if len(listener) != 3:
            raise ValueError(f"listener: needs 3 numbers, not {len(listener)}")
        self.stop()
        x, y, z = (float(value) for value in listener)
        folder = Path(self._folder.name)
        target = folder / "run.timeline"
        write_timeline(self.recording, folder / "scene.toml", target, [(x, z, -y)])
        return Session(target, listeners=[(x, z, -y)])

    def render(
        self, output: Union[str, PathLike[str], None] = None, listener: Sequence[float] = (0.3, 0.3, 0.4)
    ) -> list[Sound]:
        """The sound at `listener` [m], z up; written to `output` if it is given."""
        return self.session(listener).render(output)
