#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "roomwise/guide/places/obstacle.h"
#include "roomwise/guide/places/places.h"
#include "roomwise/live/recording/frame_images.h"
#include "roomwise/live/view/home_view.h"
#include "roomwise/mapping/localization/lens_calibration.h"
#include "roomwise/mapping/localization/place_track.h"
#include "roomwise/pipeline/rooms/turn_hint.h"

namespace roomwise::live {

// Where a device's camera is, by the map.
struct CameraPose {
  geometry::RigidTransform plan_from_camera;
  double sigma_m = 0;               // of the position, along the direction that is known worst
  std::optional<std::string> room;  // by the layout

  [[nodiscard]] Eigen::Vector3d position_plan() const { return plan_from_camera.translation; }
  // Of the optical axis over the floor, counter-clockwise from x, rad.
  [[nodiscard]] double heading_rad() const;
  [[nodiscard]] guide::Pose on_floor() const;
};

// A thing that somebody taught, in a picture.
struct SeenOwnThing {
  home::OwnThingId id = 0;
  std::optional<Eigen::Vector3d> place_plan;  // its middle, where depth and the map tell it
  std::optional<std::string> room;            // of the thing, else of the camera
};

// What one frame told.
struct FrameResult {
  double t_ms = 0;  // of the frame, by the device's clock
  // Nothing where no rooms were learned.
  std::optional<rooms::RoomDecision> decision;
  std::optional<pipeline::Side> more_to_see;  // where the room is not sure
  std::optional<CameraPose> place;
  // Of a camera that nobody calibrated, what is known of its lens, where this frame told of it.
  std::optional<mapping::LensCalibration> lens;
  bool has_depth = false;  // the frame has; else nothing tells what is ahead now
  std::optional<guide::ObstacleAhead> obstacle;  // in the way of who goes where they face, by depth
  // How far ahead of them depth shows anything in their way, m, as far as obstacles are looked for.
  std::optional<double> seen_ahead_m;
  // What a person could walk into, seen by depth: where on the floor, on the plan; none where
  // there is no place.
  std::vector<Eigen::Vector2d> obstacles;
  std::vector<SeenOwnThing> own_things;  // looked for once a second at most
  Bytes picture;                         // as the device sent it
  // For questions about the picture itself; it goes with the next one and is never stored.
  std::shared_ptr<const FrameImages> images;
};

// Looks at the frames of one device, one after the other, and remembers what it saw: the room is
// said by the whole walk. Not thread-safe.
class FrameProcessor {
 public:
  // `lens`: what is known of it where the camera is not calibrated.
  explicit FrameProcessor(std::optional<service::DeviceCamera> camera,
                          mapping::LensCalibration lens = {})
      : camera_(std::move(camera)), lens_(std::move(lens)) {}

  // Fails on pictures that cannot be read or are not of the camera's size; the next frame is looked
  // at as if this one had not been.
  [[nodiscard]] Expected<FrameResult> look(CameraFrame frame,
                                           const std::shared_ptr<const HomeView>& home);

 private:
  // `answer`: the localiser's; nothing where it was not asked.
  [[nodiscard]] Expected<std::optional<rooms::RoomDecision>> decide(
      const image::ColorImage& color, const std::optional<mapping::Localization>& answer,
      bool has_depth, const std::shared_ptr<const HomeView>& home);
  [[nodiscard]] Expected<void> look_for_own_things(const FrameImages& images, const HomeView& home,
                                                   FrameResult& result);
  // Nothing where the home has no map.
  [[nodiscard]] Expected<std::optional<mapping::Localization>> locate(
      const image::ColorImage& color, const std::optional<image::DepthImage>& depth,
      const HomeView& home, FrameResult& result);

  std::optional<service::DeviceCamera> camera_;
  mapping::LensCalibration lens_;
  // Belongs to the recognizer with which it was made.
  std::optional<rooms::RoomStream> stream_;
  std::shared_ptr<const pipeline::RoomRecognizer> stream_recognizer_;
  // Since the first picture. By the device's clock or the computer's, whichever tells of more: a
  // device's may stand, be coarse or go back, and frames may come late and all at once.
  double passed_s_ = 0;
  struct Times {
    double t_ms = 0, came_s = 0;
  };
  std::optional<Times> last_;        // picture
  std::optional<double> decided_s_;  // when a picture last told of rooms
  // Of a calibrated camera, on the map of that localiser.
  mapping::PlaceTrack track_;
  std::shared_ptr<const pipeline::HomeLocalizer> track_localizer_;
  std::optional<double> looked_for_own_s_;
};

}  // namespace roomwise::live
