"""Reads what `roomwise export json` wrote, by its schema (python3-jsonschema) and by plain geometry.

read_home_json.py SCHEMA FILE prints what it found as JSON; it fails where the file is not as the schema says or contradicts
itself."""
import json
import math
import sys

import jsonschema


def signed_area(ring):
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:])) / 2


def is_within(ring, x, y):
    within = False
    for (ax, ay), (bx, by) in zip(ring, ring[1:]):
        if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
            within = not within
    return within


def room_area(room):
    area = 0
    for outer, *holes in room["polygons"]:
        assert signed_area(outer) > 0, "an outer ring goes clockwise"
        assert all(signed_area(hole) < 0 for hole in holes), "a hole goes counter-clockwise"
        assert all(ring[0] == ring[-1] for ring in [outer, *holes]), "a ring is not closed"
        area += signed_area(outer) + sum(map(signed_area, holes))
    return area


def room_at(home, x, y):
    for room in home["rooms"]:
        for outer, *holes in room["polygons"]:
            if is_within(outer, x, y) and not any(is_within(hole, x, y) for hole in holes):
                return room["name"]
    return None


def rotated(q, v):
    x, y, z, w = q
    assert math.isclose(x * x + y * y + z * z + w * w, 1, abs_tol=1e-9)
    return [
        (1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y - w * z) * v[1] + 2 * (x * z + w * y) * v[2],
        2 * (x * y + w * z) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z - w * x) * v[2],
        2 * (x * z - w * y) * v[0] + 2 * (y * z + w * x) * v[1] + (1 - 2 * (x * x + y * y)) * v[2],
    ]


def main(schema_file, home_file):
    with open(schema_file, encoding="utf-8") as file:
        schema = json.load(file)
    with open(home_file, encoding="utf-8") as file:
        home = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(home)
    names = [room["name"] for room in home["rooms"]]
    for door in home["doors"] + home["openings"]:
        assert all(name in names for name in door["rooms"]), door
    things = []
    for thing in home["things"]:
        found = {"name": thing["name"], "room": thing["room"], "piece": thing["piece"], "room_by_place": None}
        if thing["box"]:
            box = thing["box"]
            found["room_by_place"] = room_at(home, *box["middle_m"][:2])
            corners = [
                [m + d for m, d in zip(box["middle_m"], rotated(box["quaternion_xyzw"], [s * e / 2 for s, e in zip(signs, box["size_m"])]))]
                for signs in [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
            ]
            found["lowest_m"] = min(c[2] for c in corners)
            found["highest_m"] = max(c[2] for c in corners)
        for seen in (thing["first_seen"], thing["last_seen"]):
            assert seen is None or seen["walk"] < len(home["walks"])
        things.append(found)
    # Which way the first camera of each walk looks: its z axis.
    looks = [rotated(walk["path"][0]["quaternion_xyzw"], [0, 0, 1]) for walk in home["walks"] if walk["path"]]
    print(
        json.dumps(
            {
                "rooms": names,
                "areas_m2": [room_area(room) for room in home["rooms"]],
                "floor_m2": [room["floor_m2"] for room in home["rooms"]],
                "doors": home["doors"],
                "openings": home["openings"],
                "things": things,
                "walks": [
                    {key: walk[key] for key in ("name", "frames", "placed", "keyframes_elsewhere")}
                    | {"path": len(walk["path"])}
                    | {"heights_m": sorted({round(p["position_m"][2], 2) for p in walk["path"]})}
                    for walk in home["walks"]
                ],
                "looks": looks,
                "floor_found": home["frames"]["floor_found"],
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
