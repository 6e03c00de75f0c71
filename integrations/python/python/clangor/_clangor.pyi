import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Union, final

import numpy as np
import numpy.typing as npt

_Vector = Sequence[float]
_Material = Union[str, Mapping[str, Union[str, float]]]
_Quality = Literal["draft", "normal", "high"]
_Path = Union[str, os.PathLike[str]]
_Progress = Callable[[str, float, str, str], Union[bool, None]]
_Floats = npt.NDArray[np.float64]

__all__ = [
    "__version__",
    "ClangorError",
    "Session",
    "Body",
    "Sound",
    "StruckSound",
    "Modes",
    "Timeline",
    "strike",
    "modes",
    "materials",
    "Strikes",
    "usual_shards",
]

__version__: str

class ClangorError(Exception):
    """What cannot be simulated, baked, rendered or read."""

@final
class Body:
    """A body of a session."""

    @property
    def name(self) -> str: ...
    @property
    def material(self) -> str: ...
    @property
    def mass(self) -> float: ...
    @property
    def position(self) -> list[float]: ...

@final
class Sound:
    """The pressure at a listener."""

    @property
    def listener(self) -> str: ...
    @property
    def sample_rate(self) -> int: ...
    @property
    def pressure(self) -> npt.NDArray[np.float32]: ...
    @property
    def duration(self) -> float: ...
    @property
    def peak(self) -> float: ...

@final
class Timeline:
    """What happened: contacts and poses, as columns."""

    @staticmethod
    def open(path: _Path) -> Timeline: ...
    @property
    def bodies(self) -> list[str]: ...
    @property
    def contacts(self) -> dict[str, npt.NDArray[np.generic]]: ...
    @property
    def poses(self) -> dict[str, npt.NDArray[np.generic]]: ...

@final
class Session:
    """A scene (`.toml`) or a timeline (`.timeline`) on its way to sound."""

    def __new__(
        cls,
        path: _Path | None = None,
        *,
        text: str | None = None,
        listeners: Sequence[_Vector] | None = None,
        duration: float | None = None,
        seed: int | None = None,
        sample_rate: int | None = None,
        quality: _Quality = "normal",
        max_frequency: float | None = None,
        cache: _Path | None = None,
        timeline: _Path | None = None,
        progress: _Progress | None = None,
    ) -> Session: ...
    @property
    def bodies(self) -> list[Body]: ...
    @property
    def warnings(self) -> list[str]: ...
    def simulate(self) -> Timeline: ...
    def bake(self) -> list[str]: ...
    def render(self, output: _Path | None = None) -> list[Sound]: ...

@final
class StruckSound:
    """The sound of one impact."""

    @property
    def pressure(self) -> _Floats: ...
    @property
    def times(self) -> _Floats: ...
    @property
    def sample_rate(self) -> int: ...
    @property
    def contact_duration(self) -> float: ...
    @property
    def impulse(self) -> list[float]: ...
    @property
    def velocity_change(self) -> list[float]: ...
    @property
    def modes(self) -> int: ...
    @property
    def remarks(self) -> list[str]: ...

@final
class Modes:
    """At which frequencies a free body rings, and for how long."""

    @property
    def frequencies(self) -> _Floats: ...
    @property
    def t60(self) -> _Floats: ...
    @property
    def damping_ratios(self) -> _Floats: ...
    @property
    def errors(self) -> _Floats: ...
    @property
    def method(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...

def strike(
    object: str,
    material: _Material,
    *,
    scale: float = 1.0,
    impulse: _Vector | None = None,
    striker: tuple[_Material, float, float] | None = None,
    point: _Vector | None = None,
    listener: _Vector | None = None,
    seconds: float | None = None,
    sample_rate: int = 48000,
    quality: _Quality = "normal",
    max_frequency: float | None = None,
    cache: _Path | None = None,
    progress: _Progress | None = None,
) -> StruckSound: ...
def modes(
    object: str,
    material: _Material,
    *,
    scale: float = 1.0,
    max_frequency: float = 20000.0,
    accuracy: float = 0.01,
    progress: _Progress | None = None,
) -> Modes: ...
def materials() -> list[str]: ...

@final
class Strikes:
    """The strikes of a recipe."""

    def __new__(
        cls,
        *,
        text: str | None = None,
        path: _Path | None = None,
        folder: _Path | None = None,
        seed: int | None = None,
        quality: _Quality = "normal",
        max_frequency: float | None = None,
        cache: _Path | None = None,
    ) -> Strikes: ...
    def __len__(self) -> int: ...
    @property
    def bodies(self) -> int: ...
    def range(self, start: int, stop: int, progress: _Progress | None = None) -> list[dict[str, Any]]: ...
    def write(
        self,
        folder: _Path,
        part: tuple[int, int],
        files: Literal["parquet", "wav"] = "parquet",
        progress: _Progress | None = None,
    ) -> tuple[os.PathLike[str], int, bool]: ...
    def bake(self, part: tuple[int, int], progress: _Progress | None = None) -> int: ...

def usual_shards(count: int) -> int: ...
