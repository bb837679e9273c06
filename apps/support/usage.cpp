#include "apps/support/usage.h"

#include <fmt/format.h>

#include <algorithm>

#include "datasets/text/nearest_names.h"
#include "datasets/text/number.h"

namespace slammot {
namespace {

// The command that was given, or the program.
const CLI::App& command_of(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : *given.front();
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

// The command's own, and the program's that stand after it too.
std::vector<std::string> option_names(const CLI::App& app, const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* of : {&command, &app}) {
    for (const CLI::Option* option : of->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        if (std::ranges::find(names, "--" + name) == names.end()) names.push_back("--" + name);
      }
    }
  }
  return names;
}

std::string one_line(std::string text) {
  for (char& c : text) c = c == '\n' ? ' ' : c;
  return text;
}

}  // namespace

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = command_of(app);
  const std::vector<std::string> unknown = app.remaining(true);
  const bool known = &command != &app;
  const std::string name = known ? app.get_name() + " " + command.get_name() : app.get_name();
  if (!unknown.empty() && unknown.front().starts_with("-")) {
    return fmt::format("'{}' has no option {}, the nearest are {}", name, unknown.front(),
                       nearest_names(unknown.front(), option_names(app, command)));
  }
  if (!unknown.empty() && !known) {
    return fmt::format("unknown command '{}', the nearest are {}", unknown.front(),
                       nearest_names(unknown.front(), command_names(app)));
  }
  if (!unknown.empty()) {
    return fmt::format("'{}' takes no further argument '{}'", name, unknown.front());
  }
  return fmt::format("{}; see {} --help", one_line(error.what()), name);
}

CLI::Validator whole_number_from(std::uint64_t least) {
  return {[least](std::string& text) {
            const auto number = parse_number<std::uint64_t>(text);
            if (number && *number >= least) return std::string();
            return fmt::format("'{}' is not a whole number of at least {}", text, least);
          },
          ""};
}

}  // namespace slammot
