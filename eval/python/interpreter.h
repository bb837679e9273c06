// Python outside this program: reports and estimators written in it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slammot {

// $SLAMMOT_PYTHON, else Debian's.
std::string python_interpreter();

// The folder of the package slammot: beside the program, where it is installed, or in the source
// tree. Empty if there is none.
std::filesystem::path python_package_folder();

// The environment of this process with the package on PYTHONPATH and one thread for numpy, because
// runs are what is parallel.
std::vector<std::string> python_environment();

}  // namespace slammot
