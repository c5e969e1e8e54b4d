// What a home costs that grows: memory and processor time of finishing its map, of opening it, of
// finding pictures in it and of a further walk, by the number of its key-frames:
//   large_home_benchmark FOLDER [no-floor] [whole] KEYFRAMES [KEYFRAMES ...]
// With no-floor a map is left when its floor is to be fused; with whole its landmarks are adjusted
// all at once, however many there are. The homes are made from seeds, in FOLDER, stay there, and
// are used again: KEYFRAMES.home is one whose frames are all stored and whose map is not solved
// yet, KEYFRAMES-finished.home the same with its map.
//
// A home is a building of rooms whose walls all have patterns of their own, and is walked through
// twice, the second time back: a full turn of 40 key-frames in each room each time. Its edges are
// true but for noise: they are written as mapping would have measured them, so that a large home
// costs no hours. All else (features, landmarks, index, floor, places of pictures) is found in its
// pictures. Each part runs in a process of its own on one thread beside the main one.

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "arguments.h"
#include "peak_memory.h"
#include "roomwise/base/random.h"
#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace {

using namespace roomwise;
using geometry::RigidTransform;
namespace fs = std::filesystem;

constexpr std::uint64_t kSeed = 1;
constexpr std::uint64_t kTurn = 40;  // key-frames of a full turn in a room
constexpr std::uint64_t kRow = 12;   // rooms in a row
constexpr double kApart_m = 8;       // from room to room
constexpr double kEye_m = 1.4;
constexpr double kHeight_m = 2.6;
constexpr TimestampNs kStep_ns = 200'000'000;

geometry::PinholeCamera camera() {
  return {.fx = 525,
          .fy = 525,
          .cx = 319.5,
          .cy = 239.5,
          .width = 640,
          .height = 480,
          .distortion = {},
          .depth_units_per_metre = 1000};
}

// ---- the building ----

struct Room {
  Eigen::Vector3d middle;  // half way up
  Eigen::Vector3d half;    // sizes
};

Room room(std::uint64_t index) {
  RandomStream random(kSeed, {index, 1});
  const std::uint64_t row = index / kRow;
  const std::uint64_t along = index % kRow;
  const std::uint64_t column = row % 2 == 0 ? along : kRow - 1 - along;
  return {
      {kApart_m * static_cast<double>(column), kApart_m * static_cast<double>(row), kHeight_m / 2},
      {random.between(1.5, 3), random.between(1.5, 3), kHeight_m / 2}};
}

// The room beside this one in the row before, where there is one.
std::optional<std::uint64_t> room_beside(std::uint64_t index) {
  if (index < kRow) return std::nullopt;
  return index - 1 - 2 * (index % kRow);
}

// Where a camera stands that looks along `heading_rad`, a little down; `aside_m` from the middle.
RigidTransform world_from_camera(const Room& room, double heading_rad, double aside_m) {
  constexpr double kDown_rad = 0.15;
  const Eigen::Vector3d ahead(std::cos(heading_rad), std::sin(heading_rad), 0);
  Eigen::Matrix3d axes;
  axes.col(2) = std::cos(kDown_rad) * ahead - std::sin(kDown_rad) * Eigen::Vector3d::UnitZ();
  axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  Eigen::Vector3d at = room.middle + aside_m * ahead;
  at.z() = kEye_m;
  return RigidTransform::from_matrix(axes, at);
}

// A number of 32 bits that follows from three.
std::uint32_t scramble(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::uint32_t h = a * 0x9e3779b1U ^ b * 0x85ebca77U ^ c * 0xc2b2ae3dU;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12)) * 0x297a2d39U;
  return h ^ (h >> 15);
}

// Smooth noise over a wall, 0 to 1.
float noise(std::uint32_t wall, double u, double v) {
  const double fu = std::floor(u), fv = std::floor(v);
  const auto x = static_cast<std::uint32_t>(static_cast<int>(fu));
  const auto y = static_cast<std::uint32_t>(static_cast<int>(fv));
  const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
    return static_cast<float>(scramble(wall, x + dx, y + dy) >> 8) * 0x1.0p-24F;
  };
  const auto s = static_cast<float>(u - fu), t = static_cast<float>(v - fv);
  return (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
}

