"""Physically based sound for rigid bodies: a scene goes in, the pressure [Pa] at a listener comes out."""

from ._clangor import (
    Body,
    ClangorError,
    Engine,
    Modes,
    Session,
    Sound,
    StruckSound,
    Timeline,
    __version__,
    materials,
    modes,
    strike,
)
from .datasets import Dataset, ShardError, dataset

__all__ = [
    "Body",
    "ClangorError",
    "Dataset",
    "Engine",
    "Modes",
    "Session",
    "ShardError",
    "Sound",
    "StruckSound",
    "Timeline",
    "__version__",
    "dataset",
    "materials",
    "modes",
    "strike",
]
