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


@pytest.mark.parametrize("geom", ['type="sphere" size="0.01"', 'type="box" size="0.01 0.02 0.015" euler="20 30 0"'])
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
    with pytest.raises(ValueError, match="several|only spheres"):
        recorded('type="capsule" size="0.01 0.02"')
    with pytest.raises(ValueError, match="listener"):
        recorded(seconds=0.01).session(listener=(0.0, 1.0))


def test_a_missing_material_is_a_warning_with_its_name():
    with pytest.warns(UserWarning, match="'floor' has no material"):
        recorded(seconds=0.01, materials={"ball": "steel"})
