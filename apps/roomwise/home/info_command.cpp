#include <filesystem>
#include <fstream>
#include <map>
#include <type_traits>

#include "commands.h"
#include "left_out.h"
#include "open_home.h"
#include "roomwise/home/home.h"
#include "roomwise/image/codec.h"
#include "roomwise/mapping/frontend/loop_closer.h"
#include "roomwise/mapping/graph/g2o_file.h"
#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/network/vision/open_vocabulary.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/recording/association.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/room_labels.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct InfoOptions {
  fs::path path;
  bool digest = false;
  bool verify = false;
};

// Lines "name: value" for people, members for machines.
class Facts {
 public:
  explicit Facts(const fs::path& path, const std::string& kind) {
    answer_.text = fmt::format("{}: {}\n", path.string(), kind);
    answer_.json = {{"path", path.string()}, {"kind", kind}};
  }
  template <typename Value>
  void add(const std::string& name, const Value& value) {
    if constexpr (std::is_same_v<Value, bool>) {
      answer_.text += fmt::format("  {:<20} {}\n", name, value ? "yes" : "no");
    } else {
      answer_.text += fmt::format("  {:<20} {}\n", name, value);
    }
    answer_.json[key(name)] = value;
  }
  // The same, where machines get more than people.
  void add(const std::string& name, const std::string& text, Json value) {
    add(name, text);
    answer_.json[key(name)] = std::move(value);
  }
  [[nodiscard]] Answer answer() && { return std::move(answer_); }

 private:
  // "key-frames" becomes "keyframes", "loop closures" "loop_closures".
  static std::string key(std::string name) {
    std::erase_if(name, [](char one) { return one == '-' || one == '\''; });
    std::ranges::replace(name, ' ', '_');
    return name;
  }
  Answer answer_;
};

Expected<Answer> describe_home(const InfoOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.path, context));
  if (options.verify) ROOMWISE_RETURN_IF_ERROR(home.verify());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto edges, home.edges());
  ROOMWISE_TRY(const auto objects, home.confirmed_objects());
  ROOMWISE_TRY(const pipeline::HomeThings things, pipeline::find_home_things(home));
  ROOMWISE_TRY(const auto edits, home.edits());
  ROOMWISE_TRY(const auto rooms, home.rooms());
  ROOMWISE_TRY(const auto networks, home.networks());
  ROOMWISE_TRY(const auto finders, home.region_finders());
  ROOMWISE_TRY(const auto classifier, home.room_classifier());

  Facts facts(options.path, "home");
  Json walks = Json::array();
  std::vector<std::string> recording_names, room_names, network_names, detector_names;
  std::map<home::KeyframeId, std::uint64_t> component_of;
  for (const home::Keyframe& one : keyframes) component_of[one.id] = one.pose.component;
  std::size_t frames = 0, placed = 0, on_map = 0;
  for (const home::StoredRecording& stored : recordings) {
    ROOMWISE_TRY(const auto of_recording, home.frames(stored.id));
    const auto placed_here = static_cast<std::size_t>(std::ranges::count_if(
        of_recording, [](const home::Frame& frame) { return frame.place.has_value(); }));
    const auto on_map_here =
        static_cast<std::size_t>(std::ranges::count_if(of_recording, [&](const home::Frame& frame) {
          return frame.place && component_of.at(frame.place->keyframe) == 0;
        }));
    frames += of_recording.size();
    placed += placed_here;
    on_map += on_map_here;
    // A walk's own largest component says where it belongs.
    std::optional<std::uint64_t> component;
    std::size_t own_keyframes = 0;
    for (const home::Keyframe& keyframe : keyframes) {
      if (keyframe.recording != stored.id) continue;
      ++own_keyframes;
      component = std::min(component.value_or(keyframe.pose.component), keyframe.pose.component);
    }
    std::string note = stored.finished ? "" : " (unfinished)";
    if (component.value_or(0) != 0) note += " (not joined with the map)";
    recording_names.push_back(stored.recording.name + note);
    walks.push_back({{"name", stored.recording.name},
                     {"frames", of_recording.size()},
                     {"placed", placed_here},
                     {"on_map", on_map_here},
                     {"keyframes", own_keyframes},
                     {"component", component ? Json(*component) : Json()},
                     {"finished", stored.finished}});
  }
  for (const rooms::Room& room : rooms) room_names.push_back(room.name);
  for (const auto& [id, network] : networks) network_names.push_back(network.name);
  for (const auto& [id, finder] : finders) detector_names.push_back(finder.name);

  facts.add("recordings", fmt::format("{}", fmt::join(recording_names, ", ")), std::move(walks));
  facts.add("frames", frames);
  facts.add("frames placed", placed);
  facts.add("frames on the map", on_map);
  facts.add("key-frames", keyframes.size());
  facts.add("edges", edges.size());
  facts.add("returns to a place", std::ranges::count_if(edges, mapping::spans_long_loop));
  facts.add("objects", things.things.size());
  facts.add("changed by hand", edits.size());
  facts.add("by the paper's rules", objects.size());
  facts.add("rooms", fmt::format("{}", fmt::join(room_names, ", ")));
  facts.add("networks", fmt::format("{}", fmt::join(network_names, ", ")));
  facts.add("detectors", fmt::format("{}", fmt::join(detector_names, ", ")));
  facts.add("rooms learned with", classifier ? classifier->network_name : "");
  facts.add("protected", home.is_protected());
  if (options.verify) facts.add("verified", true);
  if (options.verify && home.is_locked()) {
    facts.add("not verified", "the seals of its pictures, which need the passphrase");
  }
  if (options.digest) {
    ROOMWISE_TRY(const std::string digest, home.content_digest());
    facts.add("content sha256", digest);
  }
  return std::move(facts).answer();
}

