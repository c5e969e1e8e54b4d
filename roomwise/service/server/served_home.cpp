#include "roomwise/service/server/served_home.h"

#include "roomwise/service/server/request_checks.h"
#include "roomwise/service/server/server.h"

namespace roomwise::service {
namespace {

class OnlyHome final : public ServedHome {
 public:
  OnlyHome(Router router, AccessRegister& access, SocketHandler& sockets)
      : router_(std::move(router)), access_(access), sockets_(sockets) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const Router& router() const override { return router_; }
  [[nodiscard]] Expected<std::optional<Identity>> identify(const HttpRequest& request,
                                                           const Now& now) override {
    const auto token = token_of(request);
    if (!token) return std::nullopt;
    return access_.identify(*token, now);
  }
  [[nodiscard]] Expected<SocketHandler*> sockets() override { return &sockets_; }

 private:
  const std::string name_;
  const Router router_;
  AccessRegister& access_;
  SocketHandler& sockets_;
};

class OneAtPort final : public HomesAtPort {
 public:
  OneAtPort(Router router, AccessRegister& access, SocketHandler& sockets)
      : home_(std::make_shared<OnlyHome>(std::move(router), access, sockets)) {}

  [[nodiscard]] std::variant<ResolvedRequest, HttpAnswer> resolve(const HttpRequest& request,
                                                                  const Now& now) override {
    return ResolvedRequest{home_, "", home_->identify(request, now).value()};
  }
  [[nodiscard]] bool resolves_at_once() const override { return true; }

 private:
  std::shared_ptr<OnlyHome> home_;
};

}  // namespace

// The router decides who may.
Route socket_route() {
  return {"GET", "/api/socket", Role::kDevice,
          [](const HttpRequest&, const Placeholders&) {
            HttpAnswer answer =
                error_answer(426, "this is a WebSocket: upgrade, with the subprotocol roomwise.1");
            answer.headers = {{"Upgrade", "websocket"}, {"Connection", "Upgrade"}};
            return answer;
          },
          0};
}

std::unique_ptr<HomesAtPort> only_home(Router router, AccessRegister& access,
                                       SocketHandler& sockets) {
  return std::make_unique<OneAtPort>(std::move(router), access, sockets);
}

}  // namespace roomwise::service
