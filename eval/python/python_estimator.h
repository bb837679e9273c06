// An estimator written in Python, named `python:FILE.py:Class`. It runs in a process of its own, so
// that a fault of the script ends its run and nothing else.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estimation/estimator.h"

namespace slammot {

struct PythonClass {
  std::string file;
  std::string name;
};

inline constexpr std::string_view kPythonPrefix = "python:";

// The parts of `python:FILE.py:Class`; nothing for other names. Throws std::invalid_argument for
// one that begins so and has no class.
std::optional<PythonClass> python_class(const std::string& estimator);

struct PythonDescription {
  std::string kind;  // filter or smoother
  std::string description;
};

// Starts the script to ask the class. Throws std::invalid_argument: no such file or class, or what
// Python says of the script.
PythonDescription describe(const PythonClass& python);

// `options` is a JSON object of keyword arguments; `configuration` is for information.
std::unique_ptr<Estimator> make_python_estimator(
    const PythonClass& python, const Setup& setup, const std::string& options,
    const std::vector<std::pair<std::string, std::string>>& configuration);

}  // namespace slammot
