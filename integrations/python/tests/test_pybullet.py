"""Recording PyBullet: the momentum ledger, bounces of a ball, its sound beside our own simulation."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

pybullet = pytest.importorskip("pybullet")
pytest.importorskip("pyarrow")
GRAVITY = (0.0, 0.0, -9.80665)


@pytest.fixture()
def client():
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(*GRAVITY, number)
    yield number
    pybullet.disconnect(number)


def world(client, step, height=0.5, radius=0.01):
    pybullet.setTimeStep(step, client)
    floor = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=radius)
    mass = 7850.0 * 4.0 / 3.0 * np.pi * radius**3
    ball = pybullet.createMultiBody(mass, shape, basePosition=[0, 0, radius + height])
    return floor, ball


def recorded(client, step, seconds, materials):
    import clangor.pybullet as cp

    recorder = cp.Recorder(client, materials)
    for _ in range(round(seconds / step)):
        recorder.step()
    recorder.stop()
    return recorder


def bounces(recorder):
    """Speed after over speed before, above 0.1 m/s and 20 g dt: Bullet takes the restitution of v + g dt."""
    least = max(0.1, 20.0 * 9.80665 * recorder.dt)
    times = np.array([row[0] for row in recorder.recording.poses])
    speeds = np.array([row[4][2] for row in recorder.recording.poses])
    found = []
    for impact in recorder.recording.impacts:
        k = np.searchsorted(times, impact.time + impact.window - 1e-9)
        if k < len(times) and -impact.velocity[2] > least:
            found.append(-speeds[k] / impact.velocity[2])
    return found


def worst(recorder):
    return max(row[2] for row in recorder.ledger) / max(row[3] for row in recorder.ledger)


@pytest.mark.parametrize("wanted", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("step", [1 / 240, 0.001, 0.00025])
def test_every_bounce_has_the_restitution_that_is_set_and_the_ledger_closes(client, step, wanted):
    import clangor.pybullet as cp

    for height in (0.3, 0.4, 0.5, 0.5003, 0.6):
        pybullet.resetSimulation(client)
        pybullet.setGravity(*GRAVITY, client)
        floor, ball = world(client, step, height)
        materials = {floor: "granite", ball: "steel"}
        cp.hear_as(client, materials, wanted)
        recorder = recorded(client, step, 1.0, materials)
        found = bounces(recorder)
        speed, time, count = (2.0 * 9.80665 * height) ** 0.5, (2.0 * height / 9.80665) ** 0.5, 0
        while time < 1.0 and speed > 0.1:
            speed, count = speed * wanted, count + 1
            time += 2.0 * speed / 9.80665
        print(f"{step:.5f} s, {height} m: {np.round(found, 3)} wanted {wanted} +- 0.05;", worst(recorder))
        assert found and found == pytest.approx([wanted] * len(found), abs=0.05)
        assert max(found) < 1.0 and worst(recorder) < 1e-9
        assert sum(-i.velocity[2] > 0.1 for i in recorder.recording.impacts) >= count - 1


def test_an_impact_of_two_steps_is_one_with_the_whole_change_of_momentum(client):
    """Without `hear_as`, Bullet takes bounces in two steps; the impulse is that of both."""
    step = 0.00025
    floor, ball = world(client, step, 0.41)
    settings = dict(restitutionVelocityThreshold=0.02, erp=0, contactERP=0, contactBreakingThreshold=0.02)
    pybullet.setPhysicsEngineParameter(**settings, physicsClientId=client)
    for body in (floor, ball):
        pybullet.changeDynamics(body, -1, restitution=0.6**0.5, linearDamping=0, angularDamping=0)
    recorder = recorded(client, step, 1.0, {floor: "granite", ball: "steel"})
    poses, mass = recorder.recording.poses, pybullet.getDynamicsInfo(ball, -1, client)[0]
    times = np.array([row[0] for row in poses])
    speeds = np.array([row[4][2] for row in poses])
    for impact in recorder.recording.impacts:
        k = round(impact.time / step)
        after = speeds[np.searchsorted(times, impact.time + impact.window - 1e-9)]
        change = mass * (after - speeds[k])
        print("impact of", impact.window / step, "steps:", impact.impulse[2] / change - 1.0, "bar 0.01")
        assert impact.impulse[2] == pytest.approx(change, rel=0.01)
    assert max(impact.window for impact in recorder.recording.impacts) > 1.5 * step


def test_the_clicks_are_those_of_our_own_simulation(client):
    import clangor
    import clangor.pybullet as cp

    scene = """version = 1
