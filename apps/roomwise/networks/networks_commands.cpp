#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "commands.h"
#include "networks.h"
#include "roomwise/base/file.h"
#include "roomwise/download/https_download.h"
#include "roomwise/network/formats/catalogue.h"
#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/formats/model_card.h"
#include "roomwise/network/formats/network_file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using download::ExpectedFile;
using download::FetchedFile;
using network::CatalogueEntry;

// What FILE.sha256 says of a file that was fetched: its digest as sha256sum writes it, and in a
// comment who vouched for that.
struct Record {
  std::string sha256;  // empty where there is no record
  std::string vouched;

  [[nodiscard]] bool by_user() const { return vouched == kByUser; }
  static constexpr const char* kByUser = "given by the user";
};

fs::path record_of(const fs::path& file) {
  return file.string() + ".sha256";
}

Record read_record(const fs::path& file) {
  const auto text = read_text_file(record_of(file));
  if (!text) return {};
  Record record{text->substr(0, text->find(' ')), ""};
  if (record.sha256.size() != 64 || !download::is_digest_begin(record.sha256)) return {};
  if (const std::size_t comment = text->find("\n# "); comment != std::string::npos) {
    const std::size_t begin = comment + 3;
    record.vouched = text->substr(begin, text->find('\n', begin) - begin);
  }
  return record;
}

Expected<void> write_record(const fs::path& file, const Record& record) {
  return write_file(record_of(file), fmt::format("{}  {}\n# {}\n", record.sha256,
                                                 file.filename().string(), record.vouched));
}

// ---- networks list ----

std::string what_for(const fs::path& file) {
  const bool in_eight_bits = network::is_eight_bit_file(file);
  if (in_eight_bits) {
    const auto how = network::read_eight_bit_file(file);
    if (!how) return "damaged";
    std::error_code ignored;
    if (!fs::exists(file.parent_path() / how->network, ignored)) return "its network is missing";
  }
  const auto card = network::find_model_card(file);
  if (!card) return "no card";
  if (network::finds_things(card->task)) return "finds things";
  if (card->task == network::Task::kMatchWords) return "compares with words";
  const std::string gives = card->labels_file.empty() ? "features" : "features and names";
  return in_eight_bits ? gives + ", 8 bits" : gives;
}

// The networks of texts that cards of others name.
std::set<fs::path> text_networks_among(const std::vector<fs::path>& files) {
  std::set<fs::path> named;
  for (const fs::path& file : files) {
    const auto card = network::find_model_card(file);
    if (card && card->text) named.insert(file.parent_path() / card->text->network);
  }
  return named;
}

Expected<Answer> list() {
  Answer answer;
  answer.json = {{"folders", Json::array()}, {"here", Json::array()}, {"known", Json::array()}};
  ROOMWISE_TRY(auto usable, usable_networks());
  ROOMWISE_TRY(const auto detectors, usable_detectors());
  usable.insert(usable.end(), detectors.begin(), detectors.end());
  ROOMWISE_TRY(const auto of_words, usable_word_networks());
  if (!of_words.empty()) usable.push_back(of_words.front());
  std::vector<fs::path> folders = network_folders();
  if (const auto brought = brought_network_folder()) folders.push_back(*brought);
  for (const fs::path& folder : folders) {
    answer.json["folders"].push_back(folder.string());
    answer.text += fmt::format("In {}:\n", folder.string());
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      const bool is_network =
          network::has_ending_of_network(entry.path()) || network::is_eight_bit_file(entry.path());
      if (is_network) files.push_back(entry.path());
    }
    std::ranges::sort(files);
    const std::set<fs::path> text_networks = text_networks_among(files);
    for (const fs::path& file : files) {
      const bool used = std::ranges::find(usable, file) != usable.end();
      const std::string purpose = text_networks.contains(file) ? "reads words" : what_for(file);
      answer.text += fmt::format("  {:44} {:26} {}\n", file.filename().string(), purpose,
                                 used ? "used by default" : "");
      answer.json["here"].push_back(
          {{"file", file.string()}, {"for", purpose}, {"used_by_default", used}});
    }
  }
  answer.text += "Published (roomwise networks pull NAME):\n";
  for (const CatalogueEntry& entry : network::catalogue()) {
    const auto file = find_in_folders(entry.file);
    answer.text += fmt::format("  {:28} {:10} {}\n", entry.name, file ? "here" : "", entry.about);
    answer.json["known"].push_back({{"name", entry.name},
                                    {"file", entry.file},
                                    {"address", entry.address},
                                    {"sha256_begin", entry.sha256_begin},
                                    {"license", entry.license},
                                    {"about", entry.about},
                                    {"installed", file ? Json(file->string()) : Json()}});
    if (entry.bytes) answer.json["known"].back()["bytes"] = *entry.bytes;
  }
  return answer;
}

