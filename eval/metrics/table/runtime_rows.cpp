// Time and size.
#include "eval/metrics/table/row_forms.h"
#include "eval/metrics/table/rows.h"

namespace slammot {

MetricTable runtime_rows() {
  const auto row = [](const char* key, const char* unit, const char* name, const char* caption,
                      Pooled pooled, int decimals, auto member) {
    return Metric{.key = key,
                  .unit = unit,
                  .name = name,
                  .caption = caption,
                  .value = [=](const FinishedRun& f) { return number(member, f.metrics.runtime); },
                  .decimals = decimals,
                  .pooled = pooled,
                  .block = "runtime"};
  };
  using R = RuntimeMetrics;
  constexpr Pooled kClock = Pooled::kMedianTiming;
  Metric rate = row("frames_per_second", "1/s", "frames per second",
                    "frames over their time, smoothing after the last one included", kClock, 1,
                    &R::frames_per_second);
  rate.better = Better::kLarger;
  const Metric size =
      neither(row("state_size_median", "", "state size", "median size of the state vector",
                  Pooled::kNot, 0, &R::state_size_median));
  return {on_terminal(row("frame_median_ms", "ms", "time per frame",
                          "median time of a frame; of a batch with its share of the solution",
                          kClock, 2, &R::frame_median_ms)),
          row("frame_p95_ms", "ms", "time per frame, 95%", "95% quantile of the time of a frame",
              Pooled::kNot, 2, &R::frame_p95_ms),
          rate,
          row("smoothing_ms", "ms", "smoothing", "time of the smoothing after the last frame",
              kClock, 2, &R::smoothing_ms),
          on_terminal(size),
          neither(row("state_size_max", "", "largest state", "largest size of the state vector",
                      Pooled::kMean, 0, &R::state_size_max))};
}

}  // namespace slammot
