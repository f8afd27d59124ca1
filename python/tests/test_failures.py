"""What goes wrong inside a step, and what is refused before there is one."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
import symplint

SIZES = {"step_sizes": [0.5, 0.25]}


def verlet(q, p, h):
    p = p - 0.5 * h * np.sin(q)
    q = q + h * p
    return q, p - 0.5 * h * np.sin(q)


class NoConvergence(Exception):
    pass


def test_an_exception_is_the_cause_and_the_state_is_named():
    # Fails on the loop q = 1 + sin 2πs, p = 0.5 + cos 2πs where q > 1.9.
    def step(q, p, h):
        if (q > 1.9).any():
            raise NoConvergence("after 50 iterations")
        return verlet(q, p, h)

    with pytest.raises(symplint.StepError, match="NoConvergence: after 50 iterations") as caught:
        symplint.check(step, 1.0, 0.5, **SIZES)
    error = caught.value
    assert isinstance(error, RuntimeError) and isinstance(error.__cause__, NoConvergence)
    assert error.h == 0.5
    # The first state that fails by itself.
    first = np.arcsin(0.9) / (2 * np.pi)
    samples = round(error.sample / error.s)
    assert error.sample / samples == error.s
    assert error.s - 1 / samples <= first < error.s
    assert f"sample {error.sample} of {samples}" in str(error)


@pytest.mark.parametrize("budget", [200, 300, 500, 700, 1000, 20000])
@pytest.mark.parametrize("limit", [0.0, 0.01])
def test_a_small_budget_hides_no_failure(budget, limit):
    def step(q, p, h):
        if h > limit:
            raise NoConvergence("cannot open restart.dat")
        return verlet(q, p, h)

    with pytest.raises(symplint.StepError, match="cannot open restart.dat") as caught:
        symplint.check(step, [1.0, 2.0], [0.5, 0.1], budget=budget)
    assert isinstance(caught.value.__cause__, NoConvergence) and caught.value.h == 0.5


@pytest.mark.parametrize("budget", [200, 500, 20000])
@pytest.mark.parametrize(
    ("step", "words"),
    [(lambda q, p, h: (q * np.nan, p), "is NaN"), (lambda q, p, h: (q.T, p.T), "should have the shape")],
)
def test_a_small_budget_hides_no_wrong_result(step, words, budget):
    with pytest.raises(symplint.StepError, match=words):
        symplint.check(step, [1.0, 2.0], [0.5, 0.1], budget=budget)


def test_the_cause_is_kept_where_many_step_sizes_fail():
    def step(q, p, h):
        if (q > 1.9).any():
            raise NoConvergence(f"h = {h}")
        return verlet(q, p, h)

    sizes = [0.5 / (k + 1) for k in range(24)]
    with pytest.raises(symplint.StepError) as caught:
        symplint.check(step, 1.0, 0.5, step_sizes=sizes)
    cause = caught.value.__cause__
    assert isinstance(cause, NoConvergence) and str(cause) == f"h = {caught.value.h}"


def test_an_exception_in_a_step_of_one_state():
    def step(q, p, h):
        if q[0] > 1.9:
            raise NoConvergence
        return verlet(q, p, h)

    with pytest.raises(symplint.StepError) as caught:
        symplint.check(step, 1.0, 0.5, per_sample=True, **SIZES)
    assert isinstance(caught.value.__cause__, NoConvergence)
    assert np.sin(2 * np.pi * caught.value.s) > 0.9
    before = caught.value.s * (1 - 1 / caught.value.sample)
    assert np.sin(2 * np.pi * before) <= 0.9


def test_a_mistake_in_the_step_shows_with_its_line():
    def step(q, p, h):
        return q + undefined, p  # noqa: F821

    with pytest.raises(symplint.StepError, match="NameError") as caught:
        symplint.check(step, 1.0, 0.5, **SIZES)
    cause = caught.value.__cause__
    assert isinstance(cause, NameError)
    frames = []
    trace = cause.__traceback__
    while trace:
        frames.append(trace.tb_frame.f_code.co_name)
        trace = trace.tb_next
    assert "step" in frames


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite(value):
    def step(q, p, h):
        q, p = verlet(q, p, h)
        p[(q > 1.9) & (h == 0.25)] = value
        return q, p

    with pytest.raises(symplint.StepError, match=r"p\[0\] is") as caught:
        symplint.check(step, 1.0, 0.5, **SIZES)
    assert caught.value.h == 0.25 and caught.value.__cause__ is None
    assert 0.0 < caught.value.s < 0.5 and caught.value.sample is not None
    # The other step size is not lost.
    assert sorted({float(point["step_size"]) for point in caught.value.report.points}) == [0.5]
    assert "h = 0.25 was left out" in " ".join(str(caught.value.report).split())


def test_a_factory_that_fails():
    def make(h):
        raise ValueError("no table for this step size")

    with pytest.raises(symplint.StepError, match="no table"):
        symplint.check(make, 1.0, 0.5, make=True, **SIZES)

    with pytest.raises(symplint.StepError, match="not callable"):
        symplint.check(lambda h: 3, 1.0, 0.5, make=True, **SIZES)


def test_a_step_that_fails_on_random_loops_only():
    def step(q, p, h):
        # The given loop is a circle, which random ones are not.
        off = np.abs((q - 1.0) ** 2 + (p - 0.5) ** 2 - 1.0) > 0.05
        if off.any() and len(q) > 8:
            raise NoConvergence("off the circle")
        return verlet(q, p, h)

    report = symplint.check(step, 1.0, 0.5, **SIZES, jacobian=False)
    assert report.kind == "undecided"
    assert "off the circle" in str(report)


def test_a_loop_that_fails():
    def raises(s):
        raise NoConvergence("no such loop")

    with pytest.raises(symplint.InputError, match="the loop function failed: NoConvergence: no such loop") as caught:
        symplint.check(verlet, 1.0, 0.5, loop=raises, **SIZES)
    assert isinstance(caught.value.__cause__, NoConvergence)

    with pytest.raises(symplint.InputError, match="shape") as caught:
        symplint.check(verlet, 1.0, 0.5, loop=lambda s: (s, s[:-1]), **SIZES)
    assert "shape" in str(caught.value.__cause__)

    with pytest.raises(symplint.InputError, match="loop returned an object of type NoneType; return q and p$"):
        symplint.check(verlet, 1.0, 0.5, loop=lambda s: None, **SIZES)

    with pytest.raises(symplint.InputError, match=r"q\[0\] is NaN"):
        symplint.check(verlet, 1.0, 0.5, loop=lambda s: (s * np.nan, 0.0 * s), **SIZES)

    with pytest.raises(symplint.InputError, match="not closed"):
        symplint.check(verlet, 1.0, 0.5, loop=lambda s: (np.sin(6.0 * s), np.cos(6.0 * s)), **SIZES)


def test_a_projection_that_fails():
    def project(q, p):
        raise NoConvergence("off the manifold")

    with pytest.raises(symplint.InputError, match="the project function failed: NoConvergence: off") as caught:
        symplint.check(verlet, 1.0, 0.5, project=project, **SIZES)
    assert isinstance(caught.value.__cause__, NoConvergence)


@pytest.mark.parametrize("exception", [KeyboardInterrupt, SystemExit, GeneratorExit])
def test_exceptions_that_end_programs_pass_through(exception):
    calls = []

    def step(q, p, h):
        calls.append(h)
        if len(calls) == 20:
            raise exception
        return verlet(q, p, h)

    with pytest.raises(exception):
        symplint.check(step, 1.0, 0.5, **SIZES)
    assert len(calls) == 20


def test_ctrl_c_while_a_failing_sample_is_looked_for():
    calls = []

    def step(q, p, h):
        calls.append(len(q))
        if len(calls) > 1:
            raise KeyboardInterrupt
        raise NoConvergence

    with pytest.raises(KeyboardInterrupt):
        symplint.check(step, 1.0, 0.5, **SIZES)
    assert len(calls) == 2


def test_an_exception_of_progress_stops_the_check():
    seen = []

    def progress(measured, planned, h):
        seen.append((measured, planned, h))
        if measured == 2:
            raise NoConvergence("enough")

    calls = []

    def step(q, p, h):
        calls.append(h)
        return verlet(q, p, h)

    with pytest.raises(NoConvergence, match="enough"):
        symplint.check(step, 1.0, 0.5, step_sizes=[0.5, 0.25, 0.125, 0.0625], progress=progress)
    assert max(measured for measured, *_ in seen) == 2
    assert not {0.0625} & set(calls)


def test_progress_is_told_of_every_point():
    seen = []
    report = symplint.check(verlet, 1.0, 0.5, **SIZES, progress=lambda *event: seen.append(event))
    measured = [h for _, _, h in seen if h is not None]
    assert len(measured) == len(report.points)
    assert seen[-1][0] <= seen[-1][1]


def test_the_line_on_a_terminal_shows_the_check_and_the_evaluations(monkeypatch, capsys):
    monkeypatch.setattr("symplint._progress._is_terminal", lambda: True)
    monkeypatch.setattr("symplint._progress.INTERVAL", 0.02)

    def step(q, p, h):
        time.sleep(2e-3)
        return verlet(q, p, h)

    symplint.check(step, 1.0, 0.5, **SIZES, per_sample=True, budget=400, progress=True)
    drawn = capsys.readouterr().err
    assert "random loops" in drawn
    assert "of at most 400 evaluations" in drawn
    assert drawn.endswith("\r\x1b[K")


INTERRUPTED = """
import signal, sys, time
import numpy as np
import symplint

