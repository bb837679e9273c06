#include "eval/python/python_estimator.h"

#include <filesystem>

#include "eval/python/child_process.h"
#include "eval/python/interpreter.h"
#include "eval/python/python_messages.h"

namespace slammot {
namespace {

using Json = nlohmann::ordered_json;

// The script is at fault: with its file and line.
struct ScriptError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One process of the script.
class Script {
 public:
  explicit Script(const PythonClass& python)
      : file_(python.file),
        process_({python_interpreter(), (python_package_folder() / "slammot/worker.py").string(),
                  python.file, python.name},
                 python_environment()) {
    greeting_ = answer(process_.read_line());
  }

  const Json& greeting() const { return greeting_; }

  // Throws ScriptError, or Diverged where the script says so.
  Json ask(const Json& message) { return answer(process_.ask(message.dump())); }

  // What `read` makes of the answer.
  template <typename Read>
  auto understood(Read read) const {
    try {
      return read();
    } catch (const Json::exception& error) {
      throw ScriptError(file_ + ": an estimate of another form: " + error.what());
    } catch (const std::invalid_argument& error) {
      throw ScriptError(file_ + ": " + error.what());
    }
  }

 private:
  Json answer(const std::string& line) const {
    Json json = Json::parse(line, nullptr, false);
    if (!json.is_object()) throw ScriptError(file_ + ": answered no JSON object");
    if (json.contains("diverged")) throw Diverged(json["diverged"].get<std::string>());
    if (json.contains("error")) throw ScriptError(json["error"].get<std::string>());
    return json;
  }

  std::string file_;
  ChildProcess process_;
  Json greeting_;
};

// A script that fails ends its run as a divergence does: what was finished is kept.
template <typename Function>
auto ends_the_run(const std::string& file, Function function) {
  try {
    return function();
  } catch (const ScriptError& error) {
    throw Diverged(error.what());
  } catch (const ChildEnded& error) {
    throw Diverged(file + ": " + error.what());
  }
}

class PythonEstimator final : public Estimator {
 public:
  PythonEstimator(const PythonClass& python, const Json& setup)
      : file_(python.file), script_(python) {
    script_.ask(setup);
  }

  FrameReport process(const Frame& frame, StageListener& stages) override {
    stages.begin("python");
    return ends_the_run(file_, [&] {
      const Json answer = script_.ask(frame_message(frame));
      return script_.understood([&] {
        camera_ = camera_from(answer.at("camera"));
        measured_ = landmarks_in(answer);
        return report_from(answer.at("report"));
      });
    });
  }

  CameraEstimate camera() const override { return camera_; }

  std::vector<LandmarkEstimate> landmarks() const override {
    return ends_the_run(file_, [&] {
      const Json answer = script_.ask({{"ask", "landmarks"}});
      return script_.understood([&] { return landmarks_in(answer); });
    });
  }

  std::vector<LandmarkEstimate> landmarks_measured(int /*index*/) const override {
    return measured_;
  }

  std::vector<CameraEstimate> smoothed(StageListener& stages) override {
    stages.begin("python");
    return ends_the_run(file_, [&] {
      const Json answer = script_.ask({{"ask", "smoothed"}});
      return script_.understood([&] {
        std::vector<CameraEstimate> cameras;
        for (const Json& camera : answer.at("cameras")) cameras.push_back(camera_from(camera));
        return cameras;
      });
    });
  }

 private:
  static std::vector<LandmarkEstimate> landmarks_in(const Json& answer) {
    std::vector<LandmarkEstimate> landmarks;
    for (const Json& json : answer.at("landmarks")) landmarks.push_back(landmark_from(json));
    return landmarks;
  }

  std::string file_;
  mutable Script script_;  // to ask is not to change
  CameraEstimate camera_;
  std::vector<LandmarkEstimate> measured_;
};

}  // namespace

std::optional<PythonClass> python_class(const std::string& estimator) {
  if (!estimator.starts_with(kPythonPrefix)) return std::nullopt;
  const std::size_t colon = estimator.rfind(':');
  if (colon < kPythonPrefix.size() || colon + 1 == estimator.size()) {
    throw std::invalid_argument("'" + estimator + "' is not of the form python:FILE.py:Class");
  }
  return PythonClass{estimator.substr(kPythonPrefix.size(), colon - kPythonPrefix.size()),
                     estimator.substr(colon + 1)};
}

PythonDescription describe(const PythonClass& python) {
  if (!std::filesystem::is_regular_file(python.file)) {
    throw std::invalid_argument(python.file + ": no such file");
  }
  if (python_package_folder().empty()) {
    throw std::invalid_argument("the Python package slammot is not beside this program");
  }
  try {
    const Script script(python);
    return {script.greeting().at("kind").get<std::string>(),
            script.greeting().at("description").get<std::string>()};
  } catch (const Json::exception&) {
    throw std::invalid_argument(python.file + ": kind and description must be texts");
  } catch (const ScriptError& error) {
    throw std::invalid_argument(error.what());
  } catch (const ChildEnded& error) {
    throw std::invalid_argument(python.file + ": " + error.what());
  }
}

std::unique_ptr<Estimator> make_python_estimator(
    const PythonClass& python, const Setup& setup, const std::string& options,
    const std::vector<std::pair<std::string, std::string>>& configuration) {
  Json settings = Json::object();
  for (const auto& [key, value] : configuration) settings[key] = value;
  Json message = setup_message(setup);
  message["configuration"] = settings;
  try {
    return std::make_unique<PythonEstimator>(
        python, Json{{"setup", message}, {"options", Json::parse(options)}});
  } catch (const ScriptError& error) {
    throw std::invalid_argument(error.what());
  } catch (const ChildEnded& error) {
    throw std::invalid_argument(python.file + ": " + error.what());
  }
}

}  // namespace slammot
