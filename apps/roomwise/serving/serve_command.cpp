#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "commands.h"
#include "device_camera.h"
#include "device_voice.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/live/routes/home_routes.h"
#include "roomwise/service/server/access_routes.h"
#include "roomwise/service/server/server_events.h"
#include "serving/qr_code.h"
#include "serving/serve_parts.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

using Options = ServeOptions;

// What a running server consists of, in the order in which it is made; it ends in the reverse.
class HomeServer {
 public:
  static Expected<std::unique_ptr<HomeServer>> start(const Options& options, Context& context) {
    std::unique_ptr<HomeServer> serving(new HomeServer);
    HomeServer& all = *serving;
    ROOMWISE_TRY(all.networks_, networks_for(options, context));
    ROOMWISE_TRY(all.finders_, load_object_finders());
    live::LiveHomeOptions home;
    home.threads = context.threads;
    home.frame_workers = context.threads;
    home.seed = context.seed;
    home.clock = seconds_since_1970;
    home.log = [&log = all.log_](std::string_view line) { log.write(line); };
    ROOMWISE_TRY(home.open, open_options(context));
    ROOMWISE_TRY(all.home_, live::LiveHome::open(options.home, all.networks_, all.finders_, home));
    const fs::path access = service::access_folder(options.home);
    all.access_folder_ = access;
    all.options_ = options;
    const std::vector<std::string> names = all.names();
    service::ServerOptions server;
    ROOMWISE_TRY(server.certificate, service::own_certificate(access, names, seconds_since_1970()));
    all.certificate_ = server.certificate;
    ROOMWISE_TRY(all.access_,
                 service::AccessRegister::open(access, server.certificate.fingerprint));
    if (const auto& why = all.home_->why_lenses_are_new()) all.log_.write(*why);
    if (!all.home_->view()->recognizer) all.log_.write(all.home_->view()->why_no_recognizer);
    server.address = options.address;
    server.port = options.port;
    server.allowed_hosts = names;
    server.allowed_hosts.insert(server.allowed_hosts.end(), options.allowed_hosts.begin(),
                                options.allowed_hosts.end());
    server.session_threads = context.threads;
    server.pages = options.pages.empty() ? brought_pages() : options.pages;
    server.log = [&log = all.log_](std::string_view line) { log.write(line); };
    ROOMWISE_TRY(all.server_,
                 service::Server::open(std::move(server), service::Router(all.routes()),
                                       *all.access_, *all.home_));
    all.server_->serve();  // now that the routes, which ask it, find it
    return serving;
  }
  ~HomeServer() {
    if (server_) server_->stop();
  }
  HomeServer(const HomeServer&) = delete;
  HomeServer& operator=(const HomeServer&) = delete;

  [[nodiscard]] std::string address() const { return url_of(options_, server_->port()); }
  [[nodiscard]] service::Certificate certificate() const {
    const std::scoped_lock lock(certificate_mutex_);
    return certificate_;
  }
  // Renews the certificate before it ends, and where the computer has got another address.
  void renew_certificate() {
    auto now = service::own_certificate(access_folder_, names(), seconds_since_1970());
    if (!now) return tell_once(now.error().message);
    const std::scoped_lock lock(certificate_mutex_);
    if (now->own_fingerprint == certificate_.own_fingerprint) return;
    certificate_ = *std::move(now);
    server_->use_certificate(certificate_);
  }
  [[nodiscard]] service::AccessRegister& access() { return *access_; }
  [[nodiscard]] live::LiveHome& home() { return *home_; }
  [[nodiscard]] bool has_helper() const {
    const auto devices = access_->devices();
    return std::ranges::any_of(
        devices, [](const auto& one) { return one.who.role == service::Role::kHelper; });
  }

 private:
  HomeServer() = default;

  // As the home, where it is there already, has them look.
  static Expected<pipeline::Networks> networks_for(const Options& options, const Context& context) {
    if (!fs::exists(options.home)) {
      return load_networks(options.networks, nullptr, /*also_brought=*/true);
    }
    ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
    return load_networks(options.networks, &home, /*also_brought=*/true);
  }

  [[nodiscard]] std::vector<std::string> names() const { return names_and(options_.names); }

  // What is wrong again a minute later is said once.
  void tell_once(const std::string& line) {
    if (std::exchange(told_, line) != line) log_.write(line);
  }

  std::vector<service::Route> routes() {
    std::vector<service::Route> routes = live::home_routes(*home_);
    service::AccessRoutesContext context;
    context.online = [this] { return server_->online(); };
    context.disconnect = [this](std::int64_t device) {
      server_->disconnect(device, "this device was removed");
    };
    context.renamed = [this](std::int64_t device, const std::string& name) {
      home_->device_renamed(device, name);
    };
    context.authority = [this] { return certificate().authority; };
    context.pair_address = [this] { return address() + "/pair"; };
    context.qr = [](const std::string& text) {
      return qr_rows(text).value_or(std::vector<std::string>{});
    };
    std::ranges::move(service::access_routes(*access_, std::move(context)),
                      std::back_inserter(routes));
    routes.push_back({"GET", "/health", {}, [](const auto&, const auto&) {
                        return service::json_answer({{"status", "ok"}});
                      }});
    routes.push_back({"GET", "/metrics", service::Role::kHelper,
                      [this](const auto&, const auto&) { return metrics(); }});
    return routes;
  }