# Tests in the background of a script ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)

def step(q, p, h):
    {body}
    p = p - h * np.sin(q)
    return q + h * p, p

loop = symplint.circle(1.0, 1.0, samples=2**21)
print("ready", flush=True)
try:
    {check}
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("body", "check"),
    [
        ("time.sleep(0.3)", "symplint.check(step, np.ones(2), np.ones(2), budget=2_000_000)"),
        # Without Python in between, for minutes.
        (
            "pass",
            "symplint.check(symplint.integrators.strang(symplint.systems.fput(masses=64)), radius=0.1,"
            " budget=10**9, samples=2**16, loops=1000)",
        ),
        ("pass", "symplint.measure(loop, *[loop] * 30)"),
    ],
)
def test_ctrl_c(body, check):
    code = INTERRUPTED.format(body=body, check=check)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "ready\n"
            time.sleep(1.0)
            assert process.poll() is None
            start = time.monotonic()
            process.send_signal(signal.SIGINT)
            assert process.stdout.readline() == "interrupted\n"
            assert process.wait(10) == 0
            assert time.monotonic() - start < 5.0
        finally:
            process.kill()


@pytest.mark.filterwarnings("ignore:threads=4 exceeds")
def test_a_step_is_called_by_the_calling_thread_alone():
    threads = set()

    def step(q, p, h):
        threads.add(threading.get_ident())
        return verlet(q, p, h)

    found = [symplint.check(step, [1.0, 0.2], [0.5, 0.1], **SIZES, threads=count).points for count in (None, 1, 2, 4)]
    assert threads == {threading.get_ident()}
    # Same bits on any number of threads.
    for other in found[1:]:
        assert found[0].tobytes() == other.tobytes()


