"""TensorFlow's RMSprop: steps computed by hand, and how it differs from torch's."""

import copy

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")

from npss_baselines.training.rmsprop import RMSpropTF  # noqa: E402

pytestmark = pytest.mark.numeric


def gradients(n, shape=(3, 2), seed=0):
    return np.random.default_rng(seed).normal(size=(n, *shape))


def by_hand(start, gradients, rates, decay=0.9, momentum=0.95, epsilon=1e-10):
    """Scalar by scalar, from the definition."""
    result = start.copy()
    for index in np.ndindex(start.shape):
        square, moment = 1.0, 0.0
        for gradient, rate in zip(gradients, rates, strict=True):
            square = decay * square + (1 - decay) * gradient[index] ** 2
            moment = momentum * moment + rate * gradient[index] / (square + epsilon) ** 0.5
            result[index] -= moment
    return result


def descend(optimizer, weight, gradients, rates):
    for gradient, rate in zip(gradients, rates, strict=True):
        for group in optimizer.param_groups:
            group["lr"] = rate
        weight.grad = torch.tensor(gradient)
        optimizer.step()


@pytest.mark.parametrize(
    "settings", [{}, {"decay": 0.5, "momentum": 0.0}, {"epsilon": 0.1}, {"decay": 0.0, "momentum": 0.3}]
)
def test_steps_are_those_computed_by_hand(settings):
    start, steps, rates = np.ones((3, 2)), gradients(20), np.linspace(0.1, 0.01, 20)
    weight = torch.nn.Parameter(torch.tensor(start))
    descend(RMSpropTF([weight], lr=1.0, **settings), weight, steps, rates)
    np.testing.assert_allclose(weight.detach().numpy(), by_hand(start, steps, rates, **settings), rtol=1e-12)


def test_parameters_and_groups_are_independent():
    start, steps, rates = np.ones((3, 2)), gradients(5), [0.1] * 5
    first, second, idle = (torch.nn.Parameter(torch.tensor(start)) for _ in range(3))
    optimizer = RMSpropTF([{"params": [first, idle]}, {"params": [second], "lr": 0.5, "momentum": 0.0}], lr=0.1)
    for gradient in steps:
        first.grad, second.grad = torch.tensor(gradient), torch.tensor(2 * gradient)
        optimizer.step()
    np.testing.assert_allclose(first.detach().numpy(), by_hand(start, steps, rates), rtol=1e-12)
    np.testing.assert_allclose(second.detach().numpy(), by_hand(start, 2 * steps, [0.5] * 5, momentum=0.0), rtol=1e-12)
    assert (idle == 1).all()
    assert idle not in optimizer.state
    optimizer.zero_grad()
    optimizer.step()  # without any gradient, nothing changes, not even the moment
    np.testing.assert_allclose(first.detach().numpy(), by_hand(start, steps, rates), rtol=1e-12)


def test_it_is_not_the_rmsprop_of_torch():
    """torch's first step is the rate over sqrt(1 - decay) for every gradient; this one is proportional to it."""
    moved = {}
    for optimizer in (RMSpropTF, torch.optim.RMSprop):
        weight = torch.nn.Parameter(torch.zeros(2, dtype=torch.float64))
        settings = {} if optimizer is RMSpropTF else {"alpha": 0.9, "eps": 1e-10}
        weight.grad = torch.tensor([1e-3, 1e-2], dtype=torch.float64)
        optimizer([weight], lr=0.1, momentum=0.95, **settings).step()
        moved[optimizer] = -weight.detach().numpy()
    np.testing.assert_allclose(moved[RMSpropTF], 0.1 * np.array([1e-3, 1e-2]) / np.sqrt(0.9), rtol=1e-4)
    np.testing.assert_allclose(moved[torch.optim.RMSprop], 0.1 / np.sqrt(0.1), rtol=1e-6)


def test_a_lower_rate_does_not_slow_the_steps_already_taken():
    weight = torch.nn.Parameter(torch.zeros(1, dtype=torch.float64))
    optimizer = RMSpropTF([weight], lr=0.1)
    descend(optimizer, weight, np.ones((1, 1)), [0.1])
    first = -weight.item()
    descend(optimizer, weight, np.zeros((1, 1)), [1e-12])
    assert -weight.item() == pytest.approx(1.95 * first)


def test_it_continues_from_a_stored_state():
    steps, rates = gradients(10), [0.1] * 10
    weight = torch.nn.Parameter(torch.ones(3, 2, dtype=torch.float64))
    optimizer = RMSpropTF([weight], lr=0.1)
    descend(optimizer, weight, steps[:4], rates[:4])
    again = torch.nn.Parameter(weight.detach().clone())
    restored = RMSpropTF([again], lr=0.7, momentum=0.1)
    restored.load_state_dict(copy.deepcopy(optimizer.state_dict()))
    for each, values in ((optimizer, weight), (restored, again)):
        descend(each, values, steps[4:], rates[4:])
    assert torch.equal(weight, again)
    np.testing.assert_allclose(weight.detach().numpy(), by_hand(np.ones((3, 2)), steps, rates), rtol=1e-12)


def test_a_closure_computes_the_loss():
    weight = torch.nn.Parameter(torch.tensor([2.0]))
    optimizer = RMSpropTF([weight], lr=0.1)

    def closure():
        optimizer.zero_grad()
        loss = (weight**2).sum()
        loss.backward()
        return loss

    assert optimizer.step(closure).item() == 4.0
    assert optimizer.step() is None
    assert weight.item() < 2


def test_it_finds_the_minimum_of_a_quadratic():
    weight = torch.nn.Parameter(torch.tensor([3.0, -2.0]))
    optimizer = RMSpropTF([weight], lr=0.01, momentum=0.5)
    for _ in range(500):
        optimizer.zero_grad()
        ((weight - torch.tensor([1.0, 4.0])) ** 2).sum().backward()
        optimizer.step()
    assert torch.allclose(weight, torch.tensor([1.0, 4.0]), rtol=0, atol=0.05)


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"lr": 0.0}, ValueError, "lr: "),
        ({"lr": "fast"}, TypeError, "lr: "),
        ({"lr": 0.1, "decay": 1.0}, ValueError, "decay: "),
        ({"lr": 0.1, "decay": float("nan")}, ValueError, "decay: "),
        ({"lr": 0.1, "momentum": -0.1}, ValueError, "momentum: "),
        ({"lr": 0.1, "momentum": None}, TypeError, "momentum: "),
        ({"lr": 0.1, "epsilon": 0.0}, ValueError, "epsilon: "),
    ],
)
def test_bad_numbers_are_refused(settings, error, message):
    with pytest.raises(error, match=message):
        RMSpropTF([torch.nn.Parameter(torch.ones(1))], **settings)
