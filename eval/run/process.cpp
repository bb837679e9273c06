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

// As OpenBLAS 0.3.21 has it.
std::optional<std::string> better_kernels(bool has_avx512, std::string_view chosen, bool stated) {
  if (stated || !has_avx512 || chosen != "Haswell") return std::nullopt;
  return "SkylakeX";
}

// OpenBLAS chooses its kernels when it is loaded. What is loaded cannot choose again: the program
// starts anew.
void choose_blas_kernels(char** argv) {
  constexpr const char* kVariable = "OPENBLAS_CORETYPE";
  const auto better = better_kernels(__builtin_cpu_supports("avx512vl"), openblas_get_corename(),
                                     std::getenv(kVariable) != nullptr);
  if (!better) return;
  setenv(kVariable, better->c_str(), 1);
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
