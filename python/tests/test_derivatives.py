"""Derivatives of steps: of the user, or found by JAX."""

import numpy as np
import pytest
import symplint

CENTRE = ([1.0, 0.3], [0.5, -0.2])
SIZES = {"step_sizes": [0.5, 0.25, 0.125]}
EXACT = "(exact derivatives)"


def leapfrog(q, p, h):
    q = q + 0.5 * h * p
    p = p - h * np.sin(q)
    return q + 0.5 * h * p, p


def of_leapfrog(q, p, h, dq, dp):
    middle = q + 0.5 * h * p
    dq = dq + 0.5 * h * dp
    dp = dp - h * np.cos(middle) * dq
    return dq + 0.5 * h * dp, dp


def has_exact_jacobian(report):
    return any("Jacobian" in sentence and EXACT in sentence for sentence in report.sentences)


@pytest.mark.parametrize("per_sample", [False, True])
def test_a_derivative_of_the_user_gives_the_jacobian(per_sample):
    by_differences = symplint.check(leapfrog, *CENTRE, **SIZES, per_sample=per_sample)
    report = symplint.check(leapfrog, *CENTRE, **SIZES, per_sample=per_sample, jvp=of_leapfrog)
    assert report.kind == by_differences.kind == "symplectic"
    assert has_exact_jacobian(report) and not has_exact_jacobian(by_differences)
    assert report.evaluations < by_differences.evaluations


def test_a_derivative_serves_weights_arguments_repeats_and_maps_without_a_step_size():
    def step(q, v, h, k):
        v = v - h * np.sin(k * q) / np.array([1.0, 3.0])
        return q + h * v, v

    def jvp(q, v, h, dq, dv, k):
        dv = dv - h * k * np.cos(k * q) * dq / np.array([1.0, 3.0])
        return dq + h * dv, dv

    arguments = {"args": (1.5,), "weight": [1.0, 3.0], "jvp": jvp}
    for more in ({}, {"repeat": 2}):
        report = symplint.check(step, *CENTRE, **SIZES, **arguments, **more)
        assert report.kind == "symplectic" and has_exact_jacobian(report)
    report = symplint.check(
        lambda q, p: leapfrog(q, p, 0.5), *CENTRE, step_sizes="none", jvp=lambda q, p, dq, dp: of_leapfrog(q, p, 0.5, dq, dp)
    )
    assert report.kind == "symplectic" and has_exact_jacobian(report)


def test_a_defect_that_derivatives_show_is_that_of_differences():
    def damped(q, p, h):
        q, p = leapfrog(q, p, h)
        return q, p * (1 - 1e-3 * h)

    def jvp(q, p, h, dq, dp):
        dq, dp = of_leapfrog(q, p, h, dq, dp)
        return dq, dp * (1 - 1e-3 * h)

    found = [symplint.check(damped, *CENTRE, **SIZES, jvp=of).properties["conformal"].factor for of in (jvp, None)]
    assert found == pytest.approx([1 - 0.5e-3] * 2, abs=1e-9)
    assert found[0] == pytest.approx(1 - 0.5e-3, abs=1e-14)


def test_a_wrong_derivative_is_not_trusted():
    def wrong(q, p, h, dq, dp):
        return dq, dp

    report = symplint.check(leapfrog, *CENTRE, **SIZES, jvp=wrong)
    assert report.kind in ("symplectic", "undecided") and not has_exact_jacobian(report)


def test_results_of_another_kind_are_refused():
    for jvp, words in (
        (lambda q, p, h, dq, dp: None, "jvp returns no pair"),
        (lambda q, p, h, dq, dp: (dq[:, :1], dp), "jvp returns dq of shape"),
    ):
        report = symplint.check(leapfrog, *CENTRE, **SIZES, jvp=jvp)
        assert any(words in sentence for sentence in report.sentences), report
    for arguments, words in (
        ({"jvp": 3}, "give a function"),
        ({"jvp": of_leapfrog, "project": lambda q, p: None}, "with project"),
    ):
        with pytest.raises(symplint.InputError, match=words):
            symplint.check(leapfrog, *CENTRE, **SIZES, **arguments)


def test_a_stopped_check_keeps_derivatives(tmp_path):
    calls = []

    def counted(q, p, h, dq, dp):
        calls.append(len(q))
        return of_leapfrog(q, p, h, dq, dp)

    arguments = SIZES | {"jvp": counted, "run_dir": tmp_path, "key": "counted"}
    first = symplint.check(leapfrog, *CENTRE, **arguments)
    made = len(calls)
    again = symplint.check(leapfrog, *CENTRE, **arguments)
    assert made > 0 and len(calls) == made
    assert again.digits == first.digits and has_exact_jacobian(again)


