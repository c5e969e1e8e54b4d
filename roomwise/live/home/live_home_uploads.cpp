#include <algorithm>
#include <cctype>

#include "roomwise/base/name.h"
#include "roomwise/live/home/live_home.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/zip_unpack.h"

// Recordings that somebody hands in as files.
namespace roomwise::live {
namespace {

namespace fs = std::filesystem;

// What a walk's folder is called after the file that was handed in: "Flat 3.zip" gives "Flat 3".
std::string name_of_walk(const std::string& file_name) {
  std::string name = fs::path(file_name).stem().string();
  std::ranges::replace_if(
      name, [](unsigned char c) { return c == '/' || c == '\\' || std::iscntrl(c) != 0; }, '_');
  name.erase(0, name.find_first_not_of(". "));
  if (!is_name(name) || !recording::validate_room_name(name)) return "walk";
  return name;
}

// The recordings in a folder: itself, or those below it.
std::vector<fs::path> recordings_in(const fs::path& folder, int depth) {
  if (recording::find_recording_kind(folder) != nullptr) return {folder};
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error) && depth > 0) {
      std::ranges::move(recordings_in(entry.path(), depth - 1), std::back_inserter(found));
    } else if (entry.is_regular_file(error) && recording::find_recording_kind(entry.path())) {
      found.push_back(entry.path());
    }
    if (found.size() > 1) break;
  }
  return found;
}

TakenIn refused(std::string message, std::string text) {
  return {{}, job_failure(std::move(message), std::move(text))};
}

// The recording that was unpacked to a folder, or why there is not one alone.
TakenIn recording_in(const fs::path& folder, const std::string& name) {
  constexpr int kMaxDepth = 3;  // apps put one or two folders around
  const std::vector<fs::path> found = recordings_in(folder, kMaxDepth);
  if (found.size() == 1) return {found.front(), {}};
  if (found.size() > 1) {
    return refused("several_recordings",
                   fmt::format("'{}' holds several recordings; hand them in one by one", name));
  }
  std::string kinds;
  for (const recording::RecordingKind& kind : recording::recording_kinds()) {
    kinds += fmt::format("{}{}", kinds.empty() ? "" : ", ", kind.name);
  }
  return refused(
      "no_recording",
      fmt::format("'{}' holds no recording of a kind that is read; these are: {}", name, kinds));
}

// Of a zip archive that was not unpacked; nothing where the error says all by its code.
std::optional<JobEnd> why_not_unpacked(const Error& error) {
  if (error.code == ErrorCode::kDamaged) return job_failure("file_damaged", error.message);
  if (error.code == ErrorCode::kRefused) return job_failure("file_unsafe", error.message);
  return std::nullopt;
}

// Whether at least half of the frames of a recording that was mapped could be read; of one that was
// stopped before its end, as far as that can be seen without reading all pictures.
bool is_mostly_whole(const fs::path& path, const Expected<JobEnd>& mapped) {
  const auto recording = recording::open_recording(path);
  if (!recording) return false;
  std::size_t damaged = (*recording)->damaged().size();
  const std::size_t frames = (*recording)->frames().size() + damaged;
  if (mapped && mapped->values.contains("damaged")) {
    damaged = static_cast<std::size_t>(mapped->values.at("damaged"));
  }
  return 2 * damaged <= frames;
}

Expected<void> move_to(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return fail("{}: cannot become {}: {}", from.string(), to.string(), error.message());
  return {};
}

}  // namespace

fs::path LiveHome::uploads_folder() const {
  return fs::path(file_.string() + ".uploads");
}

// In the folder of walks, of no walk yet, not even of one whose pictures were removed.
Expected<fs::path> LiveHome::unused_path(const std::string& stem, const std::string& ending) {
  fs::path path = walks_folder() / (stem + ending);
  for (int i = 2;; ++i) {
    std::error_code error;
    ROOMWISE_TRY(const bool is_known, has_recording_of(path));
    if (!is_known && !fs::exists(path, error)) return path;
    path = walks_folder() / fmt::format("{} {}{}", stem, i, ending);
  }
}

Expected<Upload> LiveHome::put_upload(const std::string& id, std::uint64_t offset,
                                      std::span<const std::uint8_t> piece) {
  return watched("an upload", uploads_->put(id, offset, piece));
}

Expected<void> LiveHome::map_upload(const std::string& id) {
  ROOMWISE_TRY(const Upload upload, uploads_->find(id));
  if (!upload.is_complete()) {
    return fail("'{}' is not whole: {} of {} bytes are there", upload.name, upload.offset,
                upload.bytes);
  }
  const auto map_now = [this, upload](Progress& progress) -> Expected<JobEnd> {
    ROOMWISE_TRY(const TakenIn taken, take_in(upload, progress));
    if (taken.refused) return *taken.refused;
    const fs::path& path = taken.path;
    auto mapped = map_folder(path, progress);
    if (!mapped && mapped.error().code == ErrorCode::kRefused) {
      mapped = job_failure("walk_known", mapped.error().message);
    }
    ROOMWISE_TRY(const bool is_in_home, has_recording_of(path));
    std::error_code error;
    const fs::path file = uploads_->file_of(upload.id);
    const bool is_archive = fs::exists(file, error);
    if (is_in_home && (!is_archive || is_mostly_whole(path, mapped))) {
      ROOMWISE_RETURN_IF_ERROR(uploads_->remove(upload.id));
      return mapped;
    }
    // An archive of which most could not be read stays: it may be all that there is. What did not
    // come into the home waits as it was: nothing of it is kept twice.
    if (!is_in_home && !is_archive) ROOMWISE_RETURN_IF_ERROR(move_to(path, file));
    if (!is_in_home) fs::remove_all(path, error);
    ROOMWISE_RETURN_IF_ERROR(uploads_->note_walk(upload.id, ""));
    return mapped;
  };
  // Also where it is stopped before it has a place to work at.
  const auto map =
      [this, work = with_place(map_now, WorkPlaces::Urgency::kCanWait)](JobProgress& progress) {
        Expected<JobEnd> mapped = work(progress);
        const std::scoped_lock lock(upload_mutex_);
        upload_in_hand_.clear();
        return mapped;
      };
  return instead_of_preparing([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(check_idle());
    const std::scoped_lock lock(upload_mutex_);
    ROOMWISE_RETURN_IF_ERROR(jobs_->start("map", map));
    upload_in_hand_ = id;
    return {};
  });
}

