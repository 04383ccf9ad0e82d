"""The network that weighs a container by its silhouette and its dimensions (paper 3.3 and Fig. 2)."""

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

import torch
from torch import Tensor, nn

from corsmal.errors import ArgumentError, check_choice
from corsmal.fields import UNLESS_DEFAULT
from corsmal.mass.axis import AXIS_RULES, AxisRule
from corsmal.mass.restoration import PADDING_PX
from corsmal.parameters import NetworkPresets

SIDE_PX = 112
"""Of the image that the network sees."""

BLOCKS = 4
STD_MIN = 1e-6

Resize = Literal["stretch", "letterbox"]
Interpolation = Literal["area", "linear"]
HiddenNorms = Literal["both", "first"]
Target = Literal["mass", "log mass"]

CHOICES: dict[str, tuple[str, ...]] = {
    "resize": get_args(Resize),
    "interpolation": get_args(Interpolation),
    "target": get_args(Target),
    "hidden_norms": get_args(HiddenNorms),
    "axis": AXIS_RULES,
}
"""The choices among forms, by the field of the config."""


@dataclass(frozen=True)
class MassConfig(NetworkPresets):
    """Sizes of the network and the form of what it is given.

    The paper gives no widths; the default ones are those of the authors' program.

    Args:
        channels: of the four convolutions.
        hidden: widths of the first two fully connected layers; the second is the length of u.
        resize: ``stretch`` the crop to a square (the paper), or ``letterbox`` it: scale it without changing its
            proportions and pad the shorter side.
        interpolation: of the resized image: a pixel is the ``area`` that the mask covers of it, or ``linear``, between
            the four nearest pixels (the authors' program).
        with_scale: give the network the mm that a pixel of its image spans, beside the three dimensions.
        target: what the last layer answers and the loss is taken of: the ``mass`` in grams, or its logarithm,
            ln(1 + mass), so that the error of a light container counts as much as that of a heavy one. With the
            logarithm the dimensions and the scale are given as logarithms too.
        axis: the rule that masks are restored by.
        padding_px: pixels that are added on each side of a mask's box before it is restored.
        standardise: whether the numbers, and the answer, are in units of the training set's deviations; else they are
            taken as they are, in mm and g (the authors' program).
        hidden_norms: whether a batch norm follows ``both`` connected layers before the last (the paper), or the
            ``first`` only (the authors' program).
        least_mass_g: least mass of the training set, which stands in for an answer of 0 g; None: it is not known, and
            0 g is no answer.

    Raises:
        ArgumentError: a width is not a positive whole number, the padding is negative, or there is no such choice.
    """

    channels: tuple[int, ...] = (32, 64, 64, 128)
    hidden: tuple[int, ...] = (64, 6)
    resize: Resize = "stretch"
    with_scale: bool = False
    target: Target = "mass"
    axis: AxisRule = "base"
    padding_px: int = PADDING_PX
    interpolation: Interpolation = field(default="area", metadata=UNLESS_DEFAULT)
    standardise: bool = field(default=True, metadata=UNLESS_DEFAULT)
    hidden_norms: HiddenNorms = field(default="both", metadata=UNLESS_DEFAULT)
    least_mass_g: float | None = field(default=None, metadata=UNLESS_DEFAULT)

    def __post_init__(self) -> None:
        widths = (*self.channels, *self.hidden)
        if len(self.channels) != BLOCKS or len(self.hidden) != 2:
            raise ArgumentError(f"config must have {BLOCKS} channels and 2 hidden widths, got {self}")
        if not all(type(width) is int and width > 0 for width in widths):
            raise ArgumentError(f"config must hold positive whole numbers as widths, got {self}")
        for name in ("with_scale", "standardise"):
            if type(getattr(self, name)) is not bool:
                raise ArgumentError(f"{name} must be true or false, got {getattr(self, name)!r}")
        if self.least_mass_g is not None and not 0 < self.least_mass_g < math.inf:
            raise ArgumentError(f"least_mass_g must be a positive number of grams, got {self.least_mass_g!r}")
        if type(self.padding_px) is not int or self.padding_px < 0:
            raise ArgumentError(f"padding_px must be a whole number of pixels, 0 or more, got {self.padding_px!r}")
        for name, choices in CHOICES.items():
            check_choice(name, getattr(self, name), choices)

    @property
    def numbers(self) -> int:
        """How many numbers the network is given beside the image."""
        return 4 if self.with_scale else 3

    @classmethod
    def paper(cls) -> "MassConfig":
        """The paper's, with the widths of the authors' program, as the paper is silent about them."""
        return cls()

    @classmethod
    def tuned(cls) -> "MassConfig":
        """Against the weaknesses that the paper names: distorted silhouettes, and light containers ignored.

        The convolutions are half as wide as the paper's, which measured no worse and is three times as quick.
        """
        return cls(channels=(16, 32, 32, 64), resize="letterbox", with_scale=True, target="log mass", axis="whole")

    @classmethod
    def released(cls) -> "MassConfig":
        """The network of the authors' program, where it does otherwise than the paper.

        How the program trains it is not known here, so it is trained like the others. Gradient descent as for the
        filling does not do: with dimensions in mm the last ReLU answers 0 after a few steps, whatever it is given.
        """
        return cls(
            axis="top",
            interpolation="linear",
            standardise=False,
            hidden_norms="first",
        )


