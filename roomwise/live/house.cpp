#include "roomwise/live/house.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>

#include "roomwise/live/routes/home_routes.h"
#include "roomwise/service/server/request_checks.h"

namespace roomwise::live {

namespace fs = std::filesystem;
using service::error_answer;
using service::HttpAnswer;
using service::HttpRequest;
using service::Placeholders;

namespace {

constexpr std::string_view kHomes = "/homes/";
constexpr std::string_view kPair = "/api/pair";

// Proofs of digits, of which one takes half a second of a processor: so many at once, and so
// many a second. One peer alone cannot use up what all have.
constexpr double kProofsOfPeer = 4, kProofsOfPeer_s = 0.125;
constexpr double kProofsOfAll = 16, kProofsOfAll_s = 0.5;
// And so many of the threads that answer all requests may be busy with them.
constexpr int kProofPlaces = 2;

HttpAnswer later(std::string_view what, int seconds) {
  HttpAnswer answer = error_answer(503, what, "later");
  answer.headers.emplace_back("Retry-After", fmt::format("{}", seconds));
  return answer;
}

// Everybody gets it of any home, and of one that is not there.
class Open final : public service::ServedHome {
 public:
  explicit Open(std::vector<service::Route> routes) : router_(std::move(routes)) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const service::Router& router() const override { return router_; }
  [[nodiscard]] Expected<service::SocketHandler*> sockets() override {
    return fail("there is no WebSocket here");
  }

 private:
  const std::string name_;
  const service::Router router_;
};

service::Route health_route() {
  return {"GET", "/health", {}, [](const HttpRequest&, const Placeholders&) {
            return service::json_answer({{"status", "ok"}});
          }};
}

// "/homes/flat-7/api/me": the home's name, and what its own addresses are after.
struct HomePath {
  std::string name;
  std::string base;
  std::string_view rest;  // empty where the slash after the name is missing
};

std::optional<HomePath> home_path(std::string_view path) {
  if (!path.starts_with(kHomes)) return std::nullopt;
  const std::string_view from_name = path.substr(kHomes.size());
  const std::size_t end = std::min(from_name.find('/'), from_name.size());
  return HomePath{std::string(from_name.substr(0, end)),
                  std::string(path.substr(0, kHomes.size() + end)), from_name.substr(end)};
}

// The rest, pages above all, is the same for all homes and tells nothing of any.
bool is_of_home(std::string_view rest) {
  return rest.starts_with("/api/") || rest == "/metrics";
}

// To whom nobody is, a home that is not there and one that is answer alike.
HttpAnswer answer_to_nobody() {
  HttpAnswer answer =
      error_answer(401, "this needs a paired device: pair it with a code first", "not_paired");
  answer.headers.emplace_back("WWW-Authenticate", "Bearer");
  return answer;
}

bool is_for_everyone(const service::Router& router, std::string_view method,
                     std::string_view path) {
  return std::ranges::any_of(router.routes(), [&](const service::Route& route) {
    return !route.role && route.method == method && route.pattern == path;
  });
}

// By which a process that would like to have the home says so to the one that has it.
fs::path wanted_file(const fs::path& home) {
  return service::access_folder(home) / "wanted";
}

}  // namespace

// A home that this process has: its register at once, the home itself once somebody who may has
// asked for it.
class House::Resident final : public service::ServedHome {
 public:
  Resident(House& house, std::string name, std::shared_ptr<service::PairingDoor> door,
           std::unique_ptr<service::AccessRegister> access)
      : house_(house),
        name_(std::move(name)),
        access_door_(std::move(door)),
        access_(std::move(access)),
        router_(routes()) {}

  ~Resident() override {
    const bool had_place = live_ != nullptr;
    live_.reset();
    if (had_place) house_.free_place();
  }
  Resident(const Resident&) = delete;
  Resident& operator=(const Resident&) = delete;

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const service::Router& router() const override { return router_; }
  [[nodiscard]] Expected<std::optional<service::Identity>> identify(
      const HttpRequest& request, const service::Now& now) override {
    if (const auto token = service::token_of(request)) {
      if (auto device = access_->identify(*token, now)) return device;
    }
    auto known = house_.options_.known_to_house(request, name_);
    if (known) return known;
    house_.say(name_, known.error().message);
    return fail("the accounts cannot be asked now; try again soon");
  }
  [[nodiscard]] Expected<service::SocketHandler*> sockets() override {
    ROOMWISE_TRY(LiveHome* const live, open());
    return live;
  }
  void note_done(const HttpRequest& request, const service::Route& route, int status) override {
    if (!route.is_audited) return;
    house_.options_.audit(
        {name_, *request.who, request.peer, request.method + " " + route.pattern, status});
  }

