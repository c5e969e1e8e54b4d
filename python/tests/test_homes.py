"""A recording becomes a home; what a home says; how long work is told of and interrupted."""

import gc
import os
import pathlib
import shutil
import signal
import threading
import unittest
import unittest.mock

import numpy as np

import made_up
import roomwise

NETWORK = pathlib.Path(__file__).parents[2] / "models/roomwise-compact-2.onnx"
FRAMES = 40


class Homes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = made_up.scratch_folder()
        cls.walk = made_up.write_recording(cls.folder / "walk", FRAMES)
        cls.told = []
        cls.report = roomwise.map_recording(
            cls.walk,
            cls.folder / "my.home",
            networks=[NETWORK],
            threads=2,
            progress=lambda *news: cls.told.append(news),
        )
        cls.learned = roomwise.learn_rooms(cls.folder / "my.home", variants=0)
        cls.home = roomwise.open_home(cls.folder / "my.home")

    def test_mapping_reports_what_it_came_to(self):
        self.assertEqual((self.report.frames, self.report.placed), (FRAMES, FRAMES))
        self.assertEqual(self.report.keyframes, len(self.home.keyframes))
        self.assertGreater(self.report.keyframes, 10)
        self.assertEqual((self.report.components, self.report.walks), (1, 1))
        self.assertTrue(self.report.is_joined)
        self.assertEqual(self.report.damaged, [])

    def test_progress_tells_every_piece_of_work_from_its_beginning_to_its_end(self):
        mapping = [news for news in self.told if news[0] == "mapping"]
        self.assertEqual(mapping[0], ("mapping", 0, FRAMES, ""))
        self.assertEqual(mapping[-1][1:3], (FRAMES, FRAMES))
        self.assertIn("key-frames", mapping[-1][3])
        self.assertGreater(len({work for work, *_ in self.told}), 1)

    def test_the_trajectory_is_near_the_truth(self):
        estimate = self.home.trajectory()
        self.assertEqual(len(estimate), FRAMES)
        error = roomwise.absolute_trajectory_error(roomwise.read_truth(self.walk), estimate)
        self.assertLess(error.error_m.rmse, 0.01)
        of_walk = self.home.trajectory(self.home.walks[0])
        np.testing.assert_array_equal(of_walk.positions, estimate.positions)
        np.testing.assert_array_equal(self.home.trajectory("walk").positions, estimate.positions)
        with self.assertRaisesRegex(roomwise.Error, "evening"):
            self.home.trajectory("evening")
        with self.assertRaisesRegex(TypeError, "walk: expected a Walk"):
            self.home.trajectory(1)

    def test_walks_and_keyframes(self):
        (walk,) = self.home.walks
        self.assertEqual((walk.name, walk.path, walk.finished), ("walk", str(self.walk), True))
        self.assertEqual(walk.camera.width, made_up.WIDTH)
        for i, keyframe in enumerate(self.home.keyframes):
            self.assertEqual((keyframe.id, keyframe.walk, keyframe.component), (i, walk.id, 0))
            self.assertEqual(keyframe.timestamp_ns, (keyframe.frame_index + 1) * 100_000_000)
            pose = keyframe.world_from_camera
            np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)

    def test_a_keyframe_shows_its_frame(self):
        keyframe = self.home.keyframes[2]
        frame = self.home.frame(keyframe.id)
        self.assertEqual(frame.index, keyframe.frame_index)
        np.testing.assert_array_equal(frame.color, made_up.color_of(frame.index))
        np.testing.assert_array_equal(frame.depth, made_up.depth_of(frame.index))
        with self.assertRaisesRegex(roomwise.Error, "no key-frame 1000"):
            self.home.frame(1000)

    def test_the_cloud_is_the_wall(self):
        cloud = self.home.cloud(voxel_size_m=0.05)
        self.assertEqual(cloud.points.shape, (len(cloud), 3))
        self.assertEqual(cloud.colors.shape, (len(cloud), 3))
        self.assertGreater(len(cloud), 100)
        self.assertLess(abs(np.median(cloud.points[:, 2]) - made_up.WALL_M), 0.05)
        self.assertEqual(made_up.address_of(cloud.points), made_up.address_of(cloud.points))
        points = cloud.points
        self.assertIs(points.base, cloud)
        kept = points.copy()
        del cloud
        gc.collect()
        np.testing.assert_array_equal(points, kept)
        with self.assertRaisesRegex(ValueError, "voxel_size_m = 0"):
            self.home.cloud(voxel_size_m=0)
        with self.assertRaisesRegex(ValueError, "voxel_size_m = nan"):
            self.home.cloud(voxel_size_m=float("nan"))

    def test_rooms_are_those_of_the_recording(self):
        hall, kitchen = self.home.rooms
        self.assertEqual((hall.name, kitchen.name), ("hall", "kitchen"))
        (visit,) = kitchen.visits
        self.assertEqual((visit.first_frame, visit.last_frame, visit.visit), (FRAMES // 2, FRAMES - 1, 1))
        self.assertEqual(set(self.learned.rooms), {"hall", "kitchen"})
        self.assertGreater(self.learned.held_out, 0)

    def test_objects_are_a_list(self):
        self.assertEqual(self.home.objects, [])  # no detector has looked at a wall

    def test_the_pose_graph_of_the_map_can_be_optimised(self):
        graph = self.home.pose_graph()
        self.assertEqual(len(graph), len(self.home.keyframes))
        before = graph.error
        self.assertLessEqual(graph.optimize().error_after, before)

    def test_a_picture_is_found_on_the_map(self):
        localizer = self.home.localizer()
        depth = made_up.depth_of(9)
        found = localizer.locate(made_up.color_of(9), depth)
        self.assertTrue(found.found, found.status)
        near = self.home.trajectory().positions[9]
        np.testing.assert_allclose(found.world_from_camera[:3, 3], near, atol=0.02)
        self.assertLess(found.position_sigma_m, 0.05)
        self.assertIn(found.keyframe, range(len(self.home.keyframes)))
        # Metres, with NaN where nothing was measured, say the same.
        in_metres = np.where(depth == 0, np.nan, depth / 1000)
        for metres in in_metres, in_metres.astype(np.float32), np.asfortranarray(in_metres):
            again = localizer.locate(made_up.color_of(9), metres)
            np.testing.assert_array_equal(again.world_from_camera, found.world_from_camera)
        # So does a file, and a view of every second column of twice as many.
        path = next(iter(sorted(self.walk.glob("rgb/1.0*.png"))))
        again = localizer.locate(path, self.walk / "depth" / path.name)
        np.testing.assert_array_equal(again.world_from_camera, found.world_from_camera)
        wide = np.repeat(made_up.color_of(9), 2, axis=1)
        again = localizer.locate(wide[:, ::2], depth)
        np.testing.assert_array_equal(again.world_from_camera, found.world_from_camera)

    def test_a_picture_of_elsewhere_is_not_found(self):
        noise = np.random.default_rng(7).integers(0, 256, (made_up.HEIGHT, made_up.WIDTH, 3))
        found = self.home.localizer().locate(noise.astype(np.uint8))
        self.assertFalse(found.found)
        self.assertIsNone(found.world_from_camera)
        self.assertIsNone(found.position_sigma_m)
        self.assertTrue(found.status)

    def test_pictures_of_a_wrong_shape_or_dtype_are_named(self):
        localizer = self.home.localizer()
        color, depth = made_up.color_of(0), made_up.depth_of(0)
        far = np.full(depth.shape, 70.0)
        cases = [
            (TypeError, r"color: expected .*uint8.*got dtype float64", color / 255, depth),
            (TypeError, r"color: expected a NumPy array.*got list", color.tolist(), depth),
            (ValueError, r"color: .*\(height, width, 3\).*got shape \(240, 320\)", color[:, :, 0], depth),
            (ValueError, r"color: .*got shape \(240, 320, 4\)", np.dstack([color, color[:, :, 0]]), depth),
            (ValueError, r"color: the array of shape \(0, 320, 3\) is empty", color[:0], depth),
            (TypeError, r"depth: expected .*uint16.*got dtype int64", color, depth.astype(int)),
            (ValueError, r"depth: .*\(height, width\).*got shape \(240, 320, 1\)", color, depth[:, :, None]),
            (ValueError, r"depth: the array of shape \(240, 0\) is empty", color, depth[:, :0]),
            (ValueError, r"depth\[0, 0\] is 70.*65.535 m", color, far),
            (ValueError, r"depth\[0, 0\] is -70", color, -far),
            (ValueError, r"depth\[0, 0\] is inf", color, far * np.inf),
            (roomwise.Error, r"320.*240|160", color[:, :160].copy(), depth),
        ]
        for kind, text, *images in cases:
            with self.subTest(text), self.assertRaisesRegex(kind, text):
                localizer.locate(*images)

    def test_a_room_is_asked_from_one_picture_or_two(self):
        recognizer = self.home.recognizer(networks=[NETWORK])
        self.assertEqual(recognizer.rooms, ["hall", "kitchen"])
        for pictures in [made_up.color_of(5)], [made_up.color_of(5), made_up.color_of(6)]:
            answer = recognizer.recognize(*pictures)
            self.assertEqual(answer.rooms[0][0], "hall")
            self.assertAlmostEqual(sum(probability for _, probability in answer.rooms), 1)
            self.assertIn(answer.verdict, ("room", "either", "not sure", "none of them"))
            self.assertEqual(answer.room, "hall" if answer.verdict == "room" else None)
            self.assertTrue(answer.why)
        cold = recognizer.recognize(made_up.color_of(35, is_warm=False))
        self.assertEqual(cold.rooms[0][0], "kitchen")
        with self.assertRaisesRegex(ValueError, "one or more; got none"):
            recognizer.recognize()
        with self.assertRaisesRegex(ValueError, r"places=True"):
            recognizer.recognize(made_up.color_of(5), depths=[made_up.depth_of(5)])

    def test_a_place_on_the_map_helps_to_tell_a_room(self):
        recognizer = self.home.recognizer(networks=[NETWORK], places=True)
        answer = recognizer.recognize(made_up.color_of(5), depths=[made_up.depth_of(5)])
        self.assertEqual(answer.rooms[0][0], "hall")
        with self.assertRaisesRegex(ValueError, "depths: expected a list of 1"):
            recognizer.recognize(made_up.color_of(5), depths=[])

    def test_a_network_that_the_rooms_were_not_learned_with_is_no_use(self):
        with self.assertRaises(roomwise.Error):
            self.home.recognizer(networks=[])

    def test_answers_outlive_what_gave_them(self):
        recognizer = roomwise.open_home(self.folder / "my.home").recognizer(networks=[NETWORK])
        gc.collect()
        answer = recognizer.recognize(made_up.color_of(5))
        del recognizer
        gc.collect()
        self.assertEqual(answer.rooms[0][0], "hall")

    def test_more_threads_than_a_process_can_have_are_refused(self):
        with self.assertRaisesRegex(ValueError, "threads = 100000 must be 1 to 1024"):
            self.home.cloud(threads=100_000)

    def test_other_threads_of_python_go_on_during_long_work(self):
        done = threading.Event()
        other = threading.Thread(target=done.set)
        # The callback waits for another thread of Python, which needs the GIL.
        self.home.cloud(progress=lambda *news: (other.ident or other.start(), done.wait()))
        other.join()
        self.assertTrue(done.is_set())

    def test_ten_thousand_questions_keep_nothing(self):
        def ask(count):
            for _ in range(count):
                self.home.keyframes[0].world_from_camera, self.home.rooms

        ask(200)
        gc.collect()
        resident = made_up.resident_bytes()
        ask(10_000)
        gc.collect()
        self.assertLess(made_up.resident_bytes() - resident, 4 << 20)


class Interruptions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = made_up.scratch_folder()
        cls.walk = made_up.write_recording(cls.folder / "walk", 20)
        roomwise.map_recording(cls.walk, cls.folder / "whole.home", networks=[])
        cls.whole = roomwise.open_home(cls.folder / "whole.home").trajectory()

    def interrupted(self, name, stop, kind):
        """A home whose mapping was stopped by stop(done) before its end."""
        path = self.folder / name
        with self.assertRaises(kind):
            roomwise.map_recording(
                self.walk, path, networks=[], progress=lambda work, done, total, note: stop(done)
            )
        return path

    def test_ctrl_c_stops_at_once_and_leaves_nothing_of_a_home_without_frames(self):
        path = self.interrupted(
            "at-once.home", lambda done: signal.raise_signal(signal.SIGINT), KeyboardInterrupt
        )
        self.assertFalse(path.exists())

    def test_ctrl_c_keeps_what_was_mapped_and_it_goes_on_from_there(self):
        path = self.interrupted(
            "stopped.home",
            lambda done: signal.raise_signal(signal.SIGINT) if done >= 10 else None,
            KeyboardInterrupt,
        )
        (walk,) = roomwise.open_home(path).walks
        self.assertFalse(walk.finished)
        with self.assertRaisesRegex(roomwise.Error, "resume=True"):
            roomwise.map_recording(self.walk, path, networks=[])
        report = roomwise.map_recording(self.walk, path, networks=[], resume=True)
        self.assertEqual(report.frames, 20)
        resumed = roomwise.open_home(path).trajectory()
        np.testing.assert_array_equal(resumed.positions, self.whole.positions)

    def test_what_the_callback_raises_stops_the_work_and_comes_out(self):
        class Enough(Exception):
            pass

        def stop(done):
            raise Enough

        path = self.interrupted("enough.home", stop, Enough)
        self.assertFalse(path.exists())

    def test_any_number_of_threads_gives_the_same_bits(self):
        path = self.folder / "threads.home"
        roomwise.map_recording(self.walk, path, networks=[], threads=3)
        np.testing.assert_array_equal(
            roomwise.open_home(path).trajectory().positions, self.whole.positions
        )

    def test_a_wrong_recording_leaves_no_home(self):
        path = self.folder / "none.home"
        with self.assertRaises(roomwise.Error):
            roomwise.map_recording(self.folder / "nowhere", path)
        with self.assertRaisesRegex(roomwise.Error, "method|paper"):
            roomwise.map_recording(self.walk, path, method="guess")
        self.assertFalse(path.exists())

    def test_a_finished_home_is_not_resumed(self):
        with self.assertRaisesRegex(roomwise.Error, "is finished"):
            roomwise.map_recording(self.walk, self.folder / "whole.home", resume=True)

    def test_frames_that_cannot_be_read_are_left_out_where_that_is_asked(self):
        damaged = self.folder / "damaged"
        shutil.copytree(self.walk, damaged)
        (damaged / "rgb/0.500000.png").write_bytes(b"no picture")
        report = roomwise.map_recording(
            damaged, self.folder / "damaged.home", networks=[], skip_damaged=True
        )
        self.assertEqual(report.frames, 19)
        (text,) = report.damaged
        self.assertIn("0.500000.png", text)


class InstalledNetworks(unittest.TestCase):
    def test_where_no_other_is_installed_the_one_that_comes_with_roomwise_looks(self):
        folder = made_up.scratch_folder()
        walk = made_up.write_recording(folder / "walk", FRAMES)
        (folder / "nothing").mkdir()
        nowhere = {"ROOMWISE_MODELS": str(folder / "nothing"), "XDG_DATA_HOME": str(folder / "nothing")}
        with unittest.mock.patch.dict(os.environ, nowhere):
            roomwise.map_recording(walk, folder / "my.home")
            roomwise.learn_rooms(folder / "my.home", variants=0)
            recognizer = roomwise.open_home(folder / "my.home").recognizer()
            self.assertEqual(recognizer.recognize(made_up.color_of(5)).rooms[0][0], "hall")


class ProtectedHomes(unittest.TestCase):
    def test_pictures_are_seen_with_the_passphrase_alone(self):
        folder = made_up.scratch_folder()
        walk = made_up.write_recording(folder / "walk", 6)
        roomwise.map_recording(walk, folder / "my.home", networks=[], passphrase="open sesame")
        locked = roomwise.open_home(folder / "my.home")
        self.assertTrue(locked.is_locked)
        self.assertGreater(len(locked.keyframes), 0)
        with self.assertRaisesRegex(roomwise.Error, "passphrase"):
            locked.frame(0)
        opened = roomwise.open_home(folder / "my.home", passphrase="open sesame")
        self.assertFalse(opened.is_locked)
        np.testing.assert_array_equal(opened.frame(0).color, made_up.color_of(0))
        with self.assertRaises(roomwise.Error):
            roomwise.open_home(folder / "my.home", passphrase="open barley")
        with self.assertRaisesRegex(TypeError, "passphrase: expected a str"):
            roomwise.open_home(folder / "my.home", passphrase=7)


if __name__ == "__main__":
    unittest.main()
