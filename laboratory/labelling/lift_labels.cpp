#include "laboratory/labelling/lift_labels.h"

#include <algorithm>
#include <cstdlib>

namespace roomwise::labelling {
namespace {

constexpr TimestampNs kMaxApart_ns = 20'000'000;

std::optional<geometry::RigidTransform> pose_at(const recording::Trajectory& truth,
                                                TimestampNs timestamp_ns) {
  const auto apart = [&](const recording::StampedPose& pose) {
    return std::abs(pose.timestamp_ns - timestamp_ns);
  };
  const auto nearest = std::ranges::min_element(truth, {}, apart);
  if (nearest == truth.end() || apart(*nearest) > kMaxApart_ns) return std::nullopt;
  return nearest->world_from_camera;
}

// A box of one camera's picture in the picture of another that looks the same way.
network::PixelBox seen_by(const geometry::PinholeCamera& other,
                          const geometry::PinholeCamera& camera, const network::PixelBox& box) {
  const auto seen = [&](float x, float y) {
    return other.project(camera.unproject({x, y}, 1)).cast<float>().eval();
  };
  const Eigen::Vector2f first = seen(box.left, box.top), last = seen(box.right, box.bottom);
  return {first.x(), first.y(), last.x(), last.y()};
}

Expected<std::optional<PlacedView>> place(const LabelledView& view,
                                          const recording::Recording& recording,
                                          const recording::Trajectory& truth) {
  constexpr float kOver_px = 1;  // a border that was drawn on the picture's own
  const recording::RecordedPicture* picture = recording.find(view.frame);
  if (picture == nullptr) {
    return fail("frame {}: the recording has no such picture among its {}", view.frame,
                recording.pictures().size());
  }
  const geometry::PinholeCamera camera = recording.original_camera(*picture);
  if (view.box.left < -kOver_px || view.box.top < -kOver_px ||
      view.box.right > static_cast<float>(camera.width) + kOver_px ||
      view.box.bottom > static_cast<float>(camera.height) + kOver_px) {
    return fail("frame {}: its box leaves the picture of {}x{}", view.frame, camera.width,
                camera.height);
  }
  const auto pose = pose_at(truth, picture->timestamp_ns);
  if (!pose) return std::nullopt;
  PlacedView placed{view.box, view.cut, view.is_occluded, camera, *pose, std::nullopt};
  ROOMWISE_TRY(const auto frame, recording.frame(view.frame));
  if (frame) {
    const geometry::PinholeCamera& of_frame = recording.info().camera;
    placed.depth_m = depth_in_middle_m(frame->depth, of_frame, seen_by(of_frame, camera, view.box));
  }
  return placed;
}

}  // namespace

Expected<LiftedLabels> lift_labels(const ReaderLabels& labels,
                                   const recording::Recording& recording,
                                   const recording::Trajectory& truth) {
  if (labels.recording != recording.info().name) {
    return fail("labels of {} do not belong to {}; give that recording's", labels.recording,
                recording.info().name);
  }
  LiftedLabels lifted{labels.recording, labels.reader, {}, {}};
  for (const LabelledThing& thing : labels.things) {
    std::vector<PlacedView> views;
    for (const LabelledView& view : thing.views) {
      const auto placed = place(view, recording, truth);
      if (!placed) return fail("thing {} ({}), {}", thing.id, thing.name, placed.error().message);
      if (*placed) views.push_back(**placed);
    }
    if (const auto in_space = lift(views)) {
      lifted.things.emplace_back(thing, *in_space);
    } else {
      lifted.not_lifted.push_back(thing);
    }
  }
  return lifted;
}

}  // namespace roomwise::labelling