  [[nodiscard]] service::AccessRegister& access() { return *access_; }
  // Once it is open; else nullptr.
  [[nodiscard]] LiveHome* live() const {
    const std::scoped_lock lock(mutex_);
    return live_.get();
  }
  [[nodiscard]] bool is_open() const { return live() != nullptr; }
  // When it was last asked for.
  [[nodiscard]] bool cannot_open() const { return cannot_open_; }

  // With House::mutex_ held, which orders them.
  void use() { used_s_ = house_.options_.clock().steady_s; }
  [[nodiscard]] double used_s() const { return used_s_; }
  // While nobody holds it.
  [[nodiscard]] bool is_idle() {
    const LiveHome* const home = live();
    return (home == nullptr || !home->is_at_work()) &&
           !access_door_->has_codes(house_.options_.clock());
  }

  // The home, opened where it is not yet.
  Expected<LiveHome*> open() {
    const std::scoped_lock one_by_one(opening_mutex_);
    if (LiveHome* const home = live()) return home;
    ROOMWISE_RETURN_IF_ERROR(house_.take_place());
    auto opened = try_to_open();
    if (!opened) {
      house_.free_place();
      cannot_open_ = true;
      // The words may name files of the computer.
      if (std::exchange(told_, opened.error().message) != opened.error().message) {
        house_.say(name_, "cannot be opened: " + opened.error().message);
      }
      return fail("this home cannot be opened now; the log of the computer says why");
    }
    cannot_open_ = false;
    const std::scoped_lock lock(mutex_);
    live_ = *std::move(opened);
    return live_.get();
  }

 private:
  // A fault in one home must not take its place from the others.
  Expected<std::unique_ptr<LiveHome>> try_to_open() {
    try {
      return open_now();
    } catch (const std::exception& fault) {
      return fail("internal error, please report it: {}", fault.what());
    }
  }

  Expected<std::unique_ptr<LiveHome>> open_now() {
    const HouseOptions& all = house_.options_;
    const fs::path file = house_.file_of(name_);
    ROOMWISE_TRY(networks_, all.networks(file));
    LiveHomeOptions options = all.home;
    ROOMWISE_TRY(options.open, all.open_options(name_));
    options.erases_removed = false;  // it is opened and closed while people go on
    options.log = [this](std::string_view line) { house_.say(name_, line); };
    ROOMWISE_TRY(auto home, LiveHome::open(file, *networks_, house_.finders_, std::move(options)));
    {
      const std::scoped_lock lock(house_.mutex_);
      ++house_.opened_;
    }
    house_.say(name_, "opened");
    return home;
  }

  std::vector<service::Route> routes() {
    service::AccessRoutesContext context = house_.options_.access(name_);
    context.renamed = [this](std::int64_t device, const std::string& name) {
      if (LiveHome* const home = live()) home->device_renamed(device, name);
    };
    std::vector<service::Route> routes = service::access_routes(*access_, std::move(context));
    for (HomeRoute& one : home_routes()) {
      routes.push_back({std::move(one.method), std::move(one.pattern), one.role,
                        [this, handler = std::move(one.handler)](const HttpRequest& request,
                                                                 const Placeholders& values) {
                          const auto home = open();
                          if (!home) return later(home.error().message, 2);
                          return handler(**home, request, values);
                        },
                        one.max_body_bytes, one.is_audited});
    }
    routes.push_back(service::socket_route());
    routes.push_back({"GET", "/metrics", service::Role::kHelper,
                      [this](const HttpRequest&, const Placeholders&) { return own_metrics(); }});
    return routes;
  }

  HttpAnswer own_metrics() {
    const auto home = open();
    if (!home) return later(home.error().message, 2);
    service::MetricsText text;
    (*home)->write_metrics(text);
    HttpAnswer answer = service::text_answer(text.text());
    answer.content_type = "text/plain; version=0.0.4";
    return answer;
  }

