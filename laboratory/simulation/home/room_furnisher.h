#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/furnishing_rules.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {

// Between a wall and what stands before it (the skirting board) or hangs on it.
constexpr double kStandingWallGap = 0.03;
constexpr double kHangingWallGap = 0.005;

// A side of a room, seen from inside: the wall's inner face.
struct WallSide {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();    // its left end for one who looks at it
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();  // to the right
  Eigen::Vector2d inward = Eigen::Vector2d::UnitY();
  double length_m = 0;
};
[[nodiscard]] std::array<WallSide, 4> sides_of(const Rectangle& room);

// Puts things into one room, each where it touches nothing, covers no window, leaves doors free,
// and leaves a way for a person to all that stands in the room.
class RoomFurnisher {
 public:
  RoomFurnisher(HomeModel& home, std::size_t room, std::span<const FurnitureModel> models,
                RandomStream random);

  [[nodiscard]] const Room& room() const { return home_.rooms[room_]; }
  [[nodiscard]] HomeModel& home() { return home_; }
  [[nodiscard]] RandomStream& random() { return random_; }

  // As many pieces as the rule and chance ask for and as find a place.
  void follow(const FurnitureRule& rule);

  // The models of a kind that suit a rule's limits, in random order.
  [[nodiscard]] std::vector<const FurnitureModel*> choose(const FurnitureRule& rule);
  [[nodiscard]] std::vector<const FurnitureModel*> choose(std::string_view kind,
                                                          double max_width_m = 9,
                                                          double max_height_m = 9);
  [[nodiscard]] std::size_t count(std::string_view kind) const;

  // Where a model stands with its back to a side, `along_m` from the side's left end to its middle.
  [[nodiscard]] PlacedObject against(const FurnitureModel& model, const WallSide& side,
                                     double along_m) const;
  // Adds it if it may stand there with that much free floor before it.
  bool try_add(PlacedObject object, double front_m);
  // Whether it touches nothing, covers no window and stands in no one's way.
  [[nodiscard]] bool fits(const PlacedObject& object, double front_m) const;
  // The same, and whether all in the room can still be reached with it there.
  [[nodiscard]] bool may_stand(const PlacedObject& object, double front_m) const;
  // A place for a model on the surface of an object. A thing of the same name is taken to be the
  // one that is moved.
  [[nodiscard]] std::optional<PlacedObject> place_on(const FurnitureModel& model,
                                                     std::size_t carrier,
                                                     const std::string& name = {});
  // Whether a thing that reaches from wall to `top_m` before a side would cover a window.
  [[nodiscard]] bool covers_window(const Footprint& footprint) const;

 private:
  struct Candidate {
    double score;
    PlacedObject object;
  };

  bool place(const FurnitureRule& rule, const FurnitureModel& model);
  [[nodiscard]] std::vector<Candidate> candidates(const FurnitureRule& rule,
                                                  const FurnitureModel& model);
  void at_walls(const FurnitureRule& rule, const FurnitureModel& model,
                std::vector<Candidate>& out);
  void in_middle(const FurnitureModel& model, std::vector<Candidate>& out);
  void at_anchor(const FurnitureRule& rule, const FurnitureModel& model, const PlacedObject& anchor,
                 std::vector<Candidate>& out);
  void around(const FurnitureModel& model, const Footprint& base, std::vector<Candidate>& out);
  void on_floor(const FurnitureModel& model, const Footprint& base, std::vector<Candidate>& out);
  void on_top(const FurnitureModel& model, std::size_t anchor, std::vector<Candidate>& out);
  // Whether a thing on a surface stands in the way of a microwave's door.
  [[nodiscard]] bool stands_before_front(const PlacedObject& object) const;
  void under_windows(const FurnitureModel& model, std::vector<Candidate>& out);
  [[nodiscard]] PlacedObject make(const FurnitureModel& model, const Eigen::Vector3d& bottom,
                                  double yaw_rad) const;
  [[nodiscard]] std::vector<std::size_t> anchors_of(const FurnitureRule& rule) const;
  [[nodiscard]] bool keeps_ways_free(const PlacedObject& object) const;
  [[nodiscard]] bool touches_curtain(const Footprint& footprint) const;
  [[nodiscard]] bool touches_anything(const PlacedObject& object) const;
  void add(PlacedObject object, double front_m);

  HomeModel& home_;
  std::size_t room_;
  std::span<const FurnitureModel> models_;
  RandomStream random_;
  std::vector<Footprint> door_zones_;  // nothing stands in them
  std::vector<Footprint> curtains_;
  struct AccessZone {
    std::size_t owner;
    Footprint zone;
  };
  std::vector<AccessZone> access_zones_;  // nothing but what belongs to the owner
  std::optional<std::size_t> anchor_;     // of the piece in hand
};

}  // namespace roomwise::simulation