def test_jax_finds_derivatives():
    jax = pytest.importorskip("jax")
    jnp = jax.numpy

    def step(q, p, h):
        p = p - h * jnp.sin(q)
        return q + h * p, p

    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    try:
        report = symplint.check(jax.jit(step), *CENTRE, **SIZES)
        assert report.kind == "symplectic" and has_exact_jacobian(report)
        of_arguments = jax.jit(lambda q, p, h, k: step(q, p, k * h))
        assert has_exact_jacobian(symplint.check(of_arguments, *CENTRE, **SIZES, args=(0.5,)))
        # A step that keeps what it is called with gets no abstract arrays.
        kept = []
        report = symplint.check(lambda q, p, h: (kept.append(q), step(q, p, h))[1], *CENTRE, **SIZES)
        assert report.kind == "symplectic" and all(isinstance(q, np.ndarray) for q in kept)
        # JAX takes the derivative of what is behind stop_gradient as 0.
        stopped = symplint.check(jax.jit(lambda q, p, h: step(jax.lax.stop_gradient(q), p, h)), *CENTRE, **SIZES)
        assert not has_exact_jacobian(stopped) and stopped.kind in ("symplectic", "undecided")
    finally:
        jax.config.update("jax_enable_x64", before)


def test_a_step_that_is_not_compiled_is_traced_if_asked():
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)

    def step(q, p, h):
        p = p - h * jax.numpy.sin(q)
        return q + h * p, p

    try:
        assert not has_exact_jacobian(symplint.check(step, *CENTRE, **SIZES))
        report = symplint.check(step, *CENTRE, **SIZES, jacobian="auto")
        assert report.kind == "symplectic" and has_exact_jacobian(report)
    finally:
        jax.config.update("jax_enable_x64", before)


def test_torch_finds_derivatives():
    torch = pytest.importorskip("torch")
    weights = torch.randn(2, 8, dtype=torch.float64, generator=torch.Generator().manual_seed(1))

    def sympnet(q, p, h):
        q, p = torch.as_tensor(q), torch.as_tensor(p)
        p = p - h * torch.tanh(q @ weights) @ weights.T
        return q + h * p, p

    def in_place(q, p, h):
        q, p = torch.as_tensor(q), torch.as_tensor(p)
        p -= h * torch.sin(q)
        q += h * p

    def residual(q, p, h):
        z = torch.hstack([torch.as_tensor(q), torch.as_tensor(p)])
        z = z + h * torch.tanh(z @ torch.ones(4, 4, dtype=torch.float64))
        return z[:, :2], z[:, 2:]

    compiled = torch.compile(sympnet, backend="eager")
    symplectic = [(step, "symplectic") for step in (sympnet, in_place, compiled)]
    for step, kind in [*symplectic, (residual, "not-symplectic")]:
        by_differences = symplint.check(step, *CENTRE, **SIZES)
        report = symplint.check(step, *CENTRE, **SIZES, jacobian="auto")
        assert report.kind == by_differences.kind == kind
        assert has_exact_jacobian(report) and not has_exact_jacobian(by_differences)
    one = symplint.check(lambda q, p, h: sympnet(q, p, h), *CENTRE, **SIZES, jacobian="auto", per_sample=True)
    assert one.kind == "symplectic" and has_exact_jacobian(one)
    # torch takes the derivative of what is detached as 0.
    detached = symplint.check(lambda q, p, h: sympnet(torch.as_tensor(q).detach(), p, h), *CENTRE, **SIZES, jacobian="auto")
    assert not has_exact_jacobian(detached) and detached.kind in ("symplectic", "undecided")
    with pytest.warns(UserWarning, match=r"torch: expected np.ndarray .*torch.as_tensor"):
        from_numpy = symplint.check(lambda q, p, h: sympnet(torch.from_numpy(q), p, h), *CENTRE, **SIZES, jacobian="auto")
    assert from_numpy.kind == "symplectic" and not has_exact_jacobian(from_numpy)
    with pytest.warns(UserWarning, match="the type float16"):
        symplint.check(lambda q, p, h: tuple(rows.half() for rows in sympnet(q, p, h)), *CENTRE, **SIZES, jacobian="auto")


def test_a_step_of_numpy_is_not_traced():
    with pytest.warns(UserWarning, match="cannot be traced"):
        report = symplint.check(leapfrog, *CENTRE, **SIZES, jacobian="auto")
    assert report.kind == "symplectic" and not has_exact_jacobian(report)
    with pytest.raises(symplint.InputError, match='True, False or "auto"'):
        symplint.check(leapfrog, *CENTRE, **SIZES, jacobian="exact")
