#include "roomwise/pipeline/rooms/floor_gaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::pipeline {
namespace {

using fusion::FloorCell;

// A camera over the floor.
struct FloorView {
  geometry::RigidTransform camera_from_plan;
  Eigen::Vector3d at_plan;
  const geometry::PinholeCamera* camera = nullptr;
  std::optional<std::string> room;
};

// Which cells of the floor were seen from near, and which were not.
class FloorGapFinder {
 public:
  FloorGapFinder(const HomeLayout& home, std::vector<FloorView> views,
                 const FloorGapOptions& options)
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
    const fusion::Storeys& storeys = home_.frame.storeys;
    return std::ranges::any_of(views_, [&](const FloorView& view) {
      const Eigen::Vector2d at = view.at_plan.head<2>();
      if ((middle - at).norm() > options_.near_m) return false;
      if (storeys.at_plan(middle) != storeys.at_plan(at)) return false;
      const Eigen::Vector3d point =
          view.camera_from_plan * Eigen::Vector3d(middle.x(), middle.y(), view.at_plan.z());
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
  const FloorGapOptions& options_;
  image::Image<State> state_;
};

void add_neighboring_things(std::span<const HomeThing> things,
                            std::span<const home::Keyframe> keyframes,
                            const fusion::GravityAlignedFrame& frame, std::vector<FloorGap>& gaps) {
  constexpr double kBeside_m = 1.5;
  for (FloorGap& gap : gaps) {
    double nearest_m = kBeside_m;
    for (const HomeThing& thing : things) {
      const auto middle = middle_on_map(thing, keyframes[thing.keyframe_id].pose, frame);
      if (!middle) continue;
      const double distance_m = (middle->head<2>() - gap.middle_plan).norm();
      if (distance_m > nearest_m) continue;
      nearest_m = distance_m;
      gap.beside = thing.name;
    }
  }
}

}  // namespace

Expected<void> FloorGapOptions::validate() const {
  if (near_m <= 0) return fail("near_m is {}; expected more than 0", near_m);
  if (min_gap_m <= 0) return fail("min_gap_m is {}; expected more than 0", min_gap_m);
  return {};
}

Expected<std::vector<FloorGap>> find_floor_gaps(const home::Home& home, const HomeLayout& layout,
                                                std::span<const home::Keyframe> keyframes,
                                                const FloorGapOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::vector<FloorView> views;
  for (const home::Keyframe& one : keyframes) {
    if (one.pose.component != 0) continue;
    const geometry::RigidTransform plan_from_camera =
        layout.frame.on_plan(one.pose.world_from_keyframe);
    views.push_back({plan_from_camera.inverse(), plan_from_camera.translation,
                     &cameras.at(one.recording),
                     layout.layout.room_at(plan_from_camera.translation.head<2>())});
  }
  std::vector<FloorGap> gaps = FloorGapFinder(layout, std::move(views), options).find();
  ROOMWISE_TRY(const HomeThings things, find_home_things(home));
  add_neighboring_things(things.things, keyframes, layout.frame, gaps);
  return gaps;
}

}  // namespace roomwise::pipeline
