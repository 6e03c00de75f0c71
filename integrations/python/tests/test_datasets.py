"""Data sets: the same samples in memory, in files, and from any executor; lost workers; other programs."""

import os
import signal
import sys
import time
import warnings
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clangor
from clangor import datasets

RECIPE: dict[str, Any] = {
    "seed": 3,
    "count": 12,
    "sample_rate": 8000,
    "seconds": 0.1,
    "material": {"dull": {"base": "brass", "loss_factor": 0.05}},
    "materials": ["steel", "dull"],
    "object": [
        {"name": "bar", "shape": "box:0.2x0.03x0.008"},
        {"shape": "sphere:0.02", "materials": "glass"},
    ],
    "striker": [{"materials": "wood", "radius": {"log": [0.005, 0.02]}, "speed": [0.2, np.float64(2.0)]}],
    "listener": [{"distance": [0.5, 2]}],
}


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path_factory.getbasetemp() / "cache"
    folder.mkdir(exist_ok=True)
    monkeypatch.setenv("CLANGOR_CACHE", str(folder))


def made(**changes: Any) -> datasets.Dataset:
    return clangor.dataset({**RECIPE, **changes}, quality="draft")


def test_strikes_are_labelled() -> None:
    rows = list(made())
    assert [row["index"] for row in rows] == list(range(12)) and len(made()) == 12
    for row in rows:
        assert row["samples"].dtype == np.float32 and row["samples"].shape == (817,)
        assert row["frequencies"].shape == row["t60s"].shape and np.abs(row["samples"]).max() > 0
        assert 0.5 <= np.linalg.norm(row["listener"]) <= 2.0 and 0.2 <= row["speed"] <= 2.0
    assert {row["material"] for row in rows} <= {"steel", "dull", "glass"}
    assert {row["object"] for row in rows} == {"bar", "sphere:0.02"}
    assert np.array_equal(made()[-1]["samples"], rows[-1]["samples"])
    longer = made(count=40)[11]
    assert np.array_equal(longer["samples"], rows[11]["samples"]) and longer["point"] == rows[11]["point"]


