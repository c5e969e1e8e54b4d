#include "python/bindings/graphs.h"

#include <pybind11/stl.h>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/long_work.h"
#include "roomwise/mapping/graph/g2o_file.h"

namespace roomwise::python {
namespace {

using mapping::PoseGraphEdge;
using mapping::PoseGraphReport;

// The nodes' numbers as given, or 0, 1, 2, ...
std::vector<mapping::NodeId> nodes_of(const py::object& nodes, std::size_t count) {
  std::vector<mapping::NodeId> ids(count);
  for (std::size_t i = 0; i < count; ++i) ids[i] = i;
  if (nodes.is_none()) return ids;
  const auto given =
      whole_array(nodes, {static_cast<py::ssize_t>(count)}, fmt::format("({},)", count), "nodes");
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t id = given.at(static_cast<py::ssize_t>(i));
    if (id < 0) throw py::value_error(fmt::format("nodes[{}] is {}; expected 0 or more", i, id));
    ids[i] = static_cast<mapping::NodeId>(id);
  }
  return ids;
}

// Omega of every edge: the identity where none is given.
std::vector<geometry::Matrix6d> information_of(const py::object& information, py::ssize_t count) {
  std::vector<geometry::Matrix6d> all(static_cast<std::size_t>(count),
                                      geometry::Matrix6d::Identity());
  if (information.is_none()) return all;
  const auto given =
      real_array(information, {count, 6, 6}, fmt::format("({}, 6, 6)", count), "information");
  for (py::ssize_t i = 0; i < count; ++i) {
    all[static_cast<std::size_t>(i)] =
        Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(given.data(i));
  }
  return all;
}

std::vector<bool> loops_of(const py::object& is_loop, py::ssize_t count) {
  std::vector<bool> all(static_cast<std::size_t>(count), false);
  if (is_loop.is_none()) return all;
  const bool is_right = py::isinstance<py::array_t<bool>>(is_loop);
  const auto given = is_right ? py::array_t<bool>(is_loop) : py::array_t<bool>();
  if (!is_right || given.ndim() != 1 || given.shape(0) != count) {
    throw py::value_error(
        fmt::format("is_loop: expected a NumPy array of shape ({},) and dtype bool", count));
  }
  for (py::ssize_t i = 0; i < count; ++i) all[static_cast<std::size_t>(i)] = given.at(i);
  return all;
}

PoseGraph graph_of(const py::object& world_from_node, const py::object& edges,
                   const py::object& from_from_to, const py::object& information,
                   const py::object& is_loop, const py::object& nodes) {
  PoseGraph graph;
  const auto poses = transforms_of(world_from_node, "world_from_node");
  const auto ids = nodes_of(nodes, poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!graph.graph.world_from_node.emplace(ids[i], poses[i]).second) {
      throw py::value_error(fmt::format("nodes[{}] is {}, which is there already", i, ids[i]));
    }
  }
  const auto ends = whole_array(edges, {-1, 2}, "(M, 2)", "edges");
  const py::ssize_t count = ends.shape(0);
  const auto measured = transforms_of(from_from_to, "from_from_to");
  if (static_cast<py::ssize_t>(measured.size()) != count) {
    throw py::value_error(
        fmt::format("from_from_to: expected shape ({}, 4, 4), a measurement an "
                    "edge; got {} of them",
                    count, measured.size()));
  }
  const auto omegas = information_of(information, count);
  const auto loops = loops_of(is_loop, count);
  for (py::ssize_t i = 0; i < count; ++i) {
    const auto place = static_cast<std::size_t>(i);
    if (ends.at(i, 0) < 0 || ends.at(i, 1) < 0) {
      throw py::value_error(fmt::format("edges[{}] names a node below 0", i));
    }
    for (const py::ssize_t end : {0, 1}) {
      if (!graph.graph.world_from_node.contains(static_cast<mapping::NodeId>(ends.at(i, end)))) {
        throw py::value_error(
            fmt::format("edges[{}] names node {}, which is not there", i, ends.at(i, end)));
      }
    }
    if (ends.at(i, 0) == ends.at(i, 1)) {
      throw py::value_error(
          fmt::format("edges[{}] leads from node {} to itself", i, ends.at(i, 0)));
    }
    graph.graph.edges.push_back({static_cast<mapping::NodeId>(ends.at(i, 0)),
                                 static_cast<mapping::NodeId>(ends.at(i, 1)), measured[place],
                                 omegas[place], loops[place]});
  }
  return graph;
}

