"""Recording PyBullet: the momentum ledger, the restitution of a dropped ball, its sound."""

import pytest

pybullet = pytest.importorskip("pybullet")
pytest.importorskip("pyarrow")


def test_a_dropped_ball_keeps_the_ledger_bounces_and_is_heard():
    import clangor.pybullet as cp

    client = pybullet.connect(pybullet.DIRECT)
    try:
        gravity, dt = (0.0, 0.0, -9.80665), 0.001
        pybullet.setGravity(*gravity, client)
        pybullet.setTimeStep(dt, client)
        settings = dict(restitutionVelocityThreshold=0.02, erp=0, contactERP=0)
        pybullet.setPhysicsEngineParameter(**settings, physicsClientId=client)
        floor = pybullet.createMultiBody(0, pybullet.createCollisionShape(pybullet.GEOM_PLANE))
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.01)
        ball = pybullet.createMultiBody(0.0329, shape, basePosition=[0, 0, 0.51])
        for body in (floor, ball):
            pybullet.changeDynamics(body, -1, restitution=0.6**0.5, linearDamping=0, angularDamping=0)
        recorder = cp.Recorder(client, dt, gravity, {floor: "granite", ball: "steel"})
        for _ in range(1000):
            recorder.step()
        speeds = [-impact.velocity[2] for impact in recorder.recording.impacts]
        assert len(speeds) == 3
        for first, second in zip(speeds, speeds[1:]):
            assert second / first == pytest.approx(0.6, abs=0.05)
        assert max(row[2] for row in recorder.ledger) < 1e-9 * max(row[3] for row in recorder.ledger)
        assert recorder.render()[0].peak > 0.0
        with pytest.raises(ValueError, match="no body 7"):
            cp.Recorder(client, dt, gravity, {7: "steel"})
    finally:
        pybullet.disconnect(client)
