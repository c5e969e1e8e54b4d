#include <sys/stat.h>

#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "paths.h"
#include "roomwise/base/file.h"
#include "roomwise/pipeline/report/home_report.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  fs::path home;
  fs::path output;
  fs::path truth;
  fs::path evaluation;
};

// What rooms eval --json printed.
Expected<std::vector<evaluation::ReportContent::Recognition>> read_evaluation(
    const fs::path& file) {
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  std::vector<evaluation::ReportContent::Recognition> results;
  try {
    const auto json = nlohmann::json::parse(text);
    for (const auto& [key, rule] :
         {std::pair("single", "one picture"), std::pair("pair", "two pictures")}) {
      const auto& values = json.at(key);
      auto& result = results.emplace_back();
      result.rule = rule;
      const auto interval_of = [](const nlohmann::json& of) -> evaluation::Interval {
        return {of.at("interval").at(0), of.at("interval").at(1)};
      };
      const auto& named = values.at("named");
      result.top1_correct = {values.at("correct"), values.at("n")};
      result.top1_interval = interval_of(values);
      result.named_correct = {named.at("right"), named.at("of")};
      result.named_interval = interval_of(named);
      result.resampled = json.at("resampled");
      result.ms = values.at("ms");
      if (!values.contains("confusion")) continue;
      for (const auto& [truth, answers] : values.at("confusion").items()) {
        for (const auto& [answer, count] : answers.items()) {
          result.confusion.add(truth, answer, count.get_ref<const std::uint64_t&>());
        }
      }
    }
  } catch (const nlohmann::json::exception& error) {
    return fail("{}: is not what rooms eval --json prints: {}", file.string(), error.what());
  }
  return results;
}

Expected<Answer> run(const ReportOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  pipeline::ReportExtras extras;
  extras.name = options.home.stem().string();
  if (!options.truth.empty()) {
    ROOMWISE_TRY(extras.truth, recording::read_truth(options.truth));
  }
  if (!options.evaluation.empty()) {
    ROOMWISE_TRY(extras.recognition, read_evaluation(options.evaluation));
  }
  if (home.is_protected()) ::umask(077);  // the page shows its pictures
  CommandRun run(context);
  ROOMWISE_TRY(const evaluation::ReportContent content,
               pipeline::report_content(home, extras, run));
  ROOMWISE_RETURN_IF_ERROR(write_file(options.output, evaluation::render_report(content)));
  return Answer{fmt::format("wrote {}\n", options.output.string()),
                {{"output", options.output.string()}}};
}

}  // namespace

void add_report_command(CLI::App& app, Context& context) {
  const auto [command, options] =
      add_command<ReportOptions>(app, context, "report", "Write one web page that shows a home",
                                 "roomwise report my.home -o my.html", run);
  command->add_option("HOME", options.home, "Home file")->required();
  command->add_option("-o,--output", options.output, "Page to write (.html)")->required();
  command->add_option("--truth", options.truth,
                      "True trajectory (TUM), or the recording's folder, for the error plot");
  command->add_option("--evaluation", options.evaluation,
                      "What rooms eval --json printed, for the tables");
}

}  // namespace roomwise::app
