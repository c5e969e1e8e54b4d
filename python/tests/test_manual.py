"""The examples of docs/python.md, on real recordings, give what it says they give."""

import doctest
import os
import pathlib
import unittest

import made_up

MANUAL = pathlib.Path(__file__).parents[2] / "docs/python.md"
DATA = pathlib.Path(os.environ.get("ROOMWISE_DATA", "nowhere"))


class Manual(unittest.TestCase):
    @unittest.skipUnless((DATA / "tum_fr1_desk_9frames").is_dir(), "set ROOMWISE_DATA to the folder of real data")
    def test_its_examples_hold(self):
        globs = {"data": DATA, "folder": made_up.scratch_folder(), "root": MANUAL.parents[1]}
        failed, tried = doctest.testfile(
            str(MANUAL),
            module_relative=False,
            globs=globs,
            optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE,
        )
        self.assertEqual(failed, 0)
        self.assertGreater(tried, 20)


if __name__ == "__main__":
    unittest.main()