class MassModel(nn.Module):
    """Four convolutional blocks, two fully connected layers to u, and a last one from u and the dimensions to grams."""

    numbers_mean: Tensor
    numbers_std: Tensor
    target_std: Tensor

    def __init__(self, config: MassConfig | None = None) -> None:
        super().__init__()
        self.config = config or MassConfig.paper()
        layers: list[nn.Module] = []
        width = 1
        for wider in self.config.channels:
            layers += [nn.Conv2d(width, wider, 3, padding=1), nn.ReLU(), nn.BatchNorm2d(wider), nn.MaxPool2d(2)]
            width = wider
        self.blocks = nn.Sequential(*layers)
        first, second = self.config.hidden
        cells = (SIDE_PX // 2**BLOCKS) ** 2
        self.connected = nn.Sequential(
            nn.Flatten(),
            *(nn.Linear(width * cells, first), nn.ReLU(), nn.BatchNorm1d(first)),
            *(nn.Linear(first, second), nn.ReLU()),
            *([nn.BatchNorm1d(second)] if self.config.hidden_norms == "both" else []),
        )
        self.last = nn.Linear(second + self.config.numbers, 1)
        self.register_buffer("numbers_mean", torch.zeros(self.config.numbers))
        self.register_buffer("numbers_std", torch.ones(self.config.numbers))
        self.register_buffer("target_std", torch.ones(()))

    def learn_statistics(self, numbers: Tensor, mass_g: Tensor) -> None:
        """Take over the training set's statistics, of the numbers (n, 3 or 4) for standardising and of the masses (n,).

        The last layer answers in units of the masses' spread: weights of the order of one, and a learning rate that
        suits them, then do for grams. Its bias begins at the mean, so that its ReLU lets gradients through.
        Where the config says not to standardise only the bias is set, so that the answers begin around the mean.
        """
        values, targets = self._scaled(numbers.float()), self.as_target(mass_g.float())
        if not self.config.standardise:
            first = values.mean(dim=0) @ self.last.weight[0, -self.config.numbers :].detach()
            nn.init.constant_(self.last.bias, float(targets.mean() - first))
            return
        self.numbers_mean.copy_(values.mean(dim=0))
        self.numbers_std.copy_(values.std(dim=0, correction=0).clamp_min(STD_MIN))
        self.target_std.copy_(targets.std(correction=0).clamp_min(STD_MIN))
        nn.init.constant_(self.last.bias, float(targets.mean() / self.target_std))

    def as_target(self, mass_g: Tensor) -> Tensor:
        """What ``answer`` should be for masses in grams."""
        return torch.log1p(mass_g) if self.config.target == "log mass" else mass_g

    def answer(self, images: Tensor, numbers: Tensor) -> Tensor:
        """Masses (B,) in the target's form: grams or ln(1 + g). Arguments as in ``forward``."""
        x = self.connected(self.blocks(images))  # (B, 1, 112, 112) -> (B, C, 7, 7) -> (B, u)
        standardised = (self._scaled(numbers) - self.numbers_mean) / self.numbers_std
        answers: Tensor = torch.relu(self.last(torch.cat([x, standardised], dim=1)))[:, 0]  # (B, u + 3) -> (B,)
        return answers * self.target_std

    def forward(self, images: Tensor, numbers: Tensor) -> Tensor:
        """Masses in grams.

        Args:
            images: (B, 1, 112, 112) restored masks, 0..1.
            numbers: (B, 3) top width, bottom width and height in mm; with ``with_scale`` (B, 4), the fourth the mm
                that a pixel of the image spans.

        Returns:
            (B,) grams, not negative.
        """
        answers = self.answer(images, numbers)
        return torch.expm1(answers) if self.config.target == "log mass" else answers

    def _scaled(self, numbers: Tensor) -> Tensor:
        return torch.log(numbers) if self.config.target == "log mass" else numbers
