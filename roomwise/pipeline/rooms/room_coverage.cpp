#include "roomwise/pipeline/rooms/room_coverage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

using fusion::FloorCell;

// ---- light ----

struct PictureTone {
  double brightness = 0;     // mean, 0 to 1
  double red_over_blue = 1;  // of the means
};

PictureTone tone_of(const image::ColorImage& picture) {
  constexpr int kStep_px = 8;  // a sample tells the mean as well
  double red = 0, green = 0, blue = 0, count = 0;
  for (int y = 0; y < picture.height(); y += kStep_px) {
    for (int x = 0; x < picture.width(); x += kStep_px) {
      const Rgb8 color = picture.at(x, y);
      red += color.r;
      green += color.g;
      blue += color.b;
      ++count;
    }
  }
  // As image::to_gray() weighs them (ITU-R BT.601).
  const double gray = 0.299 * red + 0.587 * green + 0.114 * blue;
  return {gray / (255 * count), (red + count) / (blue + count)};
}

std::array<double, 3> quartiles(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return {at(0.25), at(0.5), at(0.75)};
}

RoomLight light_of(const std::vector<PictureTone>& tones) {
  std::vector<double> brightness, red_over_blue;
  for (const PictureTone& tone : tones) {
    brightness.push_back(tone.brightness);
    red_over_blue.push_back(tone.red_over_blue);
  }
  const auto [b_low, b, b_high] = quartiles(std::move(brightness));
  const auto [r_low, r, r_high] = quartiles(std::move(red_over_blue));
  return {b, b_low, b_high, r, r_low, r_high};
}

Expected<void> add_lights(const home::Home& home, const std::vector<home::Keyframe>& keyframes,
                          const KeyframeRooms& rooms, std::vector<RoomSeen>& seen,
                          RunContext& run) {
  std::vector<home::Keyframe> named;
  for (const home::Keyframe& one : keyframes) {
    if (rooms.contains(one.id)) named.push_back(one);
  }
  std::map<std::pair<std::string, home::RecordingId>, std::vector<PictureTone>> tones;
  ROOMWISE_CHECK_OK(for_each_keyframe(
      home, named, "looking at the light", run,
      [](const home::Keyframe&, const DecodedImages& images) { return tone_of(images.color); },
      [&](const home::Keyframe& one, PictureTone tone) -> Expected<void> {
        tones[{rooms.at(one.id), one.recording}].push_back(tone);
        return {};
      }));
  for (RoomSeen& room : seen) {
    for (RoomOnWalk& walk : room.walks) walk.light = light_of(tones.at({room.room, walk.walk}));
  }
  return {};
}

// ---- floor ----

// A camera over the floor.
struct FloorView {
  geometry::RigidTransform camera_from_gravity;
  Eigen::Vector3d at_gravity;
  const geometry::PinholeCamera* camera = nullptr;
  std::optional<std::string> room;
};

// Which cells of the floor were seen from near, and which were not.
class FloorGapFinder {
 public:
  FloorGapFinder(const HomeLayout& home, std::vector<FloorView> views,
                 const CoverageOptions& options)
      : home_(home), grid_(home.grid), views_(std::move(views)), options_(options) {
    state_ = image::Image<State>(grid_.columns(), grid_.rows(), State::kNone);
  }

