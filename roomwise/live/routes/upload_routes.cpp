#include "roomwise/live/routes/upload_routes.h"

#include <nlohmann/json.hpp>

#include "roomwise/service/protocol/json_members.h"

namespace roomwise::live {
namespace {

using service::HttpAnswer;
using service::HttpRequest;
using service::Placeholders;

nlohmann::json upload_json(const Upload& upload) {
  return {{"upload", upload.id},
          {"name", upload.name},
          {"bytes", upload.bytes},
          {"offset", upload.offset},
          {"chunk_bytes", Uploads::kMaxChunkBytes}};
}

HttpAnswer upload_answer(const Expected<Upload>& upload) {
  if (!upload) return service::error_answer(409, upload.error().message);
  return service::json_answer(upload_json(*upload));
}

HttpAnswer begin_upload(LiveHome& home, const HttpRequest& request) {
  const auto parsed = service::json_of(request);
  if (!parsed) return service::error_answer(400, parsed.error().message);
  const service::OrderedJson json = *parsed;
  service::Members members(json);
  const std::string name = members.text("name");
  const std::int64_t bytes = members.integer("bytes", 1, service::kMaxInteger);
  const std::string modified = members.has("modified") ? members.text("modified") : "";
  if (members.error()) return service::error_answer(400, members.error()->message);
  return upload_answer(home.uploads().begin(name, static_cast<std::uint64_t>(bytes), modified));
}

// The answer to a piece that does not fit says where to go on, too.
HttpAnswer put_chunk(LiveHome& home, const HttpRequest& request, const Placeholders& values) {
  const std::string& id = values.at("id");
  const auto offset = service::number_of<std::uint64_t>(values.at("offset"));
  if (!offset) {
    return service::error_answer(404, fmt::format("'{}' is no number", values.at("offset")));
  }
  const auto put = home.put_upload(id, *offset, request.body);
  if (put) return upload_answer(put);
  const auto now = home.uploads().find(id);
  if (!now) return service::error_answer(404, now.error().message);
  nlohmann::json answer = upload_json(*now);
  answer["error"] = put.error().message;
  return service::json_answer(answer, 409);
}

HttpAnswer list_uploads(LiveHome& home) {
  const auto all = home.uploads().list();
  if (!all) return service::error_answer(500, all.error().message);
  nlohmann::json uploads = nlohmann::json::array();
  for (const Upload& upload : *all) {
    uploads.push_back(upload_json(upload));
    uploads.back()["is_being_mapped"] = home.is_being_mapped(upload.id);
  }
  return service::json_answer({{"uploads", uploads}});
}

HttpAnswer done_or_why(const Expected<void>& outcome) {
  if (!outcome) return service::error_answer(409, outcome.error().message);
  return service::json_answer(nlohmann::json::object());
}

}  // namespace

std::vector<HomeRoute> upload_routes() {
  constexpr auto kHelper = service::Role::kHelper;
  return {{"GET", "/api/uploads", kHelper,
           [](LiveHome& home, const auto&, const auto&) { return list_uploads(home); }},
          {"POST", "/api/uploads", kHelper,
           [](LiveHome& home, const HttpRequest& request, const auto&) {
             return begin_upload(home, request);
           }},
          {"PUT", "/api/uploads/{id}/{offset}", kHelper,
           [](LiveHome& home, const HttpRequest& request, const Placeholders& values) {
             return put_chunk(home, request, values);
           },
           Uploads::kMaxChunkBytes, /*is_audited=*/false},
          {"POST", "/api/uploads/{id}/map", kHelper,
           [](LiveHome& home, const HttpRequest&, const Placeholders& values) {
             return done_or_why(home.map_upload(values.at("id")));
           }},
          {"DELETE", "/api/uploads/{id}", kHelper,
           [](LiveHome& home, const HttpRequest&, const Placeholders& values) {
             return done_or_why(home.remove_upload(values.at("id")));
           }}};
}

}  // namespace roomwise::live