float brightness(std::uint32_t wall, double u_m, double v_m) {
  return 0.1F + 0.45F * noise(wall, u_m / 0.11, v_m / 0.11) +
         0.4F * noise(wall + 1, u_m / 0.035, v_m / 0.035);
}

image::RgbdFrame picture(std::uint64_t room_index, const RigidTransform& pose) {
  const geometry::PinholeCamera lens = camera();
  const Room walls = room(room_index);
  const Eigen::Matrix3d turned = pose.rotation_matrix();
  const Eigen::Vector3d from = pose.translation - walls.middle;
  image::RgbdFrame frame;
  frame.color = image::ColorImage(lens.width, lens.height);
  frame.depth = image::DepthImage(lens.width, lens.height);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      const Eigen::Vector3d ray =
          turned * Eigen::Vector3d((x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy, 1);
      double depth_m = 1e9;
      int axis = 0;
      for (int i = 0; i < 3; ++i) {
        const double to = ((ray[i] > 0 ? walls.half[i] : -walls.half[i]) - from[i]) / ray[i];
        if (to < depth_m) {
          depth_m = to;
          axis = i;
        }
      }
      const Eigen::Vector3d hit = from + depth_m * ray;
      const auto wall = static_cast<std::uint32_t>(16 * room_index) +
                        static_cast<std::uint32_t>(4 * axis + (ray[axis] > 0 ? 2 : 0));
      const auto level = static_cast<std::uint8_t>(
          255 * brightness(wall, hit[(axis + 1) % 3] + 20, hit[(axis + 2) % 3] + 20));
      frame.color.at(x, y) = {level, static_cast<std::uint8_t>(level - level / 8),
                              static_cast<std::uint8_t>(level - level / 5)};
      frame.depth.at(x, y) =
          static_cast<std::uint16_t>(std::lround(depth_m * lens.depth_units_per_metre));
    }
  }
  return frame;
}

// ---- the walk ----

struct Stop {
  std::uint64_t room = 0;
  RigidTransform pose;
};

// Of `count` key-frames, which are whole turns; the second half goes back through all rooms.
Stop stop_of(std::uint64_t index, std::uint64_t count) {
  const bool goes_back = index >= count / 2;
  const std::uint64_t place = goes_back ? count - 1 - index : index;
  const double heading = 2 * std::numbers::pi * static_cast<double>(place % kTurn) / kTurn;
  const std::uint64_t in = place / kTurn;
  return {in, world_from_camera(room(in), heading, goes_back ? -0.25 : 0.4)};
}

scene::PoseGraphEdge noisy_edge(std::uint64_t from, std::uint64_t to, std::uint64_t count,
                                double sigma_m, double sigma_rad, bool is_robust) {
  RandomStream random(kSeed, {from, to, 2});
  geometry::Vector6d error;
  for (int i = 0; i < 3; ++i) error[i] = sigma_rad * random.normal();
  for (int i = 3; i < 6; ++i) error[i] = sigma_m * random.normal();
  scene::PoseGraphEdge edge;
  edge.from = from;
  edge.to = to;
  edge.from_from_to =
      stop_of(from, count).pose.inverse() * stop_of(to, count).pose * RigidTransform::exp(error);
  edge.information.setZero();
  edge.information.diagonal().head<3>().setConstant(1 / (sigma_m * sigma_m));
  edge.information.diagonal().tail<3>().setConstant(4 / (sigma_rad * sigma_rad));  // half angles
  edge.is_robust = is_robust;
  return edge;
}

