#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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
#include "qr_code.h"
#include "roomwise/live/home_routes.h"
#include "roomwise/service/access_routes.h"
#include "roomwise/service/server_events.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path home;
  std::string address = "127.0.0.1";
  std::uint16_t port = 8443;
  std::vector<std::string> names;
  std::vector<std::string> allowed_hosts;
  fs::path pages;
  std::string pair;
  std::string speak;
  std::string language = "en";
  NetworkOptions networks;
};

// The pages that come with Roomwise: ../share/roomwise/web of the program's.
fs::path brought_pages() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path pages = program.parent_path().parent_path() / "share/roomwise/web";
  return fs::exists(pages / "index.html", error) ? pages : fs::path();
}

std::int64_t seconds_since_1970() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// Lines for the operator, each with its time, from any thread.
class OperatorLog {
 public:
  void write(std::string_view line) {
    const std::scoped_lock lock(mutex_);
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%F %T", &parts);
    std::cerr << text.data() << "  " << line << '\n';
  }

 private:
  std::mutex mutex_;
};

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
    all.more_names_ = options.names;
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
    all.host_ =
        options.address == "0.0.0.0" || options.address == "::" ? own_name(names) : options.address;
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

  [[nodiscard]] std::string address() const {
    const bool is_v6 = host_.find(':') != std::string::npos;
    return fmt::format("https://{}{}{}:{}", is_v6 ? "[" : "", host_, is_v6 ? "]" : "",
                       server_->port());
  }
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

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names = service::host_names();
    names.insert(names.end(), more_names_.begin(), more_names_.end());
    return names;
  }

  // What is wrong again a minute later is said once.
  void tell_once(const std::string& line) {
    if (std::exchange(told_, line) != line) log_.write(line);
  }

  // The name by which others in the network find this computer, if it has one.
  static std::string own_name(const std::vector<std::string>& names) {
    const auto local = std::ranges::find_if(
        names, [](const std::string& name) { return name.ends_with(".local"); });
    return local != names.end() ? *local : names.front();
  }

  std::vector<service::Route> routes() {
    std::vector<service::Route> routes = live::home_routes(*home_);
    service::AccessRoutesContext context;
    context.online = [this] { return server_->online(); };
    context.disconnect = [this](std::int64_t device) {
      server_->disconnect(device, "this device was removed");
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

  OperatorLog log_;
  pipeline::Networks networks_;
  objects::ObjectFinders finders_;
  std::unique_ptr<live::LiveHome> home_;
  std::unique_ptr<service::AccessRegister> access_;
  fs::path access_folder_;
  std::vector<std::string> more_names_;
  mutable std::mutex certificate_mutex_;
  service::Certificate certificate_;
  std::string told_;
  std::string host_;
  std::unique_ptr<service::Server> server_;
};

// Says the codes by which devices are paired, to who cannot read them.
class SpokenCodes {
 public:
  static Expected<SpokenCodes> open(const Options& options) {
    SpokenCodes spoken(options.language);
    ROOMWISE_CHECK_OK(spoken.wording_.style.validate(*spoken.catalogue_));
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
      voice_->say(std::move(prompt), now_ns);
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
  const std::string& code = made.digits;
  const std::string address = server.address() + "/pair#" + made.secret;
  ROOMWISE_TRY(const auto rows, qr_rows(address));
  if (::isatty(STDOUT_FILENO) != 0) std::cout << qr_lines(rows);
  std::cout << fmt::format("To pair a {}: code {} {}, within five minutes, at {}\n",
                           to_string(role), code.substr(0, 3), code.substr(3), address);
  if (const double wait_s = server.access().digits_wait_s(now); wait_s > 0) {
    std::cout << fmt::format(
        "Somebody guesses at codes: the digits are heard in {:.0f} s only, the address at once\n",
        std::ceil(wait_s));
  }
  std::cout.flush();
  if (spoken != nullptr) spoken->say(code);
  return {};
}

// Whether Enter was pressed. Where there is nobody to type, it never was.
class EnterKey {
 public:
  // A program in the background that reads from its terminal would be stopped.
  EnterKey() { ::signal(SIGTTIN, SIG_IGN); }
  // Since the last call.
  [[nodiscard]] bool take() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (at_end_ || ::poll(&input, 1, 0) != 1) return false;
    std::array<char, 256> typed{};
    const auto size = ::read(STDIN_FILENO, typed.data(), typed.size());
    if (size <= 0) at_end_ = true;
    return size > 0 && std::find(typed.begin(), typed.begin() + size, '\n') != typed.end();
  }

 private:
  bool at_end_ = false;
};

Expected<Answer> serve(const Options& options, Context& context) {
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
  if (certificate.authority) {
    std::cout << fmt::format(
        "A phone that installs {}/authority.crt is warned no more; that one's fingerprint: {}\n",
        server->address(), service::fingerprint_with_colons(certificate.authority->fingerprint));
  }
  if (options.pair == "helper" || !server->has_helper()) {
    ROOMWISE_CHECK_OK(show_code(*server, service::Role::kHelper, nullptr));
  }
  if (options.pair == "device") {
    ROOMWISE_CHECK_OK(show_code(*server, service::Role::kDevice, codes));
  }
  std::cout << "Enter makes a new code for a device. Ctrl-C stops it.\n" << std::flush;
  EnterKey enter;
  int turns = 0;
  while (!context.progress.interrupted()) {
    if (enter.take()) ROOMWISE_CHECK_OK(show_code(*server, service::Role::kDevice, codes));
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
  command->add_option("HOME", options.home, "Home file; a new one is made where there is none")
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
  add_network_options(*command, options.networks);
}

}  // namespace roomwise::app
