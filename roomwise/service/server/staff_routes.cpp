#include "roomwise/service/server/staff_routes.h"

#include <nlohmann/json.hpp>

namespace roomwise::service {
namespace {

using StaffJson = nlohmann::json;

constexpr auto kStaffCookie = "roomwise-staff";

std::optional<std::string> staff_token(const HttpRequest& request) {
  return cookie_of(request.header("cookie"), kStaffCookie);
}

void set_staff_cookie(HttpAnswer& answer, const std::string& token, std::int64_t seconds) {
  answer.headers.emplace_back(
      "Set-Cookie", fmt::format("{}={}; Path=/; Max-Age={}; Secure; HttpOnly; SameSite=Strict",
                                kStaffCookie, token, seconds));
}

class StaffDesk {
 public:
  StaffDesk(AccountStore& accounts, StaffRoutesContext context)
      : accounts_(accounts), context_(std::move(context)) {}

  HttpAnswer sign_in(const HttpRequest& request) const {
    const auto json = json_of(request);
    if (!json) return error_answer(400, json.error().message);
    const Now now = context_.clock();
    const auto session = accounts_.sign_in(text_member(*json, "name"),
                                           text_member(*json, "password"), request.peer, now);
    if (!session) {
      const Refusal& refusal = session.error();
      if (refusal.status == 503) return unavailable(refusal.message);
      // What was typed in place of a name may be a password: it is not kept. Whoever was told to
      // wait tried nothing, and must not fill the log.
      if (refusal.status == 401) {
        note({now.unix_s, "somebody", "", "signed in", "refused", request.peer});
      }
      return refusal_answer(refusal);
    }
    note({now.unix_s, session->account.name, "", "signed in", "done", request.peer});
    HttpAnswer answer = json_answer(account_json(session->account));
    set_staff_cookie(answer, session->token, kStaffSession_s);
    return answer;
  }

  HttpAnswer sign_out(const HttpRequest& request) const {
    if (const auto token = staff_token(request)) {
      const Now now = context_.clock();
      const auto account = accounts_.who(*token, now);
      if (!account) return unavailable(account.error().message);
      if (const auto done = accounts_.sign_out(*token); !done) {
        return unavailable(done.error().message);
      }
      if (*account) {
        note({now.unix_s, (*account)->name, "", "signed out", "done", request.peer});
        context_.on_signed_out((*account)->id);
      }
    }
    HttpAnswer answer = json_answer(StaffJson::object());
    set_staff_cookie(answer, "", 0);
    return answer;
  }

  HttpAnswer me(const HttpRequest& request) const {
    const auto token = staff_token(request);
    if (!token) return error_answer(401, "sign in first");
    const auto account = accounts_.who(*token, context_.clock());
    if (!account) return unavailable(account.error().message);
    if (!*account) return error_answer(401, "sign in first");
    return json_answer(account_json(**account));
  }

 private:
  // The homes that are there and that they may open.
  [[nodiscard]] StaffJson account_json(const Account& account) const {
    StaffJson homes = StaffJson::array();
    for (const std::string& home : context_.homes()) {
      const auto role = account.homes.find(home);
      if (role == account.homes.end()) continue;
      homes.push_back({{"name", home}, {"role", to_string(role->second)}});
    }
    return {{"name", account.name}, {"homes", std::move(homes)}};
  }

  // A log that cannot be written keeps nobody out: the lines go to the computer's own.
  void note(const AuditLine& line) const {
    if (const auto noted = accounts_.note(line); !noted) {
      context_.log(fmt::format("{}: {} {} (not kept among who did what: {})", line.who, line.what,
                               line.outcome, noted.error().message));
    }
  }

  [[nodiscard]] HttpAnswer unavailable(const std::string& why) const {
    context_.log("accounts: " + why);
    HttpAnswer answer = error_answer(503, "the accounts cannot be asked now; try again soon");
    answer.headers.emplace_back("Retry-After", "5");
    return answer;
  }

  AccountStore& accounts_;
  const StaffRoutesContext context_;
};

}  // namespace

std::vector<Route> staff_routes(AccountStore& accounts, StaffRoutesContext context) {
  const auto desk = std::make_shared<const StaffDesk>(accounts, std::move(context));
  constexpr std::size_t kSmallBody = 4096;
  return {
      {"POST", "/api/staff/sign-in", std::nullopt,
       [desk](const HttpRequest& request, const Placeholders&) { return desk->sign_in(request); },
       kSmallBody},
      {"POST", "/api/staff/sign-out", std::nullopt,
       [desk](const HttpRequest& request, const Placeholders&) { return desk->sign_out(request); },
       kSmallBody},
      {"GET", "/api/staff/me", std::nullopt,
       [desk](const HttpRequest& request, const Placeholders&) { return desk->me(request); }, 0}};
}

Expected<std::optional<Identity>> staff_in_home(AccountStore& accounts, const HttpRequest& request,
                                                const std::string& home, const Now& now) {
  const auto token = staff_token(request);
  if (!token) return std::nullopt;
  ROOMWISE_TRY(const auto account, accounts.who(*token, now));
  if (!account) return std::nullopt;
  const auto role = account->homes.find(home);
  if (role == account->homes.end()) return std::nullopt;
  return Identity{Identity::device_of_account(account->id), account->name, role->second};
}

}  // namespace roomwise::service