// The edges to a key-frame from earlier ones: steps, neighbours, where the turn closes, those of
// the first time that the walk was there, the room beside.
std::vector<scene::PoseGraphEdge> edges_to(std::uint64_t index, std::uint64_t count) {
  constexpr double kNear_m = 0.004, kNear_rad = 0.002, kFar_m = 0.02, kFar_rad = 0.005;
  std::vector<scene::PoseGraphEdge> edges;
  const auto add = [&](std::uint64_t from, bool is_near, bool is_robust) {
    edges.push_back(noisy_edge(from, index, count, is_near ? kNear_m : kFar_m,
                               is_near ? kNear_rad : kFar_rad, is_robust));
  };
  const std::uint64_t of_turn = index % kTurn;
  if (index > 0) add(index - 1, of_turn > 0, false);
  for (std::uint64_t back = 2; back <= std::min<std::uint64_t>(3, of_turn); ++back)
    add(index - back, true, true);
  for (std::uint64_t i = 0; of_turn + 3 >= kTurn + i; ++i) add(index - of_turn + i, true, true);
  if (index >= count / 2) {
    const std::uint64_t there = count - 1 - index;
    add(there, true, true);
    add(there % kTurn > 0 ? there - 1 : there + 1, true, true);
  } else if (const auto beside = room_beside(index / kTurn); beside && of_turn == 0) {
    add(*beside * kTurn, false, true);
  }
  return edges;
}

// Shown frame by frame; each is encoded as a recording's would be.
image::RgbdFrame encoded(image::RgbdFrame frame) {
  frame.encoded_color = image::encode_jpeg(frame.color, 90);
  frame.encoded_depth = image::encode_png(frame.depth);
  return frame;
}

home::Recording recording_of(std::string name, std::uint64_t frames) {
  return {std::move(name), "large_home_benchmark", camera(), frames};
}

Expected<void> make_home(const fs::path& file, std::uint64_t count) {
  constexpr std::uint64_t kCommit = 50;
  ROOMWISE_TRY(home::Home home, pipeline::create_home(file));
  ROOMWISE_RETURN_IF_ERROR(pipeline::store_map_settings(home, {}));
  ROOMWISE_TRY(const auto recording, home.add_recording(recording_of("building", count)));
  home::MapCommit step;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Stop stop = stop_of(i, count);
    const image::RgbdFrame frame = encoded(picture(stop.room, stop.pose));
    const RigidTransform pose = stop_of(0, count).pose.inverse() * stop.pose;
    step.keyframes.push_back({{i, i, static_cast<TimestampNs>(i) * kStep_ns},
                              {pose, 0},
                              {frame.encoded_color, frame.encoded_depth},
                              {},
                              {}});
    for (scene::PoseGraphEdge& edge : edges_to(i, count)) step.edges.push_back(std::move(edge));
    step.frames.push_back(
        {i, static_cast<TimestampNs>(i) * kStep_ns, scene::FramePlace{i, {}}, {}});
    if ((i + 1) % kCommit != 0 && i + 1 < count) continue;
    step.recording = recording;
    step.next_frame_index = i + 1;
    ROOMWISE_RETURN_IF_ERROR(home.commit(step));
    step = {};
  }
  return {};
}

// A walk that is recorded later: turns in other rooms, half way between key-frames.
class FurtherWalk final : public recording::FrameSource {
 public:
  FurtherWalk(std::uint64_t frames, std::uint64_t of_map) : of_map_(of_map) {
    info_ = {"further walk", camera(), frames};
  }
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  void skip_before(std::uint64_t index) override { next_ = index; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (next_ == *info_.frames_remaining) return std::nullopt;
    const Stop stop = stop_at(next_);
    image::RgbdFrame frame = encoded(picture(stop.room, stop.pose));
    frame.index = next_;
    frame.timestamp_ns = static_cast<TimestampNs>(of_map_ + 100 + next_) * kStep_ns;
    ++next_;
    return frame;
  }

 private:
  // Of the rooms in the middle of the building.
  [[nodiscard]] Stop stop_at(std::uint64_t index) const {
    const std::uint64_t in = of_map_ / 2 / kTurn / 2;
    return {in,
            world_from_camera(
                room(in), 2 * std::numbers::pi * (static_cast<double>(index) + 0.5) / kTurn, 0.1)};
  }
  std::uint64_t of_map_;
  std::uint64_t next_ = 0;
  recording::SourceInfo info_;
};

