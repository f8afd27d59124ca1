"""Reports: numbers, texts, files, figures."""

import json
import re

import numpy as np
import pytest
import symplint


def midpoint(q, p, h):
    dq, dp = p - 0.5 * h * np.sin(q), -np.sin(q + 0.5 * h * p)
    return q + h * dq, p + h * dp


@pytest.fixture(scope="module")
def report():
    return symplint.check(midpoint, 1.0, 0.5, step_sizes=[0.5, 0.25, 0.125, 0.0625])


def test_points_are_those_of_the_json(report):
    found = report.to_dict()
    assert json.loads(report.to_json()) == found
    assert found["schema"] == "symplint/report/3"
    assert found["evaluations"]["made"] == report.evaluations <= found["evaluations"]["budget"] == 20_000
    assert found["verdict"]["kind"] == report.kind == "not-symplectic"
    assert found["verdict"]["summary"] == report.summary
    assert found["verdict"]["sentences"] == report.sentences == report.evidence
    assert found["config"]["check"]["step"] == "midpoint"
    assert set(report.points.dtype.names) == set(found["points"][0])
    for name in report.points.dtype.names:
        for value, record in zip(report.points[name], found["points"], strict=True):
            assert value == record[name] or (record[name] is None and np.isnan(value))
    given = report.points[report.points["loop"] == 0]
    assert given["step_size"].tolist() == [0.5, 0.25, 0.125, 0.0625]
    # The circle has the area π, and the defect is what happens to it.
    assert np.allclose(given["initial"], np.pi, rtol=1e-14)
    assert np.allclose(given["defect"], np.abs(given["final"] / given["initial"] - 1.0), atol=1e-14)
    assert np.allclose(np.diff(np.log2(given["defect"])), -3.0, atol=0.5)
    assert report.breaks.size == 0 and report.breaks.dtype.names[:3] == ("loop", "step_size", "s")


def test_texts(report):
    text = str(report)
    assert text.startswith(report.headline) and "\nmidpoint · 1 degree of freedom\n" in text and "0.0625" in text
    assert repr(report) == "<symplint.Report: not symplectic: ∮p·dq changes in proportion to h³>"
    assert all(len(line) <= 100 for line in text.splitlines())


def test_html(report):
    page = report.to_html()
    assert page.startswith("<!DOCTYPE html>") and "<svg" in page and report.headline in page
    # One file without references to others.
    assert not re.search(r'(src|href)="(?!#)', page)
    fragment = report._repr_html_()
    assert "<html" not in fragment and "<style" not in fragment and "<svg" in fragment
    assert "<h2>Jacobian</h2>" in fragment and "<h2>Jacobian</h2>" in page

    def tricky(q, p, h):
        return midpoint(q, p, h)

    tricky.__name__ = "<script>&"
    page = symplint.check(tricky, 1.0, 0.5, step_sizes=[0.5]).to_html()
    assert "<script>" not in page and "&lt;script&gt;&amp;" in page


def test_folders(report, tmp_path):
    folder = tmp_path / "run"
    report.save(folder)
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    figures = [f"figures/{name}.{kind}" for name in ("loop", "step_sizes") for kind in ("pdf", "png", "svg")]
    assert names == [".lock", "config.toml", *figures, "points.csv", "report.html", "report.json"]
    assert json.loads((folder / "report.json").read_text()) == report.to_dict()
    rows = (folder / "points.csv").read_text().splitlines()
    assert len(rows) == 1 + len(report.points)
    other = tmp_path / "other"
    symplint.check(midpoint, 1.0, 0.5, step_sizes=[0.5], out=other)
    assert (other / "report.json").exists()
    occupied = tmp_path / "file"
    occupied.write_text("")
    with pytest.raises(symplint.SymplintError, match="file"):
        report.save(occupied)


