#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/home/database.h"
#include "roomwise/home/passphrase.h"
#include "roomwise/home/picture_cipher.h"
#include "roomwise/home/writer_lock.h"
#include "roomwise/image/rgbd_frame.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/objects/detection/confirmed_objects.h"
#include "roomwise/objects/detection/region_surface.h"
#include "roomwise/objects/instances/instances.h"
#include "roomwise/objects/own_things/shown_thing.h"
#include "roomwise/recording/room_labels.h"
#include "roomwise/rooms/concepts/concepts.h"
#include "roomwise/rooms/recognition/two_frame_rule.h"
#include "roomwise/scene/frame.h"
#include "roomwise/scene/keyframe.h"
#include "roomwise/scene/pose_graph_edge.h"

namespace roomwise::home {

using scene::Frame;
using scene::FramePlace;
using scene::KeyframeId;
using scene::KeyframePose;

using RecordingId = std::int64_t;
using NetworkId = std::int64_t;
using FinderId = std::int64_t;
using VisitId = std::int64_t;  // from 1 on
using EditId = std::int64_t;   // from 1 on, in the order in which they were made

// A walk through the home with an RGB-D camera.
struct Recording {
  std::string name;
  std::string folder;  // where it is read from, as the user gave it
  geometry::PinholeCamera camera;
  std::optional<std::uint64_t> frame_count;  // RGB-D frames in all; absent for a live camera
};

struct StoredRecording {
  RecordingId id = 0;
  Recording recording;
  // Frames below this index are stored; an interrupted run goes on from here.
  std::uint64_t next_frame_index = 0;
  bool finished = false;            // all its frames are stored and its map is optimised
  std::optional<double> readout_s;  // of its camera's rolling shutter, as the map was refined
};

struct DerivedData {
  std::string name;
  std::string made_from;
  Bytes data;

  friend bool operator==(const DerivedData&, const DerivedData&) = default;
};

struct Keyframe : scene::KeyframeStamp {
  RecordingId recording = 0;
  KeyframePose pose;
};

// As the camera or the recording gave them.
struct KeyframeImages {
  Bytes color;  // JPEG or PNG
  Bytes depth;  // 16-bit PNG

  friend bool operator==(const KeyframeImages&, const KeyframeImages&) = default;
};

using DepthViewId = std::uint64_t;

// Where a depth image was taken after a key-frame, before the next picture.
struct DepthView {
  DepthViewId id = 0;
  KeyframeId keyframe = 0;
  RecordingId recording = 0;
  geometry::RigidTransform keyframe_from_view;
};

// A network that has looked at key-frames.
struct Network {
  std::string name;
  std::string fingerprint;          // SHA-256 of the weights file
  std::vector<std::string> labels;  // empty for a network that serves features only
  std::size_t feature_size = 0;

  friend bool operator==(const Network&, const Network&) = default;
};

// What has looked where in key-frames things are.
struct RegionFinderRecord {
  std::string name;
  std::string fingerprint;  // objects::DetectionFinder::fingerprint()
  std::vector<std::string> labels;

  friend bool operator==(const RegionFinderRecord&, const RegionFinderRecord&) = default;
};

// A later walk through the home that brought it up to date. Times are those of its recording.
struct Visit {
  std::string name;
  std::string folder;  // where it was read from, as the user gave it
  TimestampNs first_timestamp_ns = 0;
  TimestampNs last_timestamp_ns = 0;
  std::uint64_t frames = 0;  // that were looked at
  std::uint64_t placed = 0;  // of these, those whose place on the map was found

  friend bool operator==(const Visit&, const Visit&) = default;
};

// Why a thing is no longer where it was.
enum class PastReason { kRemoved, kMoved };

// A thing as it stood in the home once.
struct PastInstance {
  objects::Instance instance;  // its surface is not kept
  PastReason reason = PastReason::kRemoved;
  // When it was seen, in the time of the recording that showed it.
  TimestampNs first_seen_ns = 0;
  TimestampNs last_seen_ns = 0;
  VisitId noticed_by = 0;
};

// A picture of a visit by which a room is known, beside those that the rooms were learned from. The
// picture itself is not kept.
struct VisitPicture {
  VisitId visit = 0;             // that brought it
  KeyframeId keyframe = 0;       // that shows the same place
  TimestampNs timestamp_ns = 0;  // in the time of the visit's recording
  std::string picture_digest;    // SHA-256 of the picture's file
  std::string room;
  std::string network_fingerprint;  // of the network that made the features
  std::vector<float> features;

