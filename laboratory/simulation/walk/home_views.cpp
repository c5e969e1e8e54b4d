#include "laboratory/simulation/walk/home_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr std::uint64_t kPieceStream = 0x91ECEu, kRoomStream = 0x4003u;
constexpr double kDegree = std::numbers::pi / 180;

// Furniture kinds and what a view of them is said to show.
constexpr std::array<std::pair<std::string_view, std::string_view>, 27> kNames{{
    {"armchair", "armchair"},
    {"bathtub", "bathtub"},
    {"bed", "bed"},
    {"bookcase", "bookcase"},
    {"bunk_bed", "bed"},
    {"chair", "chair"},
    {"chest_of_drawers", "chest of drawers"},
    {"coffee_table", "coffee table"},
    {"computer", "computer"},
    {"desk", "desk"},
    {"dining_table", "dining table"},
    {"floor_lamp", "lamp"},
    {"fridge", "fridge"},
    {"lamp", "lamp"},
    {"microwave", "microwave"},
    {"nightstand", "nightstand"},
    {"office_chair", "office chair"},
    {"plant", "plant"},
    {"radiator", "radiator"},
    {"shower", "shower"},
    {"sink", "kitchen sink"},
    {"sofa", "sofa"},
    {"stove", "stove"},
    {"toilet", "toilet"},
    {"tv", "television"},
    {"wardrobe", "wardrobe"},
    {"washbasin", "washbasin"},
}};

// A camera whose longer side sees this angle; two of four lie, one stands, one is square.
geometry::PinholeCamera sample_camera(RandomStream& random, int longer_side_px) {
  constexpr double kMaxDegrees = 66, kMinDegrees = 54;
  const int shorter_px = longer_side_px * 3 / 4;
  constexpr double kSquare = 0.87;  // has about as many pixels
  const int square_px = static_cast<int>(kSquare * longer_side_px);
  const std::array<std::pair<int, int>, 4> sizes{{{longer_side_px, shorter_px},
                                                  {longer_side_px, shorter_px},
                                                  {shorter_px, longer_side_px},
                                                  {square_px, square_px}}};
  geometry::PinholeCamera camera = {};
  std::tie(camera.width, camera.height) = sizes[random.index(sizes.size())];
  const double half_angle = random.between(kMinDegrees, kMaxDegrees) * kDegree / 2;
  camera.fx = camera.fy = std::max(camera.width, camera.height) / (2 * std::tan(half_angle));
  camera.cx = (camera.width - 1) / 2.0;
  camera.cy = (camera.height - 1) / 2.0;
  return camera;
}

// Drawn nearer: with a longer lens.
void zoom(geometry::PinholeCamera& camera, double times) {
  camera.fx *= times;
  camera.fy *= times;
}

geometry::RigidTransform rolled(const geometry::RigidTransform& world_from_camera,
                                RandomStream& random) {
  constexpr double kMax_rad = 5 * kDegree;
  geometry::Vector6d turn = geometry::Vector6d::Zero();
  turn[2] = random.between(-kMax_rad, kMax_rad);
  return world_from_camera * geometry::RigidTransform::exp(turn);
}

double sample_height_m(RandomStream& random) {
  return random.between(1.2, 1.6);
}

double share_of_pixels(const RenderedFrame& frame, std::size_t object) {
  double pixels = 0;
  for (int y = 0; y < frame.object.height(); ++y) {
    for (int x = 0; x < frame.object.width(); ++x) pixels += frame.object.at(x, y) == object + 1;
  }
  return pixels / (frame.object.width() * frame.object.height());
}

class ViewSampler {
 public:
  ViewSampler(const HomeModel& home, const Renderer& renderer, const HomeViewOptions& options,
              ThreadPool& pool)
      : home_(home),
        renderer_(renderer),
        options_(options),
        pool_(pool),
        space_(FreeSpace::of(home)) {}

  Expected<void> look_at_pieces(const MeshLoader& load) {
    std::map<std::string_view, std::vector<std::size_t>> pieces;  // by what they are named
    for (std::size_t i = 0; i < home_.objects.size(); ++i) {
      const std::string_view name = name_in_views(home_.objects[i].kind);
      if (!name.empty()) pieces[name].push_back(i);
    }
    for (const auto& [name, objects] : pieces) {
      for (std::size_t turn = 0; turn < options_.of_kind; ++turn) {
        // Where there are fewer views than pieces, not always of the first ones.
        const std::size_t object = objects[(home_.seed + turn) % objects.size()];
        ROOMWISE_RETURN_IF_ERROR(look_at(object, turn, std::string(name), load));
      }
    }
    return {};
  }

  void look_around(std::size_t room) {
    const std::vector<Eigen::Vector2d> places = places_in(room);
    if (places.empty()) return;
    for (std::size_t turn = 0; turn < options_.of_room; ++turn) {
      RandomStream random(options_.seed, {kRoomStream, home_.seed, room, turn});
      for (int draw = 0; draw < kDraws; ++draw) {
        SampledView view = sample_room_view(room, places, random);
        if (!shows_room(view)) continue;
        views_.push_back(std::move(view));
        break;
      }
    }
  }

  std::vector<SampledView> take() { return std::move(views_); }

 private:
  static constexpr int kDraws = 8;

  Expected<void> look_at(std::size_t object, std::size_t turn, std::string name,
                         const MeshLoader& load) {
    constexpr double kNearest_m = 0.7, kFarthest_m = 3.2;
    const auto places = places_before(home_, object, space_, kNearest_m, kFarthest_m);
    if (places.empty()) return {};
    ROOMWISE_TRY(const TriangleMesh mesh, load(home_.objects[object].model));
    const auto points = points_on(home_.objects[object], mesh);
    RandomStream random(options_.seed, {kPieceStream, home_.seed, object, turn});
    for (int draw = 0; draw < kDraws; ++draw) {
      SampledView view = sample_piece_view(object, places[random.index(places.size())], random);
      if (!shows_piece(view, object, points)) continue;
      view.shows = std::move(name);
      views_.push_back(std::move(view));
      break;
    }
    return {};
  }

