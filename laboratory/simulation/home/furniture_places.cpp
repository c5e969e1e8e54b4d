#include <algorithm>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/room_furnisher.h"

// Where a rule would have a piece stand: the candidates, of which the best that fits is taken.
namespace roomwise::simulation {
namespace {

constexpr double kCurtainRoom = 0.09;  // what stands before a curtain leaves that between

}  // namespace

std::vector<RoomFurnisher::Candidate> RoomFurnisher::candidates(const FurnitureRule& rule,
                                                                const FurnitureModel& model) {
  std::vector<Candidate> out;
  switch (rule.placing) {
    case Placing::kAgainstWall:
    case Placing::kInCorner:
    case Placing::kOpposite:
      at_walls(rule, model, out);
      break;
    case Placing::kInMiddle:
      in_middle(model, out);
      break;
    case Placing::kOnTop:
      on_top(model, *anchor_, out);
      break;
    case Placing::kUnderWindow:
      under_windows(model, out);
      break;
    case Placing::kOnFloor:
      if (!anchor_) {
        const Eigen::Vector2d middle = center(room().interior);
        const bool across = size(room().interior).x() > size(room().interior).y();
        const double yaw =
            (model.size_m.x() > model.size_m.y()) == across ? 0 : std::numbers::pi / 2;
        out.push_back({0, make(model, {middle.x(), middle.y(), 0}, yaw)});
        break;
      }
      [[fallthrough]];
    case Placing::kBeside:
    case Placing::kBefore:
    case Placing::kAlong:
    case Placing::kAround:
      at_anchor(rule, model, home_.objects[*anchor_], out);
      break;
  }
  return out;
}

void RoomFurnisher::at_walls(const FurnitureRule& rule, const FurnitureModel& model,
                             std::vector<Candidate>& out) {
  constexpr double kStep = 0.1;
  for (const WallSide& side : sides_of(room().interior)) {
    const double favour = random_.uniform();  // of the whole side
    const double half = model.size_m.x() / 2 + (model.elevation_m > 0 ? 0 : kStandingWallGap);
    const double last = side.length_m - half;
    if (last < half) continue;
    const int steps = static_cast<int>(std::ceil((last - half) / kStep));
    for (int i = 0; i <= steps; ++i) {
      const double along = std::min(half + kStep * i, last);
      PlacedObject object = against(model, side, along);
      if (touches_curtain(footprint_of(object))) {  // stands off the wall, the curtain behind it
        object.world_from_object.translation.head<2>() += kCurtainRoom * side.inward;
      }
      const double to_corner = std::min(along - half, last - along);
      const Eigen::Vector2d place = object.world_from_object.translation.head<2>();
      double score = favour + 0.3 * random_.uniform();
      if (rule.placing == Placing::kInCorner) {
        score -= 3 * to_corner;
      } else if (rule.placing == Placing::kOpposite) {
        const PlacedObject& anchor = home_.objects[*anchor_];
        const Eigen::Vector2d to_anchor = anchor.world_from_object.translation.head<2>() - place;
        const double looks = facing(yaw_of(anchor.world_from_object)).dot(-side.inward);
        const double aside = std::abs(to_anchor.dot(side.along));
        score += 4 * looks - aside;
        Footprint with_screen = footprint_of(object);
        with_screen.top_m = 1.25;
        if (covers_window(with_screen)) score -= 3;
        if (looks < 0.5 && aside > 1.2) continue;  // nobody watches from behind
      } else if (model.kind == "bed") {
        // With room on both sides where the wall is long, in the corner where it is narrow.
        score += to_corner > 0.55 || model.size_m.x() < 1.2 ? 0.6 : 0;
      } else {
        score += to_corner < 0.05 ? 0.25 : 0;
      }
      out.push_back({score, std::move(object)});
    }
  }
}

void RoomFurnisher::in_middle(const FurnitureModel& model, std::vector<Candidate>& out) {
  constexpr double kStep = 0.15;
  const Eigen::Vector2d middle = center(room().interior);
  const Eigen::Vector2d extent = size(room().interior);
  const Eigen::Vector2i steps = (extent / kStep).array().floor().cast<int>();
  for (const double yaw : {0.0, std::numbers::pi / 2}) {
    const bool lies_along =
        (yaw == 0) == ((model.size_m.x() > model.size_m.y()) == (extent.x() > extent.y()));
    for (int i = 0; i <= steps.x(); ++i) {
      for (int j = 0; j <= steps.y(); ++j) {
        const Eigen::Vector2d place = room().interior.min + kStep * Eigen::Vector2d(i, j);
        const double score =
            -(place - middle).norm() + (lies_along ? 0.3 : 0) + 0.4 * random_.uniform();
        out.push_back({score, make(model, {place.x(), place.y(), 0}, yaw)});
      }
    }
  }
}

void RoomFurnisher::at_anchor(const FurnitureRule& rule, const FurnitureModel& model,
                              const PlacedObject& anchor, std::vector<Candidate>& out) {
  const Footprint base = footprint_of(anchor);
  const Eigen::Vector2d front = facing(base.yaw_rad);
  const Eigen::Vector2d right(-front.y(), front.x());  // of one who looks at its front
  const Eigen::Vector2d half = model.size_m.head<2>() / 2;
  const auto put = [&](const Eigen::Vector2d& place, double yaw, double score) {
    out.push_back({score, make(model, {place.x(), place.y(), model.elevation_m}, yaw)});
  };
  const double depth_before = base.half_size.y() + half.y();
  switch (rule.placing) {
    case Placing::kBeside: {
      // Its back in line with the anchor's.
      const double gap = model.elevation_m > 0 ? 0.25 : 0.04;
      const double back = base.half_size.y() - half.y() +
                          (model.elevation_m > 0 ? kStandingWallGap - kHangingWallGap : 0);
      for (const double side : {-1.0, 1.0}) {
        const double aside = side * (base.half_size.x() + half.x() + gap);
        put(base.center + right * aside - front * back, base.yaw_rad, random_.uniform());
      }
      break;
    }
    case Placing::kBefore: {
      const double turn = 0.5 * (random_.uniform() - 0.5);
      for (const double gap : {0.06, 0.12, 0.18}) {
        for (const double aside : {0.0, -0.2, 0.2}) {
          put(base.center + front * (depth_before + gap) + right * aside,
              base.yaw_rad + std::numbers::pi + turn, -gap - std::abs(aside));
        }
      }
      break;
    }
    case Placing::kAlong:
      for (const double gap : {0.38, 0.45, 0.32}) {
        put(base.center + front * (depth_before + gap), base.yaw_rad, -std::abs(gap - 0.38));
      }
      break;
    case Placing::kAround:
      around(model, base, out);
      break;
    case Placing::kOnFloor:
      on_floor(model, base, out);
      break;
    default:
      break;
  }
}

void RoomFurnisher::around(const FurnitureModel& model, const Footprint& base,
                           std::vector<Candidate>& out) {
  for (const double quarter : {0.0, 1.0, 2.0, 3.0}) {
    const double yaw = base.yaw_rad + quarter * std::numbers::pi / 2;
    const bool at_end = quarter == 1 || quarter == 3;
    const double width = 2 * (at_end ? base.half_size.y() : base.half_size.x());
    const double depth = at_end ? base.half_size.x() : base.half_size.y();
    const int seats = std::max(1, static_cast<int>(width / 0.6));
    const Eigen::Vector2d outward = facing(yaw);
    const Eigen::Vector2d aside(-outward.y(), outward.x());
    for (int i = 0; i < seats; ++i) {
      const double turn = 0.24 * (random_.uniform() - 0.5);
      const double gap = 0.07 + 0.1 * random_.uniform();
      const Eigen::Vector2d place = base.center + outward * (depth + model.size_m.y() / 2 + gap) +
                                    aside * (width * ((i + 0.5) / seats - 0.5));
      const double score = (at_end ? 0 : 0.6) + 0.8 * random_.uniform();
      out.push_back({score, make(model, {place.x(), place.y(), 0}, yaw + std::numbers::pi + turn)});
    }
  }
}

void RoomFurnisher::on_floor(const FurnitureModel& model, const Footprint& base,
                             std::vector<Candidate>& out) {
  const Eigen::Vector2d front = facing(base.yaw_rad);
  const Eigen::Vector2d right(-front.y(), front.x());
  const Eigen::Vector2d half = model.size_m.head<2>() / 2;
  const auto put = [&](const Eigen::Vector2d& place, double yaw, double score) {
    out.push_back({score, make(model, {place.x(), place.y(), 0}, yaw)});
  };
  const double under = 0.3 * half.y();  // a part of it lies under the anchor
  const bool is_large = model.size_m.head<2>().maxCoeff() > 1.5;
  put(base.center + front * (base.half_size.y() + half.y() - (is_large ? under : -0.05)),
      base.yaw_rad, random_.uniform());
  for (const double side : {-1.0, 1.0}) {
    put(base.center + right * side * (base.half_size.x() + half.y() + 0.05),
        base.yaw_rad + std::numbers::pi / 2, is_large ? -1 : random_.uniform());
  }
}

void RoomFurnisher::on_top(const FurnitureModel& model, std::size_t anchor,
                           std::vector<Candidate>& out) {
  const PlacedObject& base = home_.objects[anchor];
  const auto base_model = std::ranges::find(models_, base.model, &FurnitureModel::id);
  constexpr double kLowestSurface = 0.25, kHighestSurface = 1.3;
  if (base_model == models_.end() || base_model->top_m < kLowestSurface ||
      base_model->top_m > kHighestSurface) {
    return;
  }
  constexpr int kTries = 24;
  for (int i = 0; i < kTries; ++i) {
    // Big things stand straight with their back to the wall, small ones lie anyhow.
    const bool is_straight = !is_small_kind(model.kind);
    const double turn =
        is_straight ? 0.1 * (random_.uniform() - 0.5) : 2.4 * (random_.uniform() - 0.5);
    Footprint footprint;
    footprint.half_size = model.size_m.head<2>() / 2;
    footprint.yaw_rad = turn;
    const Eigen::Vector2d reach = size(footprint.bounds()) / 2;
    const Eigen::Vector2d slack = base.size_m.head<2>() / 2 - reach;
    if ((slack.array() < 0.01).any()) continue;
    Eigen::Vector2d place((2 * random_.uniform() - 1) * slack.x(),
                          (2 * random_.uniform() - 1) * slack.y());
    if (is_straight) place.y() = slack.y() * (0.3 + 0.6 * random_.uniform());
    if (model.kind == "tv") place = {0, 0.4 * slack.y()};
    if (base.kind == "bed") place.y() = -std::abs(place.y()) * 0.7;  // away from the pillows
    const Eigen::Vector3d bottom =
        base.world_from_object * Eigen::Vector3d(place.x(), place.y(), base_model->top_m);
    PlacedObject object = make(model, bottom, yaw_of(base.world_from_object) + turn);
    object.stands_on = anchor;
    if (stands_before_front(object)) continue;
    out.push_back({-static_cast<double>(i), std::move(object)});
  }
}

bool RoomFurnisher::stands_before_front(const PlacedObject& object) const {
  const Footprint footprint = footprint_of(object);
  return std::ranges::any_of(home_.objects, [&](const PlacedObject& other) {
    if (other.stands_on != object.stands_on || other.kind != "microwave") return false;
    Footprint door = footprint_of(other);
    const double depth = door.half_size.y();
    constexpr double kReach = 0.6;  // as far as a worktop goes
    door.center += facing(door.yaw_rad) * (depth + kReach / 2);
    door.half_size.y() = kReach / 2;
    return overlap_on_floor(footprint, door, 0);
  });
}

void RoomFurnisher::under_windows(const FurnitureModel& model, std::vector<Candidate>& out) {
  for (const Window& window : home_.windows) {
    if (window.room != room_) continue;
    if (model.size_m.x() > window.opening.width_m + 0.5 || model.size_m.y() > 0.26 ||
        model.elevation_m + model.size_m.z() > window.opening.bottom_m) {
      continue;
    }
    for (const WallSide& side : sides_of(room().interior)) {
      const Eigen::Vector2d offset = window.opening.center - side.from;
      if (std::abs(offset.dot(side.inward)) > home_.wall_thickness_m) continue;
      out.push_back({random_.uniform(), against(model, side, offset.dot(side.along))});
    }
  }
}

}  // namespace roomwise::simulation
