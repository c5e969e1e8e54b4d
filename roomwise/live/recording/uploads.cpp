#include "roomwise/live/recording/uploads.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/live/recording/remove_folder.h"
#include "roomwise/service/protocol/json_members.h"

namespace roomwise::live {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kIdDigits = 24;
constexpr std::size_t kMaxFactsBytes = 2'000;

bool is_id(const std::string& id) {
  return id.size() == kIdDigits && id.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string id_of(const std::string& name, std::uint64_t bytes, const std::string& modified) {
  const std::string text = fmt::format("{}\n{}\n{}", bytes, modified, name);
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()})
      .substr(0, kIdDigits);
}

// Appends at the end; what could not be written whole stays as far as it was: it is counted.
Expected<void> append_to(const fs::path& path, std::span<const std::uint8_t> bytes) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  int error = descriptor < 0 ? errno : 0;
  while (error == 0 && !bytes.empty()) {
    const ssize_t put = ::write(descriptor, bytes.data(), bytes.size());
    if (put >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(put));
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (descriptor >= 0) ::close(descriptor);
  if (error == 0) return {};
  const ErrorCode code = code_of_write_error(error);
  return fail_with(code, "{}: cannot be written: {}{}", path.string(), std::strerror(error),
                   code == ErrorCode::kDiskFull
                       ? "; free some space, then go on: what came before is kept"
                       : "");
}

}  // namespace

Expected<void> UploadLimits::validate() const {
  if (max_bytes == 0) return fail("max_bytes = 0 takes no file");
  if (max_uploads == 0) return fail("max_uploads = 0 takes no file");
  return {};
}

Expected<Uploads> Uploads::open(fs::path folder, UploadLimits limits) {
  ROOMWISE_RETURN_IF_ERROR(limits.validate());
  if (!limits.free_bytes) limits.free_bytes = free_bytes_at;
  return Uploads(std::move(folder), std::move(limits));
}

fs::path Uploads::file_of(const std::string& id) const {
  return folder_ / (id + ".part");
}

fs::path Uploads::metadata_path(const std::string& id) const {
  return folder_ / (id + ".json");
}

Expected<std::uint64_t> Uploads::writable_bytes() const {
  ROOMWISE_TRY(const std::uint64_t free, limits_.free_bytes(folder_));
  return free > limits_.reserve_bytes ? free - limits_.reserve_bytes : 0;
}

Expected<Upload> Uploads::read(const std::string& id) const {
  std::error_code error;
  if (!is_id(id) || !fs::exists(metadata_path(id), error)) {
    return fail("there is no upload '{}'; begin it anew", id);
  }
  ROOMWISE_TRY(const std::string text, read_text_file(metadata_path(id)));
  ROOMWISE_TRY(const service::OrderedJson json, service::parse_object(text, kMaxFactsBytes));
  service::Members members(json);
  Upload upload{id, members.text("name"),
                static_cast<std::uint64_t>(members.integer("bytes", 1, service::kMaxInteger)), 0};
  if (members.has("walk")) upload.walk = members.text("walk", kMaxFactsBytes);
  if (members.error())
    return Unexpected(Error(*members.error()).with_context(metadata_path(id).string()));
  const auto there = fs::file_size(file_of(id), error);
  if (!error) upload.offset = std::min<std::uint64_t>(there, upload.bytes);
  return upload;
}

Expected<std::vector<Upload>> Uploads::read_all() const {
  std::vector<Upload> all;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string id = entry.path().stem().string();
    if (entry.path().extension() != ".json" || !is_id(id)) continue;
    if (auto upload = read(id)) {
      all.push_back(*std::move(upload));
    } else if (read_text_file(entry.path())) {
      // What it says is damaged: set aside, so that it does not stand in the way of all others.
      for (const fs::path& file : {file_of(id), entry.path()})
        fs::rename(file, file.string() + ".damaged", error);
    } else {
      return Unexpected(upload.error());
    }
  }
  std::ranges::sort(all, {}, &Upload::id);
  return all;
}

Expected<std::vector<Upload>> Uploads::list() const {
  const std::scoped_lock lock(mutex_);
  return read_all();
}

Expected<Upload> Uploads::find(const std::string& id) const {
  const std::scoped_lock lock(mutex_);
  return read(id);
}

Expected<Upload> Uploads::begin(const std::string& name, std::uint64_t bytes,
                                const std::string& modified) {
  const std::scoped_lock lock(mutex_);
  const std::string id = id_of(name, bytes, modified);
  if (auto known = read(id)) return known;
  if (bytes > limits_.max_bytes) {
    return fail("'{}' has {} MB; at most {} are taken", name, bytes / 1'000'000,
                limits_.max_bytes / 1'000'000);
  }
  ROOMWISE_TRY(const std::vector<Upload> all, read_all());
  std::uint64_t still_to_come = bytes;
  for (const Upload& one : all) still_to_come += one.bytes - one.offset;
  if (all.size() >= limits_.max_uploads) {
    return fail("{} files wait already; map or remove one of them first", all.size());
  }
  ROOMWISE_TRY(const std::uint64_t room, writable_bytes());
  if (still_to_come > room) {
    return fail(
        "the computer's disk has room for {} MB more, and {} MB are to come; free some space",
        room / 1'000'000, still_to_come / 1'000'000);
  }
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) return fail("{}: cannot be made: {}", folder_.string(), error.message());
  fs::permissions(folder_, fs::perms::owner_all, error);  // pictures of a home
  fs::remove(file_of(id), error);
  ROOMWISE_RETURN_IF_ERROR(write_facts({.id = id, .name = name, .bytes = bytes}));
  return read(id);
}

Expected<Upload> Uploads::put(const std::string& id, std::uint64_t offset,
                              std::span<const std::uint8_t> chunk) {
  const std::scoped_lock lock(mutex_);
  ROOMWISE_TRY(const Upload upload, read(id));
  if (offset > upload.offset) {
    return fail("the bytes from {} to {} are missing; go on from {}", upload.offset, offset,
                upload.offset);
  }
  if (chunk.size() > upload.bytes - std::min(offset, upload.bytes)) {
    return fail("the piece ends at {}, beyond the file's {} bytes", offset + chunk.size(),
                upload.bytes);
  }
  const std::uint64_t known = upload.offset - offset;
  if (known < chunk.size()) ROOMWISE_RETURN_IF_ERROR(append_to(file_of(id), chunk.subspan(known)));
  return read(id);
}

Expected<void> Uploads::note_walk(const std::string& id, const std::string& walk) {
  const std::scoped_lock lock(mutex_);
  ROOMWISE_TRY(Upload upload, read(id));
  upload.walk = walk;
  return write_facts(upload);
}

Expected<void> Uploads::write_facts(const Upload& upload) const {
  service::OrderedJson facts{{"name", upload.name}, {"bytes", upload.bytes}};
  if (!upload.walk.empty()) facts["walk"] = upload.walk;
  return write_file(metadata_path(upload.id), service::dump(facts) + "\n");
}

Expected<void> Uploads::remove(const std::string& id) {
  const std::scoped_lock lock(mutex_);
  if (!is_id(id)) return fail("there is no upload '{}'", id);
  std::error_code error;
  fs::remove(file_of(id), error);
  if (!error) fs::remove(metadata_path(id), error);
  if (error)
    return fail("{}: could not be removed: {}", metadata_path(id).string(), error.message());
  return {};
}

Expected<void> Uploads::remove_all() {
  const std::scoped_lock lock(mutex_);
  return remove_folder(folder_);
}

}  // namespace roomwise::live