  SampledView sample_piece_view(std::size_t object, const StandingPlace& from,
                                RandomStream& random) {
    const PlacedObject& piece = home_.objects[object];
    SampledView view;
    view.room = piece.room;
    view.pace = random.between(-2, 2);
    view.camera = sample_camera(random, options_.longer_side_px);
    const Eigen::Vector3d eye(from.place.x(), from.place.y(), sample_height_m(random));
    Eigen::Vector3d aim(0, 0, piece.size_m.z() / 2);
    constexpr double kBeside = 0.25;  // of the piece's sizes
    for (int axis = 0; axis < 3; ++axis) {
      aim[axis] += random.between(-kBeside, kBeside) * piece.size_m[axis];
    }
    aim = piece.world_from_object * aim;
    view.world_from_camera = rolled(looking_at(eye, aim), random);
    // As it looks from there, or so near that it fills the picture by this share.
    const double share = random.between(0.45, 1.1);
    const double fills = piece.size_m.maxCoeff() / (aim - eye).norm() * view.camera.fx /
                         std::min(view.camera.width, view.camera.height);
    constexpr double kMaxZoom = 5, kAsItIs = 0.3;
    if (random.uniform() >= kAsItIs) zoom(view.camera, std::clamp(share / fills, 1.0, kMaxZoom));
    return view;
  }

  bool shows_piece(const SampledView& view, std::size_t object,
                   const std::vector<Eigen::Vector3d>& points) const {
    constexpr double kMinSeen = 0.5, kMinPixelShare = 0.07;
    const geometry::PinholeCamera camera = coarse(view.camera);
    const RenderedFrame frame = renderer_.render(camera, view.world_from_camera, pool_);
    return share_of_pixels(frame, object) >= kMinPixelShare &&
           share_seen(points, object, frame, camera, view.world_from_camera) >= kMinSeen;
  }

  std::vector<Eigen::Vector2d> places_in(std::size_t room) const {
    constexpr int kEvery = 2;  // cells
    std::vector<Eigen::Vector2d> places;
    for (int row = 0; row < space_.rows(); row += kEvery) {
      for (int column = 0; column < space_.columns(); column += kEvery) {
        const Eigen::Vector2d place = space_.cell_center(column, row);
        if (space_.clearance_m(column, row) >= kStandingRadius_m &&
            contains(home_.rooms[room].interior, place)) {
          places.push_back(place);
        }
      }
    }
    return places;
  }

  SampledView sample_room_view(std::size_t room, const std::vector<Eigen::Vector2d>& places,
                               RandomStream& random) {
    SampledView view;
    view.shows = name_in_views(home_.rooms[room].kind);
    view.room = room;
    view.pace = random.between(-2, 2);
    view.camera = sample_camera(random, options_.longer_side_px);
    const Eigen::Vector2d place = places[random.index(places.size())];
    const Eigen::Vector3d eye(place.x(), place.y(), sample_height_m(random));
    const double heading = random.between(0, 360 * kDegree);
    const double up = random.between(-15 * kDegree, 15 * kDegree);
    const Eigen::Vector3d forward(std::cos(up) * std::cos(heading),
                                  std::cos(up) * std::sin(heading), std::sin(up));
    view.world_from_camera = rolled(looking_at(eye, eye + forward), random);
    return view;
  }

  bool shows_room(const SampledView& view) const {
    constexpr double kMaxOfOne = 0.3;  // of the picture, of a piece that has a name
    constexpr float kMinDepth_m = 1.2F;
    const RenderedFrame frame =
        renderer_.render(coarse(view.camera), view.world_from_camera, pool_);
    float depth_m = 0, pixels = 0;
    std::map<std::size_t, double> shares;
    for (int y = 0; y < frame.object.height(); ++y) {
      for (int x = 0; x < frame.object.width(); ++x) {
        depth_m += frame.depth_m.at(x, y);
        ++pixels;
        if (const std::size_t object = frame.object.at(x, y); object > 0) ++shares[object - 1];
      }
    }
    return depth_m >= kMinDepth_m * pixels && std::ranges::none_of(shares, [&](const auto& share) {
             return share.second > kMaxOfOne * static_cast<double>(pixels) &&
                    !name_in_views(home_.objects[share.first].kind).empty();
           });
  }

  const HomeModel& home_;
  const Renderer& renderer_;
  const HomeViewOptions& options_;
  ThreadPool& pool_;
  FreeSpace space_;
  std::vector<SampledView> views_;
};

}  // namespace

std::string_view name_in_views(std::string_view furniture_kind) {
  const auto found =
      std::ranges::find(kNames, furniture_kind, [](const auto& name) { return name.first; });
  return found == kNames.end() ? std::string_view{} : found->second;
}

std::string name_in_views(RoomKind kind) {
  return fmt::format("room: {}", name_of(kind));
}

Expected<std::vector<SampledView>> choose_home_views(const HomeModel& home, const MeshLoader& load,
                                                     const Renderer& renderer,
                                                     const HomeViewOptions& options,
                                                     ThreadPool& pool) {
  ViewSampler sampler(home, renderer, options, pool);
  ROOMWISE_RETURN_IF_ERROR(sampler.look_at_pieces(load));
  for (std::size_t room = 0; room < home.rooms.size(); ++room) sampler.look_around(room);
  return sampler.take();
}

}  // namespace roomwise::simulation