@pytest.mark.parametrize("name", ["config.toml", "report.json", "report.html", "points.csv", "figures/loop.png"])
def test_files_that_symplint_did_not_write_are_kept(report, tmp_path, name):
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("[system]\n")
    for save in (
        lambda: report.save(tmp_path),
        lambda: symplint.check(midpoint, 1.0, 0.5, step_sizes=[0.5], run_dir=tmp_path),
    ):
        with pytest.raises(symplint.InputError, match=f"symplint did not write {name} .*; give another folder"):
            save()
    assert file.read_text() == "[system]\n" and not (tmp_path / "journal").exists()
    # Other files do not matter.
    file.rename(tmp_path / "mine")
    report.save(tmp_path)
    report.save(tmp_path)
    with pytest.raises(symplint.InputError, match="folder is an empty path"):
        report.save("")


def test_reports_of_the_program_and_of_forces_are_replaced(report, tmp_path):
    (tmp_path / "config.toml").write_text("# symplint run folder: check\n")
    (tmp_path / "points.csv").write_text("")
    report.save(tmp_path)
    folder = tmp_path / "force"
    symplint.check_force(lambda q: -q, 1.0, run_dir=folder)
    report.save(folder)
    (folder / "report.json").write_text("[1, 2]")
    with pytest.raises(symplint.InputError, match="did not write report.json"):
        symplint.check_force(lambda q: -q, 1.0, run_dir=folder)


def test_figures(report):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    ax = report.plot()
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels[0] == "your loop" and "$h^{3}$" in labels
    lines = dict(zip(labels, ax.get_lines(), strict=True))
    assert np.array_equal(lines["your loop"].get_ydata(), np.sort(report.points["defect"][report.points["loop"] == 0]))
    other = plt.figure().add_subplot()
    assert report.plot_loop(other, samples=100) is other
    before, after = other.get_lines()
    assert len(after.get_xdata()) == 100
    q, p = symplint.circle(1.0, 0.5, samples=100)
    q, p = midpoint(q, p, 0.5)
    assert np.allclose(after.get_xdata(), q[:, 0], atol=1e-15) and np.allclose(after.get_ydata(), p[:, 0], atol=1e-15)
    measured = symplint.measure(symplint.circle(1.0, 0.5, samples=100), (q, p))
    ax = measured.plot_loop()
    assert np.array_equal(ax.get_lines()[1].get_xdata(), q[:, 0])
    assert measured.plot() is not None
    assert report.plot(color="k", label="mine").get_lines()[0].get_color() == "k"
    assert report.plot_loop(marker="x").get_lines()[1].get_marker() == "x"
    for dof in (1, -1):
        with pytest.raises(symplint.InputError, match=f"dof is {dof}; give"):
            report.plot_loop(dof=dof)
    plt.close("all")


def test_breaks_are_drawn():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    def kinked(q, p, h):
        return q + h * p, p - h * np.sign(q)

    report = symplint.check(kinked, 0.3, 0.1, step_sizes=[0.5, 0.25], budget=4000)
    assert report.kind == "broken-loops"
    labels = [line.get_label() for line in report.plot_loop().get_lines()]
    broken = report.breaks
    assert labels.count("breaks") == 1
    assert len(labels) == 2 + len(broken[(broken["loop"] == 0) & (broken["step_size"] == 0.5)])
    for line in plt.gca().get_lines()[2:]:
        (q0, q1), (p0, p1) = line.get_data()
        # A chord over a jump of the force, 2 h, where q is 0 before the step.
        assert abs(abs(p1 - p0) - 1.0) < 0.1 and abs(q1 - q0) < 0.1
    plt.close("all")


def leapfrog(q, p, h):
    q = q + 0.5 * h * p
    p = p - h * np.sin(q)
    return q + 0.5 * h * p, p