  std::vector<FloorGap> find() {
    mark_far_floor();
    mark_unseen_floor();
    mark_edges();
    std::vector<FloorGap> gaps;
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        if (auto gap = take_component({column, row})) gaps.push_back(*std::move(gap));
      }
    }
    std::ranges::stable_sort(gaps, std::greater{}, &FloorGap::length_m);
    return gaps;
  }

 private:
  enum class State : std::uint8_t { kNone, kFar, kUnseen, kUnseenEdge, kTaken };
  struct Cell {
    int column, row;
  };

  [[nodiscard]] std::array<Cell, 4> neighbors(Cell cell) const {
    return {{{cell.column + 1, cell.row},
             {cell.column - 1, cell.row},
             {cell.column, cell.row + 1},
             {cell.column, cell.row - 1}}};
  }
  [[nodiscard]] std::string room_of(Cell cell) const {
    const auto room = home_.layout.room_of_cell(cell.column, cell.row);
    return room ? home_.layout.rooms()[*room].name : std::string();
  }

  void mark_far_floor() {
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        if (grid_.at(column, row) != FloorCell::kFree) continue;
        const std::string room = room_of({column, row});
        if (room.empty() || is_seen_from_near({column, row}, room)) continue;
        state_.at(column, row) = State::kFar;
      }
    }
  }

  // Unknown cells that one reaches from free floor without crossing anything.
  void mark_unseen_floor() {
    std::vector<Cell> open;
    const auto visit = [&](Cell from) {
      for (const Cell next : neighbors(from)) {
        if (!state_.contains(next.column, next.row)) continue;
        if (grid_.at(next.column, next.row) != FloorCell::kUnknown) continue;
        if (state_.at(next.column, next.row) != State::kNone || room_of(next).empty()) continue;
        state_.at(next.column, next.row) = State::kUnseen;
        open.push_back(next);
      }
    };
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        if (grid_.at(column, row) == FloorCell::kFree) visit({column, row});
      }
    }
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      visit(cell);
    }
  }

  [[nodiscard]] bool is_seen_from_near(Cell cell, const std::string& room) const {
    const Eigen::Vector2d middle = grid_.cell_middle_m(cell.column, cell.row);
    return std::ranges::any_of(views_, [&](const FloorView& view) {
      const Eigen::Vector2d at = view.at_gravity.head<2>();
      if ((middle - at).norm() > options_.near_m) return false;
      const Eigen::Vector3d point =
          view.camera_from_gravity * Eigen::Vector3d(middle.x(), middle.y(), view.at_gravity.z());
      // Where it stands below or above in the picture is left open: heads and hands nod.
      if (point.z() <= 0) return false;
      const double x_px = view.camera->fx * point.x() / point.z() + view.camera->cx;
      if (x_px < 0 || x_px >= view.camera->width) return false;
      return view.room == room || nothing_between(at, middle);
    });
  }

  [[nodiscard]] bool nothing_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const int steps = static_cast<int>(std::ceil((to - from).norm() / grid_.cell_m()));
    for (int i = 1; i < steps; ++i) {
      const Eigen::Vector2d between = from + (to - from) * (static_cast<double>(i) / steps);
      if (grid_.at(between) == FloorCell::kOccupied) return false;
    }
    return true;
  }

  // Unseen cells beside floor that was seen.
  void mark_edges() {
    for (int row = 0; row < grid_.rows(); ++row) {
      for (int column = 0; column < grid_.columns(); ++column) {
        if (state_.at(column, row) != State::kUnseen) continue;
        const bool is_edge = std::ranges::any_of(neighbors({column, row}), [&](Cell next) {
          return state_.contains(next.column, next.row) &&
                 grid_.at(next.column, next.row) == FloorCell::kFree;
        });
        if (is_edge) state_.at(column, row) = State::kUnseenEdge;
      }
    }
  }

  [[nodiscard]] bool is_unseen(Cell cell) const {
    return state_.contains(cell.column, cell.row) &&
           grid_.at(cell.column, cell.row) == FloorCell::kUnknown &&
           state_.at(cell.column, cell.row) != State::kNone;
  }
  // Whether so much of the same lies about the cell, or, of an edge, beyond it.
  [[nodiscard]] bool is_wide_at(Cell cell, State state) const {
    const int reach = static_cast<int>(options_.min_gap_m / (2 * grid_.cell_m()));
    const auto fills_square = [&](Cell middle) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const Cell at{middle.column + dx, middle.row + dy};
          const bool is_same = state == State::kUnseenEdge
                                   ? is_unseen(at)
                                   : state_.contains(at.column, at.row) &&
                                         grid_.at(at.column, at.row) == FloorCell::kFree &&
                                         state_.at(at.column, at.row) != State::kNone;
          if (!is_same) return false;
        }
      }
      return true;
    };
    if (state == State::kFar) return fills_square(cell);
    for (const int dx : {-reach - 1, 0, reach + 1}) {
      for (const int dy : {-reach - 1, 0, reach + 1}) {
        if (fills_square({cell.column + dx, cell.row + dy})) return true;
      }
    }
    return false;
  }

  // The cells of the seed's state that hang together with it, corners too, once; nothing where no
  // person would stand there.
  std::optional<FloorGap> take_component(Cell seed) {
    const State state = state_.at(seed.column, seed.row);
    if (state != State::kFar && state != State::kUnseenEdge) return std::nullopt;
    std::vector<Cell> cells{seed};
    std::map<std::string, std::size_t> rooms;
    state_.at(seed.column, seed.row) = State::kTaken;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Cell cell = cells[i];
      ++rooms[room_of(cell)];
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const Cell next{cell.column + dx, cell.row + dy};
          if (!state_.contains(next.column, next.row)) continue;
          if (state_.at(next.column, next.row) != state) continue;
          state_.at(next.column, next.row) = State::kTaken;
          cells.push_back(next);
        }
      }
    }
    const auto middle_of = [&](Cell cell) { return grid_.cell_middle_m(cell.column, cell.row); };
    Eigen::AlignedBox2d extent;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Cell cell : cells) {
      extent.extend(middle_of(cell));
      sum += middle_of(cell);
    }
    const double length_m = extent.sizes().norm() + grid_.cell_m();
    const bool is_wide =
        std::ranges::any_of(cells, [&](Cell cell) { return is_wide_at(cell, state); });
    if (!is_wide || length_m < options_.min_gap_m) return std::nullopt;
    const Eigen::Vector2d mean = sum / static_cast<double>(cells.size());
    const Cell middle = *std::ranges::min_element(
        cells, {}, [&](Cell cell) { return (middle_of(cell) - mean).squaredNorm(); });
    const auto room =
        std::ranges::max_element(rooms, {}, [](const auto& one) { return one.second; });
    return FloorGap{room->first, state == State::kUnseenEdge, length_m, middle_of(middle), {}};
  }

  const HomeLayout& home_;
  const fusion::FloorGrid& grid_;
  std::vector<FloorView> views_;
  const CoverageOptions& options_;
  image::Image<State> state_;
};

