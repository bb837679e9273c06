// slammot draw RUN: its estimates, frame by frame, over the images and on a map; single frames also
// as PDF.
#include <fmt/format.h>

#include <memory>

#include "apps/commands.h"
#include "apps/pictures/draw_run.h"
#include "apps/support/progress.h"
#include "apps/support/writable.h"
#include "datasets/output/output_folder.h"
#include "datasets/readers/reader.h"
#include "eval/output/run_reader.h"

namespace slammot {
namespace {

struct DrawArguments {
  std::string run;
  std::string sequence;
  std::string output;
  std::vector<int> figures;
  bool force = false;
};

int execute(const DrawArguments& arguments) {
  const std::filesystem::path run = arguments.run;
  std::filesystem::path sequence = arguments.sequence;
  if (sequence.empty()) {
    const auto named = read_run(run).sequence;
    if (!named) throw InputError(run, 0, "run.yaml names no sequence; use --sequence");
    sequence = *named;
  }
  const std::filesystem::path output =
      arguments.output.empty() ? run / "pictures" : std::filesystem::path(arguments.output);
  require_output(output, kPicturesOutput, arguments.force || arguments.output.empty());
  require_writable_folder(output);
  if (!arguments.figures.empty()) {
    return draw_figures(run, read_sequence(sequence), output, arguments.figures);
  }
  Progress progress;
  const int count = draw_run(run, read_sequence(sequence), output,
                             [&](int done, int total) { progress.show("draw", done, total); });
  progress.clear();
  fmt::print("{} pictures\n{}\n", count, (output / "film.mp4").string());
  return 0;
}

}  // namespace

void add_draw(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DrawArguments>();
  CLI::App* command =
      app.add_subcommand("draw", "pictures and a film of a run made with --landmarks every-frame");
  command->add_option("RUN", arguments->run, "run folder")->required();
  command->add_option("--sequence", arguments->sequence, "with the images; else as run.yaml says")
      ->type_name("SEQUENCE");
  command->add_option("--output", arguments->output, "folder to write, else RUN/pictures")
      ->type_name("DIR");
  command->add_option("--pdf", arguments->figures, "instead, these frames as PDF, fit for a paper")
      ->type_name("FRAME[,FRAME..]")
      ->delimiter(',')
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--force", arguments->force, kForceHelp);
  command->callback([arguments, &exit_code] { exit_code = execute(*arguments); });
}

}  // namespace slammot
