"""Effective mass of PyBullet's links: the answer of the simulator to a force, a closed form, impacts."""

import warnings
from pathlib import Path

import numpy as np
import pytest

pybullet = pytest.importorskip("pybullet")
pytest.importorskip("pyarrow")
pytest.importorskip("manifold3d")


@pytest.fixture()
def client():
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


def turned(*angles):
    return pybullet.getQuaternionFromEuler(angles)


def arm(base_mass=0.0, second=None, at=(0.0, 0.0, 0.15), angles=(0.3, -0.2, 0.5)):
    """Three links; bases, inertial frames and joints are offset and turned."""
    box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.06, 0.01, 0.008])
    base = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.02, 0.02, 0.02])
    kinds = [pybullet.JOINT_REVOLUTE, second or pybullet.JOINT_REVOLUTE, pybullet.JOINT_REVOLUTE]
    made = pybullet.createMultiBody(
        base_mass,
        base,
        basePosition=at,
        baseOrientation=turned(*angles),
        baseInertialFramePosition=[0.002, 0.003, 0.001],
        baseInertialFrameOrientation=turned(0.4, 0.1, 0.2),
        linkMasses=[0.2, 0.15, 0.1],
        linkCollisionShapeIndices=[box] * 3,
        linkVisualShapeIndices=[-1] * 3,
        linkPositions=[[0.05, 0, 0], [0.16, 0, 0.01], [0.16, 0, 0]],
        linkOrientations=[turned(0.1, 0.2, 0), turned(0, 0.1, 0.3), [0, 0, 0, 1]],
        linkInertialFramePositions=[[0.07, 0, 0.002], [0.09, 0.005, 0.004], [0.08, 0.001, 0]],
        linkInertialFrameOrientations=[turned(0.2, 0, 0), turned(0.1, 0.2, 0.3), [0, 0, 0, 1]],
        linkParentIndices=[0, 1, 2],
        linkJointTypes=kinds,
        linkJointAxis=[[0, 1, 0], [0.6, 0, 0.8], [0, 0, 1]],
    )
    loose(made)
    for link, angle in enumerate((0.4, 0.03, -0.6)):
        pybullet.resetJointState(made, link, angle if kinds[link] != pybullet.JOINT_FIXED else 0.0)
    return made


def loose(body):
    for link in range(-1, pybullet.getNumJoints(body)):
        still = dict(linearDamping=0.0, angularDamping=0.0, jointDamping=0.0)
        pybullet.changeDynamics(body, link, **still)
        if link >= 0 and pybullet.getJointInfo(body, link)[2] != pybullet.JOINT_FIXED:
            pybullet.setJointMotorControl2(body, link, pybullet.VELOCITY_CONTROL, force=0)


def recorder_of(client):
    import clangor.pybullet as cp

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return cp.Recorder(client, {})


def masses_and_answers(client, pairs):
    """Per pair of bodies and links: the effective mass and that by the simulator's own step."""
    step, size, random, found = 1e-6, 1e-3, np.random.default_rng(3), []
    pybullet.setTimeStep(step, client)
    for body in range(pybullet.getNumBodies(client)):
        for other in range(pybullet.getNumBodies(client)):
            for a in range(-1, pybullet.getNumJoints(body)):
                for b in range(-1, pybullet.getNumJoints(other)):
                    pybullet.setCollisionFilterPair(body, other, a, b, 0)
    recorder = recorder_of(client)
    for first, second in pairs:
        a, b = (recorder._bodies.of_link[key] for key in (first, second))
        recorder._bodies.read()
        recorder._masses.start()
        before = {body.name: recorder._bodies.state(body) for body in recorder._bodies.bodies}
        point = before[a.name].place + 0.05 * random.normal(size=3)
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        mass = recorder._masses.of((a, b), point, normal, before)
        saved = pybullet.saveState()
        for group, sign in ((a, 1.0), (b, -1.0)):
            if group.moving:
                force = (sign * size * normal).tolist()
                pybullet.applyExternalForce(*group.key, force, point.tolist(), pybullet.WORLD_FRAME)
        pybullet.stepSimulation(client)
        recorder._bodies.read()
        after = {body.name: recorder._bodies.state(body) for body in recorder._bodies.bodies}
        change = 0.0
        for group, sign in ((a, 1.0), (b, -1.0)):
            arm = point - before[group.name].place
            ends = [s[group.name].velocity + np.cross(s[group.name].spin, arm) for s in (before, after)]
            change += sign * (ends[1] - ends[0]) @ normal
        pybullet.restoreState(saved)
        found.append((mass, size * step / change))
    return found


