#include "laboratory/studies/study_store.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/home/database.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;
using StoredJson = nlohmann::json;

Expected<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  return {};
}

// As RFC 4180 writes a field.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string sql_name(const std::string& name) {
  return "\"" + name + "\"";  // names hold letters, digits, '-' and '_' alone
}

// A row of the tables: names and texts.
using Fields = std::vector<std::pair<std::string, std::string>>;

Fields fields_of(const Study& study, const TaskResult& result) {
  Fields fields{{"task", result.id}};
  for (const StudyFactor& factor : study.factors) {
    fields.emplace_back("factor_" + factor.name, result.factors.at(factor.name));
  }
  fields.emplace_back("state", result.is_good ? "done" : "failed");
  for (const StudyValue& value : study.values) {
    const auto found = result.values.find(value.name);
    fields.emplace_back("value_" + value.name, found == result.values.end() ? "" : found->second);
  }
  fields.emplace_back("why", result.why);
  fields.emplace_back("version", result.version);
  fields.emplace_back("machine", result.machine);
  fields.emplace_back("attempts", fmt::format("{}", result.attempts));
  fields.emplace_back("seconds", fmt::format("{:.3f}", result.seconds));
  return fields;
}

// A line of a CSV file: of each field its name, or its value.
std::string csv_line(const Fields& fields, std::string Fields::value_type::*part) {
  std::vector<std::string> written;
  for (const auto& field : fields) written.push_back(csv_field(field.*part));
  return fmt::format("{}\r\n", fmt::join(written, ","));
}

Expected<void> write_csv(const fs::path& file, const std::vector<Fields>& rows) {
  std::string text = csv_line(rows.front(), &Fields::value_type::first);
  for (const Fields& row : rows) text += csv_line(row, &Fields::value_type::second);
  return write_file(file, text);
}

// Made beside and put in its place, so that who looks at it sees all or none.
Expected<void> write_sqlite(const fs::path& file, const std::vector<Fields>& rows) {
  const fs::path part = file.string() + ".part";
  std::error_code ignored;
  fs::remove(part, ignored);
  ROOMWISE_RETURN_IF_ERROR(write_file(part, ""));
  {
    ROOMWISE_TRY(home::Database database,
                 home::Database::open(part, home::Database::Access::kReadWrite));
    std::string columns;
    for (const auto& [name, value] : rows.front()) {
      // SQLite makes numbers of what is one where a column is NUMERIC.
      const bool may_be_number =
          name.starts_with("value_") || name == "attempts" || name == "seconds";
      columns +=
          fmt::format("{}{} {}{}", columns.empty() ? "" : ", ", sql_name(name),
                      may_be_number ? "NUMERIC" : "TEXT", name == "task" ? " PRIMARY KEY" : "");
    }
    ROOMWISE_RETURN_IF_ERROR(database.run(fmt::format("CREATE TABLE results ({})", columns)));
    ROOMWISE_TRY(home::Transaction all, home::Transaction::begin(database));
    for (const Fields& row : rows) {
      ROOMWISE_RETURN_IF_ERROR(database.run("INSERT INTO results DEFAULT VALUES"));
      for (const auto& [name, value] : row) {
        if (value.empty()) continue;
        ROOMWISE_RETURN_IF_ERROR(
            database.run(fmt::format("UPDATE results SET {} = ? WHERE rowid = last_insert_rowid()",
                                     sql_name(name)),
                         value));
      }
    }
    ROOMWISE_RETURN_IF_ERROR(all.commit());
  }
  fs::rename(part, file, ignored);
  if (ignored) return fail("{}: cannot be put in place: {}", file.string(), ignored.message());
  return {};
}

// A task is known by its words, in which these are placeholders.
Expected<void> check_sources(const StudyStore& there, const Study& study,
                             const std::map<std::string, fs::path>& sources) {
  std::error_code ignored;
  if (fs::is_empty(there.folder() / "results", ignored)) return {};
  for (const auto& [name, source] : sources) {
    const bool is_used = std::ranges::any_of(study.steps, [&](const StudyStep& step) {
      return std::ranges::any_of(step.words, [&](const std::string& word) {
        return word.find("{" + name + "}") != std::string::npos;
      });
    });
    const fs::path& before = there.sources().at(name);
    // With and without a slash at its end is the same.
    if (!is_used || before / "" == source / "" || fs::equivalent(before, source, ignored)) continue;
    return fail("{}: holds results of {{{}}} in {}, and not in {}; name another folder",
                there.folder().string(), name, before.string(), source.string());
  }
  return {};
}

}  // namespace