  friend bool operator==(const VisitPicture&, const VisitPicture&) = default;
};

// What a visit changes.
struct HomeChanges {
  Visit visit;
  std::vector<objects::Instance> kept;     // stand as they stood
  std::vector<objects::Instance> arrived;  // this visit brought them (Instance::visit is set here)
  std::vector<PastInstance> past;          // stand there no more (noticed_by is set here)
  // All that rooms are known by from now on; one without a visit was brought by this one. Absent:
  // as before.
  std::optional<std::vector<VisitPicture>> pictures = std::nullopt;

  [[nodiscard]] bool empty() const { return arrived.empty() && past.empty() && !pictures; }
};

// A key-frame in the making, with all that is known of it at once. Its id is the next free one:
// Home::next_keyframe_id().
struct NewKeyframe : scene::KeyframeStamp {
  KeyframePose pose;
  KeyframeImages images;
  std::vector<std::pair<NetworkId, network::Prediction>> predictions;
  std::vector<objects::ObjectScore> observations;
  std::vector<image::DepthView> depth_views = {};
};

// What mapping adds between two commits.
struct MapCommit {
  RecordingId recording = 0;
  std::vector<NewKeyframe> keyframes;       // in the order of their ids
  std::vector<scene::PoseGraphEdge> edges;  // between key-frames of this step and earlier ones
  std::vector<Frame> frames;                // since the last step, in the order of their indices
  std::uint64_t next_frame_index = 0;       // above the index of every frame so far
};

// Key-frames that give way to others, which show the same.
struct KeyframeCulling {
  std::vector<KeyframeId> culled;  // ascending
  // By the numbers that key-frames have before: what stands in the place of the edges of those that
  // go, between those that stay ...
  std::vector<scene::PoseGraphEdge> edges;
  // ... and where frames were taken whose place was told by one that goes.
  struct Place {
    RecordingId recording = 0;
    std::uint64_t frame_index = 0;
    FramePlace place;
  };
  std::vector<Place> places;
};

// A learned room classifier: the bytes of rooms::RoomClassifier.
struct RoomClassifierRecord {
  std::string network_name;
  std::string network_fingerprint;  // it means something to the features of this network only
  Bytes classifier;
  std::string report_json;  // how it was learned and how well it does

  friend bool operator==(const RoomClassifierRecord&, const RoomClassifierRecord&) = default;
};

// What a network makes of a picture or of a variant of it.
struct PictureFeatures {
  std::string picture_digest;          // SHA-256 of the picture's file
  int variant = 0;                     // 0 is the picture itself
  std::optional<KeyframeId> keyframe;  // whose picture it is; absent for a photo
  std::vector<float> features;

  friend bool operator==(const PictureFeatures&, const PictureFeatures&) = default;
};

// A place that an edit is about. It hangs on a key-frame, and so moves with the map.
struct EditPlace {
  std::string name;  // what programs called the thing there; empty: none is meant
  // Absent where the walk that it hung on was forgotten, and no other was there.
  std::optional<KeyframeId> keyframe;
  network::PixelBox picture_box;       // of the thing, in the key-frame's picture; else empty
  geometry::OrientedBox box_keyframe;  // in the key-frame's camera frame; of a point without size
};

// What somebody changed by hand. It is kept beside what programs find, which never overwrites it.
struct Edit {
  EditId id = 0;            // set by the home
  std::int64_t made_s = 0;  // seconds since 1970
  std::string made_by;      // a device's name, or the command line
  std::string what;         // "rename thing", ...: see pipeline::EditKind
  std::string change;       // JSON: to what
  std::string before;  // JSON: what it changed of the home's own rows, so that it can be undone
  std::vector<EditPlace> places;
};

// Where a thing that was taught was seen last.
struct OwnThingSighting {
  std::optional<std::int64_t> seen_s = std::nullopt;  // since 1970; absent: not known when
  std::optional<std::string> room = std::nullopt;
  // A key-frame near by, and the thing's middle in its camera frame, where it is known so well.
  std::optional<KeyframeId> keyframe = std::nullopt;
  std::optional<Eigen::Vector3d> middle_keyframe = std::nullopt;  // m