void add_neighboring_things(const std::vector<objects::Instance>& things,
                            const std::vector<home::Keyframe>& keyframes,
                            const fusion::GravityAlignedFrame& frame, std::vector<FloorGap>& gaps) {
  constexpr double kBeside_m = 1.5;
  for (FloorGap& gap : gaps) {
    double nearest_m = kBeside_m;
    for (const objects::Instance& thing : things) {
      const auto middle = middle_on_map(thing, keyframes.at(thing.keyframe_id).pose, frame);
      if (!middle) continue;
      const double distance_m = (middle->head<2>() - gap.middle_gravity).norm();
      if (distance_m > nearest_m) continue;
      nearest_m = distance_m;
      gap.beside = thing.name;
    }
  }
}

Expected<void> add_gaps(const home::Home& home, const std::vector<home::Keyframe>& keyframes,
                        const CoverageOptions& options, RunContext& run, RoomCoverage& coverage) {
  ROOMWISE_TRY(const auto layout, find_home_layout(home, run));
  if (!layout) return {};
  coverage.knows_floor = true;
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::vector<FloorView> views;
  for (const home::Keyframe& one : keyframes) {
    if (one.pose.component != 0) continue;
    const geometry::RigidTransform gravity_from_camera =
        layout->frame.gravity_from_world * one.pose.world_from_keyframe;
    views.push_back({gravity_from_camera.inverse(), gravity_from_camera.translation,
                     &cameras.at(one.recording),
                     layout->layout.room_at(gravity_from_camera.translation.head<2>())});
  }
  coverage.gaps = FloorGapFinder(*layout, std::move(views), options).find();
  ROOMWISE_TRY(const auto things, home.instances());
  add_neighboring_things(things, keyframes, layout->frame, coverage.gaps);
  return {};
}

// ---- rooms and walks ----

std::vector<RoomSeen> rooms_by_walk(const std::vector<rooms::Room>& rooms,
                                    const std::vector<home::Keyframe>& keyframes,
                                    const KeyframeRooms& room_of) {
  std::vector<RoomSeen> seen;
  for (const rooms::Room& room : rooms) seen.push_back({room.name, {}});
  for (const home::Keyframe& one : keyframes) {
    const auto named = room_of.find(one.id);
    if (named == room_of.end()) continue;
    const auto room = std::ranges::find(seen, named->second, &RoomSeen::room);
    if (room == seen.end()) continue;
    auto& walks = room->walks;
    auto walk = std::ranges::find(walks, one.recording, &RoomOnWalk::walk);
    if (walk == walks.end()) {
      walk = walks.insert(walks.end(),
                          {one.recording, 0, one.timestamp_ns, one.timestamp_ns, std::nullopt});
    }
    ++walk->pictures;
    walk->last_ns = std::max(walk->last_ns, one.timestamp_ns);
  }
  return seen;
}

constexpr std::array<std::pair<Missing, std::string_view>, 7> kMissing{
    {{Missing::kJoin, "join"},
     {Missing::kNames, "names"},
     {Missing::kPictures, "pictures"},
     {Missing::kMorePictures, "more pictures"},
     {Missing::kSecondWalk, "second walk"},
     {Missing::kOtherLight, "other light"},
     {Missing::kFloor, "floor"}}};

}  // namespace