  service::HttpAnswer metrics() {
    service::MetricsText text;
    service::write_metrics(server_->counts(), text);
    home_->write_metrics(text);
    service::HttpAnswer answer = service::text_answer(text.text());
    answer.content_type = "text/plain; version=0.0.4";
    return answer;
  }

  Options options_;
  OperatorLog log_;
  pipeline::Networks networks_;
  objects::ObjectFinders finders_;
  std::unique_ptr<live::LiveHome> home_;
  std::unique_ptr<service::AccessRegister> access_;
  fs::path access_folder_;
  mutable std::mutex certificate_mutex_;
  service::Certificate certificate_;
  std::string told_;
  std::unique_ptr<service::Server> server_;
};

// Says the codes by which devices are paired, to who cannot read them.
class SpokenCodes {
 public:
  static Expected<SpokenCodes> open(const Options& options) {
    SpokenCodes spoken(options.language);
    ROOMWISE_RETURN_IF_ERROR(spoken.wording_.style.validate(*spoken.catalogue_));
    ROOMWISE_TRY(auto speaker, open_speaker(options.speak, steady_now_ns(), std::cout));
    spoken.voice_.emplace(std::move(speaker), spoken.wording_);
    return spoken;
  }

  // Digit by digit, twice.
  void say(const std::string& code) {
    std::string digits;
    for (std::size_t i = 0; i < code.size(); ++i) {
      digits += fmt::format("{}{}", i == 0 ? "" : i == 3 ? ", " : " ", code[i]);
    }
    const TimestampNs now_ns = steady_now_ns();
    for (const char* key : {"pairing", "pairing/again"}) {
      guide::Prompt prompt = guide::make_prompt(
          wording_, key, "pairing.code", {{"code", digits}}, guide::Confidence::kSure,
          guide::after(now_ns, kCodeValid_s), "a code was made");
      voice_->say(std::move(prompt), now_ns, false);
    }
  }
  [[nodiscard]] Expected<void> step() { return voice_->step(steady_now_ns()); }

 private:
  static constexpr double kCodeValid_s = 60;

  explicit SpokenCodes(const std::string& language)
      : catalogue_(std::make_unique<guide::MessageCatalogue>(guide::MessageCatalogue::built_in())) {
    wording_.catalogue = catalogue_.get();
    wording_.style.language = language;
  }

  std::unique_ptr<guide::MessageCatalogue> catalogue_;
  guide::Wording wording_;
  std::optional<DeviceVoice> voice_;
};

Expected<void> show_code(HomeServer& server, service::Role role, SpokenCodes* spoken) {
  const service::Now now = service::Now::read();
  ROOMWISE_TRY(const service::OpenCode made, server.access().make_code(role, now));
  ROOMWISE_RETURN_IF_ERROR(print_code(made, role, server.address() + "/pair"));
  if (const double wait_s = server.access().digits_wait_s(now); wait_s > 0) {
    std::cout << fmt::format(
        "Somebody guesses at codes: the digits are heard in {:.0f} s only, the address at once\n",
        std::ceil(wait_s));
  }
  std::cout.flush();
  if (spoken != nullptr) spoken->say(made.digits);
  return {};
}

// A folder that is misspelt, or not mounted, is not to become a new home.
Expected<void> check_is_for_one_home(const Options& options) {
  const Options without;
  const std::pair<const char*, bool> of_folders[] = {
      {"--home", !options.one.empty()},
      {"--open-homes", options.open_homes != without.open_homes},
      {"--close-after", options.close_after_s != without.close_after_s},
      {"--proxy", !options.proxies.empty()},
      {"--public-address", !options.public_address.empty()},
      {"--passphrases", !options.passphrases.empty()},
      {"--accounts", !options.accounts.empty()}};
  for (const auto& [name, is_given] : of_folders) {
    if (is_given) {
      return fail("{}: is no folder, and {} is for a folder of homes", options.home.string(), name);
    }
  }
  return {};
}