  [[nodiscard]] bool is_known() const { return seen_s || room || keyframe; }
  friend bool operator==(const OwnThingSighting&, const OwnThingSighting&) = default;
};

using OwnThingId = std::int64_t;  // never given again

// A thing that somebody taught.
struct OwnThing {
  OwnThingId id = 0;  // set when it is stored
  std::string name;
  std::string owner;  // the number of their device; empty: the computer itself
  bool is_shared = true;
  std::int64_t taught_s = 0;  // since 1970
  OwnThingSighting last_seen = {};

  // Whether somebody is told of it.
  [[nodiscard]] bool is_known_to(const std::string& who) const { return is_shared || owner == who; }
  friend bool operator==(const OwnThing&, const OwnThing&) = default;
};
constexpr std::size_t kMaxOwnThingName = 60;  // bytes
constexpr std::size_t kMaxOwnThings = 100;

// How a home is opened or made.
struct OpenOptions {
  // Of a protected home; without it everything but its pictures can be read. A new home is
  // protected by it. Opening a home that is not protected with one fails: somebody believes that it
  // is.
  std::shared_ptr<const Passphrase> passphrase = nullptr;
};

// What a check found.
struct HomeCheck {
  std::uint64_t pages = 0;                          // of the file
  std::vector<std::uint64_t> damaged_pages;         // from 1; free ones may be among them
  std::vector<std::string> damaged_tables;          // not all of their rows can be read
  std::map<KeyframeId, std::string> lost_pictures;  // why a key-frame's images cannot be read
  std::vector<OwnThingId> lost_own_things;          // whose pictures cannot be read
  std::vector<std::string> broken_references;  // tables with rows that belong to one that is gone
  std::vector<std::string> doubtful_cameras;   // a recording, and what is unusual about its camera

  [[nodiscard]] bool is_whole() const {
    return damaged_pages.empty() && damaged_tables.empty() && lost_pictures.empty() &&
           lost_own_things.empty() && broken_references.empty();
  }
};

// A home: one file, a SQLite database, that holds what was mapped and learned. It stores and finds,
// and knows no algorithm.
//
// Every function that writes does so in one transaction: all of it or, on an error, nothing. A
// program that is killed at any moment loses only what it had not committed. After a power cut the
// same holds, since each commit waits until the disk has it (SQLite's synchronous=FULL), as far as
// the disk itself tells the truth. While a home is written its newest part lies beside it in
// NAME-wal, with NAME-shm and NAME-lock; closing it puts all into the one file again. After a kill
// these stay, belong to the home, and are tidied by the next program that opens it for writing.
//
// One program writes at a time; others may read meanwhile, and each call of a reader sees one state
// of the home. The pictures of a protected home (protect()) are sealed in the file: the colour and
// depth images of its key-frames, the small depth images of put_detections(), and the views of
// things that people taught; nothing else is. They are opened and sealed by the functions that read
// and write them, which fail where the home was opened without its passphrase.
//
// Doubles come back to the bit, except that -0.0 becomes 0.0. Errors name the file.
// Not thread-safe.
class Home {
 public:
  // A new, empty home. Fails where the file exists.
  [[nodiscard]] static Expected<Home> create(const std::filesystem::path& path,
                                             const OpenOptions& options = {});
  // For reading and writing. Refuses, without changing anything: what is no home, a home of another
  // version, a truncated or damaged file, a home that another process writes. (Only the images are
  // not checked for damage, which would take long; verify() does it.)
  [[nodiscard]] static Expected<Home> open(const std::filesystem::path& path,
                                           const OpenOptions& options = {});
  // For reading; also while another process writes, and on a medium that cannot be written.
  [[nodiscard]] static Expected<Home> open_read_only(const std::filesystem::path& path,
                                                     const OpenOptions& options = {});
  // Another reader of the same home, which can decrypt what this one can.
  [[nodiscard]] Expected<Home> another_reader() const;
  Home(Home&&) = default;
  Home& operator=(Home&&) = delete;
  ~Home();

