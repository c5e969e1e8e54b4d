#pragma once

#include <filesystem>
#include <memory>
#include <utility>

#include "roomwise/home/home.h"
#include "roomwise/live/home/live_home.h"
#include "roomwise/service/client/client.h"

namespace roomwise::trials {

// A folder of a program's own, readable by its user alone; it goes with this.
class OwnFolder {
 public:
  [[nodiscard]] static Expected<OwnFolder> make();
  ~OwnFolder();
  OwnFolder(OwnFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  OwnFolder& operator=(OwnFolder&&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit OwnFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

// The computer of a home, as `roomwise serve` puts it together, on a port of this machine's own:
// a home that is open behind HTTPS and WebSockets, with one device that is paired. It serves a
// copy, so that the home stays as it is.
class GuidingServer {
 public:
  // Copies the home and waits until pictures can be placed on its map. Fails where it has none.
  // `networks` and `finders` must outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<GuidingServer>> start(
      const std::filesystem::path& home, const pipeline::Networks& networks,
      const objects::ObjectFinders& finders, const home::OpenOptions& open = {});
  ~GuidingServer();
  GuidingServer(const GuidingServer&) = delete;
  GuidingServer& operator=(const GuidingServer&) = delete;

  [[nodiscard]] Expected<std::unique_ptr<service::ServerConnection>> connect() const;
  // As it dies midway.
  void stop();
  [[nodiscard]] std::shared_ptr<const live::HomeView> view() const { return home_->view(); }

 private:
  explicit GuidingServer(OwnFolder folder) : folder_(std::move(folder)) {}

  OwnFolder folder_;
  std::unique_ptr<live::LiveHome> home_;
  std::unique_ptr<service::AccessRegister> access_;
  service::ServerCredentials credentials_;
  std::unique_ptr<service::Server> server_;
};

}  // namespace roomwise::trials
