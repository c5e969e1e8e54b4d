// The part of Home that stores recordings and the map: key-frames, frames, pose graph.

#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "roomwise/home/home.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

using geometry::Matrix6d;

constexpr std::size_t kUpperTriangleSize = 21;

// Row by row; the numbers come back to the bit.
std::string upper_triangle_json(const Matrix6d& information) {
  nlohmann::json numbers = nlohmann::json::array();
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) numbers.push_back(information(row, column));
  }
  return numbers.dump();
}

std::optional<Matrix6d> from_upper_triangle_json(const std::string& text) {
  const auto numbers = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!numbers.is_array() || numbers.size() != kUpperTriangleSize) return std::nullopt;
  Matrix6d information;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      const auto& number = numbers[next++];
      if (!number.is_number()) return std::nullopt;
      information(row, column) = information(column, row) = number.get<double>();
    }
  }
  return information;
}

// But for rounding; only the upper triangle is kept.
bool is_symmetric(const Matrix6d& m) {
  const Matrix6d difference = m - m.transpose();
  return (difference.array().abs() <= 1e-9 * m.array().abs()).all();
}

// What is wrong with the order of a step's frames, which must continue what is stored.
Expected<void> check_frame_order(const std::string& file, const MapCommit& step,
                                 std::uint64_t stored_below) {
  std::uint64_t least = stored_below;
  for (const Frame& frame : step.frames) {
    if (frame.index < least) {
      return fail("{}: frame {} is stored already or out of order; expected {} or later", file,
                  frame.index, least);
    }
    least = frame.index + 1;
  }
  if (step.next_frame_index < least) {
    return fail("{}: the next frame is said to be {}, but frames below {} are stored", file,
                step.next_frame_index, least);
  }
  return {};
}

// As the schema's check names them.
constexpr std::array<std::pair<scene::MotionUse, std::string_view>, 3> kUses{{
    {scene::MotionUse::kTaken, "taken"},
    {scene::MotionUse::kDropped, "dropped"},
    {scene::MotionUse::kAlone, "alone"},
}};

std::string_view name_of(scene::MotionUse use) {
  return std::ranges::find(kUses, use, [](const auto& pair) { return pair.first; })->second;
}

scene::MotionUse use_of(std::string_view name) {
  const auto* found = std::ranges::find(kUses, name, [](const auto& pair) { return pair.second; });
  return found == kUses.end() ? scene::MotionUse::kDropped : found->first;
}

std::optional<Eigen::Vector3d> up_column(const Statement& row, int first) {
  if (!row.column<std::optional<double>>(first)) return std::nullopt;
  const auto n = row.columns<3>(first);
  return Eigen::Vector3d(n[0], n[1], n[2]);
}

Frame read_frame(const Statement& row) {
  Frame frame{.index = row.column<std::uint64_t>(0),
              .timestamp_ns = row.column<TimestampNs>(1),
              .place = {},
              .no_pose_reason = row.column<std::string>(10)};
  if (const auto keyframe = row.column<std::optional<KeyframeId>>(2)) {
    frame.place = FramePlace{*keyframe, pose_column(row, 3)};
  }
  if (const auto use = row.column<std::optional<std::string>>(11)) {
    frame.motion = scene::FrameMotion{{pose_column(row, 12), up_column(row, 19)}, use_of(*use)};
  }
  return frame;
}

// The data of one row of derived_data, read and written where they stand: of a large map they are
// large, and SQLite would copy them whole, once or twice.
class BlobInPlace {
 public:
  static Expected<BlobInPlace> open(const Database& database, std::int64_t row, bool writes) {
    sqlite3_blob* blob = nullptr;
    const int result = sqlite3_blob_open(database.handle(), "main", "derived_data", "data", row,
                                         writes ? 1 : 0, &blob);
    BlobInPlace opened(database, blob);
    if (result != SQLITE_OK) return Unexpected(opened.error());
    return opened;
  }

