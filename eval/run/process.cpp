#include "eval/run/process.h"

#include <malloc.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

#include "datasets/sequence/sha256.h"
#include "datasets/text/text_table.h"

extern "C" void openblas_set_num_threads(int);
extern "C" char* openblas_get_corename();

namespace slammot {

void prepare_process() {
  constexpr int kKept = 1 << 26;  // bytes
  openblas_set_num_threads(1);
  mallopt(M_MMAP_THRESHOLD, kKept);
  mallopt(M_TRIM_THRESHOLD, kKept);
  mallopt(M_TOP_PAD, kKept / 8);
}

// OpenBLAS chooses its kernels when it is loaded, and 0.3.21 takes processors with AVX-512 that it
// does not know for Haswell ones. What is loaded cannot choose again: the program starts anew.
void choose_blas_kernels(char** argv) {
  constexpr const char* kVariable = "OPENBLAS_CORETYPE";
  if (std::getenv(kVariable) || !__builtin_cpu_supports("avx512vl") ||
      std::string_view(openblas_get_corename()) != "Haswell") {
    return;
  }
  setenv(kVariable, "SkylakeX", 1);
  execv("/proc/self/exe", argv);  // returns only when it fails: then the slow kernels serve
}

// Once: another build may replace the file while this one runs.
const std::string& program_sha256() {
  static const std::string hash = [] {
    Sha256 sha;
    sha.add(read_text_file("/proc/self/exe"));
    return sha.hex();
  }();
  return hash;
}

}  // namespace slammot
