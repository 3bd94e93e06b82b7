"""The network as a PyTorch module. Importing this needs PyTorch; nothing else here does."""

from __future__ import annotations

import os
from typing import Any, NamedTuple, Optional, Union

import torch
from torch import nn
from torch.nn import functional

from . import _native
from .weights import Canary, Weights, load_weights

_ACTIONS = 6
_OTHERS = 3
_OWN_CELL_PLANE = 10
_NORM_EPSILON = 1e-5
_BOARD_SIZE = 11


class Output(NamedTuple):
    """Answers for a batch of positions, from the viewer's view."""

    policy_logits: torch.Tensor  # [n, 6]
    value: torch.Tensor  # [n], -1..1
    others_logits: Optional[torch.Tensor]  # [n, 3, 6], of viewer + 1, + 2, + 3; 0 of the unseen


class Block(nn.Module):
    """One block of the tower (BlockDescription in common/model/network_description.h)."""

    def __init__(self, inputs: int, description: dict[str, Any], slope: float) -> None:
        super().__init__()
        channels, expanded = description["channels"], description["expanded"]
        stride = description["stride"]
        self.slope = slope
        self.residual = description["kind"] == "residual"
        self.skip = stride == 1 and inputs == channels
        if self.residual:
            self.conv1 = _convolution(inputs, channels, 3, stride)
            self.conv2 = _convolution(channels, channels, 3)
        else:
            self.conv1 = _convolution(inputs, expanded, 1)
            self.conv2 = _convolution(expanded, expanded, 3, stride, groups=expanded)
            self.conv3 = _convolution(expanded, channels, 1)
            self.bn3 = _norm(channels)
        self.bn1 = _norm(self.conv1.out_channels)
        self.bn2 = _norm(self.conv2.out_channels)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """[n, inputs, side, side] to [n, channels, side, side]."""
        y = functional.leaky_relu(self.bn1(self.conv1(x)), self.slope)
        y = self.bn2(self.conv2(y))
        if not self.residual:
            y = self.bn3(self.conv3(functional.leaky_relu(y, self.slope)))
        if self.skip:
            y = y + x
        return functional.leaky_relu(y, self.slope) if self.residual else y


