// slammot list WHAT: the rows of the tables by which things are named.
#include <fmt/format.h>

#include <memory>

#include "apps/commands.h"
#include "datasets/readers/image_reader.h"
#include "datasets/readers/reader.h"
#include "datasets/simulation/scenario.h"
#include "eval/configuration/model_names.h"
#include "eval/configuration/registry.h"
#include "eval/metrics/metric.h"

namespace slammot {
namespace {

template <typename Table>
void print_table(const Table& table) {
  for (const auto& row : table) fmt::print("{:<22} {}\n", row.name, row.description);
}

struct Listing {
  const char* what;
  void (*print)();
};

constexpr Listing kListings[] = {
    {"estimators", [] { print_table(estimator_table()); }},
    {"landmarks", [] { print_table(landmark_list()); }},
    {"points", [] { print_table(point_list()); }},
    {"motions", [] { print_table(motion_table()); }},
    {"classifiers", [] { print_table(classifier_list()); }},
    {"metrics",
     [] {
       for (const Metric& metric : metric_table()) {
         fmt::print("{:<40} {:<6} {}\n", metric.key, metric.unit, metric.caption);
       }
     }},
    {"scenarios", [] { print_table(scenario_table()); }},
    {"readers",
     [] {
       print_table(reader_table());
       fmt::print("of images, for `slammot track`:\n");
       print_table(image_reader_table());
     }},
};

}  // namespace

void add_list(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("list", "what can be named: estimators, landmarks, ...");
  auto what = std::make_shared<std::string>();
  std::vector<std::string> choices;
  for (const Listing& listing : kListings) choices.emplace_back(listing.what);
  command->add_option("WHAT", *what, "which table")->required()->check(CLI::IsMember(choices));
  command->callback([what, &exit_code] {
    for (const Listing& listing : kListings) {
      if (*what == listing.what) listing.print();
    }
    exit_code = 0;
  });
}

}  // namespace slammot
