#pragma once

#include <string>

#include "roomwise/home/database.h"

namespace roomwise::home {

// SHA-256 (lower-case hexadecimal) over every row of the tables that count (schema.h). It depends
// on the values alone: not on the order in which rows were written, on transactions, on the layout
// of the file, on the order of columns.
[[nodiscard]] Expected<std::string> content_digest(const Database& database);

}  // namespace roomwise::home
