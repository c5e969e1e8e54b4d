#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

// The truth that lies beside a simulated recording, as JSON. World frame: that of groundtruth.txt,
// z up, the floor is z = 0, metres.
namespace roomwise::simulation {

// objects.json:
//   {"objects": [{
//     "name": "chair 3",            unique in the home
//     "kind": "dining_table",       of the furniture catalogue
//     "label": "dining table",      what people call it, and Roomwise: "toilet seat", "lamp"
//     "room": "living room",        as in floorplan.json
//     "center": [x, y, z],          of its box
//     "size": [width, depth, height],
//     "yaw_rad": 1.57,              of the box about z: width lies along (cos yaw, sin yaw)
//     "model": "scopia/chair", "creator": "...", "license": "...",
//     "seen": [[frame, pixels, share of the image], ...]}]}   frames count from 0
struct ObjectObservation {
  std::uint64_t frame = 0;
  std::uint64_t pixels = 0;
  double share = 0;  // of the image's pixels

  friend bool operator==(const ObjectObservation&, const ObjectObservation&) = default;
};

struct ObjectTruth {
  std::string name, kind, label, room;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0;
  std::string model, creator, license;
  std::vector<ObjectObservation> seen;  // by frame
};

// Counts what the object images of a walk show (see RenderedFrame::object). Frames may come in any
// order.
class ObservationCounter {
 public:
  explicit ObservationCounter(std::size_t objects) : seen_(objects) {}

  void add(std::uint64_t frame, const image::Image<std::uint16_t>& object_image);
  // Of an object of the home, by frame.
  [[nodiscard]] std::vector<ObjectObservation> of(std::size_t object) const;

 private:
  std::vector<std::vector<ObjectObservation>> seen_;
};

// All objects of a home, in its order.
[[nodiscard]] std::vector<ObjectTruth> objects_truth(const HomeModel& home,
                                                     std::span<const FurnitureModel> models,
                                                     const ObservationCounter& observations);

[[nodiscard]] Expected<void> write_objects_truth(const std::filesystem::path& path,
                                                 std::span<const ObjectTruth> objects);
// Fails, naming the file and the field, where it is not such a file.
[[nodiscard]] Expected<std::vector<ObjectTruth>> read_objects_truth(
    const std::filesystem::path& path);

// floorplan.json:
//   {"home_seed": 7, "scenario": "day", "ceiling_height": 2.6, "wall_thickness": 0.12,
//    "rooms": [{"name", "kind", "min": [x, y], "max": [x, y]}],        between the walls' faces
//    "walls": [{"from": [x, y], "to": [x, y]}],                        the walls' middle planes
//    "doors": [{"center": [x, y], "along_x", "width", "top", "rooms": [name, name], "has_leaf",
//               "open_rad"}],                                          one name: the front door
//    "windows": [{"center": [x, y], "along_x", "width", "bottom", "top", "room"}],
//    "free_space": {"origin": [x, y], "cell": 0.05, "person_radius": 0.25,
//                   "rows": ["..##", ...]}}   from low y; '.' where a person's middle may be
// Of a home of several storeys, which are drawn side by side (a point of the world is one of the
// plan and its storey's world_from_plan, from the lowest storey on), besides:
//    "storeys": [{"world_from_plan": [x, y, z]}],  and of a room "storey", from 0, and "open_floor"
//    "stairs": [{"rooms": [lower, upper], "foot": [x, y], "up": [x, y], "width", "steps", "rise",
//                "going", "rails": ["left", "right"]}]   the foot: of the first riser; for who
//                climbs
struct WallSegment {
  Eigen::Vector2d from = Eigen::Vector2d::Zero(), to = Eigen::Vector2d::Zero();
};
struct FreeSpaceTruth {
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  // lower corner of the first cell
  double cell_m = 0;
  double person_radius_m = 0;
  std::vector<std::string> rows;
};
struct FloorPlanTruth {
  std::vector<Room> rooms;  // name, kind and interior
  std::vector<WallSegment> walls;
  std::vector<Door> doors;
  std::vector<Window> windows;
  double ceiling_height_m = 0, wall_thickness_m = 0;
  FreeSpaceTruth free_space;
  std::vector<Storey> storeys{Storey{}};
  std::vector<Staircase> stairs;

  // A place of the world on the plan, by its height; and a place of the plan on its floor.
  [[nodiscard]] Eigen::Vector2d plan_from_world(const Eigen::Vector3d& place_world) const;
  [[nodiscard]] Eigen::Vector3d world_from_plan(const Eigen::Vector2d& place_plan) const;
};

[[nodiscard]] std::vector<WallSegment> walls_of(const HomeModel& home);
[[nodiscard]] Expected<void> write_floor_plan(const std::filesystem::path& path,
                                              const HomeModel& home);
[[nodiscard]] Expected<FloorPlanTruth> read_floor_plan(const std::filesystem::path& path);

}  // namespace roomwise::simulation
