#include "roomwise/home/schema.h"

#include <map>
#include <set>
#include <string>

namespace roomwise::home {
namespace {

// Poses are seven columns: the translation in metres (tx_m, ty_m, tz_m) and the unit quaternion
// (qx, qy, qz, qw) of a_from_b, which takes points of frame b to frame a. Features, scores and
// points are blobs of 32-bit floats, little-endian.
constexpr const char* kFirstTables = R"sql(
CREATE TABLE settings (
  -- With what the map was made (method, features, seed, options), so that a later run goes on alike.
  key TEXT NOT NULL PRIMARY KEY,
  value TEXT NOT NULL
) STRICT;

CREATE TABLE recordings (
  -- A walk through the home with an RGB-D camera.
  recording_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  folder TEXT NOT NULL,                -- where it was read from, as the user gave it
  fx_px REAL NOT NULL, fy_px REAL NOT NULL,  -- the camera: focal lengths
  cx_px REAL NOT NULL, cy_px REAL NOT NULL,  -- principal point; pixel (0, 0) is the centre of the top left one
  width_px INTEGER NOT NULL, height_px INTEGER NOT NULL,
  distortion_k1 REAL NOT NULL, distortion_k2 REAL NOT NULL,  -- Brown's lens distortion
  distortion_p1 REAL NOT NULL, distortion_p2 REAL NOT NULL,
  distortion_k3 REAL NOT NULL,
  depth_units_per_metre REAL NOT NULL,
  frame_count INTEGER,                 -- RGB-D frames in all; NULL for a live camera
  next_frame_index INTEGER NOT NULL,   -- frames below this one are stored; mapping goes on here
  finished INTEGER NOT NULL CHECK (finished IN (0, 1)),
  readout_s REAL                       -- of a rolling shutter, first row to last; NULL: not known
) STRICT;

-- ---- the map ----

CREATE TABLE keyframes (
  -- Frames that the map keeps, in the order of time.
  keyframe_id INTEGER PRIMARY KEY,
  recording_id INTEGER NOT NULL REFERENCES recordings ON DELETE CASCADE,
  frame_index INTEGER NOT NULL,        -- the colour image's place in the recording, from 0
  timestamp_ns INTEGER NOT NULL,
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,  -- world_from_keyframe: the camera's pose
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  component INTEGER NOT NULL,          -- connected component of the map, with a world of its own; 0 is the map's
  UNIQUE (recording_id, frame_index)
) STRICT;

CREATE TABLE keyframe_images (
  -- The images of a key-frame as the camera or the recording gave them.
  keyframe_id INTEGER PRIMARY KEY REFERENCES keyframes ON DELETE CASCADE,
  color BLOB NOT NULL,                 -- JPEG or PNG
  depth BLOB NOT NULL                  -- 16-bit PNG; see recordings.depth_units_per_metre
) STRICT;

CREATE TABLE frames (
  -- Every frame of a recording: where it was taken, or why that is not known.
  recording_id INTEGER NOT NULL REFERENCES recordings ON DELETE CASCADE,
  frame_index INTEGER NOT NULL,
  timestamp_ns INTEGER NOT NULL,
  keyframe_id INTEGER REFERENCES keyframes,
  tx_m REAL, ty_m REAL, tz_m REAL,     -- keyframe_from_camera: the camera's pose in the key-frame
  qx REAL, qy REAL, qz REAL, qw REAL,
  no_pose_reason TEXT,
  PRIMARY KEY (recording_id, frame_index),
  CHECK ((keyframe_id IS NULL) = (no_pose_reason IS NOT NULL)),
  CHECK ((keyframe_id IS NULL) = (tx_m + ty_m + tz_m + qx + qy + qz + qw IS NULL))
) STRICT;
CREATE INDEX frames_by_keyframe ON frames (keyframe_id);

CREATE TABLE device_motions (
  -- Where the device itself believed its camera when it took a frame (ARKit, odometry).
  recording_id INTEGER NOT NULL,
  frame_index INTEGER NOT NULL,
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,  -- device_from_camera, in a world of its own
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  up_x REAL, up_y REAL, up_z REAL,     -- unit vector up in the camera's frame; NULL: it feels no gravity
  use TEXT NOT NULL CHECK (use IN ('taken', 'dropped', 'alone')),  -- what mapping made of it
  PRIMARY KEY (recording_id, frame_index),
  FOREIGN KEY (recording_id, frame_index) REFERENCES frames ON DELETE CASCADE,
  CHECK ((up_x IS NULL) = (up_y IS NULL) AND (up_y IS NULL) = (up_z IS NULL))
) STRICT;

CREATE TABLE pose_graph_edges (
  -- Measurements of one key-frame's pose relative to another's, in the order in which they were made.
  edge_id INTEGER PRIMARY KEY,
  from_keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  to_keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,  -- from_from_to
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  information_upper TEXT NOT NULL,     -- JSON: upper triangle of the 6x6 inverse covariance, row by row,
                                       -- in the order x, y, z (m), qx, qy, qz
  is_robust INTEGER NOT NULL CHECK (is_robust IN (0, 1)),
  is_device_motion INTEGER NOT NULL CHECK (is_device_motion IN (0, 1))  -- not by what pictures show
) STRICT;
CREATE INDEX pose_graph_edges_by_from ON pose_graph_edges (from_keyframe_id);
CREATE INDEX pose_graph_edges_by_to ON pose_graph_edges (to_keyframe_id);

-- ---- what networks see in key-frames ----

CREATE TABLE networks (
  -- The classifiers that have looked at key-frames.
  network_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  fingerprint TEXT NOT NULL UNIQUE,    -- SHA-256 of the weights file
  labels TEXT NOT NULL,                -- JSON array; empty for a network that serves features only
  feature_size INTEGER NOT NULL
) STRICT;

CREATE TABLE keyframe_predictions (
  -- What a network sees in a key-frame.
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  network_id INTEGER NOT NULL REFERENCES networks,
  features BLOB NOT NULL,              -- networks.feature_size of them
  scores BLOB NOT NULL,                -- probability of each of networks.labels, or none
  PRIMARY KEY (keyframe_id, network_id)
) STRICT;

CREATE TABLE keyframe_observations (
  -- Objects that a network named in a key-frame.
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  object TEXT NOT NULL,
  score REAL NOT NULL,                 -- probability, 0 to 1
  PRIMARY KEY (keyframe_id, object)
) STRICT;

CREATE TABLE region_finders (
  -- What looks where in key-frames things are: detectors, and closer looks at what stands apart.
  finder_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  fingerprint TEXT NOT NULL UNIQUE,    -- SHA-256 of the weights file, with the method where there are several
  labels TEXT NOT NULL                 -- JSON array: what it can name
) STRICT;

CREATE TABLE keyframe_depths (
  -- The depth image of a key-frame, small: one place for eight by eight pixels.
  keyframe_id INTEGER PRIMARY KEY REFERENCES keyframes ON DELETE CASCADE,
  width_px INTEGER NOT NULL,
  depth BLOB NOT NULL                  -- 16-bit numbers, little-endian; see recordings.depth_units_per_metre
) STRICT;

CREATE TABLE keyframe_finders (
  -- Which finder has looked at which key-frame; it may have found nothing.
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  finder_id INTEGER NOT NULL REFERENCES region_finders,
  PRIMARY KEY (keyframe_id, finder_id)
) STRICT;

CREATE TABLE keyframe_detections (
  -- Where in a key-frame something was found, and what the depth there says of its surface.
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  finder_id INTEGER NOT NULL REFERENCES region_finders,
  place INTEGER NOT NULL,              -- 0, 1, 2, ...: best first
  label TEXT NOT NULL,                 -- as the finder calls it
  score REAL NOT NULL,                 -- 0 to 1
  left_px REAL NOT NULL, top_px REAL NOT NULL,      -- the box in the colour image, right and bottom
  right_px REAL NOT NULL, bottom_px REAL NOT NULL,  -- not included
  share REAL NOT NULL,                 -- of the box's measured places, those on the thing's surface
  measured REAL NOT NULL,              -- of the box's places, those where depth was measured
  points BLOB NOT NULL,                -- of the surface: x, y, z in m in the key-frame's camera frame
                                       -- (right, down, forward)
  PRIMARY KEY (keyframe_id, finder_id, place)
) STRICT;

-- ---- the things of the home. They follow their key-frame until they are found anew ----

CREATE TABLE objects (
  -- What the paper's rules make of the observations.
  object_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,  -- shows it best
  score REAL NOT NULL,                 -- there; probability, 0 to 1
  observations INTEGER NOT NULL,       -- number of key-frames that show it
  x_m REAL, y_m REAL, z_m REAL,        -- position in the key-frame's camera frame; NULL without depth there
  CHECK ((x_m IS NULL) = (y_m IS NULL) AND (y_m IS NULL) = (z_m IS NULL))
) STRICT;

CREATE TABLE visits (
  -- Later walks through the home that brought it up to date.
  visit_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  folder TEXT NOT NULL,                -- where it was read from, as the user gave it
  first_timestamp_ns INTEGER NOT NULL, -- in the time of its recording
  last_timestamp_ns INTEGER NOT NULL,
  frames INTEGER NOT NULL,             -- frames that were looked at
  placed INTEGER NOT NULL              -- of these, those whose place on the map was found
) STRICT;

CREATE TABLE instances (
  -- Things joined from the detections of many key-frames.
  instance_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  probability REAL NOT NULL,           -- that it is there and is called so, 0 to 1
  observations INTEGER NOT NULL,       -- number of key-frames that show it
  expected INTEGER NOT NULL,           -- number of key-frames that should
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,  -- shows it best
  left_px REAL NOT NULL, top_px REAL NOT NULL,      -- there, in the colour image
  right_px REAL NOT NULL, bottom_px REAL NOT NULL,
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,  -- keyframe_from_box: its box in the key-frame's
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL,        -- camera frame; the box frame has its origin in
  qw REAL NOT NULL,                                            -- the middle and z up
  width_m REAL NOT NULL, depth_m REAL NOT NULL,     -- along x, y and z of the box frame
  height_m REAL NOT NULL,
  sigma_x_m REAL NOT NULL, sigma_y_m REAL NOT NULL, -- standard deviation of the middle along them
  sigma_z_m REAL NOT NULL,
  visit_id INTEGER REFERENCES visits,  -- only this visit showed it: its key-frame is one near by, which does
                                       -- not; NULL: the map's key-frames show it
  points BLOB NOT NULL                 -- of the surface of what a visit brought, as in keyframe_detections
) STRICT;

CREATE TABLE instance_names (
  -- What an instance may be.
  instance_id INTEGER NOT NULL REFERENCES instances ON DELETE CASCADE,
  name TEXT NOT NULL,
  share REAL NOT NULL,                 -- of what was observed that speaks for the name, 0 to 1
  PRIMARY KEY (instance_id, name)
) STRICT;

CREATE TABLE past_instances (
  -- Things as they stood in the home once, and stand there no more. The columns down to visit_id are those
  -- of instances.
  past_id INTEGER PRIMARY KEY,
  name TEXT NOT NULL,
  probability REAL NOT NULL,
  observations INTEGER NOT NULL,
  expected INTEGER NOT NULL,
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  left_px REAL NOT NULL, top_px REAL NOT NULL,
  right_px REAL NOT NULL, bottom_px REAL NOT NULL,
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  width_m REAL NOT NULL, depth_m REAL NOT NULL, height_m REAL NOT NULL,
  sigma_x_m REAL NOT NULL, sigma_y_m REAL NOT NULL, sigma_z_m REAL NOT NULL,
  visit_id INTEGER REFERENCES visits,
  reason TEXT NOT NULL CHECK (reason IN ('removed', 'moved')),
  first_seen_ns INTEGER NOT NULL,      -- in the time of the recording that showed it
  last_seen_ns INTEGER NOT NULL,
  noticed_by INTEGER NOT NULL REFERENCES visits  -- the visit that found it gone
) STRICT;

-- ---- rooms ----

CREATE TABLE room_types (
  -- Concepts: the kinds of rooms there are.
  room_type TEXT NOT NULL PRIMARY KEY
) STRICT;

CREATE TABLE object_kinds (
  -- Concepts: the kinds of objects that count.
  object TEXT NOT NULL PRIMARY KEY
) STRICT;

CREATE TABLE object_labels (
  -- Concepts: which labels of a network mean an object.
  label TEXT NOT NULL PRIMARY KEY,
  object TEXT NOT NULL REFERENCES object_kinds
) STRICT;

CREATE TABLE has_a (
  -- Concepts: a room of this type has such an object.
  room_type TEXT NOT NULL REFERENCES room_types,
  object TEXT NOT NULL REFERENCES object_kinds,
  PRIMARY KEY (room_type, object)
) STRICT;

CREATE TABLE rooms (
  -- The rooms of this home, as its people call them.
  room TEXT NOT NULL PRIMARY KEY,
  room_type TEXT NOT NULL
) STRICT;

CREATE TABLE room_ranges (
  -- Which frames of a recording were taken in which room.
  recording_id INTEGER NOT NULL REFERENCES recordings ON DELETE CASCADE,
  first_frame_index INTEGER NOT NULL,
  last_frame_index INTEGER NOT NULL,   -- included
  room TEXT NOT NULL REFERENCES rooms,
  visit INTEGER NOT NULL,              -- 1 for the first time in the room, 2 for the next, ...
  PRIMARY KEY (recording_id, first_frame_index)
) STRICT;

CREATE TABLE room_classifiers (
  -- What was learned: from the features of a network to the rooms of this home.
  classifier_id INTEGER PRIMARY KEY,   -- the highest is the newest
  network_name TEXT NOT NULL,
  network_fingerprint TEXT NOT NULL UNIQUE,
  classifier BLOB NOT NULL,
  report TEXT NOT NULL                 -- JSON: how it was learned and how well it does
) STRICT;

CREATE TABLE keyframe_rooms (
  -- In which room the learned classifier believes a key-frame to be.
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  room TEXT NOT NULL,
  score REAL NOT NULL,                 -- probability, 0 to 1
  PRIMARY KEY (keyframe_id, room)
) STRICT;

CREATE TABLE picture_features (
  -- What a network makes of the pictures that rooms were last learned from, and of varied ones, so that
  -- learning from them again needs no network. It follows from the pictures and can be deleted.
  picture_digest TEXT NOT NULL,        -- SHA-256 of the picture's file
  network_fingerprint TEXT NOT NULL,
  augmentation TEXT NOT NULL,             -- how pictures are varied
  variant INTEGER NOT NULL,            -- 0 is the picture itself
  keyframe_id INTEGER REFERENCES keyframes ON DELETE CASCADE,  -- whose picture it is; NULL for a photo
  features BLOB NOT NULL,
  PRIMARY KEY (picture_digest, network_fingerprint, augmentation, variant)
) STRICT;
CREATE INDEX picture_features_by_keyframe ON picture_features (keyframe_id);

CREATE TABLE derived_data (
  -- What takes long to work out from the rest, kept so that questions are answered at once. It can be deleted.
  name TEXT NOT NULL PRIMARY KEY,
  made_from TEXT NOT NULL,             -- SHA-256 of all that it follows from: stale where that has changed
  data BLOB NOT NULL
) STRICT;

CREATE TABLE visit_pictures (
  -- Pictures of later visits by which rooms are known, beside those that they were learned from. The pictures
  -- themselves are not kept.
  picture_id INTEGER PRIMARY KEY,      -- in the order in which they were learned
  visit_id INTEGER NOT NULL REFERENCES visits ON DELETE CASCADE,        -- the visit that brought it
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,  -- that shows the same place
  timestamp_ns INTEGER NOT NULL,       -- in the time of the visit's recording
  picture_digest TEXT NOT NULL,        -- SHA-256 of the picture's file
  room TEXT NOT NULL,
  network_fingerprint TEXT NOT NULL,   -- of the network that made the features
  features BLOB NOT NULL
) STRICT;
CREATE INDEX visit_pictures_by_visit ON visit_pictures (visit_id);
CREATE INDEX visit_pictures_by_keyframe ON visit_pictures (keyframe_id);

CREATE TABLE stage_timings (
  -- How long the stages took, summed over threads and runs.
  stage TEXT NOT NULL PRIMARY KEY,
  calls INTEGER NOT NULL,
  wall_s REAL NOT NULL,
  cpu_s REAL NOT NULL
) STRICT;
)sql";

// That a home of before has not; open() adds them.
constexpr const char* kLaterTables = R"sql(
CREATE TABLE IF NOT EXISTS edits (
  -- What people changed by hand, in the order in which they did. Nothing that programs find changes it.
  edit_id INTEGER PRIMARY KEY AUTOINCREMENT,  -- never given again
  made_s INTEGER NOT NULL,             -- seconds since 1970
  made_by TEXT NOT NULL,               -- a device's name, or the command line
  what TEXT NOT NULL,                  -- 'rename thing', 'note', 'divide room', ...
  change TEXT NOT NULL,                -- JSON: to what
  before TEXT NOT NULL                 -- JSON: what it changed of other tables, so that it can be undone
) STRICT;

CREATE TABLE IF NOT EXISTS edit_places (
  -- Where the things, lines and points of an edit are. They move with their key-frame.
  edit_id INTEGER NOT NULL REFERENCES edits ON DELETE CASCADE,
  place INTEGER NOT NULL,              -- 0, 1, 2, ...
  name TEXT NOT NULL,                  -- what programs called the thing there; empty: no thing is meant
  keyframe_id INTEGER REFERENCES keyframes ON DELETE SET NULL,  -- NULL: its walk was forgotten
  left_px REAL NOT NULL, top_px REAL NOT NULL,      -- the thing in the key-frame's picture, as in instances;
  right_px REAL NOT NULL, bottom_px REAL NOT NULL,  -- all 0: it is not shown there
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,  -- keyframe_from_box
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  width_m REAL NOT NULL, depth_m REAL NOT NULL, height_m REAL NOT NULL,  -- 0 of a point
  PRIMARY KEY (edit_id, place)
) STRICT;
CREATE INDEX IF NOT EXISTS edit_places_by_keyframe ON edit_places (keyframe_id);

CREATE TABLE IF NOT EXISTS own_things (
  -- Things that people taught by showing them, and where each was seen last.
  own_thing_id INTEGER PRIMARY KEY AUTOINCREMENT,  -- never given again
  name TEXT NOT NULL UNIQUE,
  owner TEXT NOT NULL,                 -- who taught it: their device's number, in older rows and
                                       -- its name behind a space; '': the computer
  is_shared INTEGER NOT NULL CHECK (is_shared IN (0, 1)),  -- 0: only its owner is told of it
  taught_s INTEGER NOT NULL,           -- seconds since 1970
  seen_s INTEGER,                      -- the same; NULL: not seen yet, or it is not known when
  seen_room TEXT,
  keyframe_id INTEGER REFERENCES keyframes ON DELETE SET NULL,  -- near where it was seen
  x_m REAL, y_m REAL, z_m REAL,        -- of its middle, in the key-frame's camera frame
  CHECK ((x_m IS NULL) = (y_m IS NULL) AND (y_m IS NULL) = (z_m IS NULL))
) STRICT;

CREATE TABLE IF NOT EXISTS own_thing_views (
  -- By what a thing is known: pictures of it, sealed as those of key-frames are.
  view_id INTEGER PRIMARY KEY AUTOINCREMENT,
  own_thing_id INTEGER NOT NULL REFERENCES own_things ON DELETE CASCADE,
  picture BLOB NOT NULL,               -- JPEG
  mask BLOB NOT NULL                   -- 16-bit PNG: 1 where the thing is
) STRICT;
CREATE INDEX IF NOT EXISTS own_thing_views_by_thing ON own_thing_views (own_thing_id);

CREATE TABLE IF NOT EXISTS keyframe_depth_views (
  -- Depth images that a device took after a key-frame, before its next picture.
  depth_view_id INTEGER PRIMARY KEY,
  keyframe_id INTEGER NOT NULL REFERENCES keyframes ON DELETE CASCADE,
  tx_m REAL NOT NULL, ty_m REAL NOT NULL, tz_m REAL NOT NULL,  -- keyframe_from_view: the camera's pose
  qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL, qw REAL NOT NULL,
  depth BLOB NOT NULL                  -- as keyframe_images.depth
) STRICT;
CREATE INDEX IF NOT EXISTS keyframe_depth_views_by_keyframe ON keyframe_depth_views (keyframe_id);
)sql";

