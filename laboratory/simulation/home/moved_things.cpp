#include "laboratory/simulation/home/moved_things.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/furnishing.h"
#include "laboratory/simulation/home/home_checks.h"
#include "laboratory/simulation/home/room_furnisher.h"

namespace roomwise::simulation {
namespace {

constexpr std::array<std::string_view, 10> kSurfaces{
    "bed",          "chest",           "chest_of_drawers", "coffee_table",    "desk",
    "dining_table", "kitchen_cabinet", "nightstand",       "washing_machine", "tv_stand"};

// Small things that come into a home.
constexpr std::array<std::string_view, 9> kNewKinds{
    "book", "bottle", "bowl", "clothes", "cup", "fruit", "small_plant", "toy", "vase"};

bool is_surface(const PlacedObject& object) {
  return std::ranges::find(kSurfaces, object.kind) != kSurfaces.end();
}

class Mover {
 public:
  Mover(HomeModel& home, std::uint64_t seed, std::span<const FurnitureModel> models)
      : home_(home), seed_(seed), models_(models), random_(seed, {0x6d6f7665}) {
    for (const PlacedObject& object : home.objects) names_.insert(object.name);
  }

  void move() {
    turn_doors();
    take_some_away();
    for (std::size_t i = 0; i < home_.objects.size(); ++i) {
      const PlacedObject& object = home_.objects[i];
      if (carries_something(i)) continue;
      if (object.is_small && object.stands_on) {
        if (random_.uniform() < 0.65) move_small(i);
      } else if (object.is_movable && random_.uniform() < 0.75) {
        object.stands_on ? shift_on_surface(i) : shift_on_floor(i);
      }
    }
    add_new();
    follow_lamps();
  }

 private:
  [[nodiscard]] bool carries_something(std::size_t carrier) const {
    return std::ranges::any_of(
        home_.objects, [&](const PlacedObject& object) { return object.stands_on == carrier; });
  }

  [[nodiscard]] const FurnitureModel* model_of(const PlacedObject& object) const {
    const auto model = std::ranges::find(models_, object.model, &FurnitureModel::id);
    return model == models_.end() ? nullptr : &*model;
  }

  RoomFurnisher furnisher_of(std::size_t room) {
    return {home_, room, models_, RandomStream(seed_, {0x6d6f7665, room, random_.next()})};
  }

  void turn_doors() {
    for (Door& door : home_.doors) {
      if (!door.other_room || !door.has_leaf) continue;
      const double before = door.open_rad;
      const bool shuts = random_.uniform() < 0.25;
      door.open_rad = shuts ? 0 : 0.95 + 0.6 * random_.uniform();
      if (find_unreachable(home_).empty()) continue;
      door.open_rad = before;
    }
  }

  // Small and shifted things, but nothing that carries others, and no lamp: a home needs its light.
  void take_some_away() {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < home_.objects.size(); ++i) {
      const PlacedObject& object = home_.objects[i];
      const bool may_go = (object.is_small || object.is_movable) && object.kind != "lamp" &&
                          object.kind != "floor_lamp" && !carries_something(i);
      if (!may_go || random_.uniform() >= 0.12) kept.push_back(i);
    }
    std::vector<std::size_t> place(home_.objects.size());
    std::vector<PlacedObject> objects;
    for (const std::size_t i : kept) {
      place[i] = objects.size();
      objects.push_back(home_.objects[i]);
    }
    for (PlacedObject& object : objects) {
      if (object.stands_on) object.stands_on = place[*object.stands_on];
    }
    for (Light& light : home_.lights) {
      if (light.object) light.object = place[*light.object];
    }
    home_.objects = std::move(objects);
  }

  // To any surface: mostly of its room, now and then it was carried to another.
  void move_small(std::size_t index) {
    const PlacedObject object = home_.objects[index];
    const FurnitureModel* model = model_of(object);
    if (model == nullptr) return;
    const bool leaves_room = random_.uniform() < 0.2;
    std::vector<std::size_t> carriers;
    for (std::size_t i = 0; i < home_.objects.size(); ++i) {
      if (!is_surface(home_.objects[i]) || i == index) continue;
      if ((home_.objects[i].room == object.room) != leaves_room) carriers.push_back(i);
    }
    std::shuffle(carriers.begin(), carriers.end(), random_);
    for (const std::size_t carrier : carriers) {
      RoomFurnisher furnisher = furnisher_of(home_.objects[carrier].room);
      if (auto moved = furnisher.place_on(*model, carrier, object.name)) {
        home_.objects[index] = *std::move(moved);
        return;
      }
    }
  }

  void shift_on_surface(std::size_t index) {
    const PlacedObject object = home_.objects[index];
    const FurnitureModel* model = model_of(object);
    if (model == nullptr) return;
    RoomFurnisher furnisher = furnisher_of(object.room);
    if (auto moved = furnisher.place_on(*model, *object.stands_on, object.name)) {
      home_.objects[index] = *std::move(moved);
    }
  }

  void shift_on_floor(std::size_t index) {
    const RoomFurnisher furnisher = furnisher_of(home_.objects[index].room);
    constexpr int kTries = 12;
    for (int i = 0; i < kTries; ++i) {
      PlacedObject moved = home_.objects[index];
      const double away = 0.12 + 0.5 * random_.uniform();
      const double direction = 2 * std::numbers::pi * random_.uniform();
      const double turn = 1.4 * (random_.uniform() - 0.5);
      const Eigen::Vector3d step(std::cos(direction), std::sin(direction), 0);
      moved.world_from_object = upright_pose(moved.world_from_object.translation + step * away,
                                             yaw_of(moved.world_from_object) + turn);
      if (!furnisher.may_stand(moved, 0)) continue;
      home_.objects[index] = std::move(moved);
      return;
    }
  }

  void add_new() {
    const std::size_t wanted = 1 + random_.index(1 + home_.rooms.size());
    for (std::size_t i = 0; i < wanted; ++i) {
      const std::size_t room = random_.index(home_.rooms.size());
      RoomFurnisher furnisher = furnisher_of(room);
      const std::string_view kind = kNewKinds[random_.index(kNewKinds.size())];
      const auto choice = furnisher.choose(kind, 0.4);
      if (choice.empty()) continue;
      for (std::size_t carrier = 0; carrier < home_.objects.size(); ++carrier) {
        if (home_.objects[carrier].room != room || !is_surface(home_.objects[carrier])) continue;
        auto added = furnisher.place_on(*choice.front(), carrier, new_name(kind));
        if (!added) continue;
        names_.insert(added->name);
        home_.objects.push_back(*std::move(added));
        break;
      }
    }
  }

  [[nodiscard]] std::string new_name(std::string_view kind) const {
    std::string plain(kind);
    std::ranges::replace(plain, '_', ' ');
    for (int number = 2;; ++number) {
      std::string name = fmt::format("{} {}", plain, number);
      if (!names_.contains(name)) return name;
    }
  }

  void follow_lamps() {
    for (Light& light : home_.lights) {
      if (light.object) light.position = light_of_lamp(home_, *light.object).position;
    }
  }

  HomeModel& home_;
  std::uint64_t seed_;
  std::span<const FurnitureModel> models_;
  RandomStream random_;
  std::set<std::string> names_;  // of things there and gone
};

}  // namespace

void move_things(HomeModel& home, std::uint64_t seed, std::span<const FurnitureModel> models) {
  Mover(home, seed, models).move();
}

}  // namespace roomwise::simulation
