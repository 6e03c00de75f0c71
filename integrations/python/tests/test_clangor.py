"""The package as a user has it: `pip install .[test]`, then `pytest integrations/python`."""

import gc
import importlib.util
import os
import re
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import clangor

ROOT = Path(__file__).resolve().parents[3]
DROP = ROOT / "scenes" / "ball-drop.toml"


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path_factory.getbasetemp() / "cache"
    folder.mkdir(exist_ok=True)
    monkeypatch.setenv("CLANGOR_CACHE", str(folder))


def test_a_scene_becomes_pressure() -> None:
    session = clangor.Session(DROP, duration=0.6)
    timeline = session.simulate()
    assert "ball" in timeline.bodies
    assert timeline.contacts["impulse_n"].min() > 0.0
    (sound,) = session.render()
    assert sound.pressure.dtype == np.float32
    assert sound.pressure.shape[0] == round(sound.duration * sound.sample_rate)
    assert sound.peak == pytest.approx(float(np.abs(sound.pressure).max()))
    assert sound.peak > 0.1


def test_the_file_has_the_same_samples(tmp_path: Path) -> None:
    session = clangor.Session(DROP, duration=0.5, listeners=[(0.3, 0.4, 0.4)])
    (sound,) = session.render(tmp_path / "drop.wav")
    data = (tmp_path / "drop.wav").read_bytes()
    start = data.index(b"data") + 8
    samples = np.frombuffer(data[start : start + 4 * sound.pressure.size], dtype="<f4")
    assert np.array_equal(samples, sound.pressure.ravel())


def test_arrays_are_not_copied() -> None:
    (sound,) = clangor.Session(DROP, duration=0.5).render()
    assert sound.pressure is sound.pressure


def test_a_strike_and_its_modes() -> None:
    struck = clangor.strike(
        "box:0.2x0.03x0.008", "brass", striker=("wood", 0.01, 1.0), seconds=0.2, quality="draft"
    )
    assert struck.pressure.shape == struck.times.shape and struck.modes > 5
    found = clangor.modes("box:0.2x0.03x0.008", "brass", max_frequency=3000.0)
    # Bernoulli's bar: f = 22.373 / (2 pi L^2) sqrt(E I / (rho A)).
    bar = 22.373 / (2 * np.pi * 0.2**2) * np.sqrt(100e9 * 0.008**2 / 12 / 8500)
    assert found.frequencies[0] == pytest.approx(bar, rel=0.02)
    heavier = clangor.modes(
        "box:0.2x0.03x0.008", {"base": "brass", "density": 34000.0}, max_frequency=3000.0
    )
    # Four times the density, half the frequency.
    assert heavier.frequencies[0] == pytest.approx(found.frequencies[0] / 2, rel=1e-3)


def test_timelines_are_read_back(tmp_path: Path) -> None:
    folder = tmp_path / "run.timeline"
    session = clangor.Session(DROP, duration=0.5, timeline=folder)
    simulated = session.simulate()
    read = clangor.Timeline.open(folder)
    assert read.bodies == simulated.bodies
    assert np.array_equal(read.contacts["t"], simulated.contacts["t"])
    pyarrow = pytest.importorskip("pyarrow")
    assert pyarrow.table(read.poses).num_rows == len(read.poses["t"])


def test_a_door_on_hinges_is_hit_with_its_inertia_about_them(tmp_path: Path) -> None:
    folder = tmp_path / "door.timeline"
    session = clangor.Session(ROOT / "scenes" / "door.toml", duration=1.0, timeline=folder)
    rows = session.simulate().contacts
    (door,) = (body for body in session.bodies if body.name == "door")
    hits = (rows["kind"] == 0) & ~np.isnan(rows["effective_mass"])
    names = ("point", "normal")
    point, normal = (np.array([rows[f"{name}_{axis}"][hits] for axis in "xyz"]) for name in names)
    lever = point[2] * normal[0] - point[0] * normal[2]
    inertia = rows["effective_mass"][hits] * lever**2
    wanted = door.mass * ((0.8**2 + 0.04**2) / 12 + 0.405**2)
    print(f"{hits.sum()} points, worst {np.abs(inertia / wanted - 1.0).max():.1e}, bar 1e-6")
    assert hits.any() and inertia == pytest.approx(wanted, rel=1e-6)
    read = clangor.Timeline.open(folder).contacts["effective_mass"]
    assert np.array_equal(read, rows["effective_mass"].astype(np.float32), equal_nan=True)


