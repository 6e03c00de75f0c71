"""Effective mass of MuJoCo's links at their impacts: closed forms, the answer to a force, the timeline."""

import warnings
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
pyarrow_parquet = pytest.importorskip("pyarrow.parquet")

HEAD = """<mujoco><option timestep="0.00025" gravity="0 0 -9.80665" integrator="Euler"/>
<default><geom solref="0.002 0.215" solimp="0.95 0.99 0.001" density="2000"/></default><worldbody>"""
TAIL = "</worldbody></mujoco>"
LINK = """<body name="{name}" pos="{place}">{joint}
<geom type="capsule" size=".01" fromto="0 0 0 .15 0 0"/>{inside}</body>"""
HINGE = '<joint type="hinge" axis="0 1 0" armature="{armature}"/>'
BALL = """<body name="ball" pos=".32 .002 .4"><freejoint/><geom type="sphere" size=".02"/></body>
<body name="other" pos=".32 .012 .5"><freejoint/><geom type="sphere" size=".02"/></body>"""
POST = '<geom name="table" type="box" size=".03 .2 .01" pos=".1 0 .08"/>'
WALL = '<geom name="table" type="box" size=".3 .2 .01" pos=".4 0 0"/>'


def arm(links, joint=None, armature=0.0):
    inside = ""
    for k in reversed(range(links)):
        first = (joint or HINGE.format(armature=armature)) if k == 0 else HINGE.format(armature=armature)
        place = ".18 0 0" if k else "0 0 .15"
        inside = LINK.format(name=f"link{k}", place=place, joint=first, inside=inside)
    return inside


def recorded(monkeypatch, bodies, seconds):
    """A recorder after a run, and the arguments and answers of all effective masses with their positions."""
    import clangor.mujoco as cm
    from clangor.mujoco_bodies import Bodies

    model, calls = mujoco.MjModel.from_xml_string(HEAD + bodies + TAIL), []
    own = Bodies.effective_mass

    def logged(self, a, b, point, normal):
        mass = own(self, a, b, point, normal)
        calls.append((a.root, b.root, point.copy(), normal.copy(), mass, self._copy.qpos.copy()))
        return mass

    monkeypatch.setattr(Bodies, "effective_mass", logged)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        recorder = cm.Recorder(model, mujoco.MjData(model))
        for _ in range(round(seconds / 0.00025)):
            recorder.step()
    recorder.stop()
    return recorder, calls


def answer(model, bodies, point, normal, place):
    """Effective mass by the simulator's own step: forces of 1 N on both bodies at rest, without contact."""
    data, step = mujoco.MjData(model), float(model.opt.timestep)
    flags, gravity = int(model.opt.disableflags), model.opt.gravity.copy()
    model.opt.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    model.opt.gravity[:], model.opt.timestep = 0.0, 1e-7
    data.qpos[:] = place
    mujoco.mj_forward(model, data)
    arms = []
    for body, sign in zip(bodies, (1.0, -1.0)):
        arms.append(point - data.xipos[body])
        data.xfrc_applied[body, :3] += sign * normal
        data.xfrc_applied[body, 3:] += np.cross(arms[-1], sign * normal)
    mujoco.mj_step(model, data)
    speed = 0.0
    for body, far, sign in zip(bodies, arms, (1.0, -1.0)):
        both = np.zeros(6)
        if body:
            data.qpos[:] = place
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, both, 0)
        speed += sign * (both[3:] + np.cross(both[:3], far)) @ normal
    model.opt.disableflags, model.opt.gravity[:], model.opt.timestep = flags, gravity, step
    return 1e-7 / speed


@pytest.mark.parametrize("armature", [0.0, 0.01])
def test_a_pendulum_has_its_moment_over_the_square_of_the_arm(monkeypatch, armature):
    recorder, calls = recorded(monkeypatch, POST + arm(1, armature=armature), 0.4)
    model = recorder.model
    assert calls and recorder.recording.impacts
    place = model.body_ipos[1]
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[1])
    turn = turn.reshape(3, 3)
    inertia = (turn @ np.diag(model.body_inertia[1]) @ turn.T)[1, 1]
    moment = armature + inertia + model.body_mass[1] * place @ place
    worst = 0.0
    for _, _, point, normal, mass, _ in calls:
        lever = np.cross(point - np.array([0, 0, 0.15]), normal)[1]
        worst = max(worst, abs(mass * lever**2 / moment - 1.0))
    print(f"I/r^2 {moment / lever**2:.4f} kg of a link of {model.body_mass[1]:.4f}: {worst:.1e}, bar 1e-12")
    # Residual seen: 6e-16.
    assert worst < 1e-12