Expected<Answer> serve(const Options& options, Context& context) {
  ROOMWISE_RETURN_IF_ERROR(check_pages(options));
  ::umask(077);  // what it writes is of a home: its owner alone reads it
  std::error_code none;
  if (fs::is_directory(options.home, none)) return serve_house(options, context);
  ROOMWISE_RETURN_IF_ERROR(check_is_for_one_home(options));
  catch_interrupts();  // before it says that it serves: whoever waits for that may end it at once
  cv::setNumThreads(1);
  std::optional<SpokenCodes> spoken;
  if (!options.speak.empty()) {
    ROOMWISE_TRY(spoken, SpokenCodes::open(options));
  }
  SpokenCodes* codes = spoken ? &*spoken : nullptr;
  std::error_code ignored;
  const bool is_new = !fs::exists(options.home, ignored);
  ROOMWISE_TRY(const auto server, HomeServer::start(options, context));
  if (is_new) {
    fmt::print(stderr,
               "{} was not there: it is a new home, for walks recorded from the helper's page\n",
               options.home.string());
  }
  const service::Certificate certificate = server->certificate();
  std::cout << fmt::format("{} serves {}\nIts certificate's fingerprint (SHA-256): {}\n",
                           server->address(), options.home.string(),
                           service::fingerprint_with_colons(certificate.own_fingerprint));
  std::cout << words_for_phones(options, server->address(), certificate);
  if (options.pair == "helper" || !server->has_helper()) {
    ROOMWISE_RETURN_IF_ERROR(show_code(*server, service::Role::kHelper, nullptr));
  }
  if (options.pair == "device") {
    ROOMWISE_RETURN_IF_ERROR(show_code(*server, service::Role::kDevice, codes));
  }
  std::cout << "Enter makes a new code for a device. Ctrl-C stops it.\n" << std::flush;
  EnterKey enter;
  int turns = 0;
  while (!context.progress.interrupted()) {
    if (enter.take()) tell_of_code(show_code(*server, service::Role::kDevice, codes));
    if (codes != nullptr) {
      if (const auto spoken_on = codes->step(); !spoken_on) {
        std::cerr << "codes are not spoken any more: " << spoken_on.error().message << '\n';
        codes = nullptr;
      }
    }
    constexpr int kTurnsOfAMinute = 600;
    if (turns++ % kTurnsOfAMinute == 0) {
      server->home().watch_disk();
      server->renew_certificate();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const auto looked_at = server->home().frames_processed();
  return Answer{
      fmt::format("stopped; {} frames were looked at\n", looked_at),
      {{"frames_looked_at", looked_at}, {"frames_dropped", server->home().frames_dropped()}}};
}

}  // namespace

void add_serve_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<Options>(
      app, context, "serve",
      "Open a home for devices and pages: pictures in, answers out (HTTPS on one port)",
      "roomwise serve my.home --address 0.0.0.0", serve);
  command
      ->add_option("HOME", options.home,
                   "Home file; a new one is made where there is none. Or a folder of homes: "
                   "NAME.home is then served at /homes/NAME/")
      ->required();
  add_setting(*command, "--address", options.address,
              "Address to listen on: this computer alone by default, 0.0.0.0 for the whole "
              "home's network");
  add_setting(*command, "--port", options.port, "Port to listen on; 0: any that is free");
  command->add_option("--name", options.names,
                      "Another name or address of this computer, for its certificate (made at the "
                      "first start)");
  command->add_option("--allowed-host", options.allowed_hosts,
                      "Another name by which devices that are not paired yet may call this "
                      "computer, beside its own and --name: of a router or a proxy, for example. "
                      "Addresses are always allowed");
  command->add_option("--pages", options.pages,
                      "Folder of the web pages; default: those that come with Roomwise");
  command
      ->add_option("--pair", options.pair,
                   "Show a code by which a device or a helper is paired (a helper's is shown "
                   "anyway as long as there is none)")
      ->check(CLI::IsMember({"device", "helper"}));
  command->add_option("--speak", options.speak,
                      "Say devices' codes, too: speech-dispatcher, text (lines on standard output) "
                      "or wav:FILE; Enter makes and says a new one");
  add_setting(*command, "--language", options.language,
              "Language of what is said: en, de, es or fr");
  command->add_option("--home", options.one,
                      "Of a folder: the home whose codes are shown (--pair, Enter)");
  add_setting(*command, "--open-homes", options.open_homes,
              "Of a folder: so many homes are in memory at once; the one used least makes room",
              positive());
  add_setting(*command, "--close-after", options.close_after_s,
              "Of a folder: seconds after which a home that nobody uses is closed", positive());
  command->add_option("--proxy", options.proxies,
                      "Of a folder: address of a proxy that says by X-Forwarded-For for whom it "
                      "asks");
  command->add_option("--public-address", options.public_address,
                      "Of a folder: HOST:PORT by which others reach it, where that is a proxy's");
  command->add_option("--passphrases", options.passphrases,
                      "Of a folder: a folder with a file NAME for each home NAME that a passphrase "
                      "protects");
  command->add_option("--accounts", options.accounts,
                      "Of a folder: postgresql://USER@HOST/DATABASE with the accounts of staff and "
                      "who did what; default: a file in the folder");
  add_network_options(*command, options.networks);
}

}  // namespace roomwise::app
