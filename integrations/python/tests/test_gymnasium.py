"""Recording a Gymnasium environment: substeps within a frame are heard."""

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
mujoco = pytest.importorskip("mujoco")
pytest.importorskip("pyarrow")
pytest.importorskip("imageio")

XML = """<mujoco><option timestep="0.00025"/><default><geom solref="0.002 0.2"/></default>
<worldbody><geom name="floor" type="plane" size="2 2 .1"/>
<body name="ball" pos="0 0 .11"><freejoint/><geom type="sphere" size="0.01"/></body></worldbody></mujoco>"""
MATERIALS = {"ball": "steel", "floor": "granite"}


def test_frame_skip_5_gives_the_sound_of_stepping_by_hand(tmp_path):
    import clangor.gymnasium as cg
    import clangor.mujoco as cm
    from gymnasium.envs.mujoco import MujocoEnv

    class Ball(MujocoEnv):
        metadata = {"render_modes": ["human", "rgb_array", "depth_array", "rgbd_tuple"], "render_fps": 800}

        def step(self, action):
            self.do_simulation(action, self.frame_skip)
            return self.data.qpos.copy(), 0.0, False, False, {}

        def reset_model(self):
            self.set_state(self.init_qpos, self.init_qvel)
            return self.data.qpos.copy()

    path = tmp_path / "ball.xml"
    path.write_text(XML)
    space = gymnasium.spaces.Box(-np.inf, np.inf, (7,), np.float64)
    env = cg.SoundRecorder(Ball(str(path), 5, space), MATERIALS)
    env.reset(seed=1)
    for _ in range(200):
        env.step(np.zeros(0))
    env.stop()

    model = mujoco.MjModel.from_xml_string(XML)
    hand = cm.Recorder(model, mujoco.MjData(model), MATERIALS)
    for _ in range(1000):
        hand.step()
    (by_env,), (by_hand,) = env.recorder.render(), hand.render()
    assert by_hand.peak > 0.0
    assert (by_env.pressure == by_hand.pressure).all()