class Network(nn.Module):
    """The module of a description; its parameters and buffers have the names of our arrays.

    ``Network.load(path)`` reads a file. ``to_weights`` gives what ``save_weights`` writes.
    """

    def __init__(self, description: dict[str, Any]) -> None:
        """A network with PyTorch's random weights; ValueError unless the description is valid."""
        super().__init__()
        _native.check_description(description)
        self.description = description
        stem, side = description["stem_channels"], _BOARD_SIZE
        self.stem = _branch(description["planes"], stem, 3, description["stem_stride"])
        blocks, channels = [], stem
        for block in description["blocks"]:
            blocks.append(Block(channels, block, description["leaky_slope"]))
            channels = block["channels"]
        self.blocks = nn.Sequential(*blocks)
        for stride in [description["stem_stride"], *(b["stride"] for b in description["blocks"])]:
            side = (side + stride - 1) // stride
        self._make_heads(channels, side * side)

    def _make_heads(self, channels: int, cells: int) -> None:
        given = self.description
        self.value = _branch(channels, given["value_channels"], 1)
        self.value.fc1 = nn.Linear(given["value_channels"] * cells, given["value_hidden"])
        self.value.fc2 = nn.Linear(given["value_hidden"], 1)
        self.policy = _branch(channels, given["policy_channels"], 1)
        self.policy.fc = nn.Linear(given["policy_channels"] * cells, _ACTIONS)
        if given["own_hidden"] > 0:
            self.own = nn.Module()
            self.own.fc = nn.Linear(channels, given["own_hidden"])
            self.own.value = nn.Linear(given["own_hidden"], given["value_hidden"], bias=False)
            self.own.policy = nn.Linear(given["own_hidden"], _ACTIONS, bias=False)
        if given["others_hidden"] > 0:
            self.others = nn.Module()
            self.others.fc = nn.Linear(channels, given["others_hidden"])
            self.others.policy = nn.Linear(given["others_hidden"], _ACTIONS)

    @classmethod
    def from_weights(cls, weights: Weights) -> Network:
        """The network of these weights, in evaluation mode."""
        _native.check_weights(weights.description, weights.arrays)
        network = cls(weights.description)
        state = {name: torch.from_numpy(array.copy()) for name, array in weights.arrays.items()}
        network.load_state_dict(state, strict=False)  # our files have no num_batches_tracked
        return network.eval()

    @classmethod
    def load(cls, name: Union[str, os.PathLike]) -> Network:
        """The network of a .weights file, in evaluation mode."""
        return cls.from_weights(load_weights(name))

    def to_weights(self, version: int, canary: Canary) -> Weights:
        """Its weights; the canary's positions get the answers that it gives now."""
        arrays = {name: value.detach().cpu().float().numpy().copy()
                  for name, value in self.state_dict().items()
                  if not name.endswith("num_batches_tracked")}
        if len(canary) > 0:
            canary = canary.answered(*self.answers(canary))
        return Weights(version, self.description, arrays, canary)

    def answers(self, canary: Canary) -> tuple[Any, Any, Any]:
        """(policy, value, others) for a canary's positions, as it holds them."""
        was_training = self.training
        self.eval()
        with torch.no_grad():
            planes = torch.from_numpy(canary.planes)
            output = self(planes.to(next(self.parameters()).device))
            others = torch.zeros(len(planes), _OTHERS, _ACTIONS)
            if output.others_logits is not None:
                seen = planes[:, _OWN_CELL_PLANE + 1:_OWN_CELL_PLANE + 4].sum((2, 3))
                others = output.others_logits.softmax(-1).cpu() * seen[:, :, None]
        self.train(was_training)
        return (output.policy_logits.softmax(-1).cpu().numpy(), output.value.cpu().numpy(),
                (others * 255 + 0.5).to(torch.uint8).numpy())

    def canary_difference(self, canary: Canary) -> tuple[float, float]:
        """The largest differences in policy probability and in value from the canary's answers."""
        policy, value, others = self.answers(canary)
        foretold = abs(others.astype(int) - canary.others.astype(int)).max(initial=0) / 255
        return (max(float(abs(policy - canary.policy).max(initial=0)), float(foretold)),
                float(abs(value - canary.value).max(initial=0)))

    def forward(self, planes: torch.Tensor) -> Output:
        """planes: float32 [n, 23, 11, 11]."""
        x = self.blocks(self._run(self.stem, planes))
        hidden = self.value.fc1(self._run(self.value, x).flatten(1))
        logits = self.policy.fc(self._run(self.policy, x).flatten(1))
        if self.description["own_hidden"] > 0:
            cells, seen = self._cells(x, planes, _OWN_CELL_PLANE, 1)
            own = (self._activate(self.own.fc(cells)) * seen)[:, 0]
            hidden = hidden + self.own.value(own)
            logits = logits + self.own.policy(own)
        others = None
        if self.description["others_hidden"] > 0:
            cells, seen = self._cells(x, planes, _OWN_CELL_PLANE + 1, _OTHERS)
            others = self.others.policy(self._activate(self.others.fc(cells))) * seen
        value = torch.tanh(self.value.fc2(self._activate(hidden))).squeeze(1)
        return Output(logits, value, others)

    @staticmethod
    def _cells(tower: torch.Tensor, planes: torch.Tensor, first: int, count: int
               ) -> tuple[torch.Tensor, torch.Tensor]:
        """What the tower says of the cells marked in these planes, and which are marked."""
        marked = planes[:, first:first + count].flatten(2)
        return marked @ tower.flatten(2).transpose(1, 2), marked.sum(2, keepdim=True)

    def _run(self, branch: nn.Module, x: torch.Tensor) -> torch.Tensor:
        return self._activate(branch.bn(branch.conv(x)))

    def _activate(self, x: torch.Tensor) -> torch.Tensor:
        return functional.leaky_relu(x, self.description["leaky_slope"])


def _convolution(inputs: int, outputs: int, kernel: int, stride: int = 1, groups: int = 1
                 ) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False)


def _norm(channels: int) -> nn.BatchNorm2d:
    return nn.BatchNorm2d(channels, eps=_NORM_EPSILON)


def _branch(inputs: int, outputs: int, kernel: int, stride: int = 1) -> nn.Module:
    branch = nn.Module()
    branch.conv = _convolution(inputs, outputs, kernel, stride)
    branch.bn = _norm(outputs)
    return branch