@pytest.mark.parametrize("second", ["hinge", "slide", "fixed"])
@pytest.mark.parametrize("base_mass", [0.0, 0.3])
def test_the_simulator_answers_a_force_with_the_effective_mass(client, base_mass, second):
    kind = dict(hinge=pybullet.JOINT_REVOLUTE, slide=pybullet.JOINT_PRISMATIC, fixed=pybullet.JOINT_FIXED)
    made = arm(base_mass, kind[second])
    box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.03, 0.02, 0.01])
    free = pybullet.createMultiBody(0.25, box, basePosition=[0.3, 0.2, 0.1], baseOrientation=turned(1, 2, 3))
    still = pybullet.createMultiBody(0, box, basePosition=[0.3, -0.2, 0.1])
    loose(free)
    other = arm(0.2, at=(0.5, 0.5, 0.5), angles=(-1.0, 0.4, 2.0))
    pairs = [((made, k), (still, -1)) for k in range(3)]
    pairs += [((made, k), (free, -1)) for k in range(3)]
    pairs += [((made, k), (other, 2)) for k in range(3)]
    pairs += [((made, 2), (made, 0)), ((other, -1), (still, -1)), ((other, 2), (other, -1))]
    pairs += [((made, 2), (made, -1)), ((other, -1), (free, -1))]
    rows = masses_and_answers(client, pairs)
    errors = [abs(mass / answer - 1.0) for mass, answer in rows]
    for pair, (mass, answer) in zip(pairs, rows):
        print(pair, f"{mass:.5f} kg, {answer:.5f} by a step")
    print("largest error", max(errors), "bar 1e-5")
    # Residual seen: 8e-7, of the smallest change of speed.
    assert max(errors) < 1e-5


@pytest.mark.parametrize("fixed", [True, False])
@pytest.mark.parametrize("file", ["r2d2.urdf", "kuka_iiwa/model.urdf"])
def test_robots_answer_a_force_with_the_effective_mass(client, file, fixed):
    data = pytest.importorskip("pybullet_data").getDataPath()
    made = pybullet.loadURDF(f"{data}/{file}", [0, 0, 1], turned(0.3, 0.5, -1.0), useFixedBase=fixed)
    loose(made)
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.03)
    free = pybullet.createMultiBody(0.5, shape, basePosition=[0.4, 0.1, 1.45])
    joints = range(pybullet.getNumJoints(made))
    moving = [k for k in joints if pybullet.getJointInfo(made, k)[2] != pybullet.JOINT_FIXED]
    for link in moving:
        low, high = pybullet.getJointInfo(made, link)[8:10]
        pybullet.resetJointState(made, link, 0.6 * low + 0.4 * high if low < high else 0.1 + 0.05 * link)
    loose(free)
    rows = masses_and_answers(client, [((made, k), (free, -1)) for k in moving])
    errors = [abs(mass / answer - 1.0) for mass, answer in rows]
    print(file, "fixed" if fixed else "free", len(errors), "links, largest error", max(errors), "bar 1e-6")
    # Residual seen: 5e-8.
    assert max(errors) < 1e-6