std::string describe(const geometry::PinholeCamera& camera) {
  return fmt::format("{}x{}, fx {:g} fy {:g} cx {:g} cy {:g}", camera.width, camera.height,
                     camera.fx, camera.fy, camera.cx, camera.cy);
}

double seconds_of(TimestampNs length_ns) {
  return std::round(static_cast<double>(length_ns) * kSecondsPerNs * 1000) / 1000;
}

Expected<void> add_rooms_and_truth(const fs::path& folder, Facts& facts) {
  if (fs::exists(folder / "rooms.txt")) {
    ROOMWISE_TRY(const auto labels, recording::RoomLabels::read(folder / "rooms.txt"));
    std::set<std::string> rooms;
    for (const recording::RoomRange& range : labels.ranges()) rooms.insert(range.room);
    facts.add("rooms", fmt::format("{}", fmt::join(rooms, ", ")));
  }
  facts.add("ground truth", fs::exists(folder / "groundtruth.txt"));
  return {};
}

// What is there and never given on.
void add_left_out(const image::PersonalData& left_out, Facts& facts) {
  if (left_out.any()) facts.add("left out", left_out_text(left_out), left_out_json(left_out));
}

// The frames that only --skip-damaged goes on without.
void add_damage(const recording::Recording& recording, Facts& facts) {
  if (recording.damaged().empty()) return;
  Json all = Json::array();
  for (const recording::DamagedFrame& one : recording.damaged()) all.push_back(one.why);
  facts.add("damaged frames",
            fmt::format("{}; the first: {}", all.size(), recording.damaged().front().why),
            std::move(all));
}

