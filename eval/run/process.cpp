#include "eval/run/process.h"

#include <malloc.h>

extern "C" void openblas_set_num_threads(int);

namespace slammot {

void prepare_process() {
  constexpr int kKept = 1 << 26;  // bytes
  openblas_set_num_threads(1);
  mallopt(M_MMAP_THRESHOLD, kKept);
  mallopt(M_TRIM_THRESHOLD, kKept);
  mallopt(M_TOP_PAD, kKept / 8);
}

}  // namespace slammot