py::array_t<std::int64_t> nodes_as_array(const PoseGraph& graph) {
  py::array_t<std::int64_t> nodes(static_cast<py::ssize_t>(graph.graph.world_from_node.size()));
  std::int64_t* to = nodes.mutable_data();
  for (const auto& [id, pose] : graph.graph.world_from_node) *to++ = static_cast<std::int64_t>(id);
  return nodes;
}

py::array_t<double> poses_as_array(const PoseGraph& graph) {
  std::vector<geometry::RigidTransform> poses;
  for (const auto& [id, pose] : graph.graph.world_from_node) poses.push_back(pose);
  return matrices_of(poses);
}

py::array_t<std::int64_t> edges_as_array(const PoseGraph& graph) {
  py::array_t<std::int64_t> ends(
      {static_cast<py::ssize_t>(graph.graph.edges.size()), py::ssize_t{2}});
  std::int64_t* to = ends.mutable_data();
  for (const PoseGraphEdge& edge : graph.graph.edges) {
    *to++ = static_cast<std::int64_t>(edge.from);
    *to++ = static_cast<std::int64_t>(edge.to);
  }
  return ends;
}

py::array_t<double> measurements_as_array(const PoseGraph& graph) {
  std::vector<geometry::RigidTransform> measured;
  for (const PoseGraphEdge& edge : graph.graph.edges) measured.push_back(edge.from_from_to);
  return matrices_of(measured);
}

// Omega is symmetric, so that it lies as NumPy reads it.
py::array information_view(const py::object& self) {
  const auto& edges = self.cast<const PoseGraph&>().graph.edges;
  constexpr auto kNumber = static_cast<py::ssize_t>(sizeof(double));
  return view(edges.empty() ? nullptr : edges.front().information.data(),
              {static_cast<py::ssize_t>(edges.size()), 6, 6},
              {static_cast<py::ssize_t>(sizeof(PoseGraphEdge)), 6 * kNumber, kNumber}, self);
}

py::array loops_view(const py::object& self) {
  const auto& edges = self.cast<const PoseGraph&>().graph.edges;
  return view(edges.empty() ? nullptr : &edges.front().is_robust,
              {static_cast<py::ssize_t>(edges.size())},
              {static_cast<py::ssize_t>(sizeof(PoseGraphEdge))}, self);
}

double error_of(const PoseGraph& graph) {
  for (const PoseGraphEdge& edge : graph.graph.edges) {
    for (const mapping::NodeId end : {edge.from, edge.to}) {
      if (!graph.graph.world_from_node.contains(end)) {
        raise({fmt::format("an edge leads from node {} to node {}, and there is no node {}",
                           edge.from, edge.to, end)});
      }
    }
  }
  return mapping::pose_graph_chi2(graph.graph);
}

PoseGraphReport optimize(PoseGraph& graph, int max_iterations, double relative_tolerance,
                         double loop_kernel) {
  mapping::PoseGraphOptions options;
  options.max_iterations = max_iterations;
  options.relative_tolerance = relative_tolerance;
  options.loop_kernel = loop_kernel;
  value_of(options.validate());
  // Of a copy, since Python may look at the graph meanwhile.
  mapping::PoseGraph moved = graph.graph;
  const PoseGraphReport report = run_long(
      [&](const Progress& progress) { return mapping::optimize(moved, options, progress); });
  graph.graph.world_from_node = std::move(moved.world_from_node);
  return report;
}

}  // namespace

