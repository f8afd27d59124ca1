"""Steps that compute with arrays of JAX and torch, where these are installed."""

import re

import numpy as np
import pytest
import symplint

CENTRE = ([1.0, 0.3], [0.5, -0.2])
SIZES = {"step_sizes": [0.5, 0.25, 0.125]}


def check(step, **arguments):
    return symplint.check(step, *CENTRE, **(SIZES | arguments))


@pytest.fixture
def jax():
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


@pytest.fixture
def torch():
    return pytest.importorskip("torch")


def kick_and_drift(of, sin):
    """Kicks and drifts arrays that `of` makes of those of numpy."""

    def step(q, p, h):
        q, p = of(q), of(p)
        p = p - h * sin(q)
        return q + h * p, p

    return step


def test_jax_in_double_precision(jax):
    jnp = jax.numpy
    step = kick_and_drift(jnp.asarray, jnp.sin)
    one = kick_and_drift(lambda x: x, jnp.sin)
    forms = {
        "eager": step,
        "jit": jax.jit(step),
        "vmap": jax.jit(jax.vmap(one, (0, 0, None))),
        "dlpack": kick_and_drift(jnp.from_dlpack, jnp.sin),
        "one array for both": lambda q, p, h: jnp.stack(step(q, p, h)),
    }
    for name, form in forms.items():
        report = check(form)
        assert report.kind == "symplectic" and report.digits > 13, (name, str(report))
    report = check(jax.jit(step), per_sample=True, budget=2000, loops=2)
    assert report.kind == "symplectic"


@pytest.mark.parametrize("double", [True, False])
def test_jax_compiles_a_step_for_few_sizes(jax, double):
    jax.config.update("jax_enable_x64", double)
    step = jax.jit(jax.vmap(kick_and_drift(lambda x: x, jax.numpy.sin), (0, 0, None)))
    sizes = set()

    def counted(q, p, h):
        sizes.add(len(q))
        return step(q, p, h)

    report = symplint.check(counted, *CENTRE)
    assert report.kind == "symplectic" and report.digits > (12 if double else 6)
    assert len(sizes) <= 6


def test_gradients_of_jax(jax):
    jnp = jax.numpy

    def hamiltonian(q, p):
        return 0.5 * jnp.dot(p, p) + 0.3 * jnp.sin(q[0] + 2.0 * q[1]) - jnp.cos(q).sum()

    force = jax.grad(hamiltonian)

    def euler(q, p, h):
        p = p - h * force(q, p)
        return q + h * p, p

    def midpoint(q, p, h):
        half_q, half_p = q + 0.5 * h * p, p - 0.5 * h * force(q, p)
        return q + h * half_p, p - h * force(half_q, half_p)

    def batched(step):
        return jax.jit(jax.vmap(step, (0, 0, None)))

    assert check(batched(euler)).digits > 13
    report = check(batched(midpoint), step_sizes=0.5 ** np.arange(1, 8))
    assert report.kind == "not-symplectic" and report.order == 3.0, str(report)


def test_jax_in_single_precision(jax):
    jnp = jax.numpy
    jax.config.update("jax_enable_x64", False)
    step = jax.jit(kick_and_drift(jnp.asarray, jnp.sin))
    # Without a word on it, JAX computes in single precision: that is seen.
    for arguments in ({}, {"dtype": "float32"}, {"dtype": jnp.float32}):
        report = check(step, **arguments)
        assert report.kind == "symplectic" and 6.5 < report.digits < 8.5, str(report)


@pytest.mark.parametrize("jacobian", [True, "auto"])
def test_networks_in_single_precision_have_six_digits_after_few_compilations(jax, jacobian):
    jnp = jax.numpy
    jax.config.update("jax_enable_x64", False)

    def verlet(seed):
        of_weights, of_sum = jax.random.split(jax.random.PRNGKey(seed))
        weights = jax.random.normal(of_weights, (2, 16))
        last = jax.random.normal(of_sum, (16,)) / 16
        force = jax.grad(lambda q: -(jnp.tanh(q @ weights) @ last + 0.5 * (q**2).sum(-1)).sum())

        def step(q, p, h):
            p = p + 0.5 * h * force(q)
            q = q + h * p
            return q, p + 0.5 * h * force(q)

        return jax.jit(step)

    decided = []
    for seed in (5, 7, 9):
        step = verlet(seed)
        report = symplint.check(step, *CENTRE, radius=0.5, jacobian=jacobian)
        assert step._cache_size() <= 6
        # Derivatives by JAX; differences of results in single precision leave three or four digits.
        (jacobian_digits,) = re.findall(r"to ([\d.]+) digits \(exact derivatives\)", " ".join(report.sentences))
        assert float(jacobian_digits) >= 5.9
        # Rounding may look like small jumps, which leaves a verdict open.
        assert report.kind in ("symplectic", "undecided"), str(report)
        decided += [report.digits] if report.kind == "symplectic" else []
    assert len(decided) >= 2 and min(decided) >= 6.0, decided


