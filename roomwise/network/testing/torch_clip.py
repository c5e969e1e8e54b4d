"""Small networks of CLIP's kind with random weights, exported by PyTorch, for tests of the executor.

    python3 torch_clip.py FOLDER

writes, of two ways in which such networks are written (OpenAI's with nn.MultiheadAttention, QuickGELU and the end of the
text found by its largest number; Hugging Face's with products, GELU and masks of its own) and several opsets,
NAME.onnx with NAME.input and NAME.expected, both plain 32-bit floats. What their parts are is the papers' (Radford 2021).
"""
import math
import os
import sys
import warnings

import numpy
import torch
from torch import nn

WIDTH, HEADS, LAYERS, EMBEDDING = 32, 4, 3, 24
PICTURE, PATCH = 32, 8
WORDS, PLACES, END = 97, 16, 96


class QuickGELU(nn.Module):
    def forward(self, x):
        return x * torch.sigmoid(1.702 * x)


class PackedBlock(nn.Module):
    """OpenAI's: length x batch x width, one packed projection."""

    def __init__(self, mask):
        super().__init__()
        self.attention = nn.MultiheadAttention(WIDTH, HEADS)
        self.before, self.between = nn.LayerNorm(WIDTH), nn.LayerNorm(WIDTH)
        self.mlp = nn.Sequential(nn.Linear(WIDTH, 4 * WIDTH), QuickGELU(), nn.Linear(4 * WIDTH, WIDTH))
        self.mask = mask

    def forward(self, x):
        y = self.before(x)
        x = x + self.attention(y, y, y, need_weights=False, attn_mask=self.mask)[0]
        return x + self.mlp(self.between(x))