Expected<StudyStore> StudyStore::create(const fs::path& folder, const fs::path& study_file,
                                        const fs::path& data, const std::string& version) {
  ROOMWISE_TRY(const std::string text, read_text_file(study_file));
  ROOMWISE_TRY(const Study study, parse_study(text, study_file.string()));
  const std::map<std::string, fs::path> sources{
      {"data", data.empty() ? fs::path() : fs::absolute(data)},
      {"study", fs::absolute(study_file).parent_path()}};
  const fs::path facts = folder / "study.json";
  if (fs::exists(facts)) {
    ROOMWISE_TRY(const StudyStore there, open(folder));
    if (there.study().name != study.name) {
      return fail("{}: holds the study '{}' and not '{}'; name another folder", folder.string(),
                  there.study().name, study.name);
    }
    ROOMWISE_RETURN_IF_ERROR(check_sources(there, study, sources));
  }
  ROOMWISE_RETURN_IF_ERROR(make_folder(folder / "results"));
  ROOMWISE_RETURN_IF_ERROR(make_folder(folder / "tasks"));
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "study.toml", text));
  StoredJson json{{"version", version}};
  for (const auto& [name, source] : sources) json[name] = source.string();
  ROOMWISE_RETURN_IF_ERROR(write_file(facts, json.dump(2) + "\n"));
  return open(folder);
}

Expected<StudyStore> StudyStore::open(const fs::path& folder) {
  StudyStore store;
  store.folder_ = fs::absolute(folder);
  ROOMWISE_TRY(const std::string text, read_text_file(folder / "study.json"));
  const StoredJson json = StoredJson::parse(text, nullptr, false);
  if (!json.is_object()) {
    return fail("{}: is damaged; run the study again", (folder / "study.json").string());
  }
  for (const char* source : {"data", "study"}) store.sources_[source] = json.value(source, "");
  store.version_ = json.value("version", "");
  ROOMWISE_TRY(store.study_, read_study(folder / "study.toml"));
  return store;
}

Expected<void> StudyStore::put(const TaskResult& result) const {
  const StoredJson json{
      {"task", result.id},         {"factors", result.factors},   {"good", result.is_good},
      {"why", result.why},         {"values", result.values},     {"version", result.version},
      {"machine", result.machine}, {"attempts", result.attempts}, {"seconds", result.seconds}};
  return write_file(folder_ / "results" / (result.id + ".json"), json.dump() + "\n");
}

Expected<std::optional<TaskResult>> StudyStore::find(const std::string& id) const {
  const fs::path file = folder_ / "results" / (id + ".json");
  if (!fs::exists(file)) return std::optional<TaskResult>();
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  try {
    const StoredJson json = StoredJson::parse(text);
    TaskResult result;
    json.at("task").get_to(result.id);
    json.at("factors").get_to(result.factors);
    json.at("good").get_to(result.is_good);
    json.at("why").get_to(result.why);
    json.at("values").get_to(result.values);
    json.at("version").get_to(result.version);
    json.at("machine").get_to(result.machine);
    json.at("attempts").get_to(result.attempts);
    json.at("seconds").get_to(result.seconds);
    if (result.id == id) return std::optional(std::move(result));
  } catch (const StoredJson::exception&) {
  }
  return fail_with(ErrorCode::kDamaged, "{}: is damaged; remove it to have its task done anew",
                   file.string());
}

Expected<void> StudyStore::forget(const std::string& id) const {
  std::error_code error;
  fs::remove(folder_ / "results" / (id + ".json"), error);
  if (!error) fs::remove_all(task_folder(id), error);
  if (error) return fail("{}: cannot be removed: {}", task_folder(id).string(), error.message());
  return {};
}

Expected<void> StudyStore::forget_failed() const {
  ROOMWISE_TRY(const auto all, results());
  for (const TaskResult& result : all) {
    if (!result.is_good) ROOMWISE_RETURN_IF_ERROR(forget(result.id));
  }
  return {};
}

Expected<std::vector<TaskResult>> StudyStore::results() const {
  std::vector<TaskResult> results;
  for (const StudyTask& task : tasks()) {
    ROOMWISE_TRY(auto result, find(task.id));
    if (result) results.push_back(*std::move(result));
  }
  return results;
}

Expected<std::vector<StudyTask>> StudyStore::open_tasks() const {
  std::vector<StudyTask> open;
  for (StudyTask& task : tasks()) {
    ROOMWISE_TRY(const auto result, find(task.id));
    if (!result) open.push_back(std::move(task));
  }
  return open;
}

Expected<void> StudyStore::write_tables() const {
  ROOMWISE_TRY(const auto all, results());
  std::vector<Fields> rows;
  for (const TaskResult& result : all) rows.push_back(fields_of(study_, result));
  if (rows.empty()) return {};
  ROOMWISE_RETURN_IF_ERROR(write_csv(folder_ / "results.csv", rows));
  return write_sqlite(folder_ / "results.sqlite", rows);
}

}  // namespace roomwise::studies
