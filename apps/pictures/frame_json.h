// A frame's picture as data, which python/slammot/report/frame_figure.py draws (docs/formats.md).
#pragma once

#include <nlohmann/json.hpp>

#include "apps/pictures/run_pictures.h"

namespace slammot {

nlohmann::ordered_json frame_json(const RunPictures& pictures, const RunFrame& frame);

}  // namespace slammot
