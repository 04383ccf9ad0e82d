"""A small Mask R-CNN for the demo: few parameters, quick on a CPU, its numbers in one config."""

import math
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torchvision.models.detection import MaskRCNN
from torchvision.models.detection.anchor_utils import AnchorGenerator
from torchvision.models.detection.faster_rcnn import FastRCNNPredictor, TwoMLPHead
from torchvision.models.detection.mask_rcnn import MaskRCNNHeads, MaskRCNNPredictor
from torchvision.ops import FeaturePyramidNetwork, MultiScaleRoIAlign
from torchvision.ops.feature_pyramid_network import LastLevelMaxPool

from corsmal.detection.torch_detector import TorchDetector
from corsmal.errors import ArgumentError
from corsmal.weights import file_sha256, read_network, save_network

LEVELS = 4


@dataclass(frozen=True)
class SmallMaskRCNNConfig:
    """Sizes of the network. Images are scaled to fit ``image_side_min`` × ``image_side_max`` pixels.

    Args:
        widths: channels of the four stages, at strides 4, 8, 16 and 32.
        blocks: residual blocks of each stage.
        pyramid: channels of the feature pyramid.
        box_head: width of the box head's two layers.
        mask_layers: channels of the mask head's layers.
        mask_side: pixels of the side of a predicted mask, twice that of its features.
        mask_scale: boxes of this side and larger take their mask's features from stride 16, half of it from stride 8.
        anchor_sizes: sides of the anchors, per level of the proposals (strides 8, 16, 32 and 64), pixels.
        anchor_ratios: height by width.
        labels: COCO numbers of the classes, in the order of the network's outputs (after the background).
        unreported: further classes, of things that look like containers and are never reported.
        image_side_min: shorter side, pixels.
        image_side_max: longer side, pixels.

    Raises:
        ArgumentError: a size is not a positive whole number, or there is another number of levels than four.
    """

    widths: tuple[int, ...] = (32, 64, 96, 128)
    blocks: tuple[int, ...] = (1, 2, 2, 1)
    pyramid: int = 64
    box_head: int = 256
    mask_layers: tuple[int, ...] = (64, 64, 64)
    mask_side: int = 28
    mask_scale: int = 224
    anchor_sizes: tuple[tuple[int, ...], ...] = ((20, 32), (48, 72), (104, 150), (200, 260))
    anchor_ratios: tuple[float, ...] = (1.0, 1.6, 2.6)
    labels: tuple[int, ...] = (44, 46, 47, 84, 86)
    unreported: int = 0
    image_side_min: int = 360
    image_side_max: int = 640

    def __post_init__(self) -> None:
        sizes = (self.pyramid, self.box_head, self.mask_side, self.mask_scale, self.image_side_min, self.image_side_max)
        whole = (*self.widths, *self.blocks, *self.mask_layers, *self.labels, *sizes)
        sides = (*self.anchor_ratios, *chain.from_iterable(self.anchor_sizes))
        if not all(type(number) is int and number > 0 for number in whole) or self.mask_side % 2:
            raise ArgumentError(f"config must hold positive whole numbers and an even mask_side, got {self}")
        if not all(isinstance(number, int | float) and 0 < number < math.inf for number in sides):
            raise ArgumentError(f"anchor_sizes and anchor_ratios must be positive numbers, got {self}")
        if type(self.unreported) is not int or self.unreported < 0:
            raise ArgumentError(f"unreported must be a whole number, 0 or more, got {self.unreported!r}")
        if not len(self.widths) == len(self.blocks) == len(self.anchor_sizes) == LEVELS:
            raise ArgumentError(f"widths, blocks and anchor_sizes must be given for {LEVELS} levels, got {self}")
        if not (self.mask_layers and self.labels and self.anchor_ratios and all(self.anchor_sizes)):
            raise ArgumentError(f"config must hold no empty list, got {self}")
        if len(set(map(len, self.anchor_sizes))) > 1:
            raise ArgumentError(f"anchor_sizes must be as many at each level, got {self.anchor_sizes}")


class Block(nn.Module):
    """Two 3×3 convolutions with batch norm and a shortcut."""

    def __init__(self, width_in: int, width_out: int, *, stride: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(width_in, width_out, 3, stride, 1, bias=False),
            nn.BatchNorm2d(width_out),
            nn.ReLU(inplace=True),
            nn.Conv2d(width_out, width_out, 3, 1, 1, bias=False),
            nn.BatchNorm2d(width_out),
        )
        same = stride == 1 and width_in == width_out
        self.shortcut = (
            nn.Identity()
            if same
            else nn.Sequential(nn.Conv2d(width_in, width_out, 1, stride, bias=False), nn.BatchNorm2d(width_out))
        )

    def forward(self, x: Tensor) -> Tensor:
        """(B, C, H, W) to (B, C', H / stride, W / stride)."""
        return torch.relu(self.layers(x) + self.shortcut(x))


