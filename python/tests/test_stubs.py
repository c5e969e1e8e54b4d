"""The types that are told (roomwise/__init__.pyi) are those of what is there."""

import ast
import inspect
import pathlib
import re
import unittest

import roomwise

STUB = ast.parse(pathlib.Path(roomwise.__file__).with_name("__init__.pyi").read_text())
SPECIAL = {"__init__", "__len__", "__iter__", "__next__", "__getitem__", "__eq__"}


def is_public(name):
    return not name.startswith("_")


def stub_functions(body):
    return {node.name: node for node in body if isinstance(node, ast.FunctionDef)}


def stub_classes():
    return {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}


def stub_names():
    names = set(stub_classes()) | set(stub_functions(STUB.body))
    for node in STUB.body:
        if isinstance(node, ast.AnnAssign):
            names.add(node.target.id)
    return names


def arguments_of(function):
    """(name, default) in order; what is given by name alone; whether there is *args."""

    def text(default):
        if default is None:
            return None
        value = ast.literal_eval(default)
        return list(value) if isinstance(value, tuple) else value

    given = function.args
    by_place = given.posonlyargs + given.args
    missing = [None] * (len(by_place) - len(given.defaults))
    places = list(zip([a.arg for a in by_place], map(text, missing + given.defaults)))
    names = list(zip([a.arg for a in given.kwonlyargs], map(text, given.kw_defaults)))
    return [place for place in places if place[0] != "self"], names, given.vararg is not None


def native_function(function):
    """What pybind11 says of a function in the first line of its docstring."""
    line = function.__doc__.splitlines()[0]
    name, rest = line.split("(", 1)
    line = f"def f({rest}"
    # "<...>" is no Python: a default that cannot be told.
    return ast.parse(re.sub(r"<[^>]*>", "None", line) + ": ...").body[0]


class Stubs(unittest.TestCase):
    def test_the_same_names_as_the_package(self):
        self.assertEqual(
            {name for name in stub_names() if is_public(name) or name == "__version__"},
            set(roomwise.__all__),
        )
        self.assertEqual(
            {name for name in vars(roomwise) if is_public(name)} - {"annotations"},
            set(roomwise.__all__) - {"__version__"},
        )

    def test_the_same_members_as_every_class(self):
        for name, stub in stub_classes().items():
            there = getattr(roomwise, name)
            if name == "ErrorCode":
                members = {code.name for code in there}
                told = {node.targets[0].id for node in stub.body}
            elif name == "Error":
                continue  # in Python itself
            else:
                members = {m for m in vars(there) if is_public(m) or m in SPECIAL}
                told = set(stub_functions(stub.body))
                if "__init__" not in told:  # pybind11 has one that refuses
                    members.discard("__init__")
            with self.subTest(name):
                self.assertEqual(told, members)

    def test_the_same_arguments_as_every_function(self):
        compared = 0
        functions = [(roomwise, node) for node in stub_functions(STUB.body).values()]
        for name, stub in stub_classes().items():
            if name not in ("Error", "ErrorCode"):
                functions += [(getattr(roomwise, name), node) for node in stub_functions(stub.body).values()]
        for owner, stub in functions:
            there = inspect.getattr_static(owner, stub.name)
            if isinstance(there, property) or stub.name in SPECIAL - {"__init__"}:
                continue
            there = getattr(owner, stub.name)
            with self.subTest(f"{owner.__name__}.{stub.name}"):
                self.assertEqual(arguments_of(stub), arguments_of(native_function(there)))
                self.assertIn("Error", there.__doc__, "it says how it fails")
                compared += 1
        self.assertGreater(compared, 15)

    def test_everything_says_what_it_is(self):
        for name in roomwise.__all__:
            there = getattr(roomwise, name)
            self.assertTrue(there.__doc__ and there.__doc__.strip(), name)

    def test_things_belong_to_the_package(self):
        for name in stub_classes():
            self.assertEqual(getattr(roomwise, name).__module__, "roomwise", name)


if __name__ == "__main__":
    unittest.main()