bool RoomLight::differs_from(const RoomLight& other) const {
  const auto differ = [](double a, double a_low, double a_high, double b, double b_low,
                         double b_high) {
    return std::abs(a - b) > std::max(a_high - a_low, b_high - b_low);
  };
  return differ(brightness, brightness_low, brightness_high, other.brightness, other.brightness_low,
                other.brightness_high) ||
         differ(red_over_blue, red_over_blue_low, red_over_blue_high, other.red_over_blue,
                other.red_over_blue_low, other.red_over_blue_high);
}

std::size_t RoomSeen::pictures() const {
  std::size_t pictures = 0;
  for (const RoomOnWalk& walk : walks) pictures += walk.pictures;
  return pictures;
}

std::optional<bool> RoomSeen::by_several_lights() const {
  for (std::size_t a = 0; a < walks.size(); ++a) {
    if (!walks[a].light) return std::nullopt;
    for (std::size_t b = 0; b < a; ++b) {
      if (walks[a].light->differs_from(*walks[b].light)) return true;
    }
  }
  return false;
}

Expected<void> CoverageOptions::validate() const {
  if (near_m <= 0) return fail("near_m is {}; expected more than 0", near_m);
  if (min_gap_m <= 0) return fail("min_gap_m is {}; expected more than 0", min_gap_m);
  return learning.validate();
}

Expected<RoomCoverage> find_room_coverage(const home::Home& home, const CoverageOptions& options,
                                          RunContext& run) {
  ROOMWISE_CHECK_OK(options.validate());
  RoomCoverage coverage;
  ROOMWISE_TRY(coverage.walks, home.recordings());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto rooms, home.rooms());
  ROOMWISE_TRY(const KeyframeRooms room_of, rooms_of_keyframes(home));
  for (const home::StoredRecording& walk : coverage.walks) {
    const auto is_of_walk = [&](const home::Keyframe& one) { return one.recording == walk.id; };
    const bool is_on_map = std::ranges::any_of(keyframes, [&](const home::Keyframe& one) {
      return is_of_walk(one) && one.pose.component == 0;
    });
    if (!is_on_map) coverage.not_joined.push_back(walk.id);
    coverage.unnamed.push_back(
        static_cast<std::size_t>(std::ranges::count_if(keyframes, [&](const home::Keyframe& one) {
          return is_of_walk(one) && !room_of.contains(one.id);
        })));
  }
  coverage.rooms = rooms_by_walk(rooms, keyframes, room_of);
  if (!home.is_locked()) {
    ROOMWISE_CHECK_OK(add_lights(home, keyframes, room_of, coverage.rooms, run));
  }
  ROOMWISE_CHECK_OK(add_gaps(home, keyframes, options, run, coverage));
  return coverage;
}

std::string_view to_string(Missing what) {
  return std::ranges::find(kMissing, what, &std::pair<Missing, std::string_view>::first)->second;
}

std::vector<CoverageItem> missing_items(const RoomCoverage& coverage,
                                        const CoverageOptions& options) {
  std::vector<CoverageItem> items;
  for (const home::RecordingId walk : coverage.not_joined) {
    items.push_back({Missing::kJoin, {}, walk, 0, std::nullopt});
  }
  for (std::size_t i = 0; i < coverage.walks.size(); ++i) {
    if (coverage.unnamed[i] == 0) continue;
    items.push_back({Missing::kNames, {}, coverage.walks[i].id, coverage.unnamed[i], std::nullopt});
  }
  for (const RoomSeen& room : coverage.rooms) {
    const std::size_t pictures = room.pictures();
    if (pictures < options.learning.comfortable_pictures) {
      items.push_back(
          {pictures < options.learning.min_pictures ? Missing::kPictures : Missing::kMorePictures,
           room.room, std::nullopt, pictures, std::nullopt});
    }
    if (room.walks.size() == 1) {
      items.push_back(
          {Missing::kSecondWalk, room.room, room.walks.front().walk, pictures, std::nullopt});
    } else if (room.by_several_lights() == false && !room.walks.empty()) {
      items.push_back({Missing::kOtherLight, room.room, std::nullopt, pictures, std::nullopt});
    }
  }
  for (const FloorGap& gap : coverage.gaps) {
    items.push_back({Missing::kFloor, gap.room, std::nullopt, 0, gap});
  }
  std::ranges::stable_sort(items, {}, &CoverageItem::what);
  return items;
}

}  // namespace roomwise::pipeline
