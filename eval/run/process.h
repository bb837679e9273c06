// How a program that runs estimators sets up its process, once, at its start.
#pragma once

namespace slammot {

// One BLAS thread, so that no result depends on the machine's number of cores and runs are what is
// parallel; and memory that is freed is kept, because a frame's matrices are those of the next.
void prepare_process();

}  // namespace slammot
