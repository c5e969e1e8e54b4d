#include "roomwise/mapping/graph/g2o_file.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "roomwise/base/file.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;

constexpr std::string_view kBlanks = " \t\r";

// The line's words, taken one after the other.
class Tokenizer {
 public:
  explicit Tokenizer(std::string_view line) : rest_(line.substr(0, line.find('#'))) {}

  // Empty at the end of the line.
  std::string_view next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
    rest_.remove_prefix(word.size());
    return word;
  }

  template <typename Number>
  Expected<Number> number(std::string_view what) {
    const std::string_view word = next();
    if (word.empty()) return fail("the line ends before {}", what);
    Number value{};
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (status != std::errc() || end != word.data() + word.size()) {
      return fail("{} is '{}'; expected a number", what, word);
    }
    if constexpr (std::is_floating_point_v<Number>) {
      if (!std::isfinite(value)) return fail("{} is '{}'; expected a finite number", what, word);
    }
    return value;
  }

  Expected<void> end() {
    if (const std::string_view word = next(); !word.empty()) {
      return fail("'{}' stands after the last number", word);
    }
    return {};
  }

 private:
  std::string_view rest_;
};

Expected<RigidTransform> parse_transform(Tokenizer& words) {
  RigidTransform transform;
  for (int i = 0; i < 3; ++i) {
    ROOMWISE_TRY(transform.translation(i), words.number<double>("the translation"));
  }
  for (int i = 0; i < 4; ++i) {
    ROOMWISE_TRY(transform.rotation.coeffs()(i), words.number<double>("the quaternion"));
  }
  const double length = transform.rotation.norm();
  constexpr double kShortest = 0.5;
  if (!(length > kShortest && length < 1 / kShortest)) {
    return fail("the quaternion has length {}; expected 1", length);
  }
  // Files round their quaternions. One that is of unit length up to rounding stays as it is, so
  // that writing and reading a graph loses nothing.
  constexpr double kUnit = 1e-14;
  if (std::abs(length - 1) > kUnit) transform.rotation.normalize();
  return transform;
}

Expected<Matrix6d> parse_information(Tokenizer& words) {
  Matrix6d information;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      ROOMWISE_TRY(information(row, column), words.number<double>("the information matrix"));
      information(column, row) = information(row, column);
    }
  }
  return information;
}

// What the lines of a file say; complete() checks what only the whole file can tell.
class Reader {
 public:
  Expected<void> read_line(std::size_t number, std::string_view line) {
    Tokenizer words(line);
    const std::string_view type = words.next();
    if (type.empty()) return {};
    if (type == "VERTEX_SE3:QUAT") return read_vertex(words);
    if (type == "EDGE_SE3:QUAT") return read_edge(words, number);
    if (type == "FIX") return read_fix(words, number);
    return fail("'{}' is not known; expected VERTEX_SE3:QUAT, EDGE_SE3:QUAT or FIX", type);
  }

  // The error names the line itself.
  Expected<PoseGraph> complete() && {
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      PoseGraphEdge& edge = graph_.edges[i];
      for (const NodeId id : {edge.from, edge.to}) {
        if (!graph_.world_from_node.contains(id)) {
          return fail("{}: the edge needs node {}, which the file does not hold", edge_lines_[i],
                      id);
        }
      }
      // What does not join consecutive nodes is a loop closure, which may be wrong.
      edge.is_robust = !is_next(edge.from, edge.to);
    }
    if (fixed_ && (graph_.world_from_node.empty() ||
                   fixed_->first != graph_.world_from_node.begin()->first)) {
      return fail("{}: FIX names node {}; only the lowest node can be held still", fixed_->second,
                  fixed_->first);
    }
    return std::move(graph_);
  }

 private:
  Expected<void> read_vertex(Tokenizer& words) {
    ROOMWISE_TRY(const NodeId id, words.number<NodeId>("the node"));
    ROOMWISE_TRY(const RigidTransform pose, parse_transform(words));
    ROOMWISE_RETURN_IF_ERROR(words.end());
    if (!graph_.world_from_node.emplace(id, pose).second) return fail("node {} is given twice", id);
    return {};
  }

  Expected<void> read_edge(Tokenizer& words, std::size_t line) {
    PoseGraphEdge edge;
    ROOMWISE_TRY(edge.from, words.number<NodeId>("the first node"));
    ROOMWISE_TRY(edge.to, words.number<NodeId>("the second node"));
    ROOMWISE_TRY(edge.from_from_to, parse_transform(words));
    ROOMWISE_TRY(edge.information, parse_information(words));
    ROOMWISE_RETURN_IF_ERROR(words.end());
    graph_.edges.push_back(edge);
    edge_lines_.push_back(line);
    return {};
  }

  Expected<void> read_fix(Tokenizer& words, std::size_t line) {
    ROOMWISE_TRY(const NodeId id, words.number<NodeId>("the node"));
    ROOMWISE_RETURN_IF_ERROR(words.end());
    if (fixed_ && fixed_->first != id) return fail("a second node is held still; expected one FIX");
    fixed_ = {id, line};
    return {};
  }

  [[nodiscard]] bool is_next(NodeId from, NodeId to) const {
    const auto next = std::next(graph_.world_from_node.find(from));
    return next != graph_.world_from_node.end() && next->first == to;
  }

  PoseGraph graph_;
  std::vector<std::size_t> edge_lines_;                  // where each edge stands, for errors
  std::optional<std::pair<NodeId, std::size_t>> fixed_;  // node and line
};

// Shortest decimals that read back as the same numbers.
void append(std::string& text, const RigidTransform& transform) {
  for (const double value : transform.translation) text += fmt::format(" {}", value);
  for (const double value : transform.rotation.coeffs()) text += fmt::format(" {}", value);
}

}  // namespace

Expected<PoseGraph> read_g2o(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  Reader reader;
  std::string_view rest = text;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    if (auto read = reader.read_line(number, line); !read) {
      return Unexpected(
          std::move(read).error().with_context(fmt::format("{}:{}", path.string(), number)));
    }
  }
  auto graph = std::move(reader).complete();
  if (!graph) return fail("{}:{}", path.string(), graph.error().message);
  if (graph->world_from_node.empty())
    return fail("{}: holds no VERTEX_SE3:QUAT line", path.string());
  return graph;
}

Expected<void> write_g2o(const std::filesystem::path& path, const PoseGraph& graph) {
  std::string text;
  for (const auto& [id, pose] : graph.world_from_node) {
    text += fmt::format("VERTEX_SE3:QUAT {}", id);
    append(text, pose);
    text += '\n';
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    text += fmt::format("EDGE_SE3:QUAT {} {}", edge.from, edge.to);
    append(text, edge.from_from_to);
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        text += fmt::format(" {}", edge.information(row, column));
      }
    }
    text += '\n';
  }
  return write_file(path, text);
}

}  // namespace roomwise::mapping