  [[nodiscard]] Expected<void> write(const Bytes& data) const {
    // SQLite makes no row of more bytes than an int tells.
    if (data.empty() ||
        sqlite3_blob_write(blob_.get(), data.data(), static_cast<int>(data.size()), 0) == SQLITE_OK)
      return {};
    return Unexpected(error());
  }
  [[nodiscard]] Expected<Bytes> read() const {
    const int size = sqlite3_blob_bytes(blob_.get());
    Bytes data(static_cast<std::size_t>(size));
    if (size == 0 || sqlite3_blob_read(blob_.get(), data.data(), size, 0) == SQLITE_OK) return data;
    return Unexpected(error());
  }

 private:
  struct Closer {
    void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
  };
  BlobInPlace(const Database& database, sqlite3_blob* blob) : database_(&database), blob_(blob) {}
  [[nodiscard]] Error error() const {
    return describe_error(database_->handle(), database_->file());
  }

  const Database* database_;
  std::unique_ptr<sqlite3_blob, Closer> blob_;
};

#define ROOMWISE_RECORDING_COLUMNS                                                      \
  "name, folder, fx_px, fy_px, cx_px, cy_px, width_px, height_px, distortion_k1, "      \
  "distortion_k2, distortion_p1, distortion_p2, distortion_k3, depth_units_per_metre, " \
  "frame_count, next_frame_index, finished"

StoredRecording read_recording(const Statement& row) {
  const geometry::PinholeCamera camera{
      .fx = row.column<double>(3),
      .fy = row.column<double>(4),
      .cx = row.column<double>(5),
      .cy = row.column<double>(6),
      .width = row.column<int>(7),
      .height = row.column<int>(8),
      .distortion = {row.column<double>(9), row.column<double>(10), row.column<double>(11),
                     row.column<double>(12), row.column<double>(13)},
      .depth_units_per_metre = row.column<double>(14)};
  return {.id = row.column<RecordingId>(0),
          .recording = {.name = row.column<std::string>(1),
                        .folder = row.column<std::string>(2),
                        .camera = camera,
                        .frame_count = row.column<std::optional<std::uint64_t>>(15)},
          .next_frame_index = row.column<std::uint64_t>(16),
          .finished = row.column<bool>(17),
          .readout_s = row.column<std::optional<double>>(18)};
}

// What would be lost with its key-frame and comes from nowhere else.
constexpr std::array<std::string_view, 5> kHoldingTables{"edit_places", "own_things", "instances",
                                                         "past_instances", "visit_pictures"};

// Where numbers of key-frames stand: table and column.
Expected<std::vector<std::pair<std::string, std::string>>> keyframe_columns(
    const Database& database) {
  const auto read = [](const Statement& row) {
    return std::pair(row.column<std::string>(0), row.column<std::string>(1));
  };
  ROOMWISE_TRY(auto columns, (collect<std::vector<std::pair<std::string, std::string>>>(
                                 database,
                                 "SELECT tables.name, keys.\"from\" FROM sqlite_master AS tables, "
                                 "pragma_foreign_key_list(tables.name) AS keys "
                                 "WHERE tables.type = 'table' AND keys.\"table\" = 'keyframes'",
                                 read)));
  columns.emplace_back("keyframes", "keyframe_id");
  return columns;
}

Keyframe read_keyframe(const Statement& row) {
  return {{row.column<KeyframeId>(0), row.column<std::uint64_t>(1), row.column<TimestampNs>(2)},
          row.column<RecordingId>(3),
          {pose_column(row, 4), row.column<std::uint64_t>(11)}};
}

}  // namespace