// A source whose frames are all in the home.
class AtItsEnd final : public recording::FrameSource {
 public:
  explicit AtItsEnd(std::uint64_t frames) : frames_(frames) {
    info_ = {"building", camera(), std::uint64_t{0}};
  }
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  void skip_before(std::uint64_t index) override { next_ = index; }
  // The last key-frame is asked for, to know the recording by its picture.
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (next_ >= frames_) return std::nullopt;
    const Stop stop = stop_of(next_, frames_);
    image::RgbdFrame frame = encoded(picture(stop.room, stop.pose));
    frame.index = next_;
    frame.timestamp_ns = static_cast<TimestampNs>(next_) * kStep_ns;
    ++next_;
    return frame;
  }

 private:
  std::uint64_t frames_;
  std::uint64_t next_ = 0;
  recording::SourceInfo info_;
};

// ---- what is measured ----

struct Task {
  bool fuses_floor = true;
  pipeline::MapSettings settings;
};

// Processor time and peak memory of each piece of work, and of what is between them.
class PartsOfWork final : public Progress {
 public:
  explicit PartsOfWork(bool fuses_floor) : fuses_floor_(fuses_floor) { reset(); }
  [[nodiscard]] bool interrupted() const override {
    return !fuses_floor_ && work_ == "fusing the map";
  }
  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    take(between_);
    work_ = work;
  }
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {
    take(work_);
    between_ = "after " + work_;
  }
  void print() {
    take(between_);
    for (const auto& [name, part] : parts_)
      fmt::print("    {}: {:.1f} CPU-s, peak {:.0f} MB\n", name, part.cpu_s, part.peak_mb);
  }
  [[nodiscard]] double peak_mb() const {
    double peak = 0;
    for (const auto& [name, part] : parts_) peak = std::max(peak, part.peak_mb);
    return peak;
  }

 private:
  struct Part {
    double cpu_s = 0;
    double peak_mb = 0;
  };
  void reset() {
    begin_s_ = process_cpu_time_s();
    bench::reset_peak_memory();
  }
  void take(const std::string& name) {
    auto known = std::ranges::find(parts_, name, [](const auto& part) { return part.first; });
    if (known == parts_.end()) known = parts_.insert(parts_.end(), {name, {}});
    known->second.cpu_s += process_cpu_time_s() - begin_s_;
    known->second.peak_mb = std::max(known->second.peak_mb, bench::peak_mb());
    reset();
  }
  bool fuses_floor_;
  std::vector<std::pair<std::string, Part>> parts_;
  std::string work_, between_ = "before";
  double begin_s_ = 0;
};

void print_stages(const StageClock& clock) {
  for (const auto& [name, stage] : clock.stages())
    fmt::print("    stage {}: {:.2f} CPU-s, {:.2f} s\n", name, stage.cpu_s, stage.wall_s);
}

// How far key-frames are from where they were taken, after a rigid motion that fits best.
Expected<double> keyframe_error_m(const home::Home& home, std::uint64_t count) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  Eigen::Matrix3Xd truth(3, count), estimate(3, count);
  for (std::uint64_t i = 0; i < count; ++i) {
    truth.col(static_cast<Eigen::Index>(i)) = stop_of(i, count).pose.translation;
    estimate.col(static_cast<Eigen::Index>(i)) = keyframes[i].pose.world_from_keyframe.translation;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(estimate, truth, false);
  const Eigen::Matrix3Xd moved =
      (fit.topLeftCorner<3, 3>() * estimate).colwise() + fit.topRightCorner<3, 1>().eval();
  return std::sqrt((moved - truth).colwise().squaredNorm().mean());
}

// The same within each room: what a picture's place there is as good as.
Expected<double> error_in_rooms_m(const home::Home& home, std::uint64_t count) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  double squares = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t first = stop_of(i, count).room * kTurn;
    const RigidTransform truth = stop_of(first, count).pose.inverse() * stop_of(i, count).pose;
    const RigidTransform estimate =
        keyframes[first].pose.world_from_keyframe.inverse() * keyframes[i].pose.world_from_keyframe;
    squares += (truth.translation - estimate.translation).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(count));
}

