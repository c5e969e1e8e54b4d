#include "own_kinds.h"

#include <cstdlib>

#include "networks.h"
#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/objects/detection/object_vocabulary.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::app {

std::filesystem::path own_kinds_file() {
  const char* named = std::getenv("ROOMWISE_KINDS");
  if (named != nullptr && *named != '\0') return named;
  const auto networks = own_network_folder();
  if (!networks) return {};
  const auto file = networks->parent_path() / "kinds.json";
  std::error_code ignored;
  return std::filesystem::exists(file, ignored) ? file : std::filesystem::path();
}

Expected<void> add_own_kinds() {
  const std::filesystem::path file = own_kinds_file();
  if (file.empty()) return {};
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  return in_context(file.string(),
                    objects::add_kinds(text).and_then(objects::ObjectVocabulary::check_kinds));
}

}  // namespace roomwise::app
