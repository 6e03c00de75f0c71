"""Materials, shapes, mass and inertia of bodies that are recorded from MuJoCo."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pyarrow")

XML = """<mujoco><option timestep="0.00025" gravity="0 0 -9.80665"/>
<default><geom solref="0.002 0.215" solimp="0.95 0.99 0.001"/></default>
<worldbody><geom name="floor" type="plane" size="2 2 .1"/>
<body name="thing" pos="0 0 .2">{inside}<freejoint/></body></worldbody></mujoco>"""
BALL = '<geom type="sphere" size="0.01" density="7850"/>'


def run(inside, seconds=0.4, materials=None):
    import clangor.mujoco as cm

    model = mujoco.MjModel.from_xml_string(XML.format(inside=inside))
    materials = {"thing": "steel", "floor": "granite"} if materials is None else materials
    recorder = cm.Recorder(model, mujoco.MjData(model), materials)
    for _ in range(round(seconds / model.opt.timestep)):
        recorder.step()
    return recorder


def header(recorder):
    recorder.session()
    return json.loads((Path(recorder._folder.name) / "run.timeline" / "timeline.json").read_text())


def test_one_warning_gives_the_level_that_the_restitution_costs():
    with pytest.warns(UserWarning, match="costs") as caught:
        recorder = run(BALL)
    recorder.stop()
    (text,) = [str(w.message) for w in caught if "costs" in str(w.message)]
    first, second = recorder.recording.impacts[:2]
    bounce = second.velocity[2] / first.velocity[2]
    level = 20.0 * np.log10((1.0 + bounce) / (1.0 + 0.88))
    said = float(text.split("costs ")[1].split(" dB")[0])
    print("warning", said, "dB, by the speeds of the first two impacts", round(level, 2), "dB, bar 0.2")
    assert abs(said - level) < 0.2


@pytest.mark.parametrize("first, second", [("wood", "granite"), ("steel", "concrete"), ("glass", "glass")])
def test_hear_as_takes_the_restitution_of_the_materials(first, second):
    import clangor.mujoco as cm
    from clangor.material_pairs import pair_restitution

    model = mujoco.MjModel.from_xml_string(XML.format(inside=BALL))
    materials = {"thing": first, "floor": second}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with cm.hear_as(model, materials=materials) as step:
            recorder = cm.Recorder(model, mujoco.MjData(model), materials)
            for _ in range(round(0.7 / step)):
                recorder.step()
    speeds = [-impact.velocity[2] for impact in recorder.recording.impacts]
    wanted = pair_restitution(first, second, speeds[0])
    bounces = [b / a for a, b in zip(speeds, speeds[1:])]
    print(first, second, np.round(bounces, 3), "wanted", round(wanted, 3), "+- 0.05")
    assert bounces and bounces == pytest.approx([wanted] * len(bounces), abs=0.05)


def test_hear_as_holds_three_materials_at_once():
    import clangor.mujoco as cm
    from clangor.material_pairs import pair_restitution

    text = """<mujoco><worldbody><geom name="floor" type="plane" size="2 2 .1"/>
<body name="a" pos="0 0 .2"><freejoint/><geom type="sphere" size="0.01"/></body>
<body name="b" pos=".5 0 .2"><freejoint/><geom type="sphere" size="0.01"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    materials = {"a": "steel", "b": "wood", "floor": "granite"}
    with cm.hear_as(model, materials=materials) as step:
        recorder = cm.Recorder(model, mujoco.MjData(model), materials)
        for _ in range(round(0.8 / step)):
            recorder.step()
    for name in "ab":
        speeds = [-i.velocity[2] for i in recorder.recording.impacts if i.a == name]
        wanted = pair_restitution(materials[name], "granite", speeds[0])
        print(name, speeds[1] / speeds[0], "wanted", wanted, "+- 0.05")
        assert speeds[1] / speeds[0] == pytest.approx(wanted, abs=0.05)


def test_mass_and_inertia_of_the_simulator_are_kept():
    inertial = '<inertial pos="0 0 0" mass="0.5" fullinertia="2e-4 3e-4 4e-4 2e-5 1e-5 3e-5"/>'
    recorder = run(inertial + '<geom type="box" size=".01 .02 .03" euler="20 30 0"/>', 0.3)
    (body,) = [row for row in header(recorder)["bodies"] if row["name"] == "thing"]
    poses = recorder.recording.poses
    rotation, axes = poses[0][3], np.array([[2e-4, 2e-5, 1e-5], [2e-5, 3e-4, 3e-5], [1e-5, 3e-5, 4e-4]])
    world = rotation @ np.array(body["inertia"]) @ rotation.T
    print("inertia error", np.abs(world / axes - 1.0).max(), "bar 1e-5; mass", body["mass"])
    assert body["mass"] == pytest.approx(0.5) and world == pytest.approx(axes, rel=1e-5)
    impact = recorder.recording.impacts[0]
    before = max((p for p in poses if p[0] <= impact.time), key=lambda p: p[0])
    after = min((p for p in poses if p[0] >= impact.time + impact.window), key=lambda p: p[0])
    turned = before[3] @ np.array(body["inertia"]) @ before[3].T
    kick = np.linalg.solve(turned, np.cross(impact.point - before[2], impact.impulse))
    error = np.linalg.norm(after[5] - before[5] - kick) / np.linalg.norm(kick)
    print("change of angular velocity by the impact, error", error, "bar 0.1")
    assert error < 0.1