bool is_later(std::string_view table) {
  return table == "edits" || table == "edit_places" || table == "own_things" ||
         table == "own_thing_views" || table == "keyframe_depth_views" ||
         table == "sqlite_sequence";  // the last is SQLite's own
}

// The columns of each table, by name.
Expected<std::map<std::string, std::set<std::string>>> columns_of(const Database& database) {
  std::map<std::string, std::set<std::string>> columns;
  ROOMWISE_RETURN_IF_ERROR(
      database.for_each("SELECT m.name, c.name FROM sqlite_schema m, pragma_table_info(m.name) c "
                        "WHERE m.type = 'table'",
                        [&](const Statement& row) {
                          columns[row.column<std::string>(0)].insert(row.column<std::string>(1));
                        }));
  return columns;
}

}  // namespace

Expected<void> create_tables(Database& database) {
  ROOMWISE_TRY(Transaction transaction, Transaction::begin(database));
  ROOMWISE_RETURN_IF_ERROR(database.run_script(kFirstTables));
  ROOMWISE_RETURN_IF_ERROR(database.run_script(kLaterTables));
  ROOMWISE_RETURN_IF_ERROR(database.run_script(fmt::format(
      "PRAGMA application_id = {}; PRAGMA user_version = {};", kApplicationId, kHomeVersion)));
  return transaction.commit();
}

