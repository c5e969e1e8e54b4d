#include "roomwise/live/home/home_backup.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/base/file_descriptor.h"
#include "roomwise/base/put_in_place.h"
#include "roomwise/home/writer_lock.h"
#include "roomwise/live/recording/remove_folder.h"
#include "roomwise/service/access/access.h"
#include "roomwise/service/credentials/private_folder.h"

namespace roomwise::live {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kWalks = ".walks";
// What lies beside a home and belongs to it, by the end of its name.
constexpr std::array<std::string_view, 4> kBeside{".access", ".photos", ".lenses.json", kWalks};

fs::path beside(const fs::path& home, std::string_view ending) {
  return fs::path(home.string() + std::string(ending));
}

// What a database keeps beside it while it is open; its copy has all in one file.
bool is_part_of_database(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with("-wal") || name.ends_with("-shm") || name.ends_with("-journal") ||
         name.ends_with("-lock");
}

Expected<void> copy_database(const fs::path& from, const fs::path& to) {
  ROOMWISE_TRY(const auto source, home::Database::open(from, home::Database::Access::kReadOnly));
  ROOMWISE_RETURN_IF_ERROR(write_file(to, std::string_view()));
  ROOMWISE_TRY(auto copy, home::Database::open(to, home::Database::Access::kReadWrite));
  return source.copy_to(copy);
}

Expected<void> copy_file(const fs::path& from, const fs::path& to, Backup& backup) {
  if (is_part_of_database(from)) return {};
  if (is_database(from)) {
    ROOMWISE_RETURN_IF_ERROR(copy_database(from, to));
  } else {
    std::error_code error;
    if (!fs::copy_file(from, to, error)) {
      return fail("{}: cannot be copied to {}: {}", from.string(), to.string(), error.message());
    }
  }
  std::error_code ignored;
  fs::permissions(to, fs::perms::owner_read | fs::perms::owner_write, ignored);
  ++backup.files;
  backup.bytes += fs::file_size(to, ignored);
  return {};
}

Expected<void> copy_all(const fs::path& from, const fs::path& to, Backup& backup) {
  if (!fs::is_directory(from)) return copy_file(from, to, backup);
  ROOMWISE_RETURN_IF_ERROR(service::make_private_folder(to));
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(from, error)) {
    if (entry.is_symlink()) continue;  // what lies elsewhere is not the home's
    ROOMWISE_RETURN_IF_ERROR(copy_all(entry.path(), to / entry.path().filename(), backup));
  }
  if (error) return fail("{}: cannot be read: {}", from.string(), error.message());
  return {};
}

Expected<void> copy_home(const home::Home& home, const fs::path& to, Backup& backup) {
  ROOMWISE_RETURN_IF_ERROR(home.copy_to(to));
  ++backup.files;
  backup.bytes += fs::file_size(to);
  return {};
}

Expected<void> copy_beside(const fs::path& from, const fs::path& to, bool with_walks,
                           Backup& backup) {
  for (const std::string_view ending : kBeside) {
    if (ending == kWalks && !with_walks) continue;
    const fs::path source = beside(from, ending);
    if (fs::exists(source)) ROOMWISE_RETURN_IF_ERROR(copy_all(source, beside(to, ending), backup));
  }
  return {};
}

// How many devices are paired with the home, which nobody has open; without them none is after it.
// Their numbers are given to no other device.
Expected<std::size_t> settle_devices(const fs::path& home, bool with_devices) {
  const fs::path folder = service::access_folder(home);
  if (!service::AccessRegister::exists(folder)) return 0;
  ROOMWISE_TRY(const auto access, service::AccessRegister::open(folder, std::string()));
  if (!with_devices) {
    for (const service::PairedDevice& device : access->devices()) {
      ROOMWISE_RETURN_IF_ERROR(access->revoke(device.who.device));
    }
  }
  return access->devices().size();
}