bool LiveHome::is_being_mapped(const std::string& upload) const {
  const std::scoped_lock lock(upload_mutex_);
  return upload == upload_in_hand_ && jobs_->running();
}

Expected<void> LiveHome::remove_upload(const std::string& id) {
  const std::scoped_lock lock(upload_mutex_);
  if (id == upload_in_hand_ && jobs_->running()) {
    return fail("it is being mapped; wait until that is done, or stop it");
  }
  return uploads_->remove(id);
}

Expected<void> LiveHome::go_on_with_uploads() {
  std::error_code error;
  fs::remove_all(unpacking_folder(), error);
  ROOMWISE_TRY(const auto uploads, uploads_->list());
  for (const Upload& upload : uploads) {
    if (upload.walk.empty()) continue;
    const fs::path path = walks_folder() / upload.walk;
    ROOMWISE_TRY(const bool is_in_home, has_recording_of(path));
    const bool is_moved = !fs::exists(uploads_->file_of(upload.id), error);
    const bool is_there = fs::exists(path, error);
    // An archive of which most cannot be read stays, as it does where nothing was killed.
    const bool is_done =
        is_moved || (is_in_home && is_mostly_whole(path, fail("nobody counted what is damaged")));
    if (is_there && is_done) {
      ROOMWISE_RETURN_IF_ERROR(uploads_->remove(upload.id));
    } else if (!is_there || is_in_home) {
      ROOMWISE_RETURN_IF_ERROR(uploads_->note_walk(upload.id, ""));
    }
  }
  return {};
}

fs::path LiveHome::unpacking_folder() const {
  return walks_folder() / ".unpacking";
}

Expected<TakenIn> LiveHome::take_in(const Upload& upload, Progress& progress) {
  const fs::path unpacked = unpacking_folder();
  std::error_code error;
  fs::remove_all(unpacked, error);
  if (error) return fail("{}: cannot be removed: {}", unpacked.string(), error.message());
  ROOMWISE_RETURN_IF_ERROR(make_walks_folder());
  auto taken = take_in(upload, unpacked, progress);
  fs::remove_all(unpacked, error);
  return taken;
}

Expected<TakenIn> LiveHome::take_in(const Upload& upload, const fs::path& unpacked,
                                    Progress& progress) {
  const fs::path file = uploads_->file_of(upload.id);
  const std::string name = name_of_walk(upload.name);
  // Record3D's recordings are zip archives that are read as they are.
  if (recording::find_recording_kind(file) != nullptr) {
    ROOMWISE_TRY(const fs::path path,
                 unused_path(name, fs::path(upload.name).extension().string()));
    ROOMWISE_RETURN_IF_ERROR(uploads_->note_walk(upload.id, path.filename().string()));
    ROOMWISE_RETURN_IF_ERROR(move_to(file, path));
    return TakenIn{path, {}};
  }
  if (!recording::is_zip_file(file)) {
    return refused(
        "file_unknown",
        fmt::format("'{}' is neither a zip archive nor a recording that is read", upload.name));
  }
  recording::UnpackLimits limits;
  ROOMWISE_TRY(limits.max_bytes, uploads_->writable_bytes());
  if (limits.max_bytes == 0) {
    return fail_with(ErrorCode::kDiskFull,
                     "the computer's disk has no room to unpack '{}'; free some space",
                     upload.name);
  }
  if (const auto done = recording::unpack_zip(file, unpacked, limits, progress); !done) {
    auto why = why_not_unpacked(done.error());
    if (!why) return Unexpected(done.error());
    return TakenIn{{}, std::move(why)};
  }
  TakenIn inside = recording_in(unpacked, upload.name);
  if (inside.refused) return inside;
  const fs::path& found = inside.path;
  // Where somebody lives, and with what they recorded it, is not kept.
  if (fs::is_directory(found)) ROOMWISE_RETURN_IF_ERROR(recording::leave_out_personal_data(found));
  ROOMWISE_TRY(
      const fs::path path,
      unused_path(name, fs::is_directory(found) ? std::string() : found.extension().string()));
  ROOMWISE_RETURN_IF_ERROR(uploads_->note_walk(upload.id, path.filename().string()));
  ROOMWISE_RETURN_IF_ERROR(move_to(found, path));
  return TakenIn{path, {}};
}

}  // namespace roomwise::live
