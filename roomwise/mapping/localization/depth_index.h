#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "roomwise/base/plain_bytes.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/rgbd_pyramid.h"

namespace roomwise::mapping {

// Which key-frames' depth images look like one: the same by lamp light as by day, and on walls
// without any feature. Depth images of some twenty pixels across are compared pixel by pixel, also
// shifted against each other, as if the camera had turned a little. Views must not be empty, and
// all of one camera. What a question costs grows with the number of views: about 10 microseconds
// each.
class DepthIndex {
 public:
  struct Hit {
    std::size_t index = 0;  // in the order of adding
    double unlike = 0;      // 0: the same, 1: nothing in common
    // How the camera was turned, about: no more is known of the motion.
    geometry::RigidTransform indexed_from_query;
  };

  void add(const motion::RgbdPyramid& view);
  // The `most` views that look most like one, best first; of equals the earlier.
  // Those in `left_out`, by index, are as if they were not there.
  [[nodiscard]] std::vector<Hit> find(const motion::RgbdPyramid& view, std::size_t most,
                                      const std::vector<bool>& left_out = {}) const;
  [[nodiscard]] std::size_t size() const { return thumbnails_.size(); }

  // Only these, ascending, stay, and are numbered anew.
  void keep_only(std::span<const std::size_t> kept);

  // The index as plain bytes and back.
  void write(PlainWriter& writer) const;
  [[nodiscard]] std::size_t written_bytes() const;
  void read(PlainReader& reader);

 private:
  // Metres, a row after another; 0 where nothing was measured.
  using Thumbnail = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  [[nodiscard]] static Thumbnail shrink(const motion::PyramidLevel& level);

  std::vector<Thumbnail> thumbnails_;
};

}  // namespace roomwise::mapping