// The one home that lies in a folder.
Expected<fs::path> home_in(const fs::path& folder) {
  std::vector<fs::path> databases;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file() && is_database(entry.path())) databases.push_back(entry.path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  if (databases.size() == 1) return databases.front();
  return fail("{}: holds {} homes; give a folder that roomwise backup made", folder.string(),
              databases.size());
}

// Nothing of that name is there, not even what a home that was moved away left: its log would be
// played into the one that comes.
Expected<void> check_free(const fs::path& home) {
  std::vector<std::string_view> endings{"", "-wal", "-shm", "-journal"};
  endings.insert(endings.end(), kBeside.begin(), kBeside.end());
  for (const std::string_view ending : endings) {
    if (!fs::exists(beside(home, ending))) continue;
    return fail("{}: is there; move it away first", beside(home, ending).string());
  }
  return {};
}

// All that was copied is on the disk.
Expected<void> flush(const fs::path& folder) {
  const FileDescriptor descriptor{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (descriptor.value >= 0 && ::syncfs(descriptor.value) == 0) return {};
  return fail("{}: cannot be flushed to the disk: {}", folder.string(), std::strerror(errno));
}

}  // namespace

Expected<Backup> back_up(const home::Home& home, const fs::path& folder,
                         const BackupOptions& options) {
  // Another backup into it would take this one's parts for its own.
  ROOMWISE_TRY(const home::WriterLock lock, home::WriterLock::take(folder));
  if (fs::exists(folder)) return fail("{}: is there; give a new folder", folder.string());
  const fs::path file = home.file(), partial = folder.string() + ".part";
  ROOMWISE_RETURN_IF_ERROR(remove_folder(partial));  // of a backup that was stopped
  Backup backup;
  const auto copy = [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(service::make_private_folder(partial));
    const fs::path target = partial / file.filename();
    ROOMWISE_RETURN_IF_ERROR(copy_home(home, target, backup));
    ROOMWISE_RETURN_IF_ERROR(copy_beside(file, target, options.with_walks, backup));
    ROOMWISE_RETURN_IF_ERROR(flush(partial));
    return put_in_place(partial, folder);
  };
  const Expected<void> copied = copy();
  if (copied) return backup;
  (void)remove_folder(partial);
  return Unexpected(copied.error());
}

Expected<Restored> restore(const fs::path& folder, const fs::path& home,
                           const RestoreOptions& options) {
  ROOMWISE_TRY(const fs::path source, home_in(folder));
  ROOMWISE_TRY(const home::WriterLock lock, home::WriterLock::take(home));
  ROOMWISE_RETURN_IF_ERROR(check_free(home));
  ROOMWISE_TRY(const home::Home backed_up, home::Home::open_read_only(source));
  Restored backup;
  const fs::path partial = home.string() + ".restored";
  // The home comes last: until it is there, nothing looks at what lies beside it.
  const auto remove_partial = [&]() -> Expected<void> {
    for (const std::string_view ending : kBeside)
      ROOMWISE_RETURN_IF_ERROR(remove_folder(beside(partial, ending)));
    return remove_folder(partial);
  };
  const auto copy = [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(remove_partial());  // of a restoring that was stopped
    ROOMWISE_RETURN_IF_ERROR(copy_home(backed_up, partial, backup));
    ROOMWISE_RETURN_IF_ERROR(copy_beside(source, partial, true, backup));
    ROOMWISE_TRY(backup.devices, settle_devices(partial, options.with_devices));
    for (const std::string_view ending : kBeside) {
      if (fs::exists(beside(partial, ending)))
        ROOMWISE_RETURN_IF_ERROR(put_in_place(beside(partial, ending), beside(home, ending)));
    }
    ROOMWISE_RETURN_IF_ERROR(flush(fs::absolute(home).parent_path()));
    return put_in_place(partial, home);
  };
  const Expected<void> copied = copy();
  if (copied) return backup;
  (void)remove_partial();
  return Unexpected(copied.error());
}

}  // namespace roomwise::live