@pytest.mark.parametrize("count", [5_000, 10**6, 2**62])
def test_more_threads_than_processors_are_not_started(count):
    with pytest.warns(UserWarning, match=f"threads={count} exceeds the number of processors"):
        report = symplint.check(verlet, 1.0, 0.5, **SIZES, threads=count)
    assert report.to_dict()["provenance"]["threads"] <= (os.cpu_count() or 1)


def test_no_rule_is_the_default_rule():
    assert symplint.check(verlet, 1.0, 0.5, **SIZES, rule=None).kind == "symplectic"
    assert float(symplint.loop_integral(*symplint.circle(1.0, 0.5), rule=None)) == pytest.approx(np.pi)


def test_an_opening_is_not_the_motion_of_the_loop():
    def open_loop(s):
        angle = (2 * np.pi - 6.3e-11) * np.asarray(s)[:, None]
        return np.sin(angle), np.cos(angle)

    with pytest.raises(symplint.InputError, match=r"is 6\.3\d*e-11 away"):
        symplint.check(verlet, 0.0, 0.0, loop=open_loop)


def test_steps_backwards_keep_their_sign():
    def damped(q, p, h):
        q, p = verlet(q, p, h)
        return q, (1 - 0.01 * h) * p

    backwards = {"step_sizes": [-0.5, -0.25, -0.125, -0.0625]}
    for step, words in ((verlet, "for h from -0.5 to -0.0625"), (damped, "for h from -0.0625 to -0.5")):
        text = " ".join(str(symplint.check(step, 1.0, 0.5, **backwards)).split())
        assert words in text, text
        text = text.replace("up to 0.", "")
        assert "h = 0." not in text and "from 0." not in text and "to 0." not in text, text


