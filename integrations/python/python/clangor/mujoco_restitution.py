"""Contact settings of MuJoCo under which bodies bounce with a wanted restitution.

MuJoCo's contact is a spring and damper, `solref` = (time constant, damping ratio). The restitution e of a
damping ratio z is that of a sphere which is dropped on a plane, e = v_after / v_before, at constant
impedance, where it hardly depends on speed. Two geoms have the mean of their ratios. The spring's angular
frequency is 1 / (time constant * z); half its period is 24 time steps, which holds e within 0.03 at any
phase of the step. It is not a contact of elastic solids: the duration of an impact is 24 steps, whatever
the material.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from math import pi
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .material_pairs import Material, check_material, meetings, pair_restitution
from .recording import Floats

_STEP, _STEPS_OF_CONTACT = 0.000125, 24.0
_HEIGHTS = (0.05, 0.053, 0.056, 0.059)
_SOLIMP = (0.99, 0.99, 0.001, 0.5, 2.0)
_LOWEST, _HIGHEST = 0.05, 0.97
_TOLERANCE = 0.03
_DROP = """<mujoco><option timestep="{step}"/><worldbody><geom type="plane" size="1 1 .1" {contact}/>
<body pos="0 0 {centre}"><freejoint/><geom type="sphere" size=".01" {contact}/></body></worldbody></mujoco>"""


def _solref(step: float, damping_ratio: float) -> tuple[float, float]:
    return _STEPS_OF_CONTACT * step / (pi * damping_ratio), damping_ratio


@lru_cache(maxsize=256)
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


@lru_cache(maxsize=256)
def _damping_ratio(step: float, restitution: float) -> float:
    """Damping ratio for `restitution`, by bisection. Errors: ValueError if none gives it within 0.03."""
    low, high = 0.002, 1.5
    for _ in range(14):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if dropped_restitution(step, middle) > restitution else (low, middle)
    ratio = float((low * high) ** 0.5)
    found = dropped_restitution(step, ratio)
    if abs(found - restitution) > _TOLERANCE:
        raise ValueError(f"restitution: {restitution} cannot be reached, the nearest is {found:.2f}")
    return ratio


def _ratios(model: Any, step: float, materials: Mapping[str, Material]) -> Floats:
    """Damping ratio of every geom: least squares over the pairs of materials that can meet."""
    for key, material in materials.items():
        check_material(material, f"materials[{key!r}]")
    kinds: list[Material] = []
    kind, moving = [], []
    for g in range(model.ngeom):
        b = int(model.geom_bodyid[g])
        names = (model.geom(g).name, model.body(b).name, model.body(int(model.body_weldid[b])).name)
        material = next((materials[name] for name in names if name in materials), "steel")
        if material not in kinds:
            kinds.append(material)
        kind.append(kinds.index(material))
        moving.append(bool(model.body_weldid[b]))
    rows, wanted = [], []
    for i, j in meetings(kind, moving):
        both = min(max(pair_restitution(kinds[i], kinds[j]), _LOWEST), _HIGHEST)
        rows.append([0.5 * ((k == i) + (k == j)) for k in range(len(kinds))])
        wanted.append(_damping_ratio(step, round(both, 3)))
    if not rows:
        raise ValueError("model: has no two geoms that can meet")
    found = np.maximum(np.linalg.lstsq(np.array(rows), np.array(wanted), rcond=None)[0], 0.002)
    ratios: Floats = found[kind]
    return ratios


@contextmanager
def hear_as(
    model: Any,
    restitution: float | None = None,
    materials: Mapping[str, Material] | None = None,
    step: float = _STEP,
) -> Iterator[float]:
    """Within it, contacts of `model` bounce as their materials do; gives the time step [s] in force.

    `materials` maps names of bodies or geoms, as for `Recorder`; a `restitution` (0.05 to 0.95) is that of
    all contacts instead. It sets `geom_solref`, `geom_solimp` and the time step: `step` [s], at most 0.125
    ms. All are restored on exit. A policy sees other physics within it, and needs more steps for the same
    time. Errors: ValueError for values out of range, for contact pairs of their own settings, and where no
    damping ratio gives the restitution within 0.03.
    """
    if restitution is None and materials is None:
        raise ValueError("hear_as: needs a restitution or materials")
    if restitution is not None and not _LOWEST <= restitution <= 0.95:
        raise ValueError(f"restitution: {restitution} is not between 0.05 and 0.95")
    if not step > 0.0:
        raise ValueError(f"step: {step} is not above 0")
    if model.npair or model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE:
        raise ValueError(
            "model: <pair> elements or <flag override> set contacts that hear_as does not change"
        )
    step = min(step, _STEP)
    if restitution is None:
        ratios = _ratios(model, step, materials or {})
    else:
        ratios = np.full(model.ngeom, _damping_ratio(step, restitution))
    before = float(model.opt.timestep), model.geom_solref.copy(), model.geom_solimp.copy()
    try:
        model.opt.timestep = step
        model.geom_solref[:] = [_solref(step, float(ratio)) for ratio in ratios]
        model.geom_solimp[:] = _SOLIMP
        yield step
    finally:
        model.opt.timestep = before[0]
        model.geom_solref[:] = before[1]
        model.geom_solimp[:] = before[2]
