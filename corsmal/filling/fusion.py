"""When to trust which sense: a gate between what networks of sound and of sight say, and calibrated probabilities.

Both senses give probabilities of type and level. The logarithms of the level's are mixed: the gate gives sight a share,
which follows from the kind of container that sight recognises. In a box nothing can be seen, and networks of sight are
not trained on levels in boxes: there sight has no share, and in what can be seen through one that is learned. Within
the training containers of the winners' folds the level was known better so (79.8 and 79.2, means of four choices of
networks, better in each) than with a share for each kind, which gave sight a tenth in boxes; with one that also
followed from what both senses say of the filling it was known no better. The type is sound's where there is sound:
there, too, a share of sight in it made it worse. A temperature, of each head with both senses or with one of them only,
makes the probabilities mean what they say. Gate and temperatures are learned from recordings of containers that the
networks had not seen, see ``train_fused``.
"""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Literal, NamedTuple, get_args

import torch
from torch import Tensor, nn
from torch.nn import functional

from corsmal.errors import ArgumentError, check_choice
from corsmal.filling.records import KINDS

Sense = Literal["sound", "sight"]
SENSES: tuple[Sense, ...] = ("sound", "sight")

GateForm = Literal["kinds", "visible"]
"""What sight's share follows from: ``kinds``: the probabilities of all kinds, each with a weight; ``visible``: that the
container is no box, times one number."""

CASES = (*SENSES, "both")
"""What there is of a recording: each case has a temperature of its own."""

PENALTY = 0.01
"""On the squared weights of the gate: it learns from hundreds of recordings, of few containers."""

STEPS_MAX = 200


class Answer(NamedTuple):
    """Logarithms of one sense's probabilities.

    Args:
        types: (B, 4) of the filling's types.
        levels: (B, 3) of its levels.
        kinds: (B, 3) of the container's kinds, which sight recognises.
    """

    types: Tensor
    levels: Tensor
    kinds: Tensor | None = None


class FusionGate(nn.Module):
    """The share of sight in the level, and the temperatures.

    Args:
        form: what the share follows from.

    Raises:
        ArgumentError: there is no such form.

    Example:
        >>> gate = FusionGate()
        >>> shares = [torch.rand(2, classes).log_softmax(dim=1) for classes in (4, 3, 3)]
        >>> sound, sight = Answer(*shares[:2]), Answer(*shares)
        >>> types, levels, share = gate(sound, sight)
        >>> types.shape, levels.shape, share.shape
        (torch.Size([2, 4]), torch.Size([2, 3]), torch.Size([2]))
    """

    input_mean: Tensor
    input_std: Tensor

    def __init__(self, form: GateForm = "visible") -> None:
        check_choice("form", form, get_args(GateForm))
        super().__init__()
        self.form = form
        if form == "visible":
            self.visible = nn.Parameter(torch.zeros(()))
        else:
            self.register_buffer("input_mean", torch.zeros(len(KINDS)))
            self.register_buffer("input_std", torch.ones(len(KINDS)))
            self.share = nn.Linear(len(KINDS), 1)
            nn.init.zeros_(self.share.weight)
            nn.init.zeros_(self.share.bias)
        self.log_temperatures = nn.Parameter(torch.zeros(len(CASES), 2))

    def forward(
        self, sound: Answer | None, sight: Answer | None, *, calibrated: bool = True
    ) -> tuple[Tensor, Tensor, Tensor]:
        """What is answered where there are both senses, or one of them; if not ``calibrated``, at temperatures of 1.

        Returns:
            (B, 4) and (B, 3) logits, and (B,) the share of sight in the level; 0 or 1 where a sense is missing.

        Raises:
            ArgumentError: both senses are missing, or sight does not say the container's kind.
        """
        if sound is not None and sight is not None:
            case = "both"
            share = self._share(_kinds(sight))  # (B, 1)
            types, levels = sound.types, torch.lerp(sound.levels, sight.levels, share)
            share = share[:, 0]
        elif (own := sound or sight) is not None:
            case = "sight" if sound is None else "sound"
            types, levels, _ = own
            share = torch.full((len(types),), float(sound is None))
        else:
            raise ArgumentError("sound or sight must be given, got neither")
        if not calibrated:
            return types, levels, share
        temperatures = self.log_temperatures[CASES.index(case)].exp()
        return types / temperatures[0], levels / temperatures[1], share

    def learn(self, sound: Answer, sight: Answer, *, types: Tensor, levels: Tensor) -> None:
        """Fit share and temperatures to recordings that the networks had not seen.

        Args:
            sound: what sound says about them.
            sight: what sight says.
            types: (B,) true types.
            levels: (B,) true levels.
        """
        given = ((sound, None), (None, sight), (sound, sight))

        def loss(*, calibrated: bool) -> Tensor:
            total = torch.zeros(()) if self.form == "visible" else PENALTY * self.share.weight.square().sum()
            for senses in given if calibrated else given[-1:]:
                found_types, found_levels, _ = self(*senses, calibrated=calibrated)
                total = total + functional.cross_entropy(found_types, types)
                total = total + functional.cross_entropy(found_levels, levels)
            return total

        if self.form == "visible":
            _minimise(partial(loss, calibrated=True), self.parameters())
            return
        inputs = _kinds(sight)
        self.input_mean.copy_(inputs.mean(dim=0))
        self.input_std.copy_(inputs.std(dim=0).clamp_min(1e-3))
        # one after the other: a low temperature would make up for a share that hardly differs
        _minimise(partial(loss, calibrated=False), self.share.parameters())
        _minimise(partial(loss, calibrated=True), [self.log_temperatures])

    def _share(self, kinds: Tensor) -> Tensor:
        """(B, 1) of sight in the level, from the (B, 3) probabilities of the container's kinds."""
        if self.form == "visible":
            return self.visible.sigmoid() * (1 - kinds[:, KINDS.index("box"), None])
        shares: Tensor = self.share((kinds - self.input_mean) / self.input_std).sigmoid()
        return shares


def _minimise(loss: Callable[[], Tensor], parameters: Iterable[nn.Parameter]) -> None:
    learned, least, best = list(parameters), float("inf"), None
    optimiser = torch.optim.LBFGS(learned, max_iter=STEPS_MAX, line_search_fn="strong_wolfe")

    def step() -> Tensor:
        nonlocal least, best
        optimiser.zero_grad()
        value = loss()
        value.backward()
        if value.item() < least:
            least, best = value.item(), [each.detach().clone() for each in learned]
        return value

    try:
        optimiser.step(step)
    except RuntimeError:  # where answers hardly differ the loss is flat, and a step may leave the range of numbers
        with torch.no_grad():
            for each, value in zip(learned, best or [], strict=False):
                each.copy_(value)


def _kinds(sight: Answer) -> Tensor:
    """(B, 3) probabilities of the container's kinds."""
    if sight.kinds is None:
        raise ArgumentError("sight must say the container's kind, got none")
    return sight.kinds.exp()