def test_checks_on_several_threads_and_within_each_other():
    results = {}

    def inner(q, p, h):
        report = symplint.check(verlet, 1.0, 0.5, step_sizes=[0.5], loops=1, jacobian=False, budget=300)
        assert report.evaluations > 0
        return verlet(q, p, h)

    def run(threads):
        found = symplint.check(inner, 1.0, 0.5, step_sizes=[0.5], loops=1, jacobian=False, threads=threads)
        results[threads] = found.kind

    workers = [threading.Thread(target=run, args=(threads,)) for threads in (None, 1, 2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60)
    assert list(results.values()) == ["symplectic"] * 3


def test_the_interpreter_is_free_while_the_library_works():
    # A compiled check must let other threads run.
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        start = time.monotonic()
        integrator = symplint.integrators.strang(symplint.systems.fput(masses=64))
        symplint.check(integrator, radius=0.1, samples=2**13, budget=2_000_000, threads=1)
        seconds = time.monotonic() - start
    finally:
        stop.set()
        thread.join()
    assert seconds > 0.05
    during = [moment for moment in ticks if moment < start + seconds]
    assert len(during) > 20 * seconds


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"q0": [1.0, 2.0]}, "q0 has 2 values and p0 has 1"),
        ({"q0": []}, "q0 has 0"),
        ({"q0": [], "p0": []}, "empty"),
        ({"q0": [[1.0]]}, "shape"),
        ({"q0": "one"}, "real numbers"),
        ({"q0": np.nan}, "q is NaN|finite"),
        ({"q0": np.ma.masked_array([1.0], [True])}, "masked"),
        ({"q0": None}, "missing"),
        ({"q0": 1j}, "real numbers"),
        ({"step_sizes": []}, "step_sizes is an empty list"),
        ({"step_sizes": [0.0]}, r"step_sizes\[0\] is 0; give a finite number other than 0"),
        ({"step_sizes": [np.inf]}, r"step_sizes\[0\] is inf"),
        ({"step_sizes": [0.5], "typical_step": 0.1}, "both step_sizes and typical_step"),
        ({"typical_step": "fast"}, "typical_step is 'fast'"),
        ({"typical_step": -np.inf}, "typical_step is -inf"),
        ({"radius": -1.0}, "positive"),
        ({"radius": 0.0}, "positive"),
        ({"radius": "large"}, "auto"),
        ({"radius": [1.0, 2.0]}, "radius has 2 values for 1"),
        ({"loop": 3}, "loop is an object of type int"),
        ({"loop": symplint.Circle([0.0, 0.0], [0.0, 0.0])}, "must agree"),
        ({"loops": 0}, "loops is 0"),
        ({"loops": 2.5}, "loops is 2.5"),
        ({"loops": 10**15}, "loops is 1000000000000000; give at most 10000"),
        ({"loop": np.sin, "radius": 2.0}, "both loop and radius"),
        ({"loop": np.sin, "radius": np.ones(1)}, "both loop and radius"),
        ({"seed": -1}, "seed is -1"),
        ({"rule": "simpson"}, "pseudospectral"),
        ({"samples": 2}, "samples is 2"),
        ({"samples": "many"}, "auto"),
        ({"budget": 100}, "at least 200"),
        ({"closure": "chord"}, 'closure is "chord"; give "substeps" or "chords"'),
        ({"sample_sweep": {"from": 2}}, "sample_sweep.from is 2"),
        ({"period": [1.0, 2.0]}, "period has 2 values"),
        ({"period": -1.0}, r"period\[0\] is -1"),
        ({"weight": 0.0}, r"weight\[0\]"),
        ({"momentum_period": -1.0}, "period"),
        ({"momentum_period": [1.0, 2.0]}, "momentum_period has 2 values"),
        ({"cutoff": -1.0}, "cutoff"),
        ({"dtype": "float16"}, "float32"),
        ({"dtype": "int32"}, "float32"),
        ({"threads": 0}, "threads is 0"),
        ({"progress": 3}, "progress is 3"),
        ({"project": 3}, "project is an object of type int"),
        ({"step": 3}, "step is an object of type int"),
    ],
)
def test_arguments_that_are_not_valid(arguments, words):
    with pytest.raises(symplint.InputError, match=words) as caught:
        symplint.check(**({"step": verlet, "q0": 1.0, "p0": 0.5} | arguments))
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, symplint.SymplintError)


def test_arguments_that_do_not_exist_are_refused():
    with pytest.raises(TypeError, match="unexpected keyword argument 'perod'; did you mean 'period'?"):
        symplint.check(verlet, 1.0, 0.5, perod=1.0)
    with pytest.raises(TypeError, match="unexpected keyword argument 'step_size'; did you mean 'step_sizes'?"):
        symplint.check(verlet, 1.0, 0.5, step_size=0.1)


