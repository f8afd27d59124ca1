"""Two networks as time steps in torch: a residual one and a SympNet, with random weights, untrained (pip install torch).

A residual network z + h f(z) is no canonical map, however well it is trained. A SympNet is a product of shears, each of them the
step of a Hamiltonian of p or of q alone: symplectic whatever its weights are. P. Jin et al., "SympNets: Intrinsic structure-preserving
symplectic networks for identifying Hamiltonian systems" (2020), arXiv:2001.03750: this one is of gradient modules.
"""

import symplint
import torch

DOF, WIDTH, LAYERS = 2, 16, 6


def random(*shape):
    return torch.randn(*shape, dtype=torch.float64, generator=GENERATOR)


GENERATOR = torch.Generator().manual_seed(1)
RESIDUAL = [(random(2 * DOF, WIDTH), random(WIDTH), 0.2 * random(WIDTH, 2 * DOF)) for _ in range(LAYERS)]
SHEARS = [(random(DOF, WIDTH), random(WIDTH), 0.2 * random(WIDTH)) for _ in range(LAYERS)]


def residual_network(q, p, h):
    z = torch.hstack([torch.as_tensor(q), torch.as_tensor(p)])
    for inward, bias, outward in RESIDUAL:
        z = z + h * torch.tanh(z @ inward + bias) @ outward
    return z[:, :DOF], z[:, DOF:]


def sympnet(q, p, h):
    q, p = torch.as_tensor(q), torch.as_tensor(p)
    for layer, (weights, bias, scale) in enumerate(SHEARS):
        # The gradient of the sum of scale * log(cosh(weights' x + bias)).
        if layer % 2 == 0:
            p = p + h * (scale * torch.tanh(q @ weights + bias)) @ weights.T
        else:
            q = q + h * (scale * torch.tanh(p @ weights + bias)) @ weights.T
    return q, p


def report(network):
    return symplint.check(network, [0.3, -0.2], [0.1, 0.4], step_sizes=[0.5, 0.25, 0.125], jacobian="auto")


if __name__ == "__main__":
    for network in (sympnet, residual_network):
        found = report(network)
        print(f"{network.__name__}: {found.headline}\n  {found.summary}")
