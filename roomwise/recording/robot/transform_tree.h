#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/timestamp.h"
#include "roomwise/recording/messages/messages.h"

namespace roomwise::recording {

// A transform as it changes over time.
class MovingTransform {
 public:
  struct Sample {
    TimestampNs timestamp_ns = 0;
    geometry::RigidTransform transform;
  };
  // Samples may come in any order until the first at(). Those of less than 10 ms after the last one
  // are left out.
  void add(TimestampNs timestamp_ns, const geometry::RigidTransform& transform);
  void sort();
  [[nodiscard]] bool moves() const { return moves_; }
  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  // Between two samples at most a second apart, or within 0.1 s of the first or last one; at any
  // time where it never moves. Nothing elsewhere.
  [[nodiscard]] std::optional<geometry::RigidTransform> at(TimestampNs timestamp_ns) const;

 private:
  std::vector<Sample> samples_;
  bool moves_ = false;
};

// Which frame of coordinates lies where in which other: a tree, as ROS's tf keeps it.
class TransformTree {
 public:
  // A frame has one parent, that of its first transform; others are passed over.
  void add(const TransformMessage& transform);
  // Before the first look.
  void sort();
  // The frame that has no parent above `frame`; itself where it has none or is unknown.
  [[nodiscard]] std::string root_of(const std::string& frame) const;
  // Whether a transform between them changes over time.
  [[nodiscard]] bool moves(const std::string& from, const std::string& to) const;
  // Takes points of `from` to `to`; nothing where the frames are not connected or a transform
  // between them is not known at that time.
  [[nodiscard]] std::optional<geometry::RigidTransform> look_up(const std::string& to,
                                                                const std::string& from,
                                                                TimestampNs timestamp_ns) const;

 private:
  struct Edge {
    std::string parent;
    MovingTransform parent_from_child;
  };
  // The frame and all above it, the root last.
  [[nodiscard]] std::vector<std::string> chain_of(const std::string& frame) const;
  [[nodiscard]] std::optional<geometry::RigidTransform> climb(const std::vector<std::string>& chain,
                                                              const std::string& ancestor,
                                                              TimestampNs timestamp_ns) const;

  std::map<std::string, Edge, std::less<>> edges_;  // by the child
};

}  // namespace roomwise::recording
