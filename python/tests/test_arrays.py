"""Arrays show the library's memory and keep it alive; they are never copied behind one's back."""

import gc
import sys
import unittest

import numpy as np

import made_up
import roomwise


class FramesAsArrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.recording = roomwise.read_recording(made_up.write_recording(made_up.scratch_folder() / "walk"))

    def test_images_are_what_the_files_hold(self):
        for i, frame in enumerate(self.recording):
            np.testing.assert_array_equal(frame.color, made_up.color_of(i, is_warm=i < 4))
            np.testing.assert_array_equal(frame.depth, made_up.depth_of(i))
        self.assertEqual((frame.color.dtype, frame.depth.dtype), (np.uint8, np.uint16))

    def test_asking_twice_gives_the_same_memory(self):
        frame = self.recording[0]
        for name in "color", "depth":
            first, second = getattr(frame, name), getattr(frame, name)
            self.assertIsNot(first, second)
            self.assertEqual(made_up.address_of(first), made_up.address_of(second), name)
            self.assertFalse(first.flags.owndata)
            self.assertTrue(first.flags.c_contiguous)
            self.assertIs(first.base, frame)

    def test_views_cannot_be_written(self):
        frame = self.recording[0]
        for array in frame.color, frame.depth:
            with self.assertRaises(ValueError):
                array[0, 0] = 1
            array.copy()[0, 0] = 1

    def test_a_view_keeps_its_frame_alive(self):
        frame = self.recording[3]
        color = frame.color
        address = made_up.address_of(color)
        before = sys.getrefcount(frame)
        self.assertGreaterEqual(before, 3)  # `frame`, the argument, the view
        del frame
        gc.collect()
        self.assertEqual(made_up.address_of(color), address)
        np.testing.assert_array_equal(color, made_up.color_of(3))

    def test_a_frame_outlives_its_recording(self):
        recording = roomwise.read_recording(made_up.write_recording(made_up.scratch_folder() / "walk"))
        iterator = iter(recording)
        del recording
        gc.collect()
        frame = next(iterator)
        del iterator
        gc.collect()
        np.testing.assert_array_equal(frame.color, made_up.color_of(0))

    def test_metres_are_not_a_number_where_nothing_was_measured(self):
        frame = self.recording[0]
        self.assertEqual(frame.depth_m.dtype, np.float32)
        np.testing.assert_array_equal(np.isnan(frame.depth_m), frame.depth == 0)
        self.assertEqual(np.nanmax(frame.depth_m), np.float32(made_up.WALL_M))
        self.assertTrue(frame.depth_m.flags.owndata)

    def test_a_recording_is_a_sequence(self):
        self.assertEqual(len(self.recording), 8)
        self.assertEqual(self.recording[-1].index, 7)
        self.assertEqual(self.recording[-1].timestamp_ns, 800_000_000)
        self.assertAlmostEqual(self.recording[-1].time_s, 0.8)
        self.assertEqual([frame.index for frame in self.recording], list(range(8)))
        self.assertEqual([frame.index for frame in self.recording], list(range(8)))  # anew
        for i in 8, -9:
            with self.assertRaisesRegex(IndexError, "has 8 frames"):
                self.recording[i]

    def test_intrinsics(self):
        camera = self.recording[0].camera
        self.assertEqual(camera, self.recording.camera)
        np.testing.assert_array_equal(camera.matrix, [[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]])
        self.assertEqual(camera.distortion, (0, 0, 0, 0, 0))
        self.assertEqual(roomwise.Camera.named("fr1").width, 640)
        self.assertNotEqual(camera, roomwise.Camera.named("fr1"))

    def test_ten_thousand_calls_keep_nothing(self):
        frame = self.recording[0]

        def calls(count):
            for _ in range(count):
                frame.color, frame.depth, frame.camera.matrix  # noqa: B018

        calls(1000)
        gc.collect()
        references, resident = sys.getrefcount(frame), made_up.resident_bytes()
        calls(10_000)
        gc.collect()
        self.assertEqual(sys.getrefcount(frame), references)
        # A leak of the smallest array object alone would be 10,000 times 100 bytes, three times over.
        self.assertLess(made_up.resident_bytes() - resident, 1 << 20)

    def test_metres_and_decoded_frames_are_given_back(self):
        for _ in range(20):
            self.recording[0].depth_m
        gc.collect()
        resident = made_up.resident_bytes()
        for _ in range(400):  # 0.7 MB each
            self.recording[0].depth_m
        gc.collect()
        self.assertLess(made_up.resident_bytes() - resident, 16 << 20)


