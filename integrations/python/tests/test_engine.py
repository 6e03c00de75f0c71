"""The real-time engine: it plays what `strike` renders, from any thread, into arrays of the caller."""

import gc
import os
import threading
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import clangor

ROOT = Path(__file__).resolve().parents[3]
BAR = "box:0.2x0.03x0.008"
EAR = (0.5, 0.3, 0.4)
RATE = 48000
BAND = 16000.0
# `strike` begins so many samples before the impact.
LEAD = 96
MEETS: dict[str, Any] = {"point": (0, 0, 0), "normal": (0, 1, 0), "speed": 1}


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path_factory.getbasetemp() / "cache"
    folder.mkdir(exist_ok=True)
    monkeypatch.setenv("CLANGOR_CACHE", str(folder))


def ball_engine(**settings: Any) -> tuple[clangor.Engine, int]:
    engine = clangor.Engine([EAR], **settings)
    return engine, engine.add("sphere:0.02", "steel", quality="draft")


def apart(one: npt.NDArray[Any], other: npt.NDArray[Any]) -> float:
    """Largest difference over the peak of the first."""
    return float(np.abs(one - other).max() / np.abs(one).max())


def from_impact(sound: npt.NDArray[Any], engine: clangor.Engine, time: float, count: int) -> npt.NDArray[Any]:
    """The samples of a listener, aligned with those of `strike`."""
    start = round((time + engine.latency) * RATE) - LEAD
    return sound[start : start + count]


def played(engine: clangor.Engine, seconds: float, block: int = 128) -> npt.NDArray[np.float64]:
    return np.concatenate([engine.render(block) for _ in range(round(seconds * RATE / block))])[:, 0]


@pytest.mark.parametrize(
    "how",
    [
        {"striker": ("steel", 0.006, 1.0)},
        {"impulse": (0.001, -0.002, 0.003)},
    ],
)
def test_it_plays_what_strike_renders(how: dict[str, Any]) -> None:
    offline = clangor.strike(
        BAR, "brass", listener=EAR, seconds=0.15, quality="draft", max_frequency=BAND, **how
    ).pressure
    engine = clangor.Engine([EAR], max_frequency=BAND)
    bar = engine.add(BAR, "brass", quality="draft")
    time = 0.05
    engine.strike(bar, time=time, **how)
    live = from_impact(played(engine, 0.25), engine, time, len(offline))
    residual = apart(offline, live)
    print(f"{how}: peak {np.abs(offline).max():.3g} Pa, residual {residual:.1e}")
    assert engine.modes(bar) > 5 and engine.report["late"] == 0 and engine.report["refused"] == 0
    # Residuals seen: 4.3e-5 with the ball, 5.1e-5 with the impulse, of the delays of the engine.
    assert residual < 1e-3


def test_a_body_sounds_from_where_it_is() -> None:
    turn = (0.0, np.sin(0.4), 0.0, np.cos(0.4))
    place = np.array([1.0, -2.0, 0.5])
    c, s = np.cos(0.8), np.sin(0.8)
    ear = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ EAR + place
    sounds = []
    for listener, pose in [(EAR, {}), (ear, {"position": place, "orientation": turn})]:
        engine = clangor.Engine([listener], max_frequency=BAND)
        bar = engine.add(BAR, "brass", quality="draft", **pose)  # type: ignore[arg-type]
        engine.strike(bar, striker=("wood", 0.01, 1.0), time=0.01)
        sounds.append(played(engine, 0.1))
    residual = apart(sounds[0], sounds[1])
    print(f"turned and moved: {residual:.1e}")
    # Residual seen: 4e-16.
    assert residual < 1e-9
    # It goes where it is told to go, and is struck there: half as far away, it is louder and earlier.
    engine.silence()
    played(engine, 0.01)
    loud = []
    for share in (0.0, 0.5):
        engine.move_to(bar, (1 - share) * place + share * ear, orientation=turn)
        played(engine, 0.05)
        engine.strike(bar, striker=("wood", 0.01, 1.0))
        sound = np.abs(played(engine, 0.05))
        loud.append((sound.max(), np.argmax(sound > 0.5 * sound.max())))
        engine.silence()
        played(engine, 0.01)
    assert 1.5 < loud[1][0] / loud[0][0] < 3.0 and engine.report["refused"] == 0
    way = float(np.linalg.norm(EAR)) / 2
    # Samples of the way through air, 343 m/s; within the size of the bar.
    assert loud[0][1] - loud[1][1] == pytest.approx(way / 343.0 * RATE, abs=0.1 / 343.0 * RATE)


