import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeVar, Union, final, overload

import numpy as np
import numpy.typing as npt

_Vector = Union[Sequence[float], npt.NDArray[np.floating[Any]]]
_Material = Union[str, Mapping[str, Union[str, float]]]
_Quality = Literal["draft", "normal", "high"]
_Path = Union[str, os.PathLike[str]]
_Progress = Callable[[str, float, str, str], Union[bool, None]]
_Floats = npt.NDArray[np.float64]
_Real = TypeVar("_Real", np.float32, np.float64)
_Striker = tuple[_Material, float, float]

__all__ = [
    "__version__",
    "ClangorError",
    "Session",
    "Body",
    "Engine",
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
class Engine:
    """Renders the pressure at one or two listeners block by block, while impacts happen."""

    def __new__(
        cls,
        listeners: Sequence[_Vector] | _Floats,
        *,
        sample_rate: int = 48000,
        block: int = 128,
        objects: int = 64,
        reach: float = 40.0,
        max_frequency: float | None = None,
        scene: Session | None = None,
    ) -> Engine: ...
    @property
    def sample_rate(self) -> int: ...
    @property
    def listeners(self) -> int: ...
    @property
    def latency(self) -> float: ...
    @property
    def time(self) -> float: ...
    @property
    def report(self) -> dict[str, float]: ...
    def add(
        self,
        object: str,
        material: _Material,
        *,
        scale: float = 1.0,
        quality: _Quality = "normal",
        cache: _Path | None = None,
        position: _Vector = (0.0, 0.0, 0.0),
        orientation: _Vector = (0.0, 0.0, 0.0, 1.0),
        progress: _Progress | None = None,
    ) -> int: ...
    def add_scene(
        self,
        session: Session,
        *,
        quality: _Quality = "normal",
        cache: _Path | None = None,
        progress: _Progress | None = None,
    ) -> dict[str, int]: ...
    def remove(self, slot: int) -> None: ...
    def modes(self, slot: int) -> int: ...
    def remarks(self, slot: int) -> list[str]: ...
    def strike(
        self,
        slot: int,
        *,
        impulse: _Vector | None = None,
        striker: _Striker | None = None,
        point: _Vector | None = None,
        time: float | None = None,
    ) -> None: ...
    def collide(
        self,
        slot: int,
        partner: int | _Material,
        *,
        point: _Vector,
        normal: _Vector,
        speed: float,
        time: float | None = None,
    ) -> None: ...
    def impact(
        self,
        *,
        slot: int | None = None,
        radius: float | None = None,
        duration: float,
        time: float | None = None,
        position: _Vector | None = None,
        orientation: _Vector | None = None,
        velocity_change: _Vector = (0.0, 0.0, 0.0),
        angular_velocity_change: _Vector = (0.0, 0.0, 0.0),
        point: _Vector | None = None,
        impulse: _Vector = (0.0, 0.0, 0.0),
        force: tuple[float, float, Sequence[float] | _Floats] | None = None,
    ) -> None: ...
    def move_to(
        self,
        slot: int,
        position: _Vector,
        *,
        orientation: _Vector = (0.0, 0.0, 0.0, 1.0),
        velocity: _Vector = (0.0, 0.0, 0.0),
        angular_velocity: _Vector = (0.0, 0.0, 0.0),
        time: float | None = None,
    ) -> None: ...
    def end(self, slot: int, *, time: float | None = None) -> None: ...
    def listen(self, listeners: Sequence[_Vector] | _Floats) -> None: ...
    def switch(self, part: Literal["acceleration", "modal", "reflections"], on: bool) -> None: ...
    def silence(self) -> None: ...
    @overload
    def render(self, frames: int, *, out: None = None) -> _Floats: ...
    @overload
    def render(self, frames: int | None = None, *, out: npt.NDArray[_Real]) -> npt.NDArray[_Real]: ...

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
    striker: _Striker | None = None,
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
