#include "roomwise/recording/phone/stray_scanner.h"

#include <algorithm>
#include <array>

#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/data_lines.h"
#include "roomwise/recording/phone/json_file.h"
#include "roomwise/recording/phone/longest_rise.h"
#include "roomwise/recording/phone/numbered_files.h"
#include "roomwise/recording/phone/phone_recording.h"
#include "roomwise/recording/phone/video_file.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

// A table of values divided by commas, its lines' ends and blanks taken away.
struct CsvLine {
  std::size_t number = 0;  // in the file, from 1
  std::vector<std::string_view> values;
  bool complete = true;  // false for a last line without its line end
};
std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}
std::vector<CsvLine> csv_lines(std::string_view text) {
  std::vector<CsvLine> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const bool complete = end < text.size();
    std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    CsvLine values{number, {}, complete};
    for (;;) {
      const std::size_t comma = std::min(line.find(','), line.size());
      values.values.push_back(trimmed(line.substr(0, comma)));
      if (comma == line.size()) break;
      line.remove_prefix(comma + 1);
    }
    lines.push_back(std::move(values));
  }
  return lines;
}

// The columns of odometry.csv by its header.
class OdometryTable {
 public:
  static Expected<OdometryTable> read(const fs::path& file) {
    OdometryTable table;
    table.file_ = file.string();
    ROOMWISE_TRY(std::string text, read_text_file(file));
    table.text_ = std::make_unique<const std::string>(std::move(text));
    table.lines_ = csv_lines(*table.text_);
    if (table.lines_.size() > 1 && !table.lines_.back().complete) {
      table.cut_off_ = table.lines_.back().number;  // and so may be its last number
      table.lines_.pop_back();
    }
    if (table.lines_.size() < 2) return fail("{}: holds no frame", table.file_);
    return table;
  }

  [[nodiscard]] std::size_t size() const { return lines_.size() - 1; }
  [[nodiscard]] bool has(std::string_view column) const { return place_of(column).has_value(); }
  // The number of a last line within which the file ends, and which is no row.
  [[nodiscard]] std::optional<std::size_t> cut_off() const { return cut_off_; }
  // Fails where a column is missing that every row needs.
  [[nodiscard]] Expected<void> check_columns() const {
    for (const char* column : {"timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw"}) {
      if (has(column)) continue;
      return fail("{}:{}: has no column '{}'", file_, lines_.front().number, column);
    }
    return {};
  }
  [[nodiscard]] std::string place(std::size_t row) const {
    return fmt::format("{}:{}", file_, lines_[row + 1].number);
  }
  [[nodiscard]] Expected<std::string_view> word(std::size_t row, std::string_view column) const {
    const auto at = place_of(column);
    if (!at) return fail("{}:{}: has no column '{}'", file_, lines_.front().number, column);
    const auto& values = lines_[row + 1].values;
    if (values.size() != lines_.front().values.size()) {
      return fail("{}: has {} values, the header {}; is the file cut off?", place(row),
                  values.size(), lines_.front().values.size());
    }
    return values[*at];
  }
  template <typename Number>
  [[nodiscard]] Expected<Number> number(std::size_t row, std::string_view column) const {
    ROOMWISE_TRY(const std::string_view text, word(row, column));
    const auto value = parse_number<Number>(text);
    if (!value) return fail("{}: {} = '{}' is no such number", place(row), column, text);
    return *value;
  }

 private:
  OdometryTable() = default;
  [[nodiscard]] std::optional<std::size_t> place_of(std::string_view column) const {
    const auto& header = lines_.front().values;
    const auto found = std::ranges::find(header, column);
    if (found == header.end()) return std::nullopt;
    return static_cast<std::size_t>(found - header.begin());
  }

  std::string file_;
  std::unique_ptr<const std::string> text_;  // what the lines point into
  std::vector<CsvLine> lines_;
  std::optional<std::size_t> cut_off_;
};

// Three rows of three numbers.
Expected<geometry::PinholeCamera> read_camera_matrix(const fs::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  std::vector<double> values;
  for (const CsvLine& line : csv_lines(text)) {
    for (const std::string_view word : line.values) {
      const auto value = parse_number<double>(word);
      if (!value) return fail("{}:{}: '{}' is no number", file.string(), line.number, word);
      values.push_back(*value);
    }
  }
  if (values.size() != 9)
    return fail("{}: has {} numbers, expected 9", file.string(), values.size());
  geometry::PinholeCamera camera;
  camera.fx = values[0];
  camera.cx = values[2];
  camera.fy = values[4];
  camera.cy = values[5];
  return camera;
}

Expected<geometry::PinholeCamera> camera_of_row(const OdometryTable& table, std::size_t row,
                                                const geometry::PinholeCamera& otherwise) {
  if (!table.has("fx")) return otherwise;
  geometry::PinholeCamera camera;
  ROOMWISE_TRY(camera.fx, table.number<double>(row, "fx"));
  ROOMWISE_TRY(camera.fy, table.number<double>(row, "fy"));
  ROOMWISE_TRY(camera.cx, table.number<double>(row, "cx"));
  ROOMWISE_TRY(camera.cy, table.number<double>(row, "cy"));
  return camera;
}