def test_raw_impacts_are_those_of_a_strike() -> None:
    struck = clangor.strike("sphere:0.02", "steel", listener=EAR, impulse=(0, -0.01, 0), seconds=0.02)
    engine, ball = ball_engine()
    time = 0.02
    engine.impact(
        slot=ball, duration=struck.contact_duration, velocity_change=struck.velocity_change, time=time
    )
    sound = from_impact(played(engine, 0.06), engine, time, len(struck.pressure))
    print(f"impacts of the caller: {apart(struck.pressure, sound):.1e}")
    # Residual seen: 7e-12.
    assert apart(struck.pressure, sound) < 1e-6
    engine = clangor.Engine([EAR])
    engine.impact(
        radius=0.02, duration=struck.contact_duration, velocity_change=struck.velocity_change, time=time
    )
    assert apart(struck.pressure, from_impact(played(engine, 0.06), engine, time, len(sound))) < 1e-4


def test_forces_may_have_any_course() -> None:
    at = np.linspace(0.0, 2e-4, 41)
    course = np.sin(np.pi * at / at[-1])
    engine, ball = ball_engine()
    step = float(at[1])
    engine.impact(
        slot=ball, duration=2e-4, velocity_change=(0, -1, 0), force=(0.0, step, course / course.sum() / step)
    )
    assert np.abs(played(engine, 0.05)).max() > 0.1 and engine.report["simplified"] == 0


def test_bodies_meet_each_other_and_the_ground() -> None:
    engine = clangor.Engine([EAR])
    struck = engine.add("sphere:0.02", "steel", quality="draft")
    ball = engine.add("sphere:0.01", "brass", quality="draft", position=(0.03, 0, 0))
    engine.collide(ball, struck, point=(0.02, 0, 0), normal=(2.0, 0, 0), speed=1.0)
    both = played(engine, 0.05)
    assert engine.report["waves"] == 2 and np.abs(both).max() > 0.1
    # The same with a ball that strikes.
    other = clangor.Engine([EAR])
    body = other.add("sphere:0.02", "steel", quality="draft")
    other.strike(body, striker=("brass", 0.01, 1.0), point=(0.02, 0, 0))
    residual = apart(both, played(other, 0.05))
    print(f"a collision and a strike: {residual:.1e}")
    # Residual seen: 0.
    assert residual < 1e-9
    engine.collide(ball, "granite", point=(0.03, -0.01, 0), normal=(0, 1, 0), speed=1.0)
    assert np.abs(played(engine, 0.05)).max() > 0.1 and engine.report["waves"] == 3


def test_a_scene_gives_acoustics_and_bodies() -> None:
    session = clangor.Session(ROOT / "scenes" / "ball-drop.toml")
    engine = clangor.Engine([EAR, (0.6, 0.3, 0.4)], scene=session)
    slots = engine.add_scene(session, quality="draft")
    assert set(slots) == {"ball"} and engine.listeners == 2
    engine.collide(slots["ball"], "granite", point=(0, 0, 0), normal=(0, 1, 0), speed=2.0)
    sound = engine.render(4800)
    assert sound.shape == (4800, 2) and np.abs(sound).max(axis=0).min() > 0.01


def test_arrays_of_the_caller_are_filled() -> None:
    def sound(fill: Any) -> npt.NDArray[Any]:
        engine, ball = ball_engine()
        engine.strike(ball)
        return np.asarray(fill(engine))

    whole = sound(lambda engine: engine.render(6000))
    assert whole.dtype == np.float64 and whole.shape == (6000, 1) and np.abs(whole).max() > 0.01
    single = np.empty((6000, 1), dtype=np.float32)
    filled = sound(lambda engine: engine.render(out=single))
    assert filled is single and np.array_equal(single, whole.astype(np.float32))
    # Every other row of an array in Fortran's order, from the end.
    wide = np.zeros((12000, 3), dtype=np.float64, order="F")
    sound(lambda engine: engine.render(6000, out=wide[::-2, 1:2]))
    assert np.array_equal(wide[::-2, 1:2], whole) and not wide[:, 0].any() and not wide[::2].any()