Expected<RecordingId> Home::add_recording(const Recording& recording) {
  const geometry::PinholeCamera& camera = recording.camera;
  if (auto valid = camera.validate(); !valid) {
    return Unexpected(std::move(valid).error().with_context(
        fmt::format("{}: camera of recording '{}'", file(), recording.name)));
  }
  const geometry::LensDistortion& lens = camera.distortion;
  return database_.insert("recordings (" ROOMWISE_RECORDING_COLUMNS ")", recording.name,
                          recording.folder, camera.fx, camera.fy, camera.cx, camera.cy,
                          camera.width, camera.height, lens.k1, lens.k2, lens.p1, lens.p2, lens.k3,
                          camera.depth_units_per_metre, recording.frame_count,
                          /*next_frame_index=*/0, /*finished=*/false);
}

Expected<std::vector<StoredRecording>> Home::recordings() const {
  return collect<std::vector<StoredRecording>>(database_,
                                               "SELECT recording_id, " ROOMWISE_RECORDING_COLUMNS
                                               ", readout_s FROM recordings ORDER BY recording_id",
                                               read_recording);
}

Expected<void> Home::commit(const MapCommit& step) {
  const auto write = [&]() -> Expected<void> {
    ROOMWISE_TRY(
        const auto stored_below,
        database_.find<std::uint64_t>(
            "SELECT next_frame_index FROM recordings WHERE recording_id = ?", step.recording));
    if (!stored_below) return fail("{}: has no recording {}", file(), step.recording);
    ROOMWISE_RETURN_IF_ERROR(check_frame_order(file(), step, *stored_below));
    for (const NewKeyframe& keyframe : step.keyframes) {
      ROOMWISE_RETURN_IF_ERROR(insert_keyframe(step.recording, keyframe));
    }
    for (const scene::PoseGraphEdge& edge : step.edges) ROOMWISE_RETURN_IF_ERROR(insert_edge(edge));
    for (const Frame& frame : step.frames) {
      ROOMWISE_RETURN_IF_ERROR(insert_frame(step.recording, frame));
    }
    return database_.run("UPDATE recordings SET next_frame_index = ? WHERE recording_id = ?",
                         step.next_frame_index, step.recording);
  };
  return atomically(write);
}

Expected<void> Home::insert_keyframe(RecordingId recording, const NewKeyframe& keyframe) {
  ROOMWISE_TRY(const KeyframeId next, next_keyframe_id());
  if (keyframe.id != next) {
    return fail("{}: the next key-frame must have the number {}, not {}", file(), next,
                keyframe.id);
  }
  if (!keyframe.pose.world_from_keyframe.is_finite()) {
    return fail("{}: the pose of key-frame {} is not finite", file(), keyframe.id);
  }
  if (keyframe.images.color.empty() || keyframe.images.depth.empty()) {
    return fail("{}: key-frame {} comes without its encoded colour or depth image", file(),
                keyframe.id);
  }
  ROOMWISE_RETURN_IF_ERROR(
      database_.add("keyframes (keyframe_id, recording_id, frame_index, timestamp_ns, tx_m, ty_m, "
                    "tz_m, qx, qy, qz, qw, component)",
                    keyframe.id, recording, keyframe.frame_index, keyframe.timestamp_ns,
                    to_numbers(keyframe.pose.world_from_keyframe), keyframe.pose.component));
  ROOMWISE_TRY(const Bytes color,
               encrypt_if_protected(keyframe.id, PictureKind::kColor, keyframe.images.color));
  ROOMWISE_TRY(const Bytes depth,
               encrypt_if_protected(keyframe.id, PictureKind::kDepth, keyframe.images.depth));
  ROOMWISE_RETURN_IF_ERROR(
      database_.add("keyframe_images (keyframe_id, color, depth)", keyframe.id, color, depth));
  for (const image::DepthView& view : keyframe.depth_views) {
    ROOMWISE_RETURN_IF_ERROR(insert_depth_view(keyframe.id, view));
  }
  for (const auto& [network, prediction] : keyframe.predictions) {
    ROOMWISE_RETURN_IF_ERROR(put_prediction(keyframe.id, network, prediction));
  }
  return put_observations(keyframe.id, keyframe.observations);
}

