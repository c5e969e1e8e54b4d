#include "roomwise/service/server/access_routes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "roomwise/service/access/rate_limit.h"

namespace roomwise::service {
namespace {

using Json = nlohmann::json;

// Pages have the token in a cookie that scripts cannot read. Browsers keep cookies for 400 days at
// most; each pairing has to be renewed after that.
// A home's cookie is sent to that home alone.
constexpr auto kCookie = "roomwise={}; Path={}/; Max-Age={}; Secure; HttpOnly; SameSite=Strict";

constexpr std::size_t kBody = 4096;

using Access = AccessRegister&;
using Context = const AccessRoutesContext&;

HttpAnswer answer_pair(const RedeemCode& redeem, const HttpRequest& request) {
  const auto json = json_of(request);
  if (!json) return error_answer(400, json.error().message);
  const std::string secret_proof = text_member(*json, "secret_proof");
  PairingAttempt attempt;
  attempt.code = text_member(*json, "code");
  attempt.secret = text_member(*json, "secret");
  attempt.nonce = text_member(*json, "nonce");
  attempt.proves_secret = !secret_proof.empty();
  attempt.proof = attempt.proves_secret ? secret_proof : text_member(*json, "proof");
  attempt.name = text_member(*json, "name");
  attempt.peer = peer_key(request.peer);
  auto pairing = redeem(request, attempt);
  if (!pairing) return refusal_answer(pairing.error());
  Json answer = {{"role", to_string(pairing->who.role)}, {"device", pairing->who.device}};
  if (!pairing->proof.empty()) answer["proof"] = pairing->proof;
  const auto cookie = json->find("cookie");
  if (cookie == json->end() || *cookie != true) {
    answer["token"] = pairing->token;
    return json_answer(answer);
  }
  HttpAnswer with_cookie = json_answer(answer);
  with_cookie.headers.emplace_back(
      "Set-Cookie", fmt::format(fmt::runtime(kCookie), pairing->token, request.base, 400 * 86400));
  return with_cookie;
}

HttpAnswer answer_me(Access, Context, const HttpRequest& request, const Placeholders&) {
  return json_answer({{"device", request.who->device},
                      {"name", request.who->name},
                      {"role", to_string(request.who->role)}});
}

HttpAnswer remove_device(Access access, Context context, std::int64_t device) {
  const auto revoked = access.revoke(device);
  if (!revoked) return error_answer(500, revoked.error().message);
  if (!*revoked) return error_answer(404, fmt::format("there is no device {}", device));
  if (context.disconnect) context.disconnect(device);
  return json_answer(Json::object());
}

HttpAnswer answer_leave(Access access, Context context, const HttpRequest& request,
                        const Placeholders&) {
  HttpAnswer answer = remove_device(access, context, request.who->device);
  answer.headers.emplace_back("Set-Cookie",
                              fmt::format(fmt::runtime(kCookie), "", request.base, 0));
  return answer;
}

HttpAnswer answer_list(Access access, Context context, const HttpRequest&, const Placeholders&) {
  const std::set<std::int64_t> online =
      context.online ? context.online() : std::set<std::int64_t>();
  Json devices = Json::array();
  for (const PairedDevice& device : access.devices()) {
    devices.push_back({{"device", device.who.device},
                       {"name", device.who.name},
                       {"role", to_string(device.who.role)},
                       {"paired", device.paired_s},
                       {"last_seen", device.last_seen_s},
                       {"online", online.contains(device.who.device)}});
  }
  return json_answer({{"devices", std::move(devices)}});
}

HttpAnswer answer_code(Access access, Context context, const HttpRequest& request,
                       const Placeholders&) {
  const auto json = json_of(request);
  if (!json) return error_answer(400, json.error().message);
  const auto role = parse_role(text_member(*json, "role"));
  if (!role) return error_answer(400, "'role' must be \"device\" or \"helper\"");
  const Now now = context.clock();
  const auto code = access.make_code(*role, now, request.who->device);
  if (!code) return error_answer(500, code.error().message);
  Json answer = {{"code", code->digits},
                 {"valid_s", static_cast<int>(kCodeValid_s)},
                 {"digits_wait_s", static_cast<int>(std::ceil(access.digits_wait_s(now)))}};
  if (context.pair_address) {
    const std::string address = context.pair_address() + "#" + code->secret;
    answer["address"] = address;
    if (context.qr) answer["qr"] = context.qr(address);
  }
  return json_answer(answer);
}

HttpAnswer answer_remove(Access access, Context context, const HttpRequest&,
                         const Placeholders& values) {
  const auto device = number_of<std::int64_t>(values.at("device"));
  return device ? remove_device(access, context, *device)
                : error_answer(404, "there is no such device");
}

HttpAnswer no_authority() {
  return error_answer(404,
                      "this computer's certificate is from before there were authorities of homes");
}

HttpAnswer answer_authority(const std::optional<Authority>& authority, const HttpRequest& request) {
  if (!authority) return no_authority();
  return json_answer({{"name", authority->name},
                      {"fingerprint", fingerprint_with_colons(authority->fingerprint)},
                      {"ends", authority->ends_s},
                      {"file", request.base + "/authority.crt"}});
}

HttpAnswer answer_authority_file(std::optional<Authority> authority) {
  if (!authority) return no_authority();
  HttpAnswer answer;
  answer.content_type = "application/x-x509-ca-cert";  // so that phones offer to install it
  answer.body = std::move(authority->certificate);
  return answer;
}

HttpAnswer answer_rename(Access access, Context context, const HttpRequest& request,
                         const Placeholders& values) {
  const auto json = json_of(request);
  if (!json) return error_answer(400, json.error().message);
  const auto device = number_of<std::int64_t>(values.at("device"));
  if (!device) return error_answer(404, "there is no such device");
  const std::string name = text_member(*json, "name");
  const auto renamed = access.rename(*device, name);
  if (!renamed) return error_answer(400, renamed.error().message);
  if (!*renamed) return error_answer(404, fmt::format("there is no device {}", *device));
  context.renamed(*device, name);
  return json_answer(Json::object());
}

}  // namespace

std::vector<Route> access_routes(AccessRegister& access, AccessRoutesContext given) {
  const auto context = std::make_shared<const AccessRoutesContext>(std::move(given));
  std::vector<Route> routes;
  const auto add = [&](const char* method, const char* pattern, std::optional<Role> role,
                       auto handler) {
    routes.push_back(
        {method, pattern, role,
         [&access, context, handler](const HttpRequest& request, const Placeholders& placeholders) {
           return handler(access, *context, request, placeholders);
         },
         kBody});
  };
  routes.push_back(
      pairing_route([&access, context](const HttpRequest&, const PairingAttempt& attempt) {
        return access.redeem(attempt, context->clock());
      }));
  add("GET", "/api/me", Role::kDevice, answer_me);
  add("POST", "/api/leave", Role::kDevice, answer_leave);
  add("GET", "/api/devices", Role::kHelper, answer_list);
  add("PUT", "/api/devices/{device}", Role::kHelper, answer_rename);
  add("DELETE", "/api/devices/{device}", Role::kHelper, answer_remove);
  add("POST", "/api/codes", Role::kHelper, answer_code);
  std::ranges::move(authority_routes(context->authority), std::back_inserter(routes));
  return routes;
}

Route pairing_route(RedeemCode redeem) {
  return {"POST", "/api/pair", std::nullopt,
          [redeem = std::move(redeem)](const HttpRequest& request, const Placeholders&) {
            return answer_pair(redeem, request);
          },
          kBody};
}

std::vector<Route> authority_routes(std::function<std::optional<Authority>()> authority) {
  if (!authority) authority = [] { return std::nullopt; };
  return {{"GET", "/api/authority", std::nullopt,
           [authority](const HttpRequest& request, const Placeholders&) {
             return answer_authority(authority(), request);
           },
           0},
          {"GET", "/authority.crt", std::nullopt,
           [authority](const HttpRequest&, const Placeholders&) {
             return answer_authority_file(authority());
           },
           0}};
}

}  // namespace roomwise::service
