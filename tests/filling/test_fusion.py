import math

import pytest
import torch

from corsmal.errors import ArgumentError
from corsmal.filling.fusion import Answer, FusionGate, _minimise


def says(classes, wanted, sure):
    """(n, classes) logarithms: the wanted class has probability ``sure``, the others share the rest."""
    shares = torch.full((len(wanted), classes), (1 - sure) / (classes - 1))
    shares[torch.arange(len(wanted)), wanted] = sure
    return shares.log()


def made(count=120):
    """Sound knows the type. Whose word on the level is right depends on the container's kind; both are equally sure."""
    rng = torch.Generator().manual_seed(0)
    types, levels = torch.randint(4, (count,), generator=rng), torch.randint(3, (count,), generator=rng)
    right, wrong = says(3, levels, 0.8), says(3, (levels + 1) % 3, 0.8)
    kinds = torch.randint(3, (count,), generator=rng)
    is_heard = kinds == 2
    heard, seen = torch.where(is_heard[:, None], right, wrong), torch.where(is_heard[:, None], wrong, right)
    sight = Answer(says(4, (types + 1) % 4, 0.6), seen, says(3, kinds, 0.9))
    return Answer(says(4, types, 0.9), heard), sight, types, levels, is_heard


def test_one_sense_is_passed_on():
    sound, sight, *_ = made(6)
    gate = FusionGate()
    types, levels, share = gate(sound, None)
    assert torch.equal(types, sound[0])
    assert torch.equal(levels, sound[1])
    assert not share.any()
    types, _, share = gate(None, sight)
    assert torch.equal(types, sight[0])
    assert (share == 1).all()


def test_untrained_gate_takes_the_mean_of_the_levels_logarithms():
    sound, sight, *_ = made(6)
    types, levels, share = FusionGate("kinds")(sound, sight)
    assert torch.equal(types, sound[0])
    assert torch.allclose(levels, (sound[1] + sight[1]) / 2)
    assert (share == 0.5).all()


def test_sight_has_no_share_in_a_box():
    sound, sight, *_ = made(3)
    sure = torch.tensor([[1.0, 0.0, 0.0], [0.25, 0.25, 0.5], [0.0, 0.0, 1.0]])
    gate = FusionGate("visible")
    with torch.no_grad():
        gate.visible.fill_(math.log(3))  # its sigmoid is 3/4
        _, levels, share = gate(sound, sight._replace(kinds=sure.log()))
    assert share.tolist() == pytest.approx([0.75, 0.375, 0])
    assert torch.allclose(levels[0], 0.25 * sound.levels[0] + 0.75 * sight.levels[0])
    assert torch.equal(levels[2], sound.levels[2])


@pytest.mark.parametrize("form", ["kinds", "visible"])
def test_gate_learns_whom_to_trust_when(form):
    sound, sight, types, levels, is_heard = made()
    gate = FusionGate(form)
    gate.learn(sound, sight, types=types, levels=levels)
    with torch.no_grad():
        found_types, found_levels, share = gate(sound, sight)
    assert torch.equal(found_types.argmax(dim=1), types)
    assert torch.equal(found_levels.argmax(dim=1), levels)
    assert share[is_heard].max() < 0.4
    assert share[~is_heard].min() > 0.6


def test_temperature_makes_probabilities_true():
    # sight alone says 0.8 and is right in 3 of 4
    levels = torch.tensor([0, 1, 2, 0] * 25)
    said = torch.tensor([0, 1, 2, 1] * 25)
    types = torch.arange(100) % 4
    sure = Answer(says(4, types, 0.9), says(3, said, 0.95), says(3, said, 0.9))
    gate = FusionGate()
    gate.learn(sure, sure, types=types, levels=levels)
    with torch.no_grad():
        shares = gate(None, sure)[1].softmax(dim=1)
    assert shares.max(dim=1).values.mean() == pytest.approx(0.75, abs=0.01)
    with torch.no_grad():
        plain = gate(None, sure, calibrated=False)[1].softmax(dim=1)
    assert plain.max(dim=1).values.mean() == pytest.approx(0.95, abs=1e-4)


def test_nothing_at_all_and_sight_that_says_no_kind_are_refused():
    sound, sight, *_ = made(6)
    with pytest.raises(ArgumentError, match="neither"):
        FusionGate()(None, None)
    with pytest.raises(ArgumentError, match="must say the container's kind"):
        FusionGate()(sound, sight._replace(kinds=None))
    with pytest.raises(ArgumentError, match="form"):
        FusionGate("sound")


def test_a_search_that_leaves_the_range_of_numbers_keeps_the_best_that_it_saw():
    parameter, seen = torch.nn.Parameter(torch.zeros(1)), []

    def loss():
        if len(seen) == 3:
            raise RuntimeError("value cannot be converted to type float without overflow")
        value = ((parameter - 3) ** 4).sum()
        seen.append((value.item(), parameter.item()))
        return value

    _minimise(loss, [parameter])
    assert parameter.item() == min(seen)[1]