class PlainBlock(nn.Module):
    """Hugging Face's: batch x length x width, three projections, the mask added where it is given."""

    def __init__(self):
        super().__init__()
        self.query, self.key, self.value, self.out = (nn.Linear(WIDTH, WIDTH) for _ in range(4))
        self.before, self.between = nn.LayerNorm(WIDTH), nn.LayerNorm(WIDTH)
        self.mlp = nn.Sequential(nn.Linear(WIDTH, 4 * WIDTH), nn.GELU(), nn.Linear(4 * WIDTH, WIDTH))

    def shaped(self, x):
        batch, length, _ = x.shape
        return x.view(batch, length, HEADS, WIDTH // HEADS).transpose(1, 2).contiguous()

    def forward(self, x, mask=None):
        batch, length, _ = x.shape
        y = self.before(x)
        many = (batch * HEADS, -1, WIDTH // HEADS)
        query = self.shaped(self.query(y) * (WIDTH // HEADS) ** -0.5).view(*many)
        key, value = self.shaped(self.key(y)).view(*many), self.shaped(self.value(y)).view(*many)
        weights = torch.bmm(query, key.transpose(1, 2))
        if mask is not None:
            weights = (weights.view(batch, HEADS, length, length) + mask).view(batch * HEADS, length, length)
        y = torch.bmm(torch.softmax(weights, dim=-1), value)
        y = y.view(batch, HEADS, length, WIDTH // HEADS).transpose(1, 2).reshape(batch, length, WIDTH)
        x = x + self.out(y)
        return x + self.mlp(self.between(x))


class Picture(nn.Module):
    def __init__(self, packed):
        super().__init__()
        self.packed = packed
        self.patches = nn.Conv2d(3, WIDTH, PATCH, PATCH, bias=False)
        self.first = nn.Parameter(torch.randn(WIDTH))
        self.places = nn.Parameter(torch.randn((PICTURE // PATCH) ** 2 + 1, WIDTH))
        self.before, self.after = nn.LayerNorm(WIDTH), nn.LayerNorm(WIDTH)
        self.blocks = nn.ModuleList(PackedBlock(None) if packed else PlainBlock() for _ in range(LAYERS))
        self.projection = nn.Parameter(torch.randn(WIDTH, EMBEDDING) / math.sqrt(WIDTH))

    def forward(self, picture):
        x = self.patches(picture)
        if self.packed:
            x = x.reshape(x.shape[0], x.shape[1], -1).permute(0, 2, 1)
            first = self.first + torch.zeros(x.shape[0], 1, x.shape[-1])
        else:
            x = x.flatten(2).transpose(1, 2)
            first = self.first.expand(x.shape[0], 1, -1)
        x = self.before(torch.cat([first, x], dim=1) + self.places)
        if self.packed:
            x = x.permute(1, 0, 2)
        for block in self.blocks:
            x = block(x)
        if self.packed:
            x = x.permute(1, 0, 2)
        x = self.after(x[:, 0, :]) @ self.projection
        return x / x.norm(dim=-1, keepdim=True) if self.packed else nn.functional.normalize(x, dim=-1)


class Text(nn.Module):
    def __init__(self, packed):
        super().__init__()
        self.packed = packed
        self.words = nn.Embedding(WORDS, WIDTH)
        self.places = nn.Embedding(PLACES, WIDTH)
        self.after = nn.LayerNorm(WIDTH)
        mask = torch.full((PLACES, PLACES), float("-inf")).triu_(1)
        self.blocks = nn.ModuleList(PackedBlock(mask) if packed else PlainBlock() for _ in range(LAYERS))
        self.projection = nn.Parameter(torch.randn(WIDTH, EMBEDDING) / math.sqrt(WIDTH))
        self.register_buffer("numbers", torch.arange(PLACES).expand((1, -1)))

    def forward(self, tokens, attended=None):
        x = self.words(tokens)
        if self.packed:
            x = (x + self.places.weight).permute(1, 0, 2)
            for block in self.blocks:
                x = block(x)
            x = self.after(x.permute(1, 0, 2))
            x = x[torch.arange(x.shape[0]), tokens.argmax(dim=-1)] @ self.projection
            return x / x.norm(dim=-1, keepdim=True)
        length = tokens.shape[1]
        x = x + self.places(self.numbers[:, :length])
        lowest = torch.finfo(x.dtype).min
        mask = torch.full((length, length), lowest)
        at = torch.arange(length)
        mask = mask.masked_fill(at < (at + 1).view(length, 1), 0)[None, None].expand(tokens.shape[0], 1, length, length)
        if attended is not None:
            left_out = 1.0 - attended[:, None, None, :].expand(tokens.shape[0], 1, length, length).to(x.dtype)
            mask = mask + left_out.masked_fill(left_out.to(torch.bool), lowest)
            mask = torch.clamp(mask, min=lowest)
        for block in self.blocks:
            x = block(x, mask)
        x = self.after(x)
        end = (tokens.to(torch.int) == END).int().argmax(dim=-1)
        return nn.functional.normalize(x[torch.arange(x.shape[0]), end] @ self.projection, dim=-1)


def export(folder, name, network, inputs, names, opset):
    network.eval()
    with torch.no_grad():
        expected = network(*inputs)
    torch.onnx.export(network, inputs, os.path.join(folder, name + ".onnx"), opset_version=opset, input_names=names,
                      output_names=["embedding"], dynamic_axes={each: {0: "batch"} for each in names})
    numpy.concatenate([each.numpy().astype(numpy.float32).ravel() for each in inputs]).tofile(
        os.path.join(folder, name + ".input"))
    expected.numpy().astype(numpy.float32).tofile(os.path.join(folder, name + ".expected"))


def main():
    warnings.simplefilter("ignore")
    folder = sys.argv[1]
    for packed in (True, False):
        for opset in (11, 14, 17):
            torch.manual_seed(opset + packed)
            way = ("packed" if packed else "plain") + str(opset)
            rows = 1 if opset == 11 else 2
            picture = torch.randn(rows, 3, PICTURE, PICTURE)
            export(folder, "picture-" + way, Picture(packed), (picture,), ["picture"], opset)
            tokens = torch.zeros(rows, PLACES, dtype=torch.int64)
            for row, text in enumerate(([95, 3, 41, 5, 9, END], [95, 8, 27, END])[:rows]):
                tokens[row, :len(text)] = torch.tensor(text)
            attended = (torch.arange(PLACES) <= tokens.argmax(dim=-1, keepdim=True)).to(torch.int64)
            inputs = (tokens,) if packed else (tokens, attended)
            export(folder, "text-" + way, Text(packed), inputs, ["tokens", "attended"][:len(inputs)], opset)


main()