  House& house_;
  const std::string name_;
  const std::shared_ptr<service::PairingDoor> access_door_;
  const std::unique_ptr<service::AccessRegister> access_;
  const service::Router router_;
  double used_s_ = 0;
  std::mutex opening_mutex_;
  std::string told_;
  std::atomic<bool> cannot_open_ = false;
  std::shared_ptr<const pipeline::Networks> networks_;  // before the home that looks by them
  mutable std::mutex mutex_;                            // of live_
  std::unique_ptr<LiveHome> live_;
};

// ---- the folder ----

House::House(fs::path folder, const objects::ObjectFinders& finders, HouseOptions options)
    : folder_(std::move(folder)),
      finders_(finders),
      options_(std::move(options)),
      proof_places_(kProofPlaces),
      proofs_of_peer_(kProofsOfPeer, kProofsOfPeer_s),
      proofs_of_all_(kProofsOfAll, kProofsOfAll_s) {
  std::vector<service::Route> front = options_.front;
  front.push_back(health_route());
  std::vector<service::Route> door{health_route()};
  // The authority is the house's.
  const service::AccessRoutesContext around = options_.access("");
  for (service::Route& route : service::authority_routes(around.authority)) {
    front.push_back(route);
    door.push_back(std::move(route));
  }
  front_ = std::make_shared<Open>(std::move(front));
  door_ = std::make_shared<Open>(std::move(door));
  std::vector<service::Route> pairing{service::pairing_route(
      [this](const HttpRequest& request, const service::PairingAttempt& attempt) {
        const std::string home = request.base.substr(kHomes.size());
        auto paired = redeem(home, attempt);
        if (paired) {
          options_.audit({home, paired->who, request.peer, "POST " + std::string(kPair), 200});
        }
        return paired;
      })};
  pairing_ = std::make_shared<Open>(std::move(pairing));
  nobodys_door_ = new_door();
}

House::~House() {
  for (const auto& [name, one] : residents_) {
    if (LiveHome* const home = one->live()) home->erase_when_closed();
  }
  residents_.clear();
}

Expected<std::unique_ptr<House>> House::open(fs::path folder, const objects::ObjectFinders& finders,
                                             HouseOptions options) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return fail("{}: is no folder of homes", folder.string());
  }
  if (options.max_open == 0) return fail("at least one home must be allowed to be open");
  return std::unique_ptr<House>(new House(std::move(folder), finders, std::move(options)));
}

