"""Records a MuJoCo environment of Gymnasium: every substep of `frame_skip` is recorded.

The wrapper replaces `_step_mujoco_simulation` of this one environment; `close` and `stop` put it back.
Impulses are those of `clangor.mujoco`; rewards and observations are not changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import mujoco  # type: ignore[import-untyped]

from .material_pairs import Material
from .mujoco import Recorder

__all__ = ["SoundRecorder"]


class SoundRecorder(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Wraps a `MujocoEnv`; `recorder` holds the episode since the last `reset`.

    `materials` maps names of bodies or geoms to materials. Errors: ValueError if `env` is no MuJoCo
    environment.
    """

    def __init__(self, env: Any, materials: Mapping[str, Material] | None = None) -> None:
        super().__init__(env)
        inner = env.unwrapped
        if not hasattr(inner, "_step_mujoco_simulation"):
            raise ValueError(f"env: {type(inner).__name__} is not a MuJoCo environment")
        self._materials = materials
        self.recorder = Recorder(inner.model, inner.data, materials)
        inner._step_mujoco_simulation = self._substeps

    def _substeps(self, control: Any, frames: int) -> None:
        inner: Any = self.env.unwrapped
        inner.data.ctrl[:] = control
        for _ in range(frames):
            self.recorder.step()
        mujoco.mj_rnePostConstraint(inner.model, inner.data)

    def reset(self, **options: Any) -> tuple[Any, dict[str, Any]]:
        """Resets the environment and begins a new recording."""
        answer = super().reset(**options)
        inner: Any = self.env.unwrapped
        self.recorder = Recorder(inner.model, inner.data, self._materials)
        return answer

    def stop(self) -> None:
        """Ends the recording; the environment steps as before. May be repeated."""
        self.recorder.stop()
        vars(self.env.unwrapped).pop("_step_mujoco_simulation", None)

    def close(self) -> None:
        """Ends the recording and closes the environment."""
        self.stop()
        super().close()