Expected<void> Home::insert_depth_view(KeyframeId keyframe, const image::DepthView& view) {
  if (!view.frame_from_view.is_finite()) {
    return fail("{}: the pose of a depth image after key-frame {} is not finite", file(), keyframe);
  }
  // Sealed pictures are bound to their number, so that is needed first.
  ROOMWISE_TRY(const auto id,
               database_.insert(
                   "keyframe_depth_views (keyframe_id, tx_m, ty_m, tz_m, qx, qy, qz, qw, depth)",
                   keyframe, to_numbers(view.frame_from_view), Bytes()));
  ROOMWISE_TRY(const Bytes depth,
               encrypt_if_protected(static_cast<KeyframeId>(id), PictureKind::kDepthView,
                                    view.encoded_depth));
  return database_.run("UPDATE keyframe_depth_views SET depth = ? WHERE depth_view_id = ?", depth,
                       id);
}

Expected<void> Home::insert_edge(const scene::PoseGraphEdge& edge) {
  const Matrix6d& information = edge.information;
  if (!edge.from_from_to.is_finite() || !information.allFinite() || !is_symmetric(information)) {
    return fail(
        "{}: the edge from key-frame {} to {} is not finite, or its information is not "
        "symmetric",
        file(), edge.from, edge.to);
  }
  return database_.add(
      "pose_graph_edges (from_keyframe_id, to_keyframe_id, tx_m, ty_m, tz_m, qx, qy, qz, qw, "
      "information_upper, is_robust, is_device_motion)",
      edge.from, edge.to, to_numbers(edge.from_from_to), upper_triangle_json(information),
      edge.is_robust, edge.is_device_motion);
}

Expected<void> Home::insert_frame(RecordingId recording, const Frame& frame) {
  std::optional<KeyframeId> keyframe;
  std::optional<PoseNumbers> pose;
  std::optional<std::string> reason;
  if (frame.place) {
    if (!frame.place->keyframe_from_camera.is_finite()) {
      return fail("{}: the pose of frame {} is not finite", file(), frame.index);
    }
    keyframe = frame.place->keyframe;
    pose = to_numbers(frame.place->keyframe_from_camera);
  } else {
    reason = frame.no_pose_reason;
  }
  ROOMWISE_RETURN_IF_ERROR(database_.add(
      "frames (recording_id, frame_index, timestamp_ns, keyframe_id, tx_m, ty_m, tz_m, qx, qy, qz, "
      "qw, no_pose_reason)",
      recording, frame.index, frame.timestamp_ns, keyframe, pose, reason));
  return frame.motion ? insert_motion(recording, frame.index, *frame.motion) : Expected<void>();
}

Expected<void> Home::insert_motion(RecordingId recording, std::uint64_t frame_index,
                                   const scene::FrameMotion& motion) {
  const auto& [world_from_camera, up] = motion.device;
  if (!world_from_camera.is_finite() || (up && !up->allFinite())) {
    return fail("{}: the device's motion at frame {} is not finite", file(), frame_index);
  }
  std::optional<std::array<double, 3>> up_numbers;
  if (up) up_numbers = {up->x(), up->y(), up->z()};
  return database_.add(
      "device_motions (recording_id, frame_index, tx_m, ty_m, tz_m, qx, qy, qz, qw, up_x, up_y, "
      "up_z, use)",
      recording, frame_index, to_numbers(world_from_camera), up_numbers, name_of(motion.use));
}

Expected<void> Home::put_readout(RecordingId id, double readout_s) {
  if (!std::isfinite(readout_s)) return fail("{}: a readout time is not finite", file());
  return database_.run("UPDATE recordings SET readout_s = ? WHERE recording_id = ?", readout_s, id);
}

Expected<void> Home::put_derived_data(const DerivedData& data) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        database_.run("INSERT OR REPLACE INTO derived_data (name, made_from, data) "
                      "VALUES (?, ?, zeroblob(?))",
                      data.name, data.made_from, data.data.size()));
    ROOMWISE_TRY(const BlobInPlace blob,
                 BlobInPlace::open(database_, sqlite3_last_insert_rowid(database_.handle()),
                                   /*writes=*/true));
    return blob.write(data.data);
  });
}