def test_wrong_arrays_are_refused() -> None:
    engine, _ = ball_engine()
    locked = np.zeros((8, 1))
    locked.flags.writeable = False
    shared = np.lib.stride_tricks.as_strided(np.zeros(8), shape=(8, 1), strides=(0, 8))
    odd = np.zeros(65, dtype=np.uint8)[1:].view(np.float64).reshape(8, 1)
    for out, error, message in [
        (np.zeros((8, 2)), ValueError, r"out has the shape \[8, 2\]; it must be \[frames, 1\]"),
        (np.zeros(8), ValueError, r"out has the shape \[8\]"),
        (np.zeros((0, 1)), ValueError, r"out has the shape \[0, 1\]"),
        (np.zeros((8, 1), dtype=np.int16), TypeError, "out has the dtype int16; it must be float32"),
        (np.zeros((8, 1), dtype=">f4"), TypeError, "out has the dtype >f4"),
        ([[0.0]], TypeError, "out is a list"),
        (locked, ValueError, "out is read-only"),
        (shared, ValueError, "out: with strides"),
        (odd, ValueError, "out: with strides"),
    ]:
        with pytest.raises(error, match=message):
            engine.render(out=out)  # type: ignore[call-overload]
    with pytest.raises(ValueError, match=r"out has the shape \[8, 1\]; it must be \[7, 1\]"):
        engine.render(7, out=np.zeros((8, 1)))
    for frames in (0, -1, 1 << 40, 1 << 70):
        with pytest.raises(ValueError, match=f"frames is {frames}; it can be 1 to"):
            engine.render(frames)
    with pytest.raises(TypeError, match="frames: "):
        engine.render(1.5)  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="frames` or `out"):
        engine.render()  # type: ignore[call-overload]
    assert engine.time == 0.0


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda e: e.strike(5), ValueError, "slot: there is no body in slot 5, of 64"),
        (lambda e: e.strike(-1), ValueError, "slot: "),
        (lambda e: e.remove(1 << 70), ValueError, "slot: "),
        (lambda e: e.modes("bar"), TypeError, "slot: "),
        (lambda e: e.collide(0, -1, **MEETS), ValueError, "partner: "),
        (lambda e: e.impact(slot=-1, duration=1e-4), ValueError, "slot: "),
        (lambda e: e.end(0, time=float("nan")), ValueError, "time is NaN"),
        (lambda e: e.strike(0, impulse=(0, float("nan"), 0)), ValueError, "impulse is .*NaN"),
        (lambda e: e.strike(0, impulse=(0, 1)), ValueError, "impulse: "),
        (lambda e: e.strike(0, point="top"), (TypeError, ValueError), "point: "),
        (lambda e: e.strike(0, point=(1, 1, 1)), clangor.ClangorError, "1.7 m off the surface"),
        (lambda e: e.strike(0, striker=("steel", -1, 1)), ValueError, "striker: radius is -1"),
        (lambda e: e.strike(0, impulse=(0, 1, 0), striker=("steel", 1, 1)), ValueError, "give either"),
        (lambda e: e.strike(0, when=1), TypeError, 'no keyword "when"'),
        (lambda e: e.strike(0, time=100.0), ValueError, "time is 100 s; the engine is at 0 s"),
        (lambda e: e.strike(0, time=float("inf")), ValueError, "time is inf"),
        (lambda e: e.collide(0, 0, **MEETS), ValueError, "partner is 0"),
        (lambda e: e.collide(0, 9, **MEETS), ValueError, "slot 9"),
        (lambda e: e.collide(0, "steel", **{**MEETS, "normal": (0, 0, 0)}), ValueError, "normal is"),
        (lambda e: e.collide(0, "steel", **{**MEETS, "speed": 0}), ValueError, "speed is 0"),
        (lambda e: e.collide(0, "stel", **MEETS), clangor.ClangorError, "stel"),
        (lambda e: e.collide(0, "steel", normal=(0, 1, 0), speed=1), TypeError, "point is missing"),
        (lambda e: e.impact(slot=0), TypeError, "duration is missing"),
        (lambda e: e.impact(slot=0, duration=20.0), ValueError, "duration is 20 s"),
        (lambda e: e.impact(duration=1e-4), ValueError, "give either `slot` or `radius`"),
        (lambda e: e.impact(radius=-1.0, duration=1e-4), ValueError, "radius is -1 m"),
        (lambda e: e.impact(slot=0, duration=1e-4, impulse=(1e10, 0, 0)), ValueError, "impulse is"),
        (lambda e: e.impact(slot=0, duration=1e-4, force=(0, 0, [1.0])), ValueError, "force: 1 samples"),
        (lambda e: e.move_to(0, (0, 0, 0), orientation=(0, 0, 0, 2)), ValueError, "of length 2; it must"),
        (lambda e: e.move_to(0, (0, 0)), ValueError, "position: "),
        (lambda e: e.move_to(7, (0, 0, 0)), ValueError, "slot 7"),
        (lambda e: e.listen([(0, 0, 0), (1, 0, 0)]), ValueError, "there are 2; the engine was made for 1"),
        (lambda e: e.listen([(0, 0, float("inf"))]), ValueError, r"listeners\[0\] is"),
        (lambda e: e.switch("echo", True), ValueError, 'part is "echo"'),
        (lambda e: e.add("spere", "steel"), clangor.ClangorError, "spere"),
        (lambda e: e.add("sphere:0.01", "stel"), clangor.ClangorError, "stel"),
        (lambda e: e.add("sphere:0.01", "steel", quality="best"), ValueError, "quality"),
        (lambda e: e.add_scene("scene.toml"), TypeError, "session"),
        (lambda e: clangor.Engine([]), ValueError, "listeners: there are 0"),
        (lambda e: clangor.Engine([EAR], block=8), ValueError, "block is 8; it can be 16 to 4096"),
        (lambda e: clangor.Engine([EAR], block=-8), ValueError, "block: "),
        (lambda e: clangor.Engine([EAR], objects=0), ValueError, "objects is 0"),
        (lambda e: clangor.Engine([EAR], sample_rate=10), ValueError, "sample_rate: .*10"),
        (lambda e: clangor.Engine([EAR], reach=1e9), ValueError, "reach is 1000000000 m"),
        (lambda e: clangor.Engine([EAR], max_frequency=-1.0), clangor.ClangorError, "-1"),
        (lambda e: clangor.Engine([EAR], scene="x.toml"), TypeError, "scene: "),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_bad_input_is_named(call: Any, error: Any, message: str) -> None:
    engine, _ = ball_engine()
    with pytest.raises(error, match=message):
        call(engine)
    # What was refused has not reached the engine.
    assert not engine.render(4800).any() and engine.report["refused"] == 0