bool House::is_home_name(std::string_view name) {
  constexpr std::size_t kMaxName = 64;
  return !name.empty() && name.size() <= kMaxName && name.front() != '.' && name.front() != '-' &&
         std::ranges::all_of(name, [](unsigned char c) {
           return c < 0x80 && (std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.');
         });
}

fs::path House::file_of(const std::string& name) const {
  return folder_ / (name + ".home");
}

bool House::has(const std::string& name) const {
  // Two names of one file would have two locks: links are none.
  std::error_code error;
  return is_home_name(name) &&
         fs::symlink_status(file_of(name), error).type() == fs::file_type::regular;
}

std::vector<std::string> House::names() const {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() == ".home" && has(name)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

void House::say(const std::string& name, std::string_view line) const {
  options_.home.log(fmt::format("{}: {}", name, line));
}

// ---- who comes ----

std::variant<service::ResolvedRequest, HttpAnswer> House::resolve(const HttpRequest& request,
                                                                  const service::Now& now) {
  const auto path = home_path(request.path);
  if (!path) return service::ResolvedRequest{front_};
  if (path->rest.empty()) {
    HttpAnswer moved;
    moved.status = 308;  // what the pages load is relative to the home's address
    moved.headers = {{"Location", path->base + "/"}};
    return moved;
  }
  const bool is_of_house =
      !is_of_home(path->rest) || is_for_everyone(door_->router(), request.method, path->rest);
  if (is_of_house) return service::ResolvedRequest{door_, path->base};
  if (request.method == "POST" && path->rest == kPair && is_home_name(path->name)) {
    if (looks_elsewhere(path->name) && has(path->name)) {
      const auto mine = find(path->name);
      if (!mine && mine.error().code == ErrorCode::kRefused) {
        return later("another process has this home; try again soon", 1);
      }
    }
    return service::ResolvedRequest{pairing_, path->base};
  }
  // Whether there is such a home is nobody's affair: one that is not there has no devices.
  if (!has(path->name)) return answer_to_nobody();
  auto resident = find(path->name);
  if (!resident && resident.error().code == ErrorCode::kRefused) {
    return later("another process has this home; try again soon", 1);
  }
  if (!resident) {
    say(path->name, resident.error().message);
    return later("this home cannot be opened now; the log of the computer says why", 5);
  }
  auto who = (*resident)->identify(request, now);
  if (!who) return later(who.error().message, 5);
  service::ResolvedRequest resolved{*resident, path->base, *std::move(who)};
  if (resolved.who || is_for_everyone((*resident)->router(), request.method, path->rest)) {
    return resolved;
  }
  return answer_to_nobody();
}

// The name of a home that is being taken in: whoever asks for it waits until this goes, by a fault
// as well.
class House::Moving {
 public:
  // With House::mutex_ held.
  Moving(House& house, const std::string& name) : house_(house), name_(name) {
    house_.moving_.insert(name_);
  }
  ~Moving() {
    const std::scoped_lock lock(house_.mutex_);
    house_.moving_.erase(name_);
    house_.changed_.notify_all();
  }
  Moving(const Moving&) = delete;
  Moving& operator=(const Moving&) = delete;

 private:
  House& house_;
  const std::string& name_;
};

Expected<std::shared_ptr<House::Resident>> House::find(const std::string& name) {
  std::unique_lock waiting(mutex_);
  changed_.wait(waiting, [&] { return !moving_.contains(name); });
  if (const auto found = residents_.find(name); found != residents_.end()) {
    found->second->use();
    return found->second;
  }
  const Moving moving(*this, name);
  waiting.unlock();
  const auto door = door_of(name);
  auto access = service::AccessRegister::open(service::access_folder(file_of(name)), door);
  std::shared_ptr<Resident> resident;
  std::error_code ignored;
  if (access) {
    fs::remove(wanted_file(file_of(name)), ignored);
    resident = std::make_shared<Resident>(*this, name, door, *std::move(access));
  } else if (access.error().code == ErrorCode::kRefused) {
    const std::ofstream wanted(wanted_file(file_of(name)));  // it counts that it is there
  }
  const std::scoped_lock lock(mutex_);
  if (!resident) {
    ++refused_;
    return Unexpected(std::move(access).error());
  }
  resident->use();
  residents_.emplace(name, resident);
  return resident;
}

Expected<service::OpenCode> House::make_code(const std::string& name, service::Role role) {
  if (!has(name)) return fail("{}: there is no such home", file_of(name).string());
  ROOMWISE_TRY(const auto resident, find(name));
  return resident->access().make_code(role, options_.clock());
}

// ---- who asks to be paired ----

std::shared_ptr<service::PairingDoor> House::new_door() {
  service::PairingDoorOptions options;
  options.fingerprint = options_.fingerprint;
  options.guesses = guesses_;
  options.proof_place = [this](const std::string& peer, const service::Now& at) {
    return proof_place(peer, at);
  };
  return std::make_shared<service::PairingDoor>(std::move(options));
}

std::shared_ptr<service::PairingDoor> House::door_of(const std::string& name) {
  const std::scoped_lock lock(doors_mutex_);
  std::shared_ptr<service::PairingDoor>& door = doors_[name];
  if (!door) door = new_door();
  return door;
}

std::shared_ptr<service::PairingDoor> House::door_for_guests(const std::string& name) const {
  const std::scoped_lock lock(doors_mutex_);
  const auto found = doors_.find(name);
  return found == doors_.end() ? nobodys_door_ : found->second;
}

tl::expected<service::ProofPlaces::Place, double> House::proof_place(const std::string& peer,
                                                                     const service::Now& now) {
  service::ProofPlaces::Place place = proof_places_.take();
  if (!place) return tl::unexpected(1.0);
  const std::scoped_lock lock(doors_mutex_);
  if (!proofs_of_peer_.take(peer, now.steady_s)) return tl::unexpected(1 / kProofsOfPeer_s);
  if (proofs_of_all_.take("", now.steady_s)) return place;
  proofs_of_peer_.give_back(peer);
  return tl::unexpected(1 / kProofsOfAll_s);
}

bool House::looks_elsewhere(const std::string& name) const {
  {
    const std::scoped_lock lock(mutex_);
    if (residents_.contains(name) || moving_.contains(name)) return false;
  }
  return service::AccessRegister::looks_open(service::access_folder(file_of(name)));
}

tl::expected<service::Pairing, service::Refusal> House::redeem(
    const std::string& name, const service::PairingAttempt& attempt) {
  const service::Now now = options_.clock();
  // Only who knows a code gets as far as to the home.
  const auto add = [&](service::Role role, const std::string& device,
                       std::int64_t maker) -> Expected<std::optional<service::Pairing>> {
    if (maker < 0) {
      ROOMWISE_TRY(const auto may, options_.role_of_account(-maker, name));
      if (may != service::Role::kHelper) return std::nullopt;
    }
    ROOMWISE_TRY(const auto resident, find(name));
    return resident->access().pair_by_code(role, device, maker, now);
  };
  service::PairingAttempt at_home = attempt;
  at_home.home = name;
  return door_for_guests(name)->redeem(at_home, now, add);
}

// ---- room ----

House::Residents House::take_out(const std::function<bool(Resident&)>& chosen) {
  Residents out;
  for (auto one = residents_.begin(); one != residents_.end();) {
    // Whoever takes one more does so with mutex_ held, so nobody can meanwhile.
    const bool is_held = one->second.use_count() > 1;
    if (is_held || !one->second->is_idle() || !chosen(*one->second)) {
      ++one;
      continue;
    }
    moving_.insert(one->first);
    out.push_back(std::move(one->second));
    one = residents_.erase(one);
  }
  return out;
}

void House::close(Residents leaving) {
  for (std::shared_ptr<Resident>& one : leaving) {
    const std::string name = one->name();
    const bool was_open = one->is_open();
    one.reset();
    if (was_open) say(name, "closed");
    const std::scoped_lock lock(mutex_);
    if (was_open) ++closed_;
    moving_.erase(name);
    changed_.notify_all();
  }
}

Expected<void> House::take_place() {
  for (;;) {
    Residents leaving;
    {
      const std::scoped_lock lock(mutex_);
      if (places_ < options_.max_open) {
        ++places_;
        return {};
      }
      const Resident* longest = nullptr;
      for (const auto& [name, one] : residents_) {
        if (one.use_count() > 1 || !one->is_open() || !one->is_idle()) continue;
        if (longest == nullptr || one->used_s() < longest->used_s()) longest = one.get();
      }
      if (longest == nullptr) {
        return fail(
            "{} homes are in use, and the computer was told to hold no more at once; try again "
            "soon",
            options_.max_open);
      }
      leaving = take_out([&](const Resident& one) { return &one == longest; });
    }
    close(std::move(leaving));
  }
}

void House::free_place() {
  const std::scoped_lock lock(mutex_);
  --places_;
}

void House::tidy() {
  constexpr double kUnopened_s = 10;  // a home of which nobody wanted more than to be let in
  const double now_s = options_.clock().steady_s;
  Residents leaving;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [name, one] : residents_) {
      if (one.use_count() > 1) one->use();
    }
    leaving = take_out([&](Resident& one) {
      const double max_s = one.is_open() ? options_.idle_s : std::min(kUnopened_s, options_.idle_s);
      std::error_code ignored;
      return now_s - one.used_s() > max_s || fs::exists(wanted_file(file_of(one.name())), ignored);
    });
  }
  close(std::move(leaving));
}

void House::watch_disk() {
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, one] : residents_) {
    if (LiveHome* const home = one->live()) home->watch_disk();
  }
}

std::vector<std::string> House::open_homes() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, one] : residents_) {
    if (one->is_open()) names.push_back(name);
  }
  return names;
}

void House::write_metrics(service::MetricsText& text) {
  const std::scoped_lock lock(mutex_);
  text.single("homes_open", "gauge", "Homes that are in memory.", std::uint64_t{places_});
  text.single("homes_opened_total", "counter", "Homes that were opened.", opened_);
  text.single("homes_closed_total", "counter", "Homes that were closed while others went on.",
              closed_);
  text.single("homes_elsewhere_total", "counter", "Requests for homes that another process has.",
              refused_);
  text.family("home_cannot_open", "gauge",
              "1: the home could not be opened when it was last asked for.");
  for (const auto& [name, one] : residents_) {
    text.sample({{"home", name}}, std::uint64_t{one->cannot_open()});
  }
  for (const auto& [name, one] : residents_) {
    LiveHome* const home = one->live();
    if (home == nullptr) continue;
    text.label_all("home", name);
    home->write_metrics(text);
  }
  text.label_all("", "");
}

}  // namespace roomwise::live