  // Runs work(), which calls functions of this home, as one transaction: all that it writes is
  // kept, or nothing where it fails.
  [[nodiscard]] Expected<void> atomically(const std::function<Expected<void>()>& work);

  // ---- settings: with what the map was made ----
  [[nodiscard]] Expected<void> put_setting(std::string_view key, std::string_view value);
  [[nodiscard]] Expected<std::map<std::string, std::string>> settings() const;

  // ---- recordings and the map ----
  [[nodiscard]] Expected<RecordingId> add_recording(const Recording& recording);
  [[nodiscard]] Expected<std::vector<StoredRecording>> recordings() const;  // as they were added
  // Adds what was mapped since the last step. Fails where it does not continue what is stored.
  [[nodiscard]] Expected<void> commit(const MapCommit& step);
  [[nodiscard]] Expected<void> put_readout(RecordingId id, double readout_s);
  // Marks that all its frames are stored and its map is optimised.
  [[nodiscard]] Expected<void> finish_recording(RecordingId id);
  // What was worked out from the rest, and what from (a digest), so that a reader knows whether it
  // is stale. It takes the place of the data of that name.
  [[nodiscard]] Expected<void> put_derived_data(const DerivedData& data);
  [[nodiscard]] Expected<std::optional<DerivedData>> derived_data(const std::string& name) const;
  // Removes the recording and all that came from it; frames of other recordings that were placed by
  // its key-frames lose their place, and the key-frames of later ones are numbered anew, so that
  // the numbers have no gap. Derived data goes; what was learned from it stays learned.
  [[nodiscard]] Expected<void> remove_recording(RecordingId id);

  // Takes key-frames out, with their pictures and what was seen in them; the others are numbered
  // anew, in their order. Fails where what must not be lost hangs on one: a frame, a change by
  // hand, a thing, a visit's picture.
  [[nodiscard]] Expected<void> cull_keyframes(const KeyframeCulling& culling);
  // Key-frames on which something hangs that has no other place, and which cannot be culled.
  [[nodiscard]] Expected<std::set<KeyframeId>> held_keyframes() const;

  [[nodiscard]] Expected<KeyframeId> next_keyframe_id() const;
  [[nodiscard]] Expected<std::vector<Keyframe>> keyframes() const;  // by id
  // Nothing where there is none.
  [[nodiscard]] Expected<std::optional<Keyframe>> find_keyframe(KeyframeId id) const;
  [[nodiscard]] Expected<KeyframeImages> images(KeyframeId id) const;
  [[nodiscard]] Expected<std::vector<DepthView>> depth_views() const;       // by id
  [[nodiscard]] Expected<Bytes> depth_view_image(DepthViewId id) const;     // 16-bit PNG
  [[nodiscard]] Expected<std::vector<Frame>> frames(RecordingId id) const;  // by index
  [[nodiscard]] Expected<std::vector<scene::PoseGraphEdge>> edges() const;  // as they were added
  // New poses for key-frames that are there; the others keep theirs.
  [[nodiscard]] Expected<void> replace_poses(const std::map<KeyframeId, KeyframePose>& poses);

  // ---- what networks see ----
  // The network's id; adds it if it is new. Known by its fingerprint.
  [[nodiscard]] Expected<NetworkId> add_network(const Network& network);
  [[nodiscard]] Expected<std::map<NetworkId, Network>> networks() const;
  [[nodiscard]] Expected<void> put_prediction(KeyframeId keyframe, NetworkId network,
                                              const network::Prediction& prediction);
  [[nodiscard]] Expected<std::optional<network::Prediction>> prediction(KeyframeId keyframe,
                                                                        NetworkId network) const;
  // Of every key-frame that the network has looked at.
  [[nodiscard]] Expected<std::map<KeyframeId, network::Prediction>> predictions(
      NetworkId network) const;