def test_slots_are_used_again() -> None:
    engine, ball = ball_engine(objects=1)
    with pytest.raises(ValueError, match="objects: all 1 slots have a body"):
        engine.add("sphere:0.03", "steel", quality="draft")
    engine.remove(ball)
    with pytest.raises(ValueError, match="slot 0"):
        engine.strike(ball)
    engine.render(128)
    assert engine.add("sphere:0.03", "steel", quality="draft") == ball
    engine.strike(ball)
    assert np.abs(engine.render(4800)).max() > 0.01


def test_one_thread_renders_and_others_send() -> None:
    engine, ball = ball_engine()
    engine.render(128)
    errors: list[BaseException] = []
    started = threading.Event()

    def render() -> None:
        started.set()
        try:
            engine.render(1 << 22)
        except BaseException as error:
            errors.append(error)

    other = threading.Thread(target=render)
    other.start()
    started.wait()
    while engine.time < 0.1 and other.is_alive():
        pass
    # The lock of the interpreter is free meanwhile, and so is the end that sends.
    engine.strike(ball)
    with pytest.raises(RuntimeError, match="Engine.render: another thread renders with this engine"):
        engine.render(128)
    assert other.is_alive()
    other.join()
    assert not errors and engine.report["waves"] == 1
    assert engine.time == pytest.approx((128 + (1 << 22)) / RATE)


def test_many_calls_do_not_grow() -> None:
    def resident() -> int:
        text = Path("/proc/self/statm").read_text() if os.path.exists("/proc/self/statm") else "0 0"
        return int(text.split()[1]) * 4096

    engine = clangor.Engine([EAR])
    bar = engine.add(BAR, "brass", quality="draft")
    block = np.empty((128, 1), dtype=np.float32)

    def call(count: int) -> None:
        for number in range(count):
            engine.strike(bar, striker=("wood", 0.01, 1.0)) if number % 8 == 0 else engine.strike(bar)
            engine.move_to(bar, (0.0, 0.0, 0.0))
            engine.render(out=block)
            engine.render(16)

    # What a call leaves behind grows in every window; pages that the allocators keep grow in one.
    call(2000)
    grown = []
    for _ in range(3):
        gc.collect()
        before = resident()
        call(10_000)
        gc.collect()
        grown.append(resident() - before)
    print(f"{', '.join(f'{size / 1024:.0f}' for size in grown)} kB more after 10 000 calls each")
    assert min(grown) < 1 << 20
