"""Rigid bodies of a MuJoCo model: which geoms form one, their mass, inertia, pose and velocity.

Bodies that are welded together are one: m = sum m_i, c = sum m_i c_i / m, and the inertia about c by the
parallel axes. Velocities are those of the centre of mass, from a copy of positions and velocities: the
simulator's own `MjData` is only read. Forces are not computed here.
"""

from __future__ import annotations

import warnings
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped]
import numpy as np

from .joint_impulses import Joints, Link
from .material_pairs import Material, check_material
from .mujoco_effective_mass import effective_mass, on_joints
from .mujoco_shapes import geom_surface, union_surface
from .recorded_run import State
from .recording import BodyShape, Floats, cross
from .surfaces import AXIS_Y_TO_Z, off_centre

__all__ = ["Bodies", "RigidBody"]


@dataclass
class RigidBody:
    """`root` is the number of the moving body, or of the world; the shape's axes are `axes` times the
    frame's."""

    name: str
    root: int
    geoms: list[int]
    mass: float
    axes: Floats
    reach: float
    """Bounding radius [m]."""


class Bodies:
    """The rigid bodies of `model`, in the pose of `data`. `materials` maps names of bodies or geoms."""

    def __init__(self, model: Any, data: Any, materials: Mapping[str, Material], folder: Path) -> None:
        self.model = model
        self._copy = mujoco.MjData(model)
        self._on_joints = on_joints(model)
        self._groups: dict[int, list[int]] = {}
        self.read(data)
        self.bodies: list[RigidBody] = []
        self.shapes: list[BodyShape] = []
        self.of_geom: dict[int, RigidBody] = {}
        self._materials, self._folder = dict(materials), folder
        for key, material in self._materials.items():
            check_material(material, f"materials[{key!r}]")
        self._used: set[str] = set()
        groups: dict[int, list[int]] = {}
        for g in range(model.ngeom):
            if model.geom_contype[g] or model.geom_conaffinity[g]:
                root = int(model.body_weldid[model.geom_bodyid[g]])
                groups.setdefault(root if root else -1 - g, []).append(g)
        for root, geoms in groups.items():
            self._add(max(root, 0), geoms)
        for key in sorted(set(self._materials) - self._used):
            raise ValueError(f"materials: the model has no body or geom {key!r}")

    def read(self, data: Any) -> None:
        """Takes positions and velocities from `data`."""
        c, names = self._copy, ("qpos", "qvel", "mocap_pos", "mocap_quat")
        if c.time > 0.0 and all(np.array_equal(getattr(c, name), getattr(data, name)) for name in names):
            return
        for name in names:
            getattr(c, name)[:] = getattr(data, name)
        c.time = 1.0
        mujoco.mj_kinematics(self.model, c)
        mujoco.mj_comPos(self.model, c)
        mujoco.mj_comVel(self.model, c)

    def _free(self, root: int) -> bool:
        """Whether the body moves on a free joint alone."""
        m = self.model
        joint = m.body_jntadr[root]
        return bool(m.body_jntnum[root] == 1 and m.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE)

    def joints(self) -> Joints:
        """The joints of all moving bodies, recorded or not."""
        m = self.model
        names: dict[Hashable, str] = {body.root: body.name for body in self.bodies if body.root}
        links = []
        for root in range(1, m.nbody):
            if int(m.body_weldid[root]) != root:
                continue
            mass = float(sum(m.body_mass[b] for b in self._members(root)))
            parent = int(m.body_weldid[m.body_parentid[root]])
            links.append(Link(root, parent, mass, self._free(root)))
        return Joints(links, names, self._velocity, self._anchor)

    def on_joints(self, a: RigidBody, b: RigidBody) -> bool:
        """Whether one of two bodies is on joints."""
        return self._on_joints[a.root] or self._on_joints[b.root]

    def effective_mass(self, a: RigidBody, b: RigidBody, point: Floats, normal: Floats) -> float | None:
        """Effective mass [kg] of two bodies along `normal` at `point` [m], in the positions last read."""
        return effective_mass(self.model, self._copy, (a.root, b.root), point, normal)

    def state(self, body: RigidBody) -> State:
        """State as last read."""
        c = self._copy
        if body.root == 0:
            g = body.geoms[0]
            place, turn = np.array(c.geom_xpos[g]), np.array(c.geom_xmat[g]).reshape(3, 3)
            return State(place, turn @ body.axes, np.zeros(3), np.zeros(3))
        velocity, spin = self._velocities(body.root)
        return State(self._centre(body.root), self._frame(body.root) @ body.axes, velocity, spin)

    def _velocities(self, root: int) -> tuple[Floats, Floats]:
        c, both = self._copy, np.zeros(6)
        mujoco.mj_objectVelocity(self.model, c, mujoco.mjtObj.mjOBJ_BODY, root, both, 0)
        return both[3:] + cross(both[:3], self._centre(root) - c.xipos[root]), both[:3].copy()

    def _velocity(self, root: Any) -> Floats:
        return self._velocities(root)[0]

    def _anchor(self, root: Any) -> Floats:
        """Place [m] of the first joint of a moving body."""
        return np.array(self._copy.xanchor[self.model.body_jntadr[root]])

    def _frame(self, root: int) -> Floats:
        return np.array(self._copy.xmat[root]).reshape(3, 3)

    def _members(self, root: int) -> list[int]:
        if root not in self._groups:
            found = [b for b in range(1, self.model.nbody) if self.model.body_weldid[b] == root]
            self._groups[root] = found
        return self._groups[root]

    def _centre(self, root: int) -> Floats:
        members = self._members(root)
        masses = self.model.body_mass[members]
        if len(members) == 1 or not masses.sum() > 0.0:
            return np.array(self._copy.xipos[root])
        centre: Floats = masses @ self._copy.xipos[members] / masses.sum()
        return centre

    def _inertia(self, root: int, axes: Floats) -> Floats:
        """Inertia [kg m²] about the centre of mass, in the axes of the shape."""
        m, c, centre = self.model, self._copy, self._centre(root)
        total = np.zeros((3, 3))
        for b in self._members(root):
            turn, away = np.array(c.ximat[b]).reshape(3, 3), c.xipos[b] - centre
            total += turn @ np.diag(m.body_inertia[b]) @ turn.T
            total += m.body_mass[b] * (away @ away * np.eye(3) - np.outer(away, away))
        shape = self._frame(root) @ axes
        found: Floats = shape.T @ total @ shape
        return found

    def _add(self, root: int, geoms: list[int]) -> None:
        m, c, g = self.model, self._copy, geoms[0]
        own = m.body(root).name if root else ""
        name = own or m.geom(g).name or (f"body-{root}" if root else f"geom-{g}")
        mass = float(sum(m.body_mass[b] for b in self._members(root))) if root else 0.0
        if root and not mass > 0.0:
            raise ValueError(f"body {name!r}: has no mass")
        plane = m.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE
        axes = np.eye(3)
        at = None
        if len(geoms) == 1:
            surface = "" if plane else geom_surface(m, g, name, self._folder)
            axes = AXIS_Y_TO_Z if m.geom_type[g] == mujoco.mjtGeom.mjGEOM_CYLINDER else axes
            reach = float(m.geom_rbound[g])
            if root:
                turn = np.array(c.geom_xmat[g]).reshape(3, 3) @ axes
                axes, away = self._frame(root).T @ turn, self._centre(root) - c.geom_xpos[g]
                at, reach = turn.T @ away, reach + float(np.linalg.norm(away))
        else:
            surface, reach = self._union(root, geoms, name)
            at = np.zeros(3)
        body = RigidBody(name, root, geoms, mass, axes, reach)
        state = self.state(body)
        shape = BodyShape(name, surface, self._material(body), mass, state.place, state.rotation, plane)
        shape.inertia = self._inertia(root, axes) if root else None
        shape.centre = off_centre(surface, at, reach)
        self.bodies.append(body)
        self.shapes.append(shape)
        self.of_geom.update({geom: body for geom in geoms})

    def _union(self, root: int, geoms: list[int], name: str) -> tuple[str, float]:
        c, frame, centre = self._copy, self._frame(root), self._centre(root)
        placed, reach = [], 0.0
        for g in geoms:
            place = frame.T @ (c.geom_xpos[g] - centre)
            placed.append((g, place, frame.T @ np.array(c.geom_xmat[g]).reshape(3, 3)))
            reach = max(reach, float(np.linalg.norm(place) + self.model.geom_rbound[g]))
        return union_surface(self.model, placed, name, self._folder), reach

    def _material(self, body: RigidBody) -> Material:
        m = self.model
        names = [m.geom(g).name for g in body.geoms]
        names += [m.body(int(m.geom_bodyid[g])).name for g in body.geoms] + [body.name]
        keys = [key for key in names if key in self._materials]
        self._used.update(keys)
        if not keys:
            warnings.warn(f"{body.name!r} has no material: steel is taken", stacklevel=6)
        return self._materials[keys[0]] if keys else "steel"
