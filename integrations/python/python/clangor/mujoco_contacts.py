"""Contact impulses of one step of MuJoCo: J = F dt at every contact point, for the integrators of MuJoCo.

Of Euler and the implicit ones, F is what the step leaves in `data`. RK4 weighs the accelerations of four
stages by 1/6, 1/3, 1/3, 1/6, and so the forces: the stages are repeated on a copy before the step. Its k-th
contact of two geoms in one stage is taken for the k-th in the others. Torques at contacts are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .recording import Floats

__all__ = ["Contacts", "GeomPush"]

_NODES = (0.5, 0.5, 1.0)
_WEIGHTS = (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)


@dataclass
class GeomPush:
    """Impulse [N s] on geom `second` at a point [m]; the normal points to it from `first`."""

    first: int
    second: int
    point: Floats
    normal: Floats
    impulse: Floats


class Contacts:
    """Steps `model` and gives the impulses of the step."""

    def __init__(self, model: Any) -> None:
        self.model = model
        runge_kutta = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
        self._copy = mujoco.MjData(model) if runge_kutta else None

    def step(self, data: Any) -> list[GeomPush]:
        """One `mj_step`."""
        dt = float(self.model.opt.timestep)
        if self._copy is None:
            mujoco.mj_step(self.model, data)
            return self._pushes(data, dt)
        pushes = self._stages(data, self._copy, dt)
        mujoco.mj_step(self.model, data)
        return pushes

    def _pushes(self, data: Any, dt: float) -> list[GeomPush]:
        found, force = [], np.zeros(6)
        for i in range(data.ncon):
            c = data.contact[i]
            mujoco.mj_contactForce(self.model, data, i, force)
            frame = np.array(c.frame).reshape(3, 3)
            normal = frame[0].copy()
            point = np.array(c.pos) + 0.5 * normal * min(float(c.dist), 0.0)
            found.append(GeomPush(int(c.geom1), int(c.geom2), point, normal, frame.T @ force[:3] * dt))
        return found

    def _stages(self, data: Any, copy: Any, dt: float) -> list[GeomPush]:
        m = self.model
        mujoco.mj_copyData(copy, m, data)
        mujoco.mj_forward(m, copy)
        place, speed, state = copy.qpos.copy(), copy.qvel.copy(), copy.act.copy()
        time = float(copy.time)
        total: dict[tuple[int, int, int], GeomPush] = {}
        for stage, weight in enumerate(_WEIGHTS):
            if stage:
                moved, h = place.copy(), _NODES[stage - 1] * dt
                mujoco.mj_integratePos(m, moved, copy.qvel, h)
                copy.qvel[:], copy.qpos[:] = speed + h * copy.qacc, moved
                copy.act[:], copy.time = state + h * copy.act_dot, time + h
                mujoco.mj_forwardSkip(m, copy, mujoco.mjtStage.mjSTAGE_NONE, 1)
            counts: dict[tuple[int, int], int] = {}
            for push in self._pushes(copy, weight * dt):
                pair = push.first, push.second
                counts[pair] = counts.get(pair, 0) + 1
                known = total.setdefault((*pair, counts[pair]), push)
                if known is not push:
                    known.impulse = known.impulse + push.impulse
        return list(total.values())
