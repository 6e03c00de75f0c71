"""Recording MuJoCo: the momentum ledger, the sound of a dropped ball, and input that is refused."""

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pyarrow")

XML = """<mujoco><option timestep="{dt}" gravity="0 0 -9.80665"/>
<default><geom solref="0.002 0.215" solimp="0.95 0.99 0.001"/></default>
<worldbody><geom name="floor" type="plane" size="2 2 .1"/>
<body name="{name}" pos="0 0 .51"><freejoint/><geom {geom} density="7850"/></body></worldbody></mujoco>"""


def recorded(geom='type="sphere" size="0.01"', dt=0.00025, seconds=0.6, **options):
    import clangor.mujoco as cm

    model = mujoco.MjModel.from_xml_string(XML.format(dt=dt, geom=geom, name="ball"))
    options.setdefault("materials", {"ball": "steel", "floor": "granite"})
    recorder = cm.Recorder(model, mujoco.MjData(model), **options)
    for _ in range(round(seconds / dt)):
        recorder.step()
    recorder.stop()
    return recorder


@pytest.mark.parametrize(
    "geom", ['type="sphere" size="0.01"', 'type="box" size="0.01 0.02 0.015" euler="20 30 0"']
)
def test_the_ledger_closes_to_1e_9_of_the_momentum(geom):
    rows = recorded(geom).ledger
    assert max(row[2] for row in rows) < 1e-9 * max(row[3] for row in rows)


def test_a_dropped_ball_is_one_impact_with_the_momentum_of_its_bounce_and_is_heard(tmp_path):
    recorder = recorded(seconds=0.45)
    (impact,) = recorder.recording.impacts
    mass = recorder.model.body_mass[1]
    speeds = [row[4][2] for row in recorder.recording.poses]
    change = mass * (max(speeds) - min(speeds))
    assert impact.impulse[2] == pytest.approx(change, rel=0.02)
    (sound,) = recorder.render(tmp_path / "ball.wav")
    assert sound.peak > 0.0 and (tmp_path / "ball.wav").exists()
    assert np.isfinite(sound.pressure).all()


def test_unknown_names_are_refused_by_name():
    with pytest.raises(ValueError, match="unobtainium"):
        recorded(materials={"ball": "unobtainium"})
    with pytest.raises(ValueError, match="no body or geom 'bell'"):
        recorded(materials={"bell": "steel"})
    with pytest.raises(ValueError, match="listener"):
        recorded(seconds=0.01).session(listener=(0.0, 1.0))


def test_a_missing_material_is_a_warning_with_its_name():
    with pytest.warns(UserWarning, match="'floor' has no material"):
        recorded(seconds=0.01, materials={"ball": "steel"})


@pytest.mark.parametrize(
    "asked, wanted", [(0.00025, 0.6), (0.001, 0.6), (0.002, 0.6), (0.002, 0.3), (0.002, 0.9)]
)
def test_hear_as_bounces_with_the_restitution_and_restores_the_model(asked, wanted):
    import clangor.mujoco as cm

    model = mujoco.MjModel.from_xml_string(
        XML.format(dt=asked, geom='type="sphere" size="0.01"', name="ball")
    )
    before = model.opt.timestep, model.geom_solref.copy(), model.geom_solimp.copy()
    with cm.hear_as(model, wanted, step=asked) as step:
        recorder = cm.Recorder(model, mujoco.MjData(model), {"ball": "steel", "floor": "granite"})
        for _ in range(round(1.0 / step)):
            recorder.step()
        recorder.stop()
    speeds = [-impact.velocity[2] for impact in recorder.recording.impacts]
    bounces = [second / first for first, second in zip(speeds, speeds[1:])]
    print("restitution", np.round(bounces, 3), "wanted", wanted, "+- 0.05")
    assert len(bounces) >= 1
    assert bounces == pytest.approx([wanted] * len(bounces), abs=0.05)
    assert model.opt.timestep == before[0]
    assert (model.geom_solref == before[1]).all() and (model.geom_solimp == before[2]).all()


def test_hear_as_refuses_what_it_cannot_reach():
    import clangor.mujoco as cm

    model = mujoco.MjModel.from_xml_string(
        XML.format(dt=0.001, geom='type="sphere" size="0.01"', name="ball")
    )
    with pytest.raises(ValueError, match="restitution"):
        with cm.hear_as(model, 1.5):
            pass


def test_the_first_click_is_within_1_db_of_our_own_simulation():
    import clangor
    import clangor.mujoco as cm

    scene = """version = 1
[simulation]
duration = 0.45
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0, 0.51, 0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
position = [0.3, 0.4, -0.3]
"""
    ours = clangor.Session(text=scene)
    rows = ours.simulate().contacts
    speed = -rows["velocity_y"][0]
    model = mujoco.MjModel.from_xml_string(
        XML.format(dt=0.001, geom='type="sphere" size="0.01"', name="ball")
    )
    bounce = rows["impulse_n"][0] / (ours.bodies[0].mass * speed) - 1.0
    with cm.hear_as(model, float(bounce)) as step:
        recorder = cm.Recorder(model, mujoco.MjData(model), {"ball": "steel", "floor": "granite"})
        for _ in range(round(0.45 / step)):
            recorder.step()
    (heard,), (wanted,) = recorder.render(), ours.render()
    assert abs(20.0 * np.log10(heard.peak / wanted.peak)) < 1.0
    print("first click", 20.0 * np.log10(heard.peak / wanted.peak), "dB")


def test_the_ledger_of_a_mesh_closes_to_1e_2_of_the_momentum():
    import clangor.mujoco as cm

    corners = " ".join(f"{x:.4f}" for x in np.random.default_rng(2).normal(size=42) * 0.02)
    text = XML.format(dt=0.00025, geom='type="mesh" mesh="stone"', name="ball")
    text = text.replace("<worldbody>", f'<asset><mesh name="stone" vertex="{corners}"/></asset><worldbody>')
    model = mujoco.MjModel.from_xml_string(text)
    recorder = cm.Recorder(model, mujoco.MjData(model), {"ball": "steel", "floor": "granite"})
    for _ in range(2000):
        recorder.step()
    rows = recorder.ledger
    worst = max(row[2] for row in rows) / max(row[3] for row in rows)
    print("ledger of a mesh", worst)
    assert worst < 1e-2


def test_a_session_outlives_its_recorder():
    import gc

    session = recorded(seconds=0.4).session()
    gc.collect()
    assert session.render()[0].peak > 0.0