Expected<void> finish(const fs::path& file, std::uint64_t count, const Task& task) {
  ROOMWISE_TRY(home::Home home, home::Home::open(file));
  ThreadPool pool(1);
  StageClock clock;
  PartsOfWork parts(task.fuses_floor);
  pipeline::RunContext run{pool, parts, clock};
  AtItsEnd source(count);
  const double begin_s = process_cpu_time_s();
  ROOMWISE_TRY(const auto summary, pipeline::map_recording(source, recording_of("building", count),
                                                           home, {}, task.settings, run));
  fmt::print("  finish: {:.1f} CPU-s, {} edges, {} left out, {} landmarks, {} views\n",
             process_cpu_time_s() - begin_s, summary.edges, summary.rejected_edges,
             summary.landmarks, summary.landmark_views);
  parts.print();
  print_stages(clock);
  ROOMWISE_TRY(const double error_m, keyframe_error_m(home, count));
  ROOMWISE_TRY(const double in_rooms_m, error_in_rooms_m(home, count));
  fmt::print("    {:.1f} MB peak; key-frames {:.4f} m off, in their rooms {:.4f} m\n",
             parts.peak_mb(), error_m, in_rooms_m);
  return {};
}

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Expected<void> locate(const fs::path& file, std::uint64_t count) {
  constexpr std::uint64_t kQuestions = 40;
  ThreadPool pool(1);
  StageClock clock;
  SilentProgress silent;
  pipeline::RunContext run{pool, silent, clock};
  std::vector<double> cpu_ms;
  std::uint64_t right = 0, wrong = 0;
  const std::uint64_t rooms = count / 2 / kTurn;
  std::vector<image::RgbdFrame> pictures;
  std::vector<Stop> stops;
  RandomStream random(kSeed, {3});
  for (std::uint64_t i = 0; i < kQuestions; ++i) {
    const std::uint64_t in = random.index(rooms);
    stops.push_back({in, world_from_camera(room(in), random.between(0, 2 * std::numbers::pi),
                                           random.between(-0.5, 0.5))});
    pictures.push_back(picture(in, stops.back().pose));
  }
  const double before_mb = bench::peak_mb();
  bench::reset_peak_memory();
  const double begin_s = process_cpu_time_s(), begin_wall_s = seconds_now();
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(file));
  const double opened_s = process_cpu_time_s();
  ROOMWISE_TRY(const auto localizer, pipeline::HomeLocalizer::create(home, {}, run));
  const double ready_s = process_cpu_time_s();
  double first_wall_s = 0, last_s = ready_s;
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (std::uint64_t i = 0; i < kQuestions; ++i) {
    ROOMWISE_TRY(const auto measured,
                 localizer.measure({pictures[i].color, pictures[i].depth, camera()}));
    const auto place = localizer.localizer().locate({measured, camera()});
    if (i == 0) first_wall_s = seconds_now() - begin_wall_s;
    const double now_s = process_cpu_time_s();
    cpu_ms.push_back(1000 * (now_s - last_s));
    last_s = now_s;
    if (!place.found()) continue;
    // Relative to the room's first key-frame.
    const std::uint64_t first = stops[i].room * kTurn;
    const RigidTransform truth = stop_of(first, count).pose.inverse() * stops[i].pose;
    const RigidTransform found =
        keyframes[first].pose.world_from_keyframe.inverse() * place.world_from_camera;
    (((truth.inverse() * found).distance_m() < 0.1) ? right : wrong) += 1;
  }
  fmt::print(
      "  locate: opened {:.2f} CPU-s, ready {:.2f} CPU-s, first picture {:.0f} CPU-ms, first "
      "answer after {:.2f} s; others {:.0f} CPU-ms in the median; {} of {} right, {} wrong; peak "
      "{:.0f} MB ({:.0f} before)\n",
      opened_s - begin_s, ready_s - opened_s, cpu_ms.front(), first_wall_s,
      evaluation::quantile({cpu_ms.begin() + 1, cpu_ms.end()}, 0.5), right, kQuestions, wrong,
      bench::peak_mb(), before_mb);
  return {};
}