Expected<std::optional<DerivedData>> Home::derived_data(const std::string& name) const {
  // The row stays open meanwhile, so that all of it is of one state of the home.
  const auto read = [&](const Statement& row) -> Expected<DerivedData> {
    ROOMWISE_TRY(const BlobInPlace blob,
                 BlobInPlace::open(database_, row.column<std::int64_t>(2), /*writes=*/false));
    ROOMWISE_TRY(Bytes data, blob.read());
    return DerivedData{row.column<std::string>(0), row.column<std::string>(1), std::move(data)};
  };
  ROOMWISE_TRY(
      auto found,
      collect<std::vector<DerivedData>>(
          database_, "SELECT name, made_from, rowid FROM derived_data WHERE name = ?", read, name));
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

Expected<void> Home::finish_recording(RecordingId id) {
  ROOMWISE_RETURN_IF_ERROR(
      database_.run("UPDATE recordings SET finished = 1 WHERE recording_id = ?", id));
  if (sqlite3_changes(database_.handle()) == 0) return fail("{}: has no recording {}", file(), id);
  return {};
}

Expected<void> Home::remove_recording(RecordingId id) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(
        const bool had_keyframes,
        database_.get<bool>("SELECT EXISTS (SELECT 1 FROM keyframes WHERE recording_id = ?)", id));
    ROOMWISE_RETURN_IF_ERROR(database_.run(
        "UPDATE frames SET keyframe_id = NULL, tx_m = NULL, ty_m = NULL, tz_m = NULL, qx = NULL, "
        "qy = NULL, qz = NULL, qw = NULL, "
        "no_pose_reason = 'its key-frame was removed with the recording it came from' "
        "WHERE keyframe_id IN (SELECT keyframe_id FROM keyframes WHERE recording_id = ?)",
        id));
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM recordings WHERE recording_id = ?", id));
    if (sqlite3_changes(database_.handle()) == 0) {
      return fail("{}: has no recording {}", file(), id);
    }
    ROOMWISE_RETURN_IF_ERROR(renumber_keyframes());
    // It followed from what is gone, too.
    if (had_keyframes) ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM derived_data"));
    // Nor was a home visited again that was never walked through.
    return database_.run("DELETE FROM visits WHERE NOT EXISTS (SELECT 1 FROM recordings)");
  });
}

// Key-frames are numbered without gaps, in the order of their walks.
Expected<void> Home::renumber_keyframes() {
  ROOMWISE_TRY(const auto left, keyframes());
  std::map<KeyframeId, KeyframeId> old_numbers;  // by the new ones
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i].id != i) old_numbers[i] = left[i].id;
  }
  if (old_numbers.empty()) return {};
  ROOMWISE_TRY(const auto columns, keyframe_columns(database_));
  ROOMWISE_RETURN_IF_ERROR(database_.run("PRAGMA defer_foreign_keys = ON"));
  ROOMWISE_RETURN_IF_ERROR(
      database_.run("CREATE TEMP TABLE IF NOT EXISTS renumbered (was INTEGER PRIMARY KEY, now "
                    "INTEGER NOT NULL)"));
  ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM temp.renumbered"));
  for (const auto& [now, was] : old_numbers)
    ROOMWISE_RETURN_IF_ERROR(database_.add("temp.renumbered (was, now)", was, now));
  for (const auto& [table, column] : columns) {
    // By way of numbers that none has, since rows are changed one after the other.
    ROOMWISE_RETURN_IF_ERROR(
        database_.run(fmt::format("UPDATE {0} SET {1} = -1 - {1} WHERE {1} >= ?", table, column),
                      old_numbers.begin()->second));
    ROOMWISE_RETURN_IF_ERROR(database_.run(
        fmt::format("UPDATE {0} SET {1} = (SELECT now FROM temp.renumbered WHERE was = -1 - {1}) "
                    "WHERE {1} < 0",
                    table, column)));
  }
  return reseal_pictures(old_numbers);
}

