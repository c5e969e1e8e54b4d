#include "laboratory/trials/guidance/guiding_server.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include "roomwise/service/credentials/certificate.h"
#include "roomwise/service/credentials/private_folder.h"

namespace roomwise::trials {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHost = "127.0.0.1";

// What helpers look at is fused when questions can be answered already: nobody looks here.
Expected<void> wait_for_places(live::LiveHome& home, const fs::path& file) {
  while (home.jobs().running() && !home.view()->map) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  static_cast<void>(home.jobs().stop("prepare"));
  home.jobs().wait();
  const auto view = home.view();
  if (!view->map || !view->map->localizer) {
    const auto state = home.jobs().state();
    return fail("{}: pictures cannot be placed on it{}", file.string(),
                state && state->state == "failed" ? ": " + state->text : "");
  }
  if (!view->map->frame.has_floor || !view->map->floor) {
    return fail("{}: its map shows no floor to be led over", file.string());
  }
  return {};
}

}  // namespace

Expected<OwnFolder> OwnFolder::make() {
  std::error_code error;
  const fs::path all = fs::temp_directory_path(error);
  std::string name = (all / "roomwise-guidance-XXXXXX").string();
  if (error || ::mkdtemp(name.data()) == nullptr) {
    return fail("{}: no folder can be made there; name another one by TMPDIR", all.string());
  }
  return OwnFolder(name);
}

OwnFolder::~OwnFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

Expected<std::unique_ptr<GuidingServer>> GuidingServer::start(const fs::path& home,
                                                              const pipeline::Networks& networks,
                                                              const objects::ObjectFinders& finders,
                                                              const home::OpenOptions& open) {
  ROOMWISE_TRY(OwnFolder folder, OwnFolder::make());
  std::unique_ptr<GuidingServer> guiding(new GuidingServer(std::move(folder)));
  GuidingServer& all = *guiding;
  const fs::path copy = all.folder_.path() / "served.home";
  std::error_code error;
  fs::copy_file(home, copy, error);
  if (error) return fail("{}: cannot be copied: {}", home.string(), error.message());
  live::LiveHomeOptions options;
  options.open = open;
  options.clock = [] { return service::Now::read().unix_s; };
  ROOMWISE_TRY(all.home_, live::LiveHome::open(copy, networks, finders, options));
  ROOMWISE_RETURN_IF_ERROR(wait_for_places(*all.home_, home));
  const fs::path access = service::access_folder(copy);
  ROOMWISE_RETURN_IF_ERROR(service::make_private_folder(access));
  const service::Now now = service::Now::read();
  service::ServerOptions server;
  ROOMWISE_TRY(server.certificate, service::own_certificate(access, {kHost}, now.unix_s));
  ROOMWISE_TRY(all.access_, service::AccessRegister::open(access, server.certificate.fingerprint));
  ROOMWISE_TRY(const service::Pairing paired,
               all.access_->pair_here(service::Role::kDevice, "simulated walker", now));
  all.credentials_ = {server.certificate.fingerprint, paired.token};
  server.address = kHost;
  ROOMWISE_TRY(all.server_, service::Server::start(std::move(server), service::Router({}),
                                                   *all.access_, *all.home_));
  return guiding;
}

GuidingServer::~GuidingServer() {
  stop();
}

void GuidingServer::stop() {
  if (server_) server_->stop();
}

Expected<std::unique_ptr<service::ServerConnection>> GuidingServer::connect() const {
  service::ClientWait wait;
  // The machine draws the pictures, too: it may be slow, and is not gone.
  wait.timeout = wait.silence = std::chrono::seconds(30);
  return service::ServerConnection::open({kHost, server_->port()}, credentials_, wait);
}

}  // namespace roomwise::trials
