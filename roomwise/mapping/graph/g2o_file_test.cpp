#include "roomwise/mapping/graph/g2o_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

const std::string kInformation = " 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6";
const std::string kTwoNodes =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 5 1 2 3 0 0 0.6 0.8\n";

class G2oFile : public ::testing::Test {
 protected:
  Expected<PoseGraph> read(const std::string& text) {
    const auto path = folder_ / "graph.g2o";
    if (auto written = write_file(path, text); !written) return Unexpected(written.error());
    return read_g2o(path);
  }
  roomwise::testing::ScratchFolder folder_;
};

TEST_F(G2oFile, IsReadAsG2oDefinesIt) {
  const auto graph = read("# a comment\n\n" + kTwoNodes + "FIX 0\n" +
                          "EDGE_SE3:QUAT 0 5  -1 1e-3 .5  0 0 0 1 " + kInformation + "\r\n");
  ASSERT_OK(graph);
  ASSERT_EQ(graph->world_from_node.size(), 2);
  const RigidTransform& pose = graph->world_from_node.at(5);
  EXPECT_EQ(pose.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pose.rotation.coeffs(), Eigen::Vector4d(0, 0, 0.6, 0.8));
  ASSERT_EQ(graph->edges.size(), 1);
  const PoseGraphEdge& edge = graph->edges[0];
  EXPECT_EQ(edge.from, 0);
  EXPECT_EQ(edge.to, 5);
  EXPECT_EQ(edge.from_from_to.translation, Eigen::Vector3d(-1, 1e-3, 0.5));
  Vector6d diagonal;
  diagonal << 1, 2, 3, 4, 5, 6;
  EXPECT_EQ(edge.information, Matrix6d(diagonal.asDiagonal()));
}

TEST_F(G2oFile, AnEdgeThatSkipsANodeIsALoop) {
  const std::string pose = " 0 0 0 0 0 0 1";
  std::string text;
  for (const char* id : {"1", "4", "6"}) text += "VERTEX_SE3:QUAT " + std::string(id) + pose + "\n";
  for (const char* ids : {"1 4", "4 6", "1 6", "6 4"}) {
    text += "EDGE_SE3:QUAT " + std::string(ids) + pose + kInformation + "\n";
  }
  const auto graph = read(text);
  ASSERT_OK(graph);
  EXPECT_FALSE(graph->edges[0].is_robust);
  EXPECT_FALSE(graph->edges[1].is_robust);
  EXPECT_TRUE(graph->edges[2].is_robust);
  EXPECT_TRUE(graph->edges[3].is_robust);
}

TEST_F(G2oFile, RoundedQuaternionsBecomeUnitLength) {
  const auto graph = read("VERTEX_SE3:QUAT 0 0 0 0 0.1 0.2 0.3 0.9273\n");
  ASSERT_OK(graph);
  EXPECT_NEAR(graph->world_from_node.at(0).rotation.norm(), 1, 1e-15);
}

TEST_F(G2oFile, WritingAndReadingLosesNothing) {
  RandomStream random(11);
  PoseGraph graph;
  const auto random_transform = [&] {
    Vector6d twist;
    for (double& value : twist) value = random.normal();
    return RigidTransform::exp(twist);
  };
  constexpr NodeId kNodes = 200;
  for (NodeId id = 0; id < kNodes; ++id) graph.world_from_node[3 * id] = random_transform();
  for (NodeId id = 0; id + 2 < kNodes; ++id) {
    Matrix6d root;
    for (double& value : root.reshaped()) value = random.normal();
    Matrix6d information = root * root.transpose();
    information = information.selfadjointView<Eigen::Upper>();
    const NodeId to = id % 2 == 0 ? id + 1 : id + 2;
    graph.edges.push_back({3 * id, 3 * to, random_transform(), information, id % 2 != 0});
  }
  const auto path = folder_ / "round_trip.g2o";
  ASSERT_OK(write_g2o(path, graph));
  const auto read_back = read_g2o(path);
  ASSERT_OK(read_back);
  ASSERT_EQ(read_back->world_from_node.size(), graph.world_from_node.size());
  for (const auto& [id, pose] : graph.world_from_node) {
    EXPECT_EQ(read_back->world_from_node.at(id).translation, pose.translation);
    EXPECT_EQ(read_back->world_from_node.at(id).rotation.coeffs(), pose.rotation.coeffs());
  }
  ASSERT_EQ(read_back->edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseGraphEdge& edge = graph.edges[i];
    const PoseGraphEdge& other = read_back->edges[i];
    EXPECT_EQ(other.from, edge.from);
    EXPECT_EQ(other.to, edge.to);
    EXPECT_EQ(other.from_from_to.translation, edge.from_from_to.translation);
    EXPECT_EQ(other.from_from_to.rotation.coeffs(), edge.from_from_to.rotation.coeffs());
    EXPECT_EQ(other.information, edge.information);
    EXPECT_EQ(other.is_robust, edge.is_robust);
  }
}

TEST_F(G2oFile, NamesTheLineThatIsWrong) {
  const std::string pose = " 0 0 0 0 0 0 1";
  const auto third_line = [&](const std::string& line) { return read(kTwoNodes + line + "\n"); };
  EXPECT_ERROR(third_line("VERTEX_SE2 1 0 0 0"), "graph.g2o:3: 'VERTEX_SE2' is not known");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 7 0 0 0 0 0 0"), ":3: the line ends before the quat");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 7 0 0 nan 0 0 0 1"), "'nan'; expected a finite number");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 7 0 0 1e999 0 0 0 1"), "'1e999'; expected a number");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 7 0 0 1m 0 0 0 1"), "'1m'; expected a number");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT -7" + pose), "the node is '-7'");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 7 0 0 0 0 0 0 0"), "quaternion has length 0");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 5" + pose), "graph.g2o:3: node 5 is given twice");
  EXPECT_ERROR(third_line("VERTEX_SE3:QUAT 7" + pose + " 0"), "'0' stands after the last number");
  EXPECT_ERROR(third_line("EDGE_SE3:QUAT 0 5" + pose + " 1 0 0"), "before the information matrix");
  EXPECT_ERROR(third_line("EDGE_SE3:QUAT 0 6" + pose + kInformation), ":3: the edge needs node 6");
  EXPECT_ERROR(third_line("FIX 5"), "graph.g2o:3: FIX names node 5");
  EXPECT_ERROR(third_line("FIX 0\nFIX 5"), "graph.g2o:4: a second node is held still");
}

TEST_F(G2oFile, AnEmptyOrMissingFileIsAnError) {
  EXPECT_ERROR(read("# nothing\n"), "graph.g2o: holds no VERTEX_SE3:QUAT line");
  EXPECT_ERROR(read_g2o(folder_ / "absent.g2o"), "absent.g2o");
}

}  // namespace
}  // namespace roomwise::mapping
