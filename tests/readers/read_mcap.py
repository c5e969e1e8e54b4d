"""Reads an MCAP file by its index, as MCAP's specification (version 0) describes it, checks all its CRC-32, and the JSON
messages by the schemas that it holds (python3-jsonschema).

read_mcap.py FILE prints what it found as JSON."""
import base64
import io
import json
import struct
import sys
import zlib

import jsonschema
import numpy as np
from PIL import Image

MAGIC = b"\x89MCAP0\r\n"
FLOAT32, UINT8 = 7, 1


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, kind):
        (value,) = struct.unpack_from("<" + kind, self.data, self.at)
        self.at += struct.calcsize("<" + kind)
        return value

    def bytes(self, size):
        assert self.at + size <= len(self.data), "a length leads beyond the end"
        self.at += size
        return self.data[self.at - size : self.at]

    def text(self):
        return self.bytes(self.number("I")).decode("utf-8")

    def list(self, *kinds):
        end = self.number("I") + self.at
        values = []
        while self.at < end:
            values.append(tuple(self.number(kind) for kind in kinds))
        assert self.at == end
        return values

    def record(self):
        kind, size = self.number("B"), self.number("Q")
        return kind, Reader(self.bytes(size))

    def records(self):
        while self.at < len(self.data):
            yield self.record()


def read_summary(data):
    assert data[:8] == MAGIC and data[-8:] == MAGIC
    footer_at = len(data) - 8 - 9 - 20
    kind, footer = Reader(data[footer_at:-8]).record()
    assert kind == 0x02
    start, offsets_start, crc = footer.number("Q"), footer.number("Q"), footer.number("I")
    assert crc == zlib.crc32(data[start : footer_at + 9 + 16]), "the summary's CRC-32"
    kind, end = Reader(data[start - 13 : start]).record()
    assert kind == 0x0F and end.number("I") == zlib.crc32(data[: start - 13]), "the data's CRC-32"
    summary = {"schemas": {}, "channels": {}, "chunks": [], "statistics": None}
    groups = []
    for kind, record in Reader(data[start:offsets_start]).records():
        if not groups or groups[-1] != kind:
            groups.append(kind)
        if kind == 0x03:
            number, name, encoding = record.number("H"), record.text(), record.text()
            assert number != 0 and encoding == "jsonschema"
            schema = json.loads(record.bytes(record.number("I")))
            summary["schemas"][number] = (name, schema)
        elif kind == 0x04:
            number, schema = record.number("H"), record.number("H")
            summary["channels"][number] = (schema, record.text(), record.text())
            assert record.text() == "", "metadata"
        elif kind == 0x08:
            summary["chunks"].append(record)
        elif kind == 0x0B:
            summary["statistics"] = record
    assert len(set(groups)) == len(groups), "records of one kind stand together"
    for kind, record in Reader(data[offsets_start:footer_at]).records():
        assert kind == 0x0E
        kind, at, length = record.number("B"), record.number("Q"), record.number("Q")
        assert {found for found, _ in Reader(data[at : at + length]).records()} == {kind}
    return summary


def read_chunk(data, index):
    first, last, at, length = (index.number("Q") for _ in range(4))
    offsets = index.list("H", "Q")
    index_length, compression = index.number("Q"), index.text()
    kind, chunk = Reader(data[at : at + length]).record()
    assert kind == 0x06
    assert (chunk.number("Q"), chunk.number("Q")) == (first, last)
    size, crc = chunk.number("Q"), chunk.number("I")
    assert chunk.text() == compression == ""
    records = chunk.bytes(chunk.number("Q"))
    assert len(records) == size and zlib.crc32(records) == crc, "the chunk's CRC-32"
    indexed = 0
    for channel, offset in offsets:
        assert at + length <= offset < at + length + index_length
        kind, entries = Reader(data[offset:]).record()
        assert kind == 0x07 and entries.number("H") == channel
        for time, place in entries.list("Q", "Q"):
            reader = Reader(records)
            reader.at = place
            kind, message = reader.record()
            assert kind == 0x05 and message.number("H") == channel
            sequence, logged, published = message.number("I"), message.number("Q"), message.number("Q")
            assert logged == published == time and first <= time <= last
            indexed += 1
            yield channel, sequence, time, json.loads(message.data[message.at :])
    assert indexed == sum(kind == 0x05 for kind, _ in Reader(records).records()), "all messages are indexed"


def stamp(message):
    return message["timestamp"]["sec"] * 10**9 + message["timestamp"]["nsec"]


def read_cloud(cloud):
    types = {FLOAT32: "<f4", UINT8: "u1"}
    names = [field["name"] for field in cloud["fields"]]
    kind = np.dtype(
        {
            "names": names,
            "formats": [types[field["type"]] for field in cloud["fields"]],
            "offsets": [field["offset"] for field in cloud["fields"]],
            "itemsize": cloud["point_stride"],
        }
    )
    points = np.frombuffer(base64.b64decode(cloud["data"], validate=True), dtype=kind)
    return np.stack([points["x"], points["y"], points["z"]], axis=1), np.stack(
        [points["red"], points["green"], points["blue"]], axis=1
    )