class Pyramid(nn.Module):
    """A small residual network with a feature pyramid: levels ``0`` to ``3`` at strides 4 to 32, ``pool`` at 64."""

    def __init__(self, config: SmallMaskRCNNConfig) -> None:
        super().__init__()
        self.out_channels = config.pyramid
        width = config.widths[0]
        self.stem = nn.Sequential(
            nn.Conv2d(3, width, 3, 2, 1, bias=False),
            nn.BatchNorm2d(width),
            nn.ReLU(inplace=True),
            nn.Conv2d(width, width, 3, 2, 1, bias=False),
            nn.BatchNorm2d(width),
            nn.ReLU(inplace=True),
        )
        self.stages = nn.ModuleList()
        for index, (wider, count) in enumerate(zip(config.widths, config.blocks, strict=True)):
            first = Block(width, wider, stride=1 if index == 0 else 2)
            self.stages.append(nn.Sequential(first, *(Block(wider, wider, stride=1) for _ in range(count - 1))))
            width = wider
        self.pyramid = FeaturePyramidNetwork(list(config.widths), config.pyramid, extra_blocks=LastLevelMaxPool())

    def forward(self, x: Tensor) -> dict[str, Tensor]:
        """(B, 3, H, W) to the levels, (B, pyramid, H / stride, W / stride) each."""
        x = self.stem(x)
        levels: OrderedDict[str, Tensor] = OrderedDict()
        for index, stage in enumerate(self.stages):
            x = stage(x)
            levels[str(index)] = x
        features: dict[str, Tensor] = self.pyramid(levels)
        return features


class CoarseProposals(nn.Module):
    """Proposals from all levels but the finest: containers are larger, and most of the time would go there."""

    def __init__(self, proposals: nn.Module) -> None:
        super().__init__()
        self.proposals = proposals

    def forward(
        self, images: Any, features: Mapping[str, Tensor], targets: list[dict[str, Tensor]] | None = None
    ) -> tuple[list[Tensor], dict[str, Tensor]]:
        """As torchvision's ``RegionProposalNetwork``."""
        coarse = OrderedDict((name, level) for name, level in features.items() if name != "0")
        proposals: tuple[list[Tensor], dict[str, Tensor]] = self.proposals(images, coarse, targets)
        return proposals


class SmallMaskRCNN(MaskRCNN):
    """The network, with random weights; detections with a score below ``score_min`` are not returned."""

    rpn: nn.Module

    def __init__(self, config: SmallMaskRCNNConfig, *, score_min: float = 0.05) -> None:
        classes = len(config.labels) + config.unreported + 1
        levels, pooled = ["0", "1", "2", "3"], config.mask_side // 2
        super().__init__(
            Pyramid(config),
            num_classes=None,
            min_size=config.image_side_min,
            max_size=config.image_side_max,
            image_mean=[0.5, 0.5, 0.5],
            image_std=[0.25, 0.25, 0.25],
            rpn_anchor_generator=AnchorGenerator(config.anchor_sizes, (config.anchor_ratios,) * LEVELS),
            rpn_pre_nms_top_n_train=400,
            rpn_pre_nms_top_n_test=200,
            rpn_post_nms_top_n_train=200,
            rpn_post_nms_top_n_test=60,
            rpn_batch_size_per_image=128,
            box_roi_pool=MultiScaleRoIAlign(levels, output_size=7, sampling_ratio=2, canonical_scale=112),
            box_head=TwoMLPHead(config.pyramid * 49, config.box_head),
            box_predictor=FastRCNNPredictor(config.box_head, classes),
            box_batch_size_per_image=32,
            box_score_thresh=score_min,
            box_detections_per_img=10,
            mask_roi_pool=MultiScaleRoIAlign(levels, pooled, sampling_ratio=2, canonical_scale=config.mask_scale),
            mask_head=MaskRCNNHeads(config.pyramid, config.mask_layers, 1),
            mask_predictor=MaskRCNNPredictor(config.mask_layers[-1], config.mask_layers[-1], classes),
        )
        self.rpn = CoarseProposals(self.rpn)
        self.config = config


class SmallDetector(TorchDetector):
    """The demo's detector: a ``SmallMaskRCNN`` with weights from a file; other arguments as in ``MaskRCNNDetector``.

    Raises:
        FileError: the file is absent, broken, or of another network.
    """

    def __init__(self, weights: Path, *, device: str | None = None, score_min: float = 0.05) -> None:
        network = read_detector(weights, score_min=score_min)
        super().__init__(
            network.to(memory_format=torch.channels_last),
            name=f"small Mask R-CNN, weights {weights.name}",
            digest=f"small Mask R-CNN {file_sha256(weights)}, score {score_min!r}",
            device=device,
            labels=(*network.config.labels, *(0,) * network.config.unreported),
        )


def save_detector(path: Path, network: SmallMaskRCNN, *, training: Mapping[str, Any] | None = None) -> None:
    """Write the weights in half precision with the config and what the network was trained on.

    Raises:
        FileError: the file cannot be written.
    """
    save_network(path, network, kind="detector", config=asdict(network.config), training=training, half=True)


def read_detector(path: Path, *, score_min: float = 0.05) -> SmallMaskRCNN:
    """The network of a file that ``save_detector`` wrote.

    Raises:
        FileError: the file is absent, broken, or of another network.
    """

    def build(config: dict[str, Any]) -> SmallMaskRCNN:
        return SmallMaskRCNN(SmallMaskRCNNConfig(**config), score_min=score_min)

    return read_network(path, "detector", build)