  // ---- objects ----
  // These take the place of the key-frame's earlier observations.
  [[nodiscard]] Expected<void> put_observations(KeyframeId keyframe,
                                                std::span<const objects::ObjectScore> observations);
  // Best first (by name where equal); key-frames without observations are left out.
  [[nodiscard]] Expected<std::map<KeyframeId, std::vector<objects::ObjectScore>>> observations()
      const;
  [[nodiscard]] Expected<void> replace_confirmed_objects(
      std::span<const objects::ConfirmedObject> objects);
  [[nodiscard]] Expected<std::vector<objects::ConfirmedObject>> confirmed_objects()
      const;  // in the order given

  // ---- where in key-frames things are, and what they are together ----
  // The finder's id; adds it if it is new. Known by its fingerprint.
  [[nodiscard]] Expected<FinderId> add_region_finder(const RegionFinderRecord& finder);
  [[nodiscard]] Expected<std::map<FinderId, RegionFinderRecord>> region_finders() const;
  // What the finder found in the key-frame takes the place of what it found there before.
  [[nodiscard]] Expected<void> put_detections(KeyframeId keyframe, FinderId finder,
                                              const objects::KeyframeDetections& look);
  // Of every key-frame that the finder has looked at.
  [[nodiscard]] Expected<std::map<KeyframeId, objects::KeyframeDetections>> detections(
      FinderId finder) const;
  // The key-frames alone.
  [[nodiscard]] Expected<std::set<KeyframeId>> looked_at(FinderId finder) const;
  [[nodiscard]] Expected<void> replace_instances(std::span<const objects::Instance> instances);
  [[nodiscard]] Expected<std::vector<objects::Instance>> instances() const;  // in the order given

  // ---- later visits ----
  // Adds the visit; its things and those kept take the place of all instances, and its pictures
  // that of all visits' pictures.
  [[nodiscard]] Expected<VisitId> apply_changes(const HomeChanges& changes);
  [[nodiscard]] Expected<std::map<VisitId, Visit>> visits() const;
  // In the order in which they became past.
  [[nodiscard]] Expected<std::vector<PastInstance>> past_instances() const;
  // These take the place of all. They go with their visit and with their key-frame, and with
  // forget_learned_rooms().
  [[nodiscard]] Expected<void> replace_visit_pictures(std::span<const VisitPicture> pictures);
  [[nodiscard]] Expected<std::vector<VisitPicture>> visit_pictures() const;  // in the order given

  // ---- what people changed by hand ----
  // As the newest.
  [[nodiscard]] Expected<EditId> add_edit(const Edit& edit);
  [[nodiscard]] Expected<std::vector<Edit>> edits() const;  // as they were made
  [[nodiscard]] Expected<void> remove_edit(EditId id);
  // What it changes, what stood before and where; not who made it, and when.
  [[nodiscard]] Expected<void> replace_edit(const Edit& edit);

