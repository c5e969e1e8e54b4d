"""Reads a dataset of Nerfstudio as its documentation ("Data conventions") describes it.

read_nerfstudio.py FOLDER prints what it found as JSON: how far the points of sparse_pc.ply lie from what depth images and
pictures show where they project to."""
import json
import pathlib
import struct
import sys

import numpy as np
from PIL import Image

import lens


def read_ply(file):
    header, body = file.read_bytes().split(b"end_header\n", 1)
    lines = header.decode().split("\n")
    assert lines[1] == "format binary_little_endian 1.0"
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    assert [line.split()[1:] for line in lines if line.startswith("property")] == [
        ["float", "x"], ["float", "y"], ["float", "z"], ["uchar", "red"], ["uchar", "green"], ["uchar", "blue"],
    ]  # fmt: skip
    rows = list(struct.iter_unpack("<fffBBB", body))
    assert len(rows) == count
    rows = np.array(rows).reshape(-1, 6)
    return rows[:, :3], rows[:, 3:].astype(int)


def main(folder):
    folder = pathlib.Path(folder)
    scene = json.loads((folder / "transforms.json").read_text(encoding="utf-8"))
    places, colors = read_ply(folder / scene["ply_file_path"])
    shown = np.zeros(len(places), dtype=bool)
    color_difference, sizes, heights, looks, depth_pixels = [], [], [], [], 0
    assert scene["camera_model"] == "OPENCV"
    for frame in scene["frames"]:
        picture = np.asarray(Image.open(folder / frame["file_path"]).convert("RGB")).astype(int)
        with Image.open(folder / frame["depth_file_path"]) as image:
            assert image.mode.startswith("I"), "depth has 16 bits"
            depth = np.asarray(image).astype(float) / 1000
        assert picture.shape[:2] == depth.shape == (frame["h"], frame["w"])
        sizes.append([frame["w"], frame["h"]])
        depth_pixels += int((depth > 0).sum())
        matrix = np.array(frame["transform_matrix"])
        assert np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3)) and np.linalg.det(matrix) > 0
        heights.append(matrix[2, 3])
        looks.append(-matrix[2, 2])  # it looks along -z
        if not len(places):
            continue
        local = (places - matrix[:3, 3]) @ matrix[:3, :3]
        local = local * [1, -1, -1]  # OpenGL's camera to one that looks along z
        local = np.where(local[:, 2:] > 0.1, local, [0, 0, -1])
        pixels = lens.project(
            local, frame["fl_x"], frame["fl_y"], frame["cx"], frame["cy"],
            **{name: frame[name] for name in ("k1", "k2", "k3", "p1", "p2")},
        )  # fmt: skip
        visible = lens.within(pixels, local[:, 2], frame["w"], frame["h"])
        at = np.floor(pixels[visible]).astype(int)
        agrees = np.abs(depth[at[:, 1], at[:, 0]] - local[visible, 2]) < 0.02
        shown[np.flatnonzero(visible)[agrees]] = True
        color_difference += np.abs(picture[at[:, 1], at[:, 0]] - colors[visible])[agrees].max(axis=1).tolist()
    print(
        json.dumps(
            {
                "frames": len(scene["frames"]),
                "walks": sorted({frame["walk"] for frame in scene["frames"]}),
                "sizes": sorted(map(list, set(map(tuple, sizes)))),
                "points": len(places),
                "shown": float(shown.mean()) if len(places) else None,
                "lowest_point_m": float(places[:, 2].min()) if len(places) else None,
                "heights_m": [min(heights), max(heights)],
                "looks_up": max(looks),
                "depth_pixels": depth_pixels,
                "color_difference_median": float(np.median(color_difference)) if color_difference else None,
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