@pytest.mark.parametrize("samples", [64, 256, 1024, 4096])
def test_measure_of_rows_that_are_lost_or_repeated(samples):
    random = np.random.default_rng(0)
    equal = np.arange(samples) / samples
    spacings = {
        "closed": np.linspace(0, 1, samples),
        "one lost": np.delete(equal, 5),
        "some lost": np.delete(equal, random.choice(samples, max(1, samples // 100), False)),
        "run lost": np.delete(equal, np.arange(10, 11 + samples // 20)),
        "any": np.sort(random.random(samples)),
    }
    for name, s in spacings.items():
        q, p = 1 + np.sin(2 * np.pi * s), 0.5 + np.cos(2 * np.pi * s)
        report = symplint.measure((q, p), leapfrog(q, p, 0.5), h=0.5)
        point = report.points[0]
        assert report.kind == "symplectic", (name, str(report))
        assert abs(point["signed_defect"]) <= point["quadrature_error"] + point["roundoff"], name
        said = " ".join(str(report).split())
        assert (f"Row {samples - 1} repeats row 0" in said) == (name == "closed"), said
        assert ("not equally spaced" in said) == (name != "closed"), said
        # The same rows of a step that loses 1%.
        q1, p1 = leapfrog(q, p, 0.5)
        damped = symplint.measure((q, p), (q1, 0.99 * p1), h=0.5)
        assert damped.kind == "not-symplectic"
        assert damped.points[0]["signed_defect"] == pytest.approx(-0.01, abs=1e-6)


def test_measure():
    q, p = symplint.circle([1.0, 0.3], [0.5, 0.1], radius=(0.5, [1.0, 2.0]))
    assert q.shape == p.shape == (256, 2)

    def step(q, p, h):
        p = p - h * np.sin(q)
        return q + h * p, p

    report = symplint.measure((q, p), step(q, p, 0.5), step(q, p, 0.25), h=[0.5, 0.25])
    assert report.kind == "symplectic" and report.digits > 12
    assert report.points["step_size"].tolist() == [0.5, 0.25]
    assert report.evaluations == 0
    unknown = symplint.measure((q, p), step(q, p, 0.5))
    assert unknown.kind == "symplectic" and np.isnan(unknown.points["step_size"]).all()
    # Periods and weights.
    wrapped = np.mod(step(q, p, 0.5)[0], 1.0)
    assert symplint.measure((np.mod(q, 1.0), p), (wrapped, step(q, p, 0.5)[1]), period=1.0).kind == "symplectic"
    heavy = symplint.measure((q, p), step(q, p, 0.5), weight=[2.0, 3.0])
    assert np.allclose(heavy.points["initial"], np.pi * (2.0 * 0.5 * 1.0 + 3.0 * 0.5 * 2.0))
    # Single precision is what the arrays say.
    single = [tuple(x.astype(np.float32) for x in states) for states in ((q, p), step(q, p, 0.5))]
    report = symplint.measure(*single)
    assert report.kind == "symplectic" and report.digits < 8
    # In lists, and in one degree of freedom without a second axis.
    q1, p1 = step(q[:, 0], p[:, 0], 0.5)
    assert symplint.measure((q[:, 0].tolist(), p[:, 0].tolist()), (q1, p1)).kind == "symplectic"
    for arguments, words in [
        (((q, p),), "no loop after"),
        (((q, p), (q[:-1], p[:-1])), "samples"),
        (((q, p), (q, p[:, :1])), "shape"),
        (((q, p), 3), "pair"),
        (((q, p), (q * np.nan, p)), "NaN"),
    ]:
        with pytest.raises(symplint.InputError, match=words):
            symplint.measure(*arguments)
    with pytest.raises(symplint.InputError, match="h has 2 values for 1"):
        symplint.measure((q, p), (q, p), h=[0.5, 0.25])


def test_loop_integrals():
    q, p = symplint.circle([0.0, 2.0], [1.0, 0.0], radius=([1.0, 2.0], [3.0, 1.0]), samples=64)
    integral = symplint.loop_integral(q, p)
    assert abs(integral.value - 5.0 * np.pi) < 1e-13
    assert np.allclose(integral.contributions, [3.0 * np.pi, 2.0 * np.pi], atol=1e-13)
    assert abs(integral.value - 5.0 * np.pi) <= integral.roundoff + integral.quadrature_error
    assert float(integral) == integral.value
    weighted = symplint.loop_integral(np.asfortranarray(q), p[:], weight=[1.0, 10.0])
    assert abs(weighted.value - 23.0 * np.pi) < 1e-12
    rough = symplint.loop_integral(q, p, rule="finite-difference")
    assert 1e-4 < abs(rough.value - integral.value) < 0.5
    # Cells where a coordinate changes too fast are left out: with a small cut-off, all but those where both change slowly.
    assert symplint.loop_integral(q, p, rule="finite-difference", cutoff=1e-9).value == 0.0
    some = symplint.loop_integral(q, p, rule="finite-difference", cutoff=(1e-9, 1000.0))
    assert some.value == 0.0
    for cutoff in (0.0, -1.0, float("nan"), "large", (1.0, 2.0, 3.0)):
        with pytest.raises(symplint.InputError, match="cutoff"):
            symplint.loop_integral(q, p, cutoff=cutoff)
    for arguments, words in [
        ((q, p[:-1]), "shape"),
        ((q[:2], p[:2]), "3 or more"),
        ((np.where(q > 0.5, np.inf, q), p), "inf"),
        (("q", p), "real numbers"),
    ]:
        with pytest.raises(symplint.InputError, match=words):
            symplint.loop_integral(*arguments)
    with pytest.raises(symplint.InputError, match="piecewise"):
        symplint.loop_integral(q, p, rule="piecewise")


def test_arrays_of_any_order_have_one_loop_integral():
    q, p = symplint.circle([0.0, 2.0], [1.0, 0.0], radius=([1.0, 2.0], [3.0, 1.0]), samples=1024)
    expected = symplint.loop_integral(q, p)
    assert abs(expected.value - 5.0 * np.pi) <= expected.roundoff + expected.quadrature_error
    for order in (
        np.asfortranarray,
        np.ascontiguousarray,
        lambda x: np.repeat(x, 2, axis=1)[:, ::2],
        lambda x: np.asfortranarray(np.repeat(x, 2, axis=0))[::2],
        lambda x: np.asfortranarray(x[::-1])[::-1],
    ):
        assert symplint.loop_integral(order(q), order(p)) == expected
        assert symplint.loop_integral(order(q), p) == expected
        lost = order(q).copy(order="K")
        lost[5, 1] = np.nan
        with pytest.raises(symplint.InputError, match="NaN|nan"):
            symplint.loop_integral(lost, p)
    one = [np.ascontiguousarray(x[:, 0]) for x in (q, p)]
    assert symplint.loop_integral(*one).value == expected.contributions[0]


def test_arrays_in_c_order_are_integrated_in_parts():
    # 70 degrees of freedom are two parts and a rest, 37 samples two tiles and a rest.
    s = np.arange(37)[:, None] / 37
    q, p = np.sin(2 * np.pi * s + np.arange(70)), (1 + np.arange(70)) * np.cos(2 * np.pi * s + np.arange(70))
    stated = {"period": np.where(np.arange(70) == 40, 2.5, 0.0), "weight": 1.0 + np.arange(70) / 70}
    expected = symplint.loop_integral(np.asfortranarray(q), np.asfortranarray(p), **stated)
    for in_order in (np.ascontiguousarray, lambda x: np.repeat(x, 3, axis=1)[:, ::3], lambda x: np.repeat(x, 2, axis=0)[::2]):
        found = symplint.loop_integral(in_order(q), in_order(p), **stated)
        assert found.value == expected.value and found.contributions == expected.contributions
        assert found.quadrature_error == pytest.approx(expected.quadrature_error, rel=1e-12, abs=0)
        assert found.roundoff == pytest.approx(expected.roundoff, rel=1e-12, abs=0)
    periodic = {"momentum_period": np.where(np.arange(70) == 69, 1000.0, 0.0)}
    assert symplint.loop_integral(q, p, **periodic).value == pytest.approx(symplint.loop_integral(np.asfortranarray(q), p, **periodic).value)
    lost = q.copy()
    lost[20, 65] = np.inf
    with pytest.raises(symplint.InputError, match=r"q\[65\] is inf"):
        symplint.loop_integral(lost, p)


def test_loops():
    step_sizes = [0.5, 0.25]
    circle = symplint.Circle([1.0, 0.2], [0.5, 0.1], radius=0.5, dofs=[0])
    q, p = circle.sample(8)
    assert np.ptp(q[:, 1]) == 0.0 and np.allclose(np.ptp(q[:, 0]), 1.0)
    assert np.allclose(circle([0.25])[0], [[1.5, 0.2]])

    def step(q, p, h):
        p = p - h * np.sin(q)
        return q + h * p, p

    of_circle = symplint.check(step, [1.0, 0.2], [0.5, 0.1], loop=circle, step_sizes=step_sizes)
    assert of_circle.kind == "symplectic"
    assert np.allclose(of_circle.points["initial"][0], 0.25 * np.pi)
    # The centre may be left to the loop.
    assert symplint.check(step, loop=circle, step_sizes=step_sizes).points.tobytes() == of_circle.points.tobytes()
    fourier = symplint.FourierLoop([1.0, 0.2], [0.5, 0.1], radius=0.5, seed=3)
    assert symplint.check(step, loop=fourier, step_sizes=step_sizes).kind == "symplectic"
    sampled = symplint.SampledLoop(*fourier.sample(64))
    assert np.allclose(sampled([0.3])[0], fourier([0.3])[0], atol=1e-13)

    def ellipse(s):
        assert s.ndim == 1
        angle = 2.0 * np.pi * s
        return 1.0 + 0.5 * np.sin(angle), 0.5 + 2.0 * np.cos(angle)

    report = symplint.check(step, 1.0, 0.5, loop=ellipse, step_sizes=step_sizes)
    assert report.kind == "symplectic" and np.isclose(report.points["initial"][0], np.pi)
    assert report.to_dict()["config"]["check"]["loop"] == "ellipse"


def test_radii_that_the_map_suggests():
    # A stiff spring: the motion runs on ellipses 100 times as high as they are wide.
    def step(q, p, h):
        p = p - h * 1e4 * q
        return q + h * p, p

    report = symplint.check(step, 0.3, 0.0, typical_step=1e-3, radius="auto")
    assert report.kind == "symplectic"
    q, p = 0.03, 3.0
    assert np.isclose(report.points["initial"][0], np.pi * q * p, rtol=0.1)


def test_a_constraint_manifold():
    # A pendulum of length 1 in Cartesian coordinates, by RATTLE.
    def step(q, p, h):
        gravity = np.array([0.0, -1.0])
        p = p + 0.5 * h * gravity
        moved = q + h * p
        a, b = (q * q).sum(1, keepdims=True), (moved * q).sum(1, keepdims=True)
        pull = (-b + np.sqrt(b * b - a * ((moved * moved).sum(1, keepdims=True) - 1.0))) / a
        new = moved + pull * q
        p = p + pull / h * q + 0.5 * h * gravity
        return new, p - new * (new * p).sum(1, keepdims=True)

    def project(q, p):
        q = q / np.linalg.norm(q, axis=1, keepdims=True)
        return q, p - q * (q * p).sum(1, keepdims=True)

    arguments = {"radius": 0.3, "step_sizes": [0.25, 0.125]}
    report = symplint.check(step, [0.6, -0.8], [0.4, 0.3], project=project, **arguments)
    assert report.kind == "symplectic"
    assert symplint.check(step, [0.6, -0.8], [0.4, 0.3], **arguments).kind != "symplectic"


def test_points_as_a_table_of_pandas(report):
    pandas = pytest.importorskip("pandas")
    table = report.to_dataframe()
    assert isinstance(table, pandas.DataFrame) and list(table.columns) == list(report.points.dtype.names)
    assert np.array_equal(table["defect"], report.points["defect"], equal_nan=True)
    assert table["samples"].dtype == np.int64
