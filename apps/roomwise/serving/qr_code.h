#pragma once

#include <string>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::app {

// The rows of a QR code of a text, '1' for a dark module: without the quiet zone around it.
[[nodiscard]] Expected<std::vector<std::string>> qr_rows(const std::string& text);

// The same for a terminal of either background: two rows of modules a line, quiet zone included.
[[nodiscard]] std::string qr_lines(const std::vector<std::string>& rows);

}  // namespace roomwise::app
