"""Reads an IndoorGML 1.0.3 document and checks what the standard asks for beyond and with its schema: the order of elements,
identifiers and what refers to them, states and spaces as each other's duals, transitions between two states that name them,
geometries of three coordinates in the document's own reference system, rings that are closed and go the right way round.

read_indoorgml.py FILE prints what it found as JSON. Written from OGC 14-005r5 (IndoorGML 1.0.3, sections 8 and 9) and
OGC 07-036 (GML 3.2.1)."""
import json
import math
import re
import sys
import xml.etree.ElementTree as ElementTree

CORE, NAVI, GML, XLINK = (
    "{http://www.opengis.net/indoorgml/1.0/core}",
    "{http://www.opengis.net/indoorgml/1.0/navigation}",
    "{http://www.opengis.net/gml/3.2}",
    "{http://www.w3.org/1999/xlink}",
)
PLACES = {"c": CORE, "n": NAVI, "g": GML}
# What a feature may hold, in this order, after what all features of GML may.
FEATURE = ["g:metaDataProperty", "g:description", "g:identifier", "g:name", "g:boundedBy"]
CHILDREN = {
    "c:IndoorFeatures": ["c:primalSpaceFeatures", "c:multiLayeredGraph"],
    "c:PrimalSpaceFeatures": ["c:cellSpaceMember", "c:cellSpaceBoundaryMember"],
    "n:GeneralSpace": ["c:cellSpaceGeometry", "c:duality", "c:externalReference", "c:partialboundedBy", "n:class", "n:function", "n:usage"],
    "c:MultiLayeredGraph": ["c:spaceLayers", "c:interEdges"],
    "c:spaceLayers": ["c:spaceLayerMember"],
    "c:SpaceLayer": ["c:usage", "c:terminationDate", "c:function", "c:creationDate", "c:class", "c:nodes", "c:edges"],
    "c:nodes": ["c:stateMember"],
    "c:edges": ["c:transitionMember"],
    "c:State": ["c:duality", "c:connects", "c:geometry"],
    "c:Transition": ["c:weight", "c:connects", "c:duality", "c:geometry"],
    "c:interEdges": ["c:interLayerConnectionMember"],
    "c:InterLayerConnection": ["c:typeOfTopoExpression", "c:comment", "c:interConnects", "c:ConnectedLayers"],
}


def full(name):
    return PLACES[name[0]] + name[2:]


def text_of(element, name):
    found = element.find(full(name))
    return None if found is None else found.text


def facts_of(element):
    return dict(re.findall(r'(\w+)="([^"]*)":', text_of(element, "g:description") or ""))


def target(element):
    return element.get(XLINK + "href")[1:]


def targets(element, name):
    return [target(one) for one in element.findall(full(name))]


class Document:
    def __init__(self, file):
        self.root = ElementTree.parse(file).getroot()
        assert self.root.tag == full("c:IndoorFeatures"), self.root.tag
        self.named = {}
        for element in self.root.iter():
            name = element.get(GML + "id")
            if name is not None:
                assert re.fullmatch(r"[A-Za-z_][\w.-]*", name), name
                assert name not in self.named, f"{name} is there twice"
                self.named[name] = element
        for element in self.root.iter():
            for link in (element.get(XLINK + "href"), element.get("srsName")):
                assert link is None or (link[0] == "#" and link[1:] in self.named), link
        for name, children in CHILDREN.items():
            self.check_order(full(name), [full(one) for one in FEATURE + children])
        self.frame = self.named[self.root.find(f"{full('g:boundedBy')}/{full('g:Envelope')}").get("srsName")[1:]]
        assert self.frame.tag == full("g:EngineeringCRS")
        axes = self.frame.findall(".//" + full("g:CoordinateSystemAxis"))
        assert [text_of(axis, "g:axisAbbrev") for axis in axes] == ["x", "y", "z"]
        assert all(axis.get("uom") == "m" for axis in axes)

    def check_order(self, tag, children):
        for element in self.root.iter(tag):
            assert element.get(GML + "id"), f"{tag} without a name"
            places = [children.index(child.tag) for child in element]
            assert places == sorted(places), f"{tag}: {[child.tag for child in element]}"

    def numbers(self, geometry, name):
        assert geometry.get("srsName") == "#" + self.frame.get(GML + "id") and geometry.get("srsDimension") == "3"
        return self.triples(geometry.find(full(name)))

    @staticmethod
    def triples(element):
        values = [float(one) for one in element.text.split()]
        assert len(values) % 3 == 0 and all(map(math.isfinite, values))
        return [tuple(values[at : at + 3]) for at in range(0, len(values), 3)]

    def all(self, name):
        return list(self.root.iter(full(name)))


def signed_area(ring):
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ring, ring[1:])) / 2


def is_within(ring, point):
    within = False
    for a, b in zip(ring, ring[1:]):
        if (a[1] > point[1]) != (b[1] > point[1]) and point[0] < a[0] + (b[0] - a[0]) * (point[1] - a[1]) / (b[1] - a[1]):
            within = not within
    return within


