// How a program that runs estimators sets up its process, once, at its start.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace slammot {

// One BLAS thread, so that no result depends on the machine's number of cores and runs are what is
// parallel; and memory that is freed is kept, because a frame's matrices are those of the next.
void prepare_process();

// The OPENBLAS_CORETYPE to start with anew, none where OpenBLAS's choice fits: it takes processors
// with AVX-512 that it does not know for Haswell ones. `stated`: by the user, who decides.
std::optional<std::string> better_kernels(bool has_avx512, std::string_view chosen, bool stated);

// Before anything else in main(): starts the program anew with the BLAS kernels that fit the
// processor, where OpenBLAS does not know it. OPENBLAS_CORETYPE, when set, decides. On one machine
// the same bytes follow either way; machines with other kernels round otherwise.
void choose_blas_kernels(char** argv);

// SHA-256 of the program's file, which tells one build from another.
const std::string& program_sha256();

}  // namespace slammot
