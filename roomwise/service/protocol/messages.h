#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/geometry/device_motion.h"
#include "roomwise/geometry/pinhole_camera.h"

// The messages of the socket between a device and the home's computer, as docs/protocol.md has
// them: values, and how they are read and written. Reading refuses what is missing, of a wrong type
// or out of range, by name; it never throws.
namespace roomwise::service {

constexpr int kProtocolVersion = 1;
// A message that is longer is refused before it is parsed.
constexpr std::size_t kMaxFrameBytes = 4'000'000;
constexpr std::size_t kMaxTextBytes = 16'384;       // from a device
constexpr std::size_t kMaxWordsBytes = 500;         // of a question in one's own words
constexpr std::size_t kMaxHomeTextBytes = 262'144;  // from the computer: lists of rooms and things

// ---- from the device ----

enum class DeviceKind { kPhone, kWearable, kPage };
enum class Distances { kMetres, kSteps };

// How a person wants to be spoken to.
struct SpeakingSettings {
  std::string language = "en";  // BCP 47
  Distances distances = Distances::kMetres;
  double step_m = 0.7;
  bool callouts = true;    // is told of a room that is entered without asking
  bool may_watch = false;  // helpers see where they are, and on what way they are led

  friend bool operator==(const SpeakingSettings&, const SpeakingSettings&) = default;
};

// What is known of a device's camera. Without calibration (a phone) its focal length is found from
// the pictures.
struct DeviceCamera {
  int width = 0, height = 0;  // px
  std::optional<geometry::PinholeCamera> calibrated = std::nullopt;
  bool has_depth = false;
  // Of a camera without calibration, the device's name for its lens: what is learned of one says
  // nothing of another.
  std::string lens = {};
};

struct Hello {
  int version = 0;
  std::string name;
  DeviceKind kind = DeviceKind::kPage;
  std::optional<DeviceCamera> camera;  // absent: it sends no frames
  SpeakingSettings settings;
};

enum class Question {
  kWhereAmI,
  kAroundMe,
  kWhereIs,
  kWayTo,  // all of the way, at once
  kRepeat,
  kNameRoom,
  kTakeMeTo,  // is led there
  kGuide,     // to whoever leads
  kInWords,   // in one's own words
  kWhatIsOn,
  kWhatIsIn,
  kWhichRooms,
  kWhichWay,  // does one look
  kWhatIsAhead,
  kWhatIsLeft,  // of who asks
  kWhatIsRight,
  kWhatIsBehind,
  kWhereToSit,
  kWhatChanged,
  kDescribeRoom,
  kWhatCanIAsk,
  kTeachThing,  // a thing is shown from now on
  kNameThing,   // enough was shown: what it is called
  kStopTeaching,
  kForgetThing,  // that was taught
  kShareThing,   // with all people of the home
  kKeepThing,    // its owner's alone
  kMarkSpot,     // where one stands is remembered
  kTakeMeBack,   // is led to where that was last, or where one set out
  kWhichSpots,
  kForgetSpot,
  kRenameSpot,
  kWhoIsHere,  // whether somebody is in the picture
  kIsItLight,  // in the picture
  kShowWalks,  // helpers may watch from now on
  kHideWalks,
};
[[nodiscard]] std::string_view to_string(Question question);  // as the protocol calls it
// What there is to say to a guide on the way.
enum class GuideWish { kPause, kResume, kHowFar, kNext, kBlocked, kEnd };

struct Ask {
  std::int64_t id = 0;
  double t_ms = 0;  // by the device's clock
  Question question = Question::kWhereAmI;
  // The thing of kWayTo, kWhatIsOn and kNameThing to kKeepThing, the room of kNameRoom, kWhatIsIn
  // and kDescribeRoom (empty: where one stands), either of kWhereIs and kTakeMeTo; the words of
  // kInWords; the spot of kMarkSpot and kForgetSpot (empty: one without a name) and kRenameSpot.
  std::string subject;
  bool is_room = false;                // the subject of kWhereIs and kTakeMeTo
  GuideWish wish = GuideWish::kPause;  // of kGuide
  bool is_private = false;             // the thing of kNameThing: its owner's alone
  std::string name = {};               // of kRenameSpot: the new one
  std::string in_room = {};  // of kWhereIs, kWayTo and kTakeMeTo a thing: the one in this room
  std::string to_room = {};  // of a door of that room: the one to this one
  bool is_way_out = false;   // of these: the way out is asked for, and no subject
};

// Those that are given take the place of the earlier ones.
struct SettingsChange {
  std::optional<std::string> language;
  std::optional<Distances> distances;
  std::optional<double> step_m;
  std::optional<bool> callouts;
  std::optional<bool> may_watch = std::nullopt;
};

struct Quiet {
  bool on = false;
};

// A helper looks at the walks on which people are led, or does so no more.
struct Watch {
  bool on = false;
};

using DeviceMessage = std::variant<Hello, Ask, SettingsChange, Quiet, Watch>;

[[nodiscard]] Expected<DeviceMessage> read_device_message(std::string_view json);
[[nodiscard]] std::string write(const DeviceMessage& message);
// The id of an Ask that cannot be read otherwise, so that its asker learns that there will be no
// answer.
[[nodiscard]] std::optional<std::int64_t> id_of_ask(std::string_view json);
void apply(const SettingsChange& change, SpeakingSettings& settings);

struct ImageSize {
  int width = 0, height = 0;  // px

  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

// What a device knew of its motion when it took a picture.
struct FramePose {
  std::string source;  // who told it: "webxr"
  geometry::DeviceMotion motion;
  // How sure it is, where it says so: of the position (x, y, z in its world, m) and of the rotation
  // (about the same axes, rad), in this order.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance = std::nullopt;
};

// A frame of the camera. The images lie in the message that it was read from. From `camera` on it
// is what version 2 of the header may add.
struct FrameMessage {
  double t_ms = 0;
  std::span<const std::uint8_t> color;  // JPEG, PNG or WebP
  std::span<const std::uint8_t> depth;  // 16-bit PNG, or empty
  // Of this picture, where the device's lens moves; without distortion. Absent: that of the hello.
  std::optional<geometry::PinholeCamera> camera = std::nullopt;
  // Of a depth image that shows what the picture shows in another size.
  std::optional<ImageSize> depth_size = std::nullopt;
  std::optional<FramePose> pose = std::nullopt;
};
// A header without what version 2 adds is written as version 1.
[[nodiscard]] Expected<FrameMessage> read_frame(std::span<const std::uint8_t> message);
// The time of a frame that cannot be read otherwise, so that its sender learns which one it is.
[[nodiscard]] std::optional<double> time_of_frame(std::span<const std::uint8_t> message);
[[nodiscard]] Bytes write(const FrameMessage& frame);

// ---- from the computer ----

// Several of one name, in different rooms.
struct ThingInRooms {
  std::string thing;
  std::vector<std::string> rooms;

