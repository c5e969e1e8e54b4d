#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/simulation/recording/simulate_recording.h"
#include "laboratory/simulation/render/true_surfaces.h"
#include "roomwise/evaluation/errors/cloud_error.h"
#include "roomwise/evaluation/errors/floor_error.h"
#include "roomwise/evaluation/errors/object_error.h"
#include "roomwise/evaluation/report/reliability.h"
#include "roomwise/evaluation/statistics/coverage.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"

// A home against the truth of the recording that it was mapped from.
namespace roomwise::trials {

// The walk of the home that this recording is: its first and last key-frame must be pictures of it.
// Fails where there is none.
[[nodiscard]] Expected<home::RecordingId> mapped_walk(const home::Home& home,
                                                      const std::filesystem::path& recording);

// The map has a world of its own: this moves it onto that of the recording's groundtruth.txt as its
// trajectory fits best.
[[nodiscard]] Expected<geometry::RigidTransform> truth_from_map(
    const home::Home& home, const std::filesystem::path& recording);

// The home that a simulated recording shows, as its simulation.json describes it. Fails where this
// program makes another home of that description than the one that made the recording.
struct RecordedHome {
  simulation::SimulationOptions made_of;
  simulation::HomeModel model;
  simulation::TrueSurfaces surfaces;
};
[[nodiscard]] Expected<RecordedHome> recorded_home(const std::filesystem::path& recording,
                                                   const simulation::FurnitureCatalogue& catalogue);

// The place that the truth of a recording is of, by which recordings that share pictures are known:
// of a simulated one its home, whatever the time of day and what is moved; else the name of its
// folder, or of the file of what people marked in it.
[[nodiscard]] Expected<std::string> place_of(const std::filesystem::path& truth);

// The key-frames of a walk.
[[nodiscard]] std::vector<home::Keyframe> of_walk(std::vector<home::Keyframe> keyframes,
                                                  home::RecordingId walk);

// The key-frames of a walk whose true pose is known within 0.02 s, in the truth's frame.
// `recording`: of that walk (mapped_walk()). Fails where there are none.
[[nodiscard]] Expected<std::vector<home::Keyframe>> at_true_poses(
    std::vector<home::Keyframe> keyframes, home::RecordingId walk,
    const std::filesystem::path& recording);

// A key-frame that shows a thing, and where.
struct ShownIn {
  home::KeyframeId keyframe = 0;
  // Absent: it lies in part behind the camera, or only a later visit saw it, near this key-frame.
  std::optional<network::PixelBox> box;
};

// What was found one way, in the truth's frame, and how far that is from the truth.
struct FoundObjectErrors {
  std::vector<evaluation::FoundObject> found;
  evaluation::ObjectErrors errors;
  std::size_t without_place = 0;  // found, but where is not known
};

struct ObjectEvaluation {
  // What the home can name and the walk showed. Of a simulated home what it showed well is
  // expected: in four key-frames or more, from two metres or nearer, half a percent of the picture
  // or more, 15 % or more of the rectangle about its box.
  std::vector<evaluation::TrueObject> truth;
  std::vector<std::optional<ShownIn>> truth_shown;  // largest; absent where no key-frame shows it
  FoundObjectErrors by_rules;                       // the paper's way
  FoundObjectErrors naive;                          // naive_objects()
  FoundObjectErrors instances;                      // joined from regions
  std::vector<ShownIn> instances_shown;             // best, of each of instances.found
  double max_distance_m = 0;                        // from a true box, of what counts as found
  evaluation::Coverage coverage;                    // of the matched instances' middles
  // Of the instances' probabilities; what need not be found is left out.
  std::vector<evaluation::Forecast> forecasts;
};

// What is there: the folder of a simulated recording, or what people marked in a real one
// (labelling::RecordingTruth).
struct ObjectTruthFiles {
  std::filesystem::path truth;
  // The real recording that the home was mapped from; empty: where it was then.
  std::filesystem::path recording;
};

// What is there, in the home's words, and the way from the map to it.
struct HomeTruth {
  std::vector<evaluation::TrueObject> things;
  std::vector<std::optional<ShownIn>> shown;  // largest; absent where no key-frame shows it
  geometry::RigidTransform truth_from_world;
  home::RecordingId walk = 0;  // that the truth is of
};
[[nodiscard]] Expected<HomeTruth> home_truth(const home::Home& home, const ObjectTruthFiles& truth);

// Objects of the home against what is there: a thing counts as found within `max_distance_m` of its
// box. Things that the walk never showed are left out, and in a home of several walks what was
// found in pictures of others alone, where no such thing is, says nothing: the truth is not theirs.
// Of what people marked, what both readers marked alike is expected. What has several words in a
// home may be called by each (an armchair is a chair or a sofa), and what is like a thing that the
// home has a word for, and has none itself, may be called so or not be found (a stool is a chair).
[[nodiscard]] Expected<ObjectEvaluation> evaluate_objects(const home::Home& home,
                                                          const ObjectTruthFiles& truth,
                                                          double max_distance_m);

// As what a map is measured.
enum class MapSurface {
  kCloud,  // averaged points of the key-frames
  kMesh,   // vertices of the fused surface
};
struct MapEvaluationOptions {
  MapSurface surface = MapSurface::kCloud;
  double voxel_size_m = 0.02;
  // The key-frames at their true poses, where they are known within 0.02 s: what is left are the
  // sensor's errors and those of joining.
  bool at_true_poses = false;
};

// The points of the map, as the recording's walk shows it, against the surfaces of the home that
// simulation.json describes. Furniture is read from the folder of its archives. Fails where this
// program makes another home of that description than the one that made the recording.
[[nodiscard]] Expected<evaluation::CloudError> evaluate_map(const home::Home& home,
                                                            const std::filesystem::path& recording,
                                                            const std::filesystem::path& furniture,
                                                            const MapEvaluationOptions& options,
                                                            pipeline::RunContext& run);

struct FloorEvaluation {
  evaluation::FloorError error;
  double floor_above_truth_m = 0;  // of the gravity-aligned frame, in the truth's middle
  double tilt_rad = 0;             // between the gravity-aligned frame's up and the truth's
};

// The map's floor grid against the free space of floorplan.json, for a person of the radius there;
// beyond what that shows nobody may stand.
[[nodiscard]] Expected<FloorEvaluation> evaluate_floor(const home::Home& home,
                                                       const std::filesystem::path& recording,
                                                       pipeline::RunContext& run);

// Stairs of the truth, and what the map says of them; found minus true.
struct StairsError {
  bool is_found = false;
  int steps = 0, found_steps = 0;  // 0: not counted
  double foot_m = 0, top_m = 0;    // of the first riser's and the last one's middle
  double width_m = 0, heading_rad = 0;
  bool are_rails_right = false;
};

// A home's layout against floorplan.json of the simulated recording that it was mapped from.
struct LayoutEvaluation {
  double floor_m2 = 0;        // of the map's free floor that lies in a room of the truth
  double right_floor_m2 = 0;  // of it that the layout gives the same name
  std::size_t doors = 0;      // of the truth that join two rooms that the walk named
  std::size_t found_doors = 0;
  std::size_t false_doorways = 0;     // of the layout, where no such door is
  std::vector<double> door_errors_m;  // of found doors, from middle to middle
  std::size_t things = 0,
              right_things = 0;  // objects whose middle lies in their room by the layout
  std::size_t storeys = 1, found_storeys = 1, found_stairs = 0;
  std::vector<StairsError> stairs;  // of the truth
  double open_floor_m2 = 0;         // called free, and one would fall there
};

// A door counts as found where a doorway of the same two rooms lies within a metre of it.
[[nodiscard]] Expected<LayoutEvaluation> evaluate_layout(const home::Home& home,
                                                         const std::filesystem::path& recording,
                                                         pipeline::RunContext& run);

}  // namespace roomwise::trials