def test_defects_of_sound_models_are_warned_of(tmp_path: Path) -> None:
    recipe = {**RECIPE, "object": RECIPE["object"][:1], "materials": "steel", "count": 2}
    data = clangor.dataset(recipe, quality="draft", cache=tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert data.bake() == 1
    for entry in (path for path in tmp_path.iterdir() if path.is_file()):
        content = bytearray(entry.read_bytes())
        content[len(content) // 2] ^= 1
        entry.write_bytes(content)
    with pytest.warns(UserWarning, match='"bar" of steel: .*baked again'):
        data.bake()


def test_a_strike_alone_has_the_same_samples() -> None:
    row = made()[next(i for i, row in enumerate(made()) if row["material"] == "steel")]
    striker = (row["striker"], row["striker_radius"], row["speed"])
    alone = clangor.strike(
        "box:0.2x0.03x0.008", "steel", striker=striker, point=row["point"], listener=row["listener"],
        seconds=0.1, sample_rate=8000, quality="draft",
    )  # fmt: skip
    assert np.array_equal(alone.pressure.astype(np.float32), row["samples"])


def test_files_open_with_arrow_and_pandas(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    paths = made().write(tmp_path, shards=3)
    assert [path.name for path in paths] == [f"strikes-{k:05}-of-00003.parquet" for k in (1, 2, 3)]
    table = parquet.read_table(tmp_path)
    assert str(table.schema.field("samples").type).startswith("list<element: float")
    for row, own in zip(table.to_pylist(), made()):
        assert np.array_equal(np.float32(row["samples"]), own["samples"])
        assert row["t60s"] == own["t60s"].tolist() and row["peak_force"] == own["peak_force"]
        assert [row["point_x"], row["point_y"], row["point_z"]] == own["point"]
    pandas = pytest.importorskip("pandas")
    assert pandas.read_parquet(tmp_path)["room"].isna().all()
    before = [path.stat().st_mtime_ns for path in paths]
    paths[1].unlink()
    made().write(tmp_path, shards=3)
    after = [path.stat().st_mtime_ns for path in paths]
    assert (after[0], after[2]) == (before[0], before[2]) and after[1] > before[1]


def test_files_open_with_huggingface(tmp_path: Path) -> None:
    huggingface = pytest.importorskip("datasets")
    made().write(tmp_path / "set", shards=2)
    loaded = huggingface.load_dataset(
        "parquet",
        data_files=str(tmp_path / "set" / "*.parquet"),
        split="train",
        cache_dir=str(tmp_path / "hf"),
    )
    assert loaded.num_rows == 12
    assert np.array_equal(np.float32(loaded[5]["samples"]), made()[5]["samples"])


def test_processes_write_what_one_writes(tmp_path: Path) -> None:
    one = made().write(tmp_path / "one", shards=4)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        several = made().write(tmp_path / "several", shards=4, executor=pool)
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in several]


class LosesOne:
    """An executor whose third job dies."""

    def __init__(self) -> None:
        self.jobs = 0

    def submit(self, fn: Any, /, *args: Any) -> "Future[Any]":
        future: Future[Any] = Future()
        self.jobs += fn is datasets._write_part
        if self.jobs == 3 and fn is datasets._write_part:
            future.set_exception(RuntimeError("worker lost"))
        else:
            future.set_result(fn(*args))
        return future


def test_a_lost_job_is_named_and_the_others_stay(tmp_path: Path) -> None:
    with pytest.raises(clangor.ShardError, match=r"shards 3 of 4 failed.*RuntimeError: worker lost") as lost:
        made().write(tmp_path, shards=4, executor=LosesOne())
    assert lost.value.missing == [3]
    assert len(list(tmp_path.glob("*.parquet"))) == 3
    assert len(made().write(tmp_path, shards=4)) == 4


def _dies() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


class KillsAWorker:
    """Dies in a process of the pool instead of the second part."""

    def __init__(self, pool: ProcessPoolExecutor) -> None:
        self.pool, self.parts = pool, 0

    def submit(self, fn: Any, /, *args: Any) -> "Future[Any]":
        self.parts += fn is datasets._write_part
        if self.parts == 2 and fn is datasets._write_part:
            return self.pool.submit(_dies)
        return self.pool.submit(fn, *args)


@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_a_killed_process_is_reported_and_the_run_continues(tmp_path: Path) -> None:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        with pytest.raises(clangor.ShardError, match="BrokenProcessPool") as lost:
            made().write(tmp_path, shards=3, executor=KillsAWorker(pool))
    assert 2 in lost.value.missing and 1 not in lost.value.missing
    assert (tmp_path / "strikes-00001-of-00003.parquet").exists()
    assert len(made().write(tmp_path, shards=3)) == 3


def test_dask_survives_a_killed_worker(tmp_path: Path) -> None:
    distributed = pytest.importorskip("dask.distributed")
    one = made().write(tmp_path / "one", shards=6)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster, distributed.Client(cluster) as client:
        class Killing:
            def submit(self, fn: Any, /, *args: Any) -> Any:
                job = client.submit(fn, *args)
                if fn is datasets._write_part and args[2] == 2:
                    time.sleep(0.05)
                    pids = client.run(os.getpid)
                    os.kill(min(pids.values()), signal.SIGKILL)
                return job

        several = made().write(tmp_path / "several", shards=6, executor=Killing())
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in several]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"count": 0}, "count: 0 is out of range"),
        ({"count": 2.5}, "count: this is a number"),
        ({"materials": ["stel"]}, "did you mean `steel`"),
        ({"striker": [{"materials": "wood", "radius": float("nan"), "speed": 1}]}, "not a finite number"),
        ({"objects": []}, "did you mean `object`"),
    ],
)
def test_mistakes_of_recipes_are_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(clangor.ClangorError, match=message):
        made(**changes)


def test_wrong_arguments_are_named(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=r"object\[0\].shape: a complex"):
        made(object=[{"shape": 1j}])
    with pytest.raises(TypeError, match="leave out count"):
        clangor.dataset("recipe.toml", count=3)
    with pytest.raises(clangor.ClangorError, match="cannot read"):
        clangor.dataset(tmp_path / "none.toml")
    with pytest.raises(IndexError, match="no strike 12"):
        made()[12]
    with pytest.raises(ValueError, match="shards is 0"):
        made().write(tmp_path, shards=0)
    with pytest.raises(ValueError, match="files is \"flac\""):
        made().write(tmp_path, files="flac")  # type: ignore[arg-type]
    made(count=1).write(tmp_path / "a", shards=1)
    with pytest.raises(clangor.ClangorError, match="belongs to another data set"):
        made(count=2).write(tmp_path / "a", shards=1)


def test_progress_can_stop(tmp_path: Path) -> None:
    seen: list[float] = []

    def stop(stage: str, done: float, body: str, step: str) -> bool:
        seen.append(done)
        return False

    with pytest.raises(clangor.ClangorError, match="interrupted"):
        made(seed=4).write(tmp_path, progress=stop)
    assert seen and not list(tmp_path.glob("*.parquet"))