// A TUM folder whose camera nobody says can be looked at all the same.
Expected<Answer> describe_without_camera(const fs::path& folder) {
  ROOMWISE_TRY(const auto colors, recording::ImageList::open(folder, "rgb.txt"));
  ROOMWISE_TRY(const auto depths, recording::ImageList::open(folder, "depth.txt"));
  const auto frames = recording::associate(colors.timestamps_ns(), depths.timestamps_ns(),
                                           recording::RecordingOptions{}.tolerance_ns);
  Facts facts(folder, "recording");
  facts.add("format", "TUM folder");
  facts.add("colour images", colors.size());
  facts.add("frames", frames.size());
  facts.add("seconds", seconds_of(colors.timestamps_ns().back() - colors.timestamps_ns().front()));
  facts.add("camera", "not given (no camera.txt; use --camera)");
  add_left_out(recording::personal_data_of_some(colors.size(),
                                                [&](std::size_t i) { return colors.read(i); }),
               facts);
  ROOMWISE_RETURN_IF_ERROR(add_rooms_and_truth(folder, facts));
  return std::move(facts).answer();
}

Expected<Answer> describe_recording(const fs::path& path) {
  const bool is_tum = recording::TumRecording::recognises(path);
  if (is_tum && !fs::exists(path / "camera.txt")) return describe_without_camera(path);
  ROOMWISE_TRY(const auto recording, recording::open_recording(path));
  const auto& pictures = recording->pictures();
  Facts facts(path, "recording");
  facts.add("format", recording->kind());
  facts.add("colour images", pictures.size());
  facts.add("frames", recording->frames().size());
  facts.add("from", format_timestamp(pictures.front().timestamp_ns));
  facts.add("to", format_timestamp(pictures.back().timestamp_ns));
  facts.add("seconds", seconds_of(pictures.back().timestamp_ns - pictures.front().timestamp_ns));
  facts.add("camera", describe(recording->info().camera));
  if (const auto doubt = recording->info().camera.doubt()) facts.add("doubt", *doubt);
  facts.add("device's poses", recording->device_poses().size());
  if (!recording->notes().empty()) {
    facts.add("notes", fmt::format("{}", fmt::join(recording->notes(), "; ")));
  }
  add_damage(*recording, facts);
  add_left_out(recording->info().personal_data, facts);
  ROOMWISE_RETURN_IF_ERROR(add_rooms_and_truth(path, facts));
  return std::move(facts).answer();
}

Expected<Answer> describe_pose_graph(const fs::path& path) {
  ROOMWISE_TRY(const mapping::PoseGraph graph, mapping::read_g2o(path));
  Facts facts(path, "pose graph");
  facts.add("poses", graph.world_from_node.size());
  facts.add("edges", graph.edges.size());
  facts.add("returns to a place", std::ranges::count_if(graph.edges, mapping::spans_long_loop));
  facts.add("F", mapping::pose_graph_chi2(graph));
  return std::move(facts).answer();
}

// The file's, and where a card of one's own goes into it, what homes know the network by.
Expected<void> add_digests(const fs::path& path, const std::string& fingerprint, Facts& facts) {
  ROOMWISE_TRY(const Bytes bytes, read_file(path));
  const std::string sha256 = sha256_hex(bytes);
  facts.add("sha256", sha256);
  if (fingerprint != sha256) facts.add("fingerprint", fingerprint);
  return {};
}

Expected<Answer> describe_detector(const fs::path& path) {
  ROOMWISE_TRY(const auto detector, network::Detector::load(path));
  const network::ModelCard& card = detector->card();
  Facts facts(path, "network that finds things");
  facts.add("name", card.name);
  facts.add("input", fmt::format("{}x{}", card.input_width_px, card.input_height_px));
  facts.add("labels", detector->labels().size());
  facts.add("license", card.license);
  ROOMWISE_RETURN_IF_ERROR(add_digests(path, detector->fingerprint(), facts));
  return std::move(facts).answer();
}

