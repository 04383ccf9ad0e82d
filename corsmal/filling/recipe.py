"""How the filling network is trained: every number of it, with the paper's preset, its authors' and a tuned one."""

import math
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

from corsmal.errors import ArgumentError, check_choice
from corsmal.fields import UNLESS_DEFAULT
from corsmal.filling.config import AnyConfig, FillingConfig, FrontEnd, PooledConfig, check_together
from corsmal.filling.samples import Task
from corsmal.parameters import NetworkPresets

Passes = Literal["alternating", "joint"]
Keep = Literal["best", "last"]
Optimiser = Literal["adamw", "sgd"]
Schedule = Literal["constant", "cosine", "steps"]
CHOICES = {"passes": Passes, "keep": Keep, "optimiser": Optimiser, "schedule": Schedule}


@dataclass(frozen=True)
class FillingTraining(NetworkPresets):
    """How the filling network is trained.

    Args:
        networks: one config per network; each starts from weights of its own, and their probabilities are averaged.
        passes: ``alternating``: an epoch is a pass for the type on random crops with the level head fixed, then one
            for the level on whole recordings with the type head fixed (paper 2 and 4.2); ``joint``: one pass on whole
            recordings, the two losses summed.
        keep: the weights of the ``best`` epoch by rule (1) on validation recordings, see ``train_filling``, or those of
            the ``last``.
        retrain: whether rule (1) chooses only the number of epochs, with which the network is then trained once more on
            all recordings, see ``train_filling``; not in the paper.
        epochs: how many.
        batch: recordings per step.
        rate: learning rate in the first epoch. The paper names neither batch, optimiser nor rate.
        schedule: ``constant``: it stays; ``cosine``: it is lowered to zero over the epochs by half a cosine; ``steps``:
            to a tenth after half of the epochs, and again after three quarters.
        weight_decay: of the optimiser.
        optimiser: AdamW, or stochastic gradient descent with ``momentum``.
        momentum: of ``sgd``, 0 to below 1.

    Raises:
        ArgumentError: a number is out of range, or the networks do not belong together, or to the passes.
    """

    networks: tuple[AnyConfig, ...] = (FillingConfig.paper(),)
    passes: Passes = "alternating"
    keep: Keep = "best"
    retrain: bool = False
    epochs: int = 150
    batch: int = 16
    rate: float = 5e-4
    schedule: Schedule = "constant"
    weight_decay: float = 0.01
    optimiser: Optimiser = field(default="adamw", metadata=UNLESS_DEFAULT)
    momentum: float = field(default=0.0, metadata=UNLESS_DEFAULT)

    def __post_init__(self) -> None:
        check_together(self.networks)
        for name, choices in CHOICES.items():
            check_choice(name, getattr(self, name), get_args(choices))
        if self.passes == "alternating" and isinstance(self.networks[0], PooledConfig):
            raise ArgumentError("networks on changes over time learn from whole recordings: passes must be 'joint'")
        for name in ("epochs", "batch"):
            if type(getattr(self, name)) is not int or getattr(self, name) < 1:
                raise ArgumentError(f"{name} must be a positive whole number, got {getattr(self, name)!r}")
        if not (0 < self.rate < math.inf and 0 <= self.weight_decay < math.inf):
            raise ArgumentError(f"rate must be positive and weight_decay not negative, got {self}")
        if not 0 <= self.momentum < 1:
            raise ArgumentError(f"momentum must be 0 or more and less than 1, got {self.momentum}")

    @property
    def front_end(self) -> FrontEnd:
        """How sound becomes the features that the networks are trained on."""
        return self.networks[0].front_end

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The passes of an epoch, in order."""
        return ("type", "level") if self.passes == "alternating" else ("both",)

    @classmethod
    def paper(cls) -> "FillingTraining":
        """The paper's: alternating passes, 150 epochs, the epoch chosen by rule (1).

        The rate was chosen in each of the winners' folds on its training containers.
        """
        return cls()

    @classmethod
    def tuned(cls) -> "FillingTraining":
        """Eight networks that know the duration, half of them on standardised features; joint loss, few epochs.

        A rate that is lowered, and 30 epochs, were chosen in each of the winners' folds on its training containers.
        """
        networks = tuple(FillingConfig.tuned(standardise=index % 2 == 1) for index in range(8))
        return cls(networks, passes="joint", keep="last", epochs=30, rate=1e-3, schedule="cosine")

    @classmethod
    def released(cls) -> "FillingTraining":
        """As the authors' program: its network and optimiser, one recording at a time, 100 epochs.

        When its rate is lowered is not known here; ``steps`` is a choice.
        """
        return cls(
            (FillingConfig.released(),),
            epochs=100,
            batch=1,
            rate=1e-3,
            schedule="steps",
            weight_decay=0.0,
            optimiser="sgd",
            momentum=0.5,
        )

    def fitted_to(self, *, channels: int, features: int) -> "FillingTraining":
        """The same for features of another form."""
        sized = (replace(config, channels=channels, features=features) for config in self.networks)
        return replace(self, networks=tuple(sized))
