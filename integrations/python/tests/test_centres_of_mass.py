"""Bodies whose centre of mass is not that of their shape: a weighted die in both simulators, and robots."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow")
HALF, MASS, AWAY = 0.008, 0.01, np.array([0.001, -0.0015, 0.002])
INERTIA = np.array([4e-7, 5e-7, 6e-7])
STEP, SECONDS = 0.00025, 0.3
XML = """<mujoco><option gravity="0 0 -9.80665" timestep="0.00025"/>
<default><geom solref="0.002 0.215" solimp="0.95 0.99 0.001"/></default><worldbody>
<geom name="floor" type="plane" size="1 1 .1"/>
<body name="die" pos="0 0 .1" quat="0.9 0.3 0.2 0.1"><freejoint/>
<inertial pos="{away}" mass="0.01" diaginertia="4e-7 5e-7 6e-7"/>{geoms}</body></worldbody></mujoco>"""
CUBE = '<geom type="box" size=".008 .008 .008"/>'
PARTS = "".join(f'<geom type="box" size=".008 .008 .004" pos="0 0 {z}"/>' for z in (-0.004, 0.004))


def mujoco_die(geoms):
    """The recorder, and the true centres and axes of the cube at the start of every step."""
    mujoco = pytest.importorskip("mujoco")
    import clangor.mujoco as cm

    model = mujoco.MjModel.from_xml_string(XML.format(away=" ".join(map(str, AWAY)), geoms=geoms))
    data, frames = mujoco.MjData(model), []
    recorder = cm.Recorder(model, data, {"die": "plastic", "floor": "granite"})
    for _ in range(round(SECONDS / STEP)):
        mujoco.mj_kinematics(model, data)
        frames.append((data.xpos[1].copy(), data.xmat[1].reshape(3, 3).copy()))
        recorder.step()
    return recorder, frames


def pybullet_die():
    pybullet = pytest.importorskip("pybullet")
    import clangor.pybullet as cp

    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.80665, client)
    pybullet.setTimeStep(STEP, client)
    floor = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[HALF] * 3)
    options = dict(basePosition=[0, 0, 0.1], baseOrientation=pybullet.getQuaternionFromEuler([0.4, 0.5, 0.6]))
    die = pybullet.createMultiBody(MASS, shape, baseInertialFramePosition=AWAY.tolist(), **options)
    pybullet.changeDynamics(die, -1, localInertiaDiagonal=INERTIA.tolist())
    materials, frames = {floor: "granite", die: "plastic"}, []
    cp.hear_as(client, materials)
    recorder = cp.Recorder(client, materials)
    for _ in range(round(SECONDS / STEP)):
        place, turn = pybullet.getBasePositionAndOrientation(die, client)
        turn = np.array(pybullet.getMatrixFromQuaternion(turn)).reshape(3, 3)
        frames.append((np.array(place) - turn @ AWAY, turn))
        recorder.step()
    pybullet.disconnect(client)
    return recorder, frames


def vertices(folder, row):
    """Vertices [m] of a body of a timeline about its centre of mass, in the axes of its pose."""
    file = folder / "meshes" / f"{row['surface']['mesh']['hash']}.ply"
    head, _, data = file.read_bytes().partition(b"end_header\n")
    words = head.decode().split()
    count, columns = int(words[words.index("vertex") + 1]), words.count("double")
    return np.frombuffer(data, "<f8", count * columns).reshape(count, columns)[:, :3]


@pytest.mark.parametrize("made", ["mujoco box", "mujoco two boxes", "pybullet box"])
def test_a_weighted_die_keeps_its_mass_centre_and_inertia_and_is_heard(made):
    if made == "pybullet box":
        recorder, frames = pybullet_die()
    else:
        recorder, frames = mujoco_die(CUBE if made == "mujoco box" else PARTS)
    (body,) = [body for body in recorder.recording.bodies if body.mass > 0.0]
    worst = 0.0
    for row, (place, turn) in zip(recorder.recording.poses, frames):
        worst = max(worst, np.abs(row[2] - place - turn @ AWAY).max(), np.abs(row[3] - turn).max())
    ledger = max(row[2] for row in recorder.ledger) / max(row[3] for row in recorder.ledger)
    print(made, "poses:", worst, "bar 1e-9; ledger", ledger, "bar 1e-2")
    assert worst < 1e-9 and ledger < 1e-2 and recorder.recording.impacts
    (sound,) = recorder.render()
    assert sound.peak > 0.0 and np.isfinite(sound.pressure).all()
    folder = Path(recorder._folder.name) / "run.timeline"
    rows = json.loads((folder / "timeline.json").read_text())["bodies"]
    (row,) = [row for row in rows if row["name"] == body.name]
    assert row["mass"] == pytest.approx(MASS)
    assert np.array(row["inertia"]).reshape(3, 3) == pytest.approx(np.diag(INERTIA), rel=1e-6, abs=1e-12)
    points = vertices(folder, row)
    low, high = points.min(axis=0) + AWAY, points.max(axis=0) + AWAY
    # Parts of a union grow by up to 8e-6 m.
    print("corners of the cube:", low, high, "bar 2e-5 m")
    assert low == pytest.approx([-HALF] * 3, abs=2e-5) and high == pytest.approx([HALF] * 3, abs=2e-5)


@pytest.mark.parametrize("name", ["humanoid", "ant", "half_cheetah", "hopper", "walker2d", "pusher"])
def test_robots_of_gymnasium_are_recorded(name):
    """Where capsules overlap, MuJoCo counts their mass twice: centres of mass are not those of unions."""
    mujoco = pytest.importorskip("mujoco")
    gymnasium = pytest.importorskip("gymnasium")
    pytest.importorskip("manifold3d")
    import clangor.mujoco as cm

    folder = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
    files = [file for file in (folder / f"{name}.xml", folder / f"{name}_v5.xml") if file.is_file()]
    if not files:
        pytest.skip(f"gymnasium has no {name}.xml")
    model = mujoco.MjModel.from_xml_path(str(files[-1]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        recorder = cm.Recorder(model, mujoco.MjData(model))
        for _ in range(50):
            recorder.step()
    moving = [body for body in recorder.recording.bodies if body.mass > 0.0]
    print(name, len(moving), "moving bodies")
    assert moving and all(np.linalg.eigvalsh(body.inertia)[0] > 0.0 for body in moving)
