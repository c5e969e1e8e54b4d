"""Which interpreter the package is built for, and that what cmake --install puts somewhere can be imported."""

import os
import pathlib
import subprocess
import sys
import unittest

import made_up

ROOT = pathlib.Path(__file__).parents[2]
DEBIANS = pathlib.Path("/usr/bin/python3")


class Installed(unittest.TestCase):
    @unittest.skipUnless("ROOMWISE_BUILD" in os.environ, "run it by ctest")
    def test_the_package_alone_is_installed_and_says_its_version(self):
        prefix = made_up.scratch_folder()
        cmake, build = os.environ["ROOMWISE_CMAKE"], os.environ["ROOMWISE_BUILD"]
        command = [cmake, "--install", build, "--component", "python", "--prefix", str(prefix)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        self.assertEqual([path.name for path in prefix.iterdir()], ["lib"])
        (package,) = prefix.glob("lib/*/dist-packages/roomwise")
        files = {path.name for path in package.iterdir()}
        self.assertLessEqual({"__init__.py", "__init__.pyi", "_errors.py", "py.typed"}, files)
        code = (
            "import importlib.metadata, roomwise; print(roomwise.__file__); "
            "print(roomwise.__version__ == importlib.metadata.version('roomwise'))"
        )
        environment = {**os.environ, "PYTHONPATH": str(package.parent)}
        said = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
        self.assertEqual(said.stdout.split(), [str(package / "__init__.py"), "True"])

    @unittest.skipUnless("ROOMWISE_BUILD" in os.environ and DEBIANS.exists(), "run it by ctest, on Debian")
    def test_a_first_build_takes_debians_though_others_come_first_in_the_path(self):
        scratch = made_up.scratch_folder()
        other = scratch / "other"  # an interpreter without NumPy, an old node and a foreign library
        subprocess.run([DEBIANS, "-m", "venv", "--without-pip", other], check=True)
        node = other / "bin/node"
        node.write_text("#!/bin/sh\necho v16.20.0\n")
        node.chmod(0o755)
        for package in ("fmt", "pybind11"):
            (other / "lib/cmake" / package).mkdir(parents=True)
            (other / "lib/cmake" / package / f"{package}-config.cmake").write_text('message(FATAL_ERROR "not Debian\'s")')
        path = f"{other / 'bin'}{os.pathsep}{os.environ['PATH']}"
        build = scratch / "build"
        command = [os.environ["ROOMWISE_CMAKE"], "--preset", "release", "-B", build]
        configured = subprocess.run(command, cwd=ROOT, env={**os.environ, "PATH": path}, capture_output=True, text=True)
        self.assertEqual(configured.returncode, 0, configured.stderr)
        cache = (build / "CMakeCache.txt").read_text()
        self.assertIn(f"Python_EXECUTABLE:FILEPATH={DEBIANS}\n", cache)
        self.assertNotIn(f"={node}\n", cache)


if __name__ == "__main__":
    unittest.main()
