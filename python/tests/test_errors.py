"""What fails says what is wrong and how to mend it."""

import os
import pathlib
import unittest

import numpy as np

import made_up
import roomwise


class Failures(unittest.TestCase):
    def test_what_fails_in_normal_use_is_an_error_with_a_code(self):
        with self.assertRaisesRegex(roomwise.Error, "no/such/walk") as raised:
            roomwise.read_recording("no/such/walk")
        self.assertIs(raised.exception.code, roomwise.ErrorCode.FAILED)
        self.assertIsInstance(raised.exception, Exception)
        self.assertNotIsInstance(raised.exception, ValueError)

    def test_a_name_that_is_no_utf_8_is_told_as_python_tells_it(self):
        path = os.fsdecode(bytes(made_up.scratch_folder()) + b"/w\xff")
        with self.assertRaises(roomwise.Error) as raised:
            roomwise.read_recording(path)
        self.assertIn(path, str(raised.exception))
        made_up.write_recording(pathlib.Path(path), frames=1)
        self.assertEqual(len(roomwise.read_recording(path)), 1)

    def test_a_file_that_is_no_home_is_an_error(self):
        path = made_up.scratch_folder() / "not.home"
        path.write_text("no home")
        with self.assertRaisesRegex(roomwise.Error, "not.home"):
            roomwise.open_home(path)
        with self.assertRaisesRegex(roomwise.Error, "missing.home"):
            roomwise.open_home(path.with_name("missing.home"))

    def test_a_line_that_is_wrong_is_named(self):
        path = made_up.scratch_folder() / "trajectory.txt"
        path.write_text("1 0 0 0 0 0 0 1\n2 0 0 zero 0 0 0 1\n3 0 0 0 0 0 0 1\n")
        with self.assertRaisesRegex(roomwise.Error, r"trajectory.txt:2.*zero"):
            roomwise.Trajectory.read(path)

    def test_a_damaged_picture_is_named_and_the_next_frame_comes(self):
        folder = made_up.write_recording(made_up.scratch_folder() / "walk", frames=3)
        (folder / "rgb/0.200000.png").write_bytes(b"no picture")
        frames = iter(roomwise.read_recording(folder))
        self.assertEqual(next(frames).index, 0)
        with self.assertRaisesRegex(roomwise.Error, "0.200000.png"):
            next(frames)
        self.assertEqual(next(frames).index, 2)
        with self.assertRaises(StopIteration):
            next(frames)

    def test_a_camera_that_cannot_be_is_an_error(self):
        with self.assertRaisesRegex(roomwise.Error, "fx|focal"):
            roomwise.Camera(fx=-1, fy=300, cx=160, cy=120, width=320, height=240)
        with self.assertRaisesRegex(roomwise.Error, "fr9"):
            roomwise.Camera.named("fr9")

    def test_trajectories_that_do_not_overlap_are_an_error(self):
        straight = np.tile([0.0, 0, 0, 1], (4, 1))
        places = np.random.default_rng(1).normal(size=(4, 3))
        early = roomwise.Trajectory(np.arange(4), places, straight)
        late = roomwise.Trajectory(np.arange(4) + 10**12, places, straight)
        empty = roomwise.Trajectory(np.arange(0), np.zeros((0, 3)), np.zeros((0, 4)))
        for other in late, empty:
            with self.assertRaises(roomwise.Error):
                roomwise.absolute_trajectory_error(early, other)

    def test_an_error_can_be_raised_and_caught_as_others(self):
        try:
            raise roomwise.Error("no", roomwise.ErrorCode.REFUSED)
        except roomwise.Error as error:
            self.assertEqual(str(error), "no")
            self.assertIs(error.code, roomwise.ErrorCode.REFUSED)


class WrongArguments(unittest.TestCase):
    def test_a_path_may_be_a_str_or_a_path_and_nothing_else(self):
        folder = made_up.write_recording(made_up.scratch_folder() / "walk", frames=1)
        for path in folder, str(folder), bytes(folder):
            if isinstance(path, bytes):
                with self.assertRaisesRegex(TypeError, "path: expected a path"):
                    roomwise.read_recording(path)
            else:
                self.assertEqual(len(roomwise.read_recording(path)), 1)
        with self.assertRaisesRegex(TypeError, "path: expected a path .* got int"):
            roomwise.read_recording(3)

    def test_a_camera_of_a_wrong_type_is_named(self):
        with self.assertRaisesRegex(TypeError, "camera: expected a Camera.*got float"):
            roomwise.read_recording(pathlib.Path("walk"), camera=0.5)

    def test_arrays_of_a_trajectory_name_what_is_wrong(self):
        times, places, turns = np.arange(2), np.zeros((2, 3)), np.tile([0.0, 0, 0, 1], (2, 1))
        cases = [
            (ValueError, r"positions: expected .*\(2, 3\).*got shape \(2, 2\)", times, places[:, :2], turns),
            (ValueError, r"quaternions: expected .*\(2, 4\).*got shape \(1, 4\)", times, places, turns[:1]),
            (TypeError, r"positions: expected .*real.*got dtype complex128", times, places + 0j, turns),
            (TypeError, r"timestamps_ns: .*whole.*got dtype float64", times / 2, places, turns),
            (TypeError, r"positions: expected a NumPy array.*got list", times, places.tolist(), turns),
            (ValueError, r"pose 1: expected a later time", np.array([5, 5]), places, turns),
            (ValueError, r"pose 0: .*finite", times, places * np.nan, turns),
            (ValueError, r"pose 0: .*quaternion that has a length", times, places, 0 * turns),
        ]
        for kind, text, *arguments in cases:
            with self.subTest(text), self.assertRaisesRegex(kind, text):
                roomwise.Trajectory(*arguments)

    def test_a_number_of_threads_below_none_is_named(self):
        with self.assertRaisesRegex(ValueError, "threads = -1"):
            roomwise.map_recording("walk", "my.home", threads=-1)

    def test_networks_are_a_list(self):
        for networks in "one.onnx", 3:
            with self.assertRaisesRegex(TypeError, "networks: expected a list"):
                roomwise.map_recording("walk", "my.home", networks=networks)

    def test_progress_must_be_callable(self):
        with self.assertRaisesRegex(TypeError, "progress: expected a function"):
            roomwise.map_recording("walk", "my.home", progress=1)


if __name__ == "__main__":
    unittest.main()