def test_a_double_pendulum_has_the_effective_mass_of_its_lagrangian(client):
    """Two balls on massless rods of 0.2 and 0.15 m, the second hinge at 0.25 m; the lower ball is hit."""
    (m1, m2), (c1, c2), long, radius = (0.3, 0.2), (0.2, 0.15), 0.25, 0.02
    shapes = []
    for c in (c1, c2):
        options = dict(radius=radius, collisionFramePosition=[0, 0, -c])
        shapes.append(pybullet.createCollisionShape(pybullet.GEOM_SPHERE, **options))
    made = pybullet.createMultiBody(
        0,
        -1,
        basePosition=[0, 0, 1],
        linkMasses=[m1, m2],
        linkCollisionShapeIndices=shapes,
        linkVisualShapeIndices=[-1] * 2,
        linkPositions=[[0, 0, 0], [0, 0, -long]],
        linkOrientations=[[0, 0, 0, 1]] * 2,
        linkInertialFramePositions=[[0, 0, -c1], [0, 0, -c2]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]] * 2,
        linkParentIndices=[0, 1],
        linkJointTypes=[pybullet.JOINT_REVOLUTE] * 2,
        linkJointAxis=[[0, 1, 0]] * 2,
    )
    for link, mass in enumerate((m1, m2)):
        inertia = [0.4 * mass * radius**2] * 3
        pybullet.changeDynamics(made, link, localInertiaDiagonal=inertia)
    wall = pybullet.createMultiBody(0, shapes[0], basePosition=[2, 0, 0])
    pybullet.resetJointState(made, 0, 0.7)
    pybullet.resetJointState(made, 1, -1.1)
    recorder = recorder_of(client)
    recorder._masses.start()
    pair = recorder._bodies.of_link[made, 1], recorder._bodies.of_link[wall, -1]
    states = {group.name: recorder._bodies.state(group) for group in pair}
    ball, angle = states[pair[0].name].place, np.arctan2(0.3, -1.0)
    normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
    found = recorder._masses.of(pair, ball - radius * normal, normal, states)
    # Angles a and b against the vertical: x = -L sin a - c sin b, z = -L cos a - c cos b of the lower ball.
    a, b = 0.7, 0.7 - 1.1
    i1, i2 = (0.4 * m * radius**2 for m in (m1, m2))
    mixed = m2 * long * c2 * np.cos(a - b)
    both = [[i1 + m1 * c1**2 + m2 * long**2, mixed], [mixed, i2 + m2 * c2**2]]
    row = [length * (np.array([-np.cos(t), 0.0, np.sin(t)]) @ normal) for length, t in ((long, a), (c2, b))]
    wanted = 1.0 / (np.array(row) @ np.linalg.solve(both, row))
    print(f"{found:.6f} kg of a ball of {m2} kg: {abs(found / wanted - 1.0):.1e}, bar 1e-6")
    # Residual seen: 2e-7.
    assert abs(found / wanted - 1.0) < 1e-6 and found > 1.2 * m2


def test_impacts_of_links_have_it_and_those_of_bodies_alone_have_none(client, tmp_path):
    import clangor
    import clangor.pybullet as cp
    from clangor.recording import write_timeline

    made = arm(angles=(0.0, 0.0, 0.0))
    slab = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.4, 0.4, 0.01])
    board = pybullet.createMultiBody(0, slab, basePosition=[0.3, 0, 0])
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.02)
    ball = pybullet.createMultiBody(0.1, shape, basePosition=[0.1, 0.3, 0.1])
    pybullet.setGravity(0.0, 0.0, -9.80665, client)
    pybullet.setTimeStep(0.00025, client)
    materials = {made: "steel", board: "wood", ball: "steel"}
    cp.hear_as(client, materials)
    recorder = cp.Recorder(client, materials)
    for _ in range(1200):
        recorder.step()
    recorder.stop()
    impacts = recorder.recording.impacts
    free = [i for i in impacts if i.a == f"body-{ball}" and i.b == f"body-{board}"]
    joined = [i for i in impacts if i.a.startswith(f"body-{made}-link")]
    print(len(free), "impacts of the ball,", len(joined), "of links, masses", {i.mass for i in joined})
    assert free and joined
    assert all(i.mass is None for i in free) and all(i.mass > 0.0 for i in joined)
    scene = Path(recorder._folder.name) / "scene.toml"
    write_timeline(recorder.recording, scene, tmp_path / "run.timeline", [(0.0, 1.0, 0.0)])
    rows = clangor.Timeline.open(tmp_path / "run.timeline").contacts
    written = np.sort(rows["effective_mass"][np.isfinite(rows["effective_mass"])])
    assert np.array_equal(written, np.sort([np.float32(i.mass) for i in joined]))
