#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "open_home.h"
#include "roomwise/base/encodings.h"
#include "roomwise/home/writer_lock.h"
#include "roomwise/live/house.h"
#include "roomwise/pipeline/stored/network_precision_key.h"
#include "roomwise/service/credentials/certificate.h"
#include "roomwise/service/credentials/private_file.h"
#include "roomwise/service/credentials/private_folder.h"
#include "roomwise/service/credentials/secrets.h"
#include "roomwise/service/server/request_checks.h"
#include "roomwise/service/server/server_events.h"
#include "roomwise/service/server/staff_routes.h"
#include "serving/qr_code.h"
#include "serving/serve_parts.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// The certificate as a proxy reads it, with its key: proxy.pem.
Expected<void> write_for_proxy(const fs::path& folder, const service::Certificate& certificate) {
  const fs::path file = folder / "proxy.pem";
  const std::string text = certificate.certificate_pem + certificate.key_pem;
  if (const auto there = read_file(file); there && std::ranges::equal(*there, text)) return {};
  return service::write_private_file(file, text);
}

// The certificate of a house, which all processes that serve it share: one of them makes it.
Expected<service::Certificate> house_certificate(const fs::path& folder,
                                                 const std::vector<std::string>& names) {
  constexpr int kTries = 200;
  for (int tries = 0;; ++tries) {
    const auto lock = home::WriterLock::take(folder / "certificate");
    if (lock) {
      ROOMWISE_TRY(auto made, service::own_certificate(folder, names, seconds_since_1970()));
      ROOMWISE_RETURN_IF_ERROR(write_for_proxy(folder, made));
      return made;
    }
    if (lock.error().code != ErrorCode::kRefused || tries == kTries) {
      return Unexpected(Error(lock.error()));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

// What who asks for the figures of all homes has to show; made at the first start.
Expected<std::string> metrics_token(const fs::path& folder) {
  const fs::path file = folder / "metrics-token";
  std::error_code error;
  if (!fs::exists(file, error)) {
    ROOMWISE_TRY(const Bytes random, service::random_bytes(32));
    ROOMWISE_RETURN_IF_ERROR(service::write_private_file(file, base64url(random)));
  }
  ROOMWISE_TRY(const Bytes bytes, read_file(file));
  std::string token(bytes.begin(), bytes.end());
  while (token.ends_with('\n')) token.pop_back();
  return token;
}

// Homes that look by the same networks share them.
class SharedNetworks {
 public:
  explicit SharedNetworks(NetworkOptions options) : options_(std::move(options)) {}

  // `open_options`: of that home.
  Expected<std::shared_ptr<const pipeline::Networks>> of(const fs::path& file,
                                                         const home::OpenOptions& open_options) {
    ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(file, open_options));
    ROOMWISE_TRY(const std::string key, pipeline::network_precision_key(home));
    // One after the other: who waits for the same ones finds them.
    const std::scoped_lock lock(mutex_);
    last_ = known_[key].lock();
    if (!last_) {
      ROOMWISE_TRY(auto loaded, load_networks(options_, &home, /*also_brought=*/true));
      last_ = std::make_shared<const pipeline::Networks>(std::move(loaded));
      known_[key] = last_;
    }
    return last_;
  }

 private:
  const NetworkOptions options_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const pipeline::Networks>> known_;  // by what decides them
  std::shared_ptr<const pipeline::Networks> last_;  // the next home is likely to look by them
};

// What a process that serves a house consists of, in the order in which it is made; it ends in the
// reverse.
class HouseServer {
 public:
  static Expected<std::unique_ptr<HouseServer>> start(const ServeOptions& options,
                                                      Context& context) {
    std::unique_ptr<HouseServer> serving(new HouseServer(options, context));
    HouseServer& all = *serving;
    ROOMWISE_RETURN_IF_ERROR(service::make_private_folder(all.own_folder_));
    ROOMWISE_TRY(all.certificate_, house_certificate(all.own_folder_, names_and(options.names)));
    ROOMWISE_TRY(all.metrics_token_, metrics_token(all.own_folder_));
    ROOMWISE_TRY(all.accounts_, open_accounts(options.home, options.accounts));
    ROOMWISE_TRY(all.finders_, load_object_finders());
    ROOMWISE_TRY(all.house_, live::House::open(options.home, all.finders_, all.house_options()));
    ROOMWISE_TRY(all.server_, service::Server::open(all.server_options(), *all.house_));
    all.server_->serve();  // now that the routes, which ask it, find it
    return serving;
  }
  ~HouseServer() {
    if (server_) server_->stop();
  }
  HouseServer(const HouseServer&) = delete;
  HouseServer& operator=(const HouseServer&) = delete;

  [[nodiscard]] std::string address() const { return url_of(options_, server_->port()); }
  [[nodiscard]] std::uint16_t port() const { return server_->port(); }
  [[nodiscard]] live::House& house() { return *house_; }
  [[nodiscard]] service::Certificate certificate() const {
    const std::scoped_lock lock(certificate_mutex_);
    return certificate_;
  }
  void renew_certificate() {
    auto now = house_certificate(own_folder_, names_and(options_.names));
    if (!now) {
      if (std::exchange(told_, now.error().message) != now.error().message) log_.write(told_);
      return;
    }
    const std::scoped_lock lock(certificate_mutex_);
    if (now->own_fingerprint == certificate_.own_fingerprint) return;
    certificate_ = *std::move(now);
    server_->use_certificate(certificate_);
  }
  // Ends WebSockets of staff who may not open the home any more, or in another role, or have signed
  // out elsewhere.
  void see_to_staff() {
    for (const std::string& home : house_->open_homes()) {
      for (const auto& [device, role] : server_->roles_online(home)) {
        if (device >= 0) continue;
        const auto role_now = accounts_->role_now(-device, home, service::Now::read());
        // Where the accounts are away, who is in stays.
        if (!role_now || *role_now == role) continue;
        server_->disconnect(service::DeviceOfHome{home, device}, "this account may not any more");
      }
    }
  }
  Expected<void> show_code(service::Role role) {
    ROOMWISE_TRY(const service::OpenCode code, house_->make_code(options_.one, role));
    ROOMWISE_RETURN_IF_ERROR(print_code(code, role, pair_address(options_.one)));
    std::cout.flush();
    return {};
  }

 private:
  HouseServer(const ServeOptions& options, const Context& context)
      : options_(options),
        context_(context),
        own_folder_(house_folder(options.home)),
        networks_(options.networks) {}

  [[nodiscard]] std::string pair_address(const std::string& home) const {
    return fmt::format("{}/homes/{}/pair", address(), home);
  }

  // Each home has a key of its own, and no other home's.
  [[nodiscard]] Expected<home::OpenOptions> open_options(const std::string& home) const {
    home::OpenOptions options;
    std::error_code error;
    if (options_.passphrases.empty() || !fs::exists(options_.passphrases / home, error)) {
      return options;
    }
    ROOMWISE_TRY(home::Passphrase passphrase, home::Passphrase::read(options_.passphrases / home));
    options.passphrase = std::make_shared<const home::Passphrase>(std::move(passphrase));
    return options;
  }

  live::HouseOptions house_options() {
    live::HouseOptions house;
    house.max_open = options_.open_homes;
    house.idle_s = options_.close_after_s;
    house.fingerprint = certificate_.fingerprint;
    house.networks =
        [this](const fs::path& file) -> Expected<std::shared_ptr<const pipeline::Networks>> {
      ROOMWISE_TRY(const home::OpenOptions open, open_options(file.stem().string()));
      return networks_.of(file, open);
    };
    house.open_options = [this](const std::string& home) { return open_options(home); };
    const live::WorkShare work = live::share_of_work(ThreadPool::default_size(), context_.threads);
    house.home.threads = work.threads;
    house.home.work_places = std::make_shared<live::WorkPlaces>(work.places);
    house.home.frame_workers = context_.threads;
    house.home.seed = context_.seed;
    house.home.clock = seconds_since_1970;
    house.home.log = [this](std::string_view line) { log_.write(line); };
    house.access = [this](const std::string& home) { return access_context(home); };
    house.audit = [this](const live::HouseAct& act) { note(act); };
    house.known_to_house = [this](const service::HttpRequest& request, const std::string& home) {
      return service::staff_in_home(*accounts_, request, home, service::Now::read());
    };
    house.role_of_account = [this](std::int64_t account, const std::string& home) {
      return accounts_->role_in_home(account, home);
    };
    // Staff begin here; a home's own people have its address.
    house.front.push_back({"GET", "/", {}, [](const auto&, const auto&) {
                             service::HttpAnswer moved;
                             moved.status = 302;
                             moved.headers = {{"Location", "/staff"}};
                             return moved;
                           }});
    service::StaffRoutesContext staff;
    staff.homes = [this] { return house_->names(); };
    staff.on_signed_out = [this](std::int64_t account) { disconnect_staff(account); };
    staff.log = [this](std::string_view line) { log_.write(line); };
    std::ranges::move(service::staff_routes(*accounts_, std::move(staff)),
                      std::back_inserter(house.front));
    house.front.push_back({"GET", "/metrics", {}, [this](const auto& request, const auto&) {
                             return metrics(request);
                           }});
    return house;
  }

  // Among who did what; where that cannot be written, in the log.
  void note(const live::HouseAct& act) {
    const bool is_staff = act.who.is_account();
    const service::AuditLine line{
        seconds_since_1970(),
        is_staff ? act.who.name : fmt::format("device {} ({})", act.who.device, act.who.name),
        act.home,
        act.what,
        fmt::format("{}", act.status),
        act.peer};
    if (const auto noted = accounts_->note(line); !noted) {
      log_.write(fmt::format("{}: {}: {}: {} (not kept among who did what: {})", act.home, line.who,
                             act.what, act.status, noted.error().message));
    }
  }

  void disconnect_staff(std::int64_t account) {
    for (const std::string& home : house_->open_homes()) {
      server_->disconnect(
          service::DeviceOfHome{home, service::Identity::device_of_account(account)}, "signed out");
    }
  }

  service::AccessRoutesContext access_context(const std::string& home) {
    service::AccessRoutesContext context;
    context.online = [this, home] { return server_->online(home); };
    context.disconnect = [this, home](std::int64_t device) {
      server_->disconnect(service::DeviceOfHome{home, device}, "this device was removed");
    };
    context.authority = [this] { return certificate().authority; };
    context.pair_address = [this, home] { return pair_address(home); };
    context.qr = [](const std::string& text) {
      return qr_rows(text).value_or(std::vector<std::string>{});
    };
    return context;
  }

  service::ServerOptions server_options() {
    constexpr std::size_t kConnectionsOfAHome = 64;
    service::ServerOptions server;
    server.certificate = certificate_;
    server.address = options_.address;
    server.port = options_.port;
    server.allowed_hosts = names_and(options_.names);
    server.allowed_hosts.insert(server.allowed_hosts.end(), options_.allowed_hosts.begin(),
                                options_.allowed_hosts.end());
    server.proxies = {options_.proxies.begin(), options_.proxies.end()};
    server.limits.connections = kConnectionsOfAHome * (1 + options_.open_homes);
    server.limits.waiting_requests = 256;
    // Some wait for homes that are being opened, or for a password's turn; others must not wait for
    // these.
    server.workers = std::max<std::size_t>(8, context_.threads) + service::kPasswordPlaces;
    server.session_threads = std::max<std::size_t>(2, context_.threads);
    server.pages = options_.pages.empty() ? brought_pages() : options_.pages;
    server.log = [this](std::string_view line) { log_.write(line); };
    return server;
  }

  service::HttpAnswer metrics(const service::HttpRequest& request) {
    const auto shown = service::token_of(request);
    if (!shown || !service::equal_secrets(*shown, metrics_token_)) {
      return service::error_answer(
          401, "figures of all homes are for who shows the token in house.access/metrics-token");
    }
    service::MetricsText text;
    service::write_metrics(server_->counts(), text);
    house_->write_metrics(text);
    service::HttpAnswer answer = service::text_answer(text.text());
    answer.content_type = "text/plain; version=0.0.4";
    return answer;
  }

  const ServeOptions options_;
  const Context& context_;
  const fs::path own_folder_;
  OperatorLog log_;
  SharedNetworks networks_;
  objects::ObjectFinders finders_;
  mutable std::mutex certificate_mutex_;
  service::Certificate certificate_;
  std::string metrics_token_;
  std::unique_ptr<service::AccountStore> accounts_;
  std::string told_;
  std::unique_ptr<live::House> house_;
  std::unique_ptr<service::Server> server_;
};

}  // namespace

Expected<Answer> serve_house(const ServeOptions& options, Context& context) {
  catch_interrupts();
  cv::setNumThreads(1);
  if (!options.speak.empty()) return fail("--speak is for one home, and this is a folder of them");
  if (!options.pair.empty() && options.one.empty()) {
    return fail("--pair needs to know the home: --home NAME");
  }
  if (!context.passphrase_file.empty()) {
    return fail(
        "--passphrase-file is for one home; give --passphrases FOLDER, with a file for each");
  }
  ROOMWISE_TRY(const auto server, HouseServer::start(options, context));
  const service::Certificate certificate = server->certificate();
  std::cout << fmt::format(
      "{} serves the {} homes in {} at port {}\nIts certificate's fingerprint (SHA-256): {}\n",
      server->address(), server->house().names().size(), options.home.string(), server->port(),
      service::fingerprint_with_colons(certificate.own_fingerprint));
  std::cout << words_for_phones(options, server->address(), certificate);
  if (!options.pair.empty()) {
    ROOMWISE_RETURN_IF_ERROR(server->show_code(*service::parse_role(options.pair)));
  }
  if (!options.one.empty()) std::cout << "Enter makes a new code for a device. ";
  std::cout << "Ctrl-C stops it.\n" << std::flush;
  EnterKey enter;
  for (int turns = 0; !context.progress.interrupted(); ++turns) {
    if (!options.one.empty() && enter.take()) {
      tell_of_code(server->show_code(service::Role::kDevice));
    }
    constexpr int kTurnsOfASecond = 10;
    if (turns % kTurnsOfASecond == 0) server->house().tidy();
    if (turns % (5 * kTurnsOfASecond) == 0) server->see_to_staff();
    if (turns % (60 * kTurnsOfASecond) == 0) {
      server->house().watch_disk();
      server->renew_certificate();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return Answer{"stopped\n", Json::object()};
}

}  // namespace roomwise::app
