// What rows of the table of metrics have in common. Numbers of one struct stand together; a
// caller's own row needs none of these helpers.
#pragma once

#include "eval/metrics/metric.h"
#include "eval/metrics/metrics.h"

namespace slammot {

inline Metric shown(Metric m, Shown where) {
  m.shown = where;
  return m;
}

inline Metric on_terminal(Metric m) { return shown(std::move(m), Shown::kTerminal); }
inline Metric on_page(Metric m) { return shown(std::move(m), Shown::kPage); }

inline Metric neither(Metric m) {
  m.better = Better::kNeither;
  return m;
}

inline Metric count(Metric m) {
  m.form = Form::kCount;
  return neither(std::move(m));
}

inline Metric near_expected(Metric m, const std::string& key) {
  m.better = Better::kNearExpected;
  m.expected = key;
  return m;
}

inline Metric pooled(Metric m, Pooled how) {
  m.pooled = how;
  return m;
}

template <typename Member, typename Struct>
double number(Member member, const Struct& s) {
  return static_cast<double>(std::invoke(member, s));
}

// A number that only metrics.json has.
inline Metric detail(const std::string& block, const std::string& leaf, const std::string& caption,
                     std::function<double(const FinishedRun&)> value, Scope scope = Scope::kRun) {
  return {.key = block + "." + leaf,
          .unit = "",
          .name = leaf,
          .caption = caption,
          .value = std::move(value),
          .scope = scope,
          .better = Better::kNeither,
          .pooled = Pooled::kNot,
          .block = block,
          .leaf = leaf};
}

inline void append(MetricTable& table, MetricTable more) {
  table.insert(table.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

}  // namespace slammot