Expected<std::set<KeyframeId>> Home::held_keyframes() const {
  std::set<KeyframeId> held;
  for (const std::string_view table : kHoldingTables) {
    ROOMWISE_RETURN_IF_ERROR(database_.for_each(
        fmt::format("SELECT DISTINCT keyframe_id FROM {} WHERE keyframe_id IS NOT NULL", table),
        [&](const Statement& row) { held.insert(row.column<KeyframeId>(0)); }));
  }
  return held;
}

Expected<void> Home::cull_keyframes(const KeyframeCulling& culling) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const auto held, held_keyframes());
    for (const KeyframeCulling::Place& moved : culling.places) {
      if (!moved.place.keyframe_from_camera.is_finite())
        return fail("{}: the pose of frame {} is not finite", file(), moved.frame_index);
      ROOMWISE_RETURN_IF_ERROR(
          database_.run("UPDATE frames SET (keyframe_id, tx_m, ty_m, tz_m, qx, qy, qz, qw) = "
                        "(?, ?, ?, ?, ?, ?, ?, ?) WHERE recording_id = ? AND frame_index = ?",
                        moved.place.keyframe, to_numbers(moved.place.keyframe_from_camera),
                        moved.recording, moved.frame_index));
    }
    for (const scene::PoseGraphEdge& edge : culling.edges)
      ROOMWISE_RETURN_IF_ERROR(insert_edge(edge));
    for (const KeyframeId id : culling.culled) {
      ROOMWISE_TRY(
          const bool has_frames,
          database_.get<bool>("SELECT EXISTS (SELECT 1 FROM frames WHERE keyframe_id = ?)", id));
      if (has_frames || held.contains(id)) {
        return fail("{}: key-frame {} cannot be taken out: {} on it", file(), id,
                    has_frames ? "the place of a frame hangs" : "something that is kept hangs");
      }
      ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM keyframes WHERE keyframe_id = ?", id));
      if (sqlite3_changes(database_.handle()) == 0)
        return fail("{}: has no key-frame {}", file(), id);
    }
    // What was seen in their pictures goes with them.
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM derived_data WHERE name = 'word_places'"));
    return renumber_keyframes();
  });
}

Expected<KeyframeId> Home::next_keyframe_id() const {
  return database_.get<KeyframeId>("SELECT coalesce(max(keyframe_id) + 1, 0) FROM keyframes");
}

Expected<std::vector<Keyframe>> Home::keyframes() const {
  return collect<std::vector<Keyframe>>(
      database_,
      "SELECT keyframe_id, frame_index, timestamp_ns, recording_id, tx_m, ty_m, tz_m, qx, qy, qz, "
      "qw, component FROM keyframes ORDER BY keyframe_id",
      read_keyframe);
}

Expected<std::optional<Keyframe>> Home::find_keyframe(KeyframeId id) const {
  ROOMWISE_TRY(const auto found,
               collect<std::vector<Keyframe>>(
                   database_,
                   "SELECT keyframe_id, frame_index, timestamp_ns, recording_id, tx_m, ty_m, tz_m, "
                   "qx, qy, qz, qw, component FROM keyframes WHERE keyframe_id = ?",
                   read_keyframe, id));
  return found.empty() ? std::nullopt : std::optional(found.front());
}

Expected<KeyframeImages> Home::images(KeyframeId id) const {
  std::optional<KeyframeImages> images;
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT color, depth FROM keyframe_images WHERE keyframe_id = ?",
      [&](const Statement& row) {
        images = KeyframeImages{row.column<Bytes>(0), row.column<Bytes>(1)};
      },
      id));
  if (!images) return fail("{}: has no key-frame {}", file(), id);
  ROOMWISE_TRY(images->color, decrypt_if_sealed(id, PictureKind::kColor, std::move(images->color)));
  ROOMWISE_TRY(images->depth, decrypt_if_sealed(id, PictureKind::kDepth, std::move(images->depth)));
  return *std::move(images);
}