// Its axes are ours already.
Expected<geometry::RigidTransform> pose_of_row(const OdometryTable& table, std::size_t row) {
  std::array<double, 7> values{};
  constexpr std::array kNames{"x", "y", "z", "qx", "qy", "qz", "qw"};
  for (std::size_t i = 0; i < values.size(); ++i) {
    ROOMWISE_TRY(values[i], table.number<double>(row, kNames[i]));
  }
  const Eigen::Quaterniond rotation(values[6], values[3], values[4], values[5]);
  constexpr double kRounding = 0.01;
  if (!(std::abs(rotation.norm() - 1) < kRounding)) {
    return fail("{}: the quaternion has not the length 1", table.place(row));
  }
  return geometry::RigidTransform{rotation.normalized(), {values[0], values[1], values[2]}};
}

struct StrayRow {
  PhonePicture picture;  // without its files
  StampedPose pose;
};
Expected<StrayRow> read_row(const OdometryTable& table, std::size_t row,
                            const geometry::PinholeCamera& otherwise) {
  StrayRow read;
  PhonePicture& picture = read.picture;
  picture.place = row;
  ROOMWISE_TRY(picture.index, table.number<std::uint64_t>(row, "frame"));
  ROOMWISE_TRY(const auto time, table.word(row, "timestamp"));
  ROOMWISE_TRY(picture.timestamp_ns, in_context(table.place(row), parse_timestamp(time)));
  ROOMWISE_TRY(picture.camera, camera_of_row(table, row, otherwise));
  ROOMWISE_TRY(read.pose.world_from_camera, pose_of_row(table, row));
  read.pose.timestamp_ns = picture.timestamp_ns;
  return read;
}

// Takes the rows of which `value` does not increase with the longest run of the others for damaged.
template <typename Value>
void mark_out_of_order_damaged(std::vector<Expected<StrayRow>>& rows, const OdometryTable& table,
                               const char* what, Value PhonePicture::*value) {
  std::vector<std::size_t> whole;
  std::vector<Value> values;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!rows[row]) continue;
    whole.push_back(row);
    values.push_back(rows[row]->picture.*value);
  }
  const std::vector<bool> is_in_order = in_longest_increasing_subsequence(values);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (is_in_order[i]) continue;
    rows[whole[i]] =
        fail("{}: its {} does not fit those of the other lines", table.place(whole[i]), what);
  }
}

std::vector<Expected<StrayRow>> read_rows(const OdometryTable& table, std::size_t count,
                                          const geometry::PinholeCamera& otherwise) {
  std::vector<Expected<StrayRow>> rows;
  for (std::size_t row = 0; row < count; ++row) rows.push_back(read_row(table, row, otherwise));
  mark_out_of_order_damaged(rows, table, "number", &PhonePicture::index);
  mark_out_of_order_damaged(rows, table, "time", &PhonePicture::timestamp_ns);
  return rows;
}

// What an end that was cut off lacks.
void note_end(const OdometryTable& table, const VideoFile& video, PhoneListing& listing) {
  if (table.cut_off()) {
    listing.notes.push_back(
        fmt::format("odometry.csv ends within line {}, which is left out", *table.cut_off()));
  }
  if (video.size() < table.size()) {
    listing.notes.push_back(
        fmt::format("rgb.mp4 has {} pictures, odometry.csv {} frames: what comes before is read",
                    video.size(), table.size()));
  }
}

}  // namespace

bool is_stray_scanner_folder(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / "rgb.mp4", ignored) &&
         fs::is_regular_file(folder / "odometry.csv", ignored);
}

Expected<std::unique_ptr<Recording>> open_stray_scanner_folder(const fs::path& folder,
                                                               const RecordingOptions& options) {
  ROOMWISE_TRY(const auto table, OdometryTable::read(folder / "odometry.csv"));
  ROOMWISE_RETURN_IF_ERROR(table.check_columns());
  ROOMWISE_TRY(const auto depths, numbered_files(folder / "depth", "", ".png"));
  geometry::PinholeCamera camera;
  if (!table.has("fx")) {
    ROOMWISE_TRY(camera, read_camera_matrix(folder / "camera_matrix.csv"));
  }
  const fs::path file = folder / "rgb.mp4";
  ROOMWISE_TRY(auto opened, VideoFile::open(file));
  const std::shared_ptr<VideoFile> video = std::move(opened);
  PhoneListing listing{"Stray Scanner", recording_name(folder), {}, {}};
  listing.poses_are_device_motion = true;  // ARKit's
  listing.device_up = kArkitUp;
  listing.personal_data = video->personal_data();
  note_end(table, *video, listing);
  std::uint64_t next = 0;
  for (auto& read : read_rows(table, std::min(table.size(), video->size()), camera)) {
    if (!read) {
      listing.damaged.push_back({next, read.error().message});
      continue;
    }
    next = read->picture.index + 1;
    read->picture.color = file;
    read->picture.depth = file_or_none(depths, read->picture.index);
    listing.device_poses.push_back(read->pose);
    listing.pictures.push_back(std::move(read->picture));
  }
  listing.read_color = [video](std::size_t place) { return video->read(place); };
  return PhoneRecording::open(std::move(listing), options);
}

}  // namespace roomwise::recording