def test_custom_materials_are_taken_and_their_faults_named():
    stiff = {"base": "steel", "density": 7900.0, "restitution": 0.5}
    recorder = run(BALL, materials={"thing": stiff, "floor": "granite"})
    (body,) = [row for row in header(recorder)["bodies"] if row["name"] == "thing"]
    assert body["material"]["density"] == 7900.0 and body["material"]["restitution"] == 0.5
    assert recorder.render()[0].peak > 0.0
    with pytest.raises(ValueError, match=r"materials\['thing'\].*densty"):
        run(BALL, materials={"thing": {"base": "steel", "densty": 1.0}, "floor": "granite"})
    with pytest.raises(ValueError, match=r"materials\['thing'\]: no preset is called None"):
        run(BALL, materials={"thing": {"density": 1.0}, "floor": "granite"})


@pytest.mark.parametrize(
    "inside",
    [
        '<geom type="capsule" size=".01 .03" density="2000" euler="70 0 0"/>',
        '<geom type="cylinder" size=".02 .01" density="2000" euler="70 20 0"/>',
        '<geom type="ellipsoid" size=".01 .02 .03" density="2000" euler="30 0 0"/>',
        '<geom type="capsule" size=".005 .03" density="2000" euler="0 80 0"/>'
        '<geom type="sphere" size=".015" pos=".0295 0 .0052"/>'
        '<geom type="sphere" size=".015" pos="-.0295 0 -.0052"/>',
    ],
    ids=["capsule", "cylinder", "ellipsoid", "dumb-bell"],
)
def test_shapes_hold_their_volume_touch_where_they_meet_and_are_heard(inside):
    pytest.importorskip("manifold3d")
    recorder = run(inside)
    rows = header(recorder)["bodies"]
    (body,) = [row for row in rows if row["name"] == "thing"]
    (impact, *_) = recorder.recording.impacts
    depth = abs(impact.point[2])
    print("mass", body["mass"], "first contact", depth, "m from the floor, bar 1e-3")
    assert depth < 1e-3
    (sound,) = recorder.render()
    assert sound.peak > 0.0 and np.isfinite(sound.pressure).all()
    worst = max(r[2] for r in recorder.ledger) / max(r[3] for r in recorder.ledger)
    print("ledger", worst, "bar 1e-2")
    assert worst < 1e-2


def test_geoms_that_do_not_touch_are_joined_with_a_warning():
    pytest.importorskip("manifold3d")
    apart = '<geom type="sphere" size=".01" pos=".03 0 0"/><geom type="sphere" size=".01" pos="-.03 0 0"/>'
    with pytest.warns(UserWarning, match="body 'thing': 1 of its parts do not touch the others; bars join"):
        run(apart)


@pytest.mark.parametrize("first, second", [("steel", "granite"), ("wood", "granite")])
def test_the_clicks_are_those_of_our_own_simulation(first, second):
    import clangor
    import clangor.mujoco as cm

    scene = f"""version = 1
[simulation]
duration = 1.0
[[body]]
name = "thing"
shape = "sphere:0.01"
material = "{first}"
position = [0, 0.51, 0]
[[plane]]
name = "floor"
material = "{second}"
[[listener]]
position = [0.3, 0.4, -0.3]
"""
    ours = clangor.Session(text=scene, sample_rate=192000)
    rows = ours.simulate().contacts
    (wanted,) = ours.render()
    density = ours.bodies[0].mass / (4.0 / 3.0 * np.pi * 1e-6)
    text = XML.format(inside=f'<geom type="sphere" size="0.01" density="{density}"/>')
    model = mujoco.MjModel.from_xml_string(text.replace("0 0 .2", "0 0 .51"))
    materials = {"thing": first, "floor": second}
    with cm.hear_as(model, materials=materials) as step:
        recorder = cm.Recorder(model, mujoco.MjData(model), materials)
        for _ in range(round(1.0 / step)):
            recorder.step()
    recorder.session()
    path, place = Path(recorder._folder.name) / "run.timeline", [(0.3, 0.4, -0.3)]
    (heard,) = clangor.Session(path, listeners=place, sample_rate=192000).render()
    times = [i.time for i in recorder.recording.impacts], rows["t"][rows["kind"] == 0]
    pairs = [pair for pair in zip(*times) if max(pair) < 0.99]
    levels = [20.0 * np.log10(peak(heard, a) / peak(wanted, b)) for a, b in pairs]
    print(first, second, "clicks", np.round(levels, 2), "dB, bars 1 and 2")
    assert len(levels) >= 2 and abs(levels[0]) < 1.0 and max(map(abs, levels)) < 2.0


def peak(sound, time):
    """Largest pressure within 3 ms of the arrival of the click."""
    arrival = time + np.hypot(np.hypot(0.3, 0.3), 0.39) / 343.2
    first, last = (round((arrival + d) * sound.sample_rate) for d in (-0.003, 0.003))
    return float(np.abs(sound.pressure[max(first, 0) : last]).max())
