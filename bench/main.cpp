// All benchmarks of bench_*.cpp; scripts/bench makes a table of their ratios.
#include <benchmark/benchmark.h>

#include "eval/run/process.h"

int main(int argc, char** argv) {
  slammot::choose_blas_kernels(argv);
  slammot::prepare_process();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
