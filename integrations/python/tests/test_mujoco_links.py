"""Bodies on joints: an arm of three links that falls on a table, and a doll on a free joint."""

import warnings

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pyarrow")

HEAD = """<mujoco><option timestep="{step}" gravity="0 0 -9.80665" integrator="{integrator}"/>
<default><geom solref="0.002 0.215" solimp="0.95 0.99 0.001" density="2000"/></default><worldbody>"""
LINK = """<body name="{name}" pos="{place}">{joint}
<geom type="capsule" size=".01" fromto="0 0 0 .15 0 0"/>{inside}</body>"""
HINGE = '<joint type="hinge" axis="0 1 0" damping="0.001"/>'


def model(kind, integrator="Euler", step=0.00025):
    hand = LINK.format(name="hand", place=".18 0 0", joint=HINGE, inside="")
    fore = LINK.format(name="forearm", place=".18 0 0", joint=HINGE, inside=hand)
    if kind == "arm":
        table = '<geom name="table" type="box" size=".3 .2 .01" pos=".4 0 0"/>'
        inside = table + LINK.format(name="arm", place="0 0 .15", joint=HINGE, inside=fore)
    else:
        floor = '<geom name="table" type="plane" size="2 2 .1"/>'
        inside = floor + LINK.format(name="arm", place="0 0 .15", joint="<freejoint/>", inside=fore)
    text = HEAD.format(integrator=integrator, step=step) + inside + "</worldbody></mujoco>"
    return mujoco.MjModel.from_xml_string(text)


def recorded(kind, seconds=0.6, integrator="Euler", step=0.00025):
    import clangor.mujoco as cm

    made = model(kind, integrator, step)
    data, forces = mujoco.MjData(made), []
    materials = {name: "wood" for name in ("arm", "forearm", "hand", "table")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        recorder = cm.Recorder(made, data, materials)
        for _ in range(round(seconds / step)):
            recorder.step()
            mujoco.mj_rnePostConstraint(made, data)
            forces.append([data.cfrc_int[b][3:].copy() for b in range(1, 4)])
    recorder.stop()
    return recorder, np.array(forces) * step


def joint_impulses(recorder, names):
    rows = [row for row in recorder.recording.lasting if row.joint]
    return [np.array([row.impulse for row in rows if row.a == name]) for name in names]


@pytest.mark.parametrize("step, bar", [(0.00025, 2e-2), (0.0000625, 5e-3)])
@pytest.mark.parametrize("kind", ["arm", "doll"])
def test_joint_impulses_come_to_those_of_the_simulator_with_the_step(kind, step, bar):
    recorder, forces = recorded(kind, 0.4, step=step)
    names = ["arm", "forearm", "hand"] if kind == "arm" else ["forearm", "hand"]
    impacts = [i for i in recorder.recording.impacts if -i.velocity @ i.normal > 0.1]
    print(kind, len(impacts), "impacts above 0.1 m/s of", sorted({i.a for i in impacts}))
    assert impacts
    for name, found in zip(names, joint_impulses(recorder, names)):
        theirs = forces[:, ("arm", "forearm", "hand").index(name)]
        errors, sizes = [], []
        for impact in impacts:
            first, last = (round(t / step) for t in (impact.time, impact.time + impact.window))
            wanted = theirs[first:last].sum(axis=0)
            errors.append(np.linalg.norm(found[first:last].sum(axis=0) - wanted))
            sizes.append(np.linalg.norm(wanted))
        worst = max(errors) / max(sizes)
        print(name, f"joint impulse against cfrc_int, of the largest: worst {worst:.1e}, bar {bar}")
        assert worst < bar


@pytest.mark.parametrize("kind", ["arm", "doll"])
@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_the_rows_of_every_link_hold_its_change_of_momentum(kind, integrator):
    recorder, _ = recorded(kind, 0.4, integrator)
    rows = recorder.recording.impacts + recorder.recording.lasting
    gravity = recorder.recording.gravity
    for body in recorder.recording.bodies:
        if body.mass == 0.0:
            continue
        poses = [row for row in recorder.recording.poses if row[1] == body.name]
        end = poses[-1][0]
        change = body.mass * (poses[-1][4] - poses[0][4] - gravity * end)
        mine = [(row.impulse, 1.0) for row in rows if row.a == body.name and row.time < end - 1e-9]
        mine += [(row.impulse, -1.0) for row in rows if row.b == body.name and row.time < end - 1e-9]
        error = np.linalg.norm(sum(s * j for j, s in mine) - change) / np.linalg.norm(change)
        print(kind, integrator, body.name, f"rows against m dv: {error:.1e}, bar 1e-2")
        assert error < 1e-2


def test_every_link_is_heard():
    recorder, _ = recorded("arm")
    assert {body.name for body in recorder.recording.bodies} == {"table", "arm", "forearm", "hand"}
    (sound,) = recorder.render()
    assert sound.peak > 0.0 and np.isfinite(sound.pressure).all()