void bind_graphs(py::module_& module) {
  py::class_<PoseGraphReport>(module, "OptimizationReport", "What optimising a pose graph came to.")
      .def_readonly("error_before", &PoseGraphReport::error_before, "F at the start")
      .def_readonly("error_after", &PoseGraphReport::error_after, "F at the end")
      .def_readonly("iterations", &PoseGraphReport::iterations)
      .def_readonly("indefinite_edges", &PoseGraphReport::indefinite_edges,
                    "Edges whose information is not positive semi-definite; where it is negative "
                    "they were taken to say nothing")
      .def_property_readonly(
          "converged",
          [](const PoseGraphReport& report) {
            return report.termination == geometry::Termination::kConverged;
          },
          "False: the poses are the best so far");
  py::class_<PoseGraph>(
      module, "PoseGraph",
      "Poses of nodes, and measurements of one relative to another. The error that is squared is "
      "that of g2o's EDGE_SE3:QUAT: translation in m, then the vector part of the unit quaternion.")
      .def(py::init(&graph_of), py::arg("world_from_node"), py::arg("edges"),
           py::arg("from_from_to"), py::arg("information") = py::none(),
           py::arg("is_loop") = py::none(), py::arg("nodes") = py::none(),
           "Of arrays, which are copied: (N, 4, 4) poses of nodes in one world, m; (M, 2) nodes "
           "that an edge leads from "
           "and to; (M, 4, 4) measurements, the second node's pose in the first's frame, m; (M, 6, "
           "6) information in the order x y z qx qy qz "
           "(default: the identity); (M,) bool, whether an edge is a loop closure, which gets the "
           "robust kernel (default: none); (N,) the nodes' numbers (default: 0, 1, 2, ...). "
           "TypeError or ValueError names the array that is none of these.")
      .def_static(
          "read",
          [](const py::object& path) {
            const std::filesystem::path file = path_of(path, "path");
            return PoseGraph{run_without_gil([&] { return mapping::read_g2o(file); })};
          },
          py::arg("path"),
          "g2o's text format (VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX); Error names the line.")
      .def(
          "write",
          [](const PoseGraph& self, const py::object& path) {
            value_of(mapping::write_g2o(path_of(path, "path"), self.graph));
          },
          py::arg("path"),
          "As a .g2o file; reading gives the same bits. Error where it cannot be written.")
      .def("optimize", &optimize, py::arg("max_iterations") = 100,
           py::arg("relative_tolerance") = 1e-9, py::arg("loop_kernel") = 0.0,
           "Moves the poses to a minimum of F; the lowest node of each connected part stays. The "
           "same graph gives the same bits. loop_kernel: e^T Omega e of a loop closure above which "
           "it counts less and less (0: never). Error, which names node or edge and leaves the "
           "graph as it was, where it cannot be optimised. Ctrl-C stops it at the next iteration "
           "and leaves the graph as it was.")
      .def_property_readonly("error", &error_of,
                             "F: the sum of e^T Omega e over all edges, without kernels; Error "
                             "where an edge has no node")
      .def_property_readonly("nodes", &nodes_as_array, "(N,) int64, ascending")
      .def_property_readonly("world_from_node", &poses_as_array,
                             "(N, 4, 4) float64 m, in the order of nodes: made anew at each call")
      .def_property_readonly("edges", &edges_as_array, "(M, 2) int64: made anew at each call")
      .def_property_readonly("from_from_to", &measurements_as_array,
                             "(M, 4, 4) float64 m: made anew at each call")
      .def_property_readonly("information", &information_view, "(M, 6, 6) float64, a view")
      .def_property_readonly("is_loop", &loops_view, "(M,) bool, a view")
      .def("__len__", [](const PoseGraph& self) { return self.graph.world_from_node.size(); })
      .def("__repr__", [](const PoseGraph& self) {
        return fmt::format("<roomwise.PoseGraph of {} poses and {} edges>",
                           self.graph.world_from_node.size(), self.graph.edges.size());
      });
}

}  // namespace roomwise::python
