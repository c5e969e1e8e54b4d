#include "serving/qr_code.h"

#include <qrencode.h>

#include <memory>

namespace roomwise::app {

Expected<std::vector<std::string>> qr_rows(const std::string& text) {
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeString8bit(text.c_str(), 0, QR_ECLEVEL_M), QRcode_free);
  if (!code) return fail("no QR code can be made of {} bytes", text.size());
  std::vector<std::string> rows;
  const auto side = static_cast<std::size_t>(code->width);
  for (std::size_t row = 0; row < side; ++row) {
    std::string modules;
    for (std::size_t column = 0; column < side; ++column) {
      modules += (code->data[row * side + column] & 1U) != 0 ? '1' : '0';
    }
    rows.push_back(std::move(modules));
  }
  return rows;
}

std::string qr_lines(const std::vector<std::string>& rows) {
  constexpr int kQuiet = 2;  // modules around it
  const int side = static_cast<int>(rows.size());
  const auto is_dark = [&](int row, int column) {
    const bool inside = row >= 0 && row < side && column >= 0 && column < side;
    return inside && rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] == '1';
  };
  std::string lines;
  for (int row = -kQuiet; row < side + kQuiet; row += 2) {
    lines += "\033[30;47m";  // dark on light, whatever the terminal's colours
    for (int column = -kQuiet; column < side + kQuiet; ++column) {
      const bool above = is_dark(row, column);
      const bool below = is_dark(row + 1, column);
      lines += above && below ? "█" : above ? "▀" : below ? "▄" : " ";
    }
    lines += "\033[0m\n";
  }
  return lines;
}

}  // namespace roomwise::app