[simulation]
duration = 1.0
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "{ball}"
position = [0, 0.51, 0]
[[plane]]
name = "floor"
material = "{floor}"
[[listener]]
position = [0.3, 0.4, -0.3]
"""
    for first, second in (("steel", "granite"), ("wood", "granite")):
        ours = clangor.Session(text=scene.format(ball=first, floor=second), sample_rate=192000)
        rows = ours.simulate().contacts
        (wanted,) = ours.render()
        for step in (0.00025, 0.001):
            pybullet.resetSimulation(client)
            pybullet.setGravity(*GRAVITY, client)
            floor, ball = world(client, step)
            pybullet.changeDynamics(ball, -1, mass=ours.bodies[0].mass)
            materials = {floor: second, ball: first}
            cp.hear_as(client, materials)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                recorder = recorded(client, step, 1.0, materials)
            recorder.session((0.3, 0.3, 0.4))
            path = Path(recorder._folder.name) / "run.timeline"
            place = [(0.3, 0.4, -0.3)]
            (heard,) = clangor.Session(path, listeners=place, sample_rate=192000).render()
            impacts = [i.time for i in recorder.recording.impacts]
            their = rows["t"][rows["kind"] == 0]
            pairs = [(a, b) for a, b in zip(impacts, their) if max(a, b) < 0.99]
            levels = [20.0 * np.log10(peak(heard, a) / peak(wanted, b)) for a, b in pairs]
            print(first, second, step, "clicks", np.round(levels, 2), "dB, bars 1 and 2")
            assert len(levels) >= 2 and abs(levels[0]) < 1.0 and max(map(abs, levels)) < 2.0


def peak(sound, time):
    """Largest pressure within 3 ms of the arrival of the click."""
    arrival = time + np.hypot(np.hypot(0.3, 0.3), 0.39) / 343.2
    first, last = (round((arrival + d) * sound.sample_rate) for d in (-0.003, 0.003))
    return float(np.abs(sound.pressure[max(first, 0) : last]).max())


def test_shapes_meshes_and_inertia_are_kept(client):
    import clangor.pybullet as cp

    pytest.importorskip("manifold3d")
    pybullet.setTimeStep(0.00025, client)
    floor = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    corners = [[0, 0, 0], [0.05, 0, 0], [0, 0.05, 0], [0, 0, 0.05]]
    made = [
        (dict(shapeType=pybullet.GEOM_CAPSULE, radius=0.01, height=0.05), [0, 0, 0]),
        (dict(shapeType=pybullet.GEOM_CYLINDER, radius=0.02, height=0.02), [0, 0, 0]),
        (dict(shapeType=pybullet.GEOM_MESH, vertices=corners), [0.0125] * 3),
    ]
    turn = pybullet.getQuaternionFromEuler([1.2, 0.3, 0.1])
    bodies = []
    for k, (shape, centre) in enumerate(made):
        number = pybullet.createCollisionShape(**shape)
        options = dict(basePosition=[0.2 * k, 0, 0.2], baseOrientation=turn)
        bodies.append(pybullet.createMultiBody(0.05, number, baseInertialFramePosition=centre, **options))
    materials = {floor: "granite", **{body: "wood" for body in bodies}}
    cp.hear_as(client, materials)
    recorder = recorded(client, 0.00025, 0.35, materials)
    print("ledger", worst(recorder), "bar 1e-9")
    assert worst(recorder) < 1e-9
    for body in bodies:
        first = next(i for i in recorder.recording.impacts if i.a == f"body-{body}")
        print(first.a, "first point", first.point[2], "m above the floor, bar 1e-3")
        assert abs(first.point[2]) < 1e-3
    recorder.session()
    path = Path(recorder._folder.name) / "run.timeline" / "timeline.json"
    rows = {row["name"]: row for row in json.loads(path.read_text())["bodies"]}
    for body in bodies:
        diagonal = sorted(pybullet.getDynamicsInfo(body, -1, client)[2])
        found = sorted(np.linalg.eigvalsh(rows[f"body-{body}"]["inertia"]))
        assert found == pytest.approx(diagonal, rel=1e-6)


def test_a_material_of_ones_own_gives_restitution_and_density(client):
    import clangor.pybullet as cp

    floor, ball = world(client, 0.00025)
    materials = {floor: "granite", ball: {"base": "wood", "restitution": 0.3, "density": 700.0}}
    cp.hear_as(client, materials)
    recorder = recorded(client, 0.00025, 0.5, materials)
    wanted, found = (0.3 * 0.83) ** 0.5, bounces(recorder)[0]
    print("restitution", found, "geometric mean", wanted, "+- 0.05")
    assert found == pytest.approx(wanted, abs=0.05)
    recorder.session()
    path = Path(recorder._folder.name) / "run.timeline" / "timeline.json"
    (row,) = [r for r in json.loads(path.read_text())["bodies"] if r["name"] == f"body-{ball}"]
    assert row["material"]["density"] == 700.0


def test_what_cannot_be_recorded_is_refused_by_name(client):
    import clangor.pybullet as cp

    floor, ball = world(client, 0.001)
    with pytest.raises(ValueError, match="no body 7"):
        cp.Recorder(client, {7: "steel"})
    with pytest.raises(ValueError, match=r"materials\[1\]: no preset is called 'unobtainium'"):
        cp.Recorder(client, {floor: "granite", ball: "unobtainium"})
