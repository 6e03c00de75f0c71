"""Rigid bodies of a PyBullet world: which links form one, their mass, inertia, pose and velocity.

A base and its links are numbered -1, 0, 1, ... Links that are fixed to their parent are one body with it:
m = sum m_i, c = sum m_i c_i / m, and the inertia about c by the parallel axes. Bullet gives poses and
velocities of the inertial frame, whose origin is the centre of mass of the link: that of a body is at
p + R c, with the velocity v + w x R c. A base without mass does not move. No force is computed here.
"""

from __future__ import annotations

import warnings
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

import numpy as np
import pybullet  # type: ignore[import-not-found]

from .joint_impulses import Joints, Link
from .material_pairs import Material, check_material
from .pybullet_shapes import Part, link_parts, rotation
from .recorded_run import State
from .recording import BodyShape, Floats, cross
from .surfaces import off_centre, union, write_obj

__all__ = ["Bodies", "Key", "RigidBody", "body_numbers", "check_keys", "link_material", "moves"]

Key = Union[int, tuple[int, int]]
"""Number of a body, or of a body and a link."""


def body_numbers(client: int) -> list[int]:
    """The numbers of all bodies."""
    return [int(pybullet.getBodyUniqueId(k, client)) for k in range(pybullet.getNumBodies(client))]


def check_keys(client: int, materials: Mapping[Key, Material]) -> None:
    """Errors: ValueError for a body or link that the world has not, or for a material that is not known."""
    bodies = body_numbers(client)
    for key, material in materials.items():
        body, link = key if isinstance(key, tuple) else (key, -1)
        if body not in bodies:
            raise ValueError(f"materials: the world has no body {body}")
        if not -1 <= link < pybullet.getNumJoints(body, client):
            raise ValueError(f"materials: {_title(client, body, -1)} has no link {link}")
        check_material(material, f"materials[{key}]")


def link_material(materials: Mapping[Key, Material], body: int, links: list[int]) -> Material | None:
    """The material of the first link that has one of its own, else of the body."""
    keys: list[Key] = [*((body, link) for link in links), body]
    return next((materials[key] for key in keys if key in materials), None)


def moves(client: int, body: int, link: int) -> bool:
    """Whether a link can move."""
    root = _root(client, body, link)
    return root >= 0 or float(pybullet.getDynamicsInfo(body, -1, client)[0]) > 0.0


def _root(client: int, body: int, link: int) -> int:
    """The link with which a link forms one body, and which hangs on a joint or is the base."""
    while link >= 0:
        joint = pybullet.getJointInfo(body, link, client)
        if joint[2] != pybullet.JOINT_FIXED:
            return link
        link = joint[16]
    return -1


def _title(client: int, body: int, link: int) -> str:
    name = pybullet.getBodyInfo(body, client)[1].decode()
    title = f"body {body} ({name})" if name else f"body {body}"
    if link < 0:
        return title
    return f"{title}, link {link} ({pybullet.getJointInfo(body, link, client)[12].decode()})"


@dataclass
class RigidBody:
    """Links that move as one; `key` is body and root, `centre` [m] that of mass in the frame of the root.

    The axes of the shape are `axes` times those of the root. `name` is empty if nothing collides.
    """

    key: tuple[int, int]
    links: list[int]
    parent: tuple[int, int] | None
    moving: bool
    name: str = ""
    mass: float = 0.0
    reach: float = 0.0
    """Bounding radius [m]."""

    def __post_init__(self) -> None:
        self.centre, self.axes = np.zeros(3), np.eye(3)