Expected<Answer> describe_word_networks(const fs::path& path) {
  ROOMWISE_TRY(const auto both, network::OpenVocabulary::load(path));
  const network::ModelCard& card = both->card();
  Facts facts(path, "networks that compare pictures with words");
  facts.add("name", card.name);
  facts.add("input", fmt::format("{}x{}", card.input_width_px, card.input_height_px));
  facts.add("texts", card.text->network);
  facts.add("features", both->size());
  facts.add("license", card.license);
  return std::move(facts).answer();
}

Expected<Answer> describe_network(const fs::path& path) {
  const auto found_card = network::find_model_card(path);
  if (found_card && network::finds_things(found_card->task)) return describe_detector(path);
  if (found_card && found_card->text) return describe_word_networks(path);
  ROOMWISE_TRY(const auto network, network::OnnxClassifier::load(path));
  const network::ModelCard& card = network->card();
  Facts facts(path, "network");
  facts.add("name", network->name());
  facts.add("input", fmt::format("{}x{}", card.input_width_px, card.input_height_px));
  facts.add("features", network->feature_size());
  facts.add("labels", network->labels().size());
  facts.add("license", card.license);
  if (network::is_eight_bit_file(path)) {
    ROOMWISE_TRY(const auto how, network::read_eight_bit_file(path));
    facts.add("in 8 bits", how.checked);
    facts.add("of", how.network.string());
    facts.add("sha256", how.sha256);
    return std::move(facts).answer();
  }
  ROOMWISE_RETURN_IF_ERROR(add_digests(path, network->fingerprint(), facts));
  return std::move(facts).answer();
}

Expected<Answer> describe_picture(const fs::path& path) {
  ROOMWISE_TRY(const Bytes bytes, read_file(path));
  if (const auto depth = image::decode_depth(bytes)) {
    Facts facts(path, "depth image");
    facts.add("width", depth->width());
    facts.add("height", depth->height());
    const auto measured = std::ranges::count_if(depth->pixels(), [](auto d) { return d != 0; });
    facts.add("measured",
              static_cast<double>(measured) / static_cast<double>(depth->pixels().size()));
    return std::move(facts).answer();
  }
  ROOMWISE_TRY(const image::ColorImage color, image::read_color(path));
  Facts facts(path, "picture");
  facts.add("width", color.width());
  facts.add("height", color.height());
  return std::move(facts).answer();
}

std::string first_bytes(const fs::path& path) {
  std::string bytes(16, '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), std::ssize(bytes));
  return bytes;
}

Expected<Answer> run(const InfoOptions& options, Context& context) {
  const fs::path& path = options.path;
  if (!fs::exists(path)) return fail("{}: there is no such file or folder", path.string());
  if (fs::is_directory(path) || recording::find_recording_kind(path) != nullptr) {
    return describe_recording(path);
  }
  if (!fs::is_regular_file(path)) {
    return fail("{}: is a pipe or a device; give a file or a folder", path.string());
  }
  if (path.extension() == ".g2o") return describe_pose_graph(path);
  if (network::has_ending_of_network(path) || network::is_eight_bit_file(path)) {
    return describe_network(path);
  }
  const std::string bytes = first_bytes(path);
  if (bytes.starts_with("\x89PNG") || bytes.starts_with("\xff\xd8\xff")) {
    return describe_picture(path);
  }
  if (is_database(path) || path.extension() == ".home") {
    return describe_home(options, context);
  }
  return fail(
      "{}: is not known; expected a home, a recording, .g2o, .onnx, .pth, .safetensors, "
      ".eightbits, "
      "PNG or JPEG",
      path.string());
}

}  // namespace

void add_info_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<InfoOptions>(
      app, context, "info",
      "Say what a file is and holds: a home, a recording, a pose graph, a network, a picture",
      "roomwise info my.home", run);
  command->add_option("FILE", options.path, "File or folder")->required();
  command->add_flag("--digest", options.digest,
                    "Of a home: SHA-256 of its content (equal for homes that hold the same)");
  command->add_flag("--verify", options.verify, "Of a home: read all of it and find any damage");
}

}  // namespace roomwise::app