def test_bfloat16_of_jax_is_too_coarse_for_a_verdict(jax):
    jnp = jax.numpy
    step = kick_and_drift(lambda x: jnp.asarray(x).astype(jnp.bfloat16), jnp.sin)
    assert check(step).kind == "undecided"
    with pytest.raises(symplint.InputError, match=r"dtype is bfloat16.*fewer bits"):
        check(step, dtype=jnp.bfloat16)
    s = 2.0 * jnp.pi * jnp.arange(64) / 64
    q, p = (x.astype(jnp.bfloat16) for x in (jnp.sin(s), jnp.cos(s)))
    integral = symplint.loop_integral(q, p)
    assert 1e-6 < abs(integral.value - np.pi) < 0.02
    assert symplint.measure((q, p), (p, -q)).kind == "undecided"


def test_arrays_of_jax_that_are_kept_stay_as_they_are(jax):
    kept = []

    def step(q, p, h):
        # JAX may refer to the memory of the array without a copy.
        q, p = jax.numpy.from_dlpack(q), jax.numpy.asarray(p)
        kept.append((q, np.array(q), p, np.array(p)))
        p = p - h * jax.numpy.sin(q)
        return q + h * p, p

    assert check(step).kind == "symplectic"
    assert all(np.array_equal(q, copy_q) and np.array_equal(p, copy_p) for q, copy_q, p, copy_p in kept)


def test_an_error_of_jax_is_the_cause(jax):
    leaked = []

    def step(q, p, h):
        jax.jit(leaked.append)(q)
        return leaked[-1], p

    with pytest.raises(symplint.StepError) as caught:
        check(step)
    assert isinstance(caught.value.__cause__, jax.errors.TracerArrayConversionError)


def test_torch_in_double_precision(torch):
    step = kick_and_drift(torch.from_numpy, torch.sin)

    def in_place(q, p, h):
        q, p = torch.from_numpy(q), torch.from_numpy(p)
        p -= h * torch.sin(q)
        q += h * p

    def with_pending_sign(q, p, h):
        q, p = step(q, p, h)
        return torch.complex(q, -p).real, torch.complex(q, -p).conj().imag

    forms = {
        "dlpack": kick_and_drift(torch.from_dlpack, torch.sin),
        "as_tensor": kick_and_drift(torch.as_tensor, torch.sin),
        "copies": kick_and_drift(torch.tensor, torch.sin),
        "in place": in_place,
        "pending sign": with_pending_sign,
        "one array for both": lambda q, p, h: torch.stack(step(q, p, h)),
    }
    expected = check(step)
    assert expected.kind == "symplectic" and expected.digits > 13
    for name, form in forms.items():
        assert check(form).to_dict()["evidence"] == expected.to_dict()["evidence"], name
    assert check(step, per_sample=True, budget=2000, loops=2).kind == "symplectic"


def test_tensors_that_require_a_gradient_are_detached(torch):
    torch.manual_seed(1)
    potential = torch.nn.Sequential(torch.nn.Linear(2, 8), torch.nn.Tanh(), torch.nn.Linear(8, 1)).double()

    def step(q, p, h):
        q = torch.as_tensor(q).requires_grad_()
        (force,) = torch.autograd.grad(potential(q).sum(), q, create_graph=True)
        p = torch.as_tensor(p) - 5.0 * h * force
        assert p.requires_grad
        return q + h * p, p

    report = check(step)
    assert report.kind == "symplectic" and report.digits > 12, str(report)


def test_torch_in_single_precision(torch):
    step = kick_and_drift(lambda x: torch.as_tensor(x).float(), torch.sin)
    for arguments in ({}, {"dtype": torch.float32}):
        report = check(step, **arguments)
        assert report.kind == "symplectic" and 6.5 < report.digits < 8.5, str(report)
    s = 2.0 * np.pi * torch.arange(64) / 64
    q, p = torch.sin(s), torch.cos(s)
    assert q.dtype == torch.float32
    assert abs(symplint.loop_integral(q, p).value - np.pi) < 1e-6
    angle = torch.tensor(0.3)
    turned = torch.cos(angle) * q + torch.sin(angle) * p, torch.cos(angle) * p - torch.sin(angle) * q
    report = symplint.measure((q, p), turned)
    assert report.kind == "undecided" or 6.0 < report.digits < 8.5


def test_bfloat16_of_torch_is_too_coarse_for_a_verdict(torch):
    step = kick_and_drift(lambda x: torch.as_tensor(x).to(torch.bfloat16), torch.sin)
    assert check(step).kind == "undecided"
    with pytest.raises(symplint.InputError, match=r"dtype is bfloat16.*fewer bits"):
        check(step, dtype=torch.bfloat16)


def test_arguments_may_be_tensors(torch):
    step = kick_and_drift(torch.as_tensor, torch.sin)
    q0, p0 = torch.tensor([1.0, 0.3], requires_grad=True), torch.tensor([0.5, -0.2])
    assert symplint.check(step, q0, p0, step_sizes=torch.tensor([0.5, 0.25]), loops=2).kind == "symplectic"


def test_a_tensor_without_numbers_is_the_cause(torch):
    def step(q, p, h):
        return torch.as_tensor(q).to("meta"), p

    with pytest.raises(symplint.StepError, match="meta"):
        check(step)