class TrajectoriesAsArrays(unittest.TestCase):
    @staticmethod
    def moved(count):
        positions = np.arange(3.0 * count).reshape(count, 3)
        quaternions = np.tile([0.0, 0, 0, 1], (count, 1))
        return roomwise.Trajectory(np.arange(count), positions, quaternions)

    def test_members_are_views_of_one_memory(self):
        trajectory = self.moved(5)
        for name in "timestamps_ns", "positions", "quaternions":
            first, second = getattr(trajectory, name), getattr(trajectory, name)
            self.assertEqual(made_up.address_of(first), made_up.address_of(second), name)
            self.assertIs(first.base, trajectory)
            self.assertFalse(first.flags.writeable)
        np.testing.assert_array_equal(trajectory.positions[4], [12, 13, 14])
        np.testing.assert_array_equal(trajectory.world_from_camera[4][:3, 3], [12, 13, 14])

    def test_a_view_keeps_its_trajectory_alive(self):
        positions = self.moved(1000).positions
        gc.collect()
        np.testing.assert_array_equal(positions[-1], [2997, 2998, 2999])

    def test_of_no_poses_arrays_are_empty(self):
        trajectory = self.moved(0)
        self.assertEqual(len(trajectory), 0)
        self.assertEqual(trajectory.timestamps_ns.shape, (0,))
        self.assertEqual(trajectory.positions.shape, (0, 3))
        self.assertEqual(trajectory.quaternions.shape, (0, 4))
        self.assertEqual(trajectory.world_from_camera.shape, (0, 4, 4))

    def test_any_real_numbers_in_any_order_in_memory_are_taken(self):
        positions = np.asfortranarray(np.arange(6, dtype=np.int32).reshape(2, 3))
        turned = np.array([[0, 0, 0, 2], [0, 0, 0, 1]], dtype=np.float32)
        trajectory = roomwise.Trajectory(np.array([1, 2], dtype=np.uint8), positions, turned)
        np.testing.assert_array_equal(trajectory.positions, positions)
        np.testing.assert_array_equal(trajectory.quaternions[0], [0, 0, 0, 1])

    def test_writing_and_reading_gives_the_same(self):
        path = made_up.scratch_folder() / "trajectory.txt"
        trajectory = self.moved(4)
        trajectory.write(path)
        np.testing.assert_allclose(roomwise.Trajectory.read(path).positions, trajectory.positions)

    def test_ten_thousand_trajectories_are_given_back(self):
        def calls(count):
            for _ in range(count):
                self.moved(50).positions

        calls(500)
        gc.collect()
        resident = made_up.resident_bytes()
        calls(10_000)  # 3 kB each
        gc.collect()
        self.assertLess(made_up.resident_bytes() - resident, 4 << 20)


class ErrorsOfTrajectories(unittest.TestCase):
    def test_absolute_and_relative_error(self):
        count = 40
        times = np.arange(count) * 100_000_000
        places = np.stack([np.sin(0.1 * np.arange(count)), 0.2 * np.arange(count), np.zeros(count)], 1)
        straight = np.tile([0.0, 0, 0, 1], (count, 1))
        truth = roomwise.Trajectory(times, places, straight)
        moved = roomwise.Trajectory(times, places + [5, 6, 7], straight)
        error = roomwise.absolute_trajectory_error(truth, moved)
        self.assertLess(error.error_m.rmse, 1e-9)
        np.testing.assert_allclose(error.truth_from_estimate[:3, 3], [-5, -6, -7], atol=1e-9)
        np.testing.assert_allclose(error.truth, error.estimate, atol=1e-9)
        np.testing.assert_array_equal(error.timestamps_ns, times)
        self.assertIs(error.truth.base, error)
        drift = roomwise.relative_pose_error(truth, moved, delta=1.0)
        self.assertLess(drift.translation_m.rmse, 1e-9)
        self.assertGreater(drift.count, 0)

    def test_a_stretched_estimate_has_an_error_and_a_scale(self):
        count = 10
        times = np.arange(count)
        places = np.random.default_rng(1).normal(size=(count, 3))
        straight = np.tile([0.0, 0, 0, 1], (count, 1))
        truth = roomwise.Trajectory(times, places, straight)
        stretched = roomwise.Trajectory(times, 2 * places, straight)
        error = roomwise.absolute_trajectory_error(truth, stretched)
        self.assertGreater(error.error_m.rmse, 0.1)
        self.assertAlmostEqual(error.best_scale, 0.5)
        self.assertLess(error.scaled_rmse_m, 1e-9)


if __name__ == "__main__":
    unittest.main()
