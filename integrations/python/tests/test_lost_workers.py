"""Sixty-four bakes on two workers, of which one is killed: nothing is wrong, missing or made twice."""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest

import clangor
from clangor import datasets

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")

BODIES = 64
BEFORE_THE_KILL = 12


# Half of it is the band of a bake [Hz]. As it is, a bake costs little; 48000 shows what the workers add to dear ones.
SAMPLE_RATE = int(os.environ.get("CLANGOR_BAKE_RATE", "8000"))


def recipe(cache: Path) -> datasets.Dataset:
    """Bars of 64 lengths."""
    lengths = [0.08 + 0.0005 * number for number in range(BODIES)]
    return clangor.dataset(
        seed=1,
        count=BODIES,
        sample_rate=SAMPLE_RATE,
        seconds=0.05,
        materials="steel",
        object=[{"shape": f"box:{length:.4f}x0.02x0.02"} for length in lengths],
        striker=[{"materials": "wood", "radius": 0.01, "speed": 1.0}],
        listener=[{"distance": 1.0}],
        quality="draft",
        cache=cache,
    )


def cpu_times() -> tuple[float, float]:
    """CPU time [s] of this process for its jobs, and for the event loop of its executor.

    Workers of Dask run jobs beside the main thread, which has the loop; those of a pool run them on it.
    """
    main, loop = threading.main_thread(), 0.0
    if threading.current_thread() is not main and main.ident is not None:
        loop = time.clock_gettime(time.pthread_getcpuclockid(main.ident))
    return time.process_time() - loop, loop


def logged(folder: str, function: Any, *arguments: Any) -> Any:
    """Job: calls a function; leaves a file when it begins, and one with its CPU times [s] when it ends."""
    name = Path(folder) / f"{arguments[1]}-{os.getpid()}-{time.monotonic_ns()}"
    name.with_suffix(".begun").touch()
    before = cpu_times()
    result = function(*arguments)
    part = name.with_suffix(".part")
    part.write_text(" ".join(str(now - then) for now, then in zip(cpu_times(), before)))
    part.rename(name.with_suffix(".done"))
    return result


class Logging:
    """An executor whose jobs leave files."""

    def __init__(self, executor: Any, folder: Path, cache: Path) -> None:
        self.executor, self.folder, self.cache = executor, folder, cache
        self.kept: dict[str, int] = {}
        folder.mkdir()

    def submit(self, fn: Any, /, *args: Any) -> Any:
        return self.executor.submit(logged, str(self.folder), fn, *args)

    def jobs(self, ending: str) -> set[str]:
        return {path.stem for path in self.folder.glob(f"*.{ending}")}

    def numbers(self, ending: str) -> list[int]:
        return sorted(int(job.split("-")[0]) for job in self.jobs(ending))

    def seconds(self, which: int) -> float:
        """CPU time [s] of finished jobs (0), or of the event loops meanwhile (1)."""
        return sum(float(path.read_text().split()[which]) for path in self.folder.glob("*.done"))

    def kill_one_at_work(self) -> None:
        """Kills a worker in the middle of a job, when some jobs are done, and looks what is in the cache."""
        while True:
            done = self.jobs("done")
            at_work = self.jobs("begun") - done
            if len(done) >= BEFORE_THE_KILL and at_work:
                os.kill(int(at_work.pop().split("-")[1]), signal.SIGKILL)
                self.kept = written(self.cache)
                return
            time.sleep(0.005)


def entries(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def written(cache: Path) -> dict[str, int]:
    """When each entry was written [ns]."""
    return {path.name: path.stat().st_mtime_ns for path in cache.glob("*.safetensors")}


class Serial:
    """The same bakes, one after the other: their entries in the cache, and their CPU time [s]."""

    def __init__(self, folder: Path) -> None:
        before = time.process_time()
        assert recipe(folder).bake() == BODIES
        self.seconds = time.process_time() - before
        self.entries = entries(folder)


@pytest.fixture(scope="module")
def serial(tmp_path_factory: pytest.TempPathFactory) -> Serial:
    return Serial(tmp_path_factory.mktemp("serial"))


@pytest.fixture(autouse=True)
def one_thread_each(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("RAYON_NUM_THREADS", "1")
    yield


def check(what: str, cache: Path, serial: Serial, runs: list[Logging]) -> None:
    """All entries are those of the serial run, and what was there when the worker died is not made again."""
    lost = sum(len(run.jobs("begun")) - len(run.jobs("done")) for run in runs)
    parts = " + ".join(f"{run.seconds(0):.2f}" for run in runs)
    total, loops = (sum(run.seconds(which) for run in runs) for which in (0, 1))
    print(
        f"{what}: finished jobs {parts} s of CPU = {total / serial.seconds:.2f} of the serial "
        f"{serial.seconds:.2f} s, and {loops:.2f} s of the executor's event loops; {lost} begun jobs lost, "
        f"of {serial.seconds / BODIES:.2f} s each"
    )
    assert entries(cache) == serial.entries
    kept = runs[0].kept
    assert len(kept) >= BEFORE_THE_KILL and kept.items() <= written(cache).items()
    assert lost >= 1
    for run in runs[1:]:
        assert run.numbers("done") == list(range(1, BODIES + 1))


def test_dask_bakes_the_lost_job_again(tmp_path: Path, serial: Serial) -> None:
    distributed = pytest.importorskip("dask.distributed")
    cache = tmp_path / "cache"
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster, distributed.Client(cluster) as client:
        run = Logging(client, tmp_path / "log", cache)
        killer = threading.Thread(target=run.kill_one_at_work)
        killer.start()
        assert recipe(cache).bake(run) == BODIES
        killer.join()
    check("dask, one of two workers killed", cache, serial, [run])
    # Dask asks again for results that the killed worker still had; their models are in the cache.
    assert set(run.numbers("done")) == set(range(1, BODIES + 1))
    assert len(run.jobs("begun")) - len(run.jobs("done")) == 1


def test_a_pool_names_what_is_missing_and_makes_only_that(tmp_path: Path, serial: Serial) -> None:
    cache = tmp_path / "cache"
    context = get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        first = Logging(pool, tmp_path / "first", cache)
        killer = threading.Thread(target=first.kill_one_at_work)
        killer.start()
        with pytest.raises(clangor.ShardError, match=r"bakes .* of 64 failed.*BrokenProcessPool") as lost:
            recipe(cache).bake(first)
        killer.join()
    done, missing = set(first.numbers("done")), set(lost.value.missing)
    # A job may end in the moment in which the pool breaks, and is named all the same.
    assert missing | done == set(range(1, BODIES + 1)) and len(missing & done) <= 2
    before = written(cache)
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        second = Logging(pool, tmp_path / "second", cache)
        assert recipe(cache).bake(second) == BODIES
    assert before.items() <= written(cache).items()
    check("processes, one of two killed, then run again", cache, serial, [first, second])
