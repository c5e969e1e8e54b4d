"""Reads a scene graph as Spark-DSG 1.1.3 reads it from JSON: what its reader asks for must be there, nodes come before the
edges that join them, and none twice.

read_scene_graph.py FILE prints what it found as JSON. Written from Spark-DSG's graph_json_serialization.cpp,
json_conversions.cpp and node_attributes.cpp, github.com/MIT-SPARK/Spark-DSG, commit be110f394bbc6d74e0390f77d41b11aae175fd0c."""
import json
import sys

NODE = {"position": list, "last_update_time_ns": int, "is_active": bool, "is_predicted": bool}
SEMANTIC = {**NODE, "name": str, "color": dict, "bounding_box": dict, "semantic_label": int, "semantic_feature": dict}
ATTRIBUTES = {
    "SemanticNodeAttributes": SEMANTIC,
    "RoomNodeAttributes": {**SEMANTIC, "semantic_class_probabilities": dict},
    "PlaceNodeAttributes": {
        **SEMANTIC,
        "distance": (int, float),
        "num_basis_points": int,
        "voxblox_mesh_connections": list,
        "pcl_mesh_connections": list,
        "mesh_vertex_labels": list,
        "deformation_connections": list,
        "real_place": bool,
        "active_frontier": bool,
        "frontier_scale": list,
        "orientation": dict,
        "need_cleanup": bool,
        "num_frontier_voxels": int,
        "anti_frontier": bool,
    },
    "ObjectNodeAttributes": {**SEMANTIC, "mesh_connections": list, "registered": bool, "world_R_object": dict},
}


def numbers(value, count):
    assert len(value) == count and all(isinstance(one, (int, float)) for one in value), value
    return value


def quaternion(value):
    q = [value[key] for key in "wxyz"]
    assert abs(sum(one * one for one in q) - 1) < 1e-6, q
    return q


def read_box(box):
    assert box["type"] in ("INVALID", "AABB", "RAABB", "OBB"), box
    if box["type"] == "INVALID":
        return None
    quaternion(box["world_R_center"])
    return {"size": numbers(box["dimensions"], 3), "center": numbers(box["world_P_center"], 3)}


def read_node(node, layers):
    attributes = node["attributes"]
    expected = ATTRIBUTES[attributes["type"]]
    for key, kind in expected.items():
        assert isinstance(attributes[key], kind), (key, attributes[key])
    feature = attributes["semantic_feature"]
    assert feature["rows"] * feature["cols"] == len(feature["data"])
    assert all(0 <= attributes["color"][key] <= 255 for key in "rgba")
    assert 0 <= attributes["semantic_label"] < 2**32 and attributes["last_update_time_ns"] >= 0
    if "world_R_object" in expected:
        quaternion(attributes["world_R_object"])
    if "orientation" in expected:
        quaternion(attributes["orientation"])
        numbers(attributes["frontier_scale"], 3)
    assert {"layer": node["layer"], "partition": node["partition"]} in layers
    return {
        "layer": node["layer"],
        "symbol": chr(node["id"] >> 56) + str(node["id"] & (2**56 - 1)),
        "name": attributes["name"],
        "position": numbers(attributes["position"], 3),
        "box": read_box(attributes["bounding_box"]),
        "metadata": attributes["metadata"],
        "distance": attributes.get("distance"),
        "parents": [],
        "siblings": [],
    }


def is_in(position, box):
    return all(abs(position[axis] - box["center"][axis]) <= box["size"][axis] / 2 + 1e-6 for axis in range(2))


def read_places(nodes, edges):
    """What the places say together, and which hang together."""
    places = {number: node for number, node in nodes.items() if node["symbol"][0] == "p"}
    rooms = {node["name"]: node for node in nodes.values() if node["symbol"][0] == "R"}
    pieces = {number: {number} for number in places}
    lengths, between_rooms = [], []
    for source, target in edges:
        if source not in places or target not in places:
            continue
        one, other = places[source], places[target]
        lengths.append(sum((a - b) ** 2 for a, b in zip(one["position"], other["position"])) ** 0.5)
        if one["parents"] != other["parents"]:
            between_rooms.append([(a + b) / 2 for a, b in zip(one["position"], other["position"])])
        if pieces[source] is not pieces[target]:
            pieces[source] |= pieces[target]
            for number in pieces[target]:
                pieces[number] = pieces[source]
    parents = [node["parents"] for node in places.values()]
    assert all(len(one) <= 1 for one in parents)
    return {
        "count": len(places),
        "pieces": len({id(piece) for piece in pieces.values()}),
        "of_rooms": {name: parents.count([name]) for name in rooms},
        "outside_their_room": sum(
            not is_in(node["position"], rooms[name]["box"]) for node in places.values() for name in node["parents"]
        ),
        "least_distance_m": min((node["distance"] for node in places.values()), default=None),
        "longest_edge_m": max(lengths, default=None),
        "between_rooms": between_rooms,
    }


def main(file):
    with open(file, encoding="utf-8") as text:
        graph = json.load(text)
    header = graph["SPARK_DSG_header"]
    assert header["project_name"] == "main"
    assert [header["version"][part] for part in ("major", "minor", "patch")] == [1, 1, 3]
    layers = graph["layer_keys"]
    names = {name: key["layer"] for name, key in graph["layer_names"].items()}
    assert all(key in layers for key in graph["layer_names"].values())
    nodes = {}
    for node in graph["nodes"]:
        assert node["id"] not in nodes, "a node is there twice"
        nodes[node["id"]] = read_node(node, layers)
    edges = set()
    for edge in graph["edges"]:
        source, target = nodes[edge["source"]], nodes[edge["target"]]
        key = frozenset((edge["source"], edge["target"]))
        assert key not in edges, "an edge is there twice"
        edges.add(key)
        info = edge["info"]
        assert info["type"] == "EdgeAttributes"
        assert isinstance(info["weighted"], bool) and isinstance(info["weight"], (int, float))
        if source["layer"] == target["layer"]:
            source["siblings"].append({"name": target["name"], **info["metadata"]})
        else:
            low, high = sorted((source, target), key=lambda node: node["layer"])
            low["parents"].append(high["name"])
    others = [node for node in nodes.values() if node["symbol"][0] != "p"]
    print(json.dumps({"layers": names, "nodes": others, "places": read_places(nodes, sorted(map(tuple, edges)))}))


if __name__ == "__main__":
    main(*sys.argv[1:])