// ---- networks pull ----

struct PullOptions {
  std::string name;
  fs::path to;
  std::string from;
  std::string sha256;
  fs::path certificates;
};

// Fetches an entry's file from where the user says, or from its publisher.
Expected<FetchedFile> fetch(const CatalogueEntry& entry, const PullOptions& options,
                            const fs::path& target, const ExpectedFile& expected,
                            const download::BeforeNaming& before_naming, Context& context) {
  const std::string& from = options.from;
  if (from.empty() || from.find("://") != std::string::npos) {
    std::string url = from.empty() ? entry.address : from;
    if (url.ends_with('/')) url += entry.file;  // a mirror
    download::DownloadOptions download_options;
    download_options.certificates = options.certificates;
    download_options.before_naming = before_naming;
    return download::download(url, target, expected, context.progress, download_options);
  }
  std::error_code ignored;
  const fs::path source =
      fs::is_directory(from, ignored) ? from / fs::path(entry.file) : fs::path(from);
  return download::copy_checked(source, target, expected, before_naming);
}

Expected<Answer> pull(const PullOptions& options, Context& context) {
  const CatalogueEntry* entry = find_catalogue_entry(options.name);
  if (entry == nullptr) {
    return fail("{}: is not in the catalogue; 'roomwise networks list' names what is",
                options.name);
  }
  if (!options.sha256.empty() &&
      (options.sha256.size() != 64 || !download::is_digest_begin(options.sha256))) {
    return fail("--sha256 is not a digest: expected 64 lower-case hexadecimal digits");
  }
  fs::path folder = options.to;
  if (folder.empty()) {
    ROOMWISE_TRY(folder, own_network_folder());
  }
  const fs::path target = folder / entry->file;
  // What the user says of the digest counts more than what the catalogue has from others.
  const bool own_digest = !options.sha256.empty();
  const ExpectedFile expected{own_digest ? std::nullopt : entry->bytes,
                              own_digest ? options.sha256 : entry->sha256_begin};
  // The record comes before the file: 'networks verify' must never call a right file wrong.
  const auto keep_record = [&](const FetchedFile& file) {
    const std::string from = entry->digest_from.empty() ? "nobody" : entry->digest_from;
    return write_record(target, {file.sha256, own_digest ? Record::kByUser : from});
  };
  Expected<FetchedFile> fetched = download::check_file(target, expected);
  const Record record = read_record(target);
  const bool recorded = fetched.has_value() && fetched->sha256 == record.sha256;
  const bool was_here = fetched.has_value() && (!expected.sha256_begin.empty() || recorded);
  if (!was_here) {
    fetched = fetch(*entry, options, target, expected, keep_record, context);
    if (!fetched) return Unexpected(std::move(fetched).error());
  } else if (!recorded || own_digest) {
    ROOMWISE_RETURN_IF_ERROR(keep_record(*fetched));
  }
  Answer answer;
  answer.text = fmt::format("{}: {} bytes, {}\n", target.string(), fetched->bytes,
                            was_here ? "was here already" : "fetched");
  answer.text += fmt::format("SHA-256 {}\n", fetched->sha256);
  std::string checked_by = own_digest ? "--sha256" : entry->digest_from;
  if (checked_by.empty()) {
    answer.text +=
        "warning: nobody has published its digest, so that only the connection vouches for it; "
        "compare it with that of a copy you trust. It is recorded for 'networks verify'\n";
  } else {
    answer.text +=
        fmt::format("checked: {} digits, from {}\n", expected.sha256_begin.size(), checked_by);
  }
  answer.text += fmt::format("licence: {}\n", entry->license);
  answer.json = {{"file", target.string()},
                 {"bytes", fetched->bytes},
                 {"sha256", fetched->sha256},
                 {"digits_checked", expected.sha256_begin.size()},
                 {"digest_from", checked_by},
                 {"was_here", was_here},
                 {"resumed_from", fetched->resumed_from},
                 {"license", entry->license}};
  return answer;
}