  bool operator==(const ThingInRooms&) const = default;
};

struct Welcome {
  std::string home;
  std::string role;
  std::vector<std::string> rooms;
  std::vector<std::string> things;
  bool has_room_classifier = false;     // rooms were learned
  bool can_localize = false;            // there is a map to find places on
  std::vector<std::string> spots = {};  // that were marked, as far as this device may know
  std::vector<ThingInRooms> things_in_rooms = {};  // of the things those that must be told apart
};

struct FrameArrived {
  double t_ms = 0;
  std::uint64_t dropped = 0;
};

struct SeenPosition {
  double x_m = 0, y_m = 0, z_m = 0;  // on the home's plan, z over the floor
  double heading_degrees = 0;        // of the camera's axis, counter-clockwise from x
  double sigma_m = 0;
};

struct Seen {
  double t_ms = 0;
  std::string room_decision;  // rooms::to_string(Verdict)
  std::string room;           // the likeliest
  double probability = 0;
  std::string why;
  std::optional<SeenPosition> position;
};

// Where the goal is of who is led and about to touch it.
struct GoalBearing {
  double t_ms = 0;             // of the picture that tells it
  double bearing_degrees = 0;  // from the camera's axis, positive to the left
  double distance_m = 0;
  double valid_until_t_ms = 0;
};

struct PromptMessage {
  std::optional<std::int64_t> answer_to;
  std::string replace_key;  // what it is about: it replaces a prompt of the same key that waits
  std::string message_id;   // its name in the catalogue
  std::string text, language, priority, confidence, sound, because;
  std::optional<double> based_on_t_ms;
  double valid_until_t_ms = 0;
};

struct RecordingState {
  std::int64_t device = 0;
  std::string state;  // "recording", "saved", "empty", "failed"; "none": it is not recorded
  std::string name;
  std::uint64_t frames = 0;
  std::string text;
};

struct JobState {
  std::string kind;   // "map", "learn"
  std::string state;  // "running", "done", "failed", "stopped"
  std::string stage;
  double fraction = 0;
  std::optional<double> left_s;
  std::string text;  // in English, as in the log
  // How it ended, which pages say in their language with these numbers; empty while it runs.
  std::string message = {};
  std::map<std::string, std::int64_t> values = {};
};

struct DeviceSeen {
  std::int64_t device = 0;
  std::string name;
  bool online = false;
  std::optional<Seen> seen;
};

// What a helper who watches sees of somebody who is led. Its times are of the computer's steady
// clock, for their differences alone.
struct WatchedWalk {
  struct Person {
    double t_ms = 0;          // when the picture came
    double x_m = 0, y_m = 0;  // on the plan
    double heading_degrees = 0;
    double sigma_m = 0;
  };
  struct Said {
    double t_ms = 0;
    std::string text;
  };
  std::string language;  // of goal and said
  std::string goal;
  std::string state;                 // to_string(guide::Course)
  std::optional<Person> person;      // by the newest picture that told
  std::optional<double> left_m;      // of the way
  std::vector<Eigen::Vector2d> way;  // its corners on the plan
  std::vector<Said> said;            // the newest last
};

struct WatchedDevice {
  std::int64_t device = 0;
  std::string name;
  double t_ms = 0;         // when this was so: of two messages the later one holds
  bool may_watch = false;  // its person says so; else there is no walk here, whether or not they go
  std::optional<WatchedWalk> walk = std::nullopt;  // absent: they are not led
};

struct ErrorMessage {
  std::string text;
  std::optional<std::int64_t> answer_to;
  std::optional<double> t_ms = std::nullopt;  // of the frame that it is about
};

// What a device needs to understand; the rest is for pages.
using HomeMessage = std::variant<Welcome, FrameArrived, Seen, GoalBearing, PromptMessage,
                                 RecordingState, JobState, DeviceSeen, WatchedDevice, ErrorMessage>;

[[nodiscard]] std::string write(const HomeMessage& message);
// The message `home` is read as a Welcome. Fails on types that are not known, naming them.
[[nodiscard]] Expected<HomeMessage> read_home_message(std::string_view json);
// A Welcome sent because rooms or things changed: of type "home".
[[nodiscard]] std::string write_home_changed(const Welcome& welcome);

}  // namespace roomwise::service
