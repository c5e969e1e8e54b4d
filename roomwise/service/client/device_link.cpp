#include "roomwise/service/client/device_link.h"

#include <algorithm>
#include <utility>

namespace roomwise::service {

bool DeviceLink::begin_try(double now_s) {
  if (state_ != State::kWaiting || now_s < try_at_s_) return false;
  state_ = State::kConnecting;
  ++counts_.tries;
  return true;
}

DeviceLink::News DeviceLink::connected() {
  state_ = State::kConnected;
  wait_s_ = 0;
  return std::exchange(was_connected_, true) ? News::kBack : News::kConnected;
}

DeviceLink::News DeviceLink::failed(double now_s) {
  const bool lost = state_ == State::kConnected;
  state_ = State::kWaiting;
  newest_.reset();
  under_way_.reset();
  is_slow_ = became_slow_ = false;
  caution_ = 1;
  wait_s_ = wait_s_ == 0 ? times_.first_wait_s : std::min(2 * wait_s_, times_.longest_wait_s);
  try_at_s_ = now_s + wait_s_;
  if (!lost) return News::kNone;
  ++counts_.losses;
  return News::kLost;
}

std::optional<double> DeviceLink::next_try_s() const {
  return state_ == State::kWaiting ? std::optional(try_at_s_) : std::nullopt;
}

void DeviceLink::offer(double t_ms, Bytes message) {
  ++counts_.offered;
  if (newest_ || state_ != State::kConnected) ++counts_.replaced;
  if (state_ == State::kConnected) newest_ = Frame{t_ms, std::move(message)};
}

std::optional<Bytes> DeviceLink::next_frame(double now_s) {
  if (under_way_ && now_s - under_way_->since_s >= times_.acknowledged_s) {
    under_way_.reset();
    become_slow();
  }
  if (state_ != State::kConnected || under_way_ || !newest_) return std::nullopt;
  under_way_ = UnderWay{newest_->t_ms, now_s};
  ++counts_.sent;
  return std::exchange(newest_, std::nullopt)->message;
}

void DeviceLink::become_slow() {
  became_slow_ = became_slow_ || !is_slow_;
  is_slow_ = true;
  quick_in_row_ = 0;
}

void DeviceLink::acknowledged(double t_ms, double now_s) {
  if (!under_way_ || under_way_->t_ms > t_ms) return;
  const double took_s = now_s - under_way_->since_s;
  under_way_.reset();
  if (!is_slow_) {
    if (took_s >= times_.slow_from_s) become_slow();
    return;
  }
  quick_in_row_ = took_s < times_.quick_until_s ? quick_in_row_ + 1 : 0;
  if (quick_in_row_ >= caution_ * times_.quick_frames) {
    is_slow_ = false;
    caution_ = std::min(2 * caution_, LinkTimes::kMaxCaution);
  }
}

}  // namespace roomwise::service