def test_progress_may_stop_the_work() -> None:
    stages = []

    def progress(stage: str, done: float, body: str, step: str) -> bool:
        stages.append(stage)
        return False

    with pytest.raises(clangor.ClangorError, match="interrupted"):
        clangor.Session(DROP, progress=progress).render()
    assert stages

    def failing(stage: str, done: float, body: str, step: str) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        clangor.Session(DROP, progress=failing).render()


def test_bad_input_is_named() -> None:
    with pytest.raises(clangor.ClangorError, match="plastik"):
        clangor.strike("bowl", "plastik")
    with pytest.raises(clangor.ClangorError, match="no-such"):
        clangor.Session("no-such.toml")
    with pytest.raises(clangor.ClangorError, match="body.0..shape|shape"):
        clangor.Session(text="version = 1\n[[body]]\nshape = \"spere\"\nmaterial = \"steel\"\n")
    with pytest.raises(ValueError, match="quality"):
        clangor.strike("bowl", "ceramic", quality="best")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="radius"):
        clangor.strike("bowl", "ceramic", striker=("steel", -1.0, 1.0))
    with pytest.raises(ValueError, match="densty"):
        clangor.modes("bowl", {"base": "steel", "densty": 1.0})
    with pytest.raises(ValueError, match="density"):
        clangor.modes("bowl", {"base": "steel", "density": float("nan")})
    with pytest.raises(ValueError, match="listeners"):
        clangor.Session(DROP, listeners=[(0.0, 1.0)])
    with pytest.raises(TypeError, match="seed"):
        clangor.Session(DROP, seed="one")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="path"):
        clangor.Session()


def test_a_session_serves_one_thread() -> None:
    inside = threading.Event()
    leave = threading.Event()

    def progress(stage: str, done: float, body: str, step: str) -> None:
        inside.set()
        leave.wait(10.0)

    session = clangor.Session(DROP, progress=progress)
    other = threading.Thread(target=session.render)
    other.start()
    assert inside.wait(30.0)
    with pytest.raises(RuntimeError, match="another thread"):
        session.simulate()
    leave.set()
    other.join()


def test_many_calls_do_not_grow() -> None:
    def resident() -> int:
        text = Path("/proc/self/statm").read_text() if os.path.exists("/proc/self/statm") else "0 0"
        return int(text.split()[1]) * 4096

    def after_calls() -> int:
        for _ in range(200):
            clangor.strike("sphere:0.01", "steel", seconds=0.1)
        gc.collect()
        return resident()

    after_calls()
    # The allocator keeps some freed pages for a while: the least of five. What calls leave behind grows each
    # time, pages that are kept for longer only once.
    least = [min(after_calls() for _ in range(5)) for _ in range(4)]
    grown = np.diff(least)
    print("growth in 1000 calls each:", ", ".join(f"{size / 1024:.0f}" for size in grown), "kB")
    assert grown.min() < 1 << 20


def test_the_examples_of_the_readme_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # They read scenes, and one writes a folder.
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "integrations" / "python" / "README.md").read_text()
    examples = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(examples) == 6
    have = all(importlib.util.find_spec(name) for name in ("mujoco", "pyarrow"))
    for example in examples if have else examples[:5]:
        exec(compile(example, "README.md", "exec"), {})


def test_it_imports_quickly() -> None:
    start = time.process_time()
    __import__("importlib").reload(clangor)
    assert time.process_time() - start < 0.3
