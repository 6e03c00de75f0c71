"""Contact settings of MuJoCo under which a dropped sphere bounces with a wanted restitution.

MuJoCo's contact is a spring and damper, `solref` = (time constant, damping ratio). The damping ratio is found by
bisection on the drop of a sphere on a plane; the impedance is constant, which makes restitution nearly independent
of speed. The spring's angular frequency is 1 / (time constant * damping ratio); half its period is 12 time steps,
since fewer gain energy.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import pi
from typing import Any

import mujoco  # type: ignore[import-untyped]

_STEP, _STEPS_OF_CONTACT = 0.000125, 12.0
_HEIGHTS = (0.05, 0.053, 0.056, 0.059)
_SOLIMP = (0.99, 0.99, 0.001, 0.5, 2.0)
_DROP = """<mujoco><option timestep="{step}"/><worldbody><geom type="plane" size="1 1 .1" {contact}/>
<body pos="0 0 {centre}"><freejoint/><geom type="sphere" size=".01" {contact}/></body></worldbody></mujoco>"""


def _solref(step: float, damping_ratio: float) -> tuple[float, float]:
    return _STEPS_OF_CONTACT * step / (pi * damping_ratio), damping_ratio


def dropped_restitution(step: float, damping_ratio: float) -> float:
    """Mean of speed after over speed before, of a sphere dropped by 5 to 6 cm, at the time step [s]."""
    impedance = " ".join(str(value) for value in _SOLIMP)
    constant, ratio = _solref(step, damping_ratio)
    contact = f'solref="{constant} {ratio}" solimp="{impedance}"'
    found = 0.0
    for height in _HEIGHTS:
        text = _DROP.format(step=step, contact=contact, centre=0.01 + height)
        model = mujoco.MjModel.from_xml_string(text)
        data, slowest, fastest = mujoco.MjData(model), 0.0, 0.0
        for _ in range(round(0.13 / step)):
            mujoco.mj_step(model, data)
            speed = float(data.qvel[2])
            slowest, fastest = min(slowest, speed), max(fastest, speed)
        found += fastest / -slowest / len(_HEIGHTS)
    return found


@contextmanager
def hear_as(model: Any, restitution: float, step: float = _STEP) -> Iterator[float]:
    """Within it, contacts of `model` bounce with `restitution` (0.05 to 0.95); gives the time step [s] in force.

    It sets `geom_solref`, `geom_solimp` and the time step: `step` [s], at most 0.125 ms. All are restored on exit.
    A policy sees other physics within it, and needs more steps for the same time. Errors: ValueError for values out
    of range, for contact pairs of their own settings, and where no damping ratio gives the restitution within 0.03.
    """
    if not 0.05 <= restitution <= 0.95:
        raise ValueError(f"restitution: {restitution} is not between 0.05 and 0.95")
    if not step > 0.0:
        raise ValueError(f"step: {step} is not above 0")
    if model.npair or model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE:
        raise ValueError(
            "model: <pair> elements or <flag override> set contacts that hear_as does not change"
        )
    step = min(step, _STEP)
    low, high = 0.002, 1.0
    for _ in range(14):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if dropped_restitution(step, middle) > restitution else (low, middle)
    ratio = (low * high) ** 0.5
    found = dropped_restitution(step, ratio)
    if abs(found - restitution) > 0.03:
        raise ValueError(f"restitution: {restitution} cannot be reached, the nearest is {found:.2f}")
    before = float(model.opt.timestep), model.geom_solref.copy(), model.geom_solimp.copy()
    try:
        model.opt.timestep = step
        model.geom_solref[:] = _solref(step, ratio)
        model.geom_solimp[:] = _SOLIMP
        yield step
    finally:
        model.opt.timestep = before[0]
        model.geom_solref[:] = before[1]
        model.geom_solimp[:] = before[2]