def test_two_links_have_the_effective_mass_of_their_lagrangian(monkeypatch):
    recorder, calls = recorded(monkeypatch, WALL + arm(2), 0.4)
    model, worst, struck = recorder.model, 0.0, set()
    (m1, m2), (c1, c2), long = model.body_mass[1:3], model.body_ipos[1:3, 0], 0.18
    # A capsule along x: its moments about y and z are alike, the third is that about its axis.
    i1, i2 = model.body_inertia[1:3].max(axis=1)
    for first, second, point, normal, mass, (q1, q2) in calls:
        body = max(first, second)
        struck.add(body)
        mixed = m2 * long * c2 * np.cos(q2)
        # Angles of both links against the world; a positive one turns x to -z.
        both = np.array([[i1 + m1 * c1**2 + m2 * long**2, mixed], [mixed, i2 + m2 * c2**2]])
        elbow = np.array([long * np.cos(q1), 0.0, 0.15 - long * np.sin(q1)])
        lever = np.cross(point - np.array([0.0, 0.0, 0.15]), normal)[1]
        row = np.array([lever, 0.0])
        if body == 2:
            row = np.array([np.cross(elbow - np.array([0.0, 0.0, 0.15]), normal)[1], 0.0])
            row[1] = np.cross(point - elbow, normal)[1]
        worst = max(worst, abs(mass * (row @ np.linalg.solve(both, row)) - 1.0))
    print(len(calls), "masses of links", struck, f"against the Lagrangian: {worst:.1e}, bar 1e-12")
    # Residual seen: 1e-15.
    assert 2 in struck and worst < 1e-12


@pytest.mark.parametrize("kind", ["arm", "doll", "motor"])
def test_the_simulator_answers_a_force_with_the_effective_mass(monkeypatch, kind):
    joint = "<freejoint/>" if kind == "doll" else None
    floor = '<geom name="table" type="plane" size="2 2 .1"/>' if kind == "doll" else WALL
    armature = 0.002 if kind == "motor" else 0.0
    bodies = floor + arm(3, joint, armature) + BALL
    recorder, calls = recorded(monkeypatch, bodies, 0.5)
    pairs = {tuple(sorted((a > 3, b > 3))) for a, b, *_ in calls}
    errors = []
    for a, b, point, normal, mass, place in calls:
        errors.append(abs(mass / answer(recorder.model, (a, b), point, normal, place) - 1.0))
    # Links of one tree against each other, in the last positions.
    from clangor.mujoco_effective_mass import effective_mass

    data, random = mujoco.MjData(recorder.model), np.random.default_rng(5)
    data.qpos[:] = calls[-1][-1]
    mujoco.mj_kinematics(recorder.model, data)
    mujoco.mj_comPos(recorder.model, data)
    for pair in ((1, 2), (1, 3), (3, 2)):
        point = data.xipos[pair[0]] + 0.05 * random.normal(size=3)
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        mass = effective_mass(recorder.model, data, pair, point, normal)
        errors.append(abs(mass / answer(recorder.model, pair, point, normal, data.qpos) - 1.0))
    print(kind, len(errors), "masses, largest error", max(errors), "bar 1e-10")
    # Residual seen: 3e-15.
    assert len(pairs) == 2 and max(errors) < 1e-10
    # A ball on a ball has the effective mass of the bodies alone.
    free = [i for i in recorder.recording.impacts if {i.a, i.b} <= {"ball", "other", "table"}]
    joined = [i for i in recorder.recording.impacts if {i.a, i.b} - {"ball", "other", "table"}]
    assert free and joined
    assert all(i.mass is None for i in free) and all(i.mass is not None for i in joined)


def test_the_timeline_has_the_masses_and_none_without_joints(monkeypatch, tmp_path):
    import clangor
    from clangor.recording import write_timeline

    recorder, calls = recorded(monkeypatch, WALL + arm(2) + BALL, 0.5)
    target = tmp_path / "run.timeline"
    scene = Path(recorder._folder.name) / "scene.toml"
    write_timeline(recorder.recording, scene, target, [(0.0, 1.0, 0.0)])
    rows = clangor.Timeline.open(target).contacts
    wanted = {i.number: i.mass for i in recorder.recording.impacts}
    for number, mass in zip(rows["impact_id"], rows["effective_mass"]):
        expected = wanted.get(int(number)) or np.nan
        assert mass == np.float32(expected) or (np.isnan(mass) and np.isnan(expected))
    found = np.isfinite(rows["effective_mass"])
    assert found.any() and not found.all()
    assert {mass for *_, mass, _ in calls} >= set(wanted.values()) - {None}
    (sound,) = recorder.render()
    assert sound.peak > 0.0 and np.isfinite(sound.pressure).all()

    recorder, calls = recorded(monkeypatch, WALL + BALL, 0.5)
    target = tmp_path / "free.timeline"
    write_timeline(recorder.recording, tmp_path / "scene.toml", target, [(0.0, 1.0, 0.0)])
    names = pyarrow_parquet.read_schema(target / "contacts.parquet").names
    assert recorder.recording.impacts and not calls and "effective_mass" not in names
    assert np.isnan(clangor.Timeline.open(target).contacts["effective_mass"]).all()
