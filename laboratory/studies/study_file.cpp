#include "laboratory/studies/study_file.h"

#include <fmt/ranges.h>

#include <toml++/toml.h>
#include <algorithm>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>

#include "roomwise/base/file.h"

namespace roomwise::studies {
namespace {

using Names = std::vector<std::string>;

// How many letters must be added, taken away or changed to make one of the other.
std::size_t letters_apart(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string nearest(const std::string& name, const Names& known) {
  return *std::ranges::min_element(
      known, {}, [&](const std::string& one) { return letters_apart(name, one); });
}

// Reads a study's TOML; errors name the file and the line.
class StudyReader {
 public:
  explicit StudyReader(std::string file) : file_(std::move(file)) {}

  Expected<Study> read(const toml::table& all) {
    ROOMWISE_RETURN_IF_ERROR(check_keys(all, {"study", "factors", "steps", "values", "table"}));
    ROOMWISE_RETURN_IF_ERROR(read_head(all));
    ROOMWISE_RETURN_IF_ERROR(read_factors(all));
    ROOMWISE_RETURN_IF_ERROR(read_steps(all));
    ROOMWISE_RETURN_IF_ERROR(read_values(all));
    ROOMWISE_RETURN_IF_ERROR(read_rows(all));
    return std::move(study_);
  }

 private:
  [[nodiscard]] Unexpected wrong(const toml::node& node, const std::string& what) const {
    return fail("{}:{}: {}", file_, node.source().begin.line, what);
  }

  [[nodiscard]] Expected<void> check_keys(const toml::table& table, const Names& known) const {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      if (std::ranges::find(known, name) != known.end()) continue;
      return wrong(node, fmt::format("'{}' is no key here; the nearest is '{}' (known: {})", name,
                                     nearest(name, known), fmt::join(known, ", ")));
    }
    return {};
  }

  [[nodiscard]] Expected<const toml::table*> table_in(const toml::table& all,
                                                      const char* name) const {
    const toml::node* node = all.get(name);
    if (node == nullptr) return fail("{}: the table [{}] is missing", file_, name);
    if (!node->is_table())
      return wrong(*node, fmt::format("'{}' must be a table: [{}]", name, name));
    return node->as_table();
  }

  // The members as they stand in the file: TOML's own order says nothing.
  static std::vector<std::pair<std::string, const toml::node*>> members(const toml::table& table) {
    std::vector<std::pair<std::string, const toml::node*>> list;
    for (const auto& [key, node] : table) list.emplace_back(std::string(key.str()), &node);
    std::ranges::stable_sort(list, {}, [](const auto& one) {
      const auto& begin = one.second->source().begin;
      return std::pair(begin.line, begin.column);
    });
    return list;
  }

  // A text or a number as it stands in a command.
  [[nodiscard]] Expected<std::string> word_of(const toml::node& node) const {
    if (const auto text = node.value_exact<std::string>()) return *text;
    if (const auto number = node.value_exact<std::int64_t>()) return fmt::format("{}", *number);
    if (const auto number = node.value_exact<double>()) return fmt::format("{}", *number);
    if (const auto flag = node.value_exact<bool>()) return fmt::format("{}", *flag);
    return wrong(node, "expected a text or a number");
  }

  [[nodiscard]] Expected<Words> list_of_words(const toml::node& node) const {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->empty()) return wrong(node, "expected a list that is not empty");
    Words words;
    for (const toml::node& one : *array) {
      ROOMWISE_TRY(std::string word, word_of(one));
      words.push_back(std::move(word));
    }
    return words;
  }