Expected<void> add_later_tables(Database& database) {
  ROOMWISE_TRY(Transaction transaction, Transaction::begin(database));
  ROOMWISE_RETURN_IF_ERROR(database.run_script(kLaterTables));
  return transaction.commit();
}

Expected<bool> has_table(const Database& database, std::string_view name) {
  return database.get<bool>("SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = ?",
                            name);
}

Expected<void> check_tables(const Database& database) {
  ROOMWISE_TRY(Database model, Database::in_memory());
  ROOMWISE_RETURN_IF_ERROR(create_tables(model));
  ROOMWISE_TRY(const auto expected, columns_of(model));
  ROOMWISE_TRY(const auto found, columns_of(database));
  for (const auto& [table, columns] : expected) {
    const auto at = found.find(table);
    if (at == found.end() && is_later(table)) continue;
    if (at == found.end()) {
      return fail(
          "{}: is damaged, or was made before this version: it has no table '{}'; put back a copy "
          "of it, or "
          "map its recordings anew",
          database.file(), table);
    }
    for (const std::string& column : columns) {
      if (!at->second.contains(column)) {
        return fail("{}: is damaged: its table '{}' has no column '{}'; put back a copy of it",
                    database.file(), table, column);
      }
    }
  }
  return {};
}

}  // namespace roomwise::home