  // ---- rooms ----
  // Fails where a room type has an object that the vocabulary does not know.
  [[nodiscard]] Expected<void> replace_concepts(const rooms::Concepts& concepts);
  [[nodiscard]] Expected<rooms::Concepts> concepts() const;
  // Fails where a room that ranges of frames belong to would go.
  [[nodiscard]] Expected<void> replace_rooms(std::span<const rooms::Room> rooms);
  [[nodiscard]] Expected<std::vector<rooms::Room>> rooms() const;  // by name
  // Fails where ranges overlap or name a room that this home does not have.
  [[nodiscard]] Expected<void> replace_room_ranges(RecordingId id,
                                                   const std::vector<recording::RoomRange>& ranges);
  [[nodiscard]] Expected<recording::RoomLabels> room_ranges(RecordingId id) const;
  // Takes the place of an earlier one for the same network and becomes the newest.
  [[nodiscard]] Expected<void> put_room_classifier(const RoomClassifierRecord& classifier);
  // Forgets what was learned of rooms: classifiers, what they said of key-frames, features of
  // pictures, pictures of visits.
  [[nodiscard]] Expected<void> forget_learned_rooms();
  // The newest; absent where nothing was learned yet.
  [[nodiscard]] Expected<std::optional<RoomClassifierRecord>> room_classifier() const;
  [[nodiscard]] Expected<std::vector<RoomClassifierRecord>> room_classifiers()
      const;  // newest first
  // In which room the classifier believes each key-frame to be; takes the place of all earlier
  // ones.
  [[nodiscard]] Expected<void> replace_keyframe_rooms(
      const std::map<KeyframeId, std::vector<rooms::RoomScore>>& rooms);
  // Best first (by name where equal).
  [[nodiscard]] Expected<std::map<KeyframeId, std::vector<rooms::RoomScore>>> keyframe_rooms()
      const;

  // ---- features of pictures that rooms were learned from ----
  // Those of one network and one way to vary pictures take the place of all others; they go with
  // their key-frame.
  [[nodiscard]] Expected<void> replace_picture_features(const std::string& network_fingerprint,
                                                        const std::string& augmentation,
                                                        std::span<const PictureFeatures> features);
  // By digest and variant; none where others are stored.
  [[nodiscard]] Expected<std::vector<PictureFeatures>> picture_features(
      const std::string& network_fingerprint, const std::string& augmentation) const;

  // ---- things that people taught ----
  // Gives it its number. Fails where the name is empty, too long, no UTF-8 text on one line, or
  // that of another thing, capitals aside; where it has no views; where there are kMaxOwnThings.
  [[nodiscard]] Expected<OwnThingId> add_own_thing(const OwnThing& thing,
                                                   std::span<const objects::TaughtView> views);
  // Whether one could be added by this name; fails as add_own_thing() does.
  [[nodiscard]] Expected<void> check_new_name(const std::string& name) const;
  [[nodiscard]] Expected<std::vector<OwnThing>> own_things() const;  // by name
  // As they were taught; fails where the home is locked.
  [[nodiscard]] Expected<std::vector<objects::TaughtView>> own_thing_views(OwnThingId id) const;
  [[nodiscard]] Expected<void> share_own_thing(OwnThingId id, bool is_shared);
  [[nodiscard]] Expected<void> put_own_thing_sighting(OwnThingId id,
                                                      const OwnThingSighting& sighting);
  // The thing, its views and where it was seen. No byte stays once erase_removed() ran.
  [[nodiscard]] Expected<void> remove_own_thing(OwnThingId id);

  // ---- times: all that differs between two runs of one seed ----
  // Adds to the times of earlier runs.
  [[nodiscard]] Expected<void> add_stage_timings(
      const std::map<std::string, StageClock::Stage>& stages);
  [[nodiscard]] Expected<std::map<std::string, StageClock::Stage>> stage_timings() const;

  // ---- the file ----
  // SHA-256 over all content but the times: equal for homes that hold the same, however they were
  // written, protected or not.
  [[nodiscard]] Expected<std::string> content_digest() const;
  // Reads the whole file, images too. Sealed pictures are opened where the home was opened with its
  // passphrase; else only the file is known to be whole.
  [[nodiscard]] Expected<HomeCheck> check() const;
  // The same, and fails where something is damaged.
  [[nodiscard]] Expected<void> verify() const;
  // Writes a whole copy, also while another program writes the home. Fails where the file exists.
  [[nodiscard]] Expected<void> copy_to(const std::filesystem::path& path) const;
  // Writes the file anew without what was removed, whose bytes stay in it until then, and empties
  // NAME-wal. Takes as long as copying the file. Fails while somebody else reads the home.
  [[nodiscard]] Expected<void> erase_removed();
  // In the transaction that takes out what nobody shall find again: keeps in the home that
  // erase_removed() is to follow, until that succeeds. So whoever opens the home next can do it
  // where it failed, or the program was killed.
  [[nodiscard]] Expected<void> owe_erasing();
  [[nodiscard]] Expected<bool> owes_erasing() const;