  [[nodiscard]] Expected<void> check_name(const toml::node& node, const std::string& name) const {
    const bool is_good = !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '_' || c == '-';
    });
    if (is_good) return {};
    return wrong(node, fmt::format("'{}' is no name: use letters, digits, '-' and '_'", name));
  }

  Expected<void> read_head(const toml::table& all) {
    ROOMWISE_TRY(const toml::table* head, table_in(all, "study"));
    ROOMWISE_RETURN_IF_ERROR(check_keys(*head, {"name", "about", "threads", "minutes"}));
    study_.name = (*head)["name"].value_or(std::string());
    ROOMWISE_RETURN_IF_ERROR(check_name(*head, study_.name));
    study_.about = (*head)["about"].value_or(std::string());
    ROOMWISE_RETURN_IF_ERROR(read_number(*head, "threads", 100'000, study_.threads));
    return read_number(*head, "minutes", 100'000, study_.minutes);
  }

  // A whole number from 1 on, where the table has one of this key.
  Expected<void> read_number(const toml::table& table, const char* key, int max, int& number) {
    const toml::node* node = table.get(key);
    if (node == nullptr) return {};
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < 1 || *value > max) {
      return wrong(*node, fmt::format("'{}' must be a whole number from 1 to {}", key, max));
    }
    number = static_cast<int>(*value);
    return {};
  }

  Expected<void> read_factors(const toml::table& all) {
    ROOMWISE_TRY(const toml::table* table, table_in(all, "factors"));
    for (const auto& [name, node] : members(*table)) {
      ROOMWISE_RETURN_IF_ERROR(check_name(*node, name));
      if (name == "data") return wrong(*node, "'data' is the folder of recordings, no factor");
      if (name == "study") return wrong(*node, "'study' is the folder of this file, no factor");
      ROOMWISE_TRY(Words values, list_of_words(*node));
      std::set<std::string> seen;
      for (const std::string& value : values) {
        if (seen.insert(value).second) continue;
        return wrong(*node, fmt::format("'{}' has '{}' twice: its tasks would be counted twice",
                                        name, value));
      }
      study_.factors.push_back({name, std::move(values)});
    }
    if (study_.factors.empty()) return wrong(*table, "there is no factor; a seed is one");
    return {};
  }

  Expected<void> read_steps(const toml::table& all) {
    const toml::node* node = all.get("steps");
    const toml::array* array = node == nullptr ? nullptr : node->as_array();
    if (array == nullptr || array->empty()) {
      return fail("{}: there is no step: [[steps]] with 'name' and 'run'", file_);
    }
    for (const toml::node& one : *array) {
      if (!one.is_table()) return wrong(one, "a step is a table: [[steps]]");
      ROOMWISE_RETURN_IF_ERROR(read_step(*one.as_table()));
    }
    return {};
  }

  Expected<void> read_step(const toml::table& table) {
    ROOMWISE_RETURN_IF_ERROR(check_keys(table, {"name", "run"}));
    StudyStep step;
    step.name = table["name"].value_or(std::string());
    ROOMWISE_RETURN_IF_ERROR(check_name(table, step.name));
    Names taken{"data", "study"};
    for (const StudyFactor& factor : study_.factors) taken.push_back(factor.name);
    for (const StudyStep& other : study_.steps) taken.push_back(other.name);
    if (std::ranges::find(taken, step.name) != taken.end()) {
      return wrong(table, fmt::format("'{}' is the name of something else already", step.name));
    }
    const toml::node* run = table.get("run");
    if (run == nullptr) return wrong(table, fmt::format("the step '{}' has no 'run'", step.name));
    ROOMWISE_TRY(step.words, list_of_words(*run));
    step.program = step.words.front();
    step.words.erase(step.words.begin());
    if ((step.program != "roomwise" && step.program != "roomwise-lab") || step.words.empty()) {
      return wrong(*run, "a step runs [\"roomwise\", …] or [\"roomwise-lab\", …]");
    }
    taken.push_back(step.name);
    for (const std::string& word : step.words) {
      for (const std::string& name : placeholders_in(word)) {
        if (std::ranges::find(taken, name) != taken.end()) continue;
        return wrong(*run, fmt::format("{{{}}} stands for nothing; the nearest is {{{}}}", name,
                                       nearest(name, taken)));
      }
    }
    study_.steps.push_back(std::move(step));
    return {};
  }

  Expected<void> read_values(const toml::table& all) {
    ROOMWISE_TRY(const toml::table* table, table_in(all, "values"));
    Names steps;
    for (const StudyStep& step : study_.steps) steps.push_back(step.name);
    for (const auto& [name, node] : members(*table)) {
      ROOMWISE_RETURN_IF_ERROR(check_name(*node, name));
      ROOMWISE_TRY(const std::string where, word_of(*node));
      const std::size_t slash = where.find('/');
      if (slash == std::string::npos) {
        return wrong(*node,
                     fmt::format("'{}' must be a step and a place in what it prints, such as "
                                 "'{}/ate/rmse_m'",
                                 where, steps.front()));
      }
      const StudyValue value{name, where.substr(0, slash), where.substr(slash)};
      if (std::ranges::find(steps, value.step) == steps.end()) {
        return wrong(*node, fmt::format("there is no step '{}'; the nearest is '{}'", value.step,
                                        nearest(value.step, steps)));
      }
      study_.values.push_back(value);
    }
    if (study_.values.empty()) return wrong(*table, "there is no figure to take");
    return {};
  }

  Expected<void> read_rows(const toml::table& all) {
    Names factors;
    for (const StudyFactor& factor : study_.factors) factors.push_back(factor.name);
    if (all.get("table") == nullptr) {
      study_.groups = factors;
      return {};
    }
    ROOMWISE_TRY(const toml::table* table, table_in(all, "table"));
    ROOMWISE_RETURN_IF_ERROR(check_keys(*table, {"rows", "columns", "digits"}));
    ROOMWISE_RETURN_IF_ERROR(read_number(*table, "digits", study_.digits, study_.digits));
    study_.are_columns = table->get("columns") != nullptr;
    const toml::node* groups = table->get(study_.are_columns ? "columns" : "rows");
    if (groups == nullptr || (study_.are_columns && table->get("rows") != nullptr)) {
      return wrong(*table, "either 'rows' or 'columns': factors by which there are some");
    }
    if (!groups->is_array()) return wrong(*groups, "expected a list of factors");
    if (groups->as_array()->empty()) return {};  // all tasks together
    ROOMWISE_TRY(study_.groups, list_of_words(*groups));
    for (const std::string& name : study_.groups) {
      if (std::ranges::find(factors, name) != factors.end()) continue;
      return wrong(*groups, fmt::format("there is no factor '{}'; the nearest is '{}'", name,
                                        nearest(name, factors)));
    }
    return {};
  }

  static Names placeholders_in(const std::string& word) {
    Names names;
    for (std::size_t at = 0; (at = word.find('{', at)) != std::string::npos; ++at) {
      const std::size_t end = word.find('}', at);
      if (end == std::string::npos) break;
      names.push_back(word.substr(at + 1, end - at - 1));
    }
    return names;
  }

  std::string file_;
  Study study_;
};

std::string replaced(std::string word, const std::string& name, const std::string& by) {
  const std::string placeholder = "{" + name + "}";
  for (std::size_t at = 0; (at = word.find(placeholder, at)) != std::string::npos;
       at += by.size()) {
    word.replace(at, placeholder.size(), by);
  }
  return word;
}

std::string id_of(const Study& study, const StudyTask& task, const std::string& version) {
  std::string made_of = study.name + "\n" + version + "\n" + task.title() + "\n";
  for (const StudyStep& step : study.steps) {
    made_of += fmt::format("{} {} {}\n", step.name, step.program, fmt::join(step.words, "\x1f"));
  }
  for (const StudyValue& value : study.values) {
    made_of += fmt::format("{} {}{}\n", value.name, value.step, value.pointer);
  }
  constexpr std::size_t kDigits = 16;
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(made_of.data()), made_of.size()})
      .substr(0, kDigits);
}

}  // namespace

