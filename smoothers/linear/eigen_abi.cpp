// Inline functions of Eigen stand in this program and in Debian's Ceres and OpenCV, and the linker
// keeps one of each. All must therefore agree on how memory is aligned, which they do as long as
// both sides are compiled for the same processor (-march) and allocate with malloc().
#include <Eigen/Core>

#if defined(__x86_64__)
static_assert(EIGEN_MAX_ALIGN_BYTES == 16, "Debian's libraries are compiled for baseline x86-64");
static_assert(EIGEN_MALLOC_ALREADY_ALIGNED, "Debian's libraries align memory as malloc() does");
#endif