def test_keys_of_configurations_are_arguments():
    sweep = {"from": 16, "to": 64, "step_size": 0.5}
    report = symplint.check(verlet, 1.0, 0.5, step_sizes=[0.5, 0.25], sample_sweep=sweep)
    assert [point["samples"] for point in report.points if point["sweep"] == "samples"] == [16, 32, 64]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: symplint.FourierLoop(0.0, 0.0, seed=-1), "seed is -1"),
        (lambda: symplint.Circle(0.0, 0.0, phases=-1), "phases is -1"),
        (lambda: symplint.Circle(0.0, 0.0, phases="golden"), 'phases is "golden"'),
        (lambda: symplint.Circle(0.0, 0.0, phases="random", seed=-1), "seed is -1"),
        (lambda: symplint.Circle(0.0, 0.0, dofs=[-1]), "dofs is -1"),
        (lambda: symplint.Circle(0.0, 0.0).sample(-1), "samples is -1"),
        (lambda: symplint.circle(0.0, 0.0, samples=2**70), "samples is 1180591620717411303424"),
        (lambda: symplint.circle(0.0, 0.0, samples=10**15), "take fewer samples"),
        (lambda: symplint.assert_symplectic(verlet, 1.0, 0.5, digits="x"), "digits is 'x'"),
    ],
)
def test_numbers_that_are_not_valid(make, words):
    with pytest.raises(symplint.InputError, match=words):
        make()


@pytest.mark.parametrize("stream", [None, "closed"])
def test_progress_without_standard_error(stream, monkeypatch, tmp_path):
    if stream == "closed":
        stream = open(tmp_path / "errors", "w")  # noqa: SIM115
        stream.close()
    monkeypatch.setattr(sys, "stderr", stream)
    assert symplint.check(verlet, 1.0, 0.5, **SIZES, progress=True).kind == "symplectic"


def test_no_thread_and_no_file_is_left_behind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    symplint.check(verlet, 1.0, 0.5, **SIZES, threads=2)
    deadline = time.monotonic() + 5.0
    tasks = "/proc/self/task"
    if os.path.isdir(tasks):
        before = len(os.listdir(tasks))
        for _ in range(5):
            symplint.check(verlet, 1.0, 0.5, **SIZES, threads=2)
        while len(os.listdir(tasks)) > before and time.monotonic() < deadline:
            time.sleep(0.01)
        assert len(os.listdir(tasks)) <= before
    assert not list(tmp_path.iterdir())


def test_the_message_of_a_failed_assertion():
    def leaky(q, p, h):
        q, p = verlet(q, p, h)
        return q, p * (1.0 - 0.01 * h)

    with pytest.raises(symplint.NotSymplecticError) as caught:
        symplint.assert_symplectic(leaky, 1.0, 0.5)
    error = caught.value
    assert isinstance(error, AssertionError) and isinstance(error, symplint.SymplintError)
    assert error.report.kind == "not-symplectic"
    # What failed, by how much, where, and with which order.
    for part in ("leaky is not symplectic", "0.005", "h = 0.5", "in proportion to h"):
        assert part in str(error)

    with pytest.raises(symplint.NotSymplecticError, match="to .* digits only, not to 17"):
        symplint.assert_symplectic(verlet, 1.0, 0.5, digits=17)

    def hidden(q, p, h):
        # Larger steps show the loss, but 1e-9 is too small for it.
        q, p = verlet(q, p, h)
        return q, p * (1.0 - 1e-7 * h)

    with pytest.raises(symplint.UndecidedError, match="not enough for a verdict"):
        symplint.assert_symplectic(hidden, 1.0, 0.5, step_sizes=[1e-9])
    # A larger step shows no loss.
    symplint.assert_symplectic(verlet, 1.0, 0.5, step_sizes=[1e-9])
    report = symplint.assert_symplectic(verlet, 1.0, 0.5, digits=12)
    assert report.digits >= 12


def test_importing_brings_no_matplotlib():
    code = textwrap.dedent(
        """
        import sys, symplint
        assert "matplotlib" not in sys.modules
        """
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def _raises(q):
    raise ValueError("outside the table")


@pytest.mark.parametrize("outside", [_raises, lambda q: np.nan * q, lambda q: q[:-1], lambda q: q + np.inf])
def test_many_steps_that_fail_are_left_out_with_their_reason(outside):
    def flight(q, p, h):
        q = q + h * p
        return (outside(q) if np.abs(q).max() > 3.0 else q), p

    sizes = {"radius": 0.3, "step_sizes": [0.2, 0.1], "properties": False}
    report = symplint.check(flight, [0.5], [0.5], **sizes, steps=400)
    assert report.is_symplectic
    assert any("Many steps were left out: " in sentence for sentence in report.sentences), report