class Bodies:
    """The rigid bodies of the world of `client`, as it is now."""

    def __init__(self, client: int, materials: Mapping[Key, Material], folder: Path) -> None:
        self.client, self._folder = client, folder
        check_keys(client, materials)
        self._groups: dict[tuple[int, int], RigidBody] = {}
        self.of_link: dict[tuple[int, int], RigidBody] = {}
        self.shapes: list[BodyShape] = []
        for body in body_numbers(client):
            for link in range(-1, pybullet.getNumJoints(body, client)):
                self._put(body, link)
        self._raw: dict[tuple[int, int], tuple[Floats, Floats, Floats, Floats]] = {}
        self._anchors: dict[tuple[int, int], Floats] = {}
        self.read()
        for group in self._groups.values():
            self._complete(group, materials)
        self.bodies = [group for group in self._groups.values() if group.name]
        collide = {group.key[0] for group in self.bodies}
        for key in materials:
            body = key[0] if isinstance(key, tuple) else key
            if body not in collide:
                raise ValueError(f"materials: {_title(client, body, -1)} has no collision shape")

    def _put(self, body: int, link: int) -> None:
        """Links are numbered from the base on, so that parents come first."""
        root = _root(self.client, body, link)
        if root == link:
            parent = None
            if link >= 0:
                up = int(pybullet.getJointInfo(body, link, self.client)[16])
                parent = body, _root(self.client, body, up)
            self._groups[body, link] = RigidBody((body, link), [], parent, moves(self.client, body, link))
        self._groups[body, root].links.append(link)
        self.of_link[body, link] = self._groups[body, root]

    def read(self) -> None:
        """Takes poses and velocities from the simulator."""
        roots: dict[int, list[int]] = {}
        for body, root in self._groups:
            roots.setdefault(body, []).append(root)
        for body, links in roots.items():
            place, turn = pybullet.getBasePositionAndOrientation(body, self.client)
            velocity, spin = pybullet.getBaseVelocity(body, self.client)
            self._raw[body, -1] = np.array(place), rotation(turn), np.array(velocity), np.array(spin)
            if not links[1:]:
                continue
            options = dict(computeLinkVelocity=1, computeForwardKinematics=1, physicsClientId=self.client)
            for root, row in zip(links[1:], pybullet.getLinkStates(body, links[1:], **options)):
                self._raw[body, root] = np.array(row[0]), rotation(row[1]), np.array(row[6]), np.array(row[7])
                self._anchors[body, root] = np.array(row[4])

    def state(self, group: RigidBody) -> State:
        """State as last read."""
        place, turn, velocity, spin = self._raw[group.key]
        away = turn @ group.centre
        return State(place + away, turn @ group.axes, velocity + cross(spin, away), spin)

    def base(self, body: int) -> tuple[Floats, Floats]:
        """Place [m] and axes of the inertial frame of the base of a body, as last read."""
        place, turn, _, _ = self._raw[body, -1]
        return place, turn

    def anchors(self) -> dict[tuple[int, int], Floats]:
        """Place [m] of the frame of every root on a joint, as last read."""
        return dict(self._anchors)

    def joints(self) -> Joints:
        """The joints of all moving bodies, recorded or not."""
        names: dict[Hashable, str] = {group.key: group.name for group in self.bodies}
        links = [
            Link(group.key, group.parent, group.mass, group.parent is None)
            for group in self._groups.values()
            if group.moving
        ]
        return Joints(links, names, self._velocity, self._anchor)

    def _velocity(self, key: Any) -> Floats:
        return self.state(self._groups[key]).velocity

    def _anchor(self, key: Any) -> Floats:
        return self._anchors[key]

    def _pose_in(self, group: RigidBody, link: int) -> tuple[Floats, Floats]:
        """Place [m] and axes of the inertial frame of a link in that of the root."""
        if link == group.key[1]:
            return np.zeros(3), np.eye(3)
        options = dict(computeForwardKinematics=1, physicsClientId=self.client)
        row = pybullet.getLinkState(group.key[0], link, **options)
        place, turn = self._raw[group.key][:2]
        return turn.T @ (np.array(row[0]) - place), turn.T @ rotation(row[1])

    def _complete(self, group: RigidBody, materials: Mapping[Key, Material]) -> None:
        """Mass and centre of all links; the surface of those that collide."""
        body, parts, inertia = group.key[0], [], np.zeros((3, 3))
        poses = {link: self._pose_in(group, link) for link in group.links}
        rows = {link: pybullet.getDynamicsInfo(body, link, self.client) for link in group.links}
        group.mass = sum(float(rows[link][0]) for link in group.links) if group.moving else 0.0
        if group.mass > 0.0:
            group.centre = sum(rows[link][0] * poses[link][0] for link in group.links) / group.mass
            for link, (place, turn) in poses.items():
                away = place - group.centre
                inertia += turn @ np.diag(rows[link][2]) @ turn.T
                inertia += rows[link][0] * (away @ away * np.eye(3) - np.outer(away, away))
        for link, (place, turn) in poses.items():
            name = _title(self.client, body, link)
            alone = not group.moving and len(group.links) == 1
            found = link_parts(self.client, (body, link), alone, name)
            parts += [part.moved(place, turn) for part in found]
        if not parts:
            return
        title = _title(self.client, *group.key)
        if group.moving and not group.mass > 0.0:
            raise ValueError(f"{title}: has no mass")
        group.name = f"body-{body}" if group.key[1] < 0 else f"body-{body}-link-{group.key[1]}"
        shape = self._shape(group, parts, title)
        shape.inertia = group.axes.T @ inertia @ group.axes if group.moving else None
        material = link_material(materials, body, group.links)
        if material is None:
            warnings.warn(f"{title} has no material: steel is taken", stacklevel=5)
        shape.material = material or "steel"
        self.shapes.append(shape)

    def _shape(self, group: RigidBody, parts: list[Part], title: str) -> BodyShape:
        """The surface about the centre of mass; where the body does not move, about its first part."""
        first, plane = parts[0], any(part.plane for part in parts)
        if plane and (group.moving or len(parts) > 1):
            raise ValueError(f"{title}: a plane cannot move, nor be one of several shapes")
        at = None
        group.centre = group.centre if group.moving else first.place
        if plane or (len(parts) == 1 and first.line):
            surface, group.axes = first.line, first.axes
            at = first.axes.T @ (group.centre - first.place)
        else:
            meshes = [part.triangles() for part in parts]
            vertices, faces = meshes[0] if len(parts) == 1 else union(meshes, title)
            surface = write_obj(self._folder / f"{group.name}.obj", (vertices - group.centre, faces))
            at = np.zeros(3)
        points = np.concatenate([part.triangles()[0] for part in parts]) - group.centre
        group.reach = 1.0 if plane else float(np.linalg.norm(points, axis=1).max())
        state = self.state(group)
        shape = BodyShape(group.name, surface, "steel", group.mass, state.place, state.rotation, plane)
        shape.centre = off_centre(surface, at, group.reach) if group.moving else None
        return shape