Expected<std::vector<DepthView>> Home::depth_views() const {
  ROOMWISE_TRY(const bool has, has_table(database_, "keyframe_depth_views"));
  if (!has) return std::vector<DepthView>();
  return collect<std::vector<DepthView>>(
      database_,
      "SELECT depth_view_id, keyframe_id, recording_id, v.tx_m, v.ty_m, v.tz_m, v.qx, v.qy, v.qz, "
      "v.qw FROM keyframe_depth_views v JOIN keyframes USING (keyframe_id) ORDER BY depth_view_id",
      [](const Statement& row) {
        return DepthView{row.column<DepthViewId>(0), row.column<KeyframeId>(1),
                         row.column<RecordingId>(2), pose_column(row, 3)};
      });
}

Expected<Bytes> Home::depth_view_image(DepthViewId id) const {
  ROOMWISE_TRY(
      std::optional<Bytes> depth,
      database_.find<Bytes>("SELECT depth FROM keyframe_depth_views WHERE depth_view_id = ?", id));
  if (!depth) return fail("{}: has no depth image {}", file(), id);
  return decrypt_if_sealed(id, PictureKind::kDepthView, *std::move(depth));
}

Expected<std::vector<Frame>> Home::frames(RecordingId id) const {
  return collect<std::vector<Frame>>(
      database_,
      "SELECT f.frame_index, timestamp_ns, keyframe_id, f.tx_m, f.ty_m, f.tz_m, f.qx, f.qy, f.qz, "
      "f.qw, no_pose_reason, m.use, m.tx_m, m.ty_m, m.tz_m, m.qx, m.qy, m.qz, m.qw, up_x, up_y, "
      "up_z FROM frames f LEFT JOIN device_motions m USING (recording_id, frame_index) "
      "WHERE recording_id = ? ORDER BY f.frame_index",
      read_frame, id);
}

Expected<std::vector<scene::PoseGraphEdge>> Home::edges() const {
  const auto read = [&](const Statement& row) -> Expected<scene::PoseGraphEdge> {
    const auto information = from_upper_triangle_json(row.column<std::string>(10));
    if (!information) {
      return fail(
          "{}: is damaged: the information of pose-graph edge {} is not {} numbers; put back "
          "a copy of it",
          file(), row.column<std::int64_t>(0), kUpperTriangleSize);
    }
    return scene::PoseGraphEdge{row.column<KeyframeId>(1), row.column<KeyframeId>(2),
                                pose_column(row, 3),       *information,
                                row.column<bool>(11),      row.column<bool>(12)};
  };
  return collect<std::vector<scene::PoseGraphEdge>>(
      database_,
      "SELECT edge_id, from_keyframe_id, to_keyframe_id, tx_m, ty_m, tz_m, qx, qy, qz, qw, "
      "information_upper, is_robust, is_device_motion FROM pose_graph_edges ORDER BY edge_id",
      read);
}

Expected<void> Home::replace_poses(const std::map<KeyframeId, KeyframePose>& poses) {
  return atomically([&]() -> Expected<void> {
    for (const auto& [id, pose] : poses) {
      if (!pose.world_from_keyframe.is_finite()) {
        return fail("{}: the new pose of key-frame {} is not finite", file(), id);
      }
      ROOMWISE_RETURN_IF_ERROR(
          database_.run("UPDATE keyframes SET (tx_m, ty_m, tz_m, qx, qy, qz, qw, component) = "
                        "(?, ?, ?, ?, ?, ?, ?, ?) WHERE keyframe_id = ?",
                        to_numbers(pose.world_from_keyframe), pose.component, id));
      if (sqlite3_changes(database_.handle()) == 0) {
        return fail("{}: has no key-frame {}", file(), id);
      }
    }
    return {};
  });
}

}  // namespace roomwise::home
