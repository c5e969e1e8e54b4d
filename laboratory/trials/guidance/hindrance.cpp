#include "laboratory/trials/guidance/hindrance.h"

#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/random.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using simulation::HomeModel;

constexpr const char* kPersonsModel = "person";
const Eigen::Vector3d kPersonsSize_m(0.5, 0.3, 1.7);
constexpr double kFromEnds_m = 1;

// A place on a planned way, and where it leads there.
struct OnWay {
  Vector2d place;
  double heading_rad = 0;
};

// Close enough together that no door is missed.
std::vector<OnWay> places_between(const guide::Route& route, double from_ends_m) {
  constexpr double kApart_m = 0.05;
  const double length_m = guide::length_m(route);
  std::vector<OnWay> places;
  double before_m = 0;
  for (std::size_t i = 1; i < route.size(); ++i) {
    const Vector2d along = route[i] - route[i - 1];
    for (double gone_m = 0; gone_m < along.norm(); gone_m += kApart_m) {
      const double at_m = before_m + gone_m;
      if (at_m < from_ends_m || at_m > length_m - from_ends_m) continue;
      places.push_back(
          {route[i - 1] + gone_m * along.normalized(), std::atan2(along.y(), along.x())});
    }
    before_m += along.norm();
  }
  return places;
}

// With the shoulders across the way.
std::optional<Vector2d> put_person(HomeModel& home, const fusion::FloorGrid& floor,
                                   const guide::Route& route, RandomStream& random) {
  auto places = places_between(route, kFromEnds_m);
  std::erase_if(places,
                [&](const OnWay& one) { return !floor.fits(one.place, kPersonsSize_m.x() / 2); });
  if (places.empty()) return std::nullopt;
  const OnWay& at = places[random.index(places.size())];
  simulation::PlacedObject person;
  person.name = person.kind = "person";
  person.model = kPersonsModel;
  person.room = simulation::room_at(home, at.place);
  person.size_m = kPersonsSize_m;
  person.world_from_object = simulation::upright_pose({at.place.x(), at.place.y(), 0},
                                                      at.heading_rad + std::numbers::pi / 2);
  home.objects.push_back(person);
  return at.place;
}

bool shut_door(HomeModel& home, const guide::Route& route, RandomStream& random) {
  constexpr double kFromDoorAsGoal_m = 0.5;
  const auto places = places_between(route, kFromDoorAsGoal_m);
  std::vector<simulation::Door*> passed;
  for (simulation::Door& door : home.doors) {
    const simulation::Rectangle hole = simulation::hole_of(door.opening, home.wall_thickness_m);
    const bool is_passed = std::ranges::any_of(
        places, [&](const OnWay& one) { return simulation::contains(hole, one.place); });
    if (door.has_leaf && door.other_room && is_passed) passed.push_back(&door);
  }
  if (passed.empty()) return false;
  passed[random.index(passed.size())]->open_rad = 0;
  return true;
}

}  // namespace

std::optional<Hindrance> parse_hindrance(std::string_view name) {
  if (name == "person") return Hindrance::kPerson;
  if (name == "person-goes") return Hindrance::kPersonGoes;
  if (name == "closed-door") return Hindrance::kClosedDoor;
  return std::nullopt;
}

std::vector<WalkGround> hinder(const GuidedMap& map, const std::shared_ptr<const WalkedHome>& home,
                               std::span<const GuidedGoal> goals, Hindrance hindrance,
                               const TrialOptions& options) {
  std::vector<WalkGround> grounds;
  for (const GuidedGoal& goal : goals) {
    const std::uint64_t walk = grounds.size();
    WalkGround& ground = grounds.emplace_back(WalkGround{home, goal});
    if (hindrance == Hindrance::kNone) continue;
    const guide::Pose start{goal.start, goal.start_heading_rad};
    const guide::Plan plan =
        guide::plan_way(map.view(), {.pose = start}, goal.goal, options.guidance.plan);
    HomeModel model = home->model;
    RandomStream random(seed_of_walk(options, walk), {0x68696e646572});
    const bool is_person = hindrance != Hindrance::kClosedDoor;
    const auto person_at =
        is_person ? put_person(model, home->floor, plan.route, random) : std::optional<Vector2d>();
    if (is_person ? !person_at : !shut_door(model, plan.route, random)) continue;
    ground.home = std::make_shared<const WalkedHome>(model);
    ground.goal.is_hindered = true;
    if (hindrance == Hindrance::kPersonGoes) {
      constexpr double kSoonest_s = 5, kLatest_s = 30;
      ground.leaving = Leaving{home, *person_at, random.between(kSoonest_s, kLatest_s)};
      continue;  // how far it is then is known already
    }
    const auto shortest_m = shortest_way_m(*ground.home, goal, options.goals);
    ground.goal.is_reachable = shortest_m.has_value();
    ground.goal.shortest_m = shortest_m.value_or(goal.shortest_m);
  }
  return grounds;
}

// As bodies are drawn in plans: an oval column.
simulation::MeshLoader with_people(simulation::MeshLoader load) {
  return [load = std::move(load)](const std::string& model) -> Expected<simulation::TriangleMesh> {
    if (model != kPersonsModel) return load(model);
    constexpr std::uint32_t kSides = 24;
    simulation::TriangleMesh mesh;
    mesh.materials.emplace_back();
    const Eigen::Vector3f size = kPersonsSize_m.cast<float>();
    const auto add = [&](const Eigen::Vector3f& place, const Eigen::Vector3f& normal) {
      mesh.positions.push_back(place);
      mesh.normals.push_back(normal);
      mesh.texture_coordinates.emplace_back(0, 0);
    };
    add({0, 0, size.z()}, Eigen::Vector3f::UnitZ());
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kSides;
      const Eigen::Vector3f out(std::cos(angle), std::sin(angle), 0);
      const Eigen::Vector3f foot = out.cwiseProduct(size) / 2;
      const Eigen::Vector3f top = foot + size.z() * Eigen::Vector3f::UnitZ();
      add(foot, out);
      add(top, out);
      add(top, Eigen::Vector3f::UnitZ());
      const std::uint32_t here = 1 + 3 * i, next = 1 + 3 * ((i + 1) % kSides);
      mesh.triangles.push_back({{here, next, next + 1}, 0});
      mesh.triangles.push_back({{here, next + 1, here + 1}, 0});
      mesh.triangles.push_back({{0, here + 2, next + 2}, 0});
    }
    return mesh;
  };
}

}  // namespace roomwise::trials
