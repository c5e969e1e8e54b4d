"""Pose graphs from arrays and from g2o's text."""

import signal
import unittest

import numpy as np

import made_up
import roomwise


def step(x_m, y_m=0.0, turn_rad=0.0):
    """1 m ahead and a quarter turn about y, as in examples/2_optimize_a_pose_graph.cpp."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    return np.array([[c, 0, s, 0.05], [0, 1, 0, y_m], [-s, 0, c, x_m], [0, 0, 0, 1.0]])


def square():
    """A walk around a square, and a surer loop closure that says 10 cm lower."""
    around = step(1.0, turn_rad=np.pi / 2)
    poses = [np.eye(4)]
    for _ in range(4):
        poses.append(poses[-1] @ around)
    loop = poses[4].copy()
    loop[:3, 3] = 0, 0.1, 0
    information = np.stack([100 * np.eye(6)] * 4 + [1000 * np.eye(6)])
    return dict(
        world_from_node=np.stack(poses),
        edges=np.array([[0, 1], [1, 2], [2, 3], [3, 4], [0, 4]]),
        from_from_to=np.stack([around] * 4 + [loop]),
        information=information,
        is_loop=np.array([False] * 4 + [True]),
    )


class PoseGraphs(unittest.TestCase):
    def test_optimising_spreads_the_difference_over_the_steps(self):
        graph = roomwise.PoseGraph(**square())
        before = graph.error
        report = graph.optimize()
        self.assertTrue(report.converged)
        self.assertAlmostEqual(report.error_before, before)
        self.assertAlmostEqual(report.error_after, graph.error)
        self.assertLess(report.error_after, before / 3)
        heights = graph.world_from_node[:, 1, 3]
        self.assertEqual(heights[0], 0)
        self.assertTrue(np.all(np.diff(heights) > 0), heights)
        self.assertAlmostEqual(heights[4], 0.1, places=2)

    def test_the_same_graph_gives_the_same_bits(self):
        first, second = (roomwise.PoseGraph(**square()) for _ in range(2))
        first.optimize()
        second.optimize()
        np.testing.assert_array_equal(first.world_from_node, second.world_from_node)

    def test_what_was_given_comes_back(self):
        given = square()
        graph = roomwise.PoseGraph(**given)
        np.testing.assert_allclose(graph.world_from_node, given["world_from_node"], atol=1e-12)
        np.testing.assert_allclose(graph.from_from_to, given["from_from_to"], atol=1e-12)
        for name in "edges", "information", "is_loop":
            np.testing.assert_array_equal(getattr(graph, name), given[name])
        np.testing.assert_array_equal(graph.nodes, np.arange(5))
        self.assertIs(graph.information.base, graph)
        self.assertEqual(
            made_up.address_of(graph.information), made_up.address_of(graph.information)
        )

    def test_nodes_may_have_any_numbers(self):
        given = square()
        given["edges"] = 10 * given["edges"] + 3
        graph = roomwise.PoseGraph(**given, nodes=10 * np.arange(5) + 3)
        np.testing.assert_array_equal(graph.nodes, [3, 13, 23, 33, 43])
        self.assertTrue(graph.optimize().converged)

    def test_writing_and_reading_gives_the_same_bits(self):
        path = made_up.scratch_folder() / "square.g2o"
        graph = roomwise.PoseGraph(**square())
        graph.write(path)
        read = roomwise.PoseGraph.read(path)
        np.testing.assert_array_equal(read.world_from_node, graph.world_from_node)
        np.testing.assert_array_equal(read.information, graph.information)
        self.assertEqual(read.error, graph.error)

    def test_a_line_of_a_file_that_is_wrong_is_named(self):
        path = made_up.scratch_folder() / "bad.g2o"
        path.write_text("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE2 1 0 0 0\n")
        with self.assertRaisesRegex(roomwise.Error, "bad.g2o:2"):
            roomwise.PoseGraph.read(path)

    def test_edges_that_cannot_be_are_refused_at_once(self):
        for wrong, message in (([0, 7], r"edges\[4\] names node 7, which is not there"),
                               ([1, 1], r"edges\[4\] leads from node 1 to itself")):
            given = square()
            given["edges"][4] = wrong
            with self.assertRaisesRegex(ValueError, message):
                roomwise.PoseGraph(**given)

    def test_an_edge_of_a_file_to_a_node_that_is_not_there_is_named(self):
        path = made_up.scratch_folder() / "loose.g2o"
        roomwise.PoseGraph(**square()).write(path)
        lines = path.read_text().splitlines()
        path.write_text("\n".join(line for line in lines if not line.startswith("VERTEX_SE3:QUAT 4 ")) + "\n")
        with self.assertRaisesRegex(roomwise.Error, "loose.g2o:8: the edge needs node 4"):
            roomwise.PoseGraph.read(path)

    def test_wrong_arrays_are_named(self):
        changes = [
            (ValueError, r"world_from_node: .*\(N, 4, 4\).*got shape \(5, 3, 4\)",
             "world_from_node", lambda a: a[:, :3]),
            (ValueError, r"world_from_node\[0\] is no rigid transform", "world_from_node", lambda a: 2 * a),
            (ValueError, r"from_from_to\[0\] is no rigid transform", "from_from_to", lambda a: a * np.nan),
            (ValueError, r"from_from_to: expected shape \(5, 4, 4\).*got 4", "from_from_to", lambda a: a[:4]),
            (TypeError, r"edges: .*whole numbers; got dtype float64", "edges", lambda a: a * 1.0),
            (ValueError, r"edges\[0\] names a node below 0", "edges", lambda a: a - 1),
            (ValueError, r"information: .*\(5, 6, 6\).*got shape \(4, 6, 6\)", "information", lambda a: a[1:]),
            (ValueError, r"is_loop: .*bool", "is_loop", lambda a: a.astype(int)),
        ]
        for kind, text, name, change in changes:
            given = square()
            given[name] = change(given[name])
            with self.subTest(text), self.assertRaisesRegex(kind, text):
                roomwise.PoseGraph(**given)
        with self.assertRaisesRegex(ValueError, r"nodes\[1\] is 7, which is there already"):
            roomwise.PoseGraph(**square(), nodes=np.full(5, 7))

    def test_options_are_checked(self):
        with self.assertRaisesRegex(roomwise.Error, "max_iterations"):
            roomwise.PoseGraph(**square()).optimize(max_iterations=-1)

    def test_ctrl_c_stops_it_and_leaves_the_graph_as_it_was(self):
        # A long chain whose loop closures contradict it: it takes many iterations.
        count = 3000
        random = np.random.default_rng(1)
        poses = np.stack([np.eye(4)] * count)
        poses[:, 2, 3] = np.arange(count)
        ends = np.array([[i, i + 1] for i in range(count - 1)] + [[i, count - 1 - i] for i in range(count // 2)])
        steps = np.stack([np.eye(4)] * len(ends))
        steps[:, :3, 3] = random.normal(0, 10, (len(ends), 3))
        graph = roomwise.PoseGraph(poses, ends, steps)
        # However soon the signal comes, and though all were done by then, it counts.
        signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
        with self.assertRaises(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, 0.001)
            graph.optimize(max_iterations=1_000_000, relative_tolerance=1e-300)
        np.testing.assert_array_equal(graph.world_from_node, poses)

    def test_of_nothing_arrays_are_empty(self):
        graph = roomwise.PoseGraph(np.zeros((0, 4, 4)), np.zeros((0, 2), dtype=int), np.zeros((0, 4, 4)))
        self.assertEqual((len(graph), graph.error), (0, 0))
        self.assertEqual(graph.edges.shape, (0, 2))
        self.assertEqual(graph.information.shape, (0, 6, 6))
        self.assertEqual(graph.is_loop.shape, (0,))


if __name__ == "__main__":
    unittest.main()
