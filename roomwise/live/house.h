#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/live/home/live_home.h"
#include "roomwise/service/access/pairing_door.h"
#include "roomwise/service/access/rate_limit.h"
#include "roomwise/service/server/access_routes.h"
#include "roomwise/service/server/metrics_text.h"
#include "roomwise/service/server/served_home.h"

namespace roomwise::live {

// Something that somebody did to a home, for who keeps the house.
struct HouseAct {
  std::string home;
  service::Identity who;
  std::string peer;  // address that it came from
  std::string what;  // "DELETE /api/things/{id}": never what was asked for
  int status = 0;    // of the answer
};

struct HouseOptions {
  std::size_t max_open = 8;  // homes in memory at once
  double idle_s = 600;       // so long a home stays open that nobody uses, if there is room
  // Of the certificate, which pairing is bound to.
  std::string fingerprint;
  // What looks at the pictures of that home.
  std::function<Expected<std::shared_ptr<const pipeline::Networks>>(const std::filesystem::path&)>
      networks;
  // The passphrase of that home.
  std::function<Expected<home::OpenOptions>(const std::string& name)> open_options =
      [](const std::string&) { return Expected<home::OpenOptions>(home::OpenOptions{}); };
  LiveHomeOptions home;  // of each; its log is told which home a line is of
  std::function<service::Now()> clock = service::Now::read;
  // Around the routes of that home.
  std::function<service::AccessRoutesContext(const std::string& name)> access =
      [](const std::string&) { return service::AccessRoutesContext{}; };
  // Who somebody without a token of the home is there, where the house knows them.
  std::function<Expected<std::optional<service::Identity>>(const service::HttpRequest&,
                                                           const std::string& name)>
      known_to_house = [](const service::HttpRequest&, const std::string&) { return std::nullopt; };
  // What one of those may do there now, by the number of the account.
  std::function<Expected<std::optional<service::Role>>(std::int64_t account,
                                                       const std::string& name)>
      role_of_account = [](std::int64_t, const std::string&) { return std::nullopt; };
  std::function<void(const HouseAct&)> audit = [](const HouseAct&) {};
  // What answers outside the homes; their handlers see to it who may.
  std::vector<service::Route> front;
};

// A folder of homes behind one port: NAME.home is served under /homes/NAME/ as a home of its own
// is under /. Each has its own devices, tokens, codes, uploads, jobs, lines in the log and figures.
// A home is opened when somebody who may asks for it and closed when it is used least and nobody
// has a socket or a request there, no job runs, no walk is recorded and no code waits; what was
// removed there can still be brought back when it is open again, whatever LiveHomeOptions of all
// say. One process
// has a home at a time: another one answers 503, and takes it over within seconds of that one's
// end, or when that one does not use it. Who is nobody there does not learn which homes there are,
// also not by asking to be paired: a wrong code, a home without codes and one that is not there are
// answered alike, after the same work (see PairingDoorOptions::guesses). Thread-safe.
class House final : public service::HomesAtPort {
 public:
  // Fails where the folder is none. `finders` must outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<House>> open(std::filesystem::path folder,
                                                             const objects::ObjectFinders& finders,
                                                             HouseOptions options);
  // Closes the homes, and erases what was removed in those that are open.
  ~House() override;
  House(const House&) = delete;
  House& operator=(const House&) = delete;

  [[nodiscard]] std::variant<service::ResolvedRequest, service::HttpAnswer> resolve(
      const service::HttpRequest& request, const service::Now& now) override;

  // The homes of the folder, by name. Files whose names cannot stand in an address are none.
  [[nodiscard]] std::vector<std::string> names() const;
  // Whether there is a home of that name; whether it has one that can stand in an address.
  [[nodiscard]] bool has(const std::string& name) const;
  [[nodiscard]] static bool is_home_name(std::string_view name);
  [[nodiscard]] std::filesystem::path file_of(const std::string& name) const;

  // A code by which somebody is paired with that home.
  [[nodiscard]] Expected<service::OpenCode> make_code(const std::string& name, service::Role role);

  // Closes what nobody has used for long, and what another process waits for; to be called about
  // once a second.
  void tidy();
  // Tells in the log when the disk gets full; to be called now and then.
  void watch_disk();
  // Of all homes, each sample with its home.
  void write_metrics(service::MetricsText& text);
  [[nodiscard]] std::vector<std::string> open_homes() const;  // in memory, by name

 private:
  class Resident;
  class Moving;
  using Residents = std::vector<std::shared_ptr<Resident>>;

  House(std::filesystem::path folder, const objects::ObjectFinders& finders, HouseOptions options);

  // The home with its register, which this process has from then on. ErrorCode::kRefused where
  // another one has it.
  [[nodiscard]] Expected<std::shared_ptr<Resident>> find(const std::string& name);
  [[nodiscard]] std::shared_ptr<service::PairingDoor> new_door();
  // Where codes of that home, which is there, are open.
  [[nodiscard]] std::shared_ptr<service::PairingDoor> door_of(const std::string& name);
  // Where codes of that name are asked for, whether there is such a home or not. Names of which no
  // code was ever made share one door; nothing that a guest sees tells them from others.
  [[nodiscard]] std::shared_ptr<service::PairingDoor> door_for_guests(
      const std::string& name) const;
  // A place for a proof of digits by that peer; how long until there may be one, s.
  [[nodiscard]] tl::expected<service::ProofPlaces::Place, double> proof_place(
      const std::string& peer, const service::Now& now);
  [[nodiscard]] tl::expected<service::Pairing, service::Refusal> redeem(
      const std::string& name, const service::PairingAttempt& attempt);
  // Whether another process seems to have it. Touches nothing, and takes as long for any name.
  [[nodiscard]] bool looks_elsewhere(const std::string& name) const;
  // A place in memory for one more home, of one that is closed for it where there is none.
  [[nodiscard]] Expected<void> take_place();
  void free_place();
  // Those of whom nobody holds one leave the house; whoever asks for them waits. With mutex_ held.
  [[nodiscard]] Residents take_out(const std::function<bool(Resident&)>& chosen);
  void close(Residents leaving);
  void say(const std::string& name, std::string_view line) const;

  const std::filesystem::path folder_;
  const objects::ObjectFinders& finders_;
  const HouseOptions options_;
  std::shared_ptr<service::ServedHome> front_;    // outside the homes
  std::shared_ptr<service::ServedHome> door_;     // of a home: what everybody gets of any
  std::shared_ptr<service::ServedHome> pairing_;  // of a home: who asks to be paired

  const std::shared_ptr<service::PeerGuesses> guesses_ = std::make_shared<service::PeerGuesses>();
  mutable std::mutex doors_mutex_;                                      // after mutex_
  std::map<std::string, std::shared_ptr<service::PairingDoor>> doors_;  // of homes that were in use
  std::shared_ptr<service::PairingDoor> nobodys_door_;
  service::ProofPlaces proof_places_;
  service::RateLimit proofs_of_peer_;
  service::RateLimit proofs_of_all_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, std::shared_ptr<Resident>> residents_;
  std::set<std::string> moving_;  // are being taken in or closed
  std::size_t places_ = 0;        // taken: homes in memory, or just being opened or closed
  std::uint64_t opened_ = 0;
  std::uint64_t closed_ = 0;
  std::uint64_t refused_ = 0;  // since another process has the home
};

}  // namespace roomwise::live