  // ---- protection of the pictures ----
  [[nodiscard]] bool is_protected() const { return is_protected_; }
  // Whether pictures cannot be read nor written: it was opened without its passphrase.
  [[nodiscard]] bool is_locked() const { return is_protected_ && !cipher_; }
  // Says how the passphrase is given.
  [[nodiscard]] Error locked_error() const;
  // Seals every picture and writes the file anew, so that nothing of them stays in it. Of a home
  // that is protected already, and was opened with its passphrase, `passphrase` takes the place of
  // the one before. Killed at any moment it leaves a home that opens with the passphrase; doing it
  // again finishes it. Fails while somebody else reads the home. Returns how many pictures it
  // sealed.
  [[nodiscard]] Expected<std::size_t> protect(const Passphrase& passphrase,
                                              const PassphraseCost& cost = {});
  // Takes the protection away, in the same way; `passphrase` is the home's. Returns how many
  // pictures it opened.
  [[nodiscard]] Expected<std::size_t> unprotect(const Passphrase& passphrase,
                                                const PassphraseCost& cost = {});

  // For looking at the file by SQL.
  [[nodiscard]] Database& database() { return database_; }
  [[nodiscard]] const std::string& file() const { return database_.file(); }

 private:
  Home(std::optional<WriterLock> lock, Database database)
      : lock_(std::move(lock)), database_(std::move(database)) {}

  // The home with what it needs for its pictures: locked where it is protected and `options` has no
  // passphrase.
  [[nodiscard]] static Expected<Home> with_protection_state(Home home, const OpenOptions& options);
  [[nodiscard]] Expected<void> begin_protection(const Passphrase& passphrase, ProtectionState state,
                                                const PassphraseCost& cost);
  // A picture as the file holds it, from the picture itself, and back.
  [[nodiscard]] Expected<Bytes> encrypt_if_protected(KeyframeId keyframe, PictureKind kind,
                                                     Bytes picture) const;
  [[nodiscard]] Expected<Bytes> decrypt_if_sealed(KeyframeId keyframe, PictureKind kind,
                                                  Bytes stored) const;
  [[nodiscard]] Expected<std::map<KeyframeId, std::string>> unreadable_pictures() const;
  [[nodiscard]] Expected<std::vector<OwnThingId>> unreadable_own_things() const;
  // Seals every picture, or opens every one.
  [[nodiscard]] Expected<std::size_t> convert_pictures(bool to_sealed);
  [[nodiscard]] Expected<void> renumber_keyframes();
  // The sealed pictures of key-frames that had another number; by the present one.
  [[nodiscard]] Expected<void> reseal_pictures(const std::map<KeyframeId, KeyframeId>& old_numbers);
  [[nodiscard]] Expected<void> insert_keyframe(RecordingId recording, const NewKeyframe& keyframe);
  [[nodiscard]] Expected<void> insert_depth_view(KeyframeId keyframe, const image::DepthView& view);
  [[nodiscard]] Expected<bool> has_own_things() const;
  [[nodiscard]] Expected<void> change_own_thing(OwnThingId id,
                                                const std::function<Expected<void>()>& change);
  [[nodiscard]] Expected<void> insert_edge(const scene::PoseGraphEdge& edge);
  [[nodiscard]] Expected<void> insert_frame(RecordingId recording, const Frame& frame);
  [[nodiscard]] Expected<void> insert_motion(RecordingId recording, std::uint64_t frame_index,
                                             const scene::FrameMotion& motion);

  std::optional<WriterLock> lock_;  // outlives the database; empty for a reader
  Database database_;
  bool is_protected_ = false;            // the file holds the cipher's key
  std::optional<PictureCipher> cipher_;  // of a protected home that was opened with its passphrase
  ProtectionState protection_state_ = ProtectionState::kEncrypted;  // known beside a cipher
};

}  // namespace roomwise::home
