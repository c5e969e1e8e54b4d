#include "roomwise/recording/robot/transform_tree.h"

#include <algorithm>

namespace roomwise::recording {
namespace {

constexpr TimestampNs kMillisecond = 1'000'000;
constexpr TimestampNs kDenseEnough = 10 * kMillisecond;
constexpr TimestampNs kLongestGap = 1000 * kMillisecond;
constexpr TimestampNs kBeyondEnds = 100 * kMillisecond;
constexpr double kSame = 1e-9;
constexpr std::size_t kMaxChain = 100;  // frames above one another; more is a circle

bool is_same(const geometry::RigidTransform& a, const geometry::RigidTransform& b) {
  return (a.translation - b.translation).norm() < kSame &&
         std::abs(std::abs(a.rotation.dot(b.rotation)) - 1) < kSame;
}

geometry::RigidTransform mix(const MovingTransform::Sample& a, const MovingTransform::Sample& b,
                             TimestampNs time) {
  const double part = static_cast<double>(time - a.timestamp_ns) /
                      static_cast<double>(b.timestamp_ns - a.timestamp_ns);
  return {a.transform.rotation.slerp(part, b.transform.rotation),
          (1 - part) * a.transform.translation + part * b.transform.translation};
}

}  // namespace

void MovingTransform::add(TimestampNs timestamp_ns, const geometry::RigidTransform& transform) {
  if (!samples_.empty()) {
    moves_ = moves_ || !is_same(samples_.front().transform, transform);
    const TimestampNs since = timestamp_ns - samples_.back().timestamp_ns;
    if (since >= 0 && since < kDenseEnough) return;
    // What stands still needs no sample that at() can do without.
    const auto joins = [&](const Sample& kept) {
      return std::abs(timestamp_ns - kept.timestamp_ns) <= kLongestGap;
    };
    if (!moves_ && samples_.size() > 1 && joins(samples_.end()[-2])) samples_.pop_back();
  }
  samples_.push_back({timestamp_ns, transform});
}

void MovingTransform::sort() {
  std::ranges::stable_sort(samples_, {}, &Sample::timestamp_ns);
}

std::optional<geometry::RigidTransform> MovingTransform::at(TimestampNs timestamp_ns) const {
  if (samples_.empty()) return std::nullopt;
  if (!moves_) return samples_.front().transform;
  const auto after = std::ranges::lower_bound(samples_, timestamp_ns, {}, &Sample::timestamp_ns);
  if (after != samples_.end() && after->timestamp_ns == timestamp_ns) return after->transform;
  if (after == samples_.begin()) {
    return after->timestamp_ns - timestamp_ns <= kBeyondEnds ? std::optional(after->transform)
                                                             : std::nullopt;
  }
  const Sample& before = *std::prev(after);
  if (after == samples_.end()) {
    return timestamp_ns - before.timestamp_ns <= kBeyondEnds ? std::optional(before.transform)
                                                             : std::nullopt;
  }
  if (after->timestamp_ns - before.timestamp_ns > kLongestGap) return std::nullopt;
  return mix(before, *after, timestamp_ns);
}

void TransformTree::add(const TransformMessage& transform) {
  const auto [edge, is_new] = edges_.try_emplace(transform.child, Edge{transform.header.frame, {}});
  if (!is_new && edge->second.parent != transform.header.frame) return;
  edge->second.parent_from_child.add(transform.header.timestamp_ns, transform.parent_from_child);
}

void TransformTree::sort() {
  for (auto& [child, edge] : edges_) edge.parent_from_child.sort();
}

std::vector<std::string> TransformTree::chain_of(const std::string& frame) const {
  std::vector<std::string> chain{frame};
  for (auto edge = edges_.find(frame); edge != edges_.end() && chain.size() < kMaxChain;
       edge = edges_.find(chain.back())) {
    chain.push_back(edge->second.parent);
  }
  return chain;
}

std::string TransformTree::root_of(const std::string& frame) const {
  return chain_of(frame).back();
}

bool TransformTree::moves(const std::string& from, const std::string& to) const {
  const auto up_from = chain_of(from), up_to = chain_of(to);
  const auto moves_above = [&](const auto& chain, const auto& other) {
    for (const std::string& frame : chain) {
      if (std::ranges::find(other, frame) != other.end()) return false;
      const auto edge = edges_.find(frame);
      if (edge != edges_.end() && edge->second.parent_from_child.moves()) return true;
    }
    return false;
  };
  return moves_above(up_from, up_to) || moves_above(up_to, up_from);
}

std::optional<geometry::RigidTransform> TransformTree::climb(const std::vector<std::string>& chain,
                                                             const std::string& ancestor,
                                                             TimestampNs timestamp_ns) const {
  geometry::RigidTransform ancestor_from_frame;
  for (const std::string& frame : chain) {
    if (frame == ancestor) return ancestor_from_frame;
    const auto step = edges_.find(frame)->second.parent_from_child.at(timestamp_ns);
    if (!step) return std::nullopt;
    ancestor_from_frame = *step * ancestor_from_frame;
  }
  return std::nullopt;
}

std::optional<geometry::RigidTransform> TransformTree::look_up(const std::string& to,
                                                               const std::string& from,
                                                               TimestampNs timestamp_ns) const {
  const auto up_from = chain_of(from), up_to = chain_of(to);
  const auto common = std::ranges::find_if(up_from, [&](const std::string& frame) {
    return std::ranges::find(up_to, frame) != up_to.end();
  });
  if (common == up_from.end()) return std::nullopt;
  const auto common_from_source = climb(up_from, *common, timestamp_ns);
  const auto common_from_target = climb(up_to, *common, timestamp_ns);
  if (!common_from_source || !common_from_target) return std::nullopt;
  return common_from_target->inverse() * *common_from_source;
}

}  // namespace roomwise::recording
