"""Reads a COLMAP text model with its pictures, as COLMAP's documentation ("Output Format") describes both.

read_colmap.py FOLDER prints what it found as JSON: how far points reproject from where images.txt says that they were seen,
and how much their colours differ from the pictures there, and in all other pictures that they project into."""
import json
import pathlib
import sys

import numpy as np
from PIL import Image

import lens

PARAMETERS = {
    "PINHOLE": ["fx", "fy", "cx", "cy"],
    "OPENCV": ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"],
    "FULL_OPENCV": ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"],
}


def lines_of(file):
    return [line for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]


def read_cameras(file):
    cameras = {}
    for line in lines_of(file):
        camera, model, width, height, *values = line.split()
        names = PARAMETERS[model]
        assert len(values) == len(names), line
        cameras[int(camera)] = {
            "model": model,
            "width": int(width),
            "height": int(height),
            "parameters": dict(zip(names, map(float, values))),
        }
    return cameras


def read_images(file):
    lines = lines_of(file)
    assert len(lines) % 2 == 0, "an image has two lines"
    images = {}
    for pose, seen in zip(lines[::2], lines[1::2]):
        image, *numbers, camera, name = pose.split()
        numbers = list(map(float, numbers))
        points = np.array(list(map(float, seen.split()))).reshape(-1, 3)
        images[int(image)] = {
            "rotation": lens.rotation(*numbers[:4]),
            "translation": np.array(numbers[4:]),
            "camera": int(camera),
            "name": name,
            "pixels": points[:, :2],
            "points": points[:, 2].astype(int),
        }
    return images


def read_points(file):
    points = {}
    for line in lines_of(file):
        point, *values = line.split()
        track = list(map(int, values[7:]))
        points[int(point)] = {
            "place": np.array(list(map(float, values[:3]))),
            "color": np.array(list(map(int, values[3:6]))),
            "track": list(zip(track[::2], track[1::2])),
        }
    return points


def main(folder):
    folder = pathlib.Path(folder)
    cameras = read_cameras(folder / "sparse/0/cameras.txt")
    images = read_images(folder / "sparse/0/images.txt")
    points = read_points(folder / "sparse/0/points3D.txt")
    places = np.array([point["place"] for point in points.values()]).reshape(-1, 3)
    colors = np.array([point["color"] for point in points.values()]).reshape(-1, 3)
    for point, seen in points.items():
        for image, index in seen["track"]:
            assert images[image]["points"][index] == point, "a track and an image contradict each other"
    own_px, own_color, other_color = [], [], []
    for image in images.values():
        camera = cameras[image["camera"]]
        picture = np.asarray(Image.open(folder / "images" / image["name"]).convert("RGB")).astype(int)
        assert picture.shape == (camera["height"], camera["width"], 3)
        if len(image["points"]):
            own = np.array([points[point]["place"] for point in image["points"]])
            seen = lens.project(own @ image["rotation"].T + image["translation"], **camera["parameters"])
            own_px += np.linalg.norm(seen - image["pixels"], axis=1).tolist()
            at = np.floor(image["pixels"]).astype(int)
            true = np.array([points[point]["color"] for point in image["points"]])
            own_color += np.abs(picture[at[:, 1], at[:, 0]] - true).max(axis=1).tolist()
        if len(places):
            local = places @ image["rotation"].T + image["translation"]
            local = np.where(local[:, 2:] > 0.1, local, [0, 0, -1])
            pixels = lens.project(local, **camera["parameters"])
            visible = lens.within(pixels, local[:, 2], camera["width"], camera["height"])
            at = np.floor(pixels[visible]).astype(int)
            other_color += np.abs(picture[at[:, 1], at[:, 0]] - colors[visible]).max(axis=1).tolist()
    print(
        json.dumps(
            {
                "models": [camera["model"] for camera in cameras.values()],
                "images": [image["name"] for image in images.values()],
                "points": len(points),
                "farthest_px": max(own_px, default=None),
                "own_color_difference": max(own_color, default=None),
                "color_difference_median": float(np.median(other_color)) if other_color else None,
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