def read_space(document, space):
    polygon = space.find(f"{full('c:cellSpaceGeometry')}/{full('c:Geometry2D')}/{full('g:Polygon')}")
    assert polygon.get("srsName") == "#" + document.frame.get(GML + "id")
    sides = [(side.tag, document.triples(side.find(f"{full('g:LinearRing')}/{full('g:posList')}"))) for side in polygon]
    assert [tag for tag, _ in sides] == [full("g:exterior")] + [full("g:interior")] * (len(sides) - 1)
    rings = [ring for _, ring in sides]
    assert all(ring[0] == ring[-1] and len(ring) >= 4 for ring in rings), "a ring is not closed"
    assert len({place[2] for ring in rings for place in ring}) == 1, "a floor is not level"
    assert signed_area(rings[0]) > 0 and all(signed_area(hole) < 0 for hole in rings[1:])
    kind = [text_of(space, "n:" + one) for one in ("class", "function", "usage")]
    assert all(kind)
    facts = facts_of(space)
    return {
        "id": space.get(GML + "id"),
        "name": text_of(space, "g:name"),
        "type": kind[1],
        "storey": int(facts["storey"]),
        "part_of": facts.get("part_of"),
        "area_m2": round(sum(map(signed_area, rings)), 4),
        "floor_m": rings[0][0][2],
        "holes": len(rings) - 1,
        "corners": len(rings[0]) - 1,
        "low": [min(place[axis] for place in rings[0]) for axis in (0, 1)],
        "high": [max(place[axis] for place in rings[0]) for axis in (0, 1)],
        "state": (targets(space, "c:duality") or [None])[0],
        "rings": rings,
    }


def place_of(document, state):
    (place,) = document.numbers(state.find(f"{full('c:geometry')}/{full('g:Point')}"), "g:pos")
    return place


def read_transition(document, transition, states):
    ends = targets(transition, "c:connects")
    assert len(ends) == 2 and ends[0] != ends[1]
    name = transition.get(GML + "id")
    for end in ends:
        assert name in targets(document.named[end], "c:connects"), f"{end} does not know {name}"
    line = document.numbers(transition.find(f"{full('c:geometry')}/{full('g:LineString')}"), "g:posList")
    assert line[0] == states[ends[0]]["place"] and line[-1] == states[ends[1]]["place"]
    length = sum(math.dist(a, b) for a, b in zip(line, line[1:]))
    assert math.isclose(float(text_of(transition, "c:weight")), length, abs_tol=0.01)
    return {
        "name": text_of(transition, "g:name"),
        "rooms": [states[end]["name"] for end in ends],
        "line": line,
        "facts": facts_of(transition),
    }


def main(file):
    document = Document(file)
    spaces = [read_space(document, space) for space in document.all("n:GeneralSpace")]
    layers = document.all("c:SpaceLayer")
    assert [text_of(layer, "c:class") for layer in layers] == ["TOPOGRAPHIC", "TAGS"][: len(layers)]
    states, storeys = {}, []
    for nodes in layers[0].findall(full("c:nodes")):
        storeys.append(text_of(nodes, "g:name"))
        for state in nodes.iter(full("c:State")):
            name = state.get(GML + "id")
            states[name] = {"name": text_of(state, "g:name"), "place": place_of(document, state)}
            (space,) = [space for space in spaces if space["id"] == target(state.find(full("c:duality")))]
            assert space["state"] == name and space["name"] == states[name]["name"]
            assert f"storey {space['storey']}" == storeys[-1]
            assert is_within(space["rings"][0], states[name]["place"]), "a state lies beside its room"
            assert not any(is_within(hole, states[name]["place"]) for hole in space["rings"][1:])
            assert states[name]["place"][2] == space["floor_m"]
    transitions = [read_transition(document, one, states) for one in document.all("c:Transition")]
    things = {}
    for state in layers[1].iter(full("c:State")) if len(layers) > 1 else []:
        things[state.get(GML + "id")] = {
            "name": text_of(state, "g:name"),
            "place": place_of(document, state),
            "facts": facts_of(state),
            "room": None,
        }
    for connection in document.all("c:InterLayerConnection"):
        assert text_of(connection, "c:typeOfTopoExpression") == "CONTAINS"
        room, thing = targets(connection, "c:interConnects")
        assert targets(connection, "c:ConnectedLayers") == [layer.get(GML + "id") for layer in layers]
        things[thing]["room"] = states[room]["name"]
    for space in spaces:
        del space["rings"]
    envelope = document.root.find(f"{full('g:boundedBy')}/{full('g:Envelope')}")
    low, high = (document.triples(envelope.find(full(f"g:{side}Corner")))[0] for side in ("lower", "upper"))
    for one in [*states.values(), *things.values()]:
        assert all(a <= b <= c for a, b, c in zip(low, one["place"], high)), "beyond the envelope"
    print(
        json.dumps(
            {
                "spaces": spaces,
                "storeys": storeys,
                "states": list(states.values()),
                "transitions": transitions,
                "things": list(things.values()),
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
