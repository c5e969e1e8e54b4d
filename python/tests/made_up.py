"""What tests share: a made-up recording of a wall, and folders that go away."""

import atexit
import pathlib
import shutil
import struct
import tempfile
import zlib

import numpy as np

WIDTH, HEIGHT, FOCAL_PX = 320, 240, 300.0
WALL_M = 2.0
FRAME_PERIOD_S = 0.1


def scratch_folder():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="roomwise-python-test-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def png(pixels):
    """The bytes of a PNG: (h, w, 3) uint8 or (h, w) uint16."""

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    bits, kind = (8, 2) if pixels.ndim == 3 else (16, 0)
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(pixels.shape[0], -1)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], bits, kind, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(raw, 1))
        + chunk(b"IEND", b"")
    )


def shift_px(frame):
    """How far the wall has moved through the picture in the n-th frame, whole pixels."""
    return 9 * frame, int(round(20 * np.sin(0.5 * frame)))


def color_of(frame, is_warm=True):
    """The wall has a random pattern of squares of 6 px; its light is warm or cold."""
    cells = np.random.default_rng(1).integers(0, 256, (80, 200), dtype=np.uint8)
    wall = np.kron(cells, np.ones((6, 6), dtype=np.uint8))
    x, y = shift_px(frame)
    gray = wall[100 + y : 100 + y + HEIGHT, 100 + x : 100 + x + WIDTH]
    dimmed = gray // 4 * 3
    return np.stack([gray, gray, dimmed] if is_warm else [dimmed, gray, gray], axis=2)


def depth_of(frame):
    """The wall in mm; a few pixels were not measured."""
    depth = np.full((HEIGHT, WIDTH), int(1000 * WALL_M), dtype=np.uint16)
    depth[:4, frame : frame + 5] = 0
    return depth


def write_recording(folder, frames=8):
    """A camera moves along a curve, without turning, in front of a wall: first in the hall, whose light
    is warm, then in the kitchen."""
    (folder / "rgb").mkdir(parents=True)
    (folder / "depth").mkdir()
    (folder / "camera.txt").write_text(
        f"{FOCAL_PX} {FOCAL_PX} {(WIDTH - 1) / 2} {(HEIGHT - 1) / 2} {WIDTH} {HEIGHT} 1000\n"
    )
    rgb, depth, truth = [], [], []
    for i in range(frames):
        time = f"{(i + 1) * FRAME_PERIOD_S:.6f}"
        (folder / f"rgb/{time}.png").write_bytes(png(color_of(i, is_warm=i < frames // 2)))
        (folder / f"depth/{time}.png").write_bytes(png(depth_of(i)))
        rgb.append(f"{time} rgb/{time}.png\n")
        depth.append(f"{time} depth/{time}.png\n")
        x, y = (WALL_M / FOCAL_PX * shift for shift in shift_px(i))
        truth.append(f"{time} {x:.9f} {y:.9f} 0 0 0 0 1\n")
    (folder / "rgb.txt").write_text("".join(rgb))
    (folder / "depth.txt").write_text("".join(depth))
    (folder / "groundtruth.txt").write_text("".join(truth))
    half = frames // 2
    (folder / "rooms.txt").write_text(f"0 {half - 1} hall 1\n{half} {frames - 1} kitchen 1\n")
    return folder


def address_of(array):
    return array.__array_interface__["data"][0]


def resident_bytes():
    """Of this process, now."""
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096
