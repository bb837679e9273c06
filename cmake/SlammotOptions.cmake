# How our own code is compiled, and the one function that declares a library of ours.
option(SLAMMOT_BUILD_TESTS "Build the tests" ${PROJECT_IS_TOP_LEVEL})
option(SLAMMOT_BUILD_BENCHMARKS "Build the benchmarks" ${PROJECT_IS_TOP_LEVEL})
option(SLAMMOT_BUILD_FUZZERS "Build the libFuzzer programs; wants clang" OFF)
option(SLAMMOT_WARNINGS_AS_ERRORS "Treat warnings in our code as errors" ${PROJECT_IS_TOP_LEVEL})
option(SLAMMOT_UNITY "Compile several sources of a library at once: two fifths of the time" ON)
set(SLAMMOT_SANITIZE "" CACHE STRING "Sanitizers, as in -fsanitize=")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})

include(GNUInstallDirs)

# Where a program looks for the module of image codecs: beside itself, and where it is installed, in a folder of its own.
file(RELATIVE_PATH SLAMMOT_BIN_TO_LIB ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
set(CMAKE_BUILD_RPATH "$ORIGIN")
set(CMAKE_INSTALL_RPATH "$ORIGIN/${SLAMMOT_BIN_TO_LIB}/slammot")

# Debian's Python, for reports, tests and the package slammot; $SLAMMOT_PYTHON overrides it when the
# program runs. Debian looks for packages here below /usr and /usr/local.
find_program(SLAMMOT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
execute_process(
  COMMAND ${SLAMMOT_PYTHON} -c "import sys; print('lib/python%d.%d/dist-packages' % sys.version_info[:2])"
  OUTPUT_VARIABLE SLAMMOT_PYTHON_DIR OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)

function(slammot_compile_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wconversion -Wshadow)
  if(SLAMMOT_WARNINGS_AS_ERRORS)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(SLAMMOT_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${SLAMMOT_SANITIZE} -fno-omit-frame-pointer)
    # Under a sanitizer Eigen would pad what it allocates, and the Ceres of the system, which has no
    # sanitizer, would free it without the padding.
    target_compile_definitions(${target} PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
    # The sanitizers call dlopen in our place, and their libraries see a program's path only if it is
    # an old-style one.
    target_link_options(${target} PUBLIC -fsanitize=${SLAMMOT_SANITIZE} LINKER:--disable-new-dtags)
  endif()
endfunction()

# What nearly every file includes, read once for each target.
set(SLAMMOT_PRECOMPILED <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <Eigen/QR> <algorithm> <cmath>
    <filesystem> <functional> <map> <memory> <optional> <span> <stdexcept> <string> <vector>)

# The library `name` of all sources in the calling folder and below it, so that adding a file is adding
# a file: slammot_library(models LINKS lib ... PRIVATE_LINKS lib ...). Without the source EXCLUDE.
function(slammot_library name)
  cmake_parse_arguments(ARG "" "EXCLUDE" "LINKS;PRIVATE_LINKS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${ARG_EXCLUDE})
  add_library(slammot_${name} STATIC ${sources})
  add_library(slammot::${name} ALIAS slammot_${name})
  set_target_properties(slammot_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
    UNITY_BUILD ${SLAMMOT_UNITY} UNITY_BUILD_BATCH_SIZE 8)
  target_include_directories(slammot_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(slammot_${name} PUBLIC cxx_std_20)
  target_link_libraries(slammot_${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
  target_precompile_headers(slammot_${name} PRIVATE ${SLAMMOT_PRECOMPILED})
  slammot_compile_options(slammot_${name})
  set_property(GLOBAL APPEND PROPERTY SLAMMOT_LIBRARIES slammot_${name})
endfunction()
