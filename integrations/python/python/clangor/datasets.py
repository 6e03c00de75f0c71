"""Data sets of labelled impacts: iterated over, or written as Parquet or WAV by any executor.

Jobs are module-level functions of the recipe and a part of the data set, so that they can be pickled. A part
that is finished stays, and is not made again; a job that was lost is named by `ShardError`.
"""

from __future__ import annotations

import json
import numbers
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Protocol, Union

from ._clangor import ClangorError, Strikes, usual_shards

__all__ = ["Dataset", "Executor", "Job", "ShardError", "dataset"]

Files = Literal["parquet", "wav"]
Quality = Literal["draft", "normal", "high"]
Progress = Callable[[str, float, str, str], Union[bool, None]]
PathLike = Union[str, "os.PathLike[str]"]
_Description = tuple[tuple[str, Any], ...]

_GROUP = 32
"""Strikes that an iteration renders at once."""
_MOST_BAKES = 1000
"""Most jobs that bake."""


class Job(Protocol):
    """What an executor returns."""

    def result(self) -> Any: ...


class Executor(Protocol):
    """`concurrent.futures`, a Dask client, `mpi4py.futures`, submitit: anything that can submit."""

    def submit(self, fn: Callable[..., Any], /, *args: Any) -> Job: ...


class ShardError(ClangorError):
    """Some jobs were lost; `missing` has their numbers, from 1. The other parts are finished."""

    def __init__(self, what: str, missing: Sequence[int], of: int, first: BaseException) -> None:
        numbers = ", ".join(str(number) for number in missing)
        super().__init__(
            f"{what} {numbers} of {of} failed, the first with {type(first).__name__}: {first}; "
            "the others are finished, and a second run makes only these"
        )
        self.missing = list(missing)


def dataset(
    recipe: PathLike | Mapping[str, Any] | None = None,
    *,
    folder: PathLike | None = None,
    quality: Quality = "normal",
    max_frequency: float | None = None,
    cache: PathLike | None = None,
    **keys: Any,
) -> Dataset:
    """A data set of a recipe: a path (`.toml`, or a table), a mapping, or its keys as keywords.

    Paths in a mapping are relative to `folder`. The keys are those of
    `docs/format/dataset.md`; with a path, only
    `seed` may be given. `quality`, `max_frequency` and `cache` are those of `strike`.
    """
    description: dict[str, Any] = {"quality": quality, "max_frequency": max_frequency}
    description["cache"] = None if cache is None else os.fspath(cache)
    if isinstance(recipe, (str, os.PathLike)):
        if set(keys) - {"seed"}:
            raise TypeError(f"a recipe in a file has its own keys: leave out {', '.join(sorted(keys))}")
        description.update(path=os.fspath(recipe), seed=keys.get("seed"))
    else:
        text = _toml_text({**(recipe or {}), **keys})
        description.update(text=text, folder=os.fspath(folder or ""))
    return Dataset(tuple(description.items()))


class Dataset:
    """Labelled strikes. `len`, indexing and iteration make them; `write` writes them."""

    def __init__(self, description: _Description) -> None:
        self._description = description
        self._strikes = _opened(description)

    def __len__(self) -> int:
        return len(self._strikes)

    def __getitem__(self, index: int) -> dict[str, Any]:
        number = index + len(self) if index < 0 else index
        if not 0 <= number < len(self):
            raise IndexError(f"there is no strike {index}: the data set has {len(self)}")
        return self._strikes.range(number, number + 1)[0]

    def __iter__(self) -> Iterator[dict[str, Any]]:
        for start in range(0, len(self), _GROUP):
            yield from self._strikes.range(start, min(start + _GROUP, len(self)))

    def bake(self, executor: Executor | None = None, progress: Progress | None = None) -> int:
        """Bakes all sound models into the cache, one object per job; returns the number of bodies."""
        if executor is None:
            return self._strikes.bake((1, 1), progress)
        parts = max(1, min(self._strikes.bodies, _MOST_BAKES))
        jobs = [(_bake_part, (self._description, number + 1, parts)) for number in range(parts)]
        return sum(_results(executor, "bakes", jobs))

    def write(
        self,
        folder: PathLike,
        *,
        shards: int | None = None,
        files: Files = "parquet",
        executor: Executor | None = None,
        progress: Progress | None = None,
    ) -> list[Path]:
        """Writes the data set in `shards` files (default: one for each 1000 strikes); returns their paths.

        With an `executor`, sound models are baked first, one object per job, and then every file is a job.
        Raises `ShardError` if jobs are lost.
        """
        of = usual_shards(len(self)) if shards is None else shards
        if of < 1:
            raise ValueError(f"shards is {of}; it must be at least 1")
        out = os.fspath(folder)
        if executor is None:
            parts = ((number + 1, of) for number in range(of))
            return [Path(self._strikes.write(out, part, files, progress)[0]) for part in parts]
        self.bake(executor)
        jobs = [(_write_part, (self._description, out, number + 1, of, files)) for number in range(of)]
        return [Path(path) for path in _results(executor, "shards", jobs)]


def _opened(description: _Description) -> Strikes:
    return Strikes(**dict(description))


def _write_part(description: _Description, folder: str, number: int, of: int, files: Files) -> str:
    """Job: writes a part."""
    return str(_opened(description).write(folder, (number, of), files)[0])


def _bake_part(description: _Description, number: int, of: int) -> int:
    """Job: bakes the sound models of a part of the objects."""
    return _opened(description).bake((number, of))


def _results(
    executor: Executor, what: str, jobs: Sequence[tuple[Callable[..., Any], tuple[Any, ...]]]
) -> list[Any]:
    """The results of all jobs; waits for all before it reports those that were lost."""
    submitted: list[Job | BaseException] = []
    for function, arguments in jobs:
        try:
            submitted.append(executor.submit(function, *arguments))
        except Exception as error:  # An executor that is broken takes no more jobs.
            submitted.append(error)
    results, lost = [], {}
    for number, job in enumerate(submitted, 1):
        try:
            if isinstance(job, BaseException):
                raise job
            results.append(job.result())
        except Exception as error:
            lost[number] = error
    if lost:
        first = next(iter(lost.values()))
        raise ShardError(what, list(lost), len(jobs), first) from first
    return results


def _toml_text(recipe: Mapping[str, Any]) -> str:
    """The text of a recipe; tables are written inline."""
    return "".join(f"{json.dumps(key)} = {_toml(key, value)}\n" for key, value in recipe.items())


def _toml(key: str, value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, Mapping):
        inner = (f"{json.dumps(name)} = {_toml(f'{key}.{name}', part)}" for name, part in value.items())
        return "{" + ", ".join(inner) + "}"
    if hasattr(value, "tolist"):
        return _toml(key, value.tolist())
    if isinstance(value, Sequence):
        return "[" + ", ".join(_toml(f"{key}[{place}]", part) for place, part in enumerate(value)) + "]"
    raise TypeError(f"{key}: a {type(value).__name__} is no value of a recipe")