Expected<void> map_further(const fs::path& file, std::uint64_t count, const Task& task) {
  constexpr std::uint64_t kFrames = 2 * kTurn;
  ROOMWISE_TRY(home::Home home, home::Home::open(file));
  // Without its floor the first walk is not finished yet; the further one takes it for that.
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (!recordings.back().finished)
    ROOMWISE_RETURN_IF_ERROR(home.finish_recording(recordings.back().id));
  ThreadPool pool(1);
  StageClock clock;
  PartsOfWork parts(task.fuses_floor);
  pipeline::RunContext run{pool, parts, clock};
  FurtherWalk source(kFrames, count);
  const double begin_s = process_cpu_time_s();
  ROOMWISE_TRY(const auto summary,
               pipeline::map_recording(source, recording_of("further walk", kFrames), home, {},
                                       task.settings, run));
  fmt::print("  further walk of {} frames: {:.1f} CPU-s, {} key-frames, {}joined\n", kFrames,
             process_cpu_time_s() - begin_s, summary.keyframes, summary.is_joined ? "" : "not ");
  parts.print();
  print_stages(clock);
  fmt::print("    {:.1f} MB peak\n", parts.peak_mb());
  return {};
}

// In a process of its own.
template <typename Work>
bool succeeds(const Work& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    const Expected<void> done = work();
    if (!done) fmt::print(stderr, "{}\n", done.error().message);
    std::fflush(stdout);
    _exit(done ? 0 : 1);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

bool measure(const fs::path& folder, std::uint64_t count, const Task& task) {
  const fs::path begun = folder / fmt::format("{}.home", count);
  const fs::path finished = folder / fmt::format("{}-finished.home", count);
  const fs::path joined = folder / fmt::format("{}-joined.home", count);
  const fs::path making = folder / fmt::format("{}-making.home", count);
  fs::remove(making);
  if (!fs::exists(begun)) {
    if (!succeeds([&] { return make_home(making, count); })) return false;
    fs::rename(making, begun);
  }
  fmt::print("{} key-frames, {} rooms, {:.0f} MB\n", count, count / 2 / kTurn,
             static_cast<double>(fs::file_size(begun)) / (1 << 20));
  if (!fs::exists(finished)) {
    fs::copy_file(begun, making, fs::copy_options::overwrite_existing);
    if (!succeeds([&] { return finish(making, count, task); })) return false;
    fs::rename(making, finished);
  }
  if (!succeeds([&] { return locate(finished, count); })) return false;
  fs::copy_file(finished, joined, fs::copy_options::overwrite_existing);
  const bool has_joined = succeeds([&] { return map_further(joined, count, task); });
  fs::remove(joined);
  return has_joined;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr std::string_view kUsage =
      "large_home_benchmark FOLDER [no-floor] [whole] KEYFRAMES [KEYFRAMES ...]";
  cv::setNumThreads(1);
  Task task;
  int first = 2;
  for (; first < argc; ++first) {
    const std::string_view word = argv[first];
    if (word == "no-floor") {
      task.fuses_floor = false;
    } else if (word == "whole") {
      task.settings.refinement.max_keyframes = std::numeric_limits<std::size_t>::max();
    } else {
      break;
    }
  }
  if (argc <= first) {
    fmt::print(stderr, "usage: {}\n", kUsage);
    return 2;
  }
  for (int i = first; i < argc; ++i) {
    const auto count = bench::parse_count(argv[i], kUsage);
    if (!count || static_cast<std::uint64_t>(*count) % (2 * kTurn) != 0) {
      fmt::print(stderr, "'{}' is no multiple of {}; usage: {}\n", argv[i], 2 * kTurn, kUsage);
      return 2;
    }
    if (!measure(argv[1], static_cast<std::uint64_t>(*count), task)) return 1;
  }
  return 0;
}