// ---- networks verify ----

struct VerifyOptions {
  std::vector<std::string> names;
};

// The files to check: those named, or all of the catalogue that are here.
Expected<std::vector<fs::path>> files_to_verify(const VerifyOptions& options) {
  std::vector<fs::path> files;
  for (const std::string& name : options.names) {
    ROOMWISE_TRY(fs::path file, find_network_file(name));
    files.push_back(std::move(file));
  }
  if (!options.names.empty()) return files;
  for (const CatalogueEntry& entry : network::catalogue()) {
    if (auto file = find_in_folders(entry.file)) files.push_back(*std::move(file));
  }
  if (files.empty()) return fail("no network of the catalogue is here; name one, or pull one");
  return files;
}

Expected<Answer> verify(const VerifyOptions& options, Context& /*context*/) {
  ROOMWISE_TRY(const auto files, files_to_verify(options));
  Answer answer;
  answer.json = Json::array();
  std::vector<std::string> wrong;
  for (const fs::path& file : files) {
    const CatalogueEntry* entry = find_catalogue_entry(file.filename().string());
    const Record record = read_record(file);
    ExpectedFile expected;
    if (entry != nullptr && !record.by_user()) expected = {entry->bytes, entry->sha256_begin};
    // What was fetched once says more than the first digits, if it agrees with them.
    if (record.sha256.starts_with(expected.sha256_begin)) expected.sha256_begin = record.sha256;
    const auto checked = download::check_file(file, expected);
    if (!checked) wrong.push_back(checked.error().message);
    const std::string state = !checked ? "WRONG"
                              : expected.sha256_begin.empty()
                                  ? "nothing is known to compare with"
                                  : fmt::format("right ({} digits)", expected.sha256_begin.size());
    answer.text += fmt::format("{}: {}\n", file.string(), state);
    answer.json.push_back({{"file", file.string()},
                           {"right", checked.has_value()},
                           {"digits_checked", expected.sha256_begin.size()},
                           {"vouched", record.vouched}});
    if (checked) answer.json.back()["sha256"] = checked->sha256;
  }
  if (!wrong.empty()) return fail("{}; delete it and pull it again", fmt::join(wrong, "; "));
  return answer;
}

}  // namespace

void add_networks_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "networks", "Fetch, check and look at networks", "roomwise networks list");
  add_command(*group, context, "list", "Networks that are here, and published ones",
              "roomwise networks list", [] { return list(); });
  {
    const auto [command, options] =
        add_command<PullOptions>(*group, context, "pull", "Fetch a published network",
                                 "roomwise networks pull yolox-nano", pull);
    command->add_option("NAME", options.name, "As 'networks list' names it")->required();
    command->add_option("--to", options.to, "Folder to put it in; default: the user's own");
    command->add_option(
        "--from", options.from,
        "Take it from this file, folder, https address, or mirror (an https address "
        "that ends in /)");
    command->add_option(
        "--sha256", options.sha256,
        "Its SHA-256 digest, from a source that you trust; used instead of the catalogue's");
    command->add_option("--certificates", options.certificates,
                        "Trust the certificates of this PEM file in place of the system's");
  }
  {
    const auto [command, options] =
        add_command<VerifyOptions>(*group, context, "verify", "Check the files of networks again",
                                   "roomwise networks verify", verify);
    command->add_option("NAMES", options.names, "Default: all of the catalogue that are here");
  }
  add_networks_looks(*group, context);
  add_networks_quantize(*group, context);
}

}  // namespace roomwise::app