def quaternion_matrix(q):
    w, v = q["w"], np.array([q["x"], q["y"], q["z"]])
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def picture_difference(picture, camera, pose, cloud):
    """Of points' colours to the picture, where the camera's own numbers say that it shows them."""
    places, colors = cloud
    at = np.array([pose["translation"][key] for key in "xyz"])
    local = (places - at) @ quaternion_matrix(pose["rotation"])
    assert camera["distortion_model"] == "plumb_bob"
    k, (k1, k2, p1, p2, k3) = np.array(camera["K"]).reshape(3, 3), camera["D"]
    ahead = local[:, 2] > 0.1
    local, colors = local[ahead], colors[ahead]
    x, y = local[:, 0] / local[:, 2], local[:, 1] / local[:, 2]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    u = k[0, 0] * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + k[0, 2]
    v = k[1, 1] * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + k[1, 2]
    column, row = np.rint(u).astype(int), np.rint(v).astype(int)  # pixel (0, 0) is its middle
    inside = (column >= 0) & (row >= 0) & (column < camera["width"]) & (row < camera["height"])
    shown = picture[row[inside], column[inside]]
    return np.abs(shown.astype(int) - colors[inside]).max(axis=1).tolist()


def entities_of(by_topic, topic):
    return by_topic[topic]["messages"][0]["entities"] if topic in by_topic else []


def read_rooms(entities):
    rooms = []
    for entity in entities:
        assert entity["frame_id"] == "home" and len(entity["texts"]) == 1
        rings, heights = [], set()
        for line in entity["lines"]:
            assert line["type"] == 1, "a LINE_LOOP, which closes itself"
            assert line["pose"]["position"] == {"x": 0, "y": 0, "z": 0} and not line["indices"]
            rings.append([(point["x"], point["y"]) for point in line["points"]])
            heights.update(point["z"] for point in line["points"])
        assert len(heights) == 1, "rooms are flat"
        rooms.append((entity["texts"][0]["text"], rings, heights.pop()))
    return rooms


def area(rings):
    """Of rings whose holes turn the other way."""
    return sum(a[0] * b[1] - a[1] * b[0] for ring in rings for a, b in zip(ring, ring[1:] + ring[:1])) / 2


def is_inside(point, rings):
    crossed = False
    for ring in rings:
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
            if (ay > point[1]) != (by > point[1]) and point[0] < ax + (bx - ax) * (point[1] - ay) / (by - ay):
                crossed = not crossed
    return crossed


def read_prompts(by_topic, poses, rooms):
    """Each with the rooms in whose outlines the camera was when it was said."""
    prompts = []
    for log in by_topic.get("/prompts", {"messages": []})["messages"]:
        assert log["level"] == 2 and log["name"] == "roomwise"
        at = poses[stamp(log)]["translation"]
        prompts.append(
            {"text": log["message"], "in": [name for name, rings, _ in rooms if is_inside((at["x"], at["y"]), rings)]}
        )
    return prompts


def main(file):
    with open(file, "rb") as content:
        data = content.read()
    kind, header = Reader(data[8:]).record()
    assert kind == 0x01 and header.text() == "" and header.text() == "roomwise"
    summary = read_summary(data)
    messages = [message for index in summary["chunks"] for message in read_chunk(data, index)]
    statistics = summary["statistics"]
    assert statistics.number("Q") == len(messages)
    assert statistics.number("H") == len(summary["schemas"]) and statistics.number("I") == len(summary["channels"])
    statistics.bytes(8)
    assert statistics.number("I") == len(summary["chunks"])
    assert statistics.number("Q") == min(m[2] for m in messages) and statistics.number("Q") == max(m[2] for m in messages)
    counts = dict(statistics.list("H", "Q"))
    by_topic = {}
    for number, (schema, topic, encoding) in summary["channels"].items():
        name, text = summary["schemas"][schema]
        assert encoding == "json"
        jsonschema.validators.validator_for(text).check_schema(text)
        own = sorted((m[1], m[2], m[3]) for m in messages if m[0] == number)
        assert len(own) == counts[number] and [m[0] for m in own] == list(range(len(own)))
        assert [m[1] for m in own] == sorted(m[1] for m in own), "in the order of time"
        for _, time, message in own:
            jsonschema.validate(message, text)
            if "timestamp" in message:
                assert stamp(message) == time
        by_topic[topic] = {"schema": name, "messages": [m[2] for m in own]}
    poses = {stamp(pose): pose for pose in by_topic["/tf"]["messages"]}
    assert all(one["messages"] for one in by_topic.values()), "a topic without a message"
    cloud = read_cloud(by_topic["/map"]["messages"][0]) if "/map" in by_topic else (np.zeros((0, 3)), np.zeros((0, 3)))
    differences = []
    for image, camera in zip(by_topic["/camera/image"]["messages"], by_topic["/camera/calibration"]["messages"]):
        assert stamp(image) == stamp(camera) and image["frame_id"] == camera["frame_id"] == "camera"
        picture = Image.open(io.BytesIO(base64.b64decode(image["data"], validate=True)))
        assert picture.format.lower() == image["format"] and picture.size == (camera["width"], camera["height"])
        assert not picture.getexif(), "a picture has Exif"
        differences += picture_difference(np.asarray(picture.convert("RGB")), camera, poses[stamp(image)], cloud)
    rooms = read_rooms(entities_of(by_topic, "/rooms"))
    print(
        json.dumps(
            {
                "topics": {topic: [one["schema"], len(one["messages"])] for topic, one in by_topic.items()},
                "frames": sorted({(pose["parent_frame_id"], pose["child_frame_id"]) for pose in poses.values()}),
                "points": len(cloud[0]),
                "lowest_point_m": float(cloud[0][:, 2].min()) if len(cloud[0]) else None,
                "color_difference_median": float(np.median(differences)) if differences else None,
                "things": [
                    {
                        "name": entity["texts"][0]["text"],
                        "bottom_m": entity["cubes"][0]["pose"]["position"]["z"] - entity["cubes"][0]["size"]["z"] / 2,
                    }
                    for entity in entities_of(by_topic, "/things")
                ],
                "rooms": [{"name": name, "area_m2": area(rings), "height_m": height} for name, rings, height in rooms],
                "prompts": read_prompts(by_topic, poses, rooms),
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