Expected<Study> parse_study(const std::string& text, const std::string& file_name) {
  try {
    return StudyReader(file_name).read(toml::parse(text, file_name));
  } catch (const toml::parse_error& error) {
    return fail("{}:{}: {}", file_name, error.source().begin.line, error.description());
  }
}

Expected<Study> read_study(const std::filesystem::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  return parse_study(text, file.string());
}

std::string StudyTask::title() const {
  std::string text;
  for (const auto& [name, value] : factors) {
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", name, value);
  }
  return text;
}

std::vector<StudyTask> tasks_of(const Study& study, const std::string& version) {
  std::vector<StudyTask> tasks(1);
  for (const StudyFactor& factor : study.factors) {
    std::vector<StudyTask> more;
    for (const StudyTask& task : tasks) {
      for (const std::string& value : factor.values) {
        more.push_back(task);
        more.back().factors[factor.name] = value;
      }
    }
    tasks = std::move(more);
  }
  for (StudyTask& task : tasks) task.id = id_of(study, task, version);
  return tasks;
}

Words words_of(const StudyStep& step, const StudyTask& task,
               const std::map<std::string, std::filesystem::path>& folders) {
  Words words;
  for (std::string word : step.words) {
    for (const auto& [name, value] : task.factors) word = replaced(std::move(word), name, value);
    for (const auto& [name, folder] : folders) {
      word = replaced(std::move(word), name, folder.string());
    }
    words.push_back(std::move(word));
  }
  return words;
}

}  // namespace roomwise::studies
