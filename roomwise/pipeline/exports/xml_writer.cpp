#include "roomwise/pipeline/exports/xml_writer.h"

#include <nlohmann/json.hpp>

#include "roomwise/evaluation/drawing/svg.h"

namespace roomwise::pipeline {
namespace {

// UTF-8 whatever it was.
std::string as_utf8(std::string_view text) {
  using Json = nlohmann::json;
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string safe_text(std::string_view text) {
  std::string safe = evaluation::escape_markup(as_utf8(text));
  // Two numbers that are no characters, which JSON holds and XML does not.
  for (const std::string_view forbidden : {"\xEF\xBF\xBE", "\xEF\xBF\xBF"}) {
    for (std::size_t at = 0; (at = safe.find(forbidden, at)) != std::string::npos;) {
      safe.replace(at, forbidden.size(), "\xEF\xBF\xBD");
    }
  }
  return safe;
}

}  // namespace

void XmlWriter::start(std::string_view name, const Attributes& attributes) {
  text_.append(open_.size(), ' ').append("<").append(name);
  for (const auto& [key, value] : attributes) {
    text_.append(" ").append(key).append("=\"").append(safe_text(value)).append("\"");
  }
}

void XmlWriter::open(std::string_view name, const Attributes& attributes) {
  start(name, attributes);
  text_ += ">\n";
  open_.emplace_back(name);
}

void XmlWriter::close() {
  const std::string name = std::move(open_.back());
  open_.pop_back();
  text_.append(open_.size(), ' ').append("</").append(name).append(">\n");
}

void XmlWriter::leaf(std::string_view name, std::string_view text, const Attributes& attributes) {
  start(name, attributes);
  text_.append(">").append(safe_text(text)).append("</").append(name).append(">\n");
}

void XmlWriter::empty(std::string_view name, const Attributes& attributes) {
  start(name, attributes);
  text_ += "/>\n";
}

}  // namespace roomwise::pipeline
